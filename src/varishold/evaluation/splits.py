"""Splits: what is held out together, and what can be known without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.trust import group_folds, same_partition

__all__ = ["Split", "split_presses", "usable_groups"]

# More groups than these are held out several at a time.
_MOST_FOLDS = 12
# Presses of a class that a learner needs.
FEWEST_PRESSES = 2


@dataclass(frozen=True, eq=False)
class Split:
    """Which presses are held out together.

    Parameters
    ----------
    kind : {"groups", "neighbours"}
        Whole groups, or blocks of presses of a class that were made one after the other.
    fold : ndarray of shape (n,), int
        The fold in which each press is held out.
    known : ndarray of shape (n,), bool
        Whether the class of each press is known when it is held out.
    codes : ndarray of shape (n,), int
        The class of each press.
    """

    kind: Literal["groups", "neighbours"]
    fold: NDArray[np.intp]
    known: NDArray[np.bool_]
    codes: NDArray[np.intp]

    @property
    def n_folds(self) -> int:
        """How many times something is held out."""
        return len(np.unique(self.fold))

    def parts(self) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """Yield for every fold the presses to learn from and those that are held out, in their order."""
        for k in np.unique(self.fold):
            yield self.training(int(k)), np.flatnonzero(self.fold == k)

    def training(self, fold: int) -> NDArray[np.intp]:
        """Return what is learned from when a fold is held out: classes with at least two presses."""
        outside = self.fold != fold
        enough = np.bincount(self.codes[outside], minlength=int(self.codes.max()) + 1) >= FEWEST_PRESSES
        return np.flatnonzero(outside & enough[self.codes])


def split_presses(labels: NDArray[np.str_], groups: NDArray[np.str_] | None, *, folds: int = 5) -> Split:
    """Return the split of some presses: each group held out once, or without groups blocks of neighbours in time.

    Parameters
    ----------
    labels : ndarray of shape (n,)
        In the order of recording.
    groups : ndarray of shape (n,), optional
    folds : int, default 5
        Folds where there are no groups.

    Raises
    ------
    InputError
        If there is one class, one group, without groups a class of fewer than three presses, groups that are the
        labels, or nothing that could be known when it is held out.
    """
    classes, codes = np.unique(labels, return_inverse=True)
    if len(classes) < 2:
        raise InputError(
            f"there is one thing only, {str(classes[0])!r}: give presses of something else too, to be told from it",
            parameter="label",
        )
    if groups is None:
        counts = np.bincount(codes)
        if counts.min() <= FEWEST_PRESSES:
            rarest = int(np.argmin(counts))
            raise InputError(
                f"{str(classes[rarest])!r} has {counted(counts[rarest], 'press')} only: give each thing at "
                f"least {FEWEST_PRESSES + 1}, one to be held out and {FEWEST_PRESSES} to learn from"
            )
        fold = group_folds(labels, folds=folds)
        return Split("neighbours", fold, np.ones(len(codes), np.bool_), codes)
    names, inner = np.unique(groups, return_inverse=True)
    if len(names) < 2:
        raise InputError(
            f"there is one group only, {str(names[0])!r}: give presses of another one too, or no groups",
            parameter="group",
        )
    if usable_groups(inner, codes) is None:
        raise InputError(
            "groups are the labels themselves: nothing would be left to learn a held-out label from; name what "
            "changes from day to day, such as the session",
            parameter="group",
        )
    split = Split("groups", (inner % _MOST_FOLDS).astype(np.intp), np.ones(len(codes), np.bool_), codes)
    known = np.zeros(len(codes), np.bool_)
    for train, test in split.parts():
        there = np.unique(codes[train])
        if len(there) >= FEWEST_PRESSES:
            known[test] = np.isin(codes[test], there)
    if not known.any():
        raise InputError(
            "every thing was felt in one group only, so that none is known where its group is held out; "
            "feel every thing in every session, or give no groups",
            parameter="group",
        )
    return Split("groups", split.fold, known, codes)


def usable_groups(groups: NDArray[np.generic] | None, codes: NDArray[np.generic]) -> NDArray[np.generic] | None:
    """Return groups if a learner can hold them out in its turn: two or more, and not the classes themselves."""
    if groups is None:
        return None
    return None if len(np.unique(groups)) < 2 or same_partition(groups, codes) else groups
