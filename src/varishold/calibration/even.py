"""Calibration by an even pressure: a bladder, a vacuum bag, or weights on flat foam."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold.calibration.gains_behind import GAIN_READINGS, readings_of_gains
from varishold.calibration.readings import Presses, presses_of
from varishold.calibration.response_fit import fit_response
from varishold.calibration.result import Calibration, Finding
from varishold.errors import InputError
from varishold.frame.checks import as_array
from varishold.recording import Recording
from varishold.sensor import Linear, Sensor

__all__ = ["calibrate_even"]

Floats = NDArray[np.float64]

# A taxel that reads less than this share of the usual one under an even pressure is broken.
_BROKEN = 0.05
# More broken taxels than this share: the pressure did not reach them.
_MOST_BROKEN = 0.1
# Repeated presses whose maps differ by more than this were not even.
_MOST_DIFFERENCE = 0.05
# Variance between presses that is more than so many times that of noise is the presses' own.
_BEYOND_NOISE = 2.0
# Known pressures, and how far apart the highest and lowest must be, to tell a response.
_FEWEST_PRESSURES, _LEAST_RATIO = 3, 2.0
# Taxels of their own differ from those beside them; under a press that is not even they read nearly alike. From the
# first spread on that is worth a word, from the second on no sensor is so made.
_ALIKE, _SMOOTH_SPREAD, _FEWEST_PAIRS = 0.7, (0.15, 0.4), 8
# What of the gains goes smoothly over the pad, as a bowl or a slope does, is told from this share on, where it is so
# many times what a surface of as many numbers finds by chance.
_BOWL, _NOT_BY_CHANCE, _OF_A_BOWL = 0.03, 4.0, 5
# Gains that change with the load are told from this share on, where the load explains so much of how presses differ
# and the strongest press reads so many times as much as the lightest.
_WITH_LOAD, _EXPLAINED, _LIGHT_TO_STRONG = 0.01, 0.7, 1.25


def calibrate_even(
    recordings: Sequence[Recording],
    *,
    sensor: Sensor | None = None,
    pressure_pa: ArrayLike | None = None,
    pad: str | None = None,
) -> Calibration:
    """Find the gains, and with known pressures the response, from presses that load all taxels alike.

    With one pressure, or several of unknown height, the gains are each taxel's reading beside the
    median one, after the response that is known already has been undone. With three or more known
    pressures the response is fitted first: the simplest of the linear, power and logarithmic one
    that explains the readings, or a table where none does.

    Parameters
    ----------
    recordings : sequence of Recording
        Each press loads the whole pad evenly.
    sensor : Sensor, optional
        What is known already; it is kept, but for what is found.
    pressure_pa : array_like of shape (n_presses,), optional
        Pressure of each press in pascal, in the order in which they were recorded.
    pad : str, optional
        Which pad of the recordings.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If a press was not even, the rest moves, or the pressures do not fit the presses.
    """
    known = sensor or Sensor()
    given = None if pressure_pa is None else _positive_pressures(pressure_pa)
    found = presses_of(recordings, known, pad=pad, most_ended=0.0)
    usable, upright = found.usable, known.upright()
    base = dataclasses.replace(upright, gains=None, crosstalk=0.0, blur_taxels=0.0)
    _check_reached(found)
    curve = None
    findings: list[Finding] = []
    unknown: list[str] = []
    told = None if given is None else _one_a_press(given, found.n)
    if told is not None and np.unique(told).size >= _FEWEST_PRESSURES and told.max() >= _LEAST_RATIO * told.min():
        typical = np.median(found.frames[:, usable], axis=1)
        base, curve, finding = fit_response(base, told, typical, "Pa")
        findings.append(finding)
    elif isinstance(known.response, Linear):
        unknown.append(
            "the response: it needs three or more presses of known pressures, the highest at least twice the lowest "
            "(pressure_pa), or known objects; where it is no straight line, the gains hold at these pressures only"
        )
    linear = np.array([base.stress(frame[None])[0] for frame in found.frames])
    beside = linear / np.median(linear[:, usable], axis=1)[:, None, None]
    _check_even(beside, usable, found, curved=curve is not None)
    seen = _as_stress(found, linear, base)
    noise = np.maximum(seen.noise / np.median(seen.frames[:, usable], axis=1), 1e-12)
    bent, bent_words = _bent(beside, _mean(beside, noise**-2, usable), usable, found)
    # What goes with the load is no press's own.
    uneven = 0.0 if bent_words else _unevenness(beside, usable, noise)
    weight = 1.0 / (noise**2 + uneven**2)
    gains = _mean(beside, weight, usable)
    spread = _error(beside, weight, seen)
    if uneven > 0.0:
        # A few presses tell of no single taxel how much they differ, but of all together.
        spread = np.maximum(spread, gains / np.sqrt(weight.sum()))
    # What goes with the load is the same however many presses there are.
    spread = np.hypot(spread, bent)
    broken = usable & (gains < _BROKEN)
    gains = np.where(broken, 0.0, gains)
    kept = usable & ~broken
    smooth = _looks_uneven(gains, kept)
    findings.insert(
        0,
        Finding(
            "gain_spread",
            float(np.std(gains[kept])),
            _error_of_deviation(gains[kept], spread[kept]),
            f"how much the taxels' gains differ; each is known to {100 * np.median(spread[kept]):.2g} %, "
            f"{_as_far(found)}",
            share=True,
        ),
    )
    notes = [*found.notes, *smooth, *bent_words]
    if broken.any():
        notes.append(
            counted(np.count_nonzero(broken), "taxel feels nothing and is", "taxels feel nothing and are")
            + " marked broken in the gain map"
        )
    if found.n < 2:
        notes.append("one press: how well it repeats is not known")
    made = found.sensor_with(
        known,
        gains=np.where(usable, gains, 1.0),
        response=base.response,
        span=base.span,
        full_scale=base.full_scale,
        unit=base.unit,
        dead_band=base.dead_band,
    )
    after = beside / np.where(gains > 0, gains, np.nan)
    unknown.append("crosstalk, blur and the cover: an even pressure is the same with and without them")
    outcome = Calibration(
        kind="even",
        sensor=made,
        presses=found.n,
        findings=tuple(findings),
        unknown=tuple(unknown),
        notes=tuple(notes),
        before=np.where(usable, beside.mean(axis=0), np.nan),
        after=np.where(kept, after.mean(axis=0), np.nan),
        error=np.where(kept, spread, np.nan),
        residual=np.where(kept, np.sqrt(np.mean((after - 1) ** 2, axis=0)), np.nan),
        curve=curve,
    )
    if not isinstance(base.response, Linear) or base.dead_band:
        return outcome.recorded()
    # A response that is found later makes other gains of these readings.
    return outcome.recorded({GAIN_READINGS: readings_of_gains(np.median(found.frames[:, usable], axis=1))})


def _positive_pressures(pressure_pa: ArrayLike) -> Floats:
    told = as_array(pressure_pa).ravel()
    wrong = told[~(np.isfinite(told) & (told > 0))]
    if not told.size or wrong.size:
        got = f"{wrong[0]:g}" if wrong.size else repr(pressure_pa)[:60]
        raise InputError(f"pressure_pa must be positive and finite numbers, pascal, got {got}", parameter="pressure_pa")
    return told


def _one_a_press(told: Floats, n: int) -> Floats:
    if told.size != n:
        raise InputError(
            f"pressure_pa must be one positive number for each of the {counted(n, 'press')} found, got {told.size}: "
            f"{', '.join(f'{p:g}' for p in told[:8])}"
        )
    return told


def _check_reached(found: Presses) -> None:
    """Refuse presses that leave a part of the pad without load."""
    for i, frame in enumerate(found.frames):
        values = frame[found.usable]
        typical = float(np.median(values))
        silent = np.count_nonzero(values < _BROKEN * typical)
        if typical <= 0 or silent > _MOST_BROKEN * values.size:
            raise InputError(
                f"{found.where(i)} is no even pressure: {silent} of {values.size} taxels feel next to nothing; "
                "cover the whole pad, or calibrate from them as unlabelled presses of anything",
                parameter="kind",
            )


def _check_even(beside: Floats, usable: NDArray[np.bool_], found: Presses, *, curved: bool) -> None:
    """Refuse repeated presses that do not load the pad alike."""
    if found.n < 2:
        return
    shares = beside[:, usable] / np.maximum(np.median(beside[:, usable], axis=0), _BROKEN)
    typical = np.median(found.frames[:, usable], axis=1)
    off = 1.4826 * np.median(np.abs(shares - 1.0), axis=1)
    noise = found.noise / typical
    wrong = np.flatnonzero(off > _MOST_DIFFERENCE + 3 * noise)
    if wrong.size:
        i = int(wrong[0])
        other = (
            "readings end below the strongest: then leave out what reaches it"
            if curved
            else "readings do not follow load in a line: then give the pressures"
        )
        raise InputError(
            f"{found.where(i)} loads the pad otherwise than the others: its taxels differ by {100 * off[i]:.0f} % from "
            f"their own median; it was not even, or {other}"
        )


def _bent(
    beside: Floats, gains: Floats, usable: NDArray[np.bool_], found: Presses
) -> tuple[Floats | float, tuple[str, ...]]:
    """Return how far each gain goes with the load, and words where it does: no gain before this response does that."""
    load = np.log(np.median(found.frames[:, usable], axis=1))
    load = load - load.mean()
    if found.n < _FEWEST_PRESSURES or np.ptp(load) < np.log(_LIGHT_TO_STRONG):
        return 0.0, ()
    off = np.where(usable, beside / np.where(gains > _BROKEN, gains, np.inf) - 1.0, 0.0)
    off = off - off.mean(axis=0)
    slope = np.tensordot(load, off, axes=1) / (load @ load)
    explained = float((load @ load) * np.sum(slope**2) / max(float(np.sum(off**2)), 1e-300))
    apart = float(np.ptp(load) * np.sqrt(np.mean(slope[usable] ** 2)))
    if explained < _EXPLAINED or apart < _WITH_LOAD:
        return 0.0, ()
    return np.abs(slope) * np.sqrt(np.mean(load**2)), (
        f"the gains change with the load, by {apart:.0%} from the lightest to the strongest press: readings are no "
        "gain before one response; below and above these pressures they are off by more",
    )


def _looks_uneven(gains: Floats, kept: NDArray[np.bool_]) -> tuple[str, ...]:
    """Refuse gains that differ much and smoothly, as a press that is not even makes them; say where that may be."""
    spread = float(np.std(gains[kept]))
    bowl = _bowl(gains, kept)
    told = (
        f"{bowl:.0%} of the gains goes smoothly over the pad: if the press was not even, they are wrong by so much; "
        "turn what presses by half a turn and compare",
    )
    also = told if bowl >= _BOWL else ()
    pairs = [
        (gains[one][both], gains[other][both])
        for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1]))
        if np.count_nonzero(both := kept[one] & kept[other]) > _FEWEST_PAIRS
    ]
    if spread < _SMOOTH_SPREAD[0] or not pairs:
        return also
    alike = float(np.mean([np.corrcoef(one, other)[0, 1] for one, other in pairs]))
    if not alike > _ALIKE:
        return also
    words = f"taxels beside each other read alike (correlation {alike:.2f}) and differ by {spread:.0%} over the pad"
    if spread < _SMOOTH_SPREAD[1]:
        return (f"{words}: the gains may be those of a press that was not even",)
    raise InputError(
        f"the press is not even: {words}, as under a thing that has a form; spread the load by a bag of water or foam "
        "under a plate, or calibrate from many presses as unlabelled ones of anything",
        parameter="kind",
    )


def _bowl(gains: Floats, kept: NDArray[np.bool_]) -> float:
    """Return the standard deviation of the bowl or slope that gains follow; 0 where chance makes as much."""
    row, col = np.nonzero(kept)
    if row.size <= 2 * (_OF_A_BOWL + 1):
        return 0.0
    y, x = row - row.mean(), col - col.mean()
    terms = np.stack([np.ones(row.size), x, y, x * x, x * y, y * y], axis=1)
    fitted = terms @ np.linalg.lstsq(terms, gains[kept], rcond=None)[0]
    left = float(np.var(gains[kept] - fitted)) * row.size / (row.size - _OF_A_BOWL - 1)
    by_chance = left * _OF_A_BOWL / row.size
    found = float(np.var(fitted))
    return float(np.sqrt(found - by_chance)) if found > _NOT_BY_CHANCE * by_chance else 0.0


def _mean(beside: Floats, weight: Floats, usable: NDArray[np.bool_]) -> Floats:
    """Return each taxel's mean over presses, beside the median one."""
    mean: Floats = np.average(beside, axis=0, weights=weight)
    return mean / np.median(mean[usable])


