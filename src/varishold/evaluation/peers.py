"""Plain peers: what anybody would try first, on the same folds and presses, settings chosen as honestly as ours."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.features import FEATURES, feature_table, pooled_frames
from varishold.evaluation.held_out import Felt, Part, one_thread
from varishold.evaluation.splits import Split, usable_groups
from varishold.files.crew import Worker, shared
from varishold.touch.course.measures import learn_settings
from varishold.trust import group_folds

__all__ = ["LEARNERS", "N_PEERS", "Peer", "all_peers", "answer_peers"]

Floats = NDArray[np.float64]

# Folds of the cross-validation that chooses a peer's settings.
_INNER_FOLDS = 3
_TREES = 200


@dataclass(frozen=True)
class Peer:
    """Features and a learner.

    Parameters
    ----------
    features : str
        One of `FEATURES`.
    learner : str
        A key of `LEARNERS`.
    """

    features: str
    learner: str


@dataclass(frozen=True)
class _Setting:
    """One setting of a learner: whether features are standardized, and what makes it from a seed and n presses."""

    standardized: bool
    make: Callable[[int, int], Any]


def _neighbours(k: int, standardized: bool) -> _Setting:
    def make(seed: int, n: int) -> Any:
        from sklearn.neighbors import KNeighborsClassifier

        return KNeighborsClassifier(min(k, n), weights="distance")

    return _Setting(standardized, make)


def _trees(kind: str) -> _Setting:
    def make(seed: int, n: int) -> Any:
        from sklearn import ensemble

        return getattr(ensemble, kind)(_TREES, random_state=seed)

    return _Setting(False, make)


def _logistic(strength: float) -> _Setting:
    def make(seed: int, n: int) -> Any:
        from sklearn.linear_model import LogisticRegression

        return LogisticRegression(C=strength, max_iter=300, tol=1e-3)

    return _Setting(True, make)


#: The learners, each with the settings that cross-validation chooses from; of equally good ones the first is taken.
LEARNERS: Mapping[str, tuple[_Setting, ...]] = {
    "nearest neighbour": tuple(_neighbours(k, standardized) for standardized in (False, True) for k in (1, 3, 5)),
    "forest": (_trees("ExtraTreesClassifier"), _trees("RandomForestClassifier")),
    "logistic regression": tuple(_logistic(strength) for strength in (0.01, 0.1, 1.0, 10.0, 100.0)),
}
#: How many peers there are.
N_PEERS = len(FEATURES) * len(LEARNERS)


def all_peers() -> tuple[Peer, ...]:
    """Return every peer."""
    return tuple(Peer(features, learner) for features in FEATURES for learner in LEARNERS)


def answer_peers(
    peers: Sequence[Peer],
    felt: Felt,
    split: Split,
    *,
    seed: int,
    chosen: Sequence[NDArray[np.intp]] | None = None,
    crew: Sequence[Worker] = (),
    tick: Callable[[], object] = lambda: None,
) -> list[Floats]:
    """Let peers learn without each fold in turn, and answer it.

    Parameters
    ----------
    peers : sequence of Peer
    felt : Felt
    split : Split
    seed : int
    chosen : sequence of ndarray of int, optional
        Of each fold the presses to learn from. Default: all that are not held out.
    crew : sequence of Worker
        Those who share the folds; nobody for this process.
    tick : callable
        Called after each peer and fold.

    Returns
    -------
    list of ndarray of shape (n, n_classes), float64
        Of each peer; 0 where a class was not known.
    """
    said = [np.zeros((len(felt.codes), len(felt.classes))) for _ in peers]
    parts = [(train if chosen is None else chosen[k], test) for k, (train, test) in enumerate(split.parts())]
    parts = [(rows, test) for rows, test in parts if len(np.unique(felt.codes[rows])) >= 2]
    answered = shared(_AnswerFold(tuple(peers), felt, seed), parts, crew)
    for (_, test), told in zip(parts, answered, strict=True):
        for one, (probabilities, classes) in zip(said, told, strict=True):
            one[np.ix_(test, classes)] = probabilities
            tick()
    return said


@dataclass(frozen=True)
class _AnswerFold:
    """Lets peers learn from some presses, and answer others; sent to other processes."""

    peers: tuple[Peer, ...]
    felt: Felt
    seed: int

    def __call__(self, part: Part) -> list[tuple[Floats, NDArray[np.intp]]]:
        rows, test = part
        felt = self.felt
        columns = sorted({name for press in felt.presses for name in press.columns})
        both = [felt.presses[k] for k in (*rows, *test)]
        with one_thread():
            settings = learn_settings(both[: len(rows)], position=True, absolute=True)
            pooled = pooled_frames(both, settings.shapes, settings.floor)
            tables = {kind: feature_table(kind, pooled, both, columns, settings.floor) for kind in FEATURES}
            known = {kind: _known(table, len(rows)) for kind, table in tables.items()}
            fold = _inner_folds(felt, rows)
            return [
                _learn_and_answer(
                    LEARNERS[peer.learner],
                    known[peer.features][: len(rows)],
                    felt.codes[rows],
                    known[peer.features][len(rows) :],
                    fold,
                    self.seed,
                )
                for peer in self.peers
            ]


def _inner_folds(felt: Felt, rows: NDArray[np.intp]) -> NDArray[np.intp] | None:
    """Return the folds that choose settings, groups kept together where they can be; None where presses are too few."""
    codes = felt.codes[rows]
    if np.bincount(codes)[np.unique(codes)].min() < 2:
        return None
    groups = usable_groups(None if felt.groups is None else felt.groups[rows], codes)
    return group_folds(codes, groups, folds=_INNER_FOLDS)


def _known(table: Floats, n_train: int) -> Floats:
    """Return features with what is not known at the mean of the training presses."""
    known = np.isfinite(table)
    count = np.maximum(known[:n_train].sum(axis=0), 1)
    mean = np.where(known[:n_train], table[:n_train], 0.0).sum(axis=0) / count
    return np.where(known, table, mean)


def _learn_and_answer(
    settings: Sequence[_Setting],
    train: Floats,
    codes: NDArray[np.intp],
    test: Floats,
    fold: NDArray[np.intp] | None,
    seed: int,
) -> tuple[Floats, NDArray[np.intp]]:
    """Choose the setting that names most held-out presses, learn, and answer."""
    best = settings[0]
    if fold is not None:
        shares = []
        for setting in settings:
            hits = 0
            for k in np.unique(fold):
                inside = fold != k
                told, classes = _fitted(setting, train[inside], codes[inside], train[~inside], seed)
                hits += int((classes[told.argmax(axis=1)] == codes[~inside]).sum())
            shares.append(hits)
        best = settings[int(np.argmax(shares))]
    return _fitted(best, train, codes, test, seed)


def _fitted(
    setting: _Setting, train: Floats, codes: NDArray[np.intp], test: Floats, seed: int
) -> tuple[Floats, NDArray[np.intp]]:
    if setting.standardized:
        mean, spread = train.mean(axis=0), train.std(axis=0)
        scale = np.where(spread > 1e-9 * (1 + np.abs(mean)), 1 / np.where(spread > 0, spread, 1.0), 0.0)
        train, test = (train - mean) * scale, (test - mean) * scale
    model = setting.make(seed, len(train))
    with warnings.catch_warnings():
        # That a search stopped early, or that there are nearly as many classes as presses, changes nothing here.
        warnings.simplefilter("ignore", UserWarning)
        model.fit(train, codes)
    return np.asarray(model.predict_proba(test)), np.asarray(model.classes_)
