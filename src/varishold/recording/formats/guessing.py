"""Other people's containers: which of their arrays are frames, where nobody has named them `pressure`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from varishold.errors import FormatError
from varishold.recording.formats.format import Options
from varishold.recording.formats.named_arrays import NAMED, SINGLE
from varishold.recording.stored import Column

__all__ = ["guessed"]

# What frames are called, and times in seconds.
_FRAMES = ("pressure", "tactile", "taxel", "touch", "frames", "skin", "force", "sensor")
_TIMES = ("time_s", "time", "times", "timestamp", "timestamps", "t")
# Arrays that a message names at most.
_TOLD = 12


def guessed(path: Path, columns: Mapping[str, Column], options: Options) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return which array stands for which name of `named_arrays`, and what there is to say about that.

    Frames are arrays of (n, rows, cols), or of (n, rows * cols) where the shape is said; those with a telling name
    where there are any, and then all that have equally many frames as the longest.

    Parameters
    ----------
    path : Path
    columns : mapping of str to Column
        Arrays of numbers by their places in the file, groups before a slash.
    options : Options

    Raises
    ------
    FormatError
        If no array can be frames, or those that can are none of them called so and differ.
    """
    taxels = options.shape[0] * options.shape[1] if options.shape else 0
    found = {
        name: column
        for name, column in columns.items()
        if (len(column.shape) == 3 and 0 not in column.shape)
        or (len(column.shape) == 2 and taxels and column.shape[1] == taxels)
    }
    telling = {name: c for name, c in found.items() if any(word in name.lower() for word in _FRAMES)}
    chosen = telling or found
    held = ", ".join(f"{n} {c.shape}" for n, c in list(columns.items())[:_TOLD]) or "no numbers"
    if not chosen:
        raise FormatError(
            f"{path}: holds no array of frames (n, rows, cols), it holds {held}; say the shape of a frame if each row "
            "is one",
            parameter="shape",
        )
    n_frames = max(column.shape[0] for column in chosen.values())
    chosen = {name: column for name, column in chosen.items() if column.shape[0] == n_frames}
    if len(chosen) > 1 and not telling:
        raise FormatError(f"{path}: holds {held}, and nobody says which are frames; call them pressure")
    keys = {SINGLE if len(chosen) == 1 else f"{NAMED}{name}": name for name in chosen}
    notes = [f"taken for frames, by shape and name: {', '.join(chosen)}"]
    times = {name.rpartition("/")[2].lower(): name for name, c in columns.items() if c.shape == (n_frames,)}
    clock = next((times[each] for each in _TIMES if each in times), None)
    if clock is not None:
        keys["time_s"] = clock
        notes.append(f"taken for times in seconds: {clock}")
    return keys, tuple(notes)
