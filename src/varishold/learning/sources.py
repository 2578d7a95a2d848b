"""Sources of evidence about a press, what is learned from each, and how they are weighed.

Touch is one source; joint angles, switches and forces are another. Each has a discriminant of its own, and what they
say is fused late: in one learner the many measures of touch would drown the few angles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import Discriminant, discriminants, distances, landmark_rows, learn_scaling
from varishold.trust import SourceWeights, calibrate, choose_weights, fuse

__all__ = ["Learned", "Source", "learn", "with_class"]

Floats = NDArray[np.float64]

# Settings that cross-validation chooses from: the kernel's width, and how far the scatter is shrunk.
_WIDTHS = (1.0, 2.0, 4.0, 8.0, 16.0)
_SHRINKAGES = (0.05, 0.1, 0.2, 0.4)
# Of settings whose log loss is within this of the least, the smoothest is taken.
_AS_GOOD = 0.01
# Up to so many measures are few: their differences are squared.
_FEW = 30
# What is more strange than all but this share of known presses, in either way, is as strange as the other way's.
_TYPICAL = 0.9


@dataclass(frozen=True, eq=False)
class Source:
    """What was learned from one source.

    Parameters
    ----------
    discriminant : Discriminant
    temperature : float
        What its scores are divided by before they are log-probabilities.
    typical : ndarray of shape (2,), float64
        The two kinds of strangeness that a tenth of known presses exceed.
    """

    discriminant: Discriminant
    temperature: float
    typical: Floats


@dataclass(frozen=True, eq=False)
class Learned:
    """What was learned from all sources together.

    Parameters
    ----------
    sources : mapping of str to Source
    trust : SourceWeights
        How far each source is believed when they are fused.
    known : ndarray of shape (n,), float64
        How strange training presses were when they were held out.
    loss : float
        Log loss of held-out presses, nats.
    landmark_codes : ndarray of shape (n_landmarks,), int
        The class of each landmark.
    drift : mapping of str to ndarray of shape (n_measures,), float64
        By how much standardized measures are known to have shifted since, of each source; empty where nothing is known.
    """

    sources: Mapping[str, Source]
    trust: SourceWeights
    known: Floats
    loss: float
    landmark_codes: NDArray[np.intp]
    drift: Mapping[str, Floats] = field(default_factory=dict)

    def scaled(self, measures: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the standardized measures of each source, less their drift; NaN where it says nothing of a press."""
        return {
            name: source.discriminant.scaling.apply(measures[name], self.drift.get(name, 0.0))
            for name, source in self.sources.items()
        }

    def judge(self, scaled: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """Return log-probabilities, shape (n, n_classes), and how strange each press is, shape (n,)."""
        judged = {name: source.discriminant.judge(scaled[name]) for name, source in self.sources.items()}
        said = {name: judged[name][0] / source.temperature for name, source in self.sources.items()}
        strange = {name: judged[name][1] / source.typical for name, source in self.sources.items()}
        return fuse(said, self.trust), _strangeness(strange)


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
    truth = codes[asked]
    said, strange, typical = {}, {}, {}
    temperatures = {}
    for name, (_, (scores, strangeness)) in chosen.items():
        temperatures[name] = calibrate(scores, truth).temperature
        # A fold that did not know the class says nothing about it.
        unknown = np.isneginf(scores[np.arange(len(truth)), truth])[:, None]
        said[name] = np.where(unknown, np.nan, scores / temperatures[name])
        typical[name] = np.maximum(np.quantile(strangeness, _TYPICAL, axis=0), 1e-12)
        strange[name] = strangeness / typical[name]
    trust = choose_weights(said, truth)
    sources = {}
    rows = landmark_rows(codes, _most_measures(measures))
    for name, ((width, shrinkage), _) in chosen.items():
        scaling = learn_scaling(measures[name])
        scaled, power = np.nan_to_num(scaling.apply(measures[name])), _power(measures[name])
        apart = distances(scaled, scaled[rows], power)
        (found,) = discriminants(scaled, apart, codes, n_classes, power, width, [shrinkage], scaling, rows)
        sources[name] = Source(found, temperatures[name], typical[name])
    loss = float(-fuse(said, trust)[np.arange(len(truth)), truth].mean())
    return Learned(sources, trust, _strangeness(strange), loss, codes[rows]), rows


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
    scaled = {
        name: np.concatenate([source.discriminant.landmarks, np.nan_to_num(added[name])])
        for name, source in learned.sources.items()
    }

    most = _most_measures(scaled)

    def solved(chosen: NDArray[np.bool_]) -> dict[str, Source]:
        rows = landmark_rows(codes[chosen], most)
        found = {}
        for name, source in learned.sources.items():
            old, of = source.discriminant, scaled[name][chosen]
            (new,) = discriminants(
                of,
                distances(of, of[rows], old.power),
                codes[chosen],
                n_classes,
                old.power,
                old.width,
                [old.shrinkage],
                old.scaling,
                rows,
            )
            found[name] = replace(source, discriminant=new)
        return found

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
    power = _power(values)
    settings = list(product(_WIDTHS, _SHRINKAGES))
    held = {of: (np.full((len(codes), n_classes), -np.inf), np.zeros((len(codes), 2))) for of in settings}
    for k in np.unique(fold):
        train, test = fold != k, fold == k
        there, inner = np.unique(codes[train], return_inverse=True)
        scaling = learn_scaling(values[train])
        rows = landmark_rows(inner, values.shape[1])
        known, new = (np.nan_to_num(scaling.apply(values[of])) for of in (train, test))
        between, apart = distances(known, known[rows], power), distances(new, known[rows], power)
        for width in _WIDTHS:
            learned = discriminants(known, between, inner, len(there), power, width, _SHRINKAGES, scaling, rows)
            for shrinkage, one in zip(_SHRINKAGES, learned, strict=True):
                said, strange = one.judge_apart(apart)
                held[width, shrinkage][0][np.ix_(test, there)] = said
                held[width, shrinkage][1][test] = strange
        tick()
    tried = {of: (said[asked], strange[asked]) for of, (said, strange) in held.items()}
    losses = {of: _log_loss(said, codes[asked]) for of, (said, _) in tried.items()}
    limit = min(losses.values()) + _AS_GOOD
    best = max(setting for setting, loss in losses.items() if loss <= limit)
    return best, tried[best]


def _power(values: Floats) -> int:
    return 2 if values.shape[1] <= _FEW else 1


def _log_loss(scores: Floats, codes: NDArray[np.intp]) -> float:
    """Return the log loss of held-out scores, as well as they can be calibrated."""
    of = calibrate(scores, codes).probabilities(scores)[np.arange(len(codes)), codes]
    return float(-np.log(of).mean())


def _strangeness(strange: Mapping[str, Floats]) -> Floats:
    """Return one number a press: the larger of both kinds, each beside what is typical, over all sources that speak."""
    return np.asarray(np.nanmax([of.max(axis=1) for of in strange.values()], axis=0))
