"""Locks of whole files, where the system has them."""

from __future__ import annotations

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

__all__ = ["lock"]


def lock(handle: int, *, wait: bool) -> None:
    """Lock an open file for this process, until it is closed.

    Raises
    ------
    BlockingIOError
        If another process holds it, and this one is not to wait.
    OSError
        Where there are no locks.
    """
    if fcntl is None:
        raise OSError("this system has no locks of whole files")
    fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
