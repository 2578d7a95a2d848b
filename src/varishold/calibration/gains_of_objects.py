"""Gains from presses of known objects: what a taxel reads beside what it should, press after press."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.agreement import Agreement, agreement_of
from varishold.calibration.explanation import Family, Observations, best_fit
from varishold.calibration.press_fit import Fit
from varishold.calibration.result import error_of_spread

__all__ = ["ObjectGains", "gains_of_objects"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A taxel takes part in a press where that stands above this share of its peak, and above so many sigma; it is known
# by so many presses.
_INSIDE, _SIGMAS, _FEWEST = 0.2, 4.0, 2
# What a reading may be off besides noise: this share of it, and what comes of a place that is off by so many taxels.
_SHARE, _TAXELS = 0.02, 0.1
# Readings that are off by so many sigmas count half: a face is not quite as it was said to be.
_HALF = 2.0
_ROUNDS = 8
# What place, depth and blur take of the gains is alike in both halves of the presses: on drawn presses gains are off
# by so many times what the halves tell.
_ALIKE = 2.0


@dataclasses.dataclass(frozen=True, eq=False)
class ObjectGains:
    """Gains by presses of known objects.

    Parameters
    ----------
    log : ndarray of shape (rows, cols), float64
        Logarithms of the gains, 0 where none is known.
    error : ndarray of shape (rows, cols), float64
        Their standard errors; NaN where none is known.
    agreed : Agreement
        Of two halves of the presses: those of one object and those of the others, or every second one.
    """

    log: Floats
    error: Floats
    agreed: Agreement

    @property
    def known(self) -> Mask:
        """Which taxels were pressed often enough; shape (rows, cols)."""
        return np.isfinite(self.error)

    @property
    def spread_error(self) -> float:
        """Standard error of how far the gains spread."""
        return error_of_spread(self.agreed.spread, self.agreed.differ, self.log[self.known], self.error[self.known])

    @property
    def worth(self) -> bool:
        """Whether to even them out: presses of another object make gains too, which its errors are larger than."""
        return self.agreed.worth and self.agreed.spread > self.spread_error

    @property
    def refusal(self) -> str:
        """Why these gains were not applied."""
        if not self.agreed.worth:
            return self.agreed.refusal
        return (
            f"the gains were not applied: that they spread by {100 * self.agreed.spread:.2g} % may be off by "
            f"{100 * self.spread_error:.2g} %"
        )

    @property
    def map(self) -> Floats:
        """The gains, 1 for the usual taxel; shape (rows, cols)."""
        return np.where(self.known, np.exp(self.log - float(np.median(self.log[self.known]))), 1.0)


def gains_of_objects(given: Observations, family: Family) -> ObjectGains:
    """Return the gains, by what presses of known objects leave unexplained without them behind such a response.

    A press's place, turn and depth are fitted to all of its taxels, so that what one taxel reads beside them press
    after press is its own. A face that is not quite as it was said to be goes with the press, not with the taxel:
    where two objects tell the same gains, they are the taxels'. Once the gains are known to the fit, places are found
    better, and the gains once more.
    """
    fit, _ = best_fit(family, given)
    found = _found(given, family, fit)
    if not found.agreed.worth:
        return found
    even = given.with_gains(found.map, found.agreed.spread)
    fit, _ = best_fit(family, even)
    more = _found(even, family, fit)
    return dataclasses.replace(found, log=found.log + np.where(found.known, more.log, 0.0))


def _found(given: Observations, family: Family, fit: Fit) -> ObjectGains:
    """Return by how much taxels are off what they should read, by the sensor of the fit."""
    off, sigma = _beside(given, family, fit)
    first = _first_half(given)
    gain, error = _taxels(off, sigma)
    halves = [_taxels(off[half], sigma[half])[0] for half in (first, ~first)]
    both = np.isfinite(halves[0]) & np.isfinite(halves[1])
    one, other = (half[both] - (half[both].mean() if both.any() else 0.0) for half in halves)
    agreed = agreement_of(one, other)
    error = np.maximum(error, agreed.differ)
    # Gains scatter about 1 so far: what is known worse than that stays near it.
    drawn = gain / (1.0 + (error / max(agreed.spread, 1e-9)) ** 2)
    return ObjectGains(np.nan_to_num(drawn), _ALIKE * error, agreed)


def _first_half(given: Observations) -> Mask:
    """Return which presses are one half: those of the first object, or every second one where there is no other."""
    first = np.array([one.object == given.observed[0].object for one in given.observed])
    return np.arange(first.size) % 2 == 0 if first.all() else first


def _beside(given: Observations, family: Family, fit: Fit) -> tuple[Floats, Floats]:
    """Return the logarithm of each stress beside what it should be, and how far off it may be; NaN outside."""
    sensor, predicted = given.sensor(family, fit.constants), fit.predicted
    frames, noise = (np.array(each) for each in zip(*((one.frame, one.sigma) for one in given.observed), strict=True))
    noise = noise[:, None, None]
    top = predicted.max(axis=(1, 2), keepdims=True)
    inside = (predicted > _INSIDE * top) & (frames > _SIGMAS * noise) & given.usable
    read, due = (np.where(inside, each, sensor.span) for each in (frames, predicted))
    off = np.log(sensor.response.stress(read / sensor.span) / sensor.response.stress(due / sensor.span))
    steep = np.hypot(*np.gradient(np.log(np.maximum(predicted, np.maximum(_INSIDE / 4 * top, 1e-300))), axis=(1, 2)))
    sigma = np.sqrt(_SHARE**2 + (noise / read) ** 2 + (_TAXELS * steep) ** 2)
    return np.where(inside, off, np.nan), np.where(inside, sigma, np.nan)


def _taxels(off: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """Return each taxel's own part of what presses are off, about 0 on the mean, and its error; NaN where unknown."""
    there = np.isfinite(off)
    known = there.sum(axis=0) >= _FEWEST
    if not known.any():
        return np.full(known.shape, np.nan), np.full(known.shape, np.nan)
    off, plain = np.where(there, off, 0.0), np.where(there & known, 1.0 / np.where(there, sigma, 1.0) ** 2, 0.0)
    weight, press, scale = plain, np.zeros((len(off), 1, 1)), 1.0
    for _ in range(_ROUNDS):
        gain = (weight * (off - press)).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300)
        gain -= gain[known].mean()
        of_press = np.maximum(weight.sum(axis=(1, 2), keepdims=True), 1e-300)
        press = (weight * (off - gain)).sum(axis=(1, 2), keepdims=True) / of_press
        left = (off - gain - press) * np.sqrt(plain)
        scale = max(1.4826 * float(np.median(np.abs(left[plain > 0]))), 1e-12)
        weight = plain / (1.0 + (left / (_HALF * scale)) ** 2)
    # A taxel's own gain took one of its presses.
    count = np.maximum(there.sum(axis=0), _FEWEST)
    error = scale / np.sqrt(np.maximum(weight.sum(axis=0), 1e-300)) * np.sqrt(count / (count - 1))
    return np.where(known, gain, np.nan), np.where(known, error, np.nan)
