"""Probabilities that are calibrated on held-out answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Calibration", "calibrate", "class_weights"]

Floats = NDArray[np.float64]

# Temperatures and shares of answers about nothing that are tried: so many temperatures an octave.
_TEMPERATURES = np.geomspace(0.25, 64.0, 65)
_OCTAVE = 8
_MIXING = np.array([0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2])
# Numbers that are worked on together: they stay in a processor's cache.
_TOGETHER = 1 << 15


@dataclass(frozen=True)
class Calibration:
    """From scores to probabilities.

    Parameters
    ----------
    temperature : float
        What scores are divided by before the exponential.
    mixing : float
        Share of answers that are about nothing: no class falls below so much of an even share.
    """

    temperature: float
    mixing: float

    def probabilities(self, scores: Floats) -> Floats:
        """Return the probability of each class, shape (n, n_classes), from scores of that shape."""
        scaled = scores / self.temperature
        shares = np.exp(scaled - scaled.max(axis=1, keepdims=True))
        shares /= shares.sum(axis=1, keepdims=True)
        return np.asarray((1 - self.mixing) * shares + self.mixing / scores.shape[1])


def class_weights(truth: NDArray[np.integer]) -> Floats:
    """Return by what things count so that a class counts as the root of how many are of it, shape (n,), 1 on the mean.

    How often somebody pressed a thing to have it learned says nothing of how often it will be met, and what is known
    from few presses is known worse: the mean over presses hides that. Were all classes to count alike, the few that
    are held out, learned from fewer still, would say too little of all.

    Examples
    --------
    >>> class_weights(np.array([0, 0, 0, 0, 1])).round(3).tolist()
    [0.833, 0.833, 0.833, 0.833, 1.667]
    """
    weights = 1.0 / np.sqrt(np.maximum(np.bincount(truth), 1))[truth]
    return np.asarray(weights / weights.mean()) if len(truth) else weights


def calibrate(scores: Floats, truth: NDArray[np.integer], counts: Floats | None = None) -> Calibration:
    """Return the calibration of least log loss on held-out answers; a plain one where no answer knew its class.

    Parameters
    ----------
    scores : ndarray of shape (n, n_classes), float64
        Of things that were not learned from; -inf where a fold did not know a class.
    truth : ndarray of shape (n,), int
        The class of each.
    counts : ndarray of shape (n,), float64, optional
        How much each counts, as `class_weights` gives it. Default: all alike.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> truth = rng.integers(0, 2, 4000)
    >>> scores = 10.0 * (np.eye(2)[truth] + rng.normal(0, 1, (4000, 2)))
    >>> found = calibrate(scores, truth)
    >>> bool(abs(found.probabilities(scores).max(axis=1).mean() - (scores.argmax(axis=1) == truth).mean()) < 0.02)
    True
    """
    known = np.isfinite(scores[np.arange(len(truth)), truth])
    scores, truth = scores[known], truth[known]
    counts = np.ones(len(truth)) if counts is None else counts[known]
    if not len(truth):
        return Calibration(1.0, 0.01)
    shares = _shares_of_truth(scores, truth)
    losses = [-counts @ np.log(_MIXING / scores.shape[1] + (1 - _MIXING) * one[:, np.newaxis]) for one in shares]
    temperature, mixing = np.unravel_index(int(np.argmin(losses)), (len(losses), len(_MIXING)))
    return Calibration(float(_TEMPERATURES[temperature]), float(_MIXING[mixing]))


def _shares_of_truth(scores: Floats, truth: NDArray[np.integer]) -> Floats:
    """Return the share of each answer's class at every temperature, shape (n_temperatures, n)."""
    shares = np.empty((len(_TEMPERATURES), len(truth)))
    together = max(1, _TOGETHER // scores.shape[1])
    for first in range(0, len(truth), together):
        rows = slice(first, first + together)
        below = scores[rows] - scores[rows].max(axis=1, keepdims=True)
        at = np.arange(len(below)), truth[rows]
        for hottest in range(len(_TEMPERATURES) - _OCTAVE, len(_TEMPERATURES)):
            odds = np.exp(below / _TEMPERATURES[hottest])
            for temperature in range(hottest, -1, -_OCTAVE):
                shares[temperature, rows] = odds[at] / odds.sum(axis=1)
                # At half the temperature odds are squared, which is quicker than another exponential.
                np.multiply(odds, odds, out=odds)
    return shares
