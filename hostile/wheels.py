"""Wheels of every platform: what is in them, and what their kernels find, run here as far as they can be.

    python -m hostile.wheels WHEEL ...

A kernel's numbers on drawn frames are compared with those of one that is compiled for this machine: run as it is, with
musl's own loader, under qemu or under wine. Needs the package ziglang. Ends with status 1 where a wheel is wrong.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from zipfile import ZipFile

from native.build import HERE, PLATFORMS, SUFFIXES, build, machine, variants

__all__ = ["Wheel", "difference", "main", "runner", "values"]

_MOST_BYTES = 6_000_000
_FRAMES = 300
# Functions of libm may differ in their last digits.
_CLOSE = 1e-12
# How a library of each processor and system begins, and what names the processor at which place.
_BEGINS = {
    ("x86_64", "linux"): (b"\x7fELF", 18, b"\x3e\0"),
    ("aarch64", "linux"): (b"\x7fELF", 18, b"\xb7\0"),
    ("x86_64", "macos"): (b"\xcf\xfa\xed\xfe", 4, b"\x07\0\0\x01"),
    ("aarch64", "macos"): (b"\xcf\xfa\xed\xfe", 4, b"\x0c\0\0\x01"),
    ("x86_64", "windows"): (b"MZ", None, b"PE\0\0\x64\x86"),
}
# What runs another platform's programs, and a file that it needs.
_RUNNERS = {
    "manylinux_2_17_x86_64": ([], "/lib64/ld-linux-x86-64.so.2"),
    "musllinux_1_2_x86_64": ([], "/lib/ld-musl-x86_64.so.1"),
    "manylinux_2_17_aarch64": (["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"], "/usr/aarch64-linux-gnu"),
    "win_amd64": (["wine64"], "/"),
}


class Wheel:
    """A wheel, unpacked into a folder."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.platform = path, path.stem.rsplit("-", 1)[1]
        self.target = PLATFORMS[self.platform]
        self.processor, self.system = machine(self.target)
        with ZipFile(path) as archive:
            archive.extractall(folder)
        self.kernel = folder / "varishold" / "kernel"

    def library(self, variant: str) -> Path:
        return self.kernel / f"varishold_{variant}{SUFFIXES[self.system]}"

    def faults(self) -> list[str]:
        """Return in words what is wrong with the files."""
        wrong = []
        if self.path.stat().st_size > _MOST_BYTES:
            wrong.append(f"has {self.path.stat().st_size} bytes")
        expected = {self.library(variant).name for variant in variants(self.processor)}
        found = {path.name for path in self.kernel.glob("varishold_*")}
        if found != expected:
            wrong.append(f"has {sorted(found)}, not {sorted(expected)}")
        for name in sorted(found & expected):
            content = (self.kernel / name).read_bytes()
            begins, at, processor = _BEGINS[self.processor, self.system]
            at = int.from_bytes(content[0x3C:0x40], "little") if at is None else at
            if not content.startswith(begins) or content[at : at + len(processor)] != processor:
                wrong.append(f"{name} is for another machine")
            wrong += [f"{name} has no function {each}" for each in bound() if each.encode() + b"\0" not in content]
        return wrong


def bound() -> list[str]:
    """Return every function that the package calls."""
    texts = [path.read_text(encoding="utf-8") for path in (HERE.parent / "src").rglob("*.py")]
    return sorted({name for text in texts for name in re.findall(r'\bbind\(\s*"(vh_\w+)"', text)})


def runner(platform: str) -> list[str] | None:
    """Return the command that runs a platform's programs here, or None."""
    command, needed = _RUNNERS.get(platform, ([], "/nowhere"))
    if not Path(needed).exists():
        return None
    if not command:
        return []
    found = shutil.which(command[0], path=os.environ["PATH"] + os.pathsep + "/usr/lib/wine")
    return [found, *command[1:]] if found else None


def values(target: str, run: list[str], library: Path, folder: Path) -> list[list[str]]:
    """Return what a kernel says of the frames, a list of words a line."""
    program = folder / f"values-{target}.exe"
    if not program.exists():
        own = ["-target", target] if target else []
        dynamic = [*(["-dynamic"] if "musl" in target else []), *([] if "windows" in target else ["-ldl"])]
        flags = ["-std=c99", "-O1", "-ffp-contract=off", f"-I{HERE}", *dynamic, "-o", str(program)]
        source = str(Path(__file__).with_name("kernel_values.c"))
        subprocess.run([sys.executable, "-m", "ziglang", "cc", *own, source, *flags], check=True, cwd=folder)
    environment = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
    command = [*run, program, library, str(_FRAMES)]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return [line.split() for line in done.stdout.splitlines()]


def difference(ours: list[list[str]], theirs: list[list[str]]) -> float:
    """Return by how much two tables differ at most, of a number beyond 1 relative to it; first lines do not count."""
    if [(row[0], len(row)) for row in ours[1:]] != [(row[0], len(row)) for row in theirs[1:]]:
        return math.inf
    worst = 0.0
    for row, other in zip(ours[1:], theirs[1:], strict=True):
        for a, b in zip(map(float, row[1:]), map(float, other[1:]), strict=True):
            if math.isnan(a) != math.isnan(b):
                return math.inf
            if not math.isnan(a):
                worst = max(worst, abs(a - b) / max(1.0, abs(a)))
    return worst


def _tried(wheel: Wheel, expected: list[list[str]], folder: Path) -> tuple[str, bool]:
    """Return in words what running it gave, and whether that is right."""
    run = runner(wheel.platform)
    if run is None:
        return "not run here", True
    rows = values(wheel.target, run, wheel.library("baseline"), folder)
    able = rows[0][1:]
    worst = difference(expected, rows)
    for variant in able:
        worst = max(worst, difference(expected, values(wheel.target, run, wheel.library(variant), folder)))
    how = Path(run[0]).name if run else "this machine"
    return f"{', '.join(['baseline', *able])} run by {how}, apart by {worst:.1g} at most", worst <= _CLOSE


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("wheel", type=Path, nargs="+")
    given = parser.parse_args()
    fine = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        own = next(path for path in build() if "baseline" in path.name)
        expected = values("", [], own, folder)
        for path in given.wheel:
            wheel = Wheel(path, folder / path.stem)
            faults = wheel.faults()
            said, right = _tried(wheel, expected, folder) if not faults else ("; ".join(faults), False)
            fine &= right
            print(f"{wheel.platform}: {path.stat().st_size / 1e6:.1f} MB, {said}", flush=True)
    sys.exit(not fine)


if __name__ == "__main__":
    main()
