"""A response from points of known stress: the simplest curve that explains them."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.result import Curve, Finding
from varishold.errors import InputError
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor, Table

__all__ = ["fit_response"]

Floats = NDArray[np.float64]

# A curve of one constant more must lower the residual to this share of a simpler one's.
_WORTH = 0.8
# Residuals below this share of full scale need no better curve.
_GOOD = 0.005


def fit_response(base: Sensor, stress: Floats, reading: Floats, unit: str) -> tuple[Sensor, Curve, Finding]:
    """Return a sensor whose response goes through points of known stress.

    Parameters
    ----------
    base : Sensor
        What is known; its response, span and full scale are replaced.
    stress, reading : ndarray of shape (n_points,), float64
        Stresses in `unit`, and readings above rest.
    unit : str
        Unit of the stresses.

    Raises
    ------
    InputError
        If more stress reads less.
    """
    order = np.argsort(stress, kind="stable")
    levels, at = np.unique(stress[order], return_inverse=True)
    means = np.bincount(at, reading[order]) / np.bincount(at)
    fall = np.flatnonzero(np.diff(means) <= 0)
    if fall.size:
        i = int(fall[0])
        raise InputError(
            f"the response is not monotone: {levels[i]:g} {unit} reads {means[i]:.4g} and {levels[i + 1]:g} {unit} "
            f"reads {means[i + 1]:.4g}; leave out presses beyond saturation, or check the order of the pressures"
        )
    full, span = float(levels[-1]), float(means[-1])
    x, y = levels / full, means / span
    best: Response = Linear()
    residual = _rms(best, x, y)
    if residual > _GOOD:
        curved = min((_fitted(family, x, y) for family in (Power, Logarithmic)), key=lambda fitted: _rms(fitted, x, y))
        if (left := _rms(curved, x, y)) < _WORTH * residual:
            best, residual = curved, left
    if residual > _GOOD and x.size > 3:
        best = Table([0.0, *x.tolist()], [0.0, *y.tolist()])
        residual = _left_out(x, y)
    made = dataclasses.replace(base, response=best, span=span, full_scale=full, unit=unit)
    constants = ", ".join(f"{key} {value:.3g}" for key, value in best.entries().items() if np.ndim(value) == 0)
    says = f"what the {best.kind} response{f' ({constants})' if constants else ''} leaves of the points, of full scale"
    error = residual / np.sqrt(max(2 * (x.size - 1), 1))
    return made, Curve(x, y), Finding("response_residual", residual, error, says, share=True)


def _rms(response: Response, x: Floats, y: Floats) -> float:
    return float(np.sqrt(np.mean((response.reading(x) - y) ** 2)))


def _fitted(family: type[Power] | type[Logarithmic], x: Floats, y: Floats) -> Response:
    """Return the member of a family of one constant that comes closest, by a search that narrows down."""
    low, high = (np.log(0.1), np.log(10.0)) if family is Power else (np.log(1e-3), np.log(1e5))
    for _ in range(12):
        grid = np.linspace(low, high, 17)
        left = [_rms(family(float(np.exp(c))), x, y) for c in grid]
        i = int(np.argmin(left))
        low, high = grid[max(i - 1, 0)], grid[min(i + 1, grid.size - 1)]
    return family(float(np.exp((low + high) / 2)))


def _left_out(x: Floats, y: Floats) -> float:
    """Return what a table leaves of each point that it is not told of."""
    left = []
    for i in range(1, x.size - 1):
        keep = np.arange(x.size) != i
        left.append(float(np.interp(x[i], np.r_[0.0, x[keep]], np.r_[0.0, y[keep]]) - y[i]))
    return float(np.sqrt(np.mean(np.square(left)))) if left else 0.0
