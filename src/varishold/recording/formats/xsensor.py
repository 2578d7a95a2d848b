"""XSENSOR PRO CSV, as other people's readers describe it: lines ``Key:,value``, then the rows of a frame."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import FormatError, InputError
from varishold.files import encoding_notes, head_lines, text_chunks
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.formats.numbers import Rows, Separator
from varishold.recording.pad import UNNAMED_PAD, Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT"]

_KEY = re.compile(r"^\s*\"?([A-Za-z][^:;,\"]*):\"?\s*(?:[,;](.*))?$")
_CLOCK = re.compile(r"^(\d{1,3}):(\d{2}):(\d{2}(?:[.,]\d+)?)$")
_LARGEST_SIDE = 10_000
_DAY_S = 86_400.0


def _recognizes(path: Path, head: bytes) -> bool:
    lines = head_lines(head)
    keys = {match[1].strip().lower() for line in lines if (match := _KEY.match(line))}
    return "rows" in keys and bool(keys & {"columns", "cols"})


def _read(path: Path, options: Options) -> Recording:
    keys: dict[str, str] = {}
    rows = Rows(path, Separator(","))
    starts: list[tuple[int, int]] = []
    clocks: list[str] = []
    mark = ","
    in_header = True
    for start, chunk in text_chunks(path):
        lines: list[str] = []
        numbers: list[int] = []
        for number, line in enumerate(chunk, start):
            if not line.strip(" ,;\t"):
                continue
            if match := _KEY.match(line):
                in_header = True
                keys[match[1].strip().lower()] = (match[2] or "").strip(' ",;\t')
                if match[1].strip().lower() == "rows":
                    mark = ";" if ";" in line else ","
                continue
            if in_header:
                starts.append((rows.n + len(lines), number))
                clocks.append(keys.pop("time", ""))
                in_header = False
            lines.append(_plain(path, number, line, mark))
            numbers.append(number)
        rows.add(lines, numbers)
    height, width = _side(path, keys, "rows"), _side(path, keys, "columns", "cols")
    if not starts:
        raise FormatError(f"{path}: holds no rows of numbers")
    if error := shape_error(path, (height, width), options):
        raise error
    if rows.width != width:
        raise FormatError(f"{path}: line {starts[0][1]} holds {counted(rows.width, 'number')}, Columns says {width}")
    ends = [row for row, _ in starts[1:]] + [rows.n]
    for frame, ((row, at), end) in enumerate(zip(starts, ends, strict=True)):
        if end - row != height:
            raise FormatError(f"{path}: frame {frame} (line {at}) has {counted(end - row, 'row')}, Rows says {height}")
    times = [_seconds(clock) for clock in clocks]
    known = [time for time in times if time is not None]
    frames = rows.values().reshape(-1, height, width)
    try:
        pad = Pad(frames, pitch_m=options.pitch_m, polarity=options.polarity)
        return Recording(
            {UNNAMED_PAD: pad},
            time_s=_from_first(np.array(known)) if known and len(known) == len(times) else None,
            unit=keys.get("units") or keys.get("pressure units") or "raw",
            sensor=keys.get("sensor", ""),
            source=str(path),
            notes=(*_clock_notes(clocks, times), *encoding_notes(path)),
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _plain(path: Path, number: int, line: str, mark: str) -> str:
    """Return a row with commas between its numbers and points in them."""
    try:
        cells = next(csv.reader([line.strip()], delimiter=mark, strict=True), [])
    except csv.Error as error:
        raise FormatError(f"{path}: line {number}: {error}; a cell must close its quotes") from error
    while cells and not cells[-1].strip():
        cells.pop()
    return ",".join(cell.strip().replace(",", ".") for cell in cells)


def _seconds(clock: str) -> float | None:
    """Return a time of day, HH:MM:SS.FFF, in seconds; None if it is none."""
    match = _CLOCK.match(clock)
    if not match:
        return None
    return int(match[1]) * 3600 + int(match[2]) * 60 + float(match[3].replace(",", "."))


def _from_first(clock_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times of day as seconds since the first, those behind a midnight too."""
    midnights = np.cumsum(np.diff(clock_s, prepend=clock_s[0]) < -_DAY_S / 2)
    since_s: NDArray[np.float64] = clock_s - clock_s[0] + _DAY_S * midnights
    return since_s


def _clock_notes(clocks: list[str], times: list[float | None]) -> list[str]:
    """Say which frame's time cannot be read, so that none is; nothing where no frame has one."""
    if None not in times or not any(clocks):
        return []
    wrong = times.index(None)
    return [f"no time is read: that of frame {wrong} must be HH:MM:SS.FFF, got {clocks[wrong][:40] or 'nothing'!r}"]


def _side(path: Path, keys: dict[str, str], *names: str) -> int:
    text = next((keys[name] for name in names if name in keys), "")
    if not (text.isascii() and text.isdigit()) or len(text) > 9 or not 0 < int(text) <= _LARGEST_SIDE:
        raise FormatError(
            f"{path}: {names[0].title()} must be a whole number from 1 to {_LARGEST_SIDE}, got {text or 'nothing'!r}"
        )
    return int(text)


FORMAT = Format("XSENSOR CSV", (), _recognizes, _read)
