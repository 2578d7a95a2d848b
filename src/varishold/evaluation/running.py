"""The evaluation of what is learned: without each group in turn, beside peers, with its leaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold._name import refuse_name_of_strangers
from varishold.errors import InputError
from varishold.evaluation.figures import FEWEST_GROUPS, difference_figure, share_figure
from varishold.evaluation.held_out import (
    Felt,
    Said,
    Strangers,
    answer_held_out,
    answer_strangers,
    n_strangers,
    one_thread,
)
from varishold.evaluation.leaks import find_leaks
from varishold.evaluation.peers import N_PEERS, Peer, all_peers, answer_peers
from varishold.evaluation.result import Evaluation, PeerScore, StrangerScore
from varishold.evaluation.scores import Answers, Scores, score
from varishold.evaluation.shots import SHOTS, shots_curve
from varishold.evaluation.splits import Split, split_presses
from varishold.files.crew import Worker, crew_of
from varishold.learning import PressClassifier, TactileClassifier
from varishold.learning.checks import plain_names
from varishold.learning.training import named_alike, named_otherwise
from varishold.touch.course.one_sensor import of_one_sensor
from varishold.touch.course.presses import Press, as_presses, first_of_same, flat_presses, is_flat
from varishold.trust import first_without_name

__all__ = ["evaluate", "felt_presses", "interval_remarks"]

# Scikit-learn takes no larger one.
_LARGEST_SEED = 2**32 - 1

Floats = NDArray[np.float64]


def evaluate(
    X: Any,
    y: ArrayLike,
    groups: ArrayLike | None = None,
    *,
    runs: ArrayLike | None = None,
    classifier: PressClassifier | None = None,
    shots: Sequence[int] = SHOTS,
    peers: bool = True,
    strangers: bool = True,
    folds: int = 5,
    seed: int = 0,
    workers: int | AbstractContextManager[Sequence[Worker]] = 1,
    tick: Callable[..., object] = lambda **_: None,
) -> Evaluation:
    """Tell how well things are told apart where nothing of the session was learned from.

    Each group is held out once and the classifier learns from the others; without groups, blocks of presses that were
    made one after the other are held out, which flatters, and the leak is named.

    Parameters
    ----------
    X, y
        Presses and their labels, as for `TactileClassifier.fit`, in the order of recording.
    groups : array_like of shape (n,), optional
        The session of each press, or the sensor, object or size: whatever is to be new.
    runs : array_like of shape (n,), optional
        The recording that each press is from. Default: all are from one.
    classifier : PressClassifier, optional
        Whose options are taken; it is not changed. Default: all defaults.
    shots : sequence of int
        Numbers of presses a thing for the shots curve; empty for none.
    peers : bool
        Whether plain peers answer the same presses.
    strangers : bool
        Whether things are left out of learning, to see whether they are refused.
    folds : int, default 5
        Blocks where there are no groups.
    seed : int
        From 0 to 2**32 - 1. The same seed gives the same figures, however many work.
    workers : int or context manager
        So many processes of this machine, 1 for this one; or what gives workers.
    tick : callable
        Called with ``total=`` once, then with ``advance=1`` as the work goes on.

    Raises
    ------
    InputError
        Saying what is wrong with which press, label or group, and what to do.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.solids import Cone, SquarePillar, ideal_frame
    >>> rng = np.random.default_rng(0)
    >>> frames = [ideal_frame(s, (12, 12), 1.0) + rng.normal(0, 0.05, (12, 12))
    ...           for _ in range(12) for s in (Cone(8.0, 4.0), SquarePillar(6.0, 4.0))]
    >>> found = evaluate(np.array(frames), ["cone", "pillar"] * 12, np.repeat(["mon", "tue", "wed"], 8), peers=False)
    >>> found.scores.right.value, found.scores.right.over, found.leaks
    (1.0, 'groups', ())
    """
    learner = TactileClassifier() if classifier is None else classifier
    felt = felt_presses(X, y, groups, learner.shape)
    for name in felt.classes.tolist():
        refuse_name_of_strangers(name, parameter="label")
    in_run = np.zeros(len(felt.codes)) if runs is None else np.asarray(runs)
    if in_run.shape != felt.codes.shape:
        raise InputError(f"runs must be one a press, {len(felt.codes)} of them, got shape {in_run.shape}")
    _check_options(shots, seed, workers)
    split = split_presses(felt.classes[felt.codes], felt.groups, folds=folds)
    tick(total=split.n_folds * (1 + N_PEERS * peers) + strangers * n_strangers(len(felt.classes)) + 3 + len(shots))

    def step() -> None:
        tick(advance=1)

    with one_thread(), crew_of(workers) as crew:
        said = answer_held_out(learner, felt, split, crew=crew, tick=step)
        scores = _scores(said.probabilities, felt, split, said.p_values, learner.error)
        left_out = (
            answer_strangers(learner, felt, split, said.chosen, seed=seed, crew=crew, tick=step) if strangers else None
        )
        beside = _peer_scores(felt, split, said, seed, crew, step) if peers else ()
        leaks = find_leaks(felt, split, in_run, seed=seed, tick=step)
        best = Peer(beside[0].features, beside[0].learner) if beside else None
        curve = shots_curve(learner, felt, split, shots=shots, peer=best, seed=seed, crew=crew, tick=step)
    remarks = [*_split_remarks(felt, split), *interval_remarks(felt.groups)]
    if left_out is not None and not left_out.classes:
        remarks.append("there are too few things to leave one out of learning: no strangers were tried")
    remarks += [
        *_copies_remarks(felt.presses, split),
        *named_otherwise(felt.presses, felt.classes[felt.codes]),
        *named_alike(felt.classes),
    ]
    return Evaluation(
        tested="learned here",
        n_presses=len(felt.codes),
        things=tuple(felt.classes.tolist()),
        groups=() if felt.groups is None else tuple(np.unique(felt.groups).tolist()),
        split=split.kind,
        n_folds=split.n_folds,
        error=learner.error,
        scores=scores,
        strangers=_left_out(left_out, felt, split, said, learner.error),
        unheard=_unheard(felt, split, said, learner.error),
        peers=beside,
        shots=curve,
        leaks=leaks,
        remarks=tuple(remarks),
        seed=seed,
    )


def felt_presses(X: Any, y: ArrayLike, groups: ArrayLike | None, shape: tuple[int, ...] | None = None) -> Felt:
    """Return presses with their classes and groups as texts.

    Raises
    ------
    InputError
        If labels or groups are not one a press, or empty, or presses are of different sensors.
    """
    presses: list[Press] = flat_presses(np.asarray(X, np.float64), shape) if is_flat(X) else as_presses(X)
    if not presses:
        raise InputError("there is no press to be tested on")
    presses = of_one_sensor(presses)
    labels = _texts(y, len(presses), "y", "label")
    classes, codes = np.unique(labels, return_inverse=True)
    return Felt(presses, codes, classes, None if groups is None else _texts(groups, len(presses), "groups", "group"))


def interval_remarks(groups: NDArray[Any] | None) -> list[str]:
    """Return what is to be said of intervals where there are too few groups for them."""
    n = 0 if groups is None else len(np.unique(groups))
    if n >= FEWEST_GROUPS:
        return []
    have = "no groups are given" if groups is None else f"there {'is' if n == 1 else 'are'} {counted(n, 'group')} only"
    return [
        f"{have}: no interval over groups can be given ({FEWEST_GROUPS} are needed); intervals are over presses, "
        "and too narrow where presses of one session are alike"
    ]


def _texts(given: ArrayLike, n: int, what: str, parameter: str) -> NDArray[np.str_]:
    texts = np.char.strip(np.asarray(given).astype(np.str_))
    if texts.shape != (n,):
        raise InputError(f"{what} must be one a press, {n} of them, got shape {texts.shape}", parameter=parameter)
    empty = [*np.flatnonzero(texts == ""), first_without_name(given)]
    if empty[0] is not None:
        raise InputError(f"press {empty[0]} has no {parameter}; fill it in, or leave the press out")
    return plain_names(texts, parameter)


def _check_options(shots: Sequence[int], seed: int, workers: object) -> None:
    wrong = [one for one in shots if isinstance(one, bool) or not isinstance(one, (int, np.integer)) or one < 1]
    if wrong:
        raise InputError(f"shots must be whole numbers of presses a thing, at least 1, got {wrong[0]!r}")
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed <= _LARGEST_SEED:
        raise InputError(f"seed must be a whole number from 0 to {_LARGEST_SEED}, got {seed!r}", parameter="seed")
    if isinstance(workers, AbstractContextManager):
        return
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise InputError(f"workers must be a whole number, at least 1, got {workers!r}")


def _scores(probabilities: Floats, felt: Felt, split: Split, p_values: Floats, error: float) -> Scores:
    known = split.known
    return score(
        Answers(
            probabilities[known],
            felt.codes[known],
            p_values[known] <= error,
            None if felt.groups is None else felt.groups[known],
        )
    )


def _peer_scores(
    felt: Felt, split: Split, said: Said, seed: int, crew: Sequence[Worker], step: Callable[[], object]
) -> tuple[PeerScore, ...]:
    """Return what the peers got, the best first."""
    known, truth = split.known, felt.codes[split.known]
    groups = None if felt.groups is None else felt.groups[known]
    right = said.probabilities[known].argmax(axis=1) == truth
    found = []
    answered = answer_peers(all_peers(), felt, split, seed=seed, crew=crew, tick=step)
    for peer, told in zip(all_peers(), answered, strict=True):
        got = _scores(told, felt, split, np.ones(len(told)), 0.0)
        ahead = difference_figure(right, told[known].argmax(axis=1) == truth, groups)
        found.append(PeerScore(peer.features, peer.learner, got.right, got.log_loss, got.calibration_error, ahead))
    return tuple(sorted(found, key=lambda peer: (-peer.right.value, peer.log_loss.value)))


def _left_out(strangers: Strangers | None, felt: Felt, split: Split, said: Said, error: float) -> StrangerScore | None:
    if strangers is None or not strangers.classes:
        return None
    return stranger_score(
        strangers.p_values <= error,
        None if felt.groups is None else felt.groups[strangers.rows],
        (strangers.p_values, said.p_values[split.known], error),
        tuple(felt.classes[list(strangers.classes)].tolist()),
    )


def _unheard(felt: Felt, split: Split, said: Said, error: float) -> StrangerScore | None:
    """Return how presses fared whose thing was unknown, because all others of it were held out too."""
    rows = ~split.known & (said.probabilities.sum(axis=1) > 0)
    if not rows.any():
        return None
    groups = None if felt.groups is None else felt.groups[rows]
    things = tuple(felt.classes[np.unique(felt.codes[rows])].tolist())
    p_values = said.p_values[rows]
    return stranger_score(p_values <= error, groups, (p_values, said.p_values[split.known], error), things)


def stranger_score(
    refused: NDArray[np.bool_],
    groups: NDArray[Any] | None,
    strangeness: tuple[Floats, Floats, float] | None,
    things: tuple[str, ...],
) -> StrangerScore:
    """Return how presses of strangers fared.

    Parameters
    ----------
    refused : ndarray of shape (n,), bool
        Of the strangers, at least one.
    groups : ndarray of shape (n,), optional
    strangeness : (ndarray, ndarray, float), optional
        p-values of the strangers and of known presses, and the share of these that may be refused.
    things : tuple of str
    """
    alike = None
    if strangeness is not None and strangeness[1].size:
        p_values, known, error = strangeness
        alike = float((p_values <= np.quantile(known, error)).mean())
    return StrangerScore(share_figure(refused, groups), alike, things)


def _split_remarks(felt: Felt, split: Split) -> list[str]:
    remarks = []
    n_groups = 0 if felt.groups is None else len(np.unique(felt.groups))
    if n_groups > split.n_folds:
        remarks.append(f"{n_groups} groups were held out several at a time, {split.n_folds} times in all")
    alone = np.unique(felt.codes[~split.known])
    if alone.size:
        names = ", ".join(felt.classes[alone].tolist())
        remarks.append(
            f"in one group only, so that {'it is' if alone.size == 1 else 'they are'} unknown where that is held out, "
            f"counted as strangers and not as errors: {names}"
        )
    return remarks


def _copies_remarks(presses: Sequence[Press], split: Split) -> list[str]:
    """Tell of presses that are there more than once on one side; those on both sides are a leak."""
    first = first_of_same(presses)
    copies = int(((first != np.arange(len(first))) & (split.fold[first] == split.fold)).sum())
    if not copies:
        return []
    what = counted(copies, "press is a copy", "presses are copies")
    return [
        f"{what} of others beside them, with identical frames: each counts as one more, and intervals over presses are "
        "too narrow; leave the copies out"
    ]
