"""How a grasp is loaded in time: onset lags, the loading curve, growth with force, the centre's path, unloading.

Each pad's load is the sum of its taxels above the standard plane. The clock starts when the first pad is touched, so
that what was recorded before does not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame import recording_noise
from varishold.frame.checks import MOST_READ, as_given, is_number
from varishold.recording import Pad, Recording

__all__ = [
    "Loading",
    "as_grasp",
    "as_moments",
    "course_names",
    "grasp_floor",
    "load_onsets",
    "loading_features",
    "measured_course",
]

Floats = NDArray[np.float64]
Clock = Literal["seconds", "frames"]

#: Shares of a pad's largest load at which its contact is looked at.
LOAD_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
#: A pad or a band of rows is touched from this share of the pad's largest load on; a pad that never
#: reaches this share of the strongest pad's load is not touched at all.
ONSET_SHARE = 0.02
# The pad holds above the first share of its largest load and is let go below the second.
_HELD_SHARE, _LET_GO_SHARE = 0.9, 0.5
# The last part of the rise, from the onset to the largest load, over which slow growth is measured.
_CREEP_PART = 1 / 3
_PER_MOMENT = ("load", "share_of_load", "area", "peak", "x", "y", "spread_x", "spread_y")
_PER_SHARE = ("time_to", "area_at", "moved_x_at", "moved_y_at", "spread_x_at", "spread_y_at")
_WHOLE = (
    "touched",
    "onset_lag",
    "largest_load",
    "creep",
    "unsteadiness",
    "largest_drop",
    "let_go",
    "dwell",
    "fall_time",
    "hysteresis_of_area",
)


@dataclass(frozen=True, eq=False)
class Loading:
    """What was measured of one grasp's loading.

    Parameters
    ----------
    names : tuple of str
        Name of each number, headed by the pad or the two pads that it is about.
    values : ndarray of shape (n_features,), float64
        Finite. Times in `clock`, positions in taxels from the pad's centre, areas in taxels, loads in taxels times the
        unit of the frames.
    clock : {"seconds", "frames"}
        The unit of times: frames where the recording had no time.
    remarks : tuple of str
        What a reader should know, in words.
    """

    names: tuple[str, ...]
    values: Floats
    clock: Clock
    remarks: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        return float(dict(zip(self.names, self.values, strict=True))[name])


def loading_features(
    frames: Recording | ArrayLike,
    time_s: ArrayLike | None = None,
    *,
    field: ArrayLike | None = None,
    floor: float | None = None,
    times: ArrayLike = (),
    bands: int = 4,
    pairs: bool = True,
    span: float | None = None,
) -> Loading:
    """Measure how a grasp is loaded in time.

    Parameters
    ----------
    frames : Recording or array_like of shape (n_frames, n_pads, rows, cols) or (n_frames, rows, cols)
        One grasp. Unloaded taxels must be near 0.
    time_s : array_like of shape (n_frames,), optional
        Time of each frame, never falling, at any rate and spacing. Seconds. Default: a recording's own time; where
        there is none, frames are counted, and `clock` and `remarks` say so.
    field : array_like of shape (rows, cols) or (n_pads, rows, cols), bool, optional
        False where a pad has no taxel. Only for frames; a recording has its own.
    floor : float, optional
        The standard plane delta. Default: four sigma of each pad's noise.
    times : array_like of shape (n_times,), optional
        Moments after a pad's onset at which its contact is looked at, in the unit of the clock.
    bands : int, default 4
        In how many bands of rows, and of columns, the onset travels over a pad; 0 leaves them out.
    pairs : bool, default True
        Whether to add, for every two pads, the mean and the difference of each number.
    span : float, optional
        Only so much time after the first pad's onset counts, in the unit of the clock. Default: all of it.

    Returns
    -------
    Loading
        Of each pad: when it is touched, counted from the first one (`onset_lag`); the time from there to each share
        of its largest load, and the contact's area, centre and spread then; the same at `times`; when each band of
        rows and columns is touched; relative growth of load late in the rise (`creep`); how unsteadily it rises;
        whether it was let go of, and if so how long it was held (`dwell`), how fast it fell to half (`fall_time`),
        and how much larger the area at half the load was then. A pad that is not touched has zeros.

    Raises
    ------
    InputError
        If frames, times and masks do not fit together, time runs backward or is beyond 1e100, or an option is out of
        range.

    Examples
    --------
    >>> import numpy as np
    >>> force = np.clip(np.arange(12) - np.array([[2], [4]]), 0, 5)
    >>> frames = force.T[:, :, None, None] * np.ones((4, 4))
    >>> loading = loading_features(frames, 0.1 * np.arange(12), floor=0.0)
    >>> round(loading["pad_1_onset_lag"], 6), round(loading["pad_0_time_to_0.5_of_load"], 6)
    (0.2, 0.24)
    >>> loading_features(frames, floor=0.0).remarks
    ('no time: times are counted in frames',)
    """
    recording = as_grasp(frames, time_s, field)
    moments = _checked_options(times, bands, span, floor)
    clock: Clock = "frames" if recording.time_s is None else "seconds"
    time = np.arange(recording.n_frames, dtype=np.float64) if recording.time_s is None else recording.time_s
    back = np.flatnonzero(np.diff(time) < 0)
    if back.size:
        k = int(back[0]) + 1
        raise InputError(f"time_s must not run backward, got {time[k]:g} after {time[k - 1]:g} at frame {k}")
    wild = np.flatnonzero(np.abs(time) > MOST_READ)
    if wild.size:
        raise InputError(f"time_s must be within +-{MOST_READ:g}, got {time[wild[0]]:g} at frame {int(wild[0])}")
    heights = [_height(pad, grasp_floor([pad]) if floor is None else floor) for pad in recording.pads.values()]
    onsets, loads, start = load_onsets(heights, time)
    if span is not None:
        stop = max(int(np.count_nonzero(time <= start + span)), 1)
        heights, time = [height[:stop] for height in heights], time[:stop]
        onsets, loads, start = load_onsets(heights, time)
    heads = list(recording.pads)
    measured = [
        measured_course(height, load, time, onset, start, moments, bands)
        for height, load, onset in zip(heights, loads, onsets, strict=True)
    ]
    if pairs:
        for a, b in combinations(range(len(onsets)), 2):
            heads += [f"mean_of_{heads[a]}_and_{heads[b]}", f"difference_of_{heads[a]}_and_{heads[b]}"]
            measured += [0.5 * (measured[a] + measured[b]), measured[a] - measured[b]]
    each = course_names(len(moments), bands)
    remarks: tuple[str, ...] = ("no time: times are counted in frames",) if clock == "frames" else ()
    untouched = [name for name, onset in zip(recording.pads, onsets, strict=True) if np.isnan(onset)]
    if untouched:
        remarks += (f"not touched: {', '.join(untouched)}",)
    return Loading(tuple(f"{head}_{name}" for head in heads for name in each), np.concatenate(measured), clock, remarks)


def as_grasp(
    frames: Recording | ArrayLike, time_s: ArrayLike | None = None, field: ArrayLike | None = None
) -> Recording:
    """Return a grasp as a recording whose pads, where they have no names, are pad_0, pad_1 and so on.

    Raises
    ------
    InputError
        If frames, times and masks do not fit together, or a value is not finite.
    """
    if isinstance(frames, Recording):
        if field is not None:
            raise InputError("field goes with frames; a recording's pads have their own")
        recording = (
            frames if time_s is None else Recording(frames.pads, as_given(time_s, "time_s must be one number a frame"))
        )
    else:
        try:
            array = np.asarray(frames)
        except (TypeError, ValueError) as error:
            raise InputError("frames of a grasp must be one array: some have another shape than the rest") from error
        if array.ndim == 3:
            array = array[:, None]
        if array.ndim != 4 or array.shape[1] == 0:
            raise InputError(
                f"a grasp must have shape (n_frames, n_pads, rows, cols) or (n_frames, rows, cols), got {array.shape}"
            )
        masks = _checked_field(field, array.shape[1:])
        pads = {f"pad_{k}": Pad(array[:, k], field=masks[k]) for k in range(array.shape[1])}
        recording = Recording(pads, None if time_s is None else as_given(time_s, "time_s must be one number a frame"))
    return recording


def grasp_floor(pads: Sequence[Pad]) -> float:
    """Return the standard plane of pads: four sigma of their noise, in the unit of the frames."""
    from varishold.frame.floor import FLOOR_SIGMAS

    return FLOOR_SIGMAS * float(np.median([recording_noise(pad.frames, pad.field, pad.valid) for pad in pads]))


def _checked_field(field: ArrayLike | None, shape: tuple[int, ...]) -> list[NDArray[np.bool_] | None]:
    if field is None:
        return [None] * shape[0]
    must = f"field must have shape {shape[1:]} or {shape}"
    mask = as_given(field, must)
    if mask.shape not in (shape, shape[1:]):
        raise InputError(f"{must}, got {mask.shape}")
    return list(np.broadcast_to(mask, shape))


def as_moments(times: ArrayLike) -> Floats:
    """Return moments after the onset, shape (n_times,); raise `InputError` where they are none."""
    try:
        moments = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"times must be numbers, got {times!r}") from error
    if moments.ndim != 1 or not np.all(np.isfinite(moments) & (moments >= 0)):
        raise InputError("times must be one row of finite numbers, none negative: moments after the onset")
    return moments


def _checked_options(times: ArrayLike, bands: Any, span: Any, floor: Any) -> Floats:
    moments = as_moments(times)
    if isinstance(bands, bool) or not isinstance(bands, (int, np.integer)) or bands < 0:
        raise InputError(f"bands must be a whole number, at least 0, got {bands!r}")
    for name, value, least in (("span", span, "above 0"), ("floor", floor, "not negative")):
        if value is None:
            continue
        number = is_number(value)
        if not number or not np.isfinite(value) or value < 0 or (name == "span" and value == 0):
            raise InputError(f"{name} must be a finite number, {least}, got {value!r}")
    return moments


def _height(pad: Pad, floor: float) -> Floats:
    height = np.where(pad.usable, pad.frames, 0.0).astype(np.float64) - floor
    height = np.where(pad.usable, np.maximum(height, 0.0), 0.0)
    wrong = np.argwhere(~np.isfinite(height))
    if wrong.size:
        frame, row, col = (int(k) for k in wrong[0])
        raise InputError(
            f"pressure must be finite, got {height[frame, row, col]} at (row, col) = ({row}, {col}) of frame {frame}; "
            "mark dead taxels in valid"
        )
    return height


def load_onsets(heights: list[Floats], time: Floats) -> tuple[Floats, list[Floats], float]:
    """Return when each pad is touched (NaN: never), each pad's load over time, and when the first pad is touched."""
    loads = [height.sum(axis=(1, 2)) for height in heights]
    largest = np.array([load.max() for load in loads])
    touched = (largest > 0) & (largest >= ONSET_SHARE * largest.max())
    onsets = [
        float(_crossings(load, time, np.array([ONSET_SHARE * most]))[0]) if touches else np.nan
        for load, most, touches in zip(loads, largest, touched, strict=True)
    ]
    return np.array(onsets), loads, float(np.nanmin([*onsets, time[-1]]))


