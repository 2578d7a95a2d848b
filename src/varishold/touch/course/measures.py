"""What is measured of a press: numbers that mean the same on another day.

Shapes of sections at shares of the press's own peak, pooled over the frames that hold most of the load; the course up
to the largest load, at shares of it; nothing of what comes after. Where on the pad, and how hard, only if asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.levelset import find_contacts_batch
from varishold.levelset.joined import join_sections
from varishold.touch.course.borne import filled_share, least_load
from varishold.touch.course.held import held_frames, press_floor, some_presses
from varishold.touch.course.image import image_names, image_shape, press_images
from varishold.touch.course.loading import course_names, load_onsets, measured_course
from varishold.touch.course.presses import Press

__all__ = [
    "MeasureSettings",
    "form_alone",
    "learn_settings",
    "measure_names",
    "measure_presses",
    "of_forms",
]

Floats = NDArray[np.float64]

#: Shares of a frame's peak at which its sections are measured, falling.
LEVELS = np.array([0.95, 0.85, 0.75, 0.65, 0.55, 0.45, 0.35, 0.25, 0.15, 0.08])
# The level at which one number stands for the whole contact.
_WHOLE = 7
#: Shares of the largest load at which the course is looked at.
LOADS = np.array([0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0])
# Moments of the rise at which the load is looked at, as shares of the typical one; and so many of them.
_FIRST_MOMENT, _LAST_MOMENT, _MOMENTS = 1 / 25, 1.25, 10
_BANDS = 4
_COURSE = course_names(_MOMENTS, _BANDS)
# Of the course: what comes after the largest load, and places.
_AFTERWARDS = ("touched", "let_go", "dwell", "fall_time", "hysteresis")
_PLACES = ("x_at", "y_at", "moved", "rows", "columns")
# A pad is touched where it bears this share of the whole load.
_TOUCHED = 0.02
# What was so in all training presses but this share of them was usual.
_UNUSUAL = 0.1
_SHAPE = ("area", "perimeter", "spread_x", "spread_y", "covariance", "length", "breadth")
_PLACE = ("x", "y")
# Numbers of a pad's shapes and places, and of all of a pad but its image and the detail of its course.
_N_SHAPES = len(LEVELS) * len(_SHAPE)
_N_NUMBERS = _N_SHAPES + len(LEVELS) * len(_PLACE) + 1 + 3 * (len(LOADS) - 1) + 2 * len(LOADS)


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
        Frames where any training press had no time: then nobody's times count.
    load : float
        The typical largest load.
    position, absolute : bool
        Whether places on the pads and absolute loads are measured too.
    least_load : float
        The largest load of the press that bore least; 0 where that is not known, or one bore nothing.
    filled : float
        The share of the largest load that stood on broken taxels, which a tenth of the presses exceeded.
    """

    shapes: Mapping[str, tuple[int, int]]
    floor: float
    rise: float
    clock: str
    load: float
    position: bool
    absolute: bool
    least_load: float = 0.0
    filled: float = 0.0


@dataclass(frozen=True, eq=False)
class _Course:
    """A press cut at shares of its largest load: frames, times and loads there; frames that hold most of it.

    `numbers` is the course of each pad in all its detail, zero where nothing of it is learned.
    """

    frames: dict[str, Floats]
    held: dict[str, Floats]
    times: Floats
    loads: Floats
    numbers: dict[str, Floats]


def learn_settings(presses: Sequence[Press], *, position: bool, absolute: bool) -> MeasureSettings:
    """Return the settings that some presses teach."""
    clock = "seconds" if all(press.time_s is not None for press in presses) else "frames"
    names = {name: shape for press in presses for name, shape in press.shapes.items()}
    floor = press_floor(presses)
    plain = MeasureSettings(names, floor, 1.0, clock, 1.0, position, absolute)
    courses = [_course(press, plain) for press in some_presses(presses)]
    rises = np.array([course.times[-1] - course.times[0] for course in courses])
    loads = np.array([course.loads[-1].sum() for course in courses])
    rise = float(np.median(rises[rises > 0])) if (rises > 0).any() else 1.0
    load = float(np.median(loads[loads > 0])) if (loads > 0).any() else 1.0
    filled = float(np.quantile([filled_share(press, floor) for press in presses], 1 - _UNUSUAL))
    return MeasureSettings(names, floor, rise, clock, load, position, absolute, least_load(presses, floor), filled)