def _error_of_deviation(gains: Floats, error: Floats) -> float:
    """Return the standard error of the standard deviation of gains: from each one's, and from their median's."""
    deviation = float(np.std(gains))
    if deviation == 0.0:
        return float(np.median(error) / np.sqrt(2 * gains.size))
    own = np.linalg.norm((gains - gains.mean()) * error) / (gains.size * deviation)
    # The median is one taxel, or two.
    return float(np.hypot(own, deviation * np.median(error) / np.sqrt(2)))


def _as_far(found: Presses) -> str:
    """Return what the error of gains does not count."""
    if found.n < 2:
        return "by noise alone: one press does not tell how even it was"
    return "as far as what presses have in common is even"


def _as_stress(found: Presses, linear: Floats, base: Sensor) -> Presses:
    """Return presses with frames that are in proportion to stress, and as steep in readings as at the usual taxel's."""
    typical = np.median(found.frames[:, found.usable], axis=1)
    step = 1e-4 * typical

    def usual(readings: Floats) -> Floats:
        alike = np.broadcast_to(readings[:, None, None], linear.shape)
        return np.asarray(np.median(base.stress(alike)[:, found.usable], axis=1))

    slope = (usual(typical + step) - usual(typical - step)) / (2 * step)
    return dataclasses.replace(found, frames=linear / slope[:, None, None])


