"""What is measured of a press: numbers that mean the same on another day.

Shapes of sections at shares of the press's own peak, pooled over the frames that hold most of the load; the course up
to the largest load, at shares of it; nothing of what comes after. Where on the pad, and how hard, only if asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.frame import recording_noise
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.levelset import find_contacts_batch
from varishold.levelset.second_moments import principal_moments
from varishold.touch.course.loading import course_names, load_onsets, measured_course
from varishold.touch.course.presses import Press

__all__ = ["MeasureSettings", "learn_settings", "measure_names", "measure_presses"]

Floats = NDArray[np.float64]

#: Shares of a frame's peak at which its sections are measured, falling.
LEVELS = np.array([0.95, 0.85, 0.75, 0.65, 0.55, 0.45, 0.35, 0.25, 0.15, 0.08])
# The level at which one number stands for the whole contact.
_WHOLE = 7
#: Shares of the largest load at which the course is looked at.
LOADS = np.array([0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0])
# Frames that hold this share of the largest load are pooled, at most so many of them.
_HELD, _MOST_HELD = 0.8, 6
# Moments of the rise at which the load is looked at, as shares of the typical one; and so many of them.
_FIRST_MOMENT, _LAST_MOMENT, _MOMENTS = 1 / 25, 1.25, 10
_BANDS = 4
_COURSE = course_names(_MOMENTS, _BANDS)
# Of the course: what comes after the largest load, and places.
_AFTERWARDS = ("touched", "let_go", "dwell", "fall_time", "hysteresis")
_PLACES = ("x_at", "y_at", "moved", "rows", "columns")
# A pad is touched where it bears this share of the whole load.
_TOUCHED = 0.02
# Noise and rise are told well enough by so many presses.
_MOST_LOOKED_AT = 100
_SHAPE = ("area", "perimeter", "spread_x", "spread_y", "covariance", "length", "breadth")


@dataclass(frozen=True, eq=False)
class MeasureSettings:
    """What measuring learned from the training presses.

    Parameters
    ----------
    shapes : mapping of str to (int, int)
        The pads by name: rows and columns.
    floor : float
        The standard plane, in the unit of the frames.
    rise : float
        The typical time from a tenth of the largest load to all of it; seconds, or frames where there was no time.
    clock : {"seconds", "frames"}
    load : float
        The typical largest load.
    position, absolute : bool
        Whether places on the pads and absolute loads are measured too.
    """

    shapes: Mapping[str, tuple[int, int]]
    floor: float
    rise: float
    clock: str
    load: float
    position: bool
    absolute: bool


@dataclass(frozen=True, eq=False)
class _Course:
    """A press cut at shares of its largest load: frames, times and loads there; frames that hold most of it."""

    frames: dict[str, Floats]
    held: dict[str, Floats]
    times: Floats
    loads: Floats
    numbers: dict[str, Floats]


def learn_settings(presses: Sequence[Press], *, position: bool, absolute: bool) -> MeasureSettings:
    """Return the settings that some presses teach."""
    some = [presses[k] for k in np.unique(np.linspace(0, len(presses) - 1, _MOST_LOOKED_AT).astype(int))]
    noise = [recording_noise(frames, press.fields[name]) for press in some for name, frames in press.pads.items()]
    floor = FLOOR_SIGMAS * float(np.median(noise))
    clock = "seconds" if all(press.time_s is not None for press in presses) else "frames"
    names = {name: shape for press in presses for name, shape in press.shapes.items()}
    plain = MeasureSettings(names, floor, 1.0, clock, 1.0, position, absolute)
    courses = [_course(press, plain) for press in some]
    rises = np.array([course.times[-1] - course.times[0] for course in courses])
    loads = np.array([course.loads[-1].sum() for course in courses])
    rise = float(np.median(rises[rises > 0])) if (rises > 0).any() else 1.0
    load = float(np.median(loads[loads > 0])) if (loads > 0).any() else 1.0
    return MeasureSettings(names, floor, rise, clock, load, position, absolute)


def measure_presses(presses: Sequence[Press], settings: MeasureSettings) -> Floats:
    """Measure presses.

    Returns
    -------
    ndarray of shape (n_presses, n_measures), float64
        In the order of `measure_names`; NaN where a press has not this pad.
    """
    courses = [_course(press, settings) for press in presses]
    loads = np.stack([course.loads for course in courses])
    times = np.stack([course.times for course in courses])
    whole = np.maximum(loads.sum(axis=2), 1e-300)
    spans = np.log((times - times[:, :1]) / settings.rise + 0.03)[:, 1:]
    columns = [spans]
    if settings.absolute:
        columns.append(np.log(whole[:, -1:] / settings.load + 1e-3))
    for p, name in enumerate(settings.shapes):
        columns.append(_measured_pad(courses, presses, name, p, loads, whole, settings))
    if len(settings.shapes) > 1:
        together = np.stack([np.mean(list(course.numbers.values()), axis=0) for course in courses])
        columns.append(_evened(together[:, _of_course(settings)], settings))
    return np.concatenate(columns, axis=1)


def measure_names(settings: MeasureSettings) -> list[str]:
    """Return the name of every number that `measure_presses` gives."""
    names = [f"time_to_{share:g}_of_load" for share in LOADS[1:]]
    if settings.absolute:
        names.append("load")
    shares = [f"{share:g}_of_peak" for share in LEVELS]
    of_load = [f"{share:g}_of_load" for share in LOADS]
    for pad in settings.shapes:
        mine = [f"{measure}_at_{share}" for measure in (*_SHAPE, "x", "y") for share in shares]
        mine += ["contacts"]
        mine += [f"{measure}_at_{share}" for measure in ("area", "moved_x", "moved_y") for share in of_load[:-1]]
        mine += [f"{measure}_at_{share}" for measure in ("peak_over_load", "share") for share in of_load]
        mine += [_COURSE[k] for k in _of_course(settings)]
        names += [f"{pad}_{one}" for one in mine]
    if len(settings.shapes) > 1:
        names += [f"mean_of_pads_{_COURSE[k]}" for k in _of_course(settings)]
    return names


def _course(press: Press, settings: MeasureSettings) -> _Course:
    heights = {name: np.maximum(frames - settings.floor, 0.0) for name, frames in press.pads.items()}
    n_frames = next(iter(heights.values())).shape[0]
    loads = np.zeros((n_frames, len(settings.shapes)))
    for p, name in enumerate(settings.shapes):
        if name in heights:
            loads[:, p] = heights[name].sum(axis=(1, 2))
    total = loads.sum(axis=1)
    top = int(np.argmax(total))
    largest = total[top]
    time = np.arange(n_frames, dtype=np.float64) if press.time_s is None else press.time_s
    most = np.maximum.accumulate(total[: top + 1])
    after = np.minimum(np.searchsorted(most, LOADS * largest), top)
    before = np.maximum(after - 1, 0)
    rise = total[after] - total[before]
    part = np.where(rise > 0, (LOADS * largest - total[before]) / np.where(rise > 0, rise, 1.0), 1.0).clip(0, 1)

    def at(series: Floats) -> Floats:
        weight = part.reshape(-1, *[1] * (series.ndim - 1))
        return np.asarray(series[before] + weight * (series[after] - series[before]))

    holding = np.flatnonzero(total >= _HELD * largest)
    held = holding[np.unique(np.linspace(0, len(holding) - 1, _MOST_HELD).round().astype(int))]
    rising = [heights[name][: top + 1] for name in heights]
    onsets, own, start = load_onsets(rising, time[: top + 1])
    moments = settings.rise * np.geomspace(_FIRST_MOMENT, _LAST_MOMENT, _MOMENTS)
    numbers = {
        name: measured_course(height, load, time[: top + 1], float(onset), start, moments, _BANDS)
        for name, height, load, onset in zip(heights, rising, own, onsets, strict=True)
    }
    return _Course(
        {name: at(height) for name, height in heights.items()},
        {name: height[held] for name, height in heights.items()},
        at(time),
        at(loads),
        numbers,
    )


def _measured_pad(
    courses: Sequence[_Course],
    presses: Sequence[Press],
    name: str,
    p: int,
    loads: Floats,
    whole: Floats,
    settings: MeasureSettings,
) -> Floats:
    """Return the numbers of one pad of all presses, shape (n_presses, n_numbers)."""
    there = [k for k, course in enumerate(courses) if name in course.frames]
    n_numbers = len(LEVELS) * (len(_SHAPE) + 2) + 1 + 3 * (len(LOADS) - 1) + 2 * len(LOADS)
    n_numbers += len(_of_course(settings))
    numbers = np.full((len(courses), n_numbers), np.nan)
    if not there:
        return numbers
    field = presses[there[0]].fields[name]
    counts = [len(courses[k].held[name]) for k in there]
    held = _sections(np.concatenate([courses[k].held[name] for k in there]), field)
    starts = np.cumsum([0, *counts[:-1]])
    pooled = np.add.reduceat(held, starts, axis=0) / np.array(counts)[:, None, None]
    course = _sections(np.concatenate([courses[k].frames[name] for k in there]), field)
    course = course.reshape(len(there), len(LOADS), *course.shape[1:])
    x, y = course[:, :, _WHOLE, 7], course[:, :, _WHOLE, 8]
    moved_x, moved_y = x[:, :-1] - x[:, -1:], y[:, :-1] - y[:, -1:]
    places = pooled[:, :, 7:9].transpose(0, 2, 1)
    if not settings.position:
        # How far the middle wanders from level to level, and while the load rises, is of the form; which way is not.
        places = np.abs(places - places[:, :, _WHOLE : _WHOLE + 1])
        moved_x, moved_y = np.abs(moved_x), np.abs(moved_y)
    peaks = np.stack([courses[k].frames[name].max(axis=(1, 2)) for k in there])
    load, all_load = loads[there][:, :, p], whole[there]
    touched = load[:, -1] >= _TOUCHED * all_load[:, -1]
    columns = [
        pooled[:, :, :7].transpose(0, 2, 1).reshape(len(there), -1),
        places.reshape(len(there), -1),
        pooled[:, :1, 9],
        course[:, :-1, _WHOLE, 0],
        moved_x,
        moved_y,
        np.log(np.where(load > 0, peaks / np.where(load > 0, load, 1.0), 1.0)),
        load / all_load,
    ]
    course_numbers = np.stack([courses[k].numbers[name] for k in there])[:, _of_course(settings)]
    columns.append(_evened(course_numbers, settings))
    numbers[there] = np.where(touched[:, None], np.concatenate(columns, axis=1), 0.0)
    return numbers


def _of_course(settings: MeasureSettings) -> list[int]:
    """Return which numbers of a pad's course are learned from."""
    if not settings.absolute:
        # In all its detail the course changes with load and noise: across days it did harm.
        return []
    left_out = (*_AFTERWARDS, *(() if settings.position else _PLACES))
    return [k for k, name in enumerate(_COURSE) if not name.startswith(left_out)]


