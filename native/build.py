"""Compile the C kernel into the package, where a source is newer than what was compiled.

    python native/build.py

Takes the C compiler of the machine (`CC`, or cc, gcc, clang), or else the one of the package ziglang, which also
compiles for other platforms. On x86-64 three libraries are made: for every processor, for those with AVX2 and for those
with AVX-512; the package chooses when it is loaded. All give the same bits: no operation is fused with another or put
in another order. One more is in single precision, as on a controller.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
TARGET = HERE.parent / "src" / "varishold" / "kernel"
# Each wheel's platform, and what ziglang calls it.
PLATFORMS = {
    "manylinux_2_17_x86_64": "x86_64-linux-gnu.2.17",
    "manylinux_2_17_aarch64": "aarch64-linux-gnu.2.17",
    "musllinux_1_2_x86_64": "x86_64-linux-musl",
    "musllinux_1_2_aarch64": "aarch64-linux-musl",
    "macosx_11_0_x86_64": "x86_64-macos.11.0",
    "macosx_11_0_arm64": "aarch64-macos.11.0",
    "win_amd64": "x86_64-windows-gnu",
}
SUFFIXES = {"linux": ".so", "macos": ".dylib", "windows": ".dll"}
# What is told apart here changes no value: math functions set no errno, and no comparison traps.
FLAGS = ["-std=c99", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-fno-strict-aliasing"]


def system_compiler() -> list[str] | None:
    """Return the command of the machine's own C compiler, or None."""
    chosen = os.environ.get("CC")
    if chosen:
        return shlex.split(chosen)
    # On Windows gcc keeps AVX registers on a stack that is not aligned for them.
    names = () if sys.platform == "win32" else ("cc", "gcc", "clang")
    return next(([found] for found in map(shutil.which, names) if found), None)


def compiler(target: str = "") -> list[str]:
    """Return the command of a C compiler: the machine's own, or the one that pip can install."""
    found = None if target else system_compiler()
    if found is not None:
        return found
    if importlib.util.find_spec("ziglang") is None:
        sys.exit("the kernel needs a C compiler: install gcc or clang, or: pip install ziglang")
    if not target:
        print("no C compiler found: the kernel is compiled by the one of the package ziglang", file=sys.stderr)
    return [sys.executable, "-m", "ziglang", "cc", *(["-target", target] if target else ["-mcpu=baseline"])]


def machine(target: str) -> tuple[str, str]:
    """Return a target's processor and system; those of this machine where it has no name."""
    if target:
        processor, system = target.split("-")[:2]
        return processor, system.split(".")[0]
    wide = sys.maxsize > 2**32
    processor = platform.machine().lower().replace("amd64", "x86_64") if wide else "of 32 bits"
    return processor, {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")


def variants(processor: str) -> dict[str, list[str]]:
    """Return each library's name, and the flags that make it."""
    found: dict[str, list[str]] = {"baseline": [], "single": ["-DVH_SINGLE", "-DVH_LANES=1"]}
    if processor == "x86_64":
        found["avx2"] = ["-mavx2"]
        wide = ["-mavx512f", "-mavx512dq", "-mavx512bw", "-mavx512vl", "-mprefer-vector-width=512"]
        found["avx512"] = ["-mavx2", *wide, "-DVH_LANES=8"]
    return found


def sources() -> list[Path]:
    return sorted(HERE.glob("*.c"))


def is_fresh(libraries: list[Path]) -> bool:
    """Tell whether every library is newer than all that it is made of."""
    made_of = max(path.stat().st_mtime_ns for path in [*sources(), *HERE.glob("*.h"), Path(__file__)])
    return all(path.is_file() and path.stat().st_mtime_ns > made_of for path in libraries)


def build(target: str = "", folder: Path = TARGET) -> list[Path]:
    """Compile what is not fresh for this machine, or for a target of `PLATFORMS`, and return the libraries."""
    processor, system = machine(target)
    flags_of = variants(processor)
    libraries = [folder / f"varishold_{name}{SUFFIXES[system]}" for name in flags_of]
    if is_fresh(libraries):
        return libraries
    command = compiler(target)
    shared = ["-shared", "-DVH_SHARED", *([] if system == "windows" else ["-fPIC", "-fvisibility=hidden"])]
    folder.mkdir(parents=True, exist_ok=True)
    for flags, library in zip(flags_of.values(), libraries, strict=True):
        # Put in place when it is complete: another process may be loading the one that stands there.
        with tempfile.TemporaryDirectory(prefix=".", dir=folder) as beside:
            # Named without its folder, which a library for macOS would keep.
            done = subprocess.run(
                [*command, *FLAGS, *flags, *shared, "-s", *map(str, sources()), "-o", library.name, "-lm"],
                cwd=beside,
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode:
                sys.exit(f"{done.stderr}\nthe kernel could not be compiled by {' '.join(command)}")
            Path(beside, library.name).replace(library)
    return libraries


if __name__ == "__main__":
    build()
