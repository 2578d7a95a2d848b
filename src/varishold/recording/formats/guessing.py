"""Other people's containers: which of their arrays are frames, where nobody has named them `pressure`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from varishold._counted import counted
from varishold.errors import FormatError
from varishold.recording.formats.csv_titles import names_time
from varishold.recording.formats.format import Options
from varishold.recording.formats.named_arrays import NAMED, SINGLE
from varishold.recording.stored import Column

__all__ = ["TIMES", "guessed"]

# What frames are called.
_FRAMES = ("pressure", "tactile", "taxel", "touch", "frames", "skin", "force", "sensor")
#: What times in seconds are called.
TIMES = ("time_s", "time", "times", "timestamp", "timestamps", "t")
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
        if options.shape:
            rows, cols = options.shape
            wanted = f"(n, {rows}, {cols}) or (n, {taxels}), it holds {held}"
        else:
            wanted = f"(n, rows, cols), it holds {held}; say the shape of a frame if each row is one"
        raise FormatError(f"{path}: holds no array of frames {wanted}", parameter="shape")
    n_frames = max(_frames_of(column, options) for column in chosen.values())
    others = {name: column for name, column in chosen.items() if _frames_of(column, options) != n_frames}
    chosen = {name: column for name, column in chosen.items() if name not in others}
    if len(chosen) > 1 and not telling:
        raise FormatError(f"{path}: holds {held}, and nobody says which are frames; call them pressure")
    keys = {SINGLE if len(chosen) == 1 else f"{NAMED}{name}": name for name in chosen}
    notes = [f"taken for frames, by shape and name: {', '.join(chosen)}"]
    if others:
        told = ", ".join(f"{name} {column.shape}" for name, column in list(others.items())[:_TOLD])
        more = ", ..." if len(others) > _TOLD else ""
        notes.append(
            f"left out, for they have not {counted(n_frames, 'frame')}: {told}{more}; make a recording of each"
        )
    vectors = {name: c for name, c in columns.items() if name.rpartition("/")[2].lower() in TIMES and len(c.shape) == 1}
    times = {name.rpartition("/")[2].lower(): name for name, c in vectors.items() if c.shape == (n_frames,)}
    clock = next((times[each] for each in TIMES if each in times), None)
    if clock is not None:
        keys["time_s"] = clock
        notes.append(f"taken for times in seconds: {clock}")
    else:
        _refuse_last_axis(path, chosen, vectors, options)
        notes += _clocks_passed(columns, n_frames)
    return keys, tuple(notes)


def _frames_of(column: Column, options: Options) -> int:
    """Return how many frames an array has, which count its last axis where the shape tells so."""
    shape = column.shape
    return shape[2] if len(shape) == 3 and shape[:2] == options.shape != shape[1:] else shape[0]


def _refuse_last_axis(
    path: Path, chosen: Mapping[str, Column], vectors: Mapping[str, Column], options: Options
) -> None:
    """Refuse frames beside a time that has an entry for each of their last axis, and none for each of their first."""
    name, column = next(iter(chosen.items()))
    tail = column.shape[2:]
    last = next((each for each, c in vectors.items() if c.shape == tail != (1,)), None)
    if last is not None and options.shape is None:
        n, rows, cols = column.shape
        raise FormatError(
            f"{path}: {last} has {counted(cols, 'time')}, as many as the last axis of {name} {column.shape}: "
            "say the shape of a "
            f"frame, {n}x{rows} if time is the last axis, {rows}x{cols} if it is the first",
            parameter="shape",
        )


def _clocks_passed(columns: Mapping[str, Column], n_frames: int) -> list[str]:
    """Say what is called a time of each frame, and is not read as one."""
    called = {name: name.rpartition("/")[2].lower() for name in columns}
    passed = [
        f"{name} {column.shape}"
        for name, column in columns.items()
        if called[name].startswith("t")
        and (names_time(called[name]) or called[name] in TIMES)
        and math.prod(column.shape) == n_frames
    ]
    if not passed:
        return []
    return [f"no time is read: {', '.join(passed[:_TOLD])} is no vector of seconds that is called time_s or time"]
