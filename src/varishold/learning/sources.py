"""Sources of evidence about a press, what is learned from each, and how they are weighed.

Touch is one source; joint angles, switches and forces are another. Each has discriminants of its own, one by absolute
and one by squared differences, and what they say is fused late: in one learner the many measures of touch would drown
the few angles, and two kernels err differently.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from varishold.learning.discriminant import (
    Discriminant,
    Scaling,
    discriminants,
    distances,
    landmark_rows,
    learn_scaling,
)
from varishold.learning.loss import mean_loss
from varishold.trust import SourceWeights, calibrate, choose_weights, class_weights, fuse

__all__ = ["FORMS_SHARE", "Learned", "Source", "View", "learn", "view_name", "with_class"]

Floats = NDArray[np.float64]

# Settings that cross-validation chooses from: the kernel's width, and how far the scatter is shrunk.
_WIDTHS = (1.0, 2.0, 4.0, 8.0, 16.0)
_SHRINKAGES = (0.05, 0.1, 0.2, 0.4)
# Of settings whose log loss is within this of the least, the smoothest is taken.
_AS_GOOD = 0.01
_POWERS = (1, 2)
#: What is learned of forms alone keeps this share of the numbers of a model.
FORMS_SHARE = 0.35
# What is typical of known presses: what this share of them does not exceed.
_TYPICAL = 0.9
# So many times as far from every training press as is typical is as strange as being typically far from every class.
_FAR = 2.0


@dataclass(frozen=True, eq=False)
class View:
    """What was learned from one source by differences of one power.

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
class Source:
    """What was learned from one source.

    Parameters
    ----------
    scaling : Scaling
    landmarks : ndarray of shape (n_landmarks, n_measures), float64
        Standardized measures that presses are compared with.
    views : tuple of View
        One for each power of differences.
    """

    scaling: Scaling
    landmarks: Floats
    views: tuple[View, ...]

    @cached_property
    def places(self) -> dict[int, Floats]:
        """Where the landmarks lie in each view, shape (n_landmarks, n_directions)."""
        return {
            view.discriminant.power: view.discriminant.coordinates(
                distances(self.landmarks, self.landmarks, view.discriminant.power)
            )
            for view in self.views
        }

    def judge(self, scaled: Floats) -> dict[int, tuple[Floats, Floats]]:
        """Return what each view says: log-probabilities less a constant, and strangeness beside what is typical."""
        judged = {}
        for view in self.views:
            power = view.discriminant.power
            scores, strange = view.discriminant.judge(distances(scaled, self.landmarks, power))
            judged[power] = scores / view.temperature, strange / view.typical
        return judged


def view_name(source: str, power: int) -> str:
    """Return how a view is called where views are fused."""
    return f"{source}.{power}"


