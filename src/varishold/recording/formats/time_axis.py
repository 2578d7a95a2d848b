"""Which axis of three is time, where the numbers along them do not tell."""

from __future__ import annotations

from pathlib import Path

from varishold._counted import counted
from varishold.errors import FormatError

__all__ = ["last_axis_words", "time_axis_notes"]

# A pad that is worth asking has no shorter sides. As many frames as rows, each more than twice as long as wide, are
# hardly ever what they seem; frames four times as long as wide, and longer than the recording, may not be either.
_FEWEST_SIDE, _TWICE, _LONG = 4, 2, 4


def time_axis_notes(
    path: Path, shape: tuple[int, int, int], which: str = "", *, ordered: bool = False
) -> tuple[str, ...]:
    """Return what to ask about an array that is read as (n, rows, cols), though its last axis may be time.

    Parameters
    ----------
    path : Path
        The file, for messages.
    shape : (int, int, int)
    which : str
        What a message calls the array, with what stands behind it.
    ordered : bool
        Whether the format says the order, so that it is asked about and never refused.

    Raises
    ------
    FormatError
        If it is hardly ever what it seems.
    """
    n, rows, cols = shape
    if not ordered and n >= _FEWEST_SIDE and n == rows and cols >= _TWICE * rows:
        raise FormatError(
            f"{path}: {which}may be {counted(n, 'frame')} of {rows} x {cols} taxels, "
            f"or {counted(cols, 'frame')} of {n} x {rows} whose last "
            f"axis is time; say which by the shape of a frame, {rows}x{cols} or {n}x{rows}",
            parameter="shape",
        )
    if (n == rows != cols) or (min(n, rows) >= _FEWEST_SIDE and cols > max(n, _LONG * rows)):
        return (
            f"{which}read as {counted(n, 'frame')} of {rows} x {cols} taxels; "
            f"if these are {counted(cols, 'frame')} of {n} x {rows}, whose "
            "last axis is time, give that shape",
        )
    return ()


def last_axis_words(shape: tuple[int, ...], which: str = "") -> str:
    """Say that an array of this shape was read with time as its last axis."""
    return f"{which}read as {counted(shape[2], 'frame')} of {shape[0]} x {shape[1]}: time is the last axis"
