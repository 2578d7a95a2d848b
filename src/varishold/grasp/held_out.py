"""Training grasps that are held out, each with all of its group: what known grasps are like to those that are left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError, require
from varishold.grasp.training import SeenGrasps

__all__ = ["HeldOut", "beyond_of", "held_out_of", "hold_out"]

Floats = NDArray[np.float64]

#: Grasps that are held out at most, and their distances from all others together.
_JUDGES, _JUDGED_DISTANCES = 1500, 4_000_000
# No reading lies farther beyond the others', in switches: sums and squares of such numbers are finite.
_FARTHEST = 1e100


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Training grasps that are held out.

    Parameters
    ----------
    patterns : ndarray of shape (n_judged,), int64
        Which of what was seen each is.
    left : ndarray of shape (n_judged, n), int64
        How many grasps of everything that was seen are left then.
    beyond : ndarray of shape (n_judged,), float64
        How far its readings lay beyond the range of those left, in switches.
    fellows : bool
        Whether each has one of its own class left; otherwise none has.
    """

    patterns: NDArray[np.int64]
    left: NDArray[np.int64]
    beyond: Floats
    fellows: bool


def hold_out(seen: SeenGrasps, groups: NDArray[np.int64] | None, beyond: Floats | float) -> HeldOut | None:
    """Hold every training grasp out with its group, or some of very many.

    Parameters
    ----------
    seen : SeenGrasps
    groups : ndarray of shape (n_rows,), int64, or None
        Which of the training grasps, row by row, are held out together; None: each alone.
    beyond : ndarray of shape (n_rows,), float64, or 0
        How far each lies beyond the range of the other groups' readings, in switches.

    Returns
    -------
    HeldOut or None
        Of the grasps whose class is left then; where no class ever is, of all. None where nothing is left.
    """
    groups = np.arange(len(seen.owners)) if groups is None else groups
    judges = np.arange(len(seen.owners))
    most = min(_JUDGES, _JUDGED_DISTANCES // max(1, len(seen)))
    if len(judges) > most:
        judges = np.sort(np.random.default_rng(0).choice(judges, most, replace=False))
    left = np.tile(seen.weights, (len(judges), 1))
    for k, row in enumerate(judges):
        np.subtract.at(left[k], seen.owners[groups == groups[row]], 1)
    patterns = seen.owners[judges]
    own = ((left > 0) & (seen.labels == seen.labels[patterns][:, None])).any(axis=1)
    told = own if own.any() else (left > 0).any(axis=1)
    if not told.any():
        return None
    off = np.broadcast_to(beyond, groups.shape)[judges[told]]
    return HeldOut(patterns[told], left[told], off, bool(own.any()))


def held_out_of(document: Mapping[str, Any], n: int) -> tuple[NDArray[np.int64], Floats]:
    """Return what a model file says of each of its n grasps: its group, and how far it lay beyond the others' readings.

    Null, as in files of the first version: each is alone, and none lay beyond.
    """
    groups = np.arange(n) if document["groups"] is None else np.array(document["groups"])
    beyond = np.zeros(n) if document["beyond"] is None else np.array(document["beyond"], dtype=np.float64)
    whole = groups.shape == (n,) and groups.dtype.kind == "i" and bool((groups >= 0).all())
    require(whole, f"groups must be a whole number from 0 on for each of {n} grasps")
    require(beyond.shape == (n,), _of_each(n))
    return groups.astype(np.int64), beyond_of(beyond, n)


def beyond_of(given: ArrayLike, n: int) -> Floats:
    """Return how far each of n grasps lies beyond what was learned, shape (n,); one number stands for all.

    Raises
    ------
    InputError
        If they are no such numbers, or not one a grasp.
    """
    try:
        beyond = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(_of_each(n)) from None
    told = beyond.shape in ((), (n,)) and bool(((beyond >= 0) & (beyond <= _FARTHEST)).all())
    require(told, _of_each(n))
    return np.broadcast_to(beyond, n).copy()


def _of_each(n: int) -> str:
    return f"beyond must be a number from 0 to {_FARTHEST:g} for each of {n} grasps"
