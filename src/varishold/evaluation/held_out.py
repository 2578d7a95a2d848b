"""Learning without what is held out, and answering it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.splits import Split, usable_groups
from varishold.learning import PressClassifier
from varishold.touch.course.presses import Press

__all__ = ["Felt", "Said", "Strangers", "answer_held_out", "answer_strangers", "learn_some", "n_strangers"]

Floats = NDArray[np.float64]

# Of so many things each is a stranger in turn; of more, a few are drawn.
_ALL_STRANGERS, _SOME_STRANGERS = 10, 5


@dataclass(frozen=True, eq=False)
class Felt:
    """Presses with what is known of them.

    Parameters
    ----------
    presses : sequence of Press
    codes : ndarray of shape (n,), int
        The class of each.
    classes : ndarray of shape (n_classes,), str
    groups : ndarray of shape (n,), str, optional
    """

    presses: Sequence[Press]
    codes: NDArray[np.intp]
    classes: NDArray[np.str_]
    groups: NDArray[np.str_] | None


@dataclass(frozen=True, eq=False)
class Said:
    """What was said of every press when it was held out.

    Parameters
    ----------
    probabilities : ndarray of shape (n, n_classes), float64
        0 where a class was not known.
    p_values : ndarray of shape (n,), float64
    chosen : mapping of int to mapping of str to values
        The parameters that were chosen for each fold, as `set_params` takes them.
    """

    probabilities: Floats
    p_values: Floats
    chosen: Mapping[int, Mapping[str, Any]]


@dataclass(frozen=True, eq=False)
class Strangers:
    """Presses of things that were left out of learning.

    Parameters
    ----------
    rows : ndarray of shape (n,), int
        Which presses.
    p_values : ndarray of shape (n,), float64
    classes : tuple of int
        The things that were left out, one at a time.
    """

    rows: NDArray[np.intp]
    p_values: Floats
    classes: tuple[int, ...]


def learn_some(classifier: PressClassifier, felt: Felt, rows: NDArray[np.intp]) -> PressClassifier:
    """Return a classifier that learned from some presses, in their order; groups are held out where they can be."""
    from sklearn.base import clone

    groups = usable_groups(None if felt.groups is None else felt.groups[rows], felt.codes[rows])
    learner: PressClassifier = clone(classifier)
    return learner.fit([felt.presses[k] for k in rows], felt.codes[rows], groups)


def answer_held_out(
    classifier: PressClassifier, felt: Felt, split: Split, *, tick: Callable[[], object] = lambda: None
) -> Said:
    """Learn without each fold in turn, and answer it."""
    chosen: dict[int, Mapping[str, Any]] = {}
    said = Said(np.zeros((len(felt.codes), len(felt.classes))), np.ones(len(felt.codes)), chosen)
    for train, test in split.parts():
        if len(np.unique(felt.codes[train])) < 2:
            continue
        learned = learn_some(classifier, felt, train)
        probabilities, said.p_values[test] = learned.judge([felt.presses[k] for k in test])
        said.probabilities[np.ix_(test, learned.classes_)] = probabilities
        chosen[int(split.fold[test[0]])] = learned.chosen_
        tick()
    return said


def answer_strangers(
    classifier: PressClassifier,
    felt: Felt,
    split: Split,
    chosen: Mapping[int, Mapping[str, Any]],
    *,
    seed: int,
    tick: Callable[[], object] = lambda: None,
) -> Strangers:
    """Leave things out of learning, one at a time, and answer their presses in a held-out fold.

    Of more than ten things five are drawn. Each is tested in one fold, so that it comes from where nothing was learned.
    What was chosen for the fold is taken over.
    """
    from sklearn.base import clone

    rng = np.random.default_rng((seed, 1))
    folds = np.unique(split.fold)
    rows: list[NDArray[np.intp]] = []
    p_values: list[Floats] = []
    left_out: list[int] = []
    for k, thing in enumerate(np.sort(rng.permutation(len(felt.classes))[: n_strangers(len(felt.classes))]).tolist()):
        mine = felt.codes == thing
        there = [int(fold) for fold in folds if (mine & (split.fold == fold)).any()]
        fold = there[k % len(there)]
        train = split.training(fold)
        train = train[felt.codes[train] != thing]
        if len(np.unique(felt.codes[train])) >= 2:
            asked = np.flatnonzero(mine & (split.fold == fold))
            learned = learn_some(clone(classifier).set_params(**chosen[fold]), felt, train)
            rows.append(asked)
            p_values.append(learned.p_values([felt.presses[int(row)] for row in asked]))
            left_out.append(thing)
        tick()
    together = np.concatenate(rows) if rows else np.zeros(0, np.intp)
    return Strangers(together, np.concatenate(p_values) if rows else np.zeros(0), tuple(left_out))


def n_strangers(n_classes: int) -> int:
    """Return how many things are left out in turn."""
    return n_classes if n_classes <= _ALL_STRANGERS else _SOME_STRANGERS