def _crossings(series: Floats, time: Floats, levels: Floats) -> Floats:
    """Return when a series first reaches each level, between two frames by a straight line; the end if never.

    There is one series, shape (n_frames,), or one for each level, shape (n_levels, n_frames).
    """
    most = np.broadcast_to(np.maximum.accumulate(series, axis=-1), (len(levels), len(time)))
    k = (most < levels[:, None]).sum(axis=1)
    found = np.minimum(k, len(time) - 1)
    before = np.maximum(found - 1, 0)
    row = np.arange(len(levels))
    low = most[row, before]
    rise = most[row, found] - low
    part = np.where(rise > 0, (levels - low) / np.where(rise > 0, rise, 1.0), 1.0)
    return np.asarray(np.where(k < len(time), time[before] + part * (time[found] - time[before]), time[-1]))


def measured_course(
    height: Floats, load: Floats, time: Floats, onset: float, start: float, moments: Floats, bands: int
) -> Floats:
    """Return the numbers of one pad's course that `course_names` names, shape (n_numbers,); zeros if never touched."""
    if np.isnan(onset):
        return np.zeros(len(course_names(len(moments), bands)))
    largest = float(load.max())
    area, peak, x, y, spread_x, spread_y = _contact(height, load)
    shares = np.array(LOAD_SHARES)
    reached = _crossings(load, time, shares * largest)
    top = int(np.argmax(load))
    at_share = [np.interp(reached, time, series) for series in (area, x, y, spread_x, spread_y)]
    moved = [at_share[1] - x[top], at_share[2] - y[top]]
    at_moment = [np.interp(onset + moments, time, series) for series in (load, area, peak, x, y, spread_x, spread_y)]
    return np.concatenate(
        [
            _whole(load, area, time, onset, start),
            *([] if not bands else [_edges(height, time, ONSET_SHARE * largest, bands) - onset]),
            reached - onset,
            at_share[0],
            *moved,
            *at_share[3:],
            at_moment[0],
            at_moment[0] / largest,
            *at_moment[1:],
        ]
    )


