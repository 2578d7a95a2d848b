"""Fitting a sensor's constants and each press's place and depth together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.imprint import KnownObject, Points

__all__ = ["ENOUGH", "Fit", "Observed", "fit_presses"]

Floats = NDArray[np.float64]
#: From depths of faces (n, rows, cols) and constants to readings.
Forward = Callable[[Floats, Floats], Floats]

_ROUNDS = 60
#: A fit ends where a round takes off less than this share of what is left.
ENOUGH = 1e-5
# Steps of numerical derivatives: of constants, and of a press's parameters as a share of its scale.
_STEP, _SHARE = 1e-4, 1e-3


@dataclass(frozen=True, eq=False)
class Observed:
    """A press that was recorded.

    Parameters
    ----------
    object : KnownObject
    frame : ndarray of shape (rows, cols), float64
        Readings above rest.
    sigma : float
        How far a prediction may be off.
    start : ndarray of shape (n_parameters,), float64
        A first guess of the object's parameters.
    scale : ndarray of shape (n_parameters,), float64
        How far each may well move.
    """

    object: KnownObject
    frame: Floats
    sigma: float
    start: Floats
    scale: Floats


@dataclass(frozen=True, eq=False)
class Fit:
    """What fits presses best.

    Parameters
    ----------
    constants : ndarray of shape (n_constants,), float64
        The sensor's.
    error : ndarray of shape (n_constants,), float64
        Their standard errors, where each taxel's residual is its own.
    press_error : ndarray of shape (n_constants,), float64
        Their standard errors, where those of one press may be alike: as presses differ.
    places : tuple of ndarray
        Each press's own parameters.
    cost : ndarray of shape (n_presses,), float64
        Mean square of each press's residuals, in its sigmas.
    predicted : ndarray of shape (n_presses, rows, cols), float64
    """

    constants: Floats
    error: Floats
    press_error: Floats
    places: tuple[Floats, ...]
    cost: Floats
    predicted: Floats


def fit_presses(
    forward: Forward,
    constants: Floats,
    observed: Sequence[Observed],
    points: Points,
    usable: NDArray[np.bool_],
    *,
    low: Floats,
    high: Floats,
    places: Sequence[Floats] | None = None,
    free: bool = True,
    by_gain: Forward | None = None,
    gain_spread: float = 0.0,
    enough: float = ENOUGH,
) -> Fit:
    """Return the constants and places that fit best (Levenberg and Marquardt).

    Parameters
    ----------
    forward : callable
        Readings of face depths with given constants.
    constants : ndarray of shape (n_constants,), float64
        Where to begin.
    observed : sequence of Observed
    points : Points
        The pad.
    usable : ndarray of shape (rows, cols), bool
        Which taxels count.
    low, high : ndarray of shape (n_constants,), float64
        Where constants must stay.
    places : sequence of ndarray, optional
        Where to begin for each press; default: their own guess.
    free : bool
        Whether constants may move; otherwise only places do.
    by_gain : callable, optional
        How readings grow with the logarithm of each taxel's gain, where gains were found from the same presses:
        constants are then less sure.
    gain_spread : float
        Prior spread of these gains.
    enough : float
        The fit ends where a round takes off less than this share of what is left.
    """
    n, sizes = len(observed), [each.start.size for each in observed]
    ends = np.cumsum([0, *sizes])
    theta, phi = constants.astype(np.float64), np.concatenate([*(places or [each.start for each in observed])])
    scales = np.concatenate([each.scale for each in observed])
    frames = np.array([each.frame for each in observed])
    weights = usable / np.array([each.sigma for each in observed])[:, None, None]

    def faces(at: Floats) -> Floats:
        return np.array([o.object.stress(at[ends[k] : ends[k + 1]], points) for k, o in enumerate(observed)])

    def residual(predicted: Floats) -> Floats:
        weighed: Floats = ((predicted - frames) * weights).reshape(n, -1)
        return weighed

    face = faces(phi)
    predicted = forward(face, theta)
    left = residual(predicted)
    damping = 1e-2
    count = theta.size if free else 0
    normal = np.eye(count)
    for _ in range(_ROUNDS):
        columns = [
            (residual(forward(face, theta + _STEP * unit)) - left) / _STEP for unit in np.eye(theta.size)[:count]
        ]
        own: list[Floats] = [np.empty((size, left.shape[1])) for size in sizes]
        for j in range(max(sizes)):
            moved, small = phi.copy(), _SHARE * scales
            for k, size in enumerate(sizes):
                if j < size:
                    moved[ends[k] + j] += small[ends[k] + j]
            change = residual(forward(faces(moved), theta)) - left
            for k, size in enumerate(sizes):
                if j < size:
                    own[k][j] = change[k] / small[ends[k] + j]
        normal, right = _normal(columns, own, left, ends, count)
        done = False
        for _ in range(8):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), -right)
            new_theta = theta.copy()
            new_theta[:count] = np.clip(theta[:count] + step[:count], low[:count], high[:count])
            limit = 2.0 * scales
            new_phi = phi + np.clip(step[count:], -limit, limit)
            new_face = faces(new_phi)
            new_left = residual(forward(new_face, new_theta))
            before, after = float((left**2).sum()), float((new_left**2).sum())
            if after < before:
                done = before - after < enough * before
                theta, phi, face, left = new_theta, new_phi, new_face, new_left
                damping = max(damping / 5, 1e-9)
                break
            damping *= 5
        else:
            done = True
        if done:
            break
    predicted = forward(face, theta)
    used = max(int(usable.sum()) * n - phi.size - count, 1)
    if by_gain is not None and free:
        normal = normal - _taken_by_gains(columns, own, (by_gain(face, theta) * weights).reshape(n, -1), gain_spread)
    inverse = np.linalg.pinv(normal)[:count, :count]
    by_residuals = np.diag(inverse) * float((left**2).sum()) / used
    # Residuals of one press are alike: how far each press as a whole pulls the constants.
    pulls = np.array([[float(one[k] @ left[k]) for one in columns] for k in range(n)]).reshape(n, count) @ inverse
    by_presses = (pulls**2).sum(axis=0) * n / max(n - 1, 1)
    return Fit(
        theta,
        np.sqrt(np.maximum(by_residuals, 0.0)),
        np.sqrt(by_presses),
        tuple(phi[ends[k] : ends[k + 1]] for k in range(n)),
        (left**2).sum(axis=1) / usable.sum(),
        predicted,
    )


def _normal(
    columns: list[Floats], own: list[Floats], left: Floats, ends: NDArray[np.intp], count: int
) -> tuple[Floats, Floats]:
    """Return the normal equations; a press's own parameters touch no other press."""
    size = count + int(ends[-1])
    normal, right = np.zeros((size, size)), np.zeros(size)
    for i, one in enumerate(columns):
        right[i] = (one * left).sum()
        for j in range(i + 1):
            normal[i, j] = normal[j, i] = (one * columns[j]).sum()
    for k, block in enumerate(own):
        at = slice(count + ends[k], count + ends[k + 1])
        right[at] = block @ left[k]
        normal[at, at] = block @ block.T
        for i, one in enumerate(columns):
            normal[i, at] = normal[at, i] = block @ one[k]
    return normal, right


def _taken_by_gains(columns: list[Floats], own: list[Floats], by_gain: Floats, spread: float) -> Floats:
    """Return what the normal equations lose to gains that are as unknown: each taxel's touches no other taxel."""
    blocks = [
        np.array([(one * by_gain).sum(axis=0) for one in columns]),
        *(b * g for b, g in zip(own, by_gain, strict=True)),
    ]
    beside = np.concatenate(blocks)
    taken: Floats = (beside / ((by_gain**2).sum(axis=0) + 1.0 / spread**2)) @ beside.T
    return taken
