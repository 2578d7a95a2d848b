"""Tekscan ASCII (ASF, or the CSV that I-Scan and relatives export)."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError, InputError
from varishold.files import encoding_notes, head_lines, text_chunks
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.formats.numbers import Rows, as_counts, as_number, separator_of
from varishold.recording.pad import UNNAMED_PAD, Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT"]

_ENTRY = re.compile(r"\s*\"?([A-Za-z][A-Za-z_]*)\"?[\s,;:=](.*)")
_FRAME = re.compile(r"^\s*\"?Frame\s+(\d+)", re.IGNORECASE)
_METRES = {"mm": 1e-3, "millimeters": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "inch": 0.0254, "inches": 0.0254}
# A cell that holds no sensel.
_NO_SENSEL = ("B", "b")
_MOST_HEADER_LINES = 10_000


def _recognizes(path: Path, head: bytes) -> bool:
    lines = head_lines(head)
    keys = {match[1].upper() for line in lines if (match := _ENTRY.match(line))}
    return any(line.lstrip().startswith("ASCII_DATA") for line in lines) or keys >= {"ROWS", "COLS", "DATA_TYPE"}


def _read(path: Path, options: Options) -> Recording:
    header: dict[str, str] = {}
    rows: Rows | None = None
    n_rows = 0
    frame_starts: list[tuple[int, int, int]] = []
    in_data = False
    for start, chunk in text_chunks(path):
        lines: list[str] = []
        numbers: list[int] = []
        for number, line in enumerate(chunk, start):
            bare = line.strip()
            if not in_data:
                if bare.startswith("ASCII_DATA"):
                    in_data = True
                elif match := _ENTRY.match(bare):
                    header.setdefault(match[1].upper(), match[2].lstrip(" \t,;:=").rstrip(" \t,;").strip('" '))
                if number > _MOST_HEADER_LINES:
                    raise FormatError(f"{path}: no line ASCII_DATA in the first {_MOST_HEADER_LINES} lines")
            elif not bare or bare.startswith("@"):
                continue
            elif match := _FRAME.match(line):
                frame_starts.append((n_rows + len(lines), number, int(match[1][:18])))
            elif not frame_starts:
                raise FormatError(f"{path}: line {number} must be 'Frame n', got {bare[:40]!r}")
            else:
                lines.append(line)
                numbers.append(number)
        if lines:
            # Where a comma is the decimal sign a semicolon separates.
            rows = rows or Rows(path, separator_of(lines), blanks=_NO_SENSEL)
            rows.add(lines, numbers)
            n_rows = rows.n
    if not in_data:
        raise FormatError(f"{path}: is cut off: there is no line ASCII_DATA")
    if rows is None:
        raise FormatError(f"{path}: holds no frame after its line ASCII_DATA")
    return _recording(path, options, header, rows, frame_starts)


def _recording(
    path: Path, options: Options, header: dict[str, str], rows: Rows, frame_starts: list[tuple[int, int, int]]
) -> Recording:
    height, width = _count(path, header, "ROWS"), _count(path, header, "COLS")
    if error := shape_error(path, (height, width), options):
        raise error
    ends = [row for row, _, _ in frame_starts[1:]] + [rows.n]
    for (row, line, number), end in zip(frame_starts, ends, strict=True):
        if end - row != height:
            raise FormatError(
                f"{path}: frame {number} (line {line}) has {counted(end - row, 'row')}, ROWS says {height}"
            )
    if rows.width != width:
        raise FormatError(f"{path}: rows hold {counted(rows.width, 'cell')}, COLS says {width}")
    frames = rows.values().reshape(len(frame_starts), height, width)
    field = _field(path, frames, frame_starts)
    frames = as_counts(np.where(field, frames, 0))

    notes = []
    announced = [as_number(header.get(key, "")) for key in ("START_FRAME", "END_FRAME")]
    if announced[0] is not None and announced[1] is not None:
        promised = announced[1] - announced[0] + 1
        if promised != len(frame_starts):
            notes.append(
                f"{counted(len(frame_starts), 'frame is', 'frames are')} there, "
                f"START_FRAME and END_FRAME promise {promised:g}"
            )
    pitch = options.pitch_m
    if pitch is None and "ROW_SPACING" in header and "COL_SPACING" in header:
        pitch = (_spacing(path, header, "ROW_SPACING"), _spacing(path, header, "COL_SPACING"))
    time = None
    if "SECONDS_PER_FRAME" in header:
        period = as_number(header["SECONDS_PER_FRAME"].replace(",", "."))
        if period is None or not (math.isfinite(period) and period > 0):
            raise FormatError(
                f"{path}: SECONDS_PER_FRAME must be a positive number, got {header['SECONDS_PER_FRAME']!r}"
            )
        time = (np.array([number for _, _, number in frame_starts], dtype=np.float64) - frame_starts[0][2]) * period
    unit = header.get("UNITS", "raw")
    try:
        return Recording(
            {UNNAMED_PAD: Pad(frames, field=None if field.all() else field, pitch_m=pitch, polarity=options.polarity)},
            time_s=time,
            unit="raw" if unit.lower() == "raw" else unit,
            sensor=header.get("SENSOR_TYPE", ""),
            source=str(path),
            notes=(*notes, *encoding_notes(path)),
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _field(path: Path, frames: NDArray[Any], frame_starts: list[tuple[int, int, int]]) -> NDArray[np.bool_]:
    """Return where there is a sensel; the same cells must say so in every frame."""
    absent: NDArray[np.bool_] = np.isnan(frames[0])
    for (_, line, number), frame in zip(frame_starts, frames, strict=True):
        if not np.array_equal(np.isnan(frame), absent):
            row, col = (int(k) for k in np.argwhere(np.isnan(frame) != absent)[0])
            raise FormatError(
                f"{path}: frame {number} (line {line}) differs from the first in where B stands, at (row, col) = "
                f"({row}, {col}); a sensel is there in all frames or in none"
            )
    return ~absent


def _count(path: Path, header: dict[str, str], key: str) -> int:
    text = header.get(key, "")
    if not (text.isascii() and text.isdigit()) or not 0 < int(text[:9]) <= 10_000 or len(text) > 9:
        raise FormatError(f"{path}: {key} must be a whole number from 1 to 10000, got {text or 'nothing'!r}")
    return int(text)


def _spacing(path: Path, header: dict[str, str], key: str) -> float:
    """Return a spacing in metres; a number without a unit is in millimetres, as Tekscan writes it."""
    number, _, unit = header[key].replace(",", ".").strip().partition(" ")
    value = as_number(number)
    factor = _METRES.get(unit.strip(' "').lower() or "mm")
    if value is None or factor is None or not (math.isfinite(value) and value > 0):
        raise FormatError(f"{path}: {key} must be a positive length in mm, cm, m or inch, got {header[key]!r}")
    return value * factor


FORMAT = Format("Tekscan ASCII", (".asf",), _recognizes, _read)
