"""MCAP: recordings as robots have them, and as `varishold record` writes them; nothing is lost.

A recording's pads are topics as `varishold.recording.mcap` writes them. Beside them stand the presses, each where it
begins, and the exact times where whole nanoseconds do not hold them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import varishold.recording.mcap as mapping
from varishold.errors import FormatError, InputError
from varishold.files import atomic_write, open_file
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.mcap.alignment import aligned
from varishold.recording.mcap.clock import STAMPS_NS, nanoseconds, seconds
from varishold.recording.mcap.topics import PRESSES, PadFacts
from varishold.recording.recording import Pad, Recording, Signals

if TYPE_CHECKING:
    from varishold.recording.mcap.gathering import Gathered, Series

__all__ = ["FORMAT", "is_measured", "write"]

_MAGIC = b"\x89MCAP0\r\n"
# How a file begins whose writer says that it was measured.
_MEASURED, _HEAD = re.compile(rb"\x89MCAP0\r\n\x01.{12}ros2.{4}varishold measurement", re.DOTALL), 64
# The exact times of a recording's frames, where nanoseconds do not hold them.
_TIMES = "time_s.float64"
# The record that tells the types of the columns of presses.
_COLUMNS = "varishold.press"
_TYPE = re.compile(r"[<>|=]?([biufU])(\d{1,9})")
_MOST_SIGNS = 1 << 24
# A recording without times is written as if it had so many frames a second.
_NOMINAL_NS = 10_000_000
# Topics that a remark names at most.
_TOLD = 8


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


def is_measured(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is what `varishold record` writes, to be played as it came.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    with open_file(path) as file:
        return _MEASURED.match(file.read(_HEAD)) is not None


def _read(path: Path, options: Options) -> Recording:
    held = mapping.gather(path)
    felt = {name: series for name, series in held.pads.items() if series.facts.kind == "pressure"}
    if not felt:
        raise FormatError(
            f"{path}: holds signals only ({', '.join(held.pads)}), and what touches is felt by pressure; "
            "varishold replay plays it"
        )
    try:
        shown, remarks = aligned({name: series.log_ns for name, series in held.pads.items()}, felt)
        pads = {name: _pad(path, series, shown[name], options) for name, series in felt.items()}
        time_s, timed = _times(held, felt, shown)
        units = {series.facts.unit for series in felt.values()}
        press, columns = _presses(path, held, len(next(iter(shown.values()))))
        return Recording(
            {name: pad for name, (pad, _) in pads.items()},
            time_s,
            units.pop() if len(units) == 1 else "raw",
            next(iter(felt.values())).facts.sensor,
            str(path),
            (*remarks, *timed, *(remark for _, more in pads.values() for remark in more), *_said(held)),
            press,
            columns,
            {name: _signals(series, shown[name]) for name, series in held.pads.items() if name not in felt},
        )
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _pad(path: Path, series: Series, shown: NDArray[np.int64], options: Options) -> tuple[Pad, tuple[str, ...]]:
    facts, values = series.facts, series.values
    # Taxels on no grid are one row.
    frames = values[:, None] if values.ndim == 2 else values
    if not np.array_equal(shown, np.arange(len(frames))):
        frames = frames[shown]
    taxels = options.shape[0] * options.shape[1] if options.shape else 0
    if options.shape and frames.shape[1] == 1 and frames.shape[2] == taxels:
        frames = frames.reshape(-1, *options.shape)
    elif error := shape_error(path, frames.shape[1:], options):
        raise error
    valid, remarks = _finite(facts, frames)
    try:
        pad = Pad(
            frames,
            field=facts.field,
            valid=valid,
            pitch_m=options.pitch_m or facts.pitch_m,
            positions_m=facts.positions_m,
            polarity="down" if options.polarity == "down" else facts.polarity,
        )
    except InputError as error:
        raise FormatError(f"{path}: pad {facts.name!r}: {error}") from error
    return pad, remarks


def _signals(series: Series, shown: NDArray[np.int64]) -> Signals:
    values = series.values.reshape(len(series.values), -1)[shown]
    names = series.facts.names
    return Signals(values, names if len(names) == values.shape[1] else (), series.facts.unit)


def _finite(facts: PadFacts, frames: NDArray[Any]) -> tuple[NDArray[np.bool_] | None, tuple[str, ...]]:
    """Return which taxels work, without those that were ever no number."""
    if frames.dtype.kind != "f":
        return facts.valid, ()
    finite = np.isfinite(frames).all(axis=0)
    known = np.ones(finite.shape, bool)
    for mask in (facts.field, facts.valid):
        known &= mask if mask is not None and mask.shape == finite.shape else True
    wrong = known & ~finite
    if not wrong.any():
        return facts.valid, ()
    return known & finite, (f"pad {facts.name}: {int(wrong.sum())} taxels are left out, whose readings are no numbers",)


def _times(
    held: Gathered, felt: dict[str, Series], shown: dict[str, NDArray[np.int64]]
) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
    """Return the time of each frame, and whose clock that is if it is not the sensor's."""
    leading = max(felt.values(), key=lambda series: len(series.log_ns))
    at = shown[leading.facts.name]
    if _TIMES in held.attachments:
        exact = np.frombuffer(held.attachments[_TIMES][: 8 * len(leading.log_ns)], "<f8")
        if len(exact) == len(leading.log_ns):
            return exact[at], ()
    if leading.stamp == "none":
        return None, ()
    told = (
        () if leading.stamp == "device" else ("time is that of the machine that recorded, for the sensor sends none",)
    )
    return seconds(leading.stamp_ns[at]), told


