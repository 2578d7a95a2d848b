"""How many of something there are, as a message says it."""

from __future__ import annotations

from typing import SupportsIndex

__all__ = ["counted"]


def counted(n: SupportsIndex, one: str, several: str = "") -> str:
    """Return a number and what is counted; `several` where that is not `one` with an s or es.

    Examples
    --------
    >>> counted(1, "frame"), counted(3, "press"), counted(0, "taxel is", "taxels are")
    ('1 frame', '3 presses', '0 taxels are')
    """
    if n == 1:
        return f"{n} {one}"
    return f"{n} {several or one + ('es' if one.endswith(('s', 'x', 'ch', 'sh')) else 's')}"