def _evened(numbers: Floats, settings: MeasureSettings) -> Floats:
    """Return numbers of the course without units, large ones drawn together."""
    names = [_COURSE[k] for k in _of_course(settings)]
    unit = np.ones(len(names))
    for k, name in enumerate(names):
        if name.startswith("time_to") or name.endswith("onset_lag"):
            unit[k] = settings.rise
        elif name.startswith(("largest_load", "load_at", "peak_at")):
            unit[k] = settings.load
        elif name == "creep":
            unit[k] = 1.0 / settings.rise
    return np.asarray(np.sign(numbers) * np.sqrt(np.abs(numbers / unit)))


def _sections(frames: Floats, field: NDArray[np.bool_]) -> Floats:
    """Measure the sections of frames at shares of their peaks, all contacts of a frame together.

    Returns
    -------
    ndarray of shape (n_frames, n_levels, 10), float64
        Of `_SHAPE`, then x, y, and the number of contacts; 0 where nothing is touched.
    """
    n = len(frames)
    peaks = frames.max(axis=(1, 2))
    shares = frames / np.where(peaks > 0, peaks, 1.0)[:, None, None]
    mask = None if field.all() else field
    batch = find_contacts_batch(shares, LEVELS, field=mask, floor=0.999 * float(LEVELS[-1]))
    own = ~np.isnan(batch.area)
    # Below its end a contact keeps the last section that was its own.
    last = np.where(own, np.arange(len(LEVELS)), -1).max(axis=1, initial=-1)
    kept = np.minimum(np.arange(len(LEVELS)), np.maximum(last, 0)[:, None])
    rows = np.arange(len(own))[:, None]
    area, perimeter = np.nan_to_num(batch.area[rows, kept]), np.nan_to_num(batch.perimeter[rows, kept])
    middle, spread = np.nan_to_num(batch.centroid[rows, kept]), np.nan_to_num(batch.covariance[rows, kept])
    second = area[..., None, None] * (spread + middle[..., :, None] * middle[..., None, :])
    sums = np.stack(
        [
            area,
            perimeter,
            *(area * middle[..., k] for k in (0, 1)),
            *(second[..., a, b] for a, b in ((0, 0), (0, 1), (1, 1))),
        ],
        axis=-1,
    )
    total = np.zeros((n, *sums.shape[1:]))
    np.add.at(total, batch.frame, sums)
    safe = np.where(total[..., 0] > 0, total[..., 0], np.inf)
    x, y = total[..., 2] / safe, total[..., 3] / safe
    xx, xy, yy = total[..., 4] / safe - x * x, total[..., 5] / safe - x * y, total[..., 6] / safe - y * y
    length, breadth = 4 * np.sqrt(principal_moments(xx, xy, yy))
    contacts = np.repeat(np.bincount(batch.frame, minlength=n)[:, None], len(LEVELS), axis=1)
    spreads = (np.sqrt(np.maximum(xx, 0.0)), np.sqrt(np.maximum(yy, 0.0)))
    return np.stack(
        [np.sqrt(total[..., 0]), total[..., 1], *spreads, np.abs(xy), length, breadth, x, y, contacts], axis=-1
    )
