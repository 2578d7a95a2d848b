"""The compiled fit of a section to capsules, one turn after another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.files.compiling import njit

__all__ = ["fit_ball", "fit_turns", "meeting"]

Floats = NDArray[np.float64]

# What is known before: the middle near the palm's axis, the size within a hand's reach, growth of a slender cone.
_MIDDLE_SPREAD_M, _USUAL_SIZE_M, _SIZE_SPREAD_M, _TURN_SPREAD, _GROWTH_SPREAD = 0.06, 0.08, 0.08, 0.5, 0.6
_HEIGHT_SPREAD_M, _FIXED = 0.02, 1e12

# A part that is farther off than so many standard deviations touches something else and counts less.
_BOUND = 4.0
# The same of a part that touches something for certain, but perhaps not the object.
_LOOSE_BOUND = 1.0

# From either side of most objects, so that a finger on the wrong side of a corner finds over.
_FIRST_SIZES_M = (0.045, 0.09)

# Parts that are so near each other touch. Metres.
_NEAR_M = 0.0015

# No section of size 1 reaches farther than 1 from its middle; beyond it by so much a part cannot touch. Metres.
_CLEAR_M = 0.005

_MOST_STEPS = 15
_ENOUGH_M = 2e-6


@njit(cache=True)
def _nearest_on_line(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    dx, dy = bx - ax, by - ay
    along = dx * dx + dy * dy
    t = 0.0 if along == 0.0 else ((px - ax) * dx + (py - ay) * dy) / along
    t = min(1.0, max(0.0, t))
    return ax + t * dx, ay + t * dy


@njit(cache=True)
def _closest(
    ax: float, ay: float, bx: float, by: float, corners: Floats, cx: float, cy: float
) -> tuple[float, float, float, float, float]:
    """Distance of a line from a polygon about c, and the nearest points of polygon and line; negative inside."""
    n = corners.shape[0]
    best = np.inf
    kx = ky = lx = ly = 0.0
    for k in range(n):
        vx, vy = cx + corners[k, 0], cy + corners[k, 1]
        qx, qy = _nearest_on_line(vx, vy, ax, ay, bx, by)
        d = (qx - vx) ** 2 + (qy - vy) ** 2
        if d < best:
            best, kx, ky, lx, ly = d, vx, vy, qx, qy
        if n > 1:
            wx, wy = cx + corners[(k + 1) % n, 0], cy + corners[(k + 1) % n, 1]
            for end in range(2):
                ex, ey = (ax, ay) if end == 0 else (bx, by)
                qx, qy = _nearest_on_line(ex, ey, vx, vy, wx, wy)
                d = (qx - ex) ** 2 + (qy - ey) ** 2
                if d < best:
                    best, kx, ky, lx, ly = d, qx, qy, ex, ey
    inside = n > 2
    if n > 2:
        for k in range(n):
            vx, vy = corners[k, 0], corners[k, 1]
            wx, wy = corners[(k + 1) % n, 0], corners[(k + 1) % n, 1]
            if (wx - vx) * (ly - cy - vy) - (wy - vy) * (lx - cx - vx) < 0:
                inside = False
                break
    distance = np.sqrt(best)
    return (-distance if inside else distance), kx, ky, lx, ly


@njit(cache=True)
def _beyond(start: Floats, end: Floats, i: int, cx: float, cy: float) -> float:
    """Distance of a part from c in the plane."""
    qx, qy = _nearest_on_line(cx, cy, start[i, 0], start[i, 1], end[i, 0], end[i, 1])
    return float(np.sqrt((qx - cx) ** 2 + (qy - cy) ** 2))


@njit(cache=True)
def _solve(matrix: Floats, right: Floats, n: int) -> Floats:
    """Solve a small symmetric positive system; both arguments are overwritten."""
    for j in range(n):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] ** 2
        matrix[j, j] = np.sqrt(max(matrix[j, j], 1e-300))
        for i in range(j + 1, n):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]
    return right


@njit(cache=True)
def fit_turns(
    start: Floats,
    end: Floats,
    radius: Floats,
    touch: NDArray[np.int64],
    corners: Floats,
    rounding: float,
    turns: Floats,
    grows: bool,
    sigma: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Fit middle, size, turn and growth, beginning at every turn.

    Parameters
    ----------
    start, end : ndarray of shape (n, 3)
        Metres.
    radius : ndarray of shape (n,)
        Metres.
    touch : ndarray of shape (n,), int
        2 for a part that must be just so far off, 1 for one that may be, 0 for one that must be at least so far off.
    corners : ndarray of shape (n_corners, 2)
        Of the section of size 1.
    rounding : float
        Radius around the corners, of the section of size 1.
    turns : ndarray of shape (n_turns,)
        Radians.
    grows : bool
    sigma : float
        Standard deviation of one part's distance. Metres.

    Returns
    -------
    found : ndarray of shape (n_turns, 5)
        Middle x and y, size (metres), turn (radians) and growth.
    off : ndarray of shape (n_turns, n)
        Distance less what it should be. Metres.
    cost : ndarray of shape (n_turns,)
    variance : ndarray of shape (n_turns,)
        Of the size. Square metres.
    """
    n, turns_too = start.shape[0], corners.shape[0] > 1
    found = np.zeros((turns.size, 5))
    offs = np.zeros((turns.size, n))
    costs = np.full(turns.size, np.inf)
    variances = np.zeros(turns.size)
    spread = np.array([_MIDDLE_SPREAD_M, _MIDDLE_SPREAD_M, _SIZE_SPREAD_M, _TURN_SPREAD, _GROWTH_SPREAD])
    weight = spread**-2.0
    # What is not asked for stays as it is.
    if not turns_too:
        weight[3] = _FIXED
    if not grows:
        weight[4] = _FIXED
    usual = np.array([_USUAL_SIZE_M / 2, 0.0, _USUAL_SIZE_M, 0.0, 0.0])
    scaled = np.empty_like(corners)
    row = np.zeros(5)
    off_now = np.zeros(n)
    for t in range(turns.size):
        usual[3] = turns[t]
        for first in _FIRST_SIZES_M:
            x = usual.copy()
            x[2] = first
            cost = 0.0
            information = np.eye(5)
            for step in range(_MOST_STEPS + 1):
                information = np.diag(weight)
                toward = weight * (usual - x)
                cost = 0.5 * np.sum(weight * (usual - x) ** 2)
                c, s = np.cos(x[3]), np.sin(x[3])
                for i in range(n):
                    z = (start[i, 2] + end[i, 2]) / 2
                    size = max(0.004, x[2] + x[4] * z)
                    if touch[i] == 0 and _beyond(start, end, i, x[0], x[1]) > size + radius[i] + _CLEAR_M:
                        off_now[i] = _CLEAR_M
                        continue
                    for k in range(corners.shape[0]):
                        scaled[k, 0] = size * (c * corners[k, 0] - s * corners[k, 1])
                        scaled[k, 1] = size * (s * corners[k, 0] + c * corners[k, 1])
                    d, kx, ky, lx, ly = _closest(start[i, 0], start[i, 1], end[i, 0], end[i, 1], scaled, x[0], x[1])
                    sign = -1.0 if d < 0 else 1.0
                    length = max(abs(d), 1e-9)
                    ux, uy = sign * (lx - kx) / length, sign * (ly - ky) / length
                    off = d - rounding * size - radius[i]
                    off_now[i] = off
                    if off >= 0.0 and touch[i] == 0:
                        continue
                    # Cauchy's bounded influence.
                    bound = _LOOSE_BOUND if off > 0.0 and touch[i] == 1 else _BOUND
                    share = 1.0 / (1.0 + (off / (bound * sigma)) ** 2)
                    cost += 0.5 * bound**2 * np.log(1.0 + (off / (bound * sigma)) ** 2)
                    arm_x, arm_y = kx - x[0], ky - x[1]
                    row[0], row[1] = -ux, -uy
                    row[2] = -(ux * arm_x + uy * arm_y) / size - rounding
                    row[3] = ux * arm_y - uy * arm_x
                    row[4] = row[2] * z
                    w = share / sigma**2
                    for j in range(5):
                        toward[j] -= w * row[j] * off
                        for k in range(5):
                            information[j, k] += w * row[j] * row[k]
                if step == _MOST_STEPS:
                    break
                move = _solve(information.copy(), toward, 5)
                largest = max(abs(move[0]), abs(move[1]), abs(move[2]), abs(move[3]) * 0.05)
                # No step may carry the section past the hand.
                x += min(1.0, 0.015 / max(largest, 1e-12)) * move
                x[2] = min(max(x[2], 0.005), 0.5)
                if largest < _ENOUGH_M:
                    break
            if cost < costs[t]:
                costs[t] = cost
                found[t] = x
                offs[t] = off_now
                variances[t] = np.linalg.inv(information)[2, 2]
    return found, offs, costs, variances


