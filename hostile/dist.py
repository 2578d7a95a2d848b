"""What would be released: a wheel and a source archive, each installed into an empty environment, shown and tested.

    python -m hostile.dist [--tag v0.1.0] [--out out/dist] [--tests PATTERN ...]

The version is pyproject's; the tag must be the same, and the changelog must have its section. Ends with status 1 where
something is wrong.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Tests that an installed package alone must pass.
TESTS = ("test_levelset_laws.py", "test_frame_laws.py", "test_kernel.py", "test_touch_laws.py")
# Bytes of the wheel, and of what `pip install` writes with it, numpy first among it; seconds from nothing to a picture.
MOST_WHEEL_BYTES, MOST_INSTALLED_BYTES, MOST_DEMO_S = 6_000_000, 110_000_000, 30.0


def faults_of_version(tag: str | None) -> list[str]:
    """Return what does not fit the version."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    found = []
    if tag is not None and tag != f"v{version}":
        found.append(f"the tag is {tag}, pyproject.toml says {version}")
    log = (ROOT / "CHANGELOG.md").read_text("utf-8")
    heading = re.search(rf"^## {re.escape(version)}(.*)$", log, re.MULTILINE)
    if heading is None:
        found.append(f"CHANGELOG.md has no section {version}")
    elif tag is not None and "unreleased" in heading[1]:
        found.append(f"CHANGELOG.md calls {version} unreleased")
    if f"version: {version}" not in (ROOT / "CITATION.cff").read_text("utf-8"):
        found.append(f"CITATION.cff is not of version {version}")
    return found


def tried(archive: Path, tests: list[str]) -> list[str]:
    """Install an archive into an empty environment, show its demo, run tests; return what went wrong."""
    found = []
    with tempfile.TemporaryDirectory(prefix="varishold-dist-") as folder:
        python = Path(folder, "venv", "bin", "python")
        run([sys.executable, "-m", "venv", str(python.parents[1])])
        before = held_bytes(python.parents[1])
        begun = time.monotonic()
        run([str(python), "-m", "pip", "install", "--quiet", str(archive)])
        page = Path(folder, "demo.html")
        run([str(python.with_name("varishold")), "demo", "--no-open", "--report", str(page)], cwd=folder)
        took = time.monotonic() - begun
        installed = held_bytes(python.parents[1]) - before
        print(f"{archive.name}: installed and shown in {took:.0f} s, {installed / 1e6:.0f} MB", flush=True)
        if installed > MOST_INSTALLED_BYTES:
            found.append(f"{archive.name}: {installed} bytes are installed")
        if archive.suffix == ".whl" and took > MOST_DEMO_S:
            found.append(f"{archive.name}: {took:.0f} s from nothing to a picture")
        if page.stat().st_size < 100_000:
            found.append(f"{archive.name}: the demo's page is empty")
        run([str(python), "-m", "pip", "install", "--quiet", f"{archive}[all]", "pytest", "hypothesis", "contourpy"])
        copied = Path(folder, "checkout")
        shutil.copytree(ROOT, copied, ignore=shutil.ignore_patterns(".*", "src", "out", "build", "__pycache__"))
        chosen = [str(path) for pattern in tests for path in sorted((copied / "tests").glob(pattern))]
        command = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", "pythonpath=.", *chosen]
        if subprocess.run(command, cwd=copied, check=False).returncode:
            found.append(f"{archive.name}: tests fail")
    return found


def held_bytes(folder: Path) -> int:
    """Return what a folder holds."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


def run(command: list[str], cwd: str | None = None) -> None:
    """Run a program that must end well."""
    subprocess.run(command, cwd=cwd, check=True)


def main() -> int:
    """Build and try; return an exit status."""
    parser = argparse.ArgumentParser(prog="python -m hostile.dist", description=__doc__)
    parser.add_argument("--tag", help="of the release; without it only the rest is checked")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "dist")
    parser.add_argument("--tests", nargs="+", default=list(TESTS), help="patterns of files in tests/")
    told = parser.parse_args()
    found = faults_of_version(told.tag or None)
    shutil.rmtree(told.out, ignore_errors=True)
    run([sys.executable, "-m", "build", "--outdir", str(told.out), str(ROOT)])
    archives = sorted(told.out.iterdir())
    wheels = [path for path in archives if path.suffix == ".whl"]
    if len(wheels) != 1 or len(archives) != 2:
        found.append(f"built {', '.join(path.name for path in archives)}")
    found += [
        f"{path.name} has {path.stat().st_size} bytes" for path in wheels if path.stat().st_size > MOST_WHEEL_BYTES
    ]
    for archive in archives:
        found += tried(archive, told.tests)
    print(*found, sep="\n", end="\n" if found else "")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
