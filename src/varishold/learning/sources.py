"""Sources of evidence about a press, what is learned from each, and how they are weighed.

Touch is one source; joint angles, switches and forces are another. Each has a discriminant of its own, and their
scores are added with weights: in one learner the many measures of touch would drown the few angles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import Discriminant, discriminants, landmark_rows, learn_scaling
from varishold.trust import Calibration, calibrate

__all__ = ["Learned", "learn", "with_class"]

Floats = NDArray[np.float64]

# Settings that cross-validation chooses from: the kernel's width, and how far the scatter is shrunk.
_WIDTHS = (2.0, 4.0, 8.0, 16.0)
_SHRINKAGES = (0.05, 0.1, 0.2, 0.4)
# Of settings whose log loss is within this of the least, the smoothest is taken.
_AS_GOOD = 0.01
# Weights of a second source beside the first.
_WEIGHTS = (0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5, 5.0, 10.0)
# What is more strange than all but this share of known presses, in either way, is as strange as the other way's.
_TYPICAL = 0.9


@dataclass(frozen=True, eq=False)
class Learned:
    """What was learned from all sources together.

    Parameters
    ----------
    sources : mapping of str to Discriminant
    weights : mapping of str to float
        What each source's scores are multiplied by.
    calibration : Calibration
        From weighted scores to probabilities.
    typical : mapping of str to ndarray of shape (2,)
        For each source the two kinds of strangeness that a tenth of known presses exceed.
    known : ndarray of shape (n,), float64
        How strange training presses were when they were held out.
    loss : float
        Log loss of held-out presses, nats.
    landmark_codes : ndarray of shape (n_landmarks,), int
        The class of each landmark.
    """

    sources: Mapping[str, Discriminant]
    weights: Mapping[str, float]
    calibration: Calibration
    typical: Mapping[str, Floats]
    known: Floats
    loss: float
    landmark_codes: NDArray[np.intp]

    def scaled(self, measures: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the standardized measures of each source."""
        return {name: source.scaling.apply(measures[name]) for name, source in self.sources.items()}

    def judge(self, scaled: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """Return the weighted scores, shape (n, n_classes), and how strange each press is, shape (n,)."""
        judged = {name: source.judge(scaled[name]) for name, source in self.sources.items()}
        scores = sum(self.weights[name] * judged[name][0] for name in judged)
        return np.asarray(scores), _strangeness({name: judged[name][1] for name in judged}, self.typical)


def learn(
    measures: Mapping[str, Floats],
    codes: NDArray[np.intp],
    n_classes: int,
    fold: NDArray[np.intp],
    *,
    asked: NDArray[np.bool_],
    tick: Callable[[], object] = lambda: None,
) -> tuple[Learned, NDArray[np.intp]]:
    """Learn from measures, every setting chosen and every probability calibrated on held-out folds.

    Parameters
    ----------
    measures : mapping of str to ndarray of shape (n, n_measures), float64
        Of each source; NaN where unknown.
    codes : ndarray of shape (n,), int
        The class of each press.
    n_classes : int
    fold : ndarray of shape (n,), int
        Which presses are held out together.
    asked : ndarray of shape (n,), bool
        Which presses settings are chosen and probabilities calibrated on, when they are held out.
    tick : callable
        Called after each setting that was tried.

    Returns
    -------
    learned : Learned
    rows : ndarray of shape (n_landmarks,), int
        Which presses are landmarks.
    """
    chosen = {name: _chosen(values, codes, n_classes, fold, asked, tick) for name, values in measures.items()}
    scores = {name: held[0] for name, (_, held) in chosen.items()}
    truth = codes[asked]
    weights = _weights(scores, truth)
    together = np.asarray(sum(weights[name] * scores[name] for name in scores))
    calibration = calibrate(together, truth)
    strange = {name: held[1] for name, (_, held) in chosen.items()}
    typical = {name: np.maximum(np.quantile(of, _TYPICAL, axis=0), 1e-12) for name, of in strange.items()}
    sources = {}
    rows = landmark_rows(codes, _most_measures(measures))
    for name, ((width, shrinkage), _) in chosen.items():
        scaling = learn_scaling(measures[name])
        scaled = scaling.apply(measures[name])
        (sources[name],) = discriminants(scaled, codes, n_classes, width, [shrinkage], scaling, rows)
    known = _strangeness(strange, typical)
    loss = _log_loss(together, truth, calibration)
    return Learned(sources, weights, calibration, typical, known, loss, codes[rows]), rows


def with_class(learned: Learned, added: Mapping[str, Floats], place: int) -> tuple[Learned, NDArray[np.intp]]:
    """Add presses of one more class; every setting and the calibration stay.

    Parameters
    ----------
    learned : Learned
    added : mapping of str to ndarray of shape (n_added, n_measures), float64
        Standardized measures of each source.
    place : int
        The number of the new class among all.

    Returns
    -------
    learned : Learned
    rows : ndarray of int
        Which of the old landmarks and what was added are landmarks now.
    """
    landmark_codes = learned.landmark_codes
    n_added = len(next(iter(added.values())))
    n_classes = int(landmark_codes.max()) + 2
    codes = np.concatenate([landmark_codes + (landmark_codes >= place), np.full(n_added, place)])
    scaled = {name: np.concatenate([source.landmarks, added[name]]) for name, source in learned.sources.items()}

    most = _most_measures(scaled)

    def solved(chosen: NDArray[np.bool_]) -> dict[str, Discriminant]:
        return {
            name: discriminants(
                scaled[name][chosen],
                codes[chosen],
                n_classes,
                source.width,
                [source.shrinkage],
                source.scaling,
                landmark_rows(codes[chosen], most),
            )[0]
            for name, source in learned.sources.items()
        }

    held = np.full(len(codes), -1)
    held[len(landmark_codes) :] = np.arange(n_added) * min(5, n_added) // n_added
    strange = []
    for k in range(min(5, n_added)):
        without = replace(learned, sources=solved(held != k))
        strange.append(without.judge({name: of[held == k] for name, of in scaled.items()})[1])
    known = np.concatenate([learned.known, *strange])
    rows = landmark_rows(codes, most)
    everything = solved(np.ones(len(codes), np.bool_))
    return replace(learned, sources=everything, known=known, landmark_codes=codes[rows]), rows


def _most_measures(measures: Mapping[str, Floats]) -> int:
    return max(int(values.shape[1]) for values in measures.values())


def _chosen(
    values: Floats,
    codes: NDArray[np.intp],
    n_classes: int,
    fold: NDArray[np.intp],
    asked: NDArray[np.bool_],
    tick: Callable[[], object],
) -> tuple[tuple[float, float], tuple[Floats, Floats]]:
    """Return the settings of least loss on held-out folds, and what was said there."""
    tried: dict[tuple[float, float], tuple[Floats, Floats]] = {}
    losses: dict[tuple[float, float], float] = {}
    for width in _WIDTHS:
        held = {s: (np.full((len(codes), n_classes), -np.inf), np.zeros((len(codes), 2))) for s in _SHRINKAGES}
        for k in np.unique(fold):
            train, test = fold != k, fold == k
            there, inner = np.unique(codes[train], return_inverse=True)
            scaling = learn_scaling(values[train])
            rows = landmark_rows(inner, values.shape[1])
            learned = discriminants(scaling.apply(values[train]), inner, len(there), width, _SHRINKAGES, scaling, rows)
            scaled = scaling.apply(values[test])
            for shrinkage, one in zip(_SHRINKAGES, learned, strict=True):
                said, strange = one.judge(scaled)
                held[shrinkage][0][np.ix_(test, there)] = said
                held[shrinkage][1][test] = strange
        for shrinkage, found in held.items():
            said, strange = found[0][asked], found[1][asked]
            tried[width, shrinkage] = said, strange
            losses[width, shrinkage] = _log_loss(said, codes[asked], calibrate(said, codes[asked]))
        tick()
    limit = min(losses.values()) + _AS_GOOD
    best = max(setting for setting, loss in losses.items() if loss <= limit)
    return best, tried[best]


def _weights(scores: Mapping[str, Floats], codes: NDArray[np.intp]) -> dict[str, float]:
    """Return the weights of least log loss; the first source's is 1."""
    names = list(scores)
    losses = {}
    for others in product(_WEIGHTS, repeat=len(names) - 1):
        weights = dict(zip(names, (1.0, *others), strict=True))
        together = np.asarray(sum(weights[name] * scores[name] for name in names))
        losses[others] = _log_loss(together, codes, calibrate(together, codes)) if others else 0.0
    return dict(zip(names, (1.0, *min(losses, key=lambda others: losses[others])), strict=True))


def _log_loss(scores: Floats, codes: NDArray[np.intp], calibration: Calibration) -> float:
    of = calibration.probabilities(scores)[np.arange(len(codes)), codes]
    return float(-np.log(of).mean())


def _strangeness(strange: Mapping[str, Floats], typical: Mapping[str, Floats]) -> Floats:
    """Return one number a press: the larger of both kinds, each beside what is typical, over all sources."""
    return np.asarray(np.max([(strange[name] / typical[name]).max(axis=1) for name in strange], axis=0))
