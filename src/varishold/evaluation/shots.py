"""Shots curves: how many are right where only so many presses of each thing are learned from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.figures import Figure, share_figure
from varishold.evaluation.held_out import Felt, codes_of, learn_some, one_thread
from varishold.evaluation.peers import Peer, answer_peers
from varishold.evaluation.splits import FEWEST_PRESSES, Split
from varishold.files.crew import Worker, shared
from varishold.learning import PressClassifier

__all__ = ["SHOTS", "Shots", "draw_shots", "shots_curve"]

#: Presses a class of which curves are drawn.
SHOTS = (1, 2, 5, 10, 20)


@dataclass(frozen=True)
class Shots:
    """Shares right where so many presses of each thing are learned from.

    Parameters
    ----------
    presses : int
        Of each thing.
    right : Figure or None
        Of the classifier; None where these are too few for it.
    peer : Figure or None
        Of the best peer; None where no peers were asked for.
    """

    presses: int
    right: Figure | None
    peer: Figure | None

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        told = {
            name: None if one is None else one.to_dict() for name, one in (("right", self.right), ("peer", self.peer))
        }
        return {"presses": self.presses, **told}


def draw_shots(felt: Felt, split: Split, presses: int, *, seed: int) -> list[NDArray[np.intp]] | None:
    """Return for every fold so many training presses of each thing, drawn by chance; None where there are fewer."""
    rng = np.random.default_rng((seed, 2, presses))
    drawn = []
    for train, _ in split.parts():
        codes = felt.codes[train]
        mine = []
        for thing in np.unique(codes):
            of = train[codes == thing]
            if len(of) < presses:
                return None
            mine.append(np.sort(rng.permutation(of)[:presses]))
        drawn.append(np.sort(np.concatenate(mine)) if mine else train)
    return drawn


def shots_curve(
    classifier: PressClassifier,
    felt: Felt,
    split: Split,
    *,
    shots: Sequence[int] = SHOTS,
    peer: Peer | None = None,
    seed: int = 0,
    crew: Sequence[Worker] = (),
    tick: Callable[[], object] = lambda: None,
) -> tuple[Shots, ...]:
    """Return the curve, as far as there are so many presses of every thing in every fold."""
    found = []
    for point in shared(_Point(classifier, felt, split, peer, seed), shots, crew):
        if point is not None:
            found.append(point)
        tick()
    return tuple(found)


@dataclass(frozen=True)
class _Point:
    """Tells how many are right with so many presses of each thing; sent to other processes."""

    classifier: PressClassifier
    felt: Felt
    split: Split
    peer: Peer | None
    seed: int

    def __call__(self, presses: int) -> Shots | None:
        felt, split = self.felt, self.split
        drawn = draw_shots(felt, split, presses, seed=self.seed)
        if drawn is None:
            return None
        mine, theirs = None, None
        with one_thread():
            if presses >= FEWEST_PRESSES:
                mine = _right(_answers(self.classifier, felt, split, drawn), felt, split)
            if self.peer is not None:
                (said,) = answer_peers([self.peer], felt, split, seed=self.seed, chosen=drawn)
                theirs = _right(said, felt, split)
        return None if mine is None and theirs is None else Shots(presses, mine, theirs)


def _answers(
    classifier: PressClassifier, felt: Felt, split: Split, drawn: Sequence[NDArray[np.intp]]
) -> NDArray[np.float64]:
    said = np.zeros((len(felt.codes), len(felt.classes)))
    for rows, (_, test) in zip(drawn, split.parts(), strict=True):
        if len(np.unique(felt.codes[rows])) >= 2:
            learned = learn_some(classifier, felt, rows)
            said[np.ix_(test, codes_of(learned, felt))] = learned.predict_proba([felt.presses[k] for k in test])
    return said


def _right(said: NDArray[np.float64], felt: Felt, split: Split) -> Figure:
    known = split.known
    right = said.argmax(axis=1) == felt.codes
    return share_figure(right[known], None if felt.groups is None else felt.groups[known])
