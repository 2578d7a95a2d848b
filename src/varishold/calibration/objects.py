"""Calibration by known objects: a ball of known diameter, a roller, a flat plate."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.imprint import KnownObject, Points
from varishold.calibration.press_fit import Fit, Observed, fit_presses
from varishold.calibration.readings import Presses, presses_of
from varishold.calibration.result import Calibration, Curve, Finding
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor

__all__ = ["FEWEST_OF_EACH", "calibrate_objects"]

Floats = NDArray[np.float64]

#: Presses of each object below which its constants are not to be believed.
FEWEST_OF_EACH = 5

# A press is never predicted better than to this share of its peak.
_LEAST_SIGMA = 0.01
# Presses that are left unexplained by more than this share of their peak (root mean square inside) are not of it.
_MOST_LEFT = 0.15
# A response of one constant more must explain presses that it was not fitted to so much better.
_WORTH = 0.95
# What is smaller than so many standard errors is none.
_SURE = 2.0
# A dead band must explain presses by so much better than none, and none leave more than so many sigma: a press that is
# as much less deep looks the same.
_DEAD_WORTH, _WELL = 0.9, 1.5
# A known object is at least as large as the spacing of taxels, and at most so many times as the pad.
_LARGEST = 50.0
# Above this share of a frame's peak a taxel is taken for pressed in the first guess.
_PRESSED = 0.1
# Constants beside the response's: logarithm of full scale beside depth, dead band, blur squared.
_SCALE, _DEAD, _BLUR = 0, 1, 2
# How large a dead band may be, and what is none to a fit that wants room.
_MOST_DEAD, _NO_DEAD = 0.8, 1e-9
# Points of the response that are shown, and readings that one needs.
_CURVE_BINS, _FEWEST_IN_BIN = 24, 5


@dataclasses.dataclass(frozen=True)
class _Family:
    """A response to be tried: how it is made of its constant, where that begins and must stay."""

    name: str
    start: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def response(self, constants: Floats) -> Response:
        if self.name == "power":
            return Power(float(np.exp(constants[0])))
        if self.name == "logarithmic":
            return Logarithmic(float(np.exp(constants[0])))
        return Linear()


_FAMILIES = (
    _Family("linear", (), (), ()),
    _Family("power", (0.0,), (np.log(0.2),), (np.log(5.0),)),
    _Family("logarithmic", (1.0,), (np.log(0.02),), (np.log(500.0),)),
)


def calibrate_objects(
    recordings: Sequence[Recording],
    objects: Sequence[KnownObject],
    *,
    sensor: Sensor | None = None,
    pad: str | None = None,
) -> Calibration:
    """Find response, dead band and blur from presses of objects of known form and size.

    Where and how deep each press was is found together with the constants. The face's depth is
    taken for the stress, as on a thin cover or a bed of springs: a power response of .5 and a thick skin press
    a ball alike.

    Parameters
    ----------
    recordings : sequence of Recording
        Presses; the pitch must be known.
    objects : sequence of KnownObject
        What pressed in each recording, or one for all.
    sensor : Sensor, optional
        What is known already; its gains are used, and kept.
    pad : str, optional
        Which pad of the recordings.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If there are fewer than `FEWEST_OF_EACH` presses of an object, the pitch is unknown, the rest
        moves, or the presses are not of the objects named.
    """
    known = sensor or Sensor()
    if len(objects) not in (1, len(recordings)):
        raise InputError(
            f"give one known object for all recordings or one for each: got {len(objects)} for {len(recordings)}"
        )
    each = list(objects) * (len(recordings) if len(objects) == 1 else 1)
    found = presses_of(recordings, known, pad=pad)
    if found.pitch_m is None:
        raise InputError(
            "known objects need the taxels' pitch, in the recordings or in the sensor file", parameter="pitch_m"
        )
    for number, thing in enumerate(each):
        count = int(np.count_nonzero(found.recording == number))
        if count < FEWEST_OF_EACH:
            raise InputError(
                f"{recordings[number].source or f'recording {number}'}: {count} presses of a {thing.kind} are too few, "
                f"{FEWEST_OF_EACH} are the least, ten at different places and depths good"
            )
    _check_sizes(each, found.usable.shape, found.pitch_m)
    points = Points(found.usable.shape, found.pitch_m)
    span = float(np.quantile(found.frames[:, found.usable].max(axis=1), 0.95))
    base = dataclasses.replace(
        known.upright(), span=span, full_scale=span, response=Linear(), dead_band=0.0, crosstalk=0.0, saturation=None
    )
    observed = [_observed(found, k, each[int(found.recording[k])], points) for k in range(found.n)]
    curved = [k for k, one in enumerate(observed) if one.object.curved]
    families = _FAMILIES if curved else _FAMILIES[:1]
    tried = {family.name: _held_out(family, base, observed, points, found.usable) for family in families}
    best = families[0]
    for family in families:
        if tried[family.name] < _WORTH * tried[best.name]:
            best = family
    fit = _fitted(best, base, observed, points, found.usable)
    plain = _fitted(best, base, observed, points, found.usable, most_dead=_NO_DEAD)
    left, left_plain = (float(np.sqrt(np.median(one.cost))) for one in (fit, plain))
    dead = left < _DEAD_WORTH * left_plain and left_plain > _WELL
    fit = fit if dead else plain
    _check_explained(fit, observed, found)
    halves = _halves(best, base, observed, points, found.usable, fit, most_dead=_MOST_DEAD if dead else _NO_DEAD)
    return _outcome(known, found, best, fit, halves, observed, tried, base, dead=dead)


def _check_sizes(things: Sequence[KnownObject], shape: tuple[int, ...], pitch_m: tuple[float, float]) -> None:
    """Refuse objects that cannot have pressed this pad: millimetres for metres."""
    across = max(side * spacing for side, spacing in zip(shape, pitch_m, strict=True))
    for thing in things:
        if not min(pitch_m) <= thing.size_m <= _LARGEST * across:
            raise InputError(
                f"a {thing.kind} of {thing.size_m:g} m on a pad that is {across:.3g} m across, taxels "
                f"{min(pitch_m):.3g} m apart: sizes and pitch are in metres"
            )


def _sensor_with(base: Sensor, family: _Family, constants: Floats) -> Sensor:
    return dataclasses.replace(
        base,
        dead_band=float(np.clip(constants[_DEAD], 0.0, 0.85)),
        blur_taxels=float(np.sqrt(np.clip(constants[_BLUR], 0.0, 16.0))),
        response=family.response(constants[3:]),
    )


def _fitted(
    family: _Family,
    base: Sensor,
    observed: Sequence[Observed],
    points: Points,
    usable: NDArray[np.bool_],
    start: Fit | None = None,
    *,
    free: bool = True,
    constants: Floats | None = None,
    most_dead: float = _MOST_DEAD,
) -> Fit:
    def forward(faces: Floats, at: Floats) -> Floats:
        return _sensor_with(base, family, at).forward(faces * (np.exp(at[_SCALE]) * base.full_scale))

    if constants is None:
        deepest = [float(one.object.stress(one.start, points).max()) for one in observed if one.object.curved] or [
            float(one.object.stress(one.start, points).max()) for one in observed
        ]
        constants = np.array([-np.log(max(deepest)), 0.02, 0.1, *family.start])
    high = np.array([30.0, most_dead, 9.0, *family.high])
    return fit_presses(
        forward,
        np.minimum(constants, high),
        observed,
        points,
        usable,
        low=np.array([-30.0, 0.0, 0.0, *family.low]),
        high=high,
        places=None if start is None else start.places,
        free=free,
    )


def _held_out(
    family: _Family, base: Sensor, observed: Sequence[Observed], points: Points, usable: NDArray[np.bool_]
) -> float:
    """Return how badly a family explains presses that it was not fitted to, in their sigmas."""
    cost = []
    for k in (0, 1):
        fit = _fitted(family, base, observed[k::2], points, usable)
        other = _fitted(family, base, observed[1 - k :: 2], points, usable, constants=fit.constants, free=False)
        cost.append(np.median(other.cost))
    return float(np.sqrt(np.mean(cost)))


def _halves(
    family: _Family,
    base: Sensor,
    observed: Sequence[Observed],
    points: Points,
    usable: NDArray[np.bool_],
    fit: Fit,
    *,
    most_dead: float,
) -> Floats:
    """Return the standard errors of the constants: as halves of the presses repeat them, at least as the fit says."""
    found = []
    for k in (0, 1):
        half = [one for i, one in enumerate(observed) if i % 2 == k]
        places = [place for i, place in enumerate(fit.places) if i % 2 == k]
        again = dataclasses.replace(fit, places=tuple(places))
        found.append(
            _fitted(family, base, half, points, usable, again, constants=fit.constants, most_dead=most_dead).constants
        )
    return np.maximum(np.abs(found[0] - found[1]) / 2, fit.error)


def _observed(found: Presses, k: int, thing: KnownObject, points: Points) -> Observed:
    """Return a press with a first guess of where and how deep it is."""
    frame = np.where(found.usable, found.frames[k], 0.0)
    peak = float(frame.max())
    dy, dx = points.pitch_m
    rows, cols = frame.shape
    y, x = np.indices(frame.shape)
    x, y = (x - (cols - 1) / 2) * dx, (y - (rows - 1) / 2) * dy
    pressed = frame > _PRESSED * peak
    weight = np.where(pressed, frame, 0.0)
    weight /= weight.sum()
    cx, cy = float((weight * x).sum()), float((weight * y).sum())
    area = float(pressed.sum()) * dx * dy
    pitch = min(dx, dy)
    xx, yy = float((weight * (x - cx) ** 2).sum()), float((weight * (y - cy) ** 2).sum())
    xy = float((weight * (x - cx) * (y - cy)).sum())
    yaw = 0.5 * float(np.arctan2(2 * xy, xx - yy))
    if thing.kind == "ball":
        depth = min(area / np.pi / thing.size_m, 0.4 * thing.size_m)
        start, scale = [cx, cy, depth], [pitch, pitch, 0.5 * depth]
    elif thing.kind == "roller":
        long = np.hypot(rows * dy * np.sin(yaw), cols * dx * np.cos(yaw))
        depth = min((area / long / 2) ** 2 / thing.size_m, 0.4 * thing.size_m)
        start = [-np.sin(yaw) * cx + np.cos(yaw) * cy, yaw, depth, 0.0]
        scale = [pitch, 0.1, 0.5 * depth, 0.5 * depth / long]
    else:
        depth = 0.5 * pitch * peak / float(found.frames.max())
        start = [cx, cy, _plate_turn(pressed, x - cx, y - cy, thing.size_m), depth, 0.0, 0.0]
        scale = [pitch, pitch, 0.1, 0.3 * depth, depth / thing.size_m, depth / thing.size_m]
    sigma = float(np.hypot(found.noise[k], _LEAST_SIGMA * peak))
    return Observed(thing, frame, sigma, np.array(start), np.array(scale))


def _plate_turn(pressed: NDArray[np.bool_], x: Floats, y: Floats, size_m: float) -> float:
    """Return the turn at which a square of this breadth covers what is pressed best."""
    turns = np.linspace(0, np.pi / 2, 19)[:-1]
    agree = []
    for turn in turns:
        u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        agree.append(np.count_nonzero((np.maximum(np.abs(u), np.abs(v)) < size_m / 2) == pressed))
    return float(turns[int(np.argmax(agree))])


def _left(fit: Fit, observed: Sequence[Observed]) -> Floats:
    """Return what is left of each press, root mean square over its pressed taxels, as a share of its peak."""
    shares = []
    for one, predicted in zip(observed, fit.predicted, strict=True):
        peak = one.frame.max()
        inside = (one.frame > _PRESSED * peak) | (predicted > _PRESSED * peak)
        shares.append(np.sqrt(np.mean((one.frame - predicted)[inside] ** 2)) / peak)
    return np.array(shares)


def _check_explained(fit: Fit, observed: Sequence[Observed], found: Presses) -> None:
    left = _left(fit, observed)
    for number in np.unique(found.recording):
        here = found.recording == number
        typical = float(np.median(left[here]))
        if typical > _MOST_LEFT:
            thing = observed[int(np.flatnonzero(here)[0])].object
            raise InputError(
                f"recording {number} is not of a {thing.kind} of {thing.size_m:g} m, or not on this pitch: "
                f"{100 * typical:.0f} % of its presses is left unexplained"
            )


def _outcome(
    known: Sensor,
    found: Presses,
    family: _Family,
    fit: Fit,
    error: Floats,
    observed: Sequence[Observed],
    tried: dict[str, float],
    base: Sensor,
    *,
    dead: bool,
) -> Calibration:
    constants = fit.constants.copy()
    findings, unknown, notes = [], [], list(found.notes)
    for index in (_DEAD, _BLUR):
        if constants[index] < _SURE * error[index]:
            constants[index] = 0.0
    if constants.size > 3:
        response = family.response(constants[3:])
        (key, value), *_ = response.entries().items()
        says = "of the power response y = x^exponent"
        if key == "a":
            says = "of the logarithmic response y = log(1 + a x) / log(1 + a)"
        findings.append(Finding(key, float(value), float(value * error[3]), says))
    elif len(tried) > 1:
        notes.append("the response is linear, as far as these presses tell")
    else:
        unknown.append("the response: a flat face presses everywhere alike; press a ball or a roller too")
    if dead:
        findings.append(
            Finding(
                "dead_band", float(constants[_DEAD]), float(error[_DEAD]), "share of full scale that is not felt", True
            )
        )
    else:
        constants[_DEAD] = 0.0
        unknown.append("a dead band: without one these presses are explained as well, were they less deep")
    blur, spread = float(np.sqrt(constants[_BLUR])), float(error[_BLUR])
    findings.append(
        Finding(
            "blur_taxels",
            blur,
            float(spread / max(2 * blur, np.sqrt(spread), 1e-9)),
            "standard deviation, in taxels, of what spreads to neighbours: crosstalk and a thin cover together",
        )
    )
    unknown += [
        "the gains: use an even pressure or unlabelled presses first, and give that sensor file (sensor)",
        "the cover's thickness and modulus: on springs, as taken here, a thick skin looks like a response and a blur",
    ]
    if len(tried) > 1:
        others = ", ".join(f"{name} {cost:.2f}" for name, cost in tried.items())
        notes.append(f"presses left out of the fit are explained to so many sigmas: {others}")
    typical = float(np.sqrt(np.median(fit.cost)))
    if typical > _WELL:
        notes.append(
            f"the fit leaves {typical:.2g} times what noise and a hundredth of the peak would: these presses are not "
            "quite of such objects on springs, and what was found may be off by more than it says"
        )
    measured = _sensor_with(base, family, constants)
    made = dataclasses.replace(
        known,
        shape=found.usable.shape,
        pitch_m=found.pitch_m,
        span=measured.span,
        full_scale=measured.full_scale,
        response=measured.response,
        dead_band=measured.dead_band,
        blur_taxels=measured.blur_taxels,
        crosstalk=0.0,
        rest=found.rest_of(known),
        source="",
    )
    residual = np.array([(one.frame - p) / one.frame.max() for one, p in zip(observed, fit.predicted, strict=True)])
    frames, predicted = np.array([one.frame for one in observed]), fit.predicted
    pressed = predicted > 0.3 * predicted.max(axis=(1, 2), keepdims=True)
    ratio = np.where(pressed & (frames > 0), frames / np.maximum(predicted, 1e-300), np.nan)
    seen = pressed.sum(axis=0) >= 2
    after = np.full(found.usable.shape, np.nan)
    after[seen] = np.nanmedian(ratio[:, seen], axis=0)
    outcome = Calibration(
        kind="objects",
        sensor=made,
        presses=found.n,
        findings=tuple(findings),
        unknown=tuple(unknown),
        notes=tuple(notes),
        before=frames.max(axis=0) / frames.max(),
        after=after,
        error=np.full(found.usable.shape, np.nan),
        residual=np.where(found.usable, np.sqrt(np.mean(residual**2, axis=0)), np.nan),
        curve=_curve(measured, fit, observed),
    )
    return dataclasses.replace(outcome, sensor=dataclasses.replace(made, calibration=outcome.record()))


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
