"""Green's theorem on polygons: areas and moments as sums over directed line segments."""

from __future__ import annotations

import math

from varishold.files.compiling import njit

__all__ = ["N_SUMS", "S_AREA", "S_LENGTH", "S_X", "S_XX", "S_XY", "S_Y", "S_YY", "add_line", "add_outline"]

#: Columns of the sums at each threshold: the integrals of 1, x, y, x^2, x y and y^2, and the outline's length. The
#: eighth keeps them in one cache line.
S_AREA, S_X, S_Y, S_XX, S_XY, S_YY, S_LENGTH = range(7)
N_SUMS = 8
# "contract" allows fused multiply-add, and nothing that changes what NaN or infinity do.


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
    sums[i, S_AREA] += dy * x
    sums[i, S_X] += dy * 0.5 * (xx + third_xx)
    sums[i, S_Y] += dy * (x * y + cross)
    sums[i, S_XX] += dy * x * (xx * (1.0 / 3.0) + third_xx)
    sums[i, S_XY] += dy * (0.5 * y * (xx + third_xx) + x * cross)
    sums[i, S_YY] += dy * (x * (y * y + hy * hy * (1.0 / 3.0)) + 2.0 * y * cross)
    return hx, hy


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def add_outline(sums, i, px, py, qx, qy):  # type: ignore[no-untyped-def]
    """Add a segment of an outline: its line integrals and its length."""
    hx, hy = add_line(sums, i, px, py, qx, qy)
    sums[i, S_LENGTH] += 2.0 * math.sqrt(hx * hx + hy * hy)
