"""Leaks: what makes a figure better than tomorrow will be."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.evaluation.features import pooled_frames
from varishold.evaluation.figures import share_figure
from varishold.evaluation.held_out import Felt
from varishold.evaluation.in_time import in_order_of_time
from varishold.evaluation.splits import Split
from varishold.frame.patches import PatchGrid
from varishold.touch.course.measures import learn_settings
from varishold.touch.course.presses import Press, first_of_same, values_of

__all__ = [
    "Leak",
    "duplicated",
    "find_leaks",
    "interleaved",
    "one_block_each",
    "sharing_frames",
    "still_columns",
    "untouched_taxels",
]

Floats = NDArray[np.float64]

# A taxel that no training press brings above this share of a strong press's peak is never touched, and a press is
# strong that has this share of the others below it. Found on real grasps whose drift is known to name the thing.
_TOUCHED, _STRONG = 0.1, 0.9
# Beside touched taxels the skin carries some of the load: a taxel farther for every so many that the pad is broad, up
# to so many; a narrower pad has nothing else.
_NARROW, _BESIDE = 4, 2
# A joint that stands still moves no more than this within a thing, radians: a seventeenth of a degree.
_STILL_RAD = 1e-3
_ANGLE = "angle_rad."
# What should tell nothing tells something where chance would do as well so rarely, and by so much more than chance.
_RARE, _MORE = 0.001, 0.05
_TREES = 100
# Of each press so many changes from frame to frame are compared, each of at least so many taxels by so many different
# amounts: where all change by one step, presses change alike by chance.
_STEEPEST, _FEWEST_CHANGED, _FEWEST_STEPS = 4, 4, 4
# Presses share frames where so many changes are the same, to so small a share of their size. Each is compared with so
# many others of about its size at most.
_FEWEST_ALIKE, _SAME_CHANGE, _MOST_COMPARED = 2, 1e-3, 50


@dataclass(frozen=True)
class Leak:
    """A reason why figures flatter.

    Parameters
    ----------
    name : str
        In a word or two: it stands beside every figure that it spoils.
    says : str
        In a sentence.
    share, chance : float or None
        Share of right answers by what should tell nothing, and what guessing gets.
    """

    name: str
    says: str
    share: float | None = None
    chance: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        return {
            "name": self.name,
            "says": self.says,
            "share": None if self.share is None else round(self.share, 6),
            "chance": None if self.chance is None else round(self.chance, 6),
        }


def find_leaks(
    felt: Felt, split: Split, runs: NDArray[Any], *, seed: int, tick: Callable[[], object] = lambda: None
) -> tuple[Leak, ...]:
    """Return every leak that is found.

    Parameters
    ----------
    felt : Felt
    split : Split
    runs : ndarray of shape (n,)
        The recording of each press; within one, presses stand in the order of time.
    seed : int
    tick : callable
        Called after each search.
    """
    found: list[Leak | None] = []
    order, goes = in_order_of_time(felt.presses, runs)
    if split.kind == "neighbours":
        found.append(
            Leak(
                "one session on both sides",
                "no groups are given: presses of one session stand on both sides of the split, which flatters; "
                "on another day fewer answers may be right",
            )
        )
        found.append(one_block_each(felt.codes[order], goes[order]))
    elif felt.groups is not None:
        found.append(interleaved(felt.groups[order], goes[order]))
    found.append(duplicated(felt.presses, split))
    tick()
    found.append(_told_by_untouched(felt, split, seed))
    tick()
    found.append(_told_by_still(felt, split, seed))
    tick()
    return tuple(leak for leak in found if leak is not None)


def interleaved(groups: NDArray[Any], runs: NDArray[Any]) -> Leak | None:
    """Tell whether groups take turns within one go, so that neighbours in time stand on both sides."""
    for run in np.unique(runs):
        inside = groups[runs == run]
        changes = int((inside[1:] != inside[:-1]).sum())
        if changes > len(np.unique(inside)) - 1:
            return Leak(
                "groups take turns",
                "groups take turns within a recording, or within recordings that follow one another: neighbours in "
                "time, of one session, stand on both sides of the split, which flatters where another day is meant",
            )
    return None


def one_block_each(codes: NDArray[Any], runs: NDArray[Any]) -> Leak | None:
    """Tell whether every thing was recorded in one go: then when it was recorded is as good as what it is."""
    changes = (codes[1:] != codes[:-1]) | (runs[1:] != runs[:-1])
    if changes.sum() + 1 != len(np.unique(codes)):
        return None
    return Leak(
        "one session a thing",
        "every thing was recorded in one go: they may be told apart by when they were recorded, and no split of these "
        "presses can show it; feel every thing in every session, and name the sessions as groups",
    )


def duplicated(presses: Sequence[Press], split: Split) -> Leak | None:
    """Tell whether identical presses, or presses that share frames, stand on both sides of the split."""
    first = first_of_same(presses)
    copies = sum(len(np.unique(split.fold[first == k])) > 1 for k in np.unique(first))
    if copies:
        held = counted(copies, "press is", "presses are")
        return Leak(
            "same presses on both sides",
            f"{held} there more than once, with identical frames, on both sides of the split; leave the copies out",
        )
    shared = int(sharing_frames(presses, split.fold).sum())
    if not shared:
        return None
    return Leak(
        "same presses on both sides",
        f"{shared} presses share frames with others on the other side of the split: they are copies, cut or rounded "
        "otherwise, or windows that overlap; keep what is of one press in one group, or leave the copies out",
    )


def sharing_frames(presses: Sequence[Press], fold: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Tell which presses hold some of the very frames of a press of another fold, shape (n_presses,).

    They are known by how readings change from frame to frame where they change most: that stays as it is wherever a
    press is cut and whatever rest is taken off, and noise makes it another for every press. One change alone may be the
    same by chance where a sensor has few steps.

    Parameters
    ----------
    presses : sequence of Press
    fold : ndarray of shape (n_presses,), int
    """
    steps = [(k, change) for k, press in enumerate(presses) for change in _steepest_changes(press)]
    sizes = np.array([float(np.linalg.norm(change)) for _, change in steps])
    order = np.argsort(sizes, kind="stable").tolist()
    alike: dict[tuple[int, int], int] = {}
    for at, one in enumerate(order):
        for other in order[at + 1 : at + 1 + _MOST_COMPARED]:
            if sizes[other] > sizes[one] * (1 + _SAME_CHANGE):
                break
            (mine, change), (theirs, its) = steps[one], steps[other]
            if fold[mine] == fold[theirs] or change.shape != its.shape:
                continue
            if float(np.linalg.norm(change - its)) <= _SAME_CHANGE * sizes[one]:
                pair = min(mine, theirs), max(mine, theirs)
                alike[pair] = alike.get(pair, 0) + 1
    found = np.zeros(len(presses), np.bool_)
    for pair, n_alike in alike.items():
        found[list(pair)] |= n_alike >= _FEWEST_ALIKE
    return found