def _said(held: Gathered) -> Iterator[str]:
    """Say what else there is to know."""
    if held.early:
        yield held.early
    if held.passed:
        topics = [f"{topic} ({kind})" for topic, kind in held.passed.items()]
        yield f"passed over: {', '.join(topics[:_TOLD])}" + (", ..." if len(topics) > _TOLD else "")


def _presses(path: Path, held: Gathered, n_frames: int) -> tuple[NDArray[np.int64] | None, dict[str, NDArray[Any]]]:
    """Return the press of each frame, and the columns of presses."""
    if _COLUMNS not in held.records:
        return None, {}
    types = held.records[_COLUMNS]
    notes = [note.told for note in held.notes if note.topic == PRESSES]
    begun: list[tuple[int, int]] = []
    cells: dict[str, dict[int, Any]] = {name: {} for name in types}
    for told in notes:
        frame, number, columns = told.get("frame"), told.get("press"), told.get("columns", {})
        if not (
            isinstance(columns, dict)
            and isinstance(frame, int | None)
            and isinstance(number, int)
            # Columns of presses are told in the order of their numbers.
            and -1 <= number < (len(notes) if columns else 2**63)
        ):
            raise FormatError(f"{path}: topic {PRESSES}: must tell frame, press and columns, got {str(told)[:80]}")
        if frame is not None:
            begun.append((min(max(frame, 0), n_frames), number))
        for name in cells.keys() & columns.keys():
            cells[name][number] = columns[name]
    press = np.full(n_frames, -1)
    starts = np.maximum.accumulate([0, *(start for start, _ in begun)])[1:].tolist()
    for (_, number), start, stop in zip(begun, starts, [*starts, n_frames][1:], strict=True):
        press[start:stop] = number
    return press, {name: _column(path, name, cells[name], types[name]) for name in types}


