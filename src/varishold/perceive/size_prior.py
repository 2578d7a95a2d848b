"""Which sizes the examples of things stand for before any touch tells one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["size_priors"]

Floats = NDArray[np.float64]

# An example stands for sizes that near its own, in logarithm.
_NEAR = 0.08

# Where a kind has fewer examples of known sizes there may be other sizes of it: things of one name usually differ in
# size by so much, in logarithm.
_ENOUGH, _USUAL = 40, 0.3


def size_priors(log_sizes: Floats, log_size: Floats, kind: NDArray[np.int64]) -> Floats:
    """Return the probability of sizes for each example, shape (n, n_sizes).

    A few examples do not say that there is no other size. Beside those of a kind one more counts, whose size may be any
    that is usual for it: as in Laplace's rule of succession the next thing is of a new size once in n + 1 times.

    Parameters
    ----------
    log_sizes : ndarray of shape (n_sizes,)
    log_size : ndarray of shape (n,)
        Of each example; NaN where it is unknown and may be any.
    kind : ndarray of shape (n,), int
        Of what each example is.
    """
    prior = _about(log_sizes, log_size, np.full(len(log_size), _NEAR))
    known = np.isfinite(log_size)
    for k in np.unique(kind[known]):
        own = np.flatnonzero(known & (kind == k))
        if len(own) < _ENOUGH:
            wide = np.hypot(log_size[own].std(), _USUAL)
            usual = _about(log_sizes, log_size[own].mean(keepdims=True), np.array([wide]))
            prior[own] = (len(own) * prior[own] + usual) / (len(own) + 1)
    return prior


def _about(log_sizes: Floats, middle: Floats, near: Floats) -> Floats:
    """Return normal probabilities of sizes, a row for each middle; even ones where it is NaN."""
    off = (log_sizes - middle[:, None]) / near[:, None]
    told = np.where(np.isfinite(off), np.exp(-0.5 * off**2), 1.0)
    out: Floats = told / told.sum(axis=1, keepdims=True)
    return out