def measure_presses(presses: Sequence[Press], settings: MeasureSettings) -> Floats:
    """Measure presses.

    Returns
    -------
    ndarray of shape (n_presses, n_measures), float64
        In the order of `measure_names`; NaN where a press has not this pad.

    Raises
    ------
    InputError
        If a press has no times, and those that the settings are of have.
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
        means = [np.mean(list(course.numbers.values()), axis=0) for course in courses]
        columns.append(_learned_course(means, settings))
    return np.concatenate(columns, axis=1)


def measure_names(settings: MeasureSettings) -> list[str]:
    """Return the name of every number that `measure_presses` gives."""
    names = [f"time_to_{share:g}_of_load" for share in LOADS[1:]]
    if settings.absolute:
        names.append("load")
    shares = [f"{share:g}_of_peak" for share in LEVELS]
    of_load = [f"{share:g}_of_load" for share in LOADS]
    for pad, shape in settings.shapes.items():
        mine = [f"{measure}_at_{share}" for measure in (*_SHAPE, *_PLACE) for share in shares]
        mine += ["contacts"]
        mine += [f"{measure}_at_{share}" for measure in ("area", "moved_x", "moved_y") for share in of_load[:-1]]
        mine += [f"{measure}_at_{share}" for measure in ("peak_over_load", "share") for share in of_load]
        mine += image_names(shape)
        mine += [f"course_{_COURSE[k]}" for k in _of_course(settings)]
        names += [f"{pad}_{one}" for one in mine]
    if len(settings.shapes) > 1:
        names += [f"mean_of_pads_{_COURSE[k]}" for k in _of_course(settings)]
    return names


def of_forms(settings: MeasureSettings) -> MeasureSettings:
    """Return settings of forms alone: with neither place nor load."""
    return replace(settings, position=False, absolute=False)


def form_alone(measures: Floats, settings: MeasureSettings) -> Floats:
    """Return what would have been measured by `of_forms`.

    Parameters
    ----------
    measures : ndarray of shape (n_presses, n_measures), float64
        As `measure_presses` gives them.
    settings : MeasureSettings
        With which they were measured.

    Returns
    -------
    ndarray of shape (n_presses, n_kept), float64
    """
    n_spans, n_levels, n_loads = len(LOADS) - 1, len(LEVELS), len(LOADS) - 1
    n_course = len(_of_course(settings))
    kept, start = [measures[:, :n_spans]], n_spans + int(settings.absolute)
    for shape in settings.shapes.values():
        n_numbers = _n_numbers(shape)
        numbers = measures[:, start : start + n_numbers].copy()
        start += n_numbers + n_course
        if settings.position:
            for first in (_N_SHAPES, _N_SHAPES + n_levels):
                numbers[:, first : first + n_levels] = _wandering(numbers[:, first : first + n_levels])
            moved = _N_SHAPES + len(_PLACE) * n_levels + 1 + n_loads
            numbers[:, moved : moved + 2 * n_loads] = np.abs(numbers[:, moved : moved + 2 * n_loads])
        kept.append(numbers)
    return np.concatenate(kept, axis=1)


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
    time = _clock(press, n_frames, settings)
    most = np.maximum.accumulate(total[: top + 1])
    after = np.minimum(np.searchsorted(most, LOADS * largest), top)
    before = np.maximum(after - 1, 0)
    rise = total[after] - total[before]
    part = np.where(rise > 0, (LOADS * largest - total[before]) / np.where(rise > 0, rise, 1.0), 1.0).clip(0, 1)

    def at(series: Floats) -> Floats:
        weight = part.reshape(-1, *[1] * (series.ndim - 1))
        return np.asarray(series[before] + weight * (series[after] - series[before]))

    held = held_frames(total)
    rising = {name: height[: top + 1] for name, height in heights.items()}
    return _Course(
        {name: at(height) for name, height in heights.items()},
        {name: height[held] for name, height in heights.items()},
        at(time),
        at(loads),
        _detail(rising, time[: top + 1], settings),
    )


def _clock(press: Press, n_frames: int, settings: MeasureSettings) -> Floats:
    """Return when each frame was, by the clock of the training presses."""
    if settings.clock == "frames":
        return np.arange(n_frames, dtype=np.float64)
    if press.time_s is None:
        raise InputError(
            f"{press.place}: has no time_s, and the presses that were learned have; give its times, or learn without"
        )
    return press.time_s


def _detail(rising: Mapping[str, Floats], time: Floats, settings: MeasureSettings) -> dict[str, Floats]:
    """Return the numbers of each pad's course up to the largest load, as far as any are learned."""
    if not _of_course(settings):
        return dict.fromkeys(rising, np.zeros(len(_COURSE)))
    onsets, own, start = load_onsets(list(rising.values()), time)
    moments = settings.rise * np.geomspace(_FIRST_MOMENT, _LAST_MOMENT, _MOMENTS)
    return {
        name: measured_course(height, load, time, float(onset), start, moments, _BANDS)
        for (name, height), load, onset in zip(rising.items(), own, onsets, strict=True)
    }


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
    numbers = np.full((len(courses), _n_numbers(settings.shapes[name]) + len(_of_course(settings))), np.nan)
    if not there:
        return numbers
    field = presses[there[0]].fields[name]
    held, at_loads = ([courses[k].held[name] for k in there], [courses[k].frames[name] for k in there])
    measured = _sections(np.concatenate([*held, *at_loads]), field)
    counts = np.array([len(frames) for frames in held])
    pooled = {measure: _pooled(of, counts) for measure, of in measured.items()}
    rising = {measure: of[counts.sum() :, _WHOLE].reshape(len(there), -1) for measure, of in measured.items()}
    places = [pooled[axis] for axis in _PLACE]
    moved = [rising[axis][:, :-1] - rising[axis][:, -1:] for axis in _PLACE]
    if not settings.position:
        places = [_wandering(at) for at in places]
        moved = [np.abs(of) for of in moved]
    peaks = np.stack([frames.max(axis=(1, 2)) for frames in at_loads])
    load, all_load = loads[there][:, :, p], whole[there]
    columns = [
        *(pooled[measure] for measure in _SHAPE),
        *places,
        pooled["contacts"][:, :1],
        rising["area"][:, :-1],
        *moved,
        np.log(np.where(load > 0, peaks / np.where(load > 0, load, 1.0), 1.0)),
        load / all_load,
        press_images(held),
        _learned_course([courses[k].numbers[name] for k in there], settings),
    ]
    touched = load[:, -1] >= _TOUCHED * all_load[:, -1]
    numbers[there] = np.where(touched[:, None], np.concatenate(columns, axis=1), 0.0)
    return numbers


