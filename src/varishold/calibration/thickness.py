"""How thick the layer is that known objects were pressed through: a ball and a flat face tell it apart from a response.

A layer presses a ball as springs behind a bent response do, but a flat face highest along its edges, as none does.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from varishold.calibration.covers import Cover, Elastic
from varishold.calibration.explanation import Explanation, Family, Observations, fitted
from varishold.calibration.press_fit import Fit

__all__ = ["POISSON", "Thickness", "has_floor", "likeliest_layer", "tells_thickness", "thickness_of"]

#: Poisson's ratio of rubbers and gels, which is taken where nobody says another.
POISSON = 0.45
# Thicknesses that are tried, as powers of 2 of the pitch; the highest is beyond any pad's contacts.
_THINNEST, _FIRST, _PER_DIAGONAL = -1.5, 0.5, 4.0
# Points along a taxel's side, and when to stop, where thicknesses are compared.
_COARSE, _ENOUGH = 4, 1e-3
# A layer is tried further where it leaves less than this share of what springs leave.
_WORTH = 0.97
# The logarithm of the thickness is looked for so long, with others so far on both sides, until it is so near.
_ROUNDS, _BESIDE, _NEAR = 4, 0.3, 0.03
# It is known no better than so: rubbers differ in Poisson's ratio, and tables are of layers that are pressed little.
_LEAST_ERROR = 0.05


@dataclasses.dataclass(frozen=True)
class Thickness:
    """How thick a layer is, and its standard error, metres."""

    metres: float
    error: float


def tells_thickness(given: Observations) -> bool:
    """Return whether presses tell a layer from a response: where round and flat things pressed."""
    return len({one.object.curved for one in given.observed}) == 2


def has_floor(cover: Cover) -> bool:
    """Return whether a cover is a layer whose floor is felt: no thicker than the pad is long."""
    return isinstance(cover, Elastic) and cover.thickness_m < cover.pad_m


def likeliest_layer(given: Observations, family: Family) -> Elastic | None:
    """Return the layer that explains presses best; None where springs do nearly as well.

    Parameters
    ----------
    given : Observations
        On springs.
    family : Family
        The response behind it.
    """
    coarse = dataclasses.replace(given, points=dataclasses.replace(given.points, per_taxel=_COARSE))
    # A dead band is one constant more, as a thickness is.
    springs = fitted(family, coarse, enough=_ENOUGH)
    fits: dict[float, Fit] = {}

    def left(step: float) -> float:
        if step not in fits:
            near = min(fits, key=lambda other: abs(other - step)) if fits else None
            fits[step] = fitted(
                family,
                coarse.under(_layer(given, step)),
                places=springs.places if near is None else fits[near].places,
                dead=False,
                enough=_ENOUGH,
            )
        return float(fits[step].cost.mean())

    highest = _FIRST + np.ceil(np.log2(_PER_DIAGONAL * given.points.diagonal_m / _pitch(given)) - _FIRST)
    best = _FIRST
    for way in (1, -1):
        while _THINNEST < best + way <= highest and left(best + way) < left(best):
            best += way
    if best < highest:
        best += _turning_point(left(max(best - 1, _THINNEST)), left(best), left(best + 1))
    if left(best) > _WORTH**2 * springs.cost.mean():
        return None
    return _layer(given, best)


def thickness_of(explanation: Explanation, given: Observations) -> tuple[Thickness, Explanation, Observations]:
    """Return how thick the layer of an explanation is, the explanation by it, and the presses under it.

    The errors of what is explained count the thickness's.

    Parameters
    ----------
    explanation : Explanation
        By an elastic layer of about that thickness.
    given : Observations
        The presses, under that layer.
    """
    fit = explanation.fit

    def under(factor: float) -> tuple[Observations, Fit]:
        cover = given.points.cover
        assert isinstance(cover, Elastic)
        thicker = given.under(dataclasses.replace(cover, thickness_m=cover.thickness_m * factor))
        found = fitted(explanation.family, thicker, places=fit.places, constants=fit.constants, dead=explanation.dead)
        return thicker, found

    for _ in range(_ROUNDS):
        beside = [under(float(np.exp(way * _BESIDE)))[1] for way in (-1, 1)]
        curves = np.stack([each.cost for each in (beside[0], fit, beside[1])])
        move = _BESIDE * _turning_point(*curves.sum(axis=1))
        if abs(move) < _NEAR:
            break
        given, fit = under(float(np.exp(move)))
    cover, n = given.points.cover, curves.shape[1]
    assert isinstance(cover, Elastic)
    without = np.array([_BESIDE * _turning_point(*(curves.sum(axis=1) - curves[:, k])) for k in range(n)])
    log_error = float(np.hypot(_LEAST_ERROR, np.sqrt((n - 1) / n * np.sum((without - without.mean()) ** 2))))
    slopes = (beside[1].constants - beside[0].constants) / (2 * _BESIDE)
    surer = dataclasses.replace(explanation, fit=fit, error=np.hypot(explanation.error, slopes * log_error))
    return Thickness(cover.thickness_m, cover.thickness_m * log_error), surer, given


def _layer(given: Observations, step: float) -> Elastic:
    return Elastic(_pitch(given) * 2.0**step, POISSON, given.points.diagonal_m)


def _pitch(given: Observations) -> float:
    return float(np.sqrt(np.prod(given.points.pitch_m)))


def _turning_point(before: float, here: float, after: float) -> float:
    """Return where a parabola through three costs an even step apart is lowest, in steps; not beyond them."""
    bend = before - 2 * here + after
    if bend <= 0:
        return float(np.argmin([before, here, after])) - 1
    return float(np.clip(0.5 * (before - after) / bend, -1, 1))
