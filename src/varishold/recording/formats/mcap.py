"""MCAP: recordings as robots have them, and as `varishold record` writes them; nothing is lost.

A recording's pads are topics as `varishold.recording.mcap` writes them. Beside them stand the presses, each where it
begins, and the exact times where whole nanoseconds do not hold them.
"""

from __future__ import annotations

import os
import re
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import varishold.recording.mcap as mapping
from varishold.errors import FormatError, InputError
from varishold.files import atomic_write, open_file
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.formats.topics_said import (
    TIMES,
    exact_times,
    left_out,
    marks_of,
    said_of,
    signals_only,
    time_words,
)
from varishold.recording.mcap.alignment import aligned
from varishold.recording.mcap.clock import STAMPS_NS, nanoseconds, seconds
from varishold.recording.mcap.magic import MAGIC
from varishold.recording.mcap.press_notes import COLUMNS, column_types, press_notes, presses_of
from varishold.recording.mcap.topics import MARKS, PRESSES, PadFacts
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording
from varishold.recording.signals import Signals
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.mcap.gathering import Gathered, Series

__all__ = ["FORMAT", "is_measured", "recording_of", "write"]

# How a file begins whose writer says that it was measured.
_MEASURED, _HEAD = re.compile(rb"\x89MCAP0\r\n\x01.{12}ros2.{4}varishold measurement", re.DOTALL), 64
# A recording without times is written as if it had so many frames a second.
_NOMINAL_NS = 10_000_000


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(MAGIC)


def is_measured(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is what `varishold record` writes, to be played as it came.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    with open_file(path) as file:
        return _MEASURED.match(file.read(_HEAD)) is not None


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.mcap_stored import stored_topics

    stack = ExitStack()
    try:
        return stored_topics(path, [stack.enter_context(mapping.opened_mcap(path))], options, stack.close)
    except BaseException:
        stack.close()
        raise


def _read(path: Path, options: Options) -> Recording:
    return recording_of(mapping.gather(path), path, options)


def recording_of(held: Gathered, path: Path, options: Options) -> Recording:
    """Return the recording that topics hold.

    Raises
    ------
    FormatError
        If they hold none, or what they hold does not fit together.
    """
    felt = {name: series for name, series in held.pads.items() if series.facts.kind == "pressure"}
    if not felt:
        raise signals_only(path, held.pads)
    try:
        shown, remarks = aligned({name: series.log_ns for name, series in held.pads.items()}, felt)
        pads = {name: _pad(path, series, shown[name], options) for name, series in felt.items()}
        time_s, timed = _times(held, felt, shown)
        units = {series.facts.unit for series in felt.values()}
        press, columns = presses_of(held, len(next(iter(shown.values()))), where=str(path))
        return Recording(
            {name: pad for name, (pad, _) in pads.items()},
            time_s,
            units.pop() if len(units) == 1 else "raw",
            next(iter(felt.values())).facts.sensor,
            str(path),
            (*remarks, *timed, *(remark for _, more in pads.values() for remark in more), *said_of(held)),
            press,
            columns,
            {name: _signals(series, shown[name]) for name, series in held.pads.items() if name not in felt},
            marks_of(held, _leading(felt).log_ns[shown[_leading(felt).facts.name]]),
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
    if frames.dtype.kind != "f":
        return facts.valid, ()
    return left_out(facts, np.isfinite(frames).all(axis=0))


def _times(
    held: Gathered, felt: dict[str, Series], shown: dict[str, NDArray[np.int64]]
) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
    """Return the time of each frame, and whose clock that is if it is not the sensor's."""
    leading = _leading(felt)
    at = shown[leading.facts.name]
    exact = exact_times(held, len(leading.log_ns))
    if exact is not None:
        return exact[at], ()
    if leading.stamp == "none":
        return None, ()
    return seconds(leading.stamp_ns[at]), time_words(leading.stamp)


def _leading(felt: dict[str, Series]) -> Series:
    """Return the pad that was read most often, whose readings are the frames."""
    return max(felt.values(), key=lambda series: len(series.log_ns))


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
            writer.attach(TIMES, exact)
        told, marks = [], list(recording.marks)[::-1]
        if recording.press is not None:
            writer.record(COLUMNS, column_types(recording.press_columns))
            told = list(press_notes(recording.press, recording.press_columns))[::-1]
        for k in range(recording.n_frames):
            while marks and marks[-1].frame == k:
                writer.tell(MARKS, marks.pop()._asdict(), log_ns=log_ns[k])
            while told and told[-1]["frame"] in (None, k):
                writer.tell(PRESSES, told.pop(), log_ns=log_ns[k])
            device = None if device_ns is None else device_ns[k]
            frames = {name: pad.frames[k] for name, pad in recording.pads.items()}
            frames |= {name: signals.values[k] for name, signals in recording.signals.items()}
            writer.reading(frames, log_ns=log_ns[k], device_ns=device, timed=device is not None)
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


FORMAT = Format("MCAP", (".mcap",), _recognizes, _read, write, _open)