def _column(path: Path, name: str, cells: dict[int, Any], told: str) -> NDArray[Any]:
    """Return a column of presses; where it says nothing of a press, it is empty."""
    match = _TYPE.fullmatch(told)
    if match is None:
        raise FormatError(f"{path}: press.{name} must be of text or numbers, got {told[:20]!r}")
    kind = match[1]
    as_cell: Any = {"U": str, "f": float, "b": bool}.get(kind, int)
    rest: Any = {"U": "", "f": float("nan")}.get(kind, 0)
    try:
        values = [as_cell(cells.get(k, rest)) for k in range(max(cells, default=-1) + 1)]
        # A text's type says how long its longest may be; no file may ask for memory by it.
        return np.array(values, told if kind != "U" or int(match[2]) * len(values) <= _MOST_SIGNS else np.str_)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{path}: press.{name} must be {told}: {error}") from None


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as MCAP, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
        As NPZ keeps it, and the polarity of its pads.
    path : str or path-like
        The file; its name should end in ``.mcap``.

    Raises
    ------
    InputError
        If it cannot be written there.
    """
    log_ns, device_ns, exact = _stamps(recording)
    with atomic_write(path) as file:
        writer = mapping.TopicWriter(file)
        for name, pad in recording.pads.items():
            facts = PadFacts(
                name,
                unit=recording.unit,
                sensor=recording.sensor,
                polarity=pad.polarity,
                pitch_m=pad.pitch_m,
                field=pad.field,
                valid=pad.valid,
                positions_m=pad.positions_m,
            )
            writer.describe(facts)
        for name, signals in recording.signals.items():
            writer.describe(PadFacts(name, kind="signals", unit=signals.unit, names=signals.names))
        if exact:
            writer.attach(_TIMES, exact)
        if recording.press is not None:
            writer.record(_COLUMNS, {name: column.dtype.str for name, column in recording.press_columns.items()})
        told = list(_press_notes(recording))[::-1]
        for k in range(recording.n_frames):
            while told and told[-1]["frame"] in (None, k):
                writer.tell(PRESSES, told.pop(), log_ns=log_ns[k])
            device = None if device_ns is None else device_ns[k]
            frames = {name: pad.frames[k] for name, pad in recording.pads.items()}
            frames |= {name: signals.values[k] for name, signals in recording.signals.items()}
            writer.reading(frames, log_ns=log_ns[k], device_ns=device, timed=device is not None)
        for last in told[::-1]:
            writer.tell(PRESSES, last, log_ns=log_ns[-1])
        writer.finish()


def _stamps(recording: Recording) -> tuple[list[int], list[int] | None, bytes]:
    """Return each frame's time of writing and of the sensor in nanoseconds, and the times if those do not hold them."""
    nominal = [k * _NOMINAL_NS for k in range(recording.n_frames)]
    if recording.time_s is None:
        return nominal, None, b""
    device = [nanoseconds(each) for each in recording.time_s.tolist()]
    possible = all(each in STAMPS_NS for each in device)
    exact = possible and np.array_equal(seconds(np.array(device)), recording.time_s)
    logged = device if possible and min(device) >= 0 else nominal
    return logged, device, b"" if exact else recording.time_s.astype("<f8").tobytes()


def _press_notes(recording: Recording) -> Iterator[dict[str, Any]]:
    """Yield where each press begins and ends, with what is known of it; none before those of lower numbers are told."""
    if recording.press is None:
        return
    columns, n_told = recording.press_columns, 0
    n_rows = max((len(column) for column in columns.values()), default=0)

    def row(number: int, frame: int | None) -> dict[str, Any]:
        known = {name: column[number] for name, column in columns.items() if number < len(column)}
        return {"frame": frame, "press": number, "columns": known}

    numbers = recording.press
    for frame in np.flatnonzero(np.diff(numbers, prepend=-1) != 0).tolist():
        number = int(numbers[frame])
        if number < n_told or number >= n_rows:
            yield {"frame": frame, "press": number}
            continue
        yield from (row(each, None) for each in range(n_told, number))
        yield row(number, frame)
        n_told = number + 1
    yield from (row(each, None) for each in range(n_told, n_rows))


FORMAT = Format("MCAP", (".mcap",), _recognizes, _read, write)
