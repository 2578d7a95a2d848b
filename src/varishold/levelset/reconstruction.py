"""V from its sections: the sum of X_i times the threshold's decrement (eq. [3], [4])."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = ["cut", "reconstruct_from_sections"]


def cut(frame: ArrayLike, thresholds: ArrayLike) -> NDArray[np.bool_]:
    """Return the sections X_i = {V > theta_i} on the taxels themselves.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        V.
    thresholds : array_like of shape (n,), float
        Theta_1 ... theta_n.

    Returns
    -------
    ndarray of shape (n, rows, cols), bool

    Examples
    --------
    >>> cut([[0.0, 1.0, 2.0]], [1.5, 0.5]).astype(int).tolist()
    [[[0, 0, 1]], [[0, 1, 1]]]
    """
    values, theta = np.asarray(frame, dtype=np.float64), np.asarray(thresholds, dtype=np.float64)
    if values.ndim != 2 or theta.ndim != 1:
        raise InputError(f"need a frame (rows, cols) and thresholds (n,), got shapes {values.shape} and {theta.shape}")
    return np.asarray(values > theta[:, None, None])


def reconstruct_from_sections(
    sections: ArrayLike, thresholds: ArrayLike, *, delta: float | None = None
) -> NDArray[np.float64]:
    """Rebuild V from its sections: delta + sum X_i (theta_i - theta_i+1), with theta_n+1 = delta.

    The result is never above V where V > delta, and below it by at most the largest decrement: of the steps
    between the thresholds, and of the one from V's top down to theta_1. Where V <= delta it is delta.

    Parameters
    ----------
    sections : array_like of shape (n, rows, cols), bool
        X_1 ... X_n, as `cut` returns them.
    thresholds : array_like of shape (n,), float
        Theta_1 ... theta_n, falling.
    delta : float, optional
        The standard plane, at most theta_n. Default: theta_n, so that X_n itself adds nothing.

    Returns
    -------
    ndarray of shape (rows, cols), float64
        In the unit of the thresholds.

    Raises
    ------
    InputError
        If shapes do not match, thresholds do not fall, or delta lies above the last.

    References
    ----------
    G. Kinoshita, S. Aida and M. Mori, "Pattern recognition by an artificial tactile sense", 1971, eq. [3], [4].

    Examples
    --------
    >>> frame = np.array([[0.0, 0.5, 1.0, 0.3]])
    >>> theta = np.array([0.8, 0.6, 0.4, 0.2])
    >>> reconstruct_from_sections(cut(frame, theta), theta, delta=0.0).round(1).tolist()
    [[0.0, 0.4, 0.8, 0.2]]
    """
    x, theta = np.asarray(sections, dtype=np.bool_), np.asarray(thresholds, dtype=np.float64)
    if x.ndim != 3 or theta.shape != x.shape[:1] or theta.size == 0:
        raise InputError(
            f"need sections (n, rows, cols) and one threshold for each, got shapes {x.shape} and {theta.shape}"
        )
    plane = float(theta[-1]) if delta is None else float(delta)
    steps = theta - np.append(theta[1:], plane)
    if np.any(steps < 0) or not np.isfinite(theta).all():
        raise InputError(f"thresholds must fall down to delta = {plane}, got {theta.tolist()}")
    return np.asarray(plane + np.tensordot(steps, x.astype(np.float64), axes=1))
