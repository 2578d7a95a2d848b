"""Folds: which things are held out together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = ["first_without_name", "group_folds", "kept_together", "same_partition"]


def group_folds(labels: ArrayLike, groups: ArrayLike | None = None, *, folds: int = 5) -> NDArray[np.intp]:
    """Deal things into folds, none of which knows what is held out.

    Where there are at least two groups, and without any fold of them every class has something to learn from, a group
    is never split; there are fewer folds where all groups of a class would fall into one. Otherwise the things of each
    class are dealt in blocks of neighbours, in the order in which they stand:
    neighbours in time are alike, and on both sides of a split they flatter.

    Parameters
    ----------
    labels : array_like of shape (n,)
        The class of each thing, in the order of recording.
    groups : array_like of shape (n,), optional
        The session of each, or whatever else must not be on both sides.
    folds : int, default 5
        The most folds.

    Returns
    -------
    ndarray of shape (n,), int
        The fold of each thing.

    Raises
    ------
    InputError
        If a class has one thing only, or groups are not one a thing.

    Examples
    --------
    >>> group_folds(["a", "a", "b", "a", "b", "a"], folds=2).tolist()
    [0, 0, 0, 1, 1, 1]
    >>> group_folds(["a", "b", "a", "b", "a", "b"], [1, 1, 2, 2, 3, 3]).tolist()
    [0, 0, 1, 1, 2, 2]
    """
    names, codes = np.unique(np.asarray(labels), return_inverse=True)
    counts = np.bincount(codes, minlength=len(names))
    if counts.size and counts.min() < 2:
        raise InputError(f"{str(names[int(np.argmin(counts))])!r} has one press only: give each class at least two")
    if groups is not None:
        session = np.unique(np.asarray(groups), return_inverse=True)[1]
        if session.shape != codes.shape:
            raise InputError(f"groups must be one a press, {len(codes)} of them, got {session.shape}")
        # With fewer folds all sessions of a class may fall into different ones.
        for n in range(folds, 1, -1):
            dealt = session % n
            held = np.unique(dealt)
            if len(held) > 1 and all(len(np.unique(codes[dealt != k])) == len(names) for k in held):
                return dealt.astype(np.intp)
    n_folds = int(min(folds, counts.max(initial=2)))
    fold = np.zeros(len(codes), dtype=np.intp)
    for k in range(len(names)):
        of = np.flatnonzero(codes == k)
        fold[of] = np.arange(len(of)) * min(n_folds, len(of)) // len(of)
    return fold


def first_without_name(names: ArrayLike) -> int | None:
    """Return the place of the first name that is missing: None or NaN; None where all are there.

    Examples
    --------
    >>> first_without_name(["a", None]), first_without_name([1.0, float("nan")]), first_without_name(["a", "nan"])
    (1, 1, None)
    """
    listed = np.asarray(names).ravel().tolist()
    return next((k for k, name in enumerate(listed) if name is None or name != name), None)


def same_partition(one: ArrayLike, other: ArrayLike) -> bool:
    """Tell whether two lists of names part things alike: groups that are the labels.

    Examples
    --------
    >>> same_partition(["a", "b", "a"], [7, 3, 7]), same_partition(["a", "b", "a"], [7, 3, 3])
    (True, False)
    """
    first, second = (np.unique(np.asarray(names), return_inverse=True)[1] for names in (one, other))
    if first.shape != second.shape:
        return False
    pairs = len(np.unique(np.stack([first, second]), axis=1).T)
    return pairs == len(np.unique(first)) == len(np.unique(second))


def kept_together(fold: NDArray[np.intp], groups: NDArray[Any]) -> bool:
    """Tell whether no group was split between folds, shape (n,) each."""
    return all(len(np.unique(fold[groups == group])) == 1 for group in np.unique(groups))