def _edges(height: Floats, time: Floats, limit: float, bands: int) -> Floats:
    """Return when each band of rows, and then of columns, first bears so much; the end if never."""
    series = []
    for axis in (2, 1):
        lines = height.sum(axis=axis)
        series += [lines[:, band].sum(axis=1) for band in _bands(lines.shape[1], bands)]
    return _crossings(np.stack(series), time, np.full(len(series), limit))


def _contact(height: Floats, load: Floats) -> tuple[Floats, ...]:
    """Return area, peak, centre and spread of each frame; an unloaded one has its neighbours' centre and spread."""
    rows, cols = height.shape[1:]
    u, v = np.arange(cols) - 0.5 * (cols - 1), np.arange(rows) - 0.5 * (rows - 1)
    safe = np.where(load > 0, load, 1.0)
    by_col, by_row = height.sum(axis=1), height.sum(axis=2)
    x, y = by_col @ u / safe, by_row @ v / safe
    spread_x = np.sqrt(np.maximum(by_col @ (u * u) / safe - x * x, 0.0))
    spread_y = np.sqrt(np.maximum(by_row @ (v * v) / safe - y * y, 0.0))
    loaded, frames = np.flatnonzero(load > 0), np.arange(len(load))
    filled = [np.interp(frames, loaded, series[loaded]) for series in (x, y, spread_x, spread_y)]
    return (height > 0).sum(axis=(1, 2)).astype(np.float64), height.max(axis=(1, 2)), *filled


