"""Constrained conjugate gradients: pressures that never pull, and surfaces that never meet twice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floating = NDArray[np.floating[Any]]

__all__ = ["Nonnegative", "solve_nonnegative"]


@dataclass(frozen=True)
class Nonnegative:
    """Outcome of `solve_nonnegative`.

    Parameters
    ----------
    x : ndarray
        The solution, nowhere negative.
    gradient : ndarray of the same shape
        A x - b.
    rms : float
        Root mean square of the gradient over the cells where x > 0 or the gradient < 0.
    iterations : int
        Steps taken.
    converged : bool
        Whether `rms` came down to the tolerance.
    """

    x: Floating
    gradient: Floating
    rms: float
    iterations: int
    converged: bool


def solve_nonnegative(
    apply: Callable[[Floating], Floating],
    precondition: Callable[[Floating], Floating],
    b: Floating,
    start: Floating,
    *,
    tolerance: float,
    max_iterations: int,
) -> Nonnegative:
    """Minimize x'Ax / 2 - b'x over x >= 0 by preconditioned conjugate gradients with a moving active set.

    A cell is free where x > 0, or where its gradient would draw it in. Along each direction x is cut at
    zero; the direction keeps its memory over changes of the free set (Polak-Ribiere's factor forgets by
    itself what no longer holds) and starts anew when it would not descend, so that sharp tips and vertical
    edges do not stall it.

    Parameters
    ----------
    apply, precondition : callable
        x -> A x with A symmetric and positive, and r -> about A^-1 r.
    b, start : ndarray of one shape
        Right-hand side, and where to begin (nowhere negative).
    tolerance : float
        Wanted `rms`.
    max_iterations : int
        Steps at most.

    Returns
    -------
    Nonnegative

    References
    ----------
    I. A. Polonsky and L. M. Keer, "A numerical method for solving rough contact problems based on the
    multi-level multi-summation and conjugate gradient techniques", Wear 231, 1999.
    """
    x = start
    gradient = apply(x) - b
    direction: Floating | None = None
    residual = gradient
    descent_before = 1.0
    for iteration in range(max_iterations + 1):
        free = (x > 0) | (gradient < 0)
        count = int(np.count_nonzero(free))
        before, residual = residual, np.where(free, gradient, gradient.dtype.type(0))
        rms = float(np.sqrt(_dot(residual, residual) / max(count, 1)))
        if rms <= tolerance or iteration == max_iterations:
            break
        steepest = np.where(free, precondition(residual), gradient.dtype.type(0))
        descent = _dot(residual, steepest)
        if descent <= 0:
            steepest, descent = residual, _dot(residual, residual)
        along = steepest
        if direction is not None:
            memory = (descent - _dot(steepest, before)) / descent_before
            if memory > 0:
                along = np.where(free, steepest + gradient.dtype.type(memory) * direction, gradient.dtype.type(0))
                if _dot(residual, along) <= 0:
                    along = steepest
        direction, descent_before = along, descent
        change = apply(along)
        step = gradient.dtype.type(_dot(residual, along) / _dot(along, change))
        x = x - step * along
        cut = x < 0
        if cut.any():
            x[cut] = 0
            gradient = apply(x) - b
        else:
            gradient = gradient - step * change
    return Nonnegative(x, gradient, rms, iteration, rms <= tolerance)


def _dot(a: Floating, b: Floating) -> float:
    return float(np.dot(a.ravel(), b.ravel()))
