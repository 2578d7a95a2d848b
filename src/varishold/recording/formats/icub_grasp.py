"""Grasps of an iCub hand as text: a line to be ignored, then seven lines a step.

Nine encoders; the largest change of each finger; twelve taxels of the thumb, the index, the middle, the ring and the
little finger, which go down under load. No time is told.
"""

from __future__ import annotations

import os
from pathlib import Path

from varishold._counted import counted
from varishold.errors import FormatError, InputError
from varishold.files import head_lines, open_file, text_chunks
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.formats.numbers import Rows, as_counts, separator_of
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording
from varishold.recording.signals import Signals

__all__ = ["FORMAT"]

_FIRST = "-10000"
_FINGERS, _TAXELS, _JOINTS = ("thumb", "index", "middle", "ring", "little"), 12, range(7, 16)
# The lines of a step: encoders, changes, taxels of each finger.
_PLACES, _WIDTHS, _STEP = ((0,), (1,), tuple(range(2, 7))), (len(_JOINTS), len(_FINGERS), _TAXELS), 7


def _recognizes(path: Path, head: bytes) -> bool:
    lines = [line for line in head_lines(head) if line.strip()]
    return len(lines) > 1 and lines[0].strip() == _FIRST and len(lines[1].split()) > 1


def _read(path: Path, options: Options) -> Recording:
    if error := shape_error(path, (1, _TAXELS), options):
        raise error
    rows = tuple(Rows(path, separator_of(())) for _ in _PLACES)
    left, first = list[tuple[int, str]](), True
    for start, chunk in text_chunks(path):
        lines = [(number, line) for number, line in enumerate(chunk, start) if line.strip()]
        if lines and first:
            del lines[0]
            first = False
        # The last step may be cut off, and is looked at when it is known to be the last.
        left += lines
        whole = max(0, len(left) - 1) // _STEP * _STEP
        _add(path, rows, left[:whole])
        left = left[whole:]
    if len(left) == _STEP and len(left[-1][1].split()) >= _TAXELS and _is_ended(path):
        _add(path, rows, left)
        left = []
    if not rows[0].n:
        raise FormatError(f"{path}: is cut off: no step of {_STEP} lines is whole")
    cut = [f"is cut off: its last step, from line {left[0][0]} on, is left out"] if left else []
    joints, changes, taxels = (kind.values() for kind in rows)
    frames = as_counts(taxels).reshape(-1, len(_FINGERS), 1, _TAXELS)
    try:
        return Recording(
            {f: Pad(frames[:, k], pitch_m=options.pitch_m, polarity="down") for k, f in enumerate(_FINGERS)},
            sensor="iCub fingertip",
            source=str(path),
            notes=("smaller is more pressure, as the sensor file icub-fingertip says; no time is told", *cut),
            signals={
                "encoders": Signals(joints, tuple(f"joint_{k}" for k in _JOINTS)),
                "maxima": Signals(as_counts(changes), _FINGERS),
            },
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _is_ended(path: Path) -> bool:
    """Tell whether the last line has its end; without it the last number may be half of one."""
    with open_file(path) as file:
        file.seek(-2, os.SEEK_END)
        end = file.read()
    return b"\n" in end or b"\r" in end


def _add(path: Path, rows: tuple[Rows, ...], lines: list[tuple[int, str]]) -> None:
    """Add whole steps."""
    for kind, places, width in zip(rows, _PLACES, _WIDTHS, strict=True):
        some = [line for k, line in enumerate(lines) if k % _STEP in places]
        for number, line in some[:1]:
            if not kind.n and (got := len(line.split())) != width:
                raise FormatError(
                    f"{path}: line {number} must have {counted(width, 'number')}, got {got}; seven lines are a step"
                )
        kind.add([line for _, line in some], [number for number, _ in some])


FORMAT = Format("iCub grasp text", (), _recognizes, _read)
