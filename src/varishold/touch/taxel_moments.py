"""How a contact's taxels lie about its centre, whatever its sections."""

from __future__ import annotations

import math

import numpy as np

from varishold.files.compiling import njit
from varishold.levelset.columns import BOTTOM, LEFT, N_TAXELS, RIGHT, TOP

__all__ = ["PER_WEIGHT", "WEIGHTS", "contact_taxels", "weighted_moments", "weights_of"]

#: How taxels are weighed: by their height, by its square, or nearly all alike.
WEIGHTS = ("height", "height_squared", "base")
#: Group and name of every number of a weight, in the order in which `weighted_moments` returns them.
PER_WEIGHT = (
    ("volume", "spread"),
    ("volume", "peakedness"),
    ("elongation", "moment_2"),
    ("outline", "moment_3"),
    ("outline", "moment_4"),
    ("outline", "moment_6"),
)
# A taxel so many times its height above the floor counts whole in the base.
_BASE_GAIN = 2.5


@njit(cache=True, nogil=True)
def contact_taxels(padded, label, index, place, floor, span):  # type: ignore[no-untyped-def]
    """Return the columns, rows and heights of a contact's taxels, the heights from 0 at the floor to 1.

    `padded`, `label` and `place` are its frame's, as in `varishold.levelset.contact.Frame`.
    """
    cols, rows, height = np.empty(place[N_TAXELS]), np.empty(place[N_TAXELS]), np.empty(place[N_TAXELS])
    n = 0
    for r in range(place[TOP], place[BOTTOM] + 1):
        for c in range(place[LEFT], place[RIGHT] + 1):
            if label[r, c] == index:
                cols[n], rows[n] = c, r
                height[n] = max((padded[r, c] - floor) / span, 0.0)
                n += 1
    return cols, rows, height


@njit(cache=True, nogil=True)
def weights_of(height):  # type: ignore[no-untyped-def]
    """Return the taxels' weights, one row for each of `WEIGHTS`."""
    weights = np.empty((len(WEIGHTS), height.size))
    for i in range(height.size):
        weights[0, i] = height[i]
        weights[1, i] = height[i] * height[i]
        weights[2, i] = min(_BASE_GAIN * height[i], 1.0)
    return weights


@njit(cache=True, nogil=True)
def weighted_moments(x, y, weight, area):  # type: ignore[no-untyped-def]
    """Return the numbers of one weight, in the order of `PER_WEIGHT`, then the centre (x, y).

    Parameters
    ----------
    x, y : ndarray of shape (n,), float64
        Where the taxels are, in units of which one taxel has the area 1.
    weight : ndarray of shape (n,), float64
    area : float
        Of the lowest section, in taxels.
    """
    total, mx, my = 0.0, 0.0, 0.0
    for i in range(x.size):
        total += weight[i]
        mx += weight[i] * x[i]
        my += weight[i] * y[i]
    total = max(total, 1e-12)
    cx, cy = mx / total, my / total
    r2, r3, r4, r6 = 0.0, 0.0, 0.0, 0.0
    # Sums of z^n with z = x + i y: how much the taxels look the same after an n-th of a turn.
    re2, im2, re3, im3, re4, im4, re6, im6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(x.size):
        w, u, v = weight[i], x[i] - cx, y[i] - cy
        square = u * u + v * v
        zr, zi = u * u - v * v, 2.0 * u * v
        fourth_r, fourth_i = zr * zr - zi * zi, 2.0 * zr * zi
        r2 += w * square
        r3 += w * square * math.sqrt(square)
        r4 += w * square * square
        r6 += w * square * square * square
        re2 += w * zr
        im2 += w * zi
        re3 += w * (zr * u - zi * v)
        im3 += w * (zr * v + zi * u)
        re4 += w * fourth_r
        im4 += w * fourth_i
        re6 += w * (fourth_r * zr - fourth_i * zi)
        im6 += w * (fourth_r * zi + fourth_i * zr)
    r2 = max(r2, 1e-12)
    numbers = (
        2.0 * math.pi * r2 / total / area,
        r4 * total / (r2 * r2) - 1.0,
        math.hypot(re2, im2) / r2,
        math.hypot(re3, im3) / max(r3, 1e-12),
        math.hypot(re4, im4) / max(r4, 1e-12),
        math.hypot(re6, im6) / max(r6, 1e-12),
    )
    return numbers, cx, cy