def _n_numbers(shape: tuple[int, int]) -> int:
    """Return how many numbers a pad has but for the detail of its course."""
    return _N_NUMBERS + math.prod(image_shape(shape))


def _wandering(at: Floats) -> Floats:
    """Return how far the middle lies from level to level: that is of the form; which way, and where, is not."""
    return np.abs(at - at[:, _WHOLE, None])


def _pooled(measured: Floats, counts: NDArray[np.intp]) -> Floats:
    """Return the mean of what is measured over the first frames, so many of each press, shape (n_presses, n_levels)."""
    ends = counts.cumsum()
    return np.asarray(np.add.reduceat(measured[: ends[-1]], ends - counts, axis=0) / counts[:, None])


def _of_course(settings: MeasureSettings) -> tuple[int, ...]:
    """Return which numbers of a pad's course are learned from."""
    return _course_kept(settings.position, settings.absolute)


@cache
def _course_kept(position: bool, absolute: bool) -> tuple[int, ...]:
    if not absolute:
        # In all its detail the course changes with load and noise: across days it did harm.
        return ()
    left_out = (*_AFTERWARDS, *(() if position else _PLACES))
    return tuple(k for k, name in enumerate(_COURSE) if not name.startswith(left_out))


def _unit_of(name: str) -> int:
    """Return what a number of the course is measured in: 0 nothing, 1 time, 2 load, 3 one by time."""
    if name.startswith("time_to") or name.endswith("onset_lag"):
        return 1
    if name.startswith(("largest_load", "load_at", "peak_at")):
        return 2
    return 3 if name == "creep" else 0


_UNITS = np.array([_unit_of(name) for name in _COURSE])


def _learned_course(numbers: Sequence[Floats], settings: MeasureSettings) -> Floats:
    """Return what is learned of the pads' courses, without units, large numbers drawn together."""
    learned = np.array(_of_course(settings), np.intp)
    units = np.array([1.0, settings.rise, settings.load, 1.0 / settings.rise])
    plain = np.stack(numbers)[:, learned] / units[_UNITS[learned]]
    return np.asarray(np.sign(plain) * np.sqrt(np.abs(plain)))


def _sections(frames: Floats, field: NDArray[np.bool_]) -> dict[str, Floats]:
    """Measure the sections of frames at shares of their peaks, all contacts of a frame together.

    Returns
    -------
    dict of str to ndarray of shape (n_frames, n_levels), float64
        The measures of `_SHAPE` and `_PLACE`, and the number of contacts; 0 where nothing is touched.
    """
    peaks = frames.max(axis=(1, 2))
    shares = frames / np.where(peaks > 0, peaks, 1.0)[:, None, None]
    batch = find_contacts_batch(shares, LEVELS, field=None if field.all() else field, floor=0.999 * float(LEVELS[-1]))
    joined = join_sections(batch.frame, len(frames), batch.area, batch.perimeter, batch.centroid, batch.covariance)
    contacts = np.bincount(batch.frame, minlength=len(frames)).astype(np.float64)
    return {
        "area": np.sqrt(joined["area"]),
        "perimeter": joined["perimeter"],
        "spread_x": np.sqrt(np.maximum(joined["xx"], 0.0)),
        "spread_y": np.sqrt(np.maximum(joined["yy"], 0.0)),
        "covariance": np.abs(joined["xy"]),
        "length": joined["length"],
        "breadth": joined["breadth"],
        "x": joined["x"],
        "y": joined["y"],
        "contacts": np.repeat(contacts[:, None], len(LEVELS), axis=1),
    }
