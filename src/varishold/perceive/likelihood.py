"""How far touches lie from each other, and likelihoods on the mean: over examples, and over those of each kind."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "log_mean",
    "mean_by_every_kind",
    "mean_by_kind",
    "members_of_kinds",
    "squared_distances",
    "squares_from",
]

Floats = NDArray[np.float64]


def squared_distances(first: NDArray[np.float32], second: NDArray[np.float32]) -> Floats:
    """Return the squared distance of every row of the one (n, d) from every row of the other (m, d), shape (n, m)."""
    a, b = first.astype(np.float64), second.astype(np.float64)
    out: Floats = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None, :] - 2 * a @ b.T
    return np.maximum(out, 0.0, out=out)


def squares_from(white: NDArray[np.float32], rows: NDArray[np.int64]) -> Floats:
    """Squared distances of some rows from all, infinite from themselves."""
    squares = squared_distances(white[rows], white)
    squares[np.arange(len(rows)), rows] = np.inf
    return squares


def log_mean(log_likelihood: Floats, *, over: int | None = None) -> Floats:
    """Return the logarithm of the mean likelihood along the last axis.

    Parameters
    ----------
    log_likelihood : ndarray of shape (..., n)
    over : int, optional
        What the sum is divided by; default: n.
    """
    top = log_likelihood.max(axis=-1, keepdims=True)
    total = np.exp(log_likelihood - top).sum(axis=-1)
    out: Floats = np.log(total / (log_likelihood.shape[-1] if over is None else over)) + top[..., 0]
    return out


def members_of_kinds(owner: NDArray[np.int64]) -> Floats:
    """Return 1 where an example is of a kind, else 0; shape (n_kinds, n), of the kinds that have an example."""
    members: Floats = (owner[:, None] == np.unique(owner)).astype(np.float64).T
    return members


def mean_by_kind(log_kernel: Floats, members: Floats) -> Floats:
    """Return the logarithm of the mean likelihood over each kind's examples that know it.

    Examples are judged by this: where none of a kind is left to say anything, that kind says nothing of them.

    Parameters
    ----------
    log_kernel : ndarray of shape (..., n)
        Log-likelihood under each example; not finite for those that do not know it.
    members : ndarray of shape (n_kinds, n)
        1 where an example is of a kind, else 0.

    Returns
    -------
    ndarray of shape (..., n_kinds)
        Minus infinity for a kind of which no example knows it; NaN where none of any kind does.
    """
    total, count, top = _sums_by_kind(log_kernel, members)
    top = np.where(count.any(axis=-1, keepdims=True), top, np.nan)
    with np.errstate(divide="ignore"):
        out: Floats = np.log(total / np.maximum(count, 1.0)) + top
    return out


def mean_by_every_kind(log_kernel: Floats, members: Floats) -> Floats:
    """As `mean_by_kind`, finite for every kind: a belief weighs them all, and must be able to come back to each.

    A kind that never was touched so is neither likelier nor less likely than the others on the whole.
    """
    total, count, top = _sums_by_kind(log_kernel, members)
    of_all = total.sum(axis=-1, keepdims=True) / np.maximum(count.sum(axis=-1, keepdims=True), 1.0)
    mean = np.where(count > 0, total / np.maximum(count, 1.0), of_all)
    out: Floats = np.log(np.maximum(mean, 1e-300)) + top
    return out


def _sums_by_kind(log_kernel: Floats, members: Floats) -> tuple[Floats, NDArray[Any], Floats]:
    """Return each kind's sum of likelihoods in parts of the largest, how many know it, and the largest's logarithm."""
    known = np.isfinite(log_kernel)
    told = np.where(known, log_kernel, -np.inf)
    top = told.max(axis=-1, keepdims=True, initial=-np.inf)
    # Where none of any kind knows it there is no largest, and any will do.
    top = np.where(np.isfinite(top), top, 0.0)
    mass = np.exp(told - top)
    return mass @ members.T, known @ members.T, top
