"""A metric under which examples lie nearest to their own kind: neighbourhood components, with the kernel that is used.

Whitening within objects makes every direction count by how much it scatters. Of some two hundred numbers most say
nothing of the name, and together they drown the few that do. Here a linear map is learned on top of the whitening: each
example is named by all others but itself, as a touch is named by a library, and the probability of its own kind is
raised. The map is held near the identity, the closer the fewer examples there are.

References
----------
Goldberger, Roweis, Hinton and Salakhutdinov, "Neighbourhood components analysis", 2005.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

__all__ = ["folds_of", "learn_map"]

Floats = NDArray[np.float64]

# How strongly the map is held to the identity (against one example's worth of surprise), and steps at most.
_HOLD, _STEPS = 10.0, 60

# The probability that an example keeps for its own kind however far off it lies, in parts of all others'.
_LEAST = 1e-9


def folds_of(kind: NDArray[np.int64], folds: int) -> NDArray[np.int64]:
    """Return the fold of each example, shape (n,): of every kind the same share in each, drawn by chance."""
    rng, out = np.random.default_rng(0), np.zeros(len(kind), dtype=np.int64)
    for k in np.unique(kind):
        own = np.flatnonzero(kind == k)
        out[rng.permutation(own)] = np.arange(len(own)) % folds
    return out


def learn_map(white: NDArray[np.float32], kind: NDArray[np.int64], width: float, fall: float) -> Floats:
    """Return the matrix (d, d) whose product with a whitened row brings it near those of its kind.

    Parameters
    ----------
    white : ndarray of shape (n, d)
    kind : ndarray of shape (n,), int
        Kinds count alike, however many examples they have.
    width, fall : float
        Of the kernel, as of a `TouchModel`.
    """
    from scipy.optimize import minimize

    # Kind by kind, so that a kind's own are a block; float32, in two tables that are gone through a few hundred times.
    order = np.argsort(kind, kind="stable")
    rows, kind = white[order].astype(np.float32), kind[order]
    n, d = rows.shape
    starts = np.flatnonzero(np.diff(kind, prepend=-1))
    blocks = [slice(*ends) for ends in pairwise([*starts.tolist(), n])]
    count = np.repeat(np.diff([*starts, n]), np.diff([*starts, n]))
    log_share = -np.log(count).astype(np.float32)
    weight = (1.0 / count / len(starts)).astype(np.float32)
    per_square, hold = 1.0 / (d * width**2), _HOLD / n
    slope = np.float32(-0.5 * fall)
    identity, table, says = np.eye(d), np.empty((n, n), np.float32), np.empty((n, n), np.float32)

    def surprise(flat: Floats) -> tuple[float, Floats]:
        """Mean surprise at the kinds, and its gradient."""
        map_ = flat.reshape(d, d)
        at = rows @ (map_ * np.sqrt(per_square)).astype(np.float32)
        norm = (at**2).sum(axis=1)
        np.matmul(at, at.T, out=table)
        np.multiply(table, np.float32(-2.0), out=table)
        np.add(table, norm[:, None], out=table)
        np.add(table, norm, out=table)
        np.maximum(table, 0.0, out=table)
        np.log1p(table, out=says)
        np.multiply(says, slope, out=says)
        np.add(says, log_share, out=says)
        np.fill_diagonal(says, -np.inf)
        np.subtract(says, says.max(axis=1, keepdims=True), out=says)
        np.exp(says, out=says)
        total = says.sum(axis=1)
        owns = np.concatenate([says[own, own].sum(axis=1) for own in blocks]) + np.float32(_LEAST) * total
        loss = float(-(weight * np.log(owns / total)).sum())
        # The slope of the surprise by each squared distance.
        for own in blocks:
            says[own, own] *= (1.0 - total[own] / owns[own])[:, None]
        np.multiply(says, (slope * weight / total)[:, None], out=says)
        np.add(table, 1.0, out=table)
        np.divide(says, table, out=says)
        drawn = (says.sum(axis=1) + says.sum(axis=0))[:, None] * at - says @ at - says.T @ at
        gradient = 2.0 * np.sqrt(per_square) * (rows.T @ drawn).astype(np.float64)
        off = map_ - identity
        return loss + hold * float((off**2).sum()), (gradient + 2 * hold * off).ravel()

    found = minimize(surprise, identity.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": _STEPS})
    out: Floats = found.x.reshape(d, d)
    return out
