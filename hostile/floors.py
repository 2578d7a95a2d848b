"""The oldest versions that are promised, or the newest there are: installed in an environment of their own and tested.

The floors are read from ``pyproject.toml``; what is not named there is taken as the installer finds it.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from pathlib import Path

__all__ = ["floors", "main"]

_ROOT = Path(__file__).parents[1]
# What is tried where there is little time: everything is imported, and each room does something.
_SHARE = ("tests/test_cli_touch.py", "tests/test_grasp_estimators.py", "tests/test_files_writing.py")


def floors() -> list[str]:
    """Return ``name==floor`` for everything that the project says it runs with."""
    project = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project.get("optional-dependencies", {})
    found = {}
    for requirement in [
        *project["dependencies"],
        *(each for name, extra in extras.items() if name != "dev" for each in extra),
    ]:
        match = re.fullmatch(r"([A-Za-z0-9_.-]+)>=([0-9.]+)", requirement)
        if match:
            found[match[1]] = match[2]
    return [f"{name}=={floor}" for name, floor in found.items()]


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--venv", type=Path, default=_ROOT / ".venv-floors")
    parser.add_argument("--newest", action="store_true", help="the newest versions instead of the oldest")
    parser.add_argument("--share", action="store_true", help="a handful of tests instead of all")
    given = parser.parse_args()
    subprocess.run([given.python, "-m", "venv", "--clear", given.venv], check=True)
    binary = given.venv / "bin" / "python"
    constraints = given.venv / "constraints.txt"
    constraints.write_text("" if given.newest else "\n".join(floors()), encoding="utf-8")
    install = [binary, "-m", "pip", "install", "--quiet", "--upgrade", "-c", constraints, "-e", f"{_ROOT}[dev,all]"]
    subprocess.run(install, check=True)
    tests = [*_SHARE, "-x"] if given.share else ["-n", "auto"]
    if not given.newest:
        # Old packages warn of what newer ones have taken away.
        tests += ["-W", "default"]
    sys.exit(subprocess.run([binary, "-m", "pytest", *tests], cwd=_ROOT, check=False).returncode)


if __name__ == "__main__":
    main()