def _steepest_changes(press: Press) -> list[Floats]:
    """Return the few largest changes of all taxels from one frame to the next, but those of few taxels or few steps."""
    frames = np.concatenate([press.pads[name].reshape(len(of), -1) for name, of in sorted(press.pads.items())], axis=1)
    changes = np.diff(frames, axis=0)
    steepest = np.argsort(-(changes * changes).sum(axis=1), kind="stable")[:_STEEPEST]
    telling = [changes[k] for k in np.sort(steepest) if np.count_nonzero(changes[k]) >= _FEWEST_CHANGED]
    return [change for change in telling if len(np.unique(np.abs(change[change != 0]))) >= _FEWEST_STEPS]


def untouched_taxels(pooled: Floats, limit: float) -> NDArray[np.bool_]:
    """Return which taxels of a pad no press loads, nor any near them, shape (rows, cols).

    Parameters
    ----------
    pooled : ndarray of shape (n_presses, rows, cols), float64
    limit : float
        What counts as load lies above it.
    """
    loaded = np.asarray((np.abs(pooled) > limit).any(axis=0))
    rows, cols = loaded.shape
    grid = PatchGrid((rows, cols))
    return ~grid.mask(grid.grown(grid.bits(loaded), min(min(rows, cols) // _NARROW, _BESIDE)))


def still_columns(values: Floats, codes: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return which joints stand still in all presses of a thing, shape (n_columns,); values are in radians."""
    spread = [np.nanstd(values[codes == k], axis=0) for k in np.unique(codes) if (codes == k).sum() > 1]
    return np.asarray(np.median(spread, axis=0) < _STILL_RAD)


def _told_by_untouched(felt: Felt, split: Split, seed: int) -> Leak | None:
    def features(train: NDArray[np.intp]) -> Floats:
        settings = learn_settings([felt.presses[k] for k in train], position=True, absolute=True)
        pooled = pooled_frames(felt.presses, settings.shapes, settings.floor)
        fields = {name: field for press in felt.presses for name, field in press.fields.items()}
        peaks = np.max([frames[train].max(axis=(1, 2)) for frames in pooled.values()], axis=0)
        limit = max(settings.floor, _TOUCHED * float(np.quantile(peaks, _STRONG)))
        away = [frames[:, untouched_taxels(frames[train], limit) & fields[name]] for name, frames in pooled.items()]
        return np.concatenate(away, axis=1)

    return _told_by(
        "untouched taxels",
        "taxels that no training press touches tell the thing in {share} of the presses (guessing gets {chance}): "
        "something else than touch is learned, such as drift or the order of recording, or touch too light to be one",
        features,
        felt,
        split,
        seed,
    )


def _told_by_still(felt: Felt, split: Split, seed: int) -> Leak | None:
    names = sorted({name for press in felt.presses for name in press.columns if name.startswith(_ANGLE)})
    if not names:
        return None
    values = values_of(felt.presses, names)
    known = np.isfinite(values)
    mean = np.where(known, values, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    filled = np.where(known, values, mean)
    still = still_columns(filled, felt.codes)
    told = ", ".join(name for name, one in zip(names, still, strict=True) if one)
    return _told_by(
        "still joints",
        f"joints that stand still ({told}) tell the thing in {{share}} of the presses (guessing gets {{chance}}): "
        "they mark the session, or how the hand was set; leave these columns out",
        lambda train: filled[:, still],
        felt,
        split,
        seed,
    )


def _told_by(
    name: str,
    says: str,
    features: Callable[[NDArray[np.intp]], Floats],
    felt: Felt,
    split: Split,
    seed: int,
) -> Leak | None:
    """Return a leak if what should tell nothing tells the thing better than guessing does."""
    from scipy.stats import binomtest
    from sklearn.ensemble import ExtraTreesClassifier

    rows: list[NDArray[np.intp]] = []
    hits: list[NDArray[np.bool_]] = []
    for train, test in split.parts():
        asked = test[split.known[test]]
        table = features(train) if asked.size else np.zeros((1, 0))
        table = table[:, np.ptp(table[train], axis=0) > 0] if asked.size else table
        if table.shape[1]:
            trees = ExtraTreesClassifier(_TREES, random_state=seed)
            with warnings.catch_warnings():
                # That there are nearly as many classes as presses.
                warnings.simplefilter("ignore", UserWarning)
                trees.fit(table[train], felt.codes[train])
            hits.append(trees.predict(table[asked]) == felt.codes[asked])
            rows.append(asked)
    if not rows:
        return None
    asked, right = np.concatenate(rows), np.concatenate(hits)
    chance = float(np.bincount(felt.codes[asked]).max() / len(asked))
    share = share_figure(right, None if felt.groups is None else felt.groups[asked])
    rare = binomtest(int(right.sum()), len(right), chance, alternative="greater").pvalue if chance < 1 else 1.0
    if share.value < chance + _MORE or (share.low or 0.0) <= chance or rare > _RARE:
        return None
    told = (f"{100 * of:.0f} %" for of in (share.value, chance))
    return Leak(name, says.format(share=next(told), chance=next(told)), share.value, chance)
