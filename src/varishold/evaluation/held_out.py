"""Learning without what is held out, and answering it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.splits import Split, usable_groups
from varishold.files.crew import Worker, shared
from varishold.learning import PressClassifier
from varishold.touch.course.presses import Press

__all__ = [
    "Felt",
    "Said",
    "Strangers",
    "answer_held_out",
    "answer_strangers",
    "codes_of",
    "learn_some",
    "n_strangers",
    "one_thread",
]

Floats = NDArray[np.float64]
# Numbers of the presses to learn from, and of those to answer.
Part = tuple[NDArray[np.intp], NDArray[np.intp]]

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


@contextmanager
def one_thread() -> Iterator[None]:
    """Let no library use threads: for many small products they cost more than they bring, and may change a digit."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


def learn_some(classifier: PressClassifier, felt: Felt, rows: NDArray[np.intp]) -> PressClassifier:
    """Return a classifier that learned from some presses, in their order; groups are held out where they can be.

    It learns the things by their names, which its errors tell; `codes_of` numbers what it knows.
    """
    from sklearn.base import clone

    groups = usable_groups(None if felt.groups is None else felt.groups[rows], felt.codes[rows])
    learner: PressClassifier = clone(classifier)
    return learner.fit([felt.presses[k] for k in rows], felt.classes[felt.codes[rows]], groups)


def codes_of(learned: PressClassifier, felt: Felt) -> NDArray[np.intp]:
    """Return the number in `felt` of each class that a classifier has learned by `learn_some`."""
    return np.searchsorted(felt.classes, learned.classes_)


@dataclass(frozen=True)
class _Judge:
    """Learns from some presses, and answers others; sent to other processes."""

    classifier: PressClassifier
    felt: Felt

    def __call__(self, part: Part) -> tuple[NDArray[np.intp], Floats, Floats, Mapping[str, Any]]:
        train, test = part
        with one_thread():
            learned = learn_some(self.classifier, self.felt, train)
            said = learned.judge([self.felt.presses[k] for k in test])
            return codes_of(learned, self.felt), *said, learned.chosen_


def answer_held_out(
    classifier: PressClassifier,
    felt: Felt,
    split: Split,
    *,
    crew: Sequence[Worker] = (),
    tick: Callable[[], object] = lambda: None,
) -> Said:
    """Learn without each fold in turn, and answer it."""
    chosen: dict[int, Mapping[str, Any]] = {}
    said = Said(np.zeros((len(felt.codes), len(felt.classes))), np.ones(len(felt.codes)), chosen)
    parts = [(train, test) for train, test in split.parts() if len(np.unique(felt.codes[train])) >= 2]
    for (_, test), found in zip(parts, shared(_Judge(classifier, felt), parts, crew), strict=True):
        codes, probabilities, said.p_values[test], settings = found
        said.probabilities[np.ix_(test, codes)] = probabilities
        chosen[int(split.fold[test[0]])] = settings
        tick()
    return said


def answer_strangers(
    classifier: PressClassifier,
    felt: Felt,
    split: Split,
    chosen: Mapping[int, Mapping[str, Any]],
    *,
    seed: int,
    crew: Sequence[Worker] = (),
    tick: Callable[[], object] = lambda: None,
) -> Strangers:
    """Leave things out of learning, one at a time, and answer their presses in a held-out fold.

    Of more than ten things five are drawn. Each is tested in one fold, so that it comes from where nothing was learned.
    What was chosen for the fold is taken over.
    """
    rng = np.random.default_rng((seed, 1))
    folds = np.unique(split.fold)
    asked: list[_Asked] = []
    for k, thing in enumerate(np.sort(rng.permutation(len(felt.classes))[: n_strangers(len(felt.classes))]).tolist()):
        mine = felt.codes == thing
        there = [int(fold) for fold in folds if (mine & (split.fold == fold)).any()]
        fold = there[k % len(there)]
        train = split.training(fold)
        train = train[felt.codes[train] != thing]
        if len(np.unique(felt.codes[train])) >= 2:
            asked.append(_Asked(thing, train, np.flatnonzero(mine & (split.fold == fold)), chosen[fold]))
        else:
            tick()
    p_values = []
    for found in shared(_FindStrange(classifier, felt), asked, crew):
        p_values.append(found)
        tick()
    together = np.concatenate([each.rows for each in asked]) if asked else np.zeros(0, np.intp)
    things = tuple(each.thing for each in asked)
    return Strangers(together, np.concatenate(p_values) if asked else np.zeros(0), things)


class _Asked(NamedTuple):
    """A thing that is left out, the presses to learn from and to ask, and the settings that were chosen for them."""

    thing: int
    train: NDArray[np.intp]
    rows: NDArray[np.intp]
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class _FindStrange:
    """Learns without a thing, and says how strange its presses are; sent to other processes."""

    classifier: PressClassifier
    felt: Felt

    def __call__(self, asked: _Asked) -> Floats:
        from sklearn.base import clone

        with one_thread():
            learner = clone(self.classifier).set_params(**asked.settings)
            learned = learn_some(learner, self.felt, asked.train)
            return np.asarray(learned.p_values([self.felt.presses[int(row)] for row in asked.rows]))


def n_strangers(n_classes: int) -> int:
    """Return how many things are left out in turn."""
    return n_classes if n_classes <= _ALL_STRANGERS else _SOME_STRANGERS