def _whole(load: Floats, area: Floats, time: Floats, onset: float, start: float) -> Floats:
    largest, top = float(load.max()), int(np.argmax(load))
    late = (time >= time[top] - _CREEP_PART * (time[top] - onset)) & (np.arange(len(time)) <= top)
    held, let_go = load[top:] >= _HELD_SHARE * largest, load[top:] < _LET_GO_SHARE * largest
    dwell = fall = hysteresis = 0.0
    if let_go.any():
        after = top + int(np.argmax(let_go))
        last_held = top + int(np.flatnonzero(held[: after - top])[-1])
        dwell = time[last_held] - _crossings(load, time, np.array([_HELD_SHARE * largest]))[0]
        part = (load[after - 1] - _LET_GO_SHARE * largest) / (load[after - 1] - load[after])
        fell = time[after - 1] + part * (time[after] - time[after - 1])
        fall = fell - time[last_held]
        rose = _crossings(load, time, np.array([_LET_GO_SHARE * largest]))
        hysteresis = area[after - 1] + part * (area[after] - area[after - 1]) - np.interp(rose, time, area)[0]
    rise = np.diff(load[: top + 1][time[: top + 1] >= onset])
    return np.array(
        [
            1.0,
            onset - start,
            largest,
            _slope(time[late], load[late]) / largest,
            np.abs(np.diff(rise)).mean() / largest if rise.size > 1 else 0.0,
            max(0.0, float(-rise.min())) / largest if rise.size else 0.0,
            float(let_go.any()),
            dwell,
            fall,
            hysteresis,
        ]
    )


def _slope(time: Floats, series: Floats) -> float:
    from_mean = time - time.mean()
    square = float(from_mean @ from_mean)
    return float(from_mean @ series) / square if square > 0 else 0.0


def _bands(n: int, bands: int) -> list[NDArray[np.intp]]:
    """Return the lines of each band; a pad of fewer lines than bands gives its lines to several."""
    at = np.minimum((np.arange(bands + 1) * n) // bands, n)
    return [np.arange(a, max(b, a + 1)) for a, b in pairwise(at.tolist())]


def course_names(n_moments: int, bands: int) -> list[str]:
    """Return the names of what `measured_course` measures."""
    names = list(_WHOLE)
    names += [f"{band}_{k}_onset_lag" for band in ("rows", "columns") for k in range(bands)]
    names += [f"{measure}_{share:g}_of_load" for measure in _PER_SHARE for share in LOAD_SHARES]
    return names + [f"{measure}_at_time_{k}" for measure in _PER_MOMENT for k in range(n_moments)]
