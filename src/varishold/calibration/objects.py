"""Calibration by known objects: a ball of known diameter, a roller, a flat plate."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.calibration.covers import cover_of
from varishold.calibration.explanation import (
    Explanation,
    Family,
    Hypothesis,
    Observations,
    explain,
    families_of,
)
from varishold.calibration.gains_behind import GAIN_READINGS, known_readings
from varishold.calibration.gains_of_objects import ObjectGains, gains_of_objects
from varishold.calibration.imprint import KnownObject, Points, Print
from varishold.calibration.objects_told import findings_of, gain_notes_of, notes_of, unknown_of
from varishold.calibration.press_fit import Fit, Observed
from varishold.calibration.readings import Presses, presses_of
from varishold.calibration.result import Calibration, Curve
from varishold.calibration.silent import marked_broken, pressed_around, silent_taxels
from varishold.calibration.thickness import (
    Thickness,
    has_floor,
    likeliest_layer,
    tells_thickness,
    thickness_of,
)
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.sensor import Linear, Sensor

__all__ = ["FEWEST_OF_EACH", "calibrate_objects"]

Floats = NDArray[np.float64]

#: Presses of each object below which its constants are not to be believed.
FEWEST_OF_EACH = 5

# A press is never predicted better than to this share of its peak.
_LEAST_SIGMA = 0.01
# Presses that are left unexplained by more than this share of their peak (root mean square inside) are not of it.
_MOST_LEFT = 0.15
# A known object is at least as large as the spacing of taxels, and at most so many times as the pad.
_LARGEST = 50.0
# Presses in which a taxel that is broken stays silent: no known object leaves one alone that it goes around.
_FEWEST_TO_BREAK = 2
# Above this share of a frame's peak a taxel is taken for pressed in the first guess.
_PRESSED = 0.1
# A press of something smaller than the pad leaves more of its taxels alone than this share leaves.
_COVERED = 0.98
# A taxel is beside what it should read where presses reach this share of their peak, so many of them at least.
_COMPARED, _FEWEST_COMPARED = 0.3, 2
# Points of the response that are shown, and readings that one needs.
_CURVE_BINS, _FEWEST_IN_BIN = 24, 5


def calibrate_objects(
    recordings: Sequence[Recording],
    objects: Sequence[KnownObject],
    *,
    sensor: Sensor | None = None,
    pad: str | None = None,
    tick: Callable[..., object] = lambda **_: None,
) -> Calibration:
    """Find response, dead band, blur and gains from presses of objects of known form and size.

    Where and how deep each press was is found together with the constants; what a taxel reads beside that, press
    after press, is its gain, where two objects or two halves of the presses agree. Round and flat objects
    together tell how thick an elastic cover is: a thick one presses a ball as springs behind a power response of .5
    do, but a flat face highest along its edges. Without both the face's depth is taken for the stress, as on springs.

    Parameters
    ----------
    recordings : sequence of Recording
        Presses; the pitch must be known.
    objects : sequence of KnownObject
        What pressed in each recording, or one for all.
    sensor : Sensor, optional
        What is known already; its gains are used, and kept; those that `calibrate_even` found without a response
        are put behind the one that is found.
    pad : str, optional
        Which pad of the recordings.
    tick : callable, optional
        Called with ``total``, how many steps there are, and with ``advance`` after some; it takes a minute at most.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If there are fewer than `FEWEST_OF_EACH` presses of an object, the pitch is unknown, the rest
        moves, readings end, or the presses are not of the objects named.
    """
    known = sensor or Sensor()
    if len(objects) not in (1, len(recordings)):
        raise InputError(
            f"give one known object for all recordings or one for each: got {len(objects)} for {len(recordings)}"
        )
    each = list(objects) * (len(recordings) if len(objects) == 1 else 1)
    # Readings that end look like a response that bends.
    found = presses_of(recordings, known, pad=pad, most_ended=0.0)
    pitch_m = found.pitch_m
    if pitch_m is None:
        raise InputError(
            "known objects need the taxels' pitch, in the recordings or in the sensor file", parameter="pitch_m"
        )
    _check_enough(recordings, each, found)
    _check_sizes(each, found.usable.shape, pitch_m)
    _check_edges(each, found, pitch_m)
    pressed = pressed_around(found.frames, found.usable)
    broken = silent_taxels(found.frames, found.usable, pressed, fewest=_FEWEST_TO_BREAK)
    found = dataclasses.replace(found, usable=found.usable & ~broken)
    points = Points(found.usable.shape, pitch_m)
    if known.cover is not None:
        points = dataclasses.replace(points, cover=cover_of(known.cover, points.diagonal_m))
    span = float(np.quantile(found.frames[:, found.usable].max(axis=1), 0.95))
    base = dataclasses.replace(
        known.upright(), span=span, full_scale=span, response=Linear(), dead_band=0.0, crosstalk=0.0, saturation=None
    )
    observed = [_observed(found, k, each[int(found.recording[k])], points) for k in range(found.n)]
    given = Observations(base, observed, points, found.usable, known_readings(known))
    tried = {each.hypothesis: each for each in _attempts(given, known, tick)}
    explanation, costs = explain({hypothesis: each.given for hypothesis, each in tried.items()}, tick)
    best, thickness = tried[explanation.hypothesis], None
    _check_explained(explanation.fit, observed, found)
    if known.cover is None and has_floor(best.hypothesis.cover):
        thickness, explanation, under = thickness_of(explanation, best.given)
        best = best._replace(given=under)
    return _outcome(known, found, best, explanation, costs, thickness, broken)


class _Attempt(NamedTuple):
    """What may explain the presses, they with the gains that go with it, and these."""

    hypothesis: Hypothesis
    given: Observations
    gains: ObjectGains | None


def _attempts(given: Observations, known: Sensor, tick: Callable[..., object]) -> Iterator[_Attempt]:
    """Yield what may explain presses: gains that were found behind one response hide that it is another."""
    families, layers = families_of(given), known.cover is None and tells_thickness(given)
    # Each is made, and judged by presses that it was not fitted to; the best is fitted once more.
    tick(total=2 * len(families) * (1 + layers) + 1)
    for family in families:
        plain = _with_gains(given, family, known)
        tick(advance=1)
        yield plain
        layer = likeliest_layer(plain.given, family) if layers else None
        if layer is not None:
            yield _with_gains(given.under(layer), family, known)
        if layers:
            tick(advance=1 if layer is not None else 2)


def _with_gains(given: Observations, family: Family, known: Sensor) -> _Attempt:
    hypothesis = Hypothesis(family, given.points.cover)
    if known.gains is not None:
        return _Attempt(hypothesis, given, None)
    gains = gains_of_objects(given, family)
    return _Attempt(hypothesis, given.with_gains(gains.map, gains.agreed.spread) if gains.worth else given, gains)


def _check_enough(recordings: Sequence[Recording], things: Sequence[KnownObject], found: Presses) -> None:
    for number, thing in enumerate(things):
        count = int(np.count_nonzero(found.recording == number))
        if count < FEWEST_OF_EACH:
            raise InputError(
                f"{recordings[number].source or f'recording {number}'}: {counted(count, 'press')} of a {thing.kind} "
                f"{'is' if count == 1 else 'are'} too few, "
                f"{FEWEST_OF_EACH} are the least, ten at different places and depths good"
            )


def _check_sizes(things: Sequence[KnownObject], shape: tuple[int, ...], pitch_m: tuple[float, float]) -> None:
    """Refuse objects that cannot have pressed this pad: millimetres for metres."""
    across = max(side * spacing for side, spacing in zip(shape, pitch_m, strict=True))
    for thing in things:
        if not min(pitch_m) <= thing.size_m <= _LARGEST * across:
            raise InputError(
                f"a {thing.kind} of {thing.size_m:g} m on a pad that is {across:.3g} m across, taxels "
                f"{min(pitch_m):.3g} m apart: sizes and pitch are in metres"
            )


def _check_edges(things: Sequence[KnownObject], found: Presses, pitch_m: tuple[float, float]) -> None:
    """Refuse presses of the whole pad where what is said to press is smaller: a blur would explain them."""
    narrow = min(side * spacing for side, spacing in zip(found.usable.shape, pitch_m, strict=True))
    values = found.frames[:, found.usable]
    covered = np.mean(values > _PRESSED * values.max(axis=1, keepdims=True), axis=1)
    for number, thing in enumerate(things):
        if thing.size_m < narrow and np.median(covered[found.recording == number]) > _COVERED:
            raise InputError(
                f"{found.sources[number]}: is not of a {thing.kind} of {thing.size_m:g} m: its presses cover the whole "
                "pad; if what pressed was even, calibrate from it so",
                parameter="kind",
            )


def _observed(found: Presses, k: int, thing: KnownObject, points: Points) -> Observed:
    """Return a press with a first guess of where and how deep it is."""
    frame = np.where(found.usable, found.frames[k], 0.0)
    peak = float(frame.max())
    left = Print(frame, frame > _PRESSED * peak, points.pitch_m, float(found.frames.max()))
    start, scale = thing.guess(left)
    sigma = float(np.hypot(found.noise[k], _LEAST_SIGMA * peak))
    return Observed(thing, frame, sigma, np.array(start), np.array(scale))


def _left(fit: Fit, observed: Sequence[Observed], usable: NDArray[np.bool_]) -> Floats:
    """Return what is left of each press, root mean square over its pressed taxels, as a share of its peak."""
    shares = []
    for one, predicted in zip(observed, fit.predicted, strict=True):
        peak = one.frame.max()
        inside = usable & ((one.frame > _PRESSED * peak) | (predicted > _PRESSED * peak))
        shares.append(np.sqrt(np.mean((one.frame - predicted)[inside] ** 2)) / peak)
    return np.array(shares)


def _check_explained(fit: Fit, observed: Sequence[Observed], found: Presses) -> None:
    left = _left(fit, observed, found.usable)
    for number in np.unique(found.recording):
        here = found.recording == number
        typical = float(np.median(left[here]))
        if typical > _MOST_LEFT:
            thing = observed[int(np.flatnonzero(here)[0])].object
            raise InputError(
                f"{found.sources[number]}: is not of a {thing.kind} of {thing.size_m:g} m, or not on this pitch: "
                f"{100 * typical:.0f} % of its presses is left unexplained"
            )


def _outcome(
    known: Sensor,
    found: Presses,
    attempt: _Attempt,
    explanation: Explanation,
    tried: Mapping[str, float],
    thickness: Thickness | None,
    broken: NDArray[np.bool_],
) -> Calibration:
    given, gains, fit, observed = attempt.given, attempt.gains, explanation.fit, attempt.given.observed
    measured = given.sensor(explanation.family, explanation.constants)
    even = gains if gains is not None and gains.worth else None
    kept = np.ones(broken.shape) if measured.gains is None else measured.gains
    made = found.sensor_with(
        known,
        pitch_m=found.pitch_m,
        gains=np.where(broken, 0.0, kept) if broken.any() else measured.gains,
        span=measured.span,
        full_scale=measured.full_scale,
        response=measured.response,
        dead_band=measured.dead_band,
        blur_taxels=measured.blur_taxels,
        crosstalk=0.0,
    )
    frames = np.array([one.frame for one in observed])
    residual = (frames - fit.predicted) / frames.max(axis=(1, 2), keepdims=True)
    outcome = Calibration(
        kind="objects",
        sensor=made,
        presses=found.n,
        findings=findings_of(explanation, thickness, even),
        unknown=unknown_of(known, given, explanation, curved=len(tried) > 1, has_gains=measured.gains is not None),
        notes=(
            *found.notes,
            *notes_of(known, explanation, tried),
            *marked_broken(broken),
            *gain_notes_of(known, given, explanation, gains),
        ),
        before=frames.max(axis=0) / frames.max() if even is None else _beside(frames, _without(even, measured, fit)),
        after=_beside(frames, fit.predicted),
        error=np.full(found.usable.shape, np.nan) if even is None else even.error,
        residual=np.where(found.usable, np.sqrt(np.mean(residual**2, axis=0)), np.nan),
        curve=_curve(measured, fit, observed),
    )
    more: dict[str, Any] = {} if thickness is None else {"thickness_m": thickness.metres}
    if not explanation.hypothesis.bends and given.gain_readings is not None:
        more[GAIN_READINGS] = given.gain_readings.tolist()
    return outcome.recorded(more)


def _without(gains: ObjectGains, measured: Sensor, fit: Fit) -> Floats:
    """Return what the fit would predict of taxels that are all alike."""
    stress = measured.response.stress(fit.predicted / measured.span)
    even: Floats = measured.span * measured.response.reading(stress / gains.map)
    return even


def _beside(frames: Floats, predicted: Floats) -> Floats:
    """Return each taxel's reading beside what it should be; NaN where too few presses press."""
    pressed = predicted > _COMPARED * predicted.max(axis=(1, 2), keepdims=True)
    ratio = np.where(pressed & (frames > 0), frames / np.maximum(predicted, 1e-300), np.nan)
    seen = np.isfinite(ratio).sum(axis=0) >= _FEWEST_COMPARED
    after = np.full(seen.shape, np.nan)
    after[seen] = np.nanmedian(ratio[:, seen], axis=0)
    return after


def _curve(measured: Sensor, fit: Fit, observed: Sequence[Observed]) -> Curve:
    """Return readings beside the stress above the dead band that explains them, in bins of stress."""
    stress = measured.response.stress(fit.predicted.ravel() / measured.span)
    reading = np.array([one.frame for one in observed]).ravel() / measured.span
    bins = np.linspace(0.0, max(float(stress.max()), 1e-9), _CURVE_BINS + 1)
    at = np.digitize(stress, bins)
    chosen = [k for k in range(2, bins.size + 1) if np.count_nonzero(at == k) >= _FEWEST_IN_BIN]
    return Curve(
        np.array([float(np.median(stress[at == k])) for k in chosen]),
        np.array([float(np.median(reading[at == k])) for k in chosen]),
    )