@njit(cache=True)
def meeting(
    start: Floats, end: Floats, radius: Floats, half_height: Floats, digit: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Tell which parts meet a part of another digit, so that what they touch may be that.

    Parameters
    ----------
    start, end : ndarray of shape (n, 3)
        Metres.
    radius, half_height : ndarray of shape (n,)
        Metres.
    digit : ndarray of shape (n,), int
        Which digit each part belongs to.

    Returns
    -------
    ndarray of shape (n,), bool
    """
    n = start.shape[0]
    out = np.zeros(n, np.bool_)
    for i in range(n):
        for k in range(n):
            if digit[i] == digit[k]:
                continue
            apart = abs(start[i, 2] + end[i, 2] - start[k, 2] - end[k, 2]) / 2
            if apart > half_height[i] + half_height[k]:
                continue
            line = np.empty((2, 2))
            line[0, 0], line[0, 1], line[1, 0], line[1, 1] = start[k, 0], start[k, 1], end[k, 0], end[k, 1]
            d, _, _, _, _ = _closest(start[i, 0], start[i, 1], end[i, 0], end[i, 1], line, 0.0, 0.0)
            if abs(d) < radius[i] + radius[k] + _NEAR_M:
                out[i] = True
    return out


@njit(cache=True)
def fit_ball(
    start: Floats, end: Floats, radius: Floats, touch: NDArray[np.int64], sigma: float
) -> tuple[Floats, float]:
    """Fit a ball, whose middle may be at any height; arguments as of `fit_turns`.

    Returns
    -------
    found : ndarray of shape (4,)
        Middle x, y and z, and diameter. Metres.
    cost : float
    """
    n = start.shape[0]
    usual = np.array([_USUAL_SIZE_M / 2, 0.0, 0.0, _USUAL_SIZE_M])
    weight = np.array([_MIDDLE_SPREAD_M, _MIDDLE_SPREAD_M, _HEIGHT_SPREAD_M, _SIZE_SPREAD_M]) ** -2.0
    found, least = usual.copy(), np.inf
    row, apart = np.zeros(4), np.zeros(3)
    for first in _FIRST_SIZES_M:
        x = usual.copy()
        x[3] = first
        cost = 0.0
        information = np.eye(4)
        for step in range(_MOST_STEPS + 1):
            information = np.diag(weight)
            toward = weight * (usual - x)
            cost = 0.5 * np.sum(weight * (usual - x) ** 2)
            for i in range(n):
                along = end[i] - start[i]
                length2 = np.sum(along * along)
                share = 0.0 if length2 == 0.0 else np.sum((x[:3] - start[i]) * along) / length2
                apart[:] = start[i] + min(1.0, max(0.0, share)) * along - x[:3]
                d = np.sqrt(np.sum(apart * apart)) + 1e-12
                off_i = d - x[3] / 2 - radius[i]
                if off_i >= 0.0 and touch[i] == 0:
                    continue
                bound = _LOOSE_BOUND if off_i > 0.0 and touch[i] == 1 else _BOUND
                part = 1.0 / (1.0 + (off_i / (bound * sigma)) ** 2)
                cost += 0.5 * bound**2 * np.log(1.0 + (off_i / (bound * sigma)) ** 2)
                row[:3] = -apart / d
                row[3] = -0.5
                w = part / sigma**2
                for j in range(4):
                    toward[j] -= w * row[j] * off_i
                    for k in range(4):
                        information[j, k] += w * row[j] * row[k]
            if step == _MOST_STEPS:
                break
            move = _solve(information.copy(), toward, 4)
            largest = np.abs(move).max()
            x += min(1.0, 0.015 / max(largest, 1e-12)) * move
            x[3] = min(max(x[3], 0.005), 0.5)
            if largest < _ENOUGH_M:
                break
        if cost < least:
            least = cost
            found[:] = x
    return found, least
