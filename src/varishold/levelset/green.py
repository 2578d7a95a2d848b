"""Green's theorem on polygons: areas and moments as sums over directed line segments."""

from __future__ import annotations

import math

from numba import njit

__all__ = ["N_SUMS", "add_line", "add_outline"]

# Per threshold: area, x, y, xx, xy, yy, perimeter; the eighth column keeps them in one cache line.
N_SUMS = 8


@njit(cache=True, nogil=True, inline="always")
def add_line(sums, i, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """Add to sums[i] the integrals of x dy, x^2/2 dy, x y dy, x^3/3 dy, x^2 y/2 dy and x y^2 dy from p to q.

    Over a closed outline with the section on its left these are the integrals of 1, x, y, x^2, x y and y^2
    over the section.
    """
    dy = qy - py
    sx = px + qx
    pp, pq, qq = px * px, px * qx, qx * qx
    rr, rs, ss = py * py, py * qy, qy * qy
    sums[i, 0] += 0.5 * dy * sx
    sums[i, 1] += dy * (pp + pq + qq) * (1.0 / 6.0)
    sums[i, 2] += dy * (py * (sx + px) + qy * (sx + qx)) * (1.0 / 6.0)
    sums[i, 3] += dy * sx * (pp + qq) * (1.0 / 12.0)
    sums[i, 4] += dy * (py * (3.0 * pp + 2.0 * pq + qq) + qy * (pp + 2.0 * pq + 3.0 * qq)) * (1.0 / 24.0)
    sums[i, 5] += dy * (px * (3.0 * rr + 2.0 * rs + ss) + qx * (rr + 2.0 * rs + 3.0 * ss)) * (1.0 / 12.0)


@njit(cache=True, nogil=True, inline="always")
def add_outline(sums, i, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """Add a segment of an outline: its line integrals and its length."""
    add_line(sums, i, px, py, qx, qy)
    dx, dy = qx - px, qy - py
    sums[i, 6] += math.sqrt(dx * dx + dy * dy)
