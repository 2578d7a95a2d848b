"""What has come to a log since one looked last."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

__all__ = ["since"]

T = TypeVar("T")


def since(log: Sequence[T], last: T | None) -> Sequence[T]:
    """Return the entries of a log after the one that was the last; all where that is no longer there.

    Examples
    --------
    >>> log = ["opening", "open", "lost"]
    >>> since(log, log[1])
    ['lost']
    """
    for k in range(len(log) - 1, -1, -1):
        if log[k] is last:
            return log[k + 1 :]
    return log
