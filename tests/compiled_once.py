"""A C compiler that keeps what it compiled: of many programs that share sources, each source is compiled once.

    python compiled_once.py FOLDER COMPILER ARGUMENT ...

Compiles the sources among the arguments one by one, as the compiler itself does where it is given several, and takes
from the folder what the same words made of the same source and the same headers, which lie beside it.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

__all__ = ["main", "words"]


def words(folder: Path, compiler: str) -> list[str]:
    """Return the command of a compiler that keeps in a folder what it compiled."""
    # Isolated and without the packages of the site it begins in a hundredth of a second.
    return [sys.executable, "-I", "-S", str(Path(__file__).resolve()), str(folder), compiler]


def main(folder: Path, compiler: str, arguments: list[str]) -> int:
    """Compile and link, or let the compiler do whatever else it is asked for."""
    sources = [name for name in arguments if name.endswith(".c")]
    if not sources or "-E" in arguments:
        return subprocess.call([compiler, *arguments])
    flags = arguments[:]
    only_compiled, program = "-c" in flags, None
    if "-o" in flags:
        at = flags.index("-o")
        program = flags[at + 1]
        del flags[at : at + 2]
    flags = [name for name in flags if name not in (*sources, "-c", "-lm")]
    objects = []
    for name in sources:
        kept = folder / f"{_key(compiler, flags, Path(name))}.o"
        if not kept.exists():
            # Put in place when it is complete: another process may want the same.
            beside = kept.with_suffix(f".{os.getpid()}")
            failed = subprocess.call([compiler, *flags, "-c", name, "-o", str(beside)])
            if failed:
                return failed
            beside.replace(kept)
        if only_compiled:
            Path(program or Path(name).with_suffix(".o").name).write_bytes(kept.read_bytes())
        objects.append(str(kept))
    return 0 if only_compiled else subprocess.call([compiler, *flags, *objects, "-lm", "-o", program or "a.out"])


def _key(compiler: str, flags: list[str], source: Path) -> str:
    """Return what stands for a compiler, its words, a source's text and that of all headers that it takes."""
    made_of = hashlib.sha256("\0".join((compiler, *flags, source.name)).encode())
    left, seen = [source], set()
    while left:
        path = left.pop()
        if path in seen:
            continue
        seen.add(path)
        text = path.read_bytes()
        made_of.update(b"\0%d\0" % len(text) + text)
        left += [path.parent / name.decode() for name in re.findall(rb'^#include "(.+)"', text, re.MULTILINE)]
    return made_of.hexdigest()


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2], sys.argv[3:]))
