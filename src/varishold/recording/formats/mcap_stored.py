"""A recording whose readings stay in files of messages: MCAP, bags of ROS."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.recording.formats.format import Options, shape_error
from varishold.recording.formats.topics_said import exact_times, left_out, marks_of, said_of, signals_only, time_words
from varishold.recording.mcap.alignment import Alignment
from varishold.recording.mcap.clock import seconds
from varishold.recording.mcap.press_notes import presses_of
from varishold.recording.mcap.stream import StreamedSeries, TopicStream
from varishold.recording.stored import Stored, StoredPad, StoredSignals

if TYPE_CHECKING:
    from collections.abc import Iterable

    from varishold.recording.mcap.container import Container

__all__ = ["stored_topics"]


class _Shown:
    """What frames show of a pad: its values, or the times of its readings."""

    def __init__(self, stream: TopicStream, name: str, alignment: Alignment, tail: tuple[int, ...], what: int) -> None:
        self._stream, self._name, self._alignment, self._what = stream, name, alignment, what
        self.shape: tuple[int, ...] = (alignment.n_frames, *tail)
        self.dtype: np.dtype[Any] = stream.pads[name].dtype if what else np.dtype(np.float64)

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        first, last, _ = wanted.indices(self.shape[0])
        shown = self._alignment.shown(self._name, first, last)
        begin, end = int(shown[0]), int(shown[-1]) + 1
        read = self._stream.read(self._name, begin, end)[self._what]
        if (np.diff(shown) != 1).any():
            read = read[shown - begin]
        return read.reshape(-1, *self.shape[1:]) if self._what else seconds(read)


def stored_topics(path: Path, containers: Iterable[Container], options: Options, close: Callable[[], object]) -> Stored:
    """Return the recording that topics hold, their readings still in the file.

    Raises
    ------
    FormatError
        If they hold none, or what they hold does not fit together.
    """
    stream = TopicStream(str(path), containers)
    held, pads = stream.held, stream.pads
    felt = {name: series for name, series in pads.items() if series.facts.kind == "pressure"}
    if not felt:
        raise signals_only(path, pads)
    try:
        alignment = Alignment({name: series.log_ns for name, series in pads.items()}, felt)
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error
    leading, n_frames = felt[alignment.leading], alignment.n_frames
    notes = [*alignment.remarks, *time_words(leading.stamp)]
    exact = exact_times(held, len(leading.log_ns))
    time_s: Any = None
    if exact is not None:
        time_s, notes = exact[alignment.begun :], [*alignment.remarks]
    elif leading.stamp != "none":
        time_s = _Shown(stream, alignment.leading, alignment, (), 0)
    stored = {}
    for name, series in felt.items():
        stored[name], told = _pad(path, stream, name, series, alignment, options)
        notes += told
    units = {series.facts.unit for series in felt.values()}
    press, columns = presses_of(held, n_frames, where=str(path))
    signals = {
        name: StoredSignals(
            _Shown(stream, name, alignment, (int(np.prod(series.shape)),), 1),
            series.facts.names if len(series.facts.names) == np.prod(series.shape) else (),
            series.facts.unit,
        )
        for name, series in pads.items()
        if name not in felt
    }
    return Stored(
        stored,
        time_s,
        units.pop() if len(units) == 1 else "raw",
        next(iter(felt.values())).facts.sensor,
        str(path),
        (*notes, *said_of(held)),
        press,
        columns,
        signals,
        marks_of(held, leading.log_ns[alignment.begun :]),
        close,
    )


def _pad(
    path: Path, stream: TopicStream, name: str, series: StreamedSeries, alignment: Alignment, options: Options
) -> tuple[StoredPad, tuple[str, ...]]:
    facts = series.facts
    # Taxels on no grid are one row.
    rows, cols = (1, *series.shape) if len(series.shape) == 1 else series.shape
    finite = series.finite.reshape(rows, cols)
    if options.shape and rows == 1 and cols == options.shape[0] * options.shape[1]:
        rows, cols = options.shape
        finite = finite.reshape(rows, cols)
    elif error := shape_error(path, (rows, cols), options):
        raise error
    valid, remarks = left_out(facts, finite)
    frames = _Shown(stream, name, alignment, (rows, cols), 1)
    polarity = "down" if options.polarity == "down" else facts.polarity
    pitch_m = options.pitch_m or facts.pitch_m
    return StoredPad(frames, f"pad {name!r}", facts.field, valid, pitch_m, facts.positions_m, polarity), remarks
