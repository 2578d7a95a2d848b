"""Compile the C kernel into the package, where a source is newer than what was compiled.

    python native/build.py

Takes the C compiler of the machine (`CC`, or cc, gcc, clang), or else the one of the package ziglang. On x86-64 three
libraries are made, for every processor, for those with AVX2 and for those with AVX-512; the package chooses when it is
loaded. All give the same bits: no
operation is fused with another or put in another order. One more is in single precision, as on a controller.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TARGET = HERE.parent / "src" / "varishold" / "kernel"
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# What is told apart here changes no value: math functions set no errno, and no comparison traps.
FLAGS = ["-std=c99", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-fno-strict-aliasing"]


def system_compiler() -> list[str] | None:
    """Return the command of the machine's own C compiler, or None."""
    chosen = os.environ.get("CC")
    if chosen:
        return shlex.split(chosen)
    return next(([found] for found in map(shutil.which, ("cc", "gcc", "clang")) if found), None)


def compiler() -> list[str]:
    """Return the command of a C compiler: the machine's own, or the one that pip can install."""
    found = system_compiler()
    if found is not None:
        return found
    if importlib.util.find_spec("ziglang") is None:
        sys.exit("the kernel needs a C compiler: install gcc or clang, or: pip install ziglang")
    return [sys.executable, "-m", "ziglang", "cc"]


def variants() -> dict[str, list[str]]:
    """Return each library's name, and the flags that make it."""
    found: dict[str, list[str]] = {"baseline": [], "single": ["-DVH_SINGLE", "-DVH_LANES=1"]}
    if platform.machine().lower() in ("x86_64", "amd64") and sys.maxsize > 2**32:
        found["avx2"] = ["-mavx2"]
        # Only what asks for them uses its widest registers: they slow a processor down.
        wide = ["-mavx512f", "-mavx512dq", "-mavx512bw", "-mavx512vl", "-mprefer-vector-width=256"]
        found["avx512"] = ["-mavx2", *wide]
    return found


def sources() -> list[Path]:
    return sorted(HERE.glob("*.c"))


def libraries() -> list[Path]:
    return [TARGET / f"varishold_{name}{SUFFIX}" for name in variants()]


def is_fresh() -> bool:
    """Tell whether every library is newer than all that it is made of."""
    made_of = max(path.stat().st_mtime_ns for path in [*sources(), *HERE.glob("*.h"), Path(__file__)])
    return all(path.is_file() and path.stat().st_mtime_ns > made_of for path in libraries())


def build() -> list[Path]:
    """Compile what is not fresh, and return the libraries."""
    if is_fresh():
        return libraries()
    command = compiler()
    if command[-2:] == ["ziglang", "cc"]:
        print("no C compiler found: the kernel is compiled by the one of the package ziglang", file=sys.stderr)
    for (name, flags), library in zip(variants().items(), libraries(), strict=True):
        # Put in place when it is complete: another process may be loading the one that stands there.
        part = library.with_name(f".{name}-{os.getpid()}{SUFFIX}")
        shared = ["-shared", "-DVH_SHARED", *([] if sys.platform == "win32" else ["-fPIC", "-fvisibility=hidden"])]
        done = subprocess.run(
            [*command, *FLAGS, *flags, *shared, *map(str, sources()), "-o", str(part), "-lm"],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            part.unlink(missing_ok=True)
            sys.exit(f"{done.stderr}\nthe kernel could not be compiled by {' '.join(command)}")
        part.replace(library)
    return libraries()


if __name__ == "__main__":
    build()