@dataclass(frozen=True, eq=False)
class Learned:
    """What was learned from all sources together.

    Parameters
    ----------
    sources : mapping of str to Source
    trust : SourceWeights
        How far each view of each source is believed when they are fused.
    known : ndarray of shape (n,), float64
        How strange training presses were when they were held out.
    loss : float
        Log loss of held-out presses, nats.
    landmark_codes : ndarray of shape (n_landmarks,), int
        The class of each landmark.
    drift : mapping of str to ndarray of shape (n_measures,), float64
        By how much standardized measures are known to have shifted since, of each source; empty where nothing is known.
    forms : Learned or None
        What was learned of forms alone, from copies of the presses as another day may bring them: it judges whether
        something is known, and has a share of every answer. None: these sources do so themselves.
    """

    sources: Mapping[str, Source]
    trust: SourceWeights
    known: Floats
    loss: float
    landmark_codes: NDArray[np.intp]
    drift: Mapping[str, Floats] = field(default_factory=dict)
    forms: Learned | None = None

    def scaled(self, measures: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the standardized measures of each source, less their drift; NaN where it says nothing of a press."""
        return {
            name: source.scaling.apply(measures[name], self.drift.get(name, 0.0))
            for name, source in self.sources.items()
        }

    def judge(self, scaled: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """Return log-probabilities, shape (n, n_classes), and how strange each press is, shape (n,)."""
        judged = {name: source.judge(scaled[name]) for name, source in self.sources.items()}
        said = {view_name(name, power): view[0] for name, views in judged.items() for power, view in views.items()}
        strange = [[view[1] for view in views.values()] for views in judged.values()]
        return fuse(said, self.trust), _strangeness(strange)


def learn(
    measures: Mapping[str, Floats],
    codes: NDArray[np.intp],
    n_classes: int,
    fold: NDArray[np.intp],
    *,
    asked: NDArray[np.bool_],
    share: float = 1.0,
    tick: Callable[[], object] = lambda: None,
) -> tuple[Learned, NDArray[np.intp]]:
    """Learn from measures, every setting chosen and every probability calibrated on held-out folds.

    There a class counts as the root of how often it was pressed.

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
    share : float
        Of the numbers that a model may keep.
    tick : callable
        Called after each fold of each view.

    Returns
    -------
    learned : Learned
    rows : ndarray of shape (n_landmarks,), int
        Which presses are landmarks.
    """
    truth = codes[asked]
    counts = class_weights(truth)
    rows = landmark_rows(codes, _most_measures(measures), share)
    said, strange, sources = dict[str, Floats](), list[list[Floats]](), dict[str, Source]()
    for name, values in measures.items():
        scaling = learn_scaling(values)
        scaled = np.nan_to_num(scaling.apply(values))
        views = []
        strange.append([])
        for power in _POWERS:
            setting, (scores, strangeness) = _chosen(values, codes, n_classes, fold, asked, power, share, tick)
            temperature = calibrate(scores, truth, counts).temperature
            typical = np.maximum(np.quantile(strangeness, _TYPICAL, axis=0), 1e-12)
            # A fold that did not know the class says nothing about it.
            unknown = np.isneginf(scores[np.arange(len(truth)), truth])[:, None]
            said[view_name(name, power)] = np.where(unknown, np.nan, scores / temperature)
            strange[-1].append(strangeness / typical)
            apart = distances(scaled, scaled[rows], power)
            views.append(View(_solved(apart, rows, codes, n_classes, power, setting), temperature, typical))
        sources[name] = Source(scaling, scaled[rows], tuple(views))
    trust = choose_weights(said, truth, counts=counts)
    loss = mean_loss(fuse(said, trust), truth)
    return Learned(sources, trust, _strangeness(strange), loss, codes[rows]), rows


def with_class(
    learned: Learned, added: Mapping[str, Floats], place: int, share: float = 1.0, *, n_presses: int | None = None
) -> tuple[Learned, NDArray[np.intp], NDArray[np.intp]]:
    """Add presses of one more class; every setting and the calibration stay.

    Parameters
    ----------
    learned : Learned
    added : mapping of str to ndarray of shape (n_added, n_measures), float64
        Standardized measures of each source.
    place : int
        The number of the new class among all.
    share : float
        Of the numbers that a model may keep.
    n_presses : int, optional
        So many of what is added are presses, and the rest copies of them, all of them so many times. Default: all.

    Returns
    -------
    learned : Learned
    rows : ndarray of int
        Which of the old landmarks and what was added are landmarks now.
    named : ndarray of shape (n_presses,), int
        As which class each press is named when it is held out.
    """
    landmark_codes = learned.landmark_codes
    n_added = len(next(iter(added.values())))
    n_classes = int(landmark_codes.max()) + 2
    codes = np.concatenate([landmark_codes + (landmark_codes >= place), np.full(n_added, place)])
    scaled = {
        name: np.concatenate([source.landmarks, np.nan_to_num(added[name])]) for name, source in learned.sources.items()
    }

    most = _most_measures(scaled)

    def solved(chosen: NDArray[np.bool_]) -> dict[str, Source]:
        rows = landmark_rows(codes[chosen], most, share)
        found = {}
        for name, source in learned.sources.items():
            of = scaled[name][chosen]
            views = []
            for view in source.views:
                old = view.discriminant
                apart = distances(of, of[rows], old.power)
                setting = old.width, old.shrinkage
                new = _solved(apart, rows, codes[chosen], n_classes, old.power, setting)
                views.append(replace(view, discriminant=new))
            found[name] = Source(source.scaling, of[rows], tuple(views))
        return found

    n = n_added if n_presses is None else n_presses
    # Copies are held out with what they are copies of.
    held = np.full(len(codes), -1)
    held[len(landmark_codes) :] = (np.arange(n_added) % n) * min(5, n) // n
    asked = np.arange(len(codes)) < len(landmark_codes) + n
    judged = []
    for k in range(min(5, n)):
        without = replace(learned, sources=solved(held != k))
        judged.append(without.judge({name: of[asked & (held == k)] for name, of in scaled.items()}))
    known = np.concatenate([learned.known, *(strange for _, strange in judged)])
    named = np.concatenate([said.argmax(axis=1) for said, _ in judged])
    rows = landmark_rows(codes, most, share)
    everything = solved(np.ones(len(codes), np.bool_))
    return replace(learned, sources=everything, known=known, landmark_codes=codes[rows]), rows, named


def _most_measures(measures: Mapping[str, Floats]) -> int:
    return max(int(values.shape[1]) for values in measures.values())


def _solved(
    apart: Floats,
    rows: NDArray[np.intp],
    codes: NDArray[np.intp],
    n_classes: int,
    power: int,
    setting: tuple[float, float],
) -> Discriminant:
    width, shrinkage = setting
    return discriminants(apart, rows, codes, n_classes, power, width, [shrinkage])[0]


def _chosen(
    values: Floats,
    codes: NDArray[np.intp],
    n_classes: int,
    fold: NDArray[np.intp],
    asked: NDArray[np.bool_],
    power: int,
    share: float,
    tick: Callable[[], object],
) -> tuple[tuple[float, float], tuple[Floats, Floats]]:
    """Return the settings of least loss on held-out folds, and what was said there."""
    settings = list(product(_WIDTHS, _SHRINKAGES))
    truth, n_asked = codes[asked], int(np.count_nonzero(asked))
    held = {of: (np.full((n_asked, n_classes), -np.inf), np.zeros((n_asked, 2))) for of in settings}
    for k in np.unique(fold):
        # Of what is held out only what is asked is answered: with sessions a copy in six, without them five.
        train, test = fold != k, asked & (fold == k)
        at = np.flatnonzero(test[asked])
        there, inner = np.unique(codes[train], return_inverse=True)
        scaling = learn_scaling(values[train])
        rows = landmark_rows(inner, values.shape[1], share)
        known, new = (np.nan_to_num(scaling.apply(values[of])) for of in (train, test))
        between, apart = distances(known, known[rows], power), distances(new, known[rows], power)
        nearest = apart.min(axis=1)
        for width in _WIDTHS:
            learned = discriminants(between, rows, inner, len(there), power, width, _SHRINKAGES)
            alike = np.exp(-apart / width)
            for shrinkage, one in zip(_SHRINKAGES, learned, strict=True):
                said, strange = one.judge_alike(alike, nearest)
                held[width, shrinkage][0][np.ix_(at, there)] = said
                held[width, shrinkage][1][at] = strange
        tick()
    losses = {of: _log_loss(said, truth) for of, (said, _) in held.items()}
    limit = min(losses.values()) + _AS_GOOD
    best = max(setting for setting, loss in losses.items() if loss <= limit)
    return best, held[best]


def _log_loss(scores: Floats, codes: NDArray[np.intp]) -> float:
    """Return the log loss of held-out scores, as well as they can be calibrated."""
    return mean_loss(np.log(calibrate(scores, codes, class_weights(codes)).probabilities(scores)), codes)


def _strangeness(strange: Sequence[Sequence[Floats]]) -> Floats:
    """Return one number a press: how strange it is to the source that it is strangest to, of those that speak.

    That is its distance from the nearest class, the mean of what the views say, each beside what is typical. What is
    far from every training press lies where classes need not be far, and is strange by that. A press of which no source
    says anything is as strange as can be.
    """
    by_source = []
    for views in strange:
        from_class, from_press = np.moveaxis(np.stack(views), 2, 0)
        by_source.append(np.maximum(from_class.mean(axis=0), from_press.max(axis=0) / _FAR))
    found = np.fmax.reduce(by_source)
    return np.where(np.isnan(found), np.inf, found)