def _unevenness(beside: Floats, usable: NDArray[np.bool_], noise: Floats) -> float:
    """Return by which share presses differ at the usual taxel beyond noise; 0 where noise alone explains it."""
    if len(beside) < 2:
        return 0.0
    mean = beside.mean(axis=0)
    there = usable & (mean >= _BROKEN)
    squares = np.sum((beside[:, there] / mean[there] - 1.0) ** 2, axis=0) / (len(beside) - 1)
    variance = float(np.mean(squares))
    by_noise = float(np.mean(noise**2) * np.mean(mean[there] ** -2.0))
    return float(np.sqrt(variance - by_noise)) if variance > _BEYOND_NOISE * by_noise else 0.0


def _error(beside: Floats, weight: Floats, found: Presses) -> Floats:
    """Return the standard error of each gain: from how presses repeat, at least from noise, and from their rest's."""
    typical = np.median(found.frames[:, found.usable], axis=1)
    noise = np.sqrt(1.0 / np.sum((typical / np.maximum(found.noise, 1e-12 * typical)) ** 2))
    share = weight / weight.sum()
    # Presses of one recording have one rest, so that they repeat its error.
    of_rest = 0.0
    if found.rest_noise is not None:
        by_rest = np.bincount(found.recording, share / typical, len(found.rest_noise))
        of_rest = float(np.linalg.norm(by_rest * found.rest_noise))
    if found.n < 2:
        return np.full(beside.shape[1:], np.hypot(noise, of_rest))
    mean = np.average(beside, axis=0, weights=weight)
    variance = np.sum(share[:, None, None] ** 2 * (beside - mean) ** 2, axis=0) * found.n / (found.n - 1)
    error: Floats = np.hypot(np.maximum(np.sqrt(variance), noise), of_rest)
    return error
