"""Green's theorem on polygons: areas and moments as sums over directed line segments."""

from __future__ import annotations

import math

from varishold.files.compiling import njit

__all__ = ["N_SUMS", "add_line", "add_outline"]

# "contract" allows fused multiply-add, and nothing that changes what NaN or infinity do.
# Per threshold: area, x, y, xx, xy, yy, perimeter; the eighth column keeps them in one cache line.
N_SUMS = 8


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def add_line(sums, i, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """Add to sums[i] the integrals of x dy, x^2/2 dy, x y dy, x^3/3 dy, x^2 y/2 dy and x y^2 dy from p to q.

    Over a closed outline with the section on its left these are the integrals of 1, x, y, x^2, x y and y^2
    over the section. Written with the segment's middle and half its length, in which they are shortest.
    """
    x, y = 0.5 * (px + qx), 0.5 * (py + qy)
    hx, hy = 0.5 * (qx - px), 0.5 * (qy - py)
    dy = qy - py
    xx, third_xx, cross = x * x, hx * hx * (1.0 / 3.0), hx * hy * (1.0 / 3.0)
    sums[i, 0] += dy * x
    sums[i, 1] += dy * 0.5 * (xx + third_xx)
    sums[i, 2] += dy * (x * y + cross)
    sums[i, 3] += dy * x * (xx * (1.0 / 3.0) + third_xx)
    sums[i, 4] += dy * (0.5 * y * (xx + third_xx) + x * cross)
    sums[i, 5] += dy * (x * (y * y + hy * hy * (1.0 / 3.0)) + 2.0 * y * cross)
    return hx, hy


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def add_outline(sums, i, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """Add a segment of an outline: its line integrals and its length."""
    hx, hy = add_line(sums, i, px, py, qx, qy)
    sums[i, 6] += 2.0 * math.sqrt(hx * hx + hy * hy)
