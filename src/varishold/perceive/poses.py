"""How objects were set up: an object in one pose is a kind, and is judged by itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import require

__all__ = ["Kinds", "kinds_of", "poses_of", "usual_of"]


class Kinds(NamedTuple):
    """Objects in poses, an object's kinds one after the other.

    Parameters
    ----------
    of_example : ndarray of shape (n,), int
        Which kind each example is of.
    object : ndarray of shape (n_kinds,), int
        Which object each kind is.
    pose : ndarray of shape (n_kinds,), int
        The pose of each kind; -1 where that is not said.
    """

    of_example: NDArray[np.int64]
    object: NDArray[np.int64]
    pose: NDArray[np.int64]


def kinds_of(owner: NDArray[np.int64], pose: NDArray[np.int64] | None) -> Kinds:
    """Return the kinds of examples whose objects are known, and perhaps their poses."""
    pairs = np.column_stack([owner, np.full(len(owner), -1) if pose is None else pose])
    kinds, kind = np.unique(pairs, axis=0, return_inverse=True)
    return Kinds(kind.reshape(-1).astype(np.int64), kinds[:, 0].astype(np.int64), kinds[:, 1].astype(np.int64))


def usual_of(kinds: Kinds) -> NDArray[np.bool_]:
    """Which examples are of their object's commonest kind; of several as common, of the first."""
    counts = np.bincount(kinds.of_example, minlength=len(kinds.object))
    first = [
        int(own[np.argmax(counts[own])]) for k in np.unique(kinds.object) for own in [np.flatnonzero(kinds.object == k)]
    ]
    return np.isin(kinds.of_example, first)


def poses_of(
    poses: Mapping[str, Sequence[str]], numbers: Mapping[str, int]
) -> tuple[tuple[str, ...], NDArray[np.int64] | None]:
    """Return the names of all poses, and which of them each example is in; -1 where that is not said."""
    known = ", ".join(numbers)
    for name, rows in poses.items():
        require(name in numbers, f"poses are given of {name!r}, which has no examples; known are {known}")
        words = isinstance(rows, Iterable) and not isinstance(rows, str)
        words = words and all(isinstance(row, str) and row.strip() for row in rows)
        require(words, f"poses of {name!r} must be words, one an example")
        require(
            len(rows) == numbers[name],
            f"{name!r} has {counted(numbers[name], 'example')}, but {counted(len(rows), 'pose')}; give one each",
        )
    names = tuple(dict.fromkeys(word for rows in poses.values() for word in rows))
    if not names:
        return (), None
    index = {word: k for k, word in enumerate(names)}
    of = [
        np.array([index[word] for word in poses[name]]) if name in poses else np.full(n, -1)
        for name, n in numbers.items()
    ]
    return names, np.concatenate(of).astype(np.int64)
