"""The learner of what a controller can hold: of each pad a linear discriminant of the signature of its largest contact.

What the pads say is added up, as if each had felt the thing by itself; one temperature, chosen on held-out presses,
allows for what they say twice. How strange a press is, is how far its strangest pad is from all classes.

References
----------
J. Friedman, "Regularized discriminant analysis", 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import Scaling, learn_scaling, linear_discriminants, single
from varishold.learning.loss import mean_loss
from varishold.trust import Calibration

__all__ = ["LEAST_TYPICAL", "LearnedPads", "PadDiscriminant", "learn_pads", "refusal_limit"]

Floats = NDArray[np.float64]

# How far the scatter within classes is shrunk: cross-validation chooses.
_SHRINKAGES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7)
# Of settings whose log loss is within this of the least, the smoothest is taken.
_AS_GOOD = 0.01
# The distance that a tenth of known presses exceed is typical.
_TYPICAL = 0.9
#: No distance is typical that is less.
LEAST_TYPICAL = 1e-9
# How strange a press is that touches no pad: more than any other.
_UNTOUCHED = 1e9
# What scores are divided by: so much is tried.
_TEMPERATURES = np.geomspace(0.25, 1024.0, 73)
# A true class that was given no probability at all costs no more than this.
_LEAST = 1e-12


@dataclass(frozen=True, eq=False)
class PadDiscriminant:
    """What one pad's contacts tell.

    Parameters
    ----------
    scaling : Scaling
        Of a signature's numbers.
    directions : ndarray of shape (n_inputs, r), float64
        To coordinates along which every class scatters by 1.
    means : ndarray of shape (n_classes, r), float64
        Where the classes lie.
    typical : float
        The distance from the nearest class that a tenth of known presses exceed.
    """

    scaling: Scaling
    directions: Floats
    means: Floats
    typical: float = 1.0

    def coordinates(self, signatures: Floats) -> Floats:
        """Return where contacts lie, shape (n, r); NaN where there is none."""
        return np.asarray(self.scaling.apply(signatures) @ self.directions)

    def judge(self, signatures: Floats) -> tuple[Floats, Floats]:
        """Return scores of shape (n, n_classes) and distances of shape (n,) beside what is typical.

        Scores are 0, and distances NaN, where there is no contact.
        """
        at = self.coordinates(signatures)
        squared = (self.means * self.means).sum(axis=1)
        scores = at @ self.means.T - 0.5 * squared
        away = np.maximum((at * at).sum(axis=1) - 2 * scores.max(axis=1), 0.0)
        return np.nan_to_num(scores), np.sqrt(away) / self.typical


@dataclass(frozen=True, eq=False)
class LearnedPads:
    """What was learned of all pads.

    Parameters
    ----------
    pads : mapping of str to PadDiscriminant
        Those that were touched, by name.
    temperature : float
        What the sum of scores is divided by before the exponential.
    shrinkage : float
        How far the scatter within classes was drawn towards an even one.
    known : ndarray of shape (n,), float64
        How strange training presses were when they were held out.
    loss : float
        Log loss of held-out presses, nats.
    """

    pads: Mapping[str, PadDiscriminant]
    temperature: float
    shrinkage: float
    known: Floats
    loss: float

    def judge(self, signatures: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """Return scores of shape (n, n_classes), and how strange each press is, shape (n,)."""
        judged = [pad.judge(signatures[name]) for name, pad in self.pads.items()]
        return np.sum([scores for scores, _ in judged], axis=0), _strangest([away for _, away in judged])


def learn_pads(
    signatures: Mapping[str, Floats],
    codes: NDArray[np.intp],
    n_classes: int,
    fold: NDArray[np.intp],
    *,
    asked: NDArray[np.bool_],
    tick: Callable[[], object] = lambda: None,
) -> LearnedPads:
    """Learn from signatures, the shrinkage chosen and probabilities calibrated on held-out folds.

    Parameters
    ----------
    signatures : mapping of str to ndarray of shape (n, n_inputs), float64
        Of each pad that is touched at all; NaN where it is not.
    codes : ndarray of shape (n,), int
        The class of each press.
    n_classes : int
    fold : ndarray of shape (n,), int
        Which presses are held out together.
    asked : ndarray of shape (n,), bool
        Which presses the shrinkage is chosen and probabilities calibrated on, when they are held out.
    tick : callable
        Called after each fold.
    """
    scores = {shrinkage: np.full((len(codes), n_classes), -np.inf) for shrinkage in _SHRINKAGES}
    away = {shrinkage: {name: np.full(len(codes), np.nan) for name in signatures} for shrinkage in _SHRINKAGES}
    for k in np.unique(fold):
        test = fold == k
        there, inner = np.unique(codes[~test], return_inverse=True)
        for shrinkage in _SHRINKAGES:
            scores[shrinkage][np.ix_(test, there)] = 0.0
        for name, of in signatures.items():
            for shrinkage, one in zip(_SHRINKAGES, _solved(of[~test], inner, len(there)), strict=True):
                said, away[shrinkage][name][test] = one.judge(of[test])
                scores[shrinkage][np.ix_(test, there)] += said
        tick()
    truth = codes[asked]
    losses = {shrinkage: _calibrated(said[asked], truth) for shrinkage, said in scores.items()}
    limit = min(loss for _, loss in losses.values()) + _AS_GOOD
    best = max(shrinkage for shrinkage, (_, loss) in losses.items() if loss <= limit)
    typical = {name: _typical(of[asked]) for name, of in away[best].items()}
    pads = {
        name: replace(_solved(of, codes, n_classes)[_SHRINKAGES.index(best)], typical=typical[name])
        for name, of in signatures.items()
    }
    known = _strangest([of[asked] / typical[name] for name, of in away[best].items()])
    return LearnedPads(pads, losses[best][0], best, known, losses[best][1])


def refusal_limit(known: Floats, error: float) -> float:
    """Return how strange a press may be whose conformal p-value is above an error; infinite where none is refused."""
    most = np.flatnonzero((1 + np.arange(known.size)) / (1 + known.size) <= error)
    return float(-np.sort(-known)[most[-1]]) if most.size else np.inf


def _solved(signatures: Floats, codes: NDArray[np.intp], n_classes: int) -> list[PadDiscriminant]:
    """Return a discriminant for each shrinkage, learned from the contacts that there are."""
    scaling = learn_scaling(signatures)
    touched = np.isfinite(signatures).all(axis=1)
    if not touched.any():
        return [PadDiscriminant(scaling, np.zeros((signatures.shape[1], 1)), np.zeros((n_classes, 1)))] * len(
            _SHRINKAGES
        )
    found = linear_discriminants(scaling.apply(signatures[touched]), codes[touched], n_classes, _SHRINKAGES)
    return [PadDiscriminant(scaling, single(directions), single(means)) for directions, means in found]


def _calibrated(scores: Floats, truth: NDArray[np.intp]) -> tuple[float, float]:
    """Return the largest temperature of about the least log loss on held-out scores, and that loss in nats."""
    calibrations = [Calibration(temperature, 0.0) for temperature in _TEMPERATURES.tolist()]
    losses = [mean_loss(np.log(np.maximum(of.probabilities(scores), _LEAST)), truth) for of in calibrations]
    best = int(np.flatnonzero(np.array(losses) <= min(losses) + _AS_GOOD)[-1])
    return float(_TEMPERATURES[best]), losses[best]


def _typical(away: Floats) -> float:
    known = away[np.isfinite(away)]
    return max(float(np.quantile(known, _TYPICAL)), LEAST_TYPICAL) if known.size else 1.0


def _strangest(away: Sequence[Floats]) -> Floats:
    """Return the greatest distance over all pads that are touched."""
    greatest = np.max([np.where(np.isnan(of), -np.inf, of) for of in away], axis=0)
    return np.asarray(np.where(np.isneginf(greatest), _UNTOUCHED, greatest))
