"""What a recording holds, and what is wrong with it: for a person who has just been given it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.doubts import doubts_of
from varishold.frame.order_statistics import median_of
from varishold.recording.pad import Pad, far_apart, of_pad
from varishold.recording.recording import Recording
from varishold.recording.time_unit import no_seconds

__all__ = ["PadSummary", "Summary", "TimeSummary", "faults_of", "summarize"]

# An interval so many times the usual one lacks frames.
_GAP = 1.5
# Times that are looked at together.
_TIMES = 1 << 20
# Gaps that are listed; the others are counted.
_MOST_GAPS = 20


@dataclass(frozen=True)
class PadSummary:
    """One pad in short.

    Parameters
    ----------
    name : str
    shape : (int, int)
    n_taxels, n_broken : int
        In the field; of these, marked as broken or showing that they are.
    pitch_m : (float, float) or None
        Row and column spacing.
    dtype : str
        Of the values.
    low, high : float
        Lowest and highest value of a working taxel, in the recording's unit.
    peak_frame : int
        The frame of largest total.
    polarity : {"up", "down"}
    on_grid : bool
        Whether taxels stand on a grid.
    """

    name: str
    shape: tuple[int, int]
    n_taxels: int
    n_broken: int
    pitch_m: tuple[float, float] | None
    dtype: str
    low: float
    high: float
    peak_frame: int
    polarity: str
    on_grid: bool


@dataclass(frozen=True)
class TimeSummary:
    """When frames came.

    Parameters
    ----------
    begin_s, duration_s : float
        When the first came, and how long it took to the last: where time goes back, as long as it went forward.
    rate_hz : float or None
        Of the usual interval; None of a single frame, or where time stands still.
    jitter_s : float or None
        Median deviation of an interval from the usual one.
    n_back, n_repeated : int
        How often time goes back, and stands still.
    n_gaps, n_lacking : int
        Intervals of more than one and a half usual ones, and about how many frames they lack.
    gaps : tuple of (int, float)
        The longest: the frame that comes after, and how long it took, in seconds.
    """

    begin_s: float
    duration_s: float
    rate_hz: float | None
    jitter_s: float | None
    n_back: int
    n_repeated: int
    n_gaps: int
    n_lacking: int
    gaps: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Summary:
    """A recording in short.

    Parameters
    ----------
    source, unit, sensor : str
    n_frames : int
    pads : tuple of PadSummary
    time : TimeSummary or None
        None where no frame has a time.
    n_presses : int or None
        None where the recording names none.
    press_columns : tuple of str
        What is known of each press.
    notes : tuple of str
        What the reader guessed or left out.
    faults : tuple of str
        As of `faults_of`.
    """

    source: str
    unit: str
    sensor: str
    n_frames: int
    pads: tuple[PadSummary, ...]
    time: TimeSummary | None
    n_presses: int | None
    press_columns: tuple[str, ...]
    notes: tuple[str, ...]
    faults: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return asdict(self)


def summarize(recording: Recording) -> Summary:
    """Return what a recording holds.

    Parameters
    ----------
    recording : Recording

    Examples
    --------
    >>> from varishold.recording import Pad
    >>> frames = np.arange(48).reshape(4, 3, 4)
    >>> found = summarize(Recording({"pad": Pad(frames)}, time_s=np.array([0.0, 0.1, 0.2, 0.5])))
    >>> found.pads[0].shape, found.pads[0].peak_frame, round(found.time.rate_hz), found.time.gaps
    ((3, 4), 3, 10, ((3, 0.3),))
    """
    return Summary(
        source=recording.source,
        unit=recording.unit,
        sensor=recording.sensor,
        n_frames=recording.n_frames,
        pads=tuple(_pad(name, pad) for name, pad in recording.pads.items()),
        time=None if recording.time_s is None else _time(recording.time_s),
        n_presses=None if recording.press is None else len(recording.presses),
        press_columns=tuple(recording.press_columns),
        notes=(*recording.notes, *_doubted(recording)),
        faults=faults_of(recording),
    )


def faults_of(recording: Recording) -> tuple[str, ...]:
    """Return what is wrong with a recording, in words: its clock, lost frames, taxels that do not work.

    Parameters
    ----------
    recording : Recording
    """
    found = []
    if recording.time_s is not None:
        time = _time(recording.time_s)
        found += no_seconds(recording.time_s)
        if time.n_back:
            found.append(f"time goes back {_times(time.n_back)}, first at frame {_first(recording.time_s, back=True)}")
        if time.n_repeated:
            found.append(
                f"time stands still {_times(time.n_repeated)}, first at frame {_first(recording.time_s, back=False)}"
            )
        if time.n_gaps:
            frame, lasts_s = time.gaps[0]
            many = f"about {time.n_lacking} frames" if time.n_lacking > 1 else "about one frame"
            where = f"{_gaps(time.n_gaps)}, the longest of {lasts_s:.4g} s before frame {frame}"
            found.append(f"{many} lacking in {where}")
    for name, pad in recording.pads.items():
        which = of_pad(name)
        found += [f"{which}{remark}" for remark in pad.remarks]
    return tuple(found)


def _doubted(recording: Recording) -> list[str]:
    found = []
    for name, pad in recording.pads.items():
        which = of_pad(name)
        doubts = (*far_apart(pad.pitch_m, pad.positions_m), *doubts_of(pad.frames, pad.usable))
        found += [f"{which}{words}" for words in doubts]
    return found


def _times(n: int) -> str:
    return "once" if n == 1 else counted(n, "time")


def _gaps(n: int) -> str:
    return "one gap" if n == 1 else f"{n} gaps"


def _first(time_s: NDArray[np.float64], *, back: bool) -> int:
    later, before = time_s[1:], time_s[:-1]
    return int(np.argmax(later < before if back else later == before)) + 1


def _pad(name: str, pad: Pad) -> PadSummary:
    usable = pad.usable
    works = usable & ~pad.broken
    works = works if works.any() else usable
    n_taxels = pad.shape[0] * pad.shape[1] if pad.field is None else int(np.count_nonzero(pad.field))
    return PadSummary(
        name=name,
        shape=pad.shape,
        n_taxels=n_taxels,
        n_broken=n_taxels - int(np.count_nonzero(usable & ~pad.broken)),
        pitch_m=pad.pitch_m,
        dtype=str(pad.frames.dtype),
        low=float(pad.extent.low[works].min()),
        high=float(pad.extent.high[works].max()),
        peak_frame=int(np.argmax(pad.totals() if pad.polarity == "up" else -pad.totals())),
        polarity=pad.polarity,
        on_grid=pad.positions_m is None,
    )


def _time(time_s: NDArray[np.float64]) -> TimeSummary:
    def steps() -> Iterator[NDArray[np.float64]]:
        # Each piece begins with the last time of the one before.
        return (np.diff(time_s[start : start + _TIMES + 1]) for start in range(0, max(len(time_s) - 1, 1), _TIMES))

    def forward() -> Iterator[NDArray[np.float64]]:
        return (piece[piece > 0] for piece in steps())

    usual = median_of(forward)
    known = usual == usual
    jitter = median_of(lambda: (np.abs(piece - usual) for piece in forward())) if known else 0.0
    gaps = np.concatenate([k * _TIMES + np.flatnonzero(piece > _GAP * usual) for k, piece in enumerate(steps())])
    lasting = time_s[gaps + 1] - time_s[gaps]
    longest = np.argsort(-lasting, kind="stable")[:_MOST_GAPS]
    n_back = sum(int(np.count_nonzero(piece < 0)) for piece in steps())
    return TimeSummary(
        begin_s=float(time_s[0]),
        duration_s=math.fsum(chain.from_iterable(forward())) if n_back else float(time_s[-1] - time_s[0]),
        rate_hz=1 / usual if known else None,
        jitter_s=round(jitter, 12) if known else None,
        n_back=n_back,
        n_repeated=sum(int(np.count_nonzero(piece == 0)) for piece in steps()),
        n_gaps=gaps.size,
        n_lacking=int((np.round(lasting / usual) - 1).sum()) if known else 0,
        gaps=tuple((int(gaps[k]) + 1, round(float(lasting[k]), 9)) for k in longest),
    )
