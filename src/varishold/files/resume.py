"""One writer a file, so that a call which carries on what another began never meets that other."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from varishold.errors import InputError, reason_of
from varishold.files.locking import lock

__all__ = ["only_writer"]


@contextmanager
def only_writer(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a file for one process while it collects what will stand there.

    Raises
    ------
    InputError
        If another process holds it, or nothing can be written beside it.
    """
    whole = Path(path).resolve()
    beside = whole.with_name(f".{hashlib.sha256(os.fsencode(whole.name)).hexdigest()[:16]}.lock")
    handle = -1
    try:
        while handle < 0:
            handle = os.open(beside, os.O_CREAT | os.O_RDWR, 0o666)
            # A file system without locks lets everybody in.
            with suppress(OSError):
                try:
                    lock(handle, wait=False)
                except BlockingIOError:
                    os.close(handle)
                    raise InputError(
                        f"{path}: another process is writing this file; wait for it, or name another"
                    ) from None
            if not _stands(handle, beside):
                # Who held it has just removed it.
                os.close(handle)
                handle = -1
    except OSError as error:
        raise InputError(f"{path}: cannot write here: {reason_of(error)}") from error
    try:
        yield
    finally:
        with suppress(OSError):
            beside.unlink()
        os.close(handle)


def _stands(handle: int, beside: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(beside))
    except FileNotFoundError:
        return False
