"""A copy of the checkout in which changes are made, so that the checkout never sees one."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["copied", "with_text"]

# What was compiled takes longer to make than all tests of a room.
_COMPILED = {".so", ".dylib", ".dll"}


def copied(checkout: Path, place: Path) -> Path:
    """Bring a copy of the checkout up to date and return it, for this process alone until it ends.

    Compiled code comes and stays with the copy, beside what it was compiled from.
    """
    place.mkdir(parents=True, exist_ok=True)
    lock = os.open(place.with_suffix(".lock"), os.O_CREAT | os.O_RDWR)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise SystemExit(f"{place} is in use: another run of this room is under way") from None
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=checkout,
        capture_output=True,
        check=True,
    )
    names = {name for name in listed.stdout.decode().split("\0") if name and (checkout / name).is_file()}
    for path in sorted(place.rglob("*"), reverse=True):
        if path.is_file() and "__pycache__" not in path.parts and str(path.relative_to(place)) not in names:
            path.unlink()
    for name in sorted(names):
        old, new = checkout / name, place / name
        if not new.is_file() or new.read_bytes() != old.read_bytes():
            new.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(old, new)
    for old in checkout.joinpath("src").rglob("*"):
        new = place / old.relative_to(checkout)
        if old.suffix in _COMPILED and not (new.is_file() and new.stat().st_mtime >= old.stat().st_mtime):
            new.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(old, new)
    return place


@contextmanager
def with_text(path: Path, text: str, age: int) -> Iterator[None]:
    """Let a file hold another text for a while.

    Its time differs from that of every other version by at least a second, so that Python never takes one for another.
    """
    before, stamp = path.read_bytes(), path.stat()
    path.write_text(text, "utf-8")
    os.utime(path, (stamp.st_atime, stamp.st_mtime + 10 + age))
    try:
        yield
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
