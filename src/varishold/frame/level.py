"""The rest of one frame: a slope or an offset, taken off where the taxels that nothing presses show it.

The rest is a plane that about a quarter of the field or more lies in, that hardly a taxel lies below, and that
something stands clearly above. A frame without such a plane, or whose plane is zero, stays as it is, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.files.compiling import njit
from varishold.frame.counts import count_of
from varishold.frame.noise import noise_sigma

__all__ = ["Levelled", "level", "level_into"]

# Of a larger frame only every so manyeth row and column is looked at.
_MOST_TAXELS = 64 * 64
# Readings that differ by less than this share of themselves show a plane that fills the field, not a rest.
_LEAST_SPAN = 0.01
# Where the search begins: this quantile of the values, and this share of the range to either side of it.
_QUANTILE, _BAND = 0.15, 0.25
_ROUNDS = 12
# Residuals beyond this many standard deviations are pressed, or another thing.
_KEPT = 3.0
# Share of the field that must lie in the plane, and that may lie below it.
_FEWEST_FREE, _MOST_BELOW = 0.22, 0.012
# The free taxels must reach over this share of the field's own spread, across as well as along.
_LEAST_SPREAD = 0.12
# A plane that stays within this share of the range is no rest but noise, or the skirt of a contact.
_LEAST_RISE = 0.04
# Nor is one that rises higher than this share of the range.
_MOST_RISE = 0.6
# The free taxels scatter as the noise does, or by this share of the range: a flank of a form scatters more.
_MOST_SCATTER_SIGMAS, _MOST_SCATTER = 1.5, 0.012
# What stands above must be at least so high (share of the range, sigmas) and so broad (taxels).
_STANDS, _STANDS_SIGMAS, _FEWEST_STANDING = 0.25, 8.0, 3
# And so many counts of the sensor.
_STANDS_COUNTS = 2.5
# Just above a rest there is little: at most this many times as many taxels as in it.
_MOST_NEAR = 0.3


@dataclass(frozen=True)
class Levelled:
    """A frame whose rest is zero.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        The frame; the same numbers where no rest was found.
    rest : (float, float, float)
        The plane that was taken off, in the unit of the frame: at the pad's first taxel, its rise by column and by row;
        zeros where nothing was.
    """

    values: NDArray[np.float64]
    rest: tuple[float, float, float]


@njit(nogil=True)
def _plane(frame, usable, at, by_col, by_row, band, out):  # type: ignore[no-untyped-def]
    """Fit a plane to the taxels within `band` of another; write (at, by col, by row, n, scatter, spread)."""
    rows, cols = frame.shape
    n, sx, sy, sxx, sxy, syy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sv, sxv, syv = 0.0, 0.0, 0.0
    my, mx = 0.5 * (rows - 1), 0.5 * (cols - 1)
    for r in range(rows):
        y = r - my
        for c in range(cols):
            if not usable[r, c]:
                continue
            v = frame[r, c]
            if abs(v - (at + by_col * c + by_row * r)) > band:
                continue
            x = c - mx
            n += 1.0
            sx += x
            sy += y
            sxx += x * x
            sxy += x * y
            syy += y * y
            sv += v
            sxv += x * v
            syv += y * v
    out[3] = n
    if n < 6.0:
        return
    cx, cy, cv = sx / n, sy / n, sv / n
    vxx, vxy, vyy = sxx / n - cx * cx, sxy / n - cx * cy, syy / n - cy * cy
    vxv, vyv = sxv / n - cx * cv, syv / n - cy * cv
    determinant = vxx * vyy - vxy * vxy
    whole_x, whole_y = (cols * cols - 1.0) / 12.0, (rows * rows - 1.0) / 12.0
    # The lesser of the two spreads, against those of the whole field.
    a, b, d = vxx / whole_x, vxy / np.sqrt(whole_x * whole_y), vyy / whole_y
    out[5] = 0.5 * (a + d) - np.sqrt(0.25 * (a - d) ** 2 + b * b)
    if not determinant > 1e-9 * (vxx * vyy + 1e-300):
        out[5] = 0.0
        return
    gx = (vxv * vyy - vyv * vxy) / determinant
    gy = (vyv * vxx - vxv * vxy) / determinant
    out[0] = cv - gx * (cx + mx) - gy * (cy + my)
    out[1], out[2] = gx, gy
    # What is pressed lies above the rest: how the rest scatters is told by what lies below it.
    total, m = 0.0, 0.0
    for r in range(rows):
        for c in range(cols):
            if usable[r, c]:
                residual = frame[r, c] - (at + by_col * c + by_row * r)
                new = frame[r, c] - (out[0] + gx * c + gy * r)
                if abs(residual) <= band and new <= 0.0:
                    total += new * new
                    m += 1.0
    out[4] = np.sqrt(total / m) if m > 0.0 else 0.0


@njit(nogil=True)
def level_into(frame, usable, sigma, rest):  # type: ignore[no-untyped-def]
    """Take the rest off a frame in place; the compiled core of `level`.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Overwritten everywhere if a rest was found; finite where usable.
    usable : ndarray of shape (rows, cols), bool
        Where the frame's values are to be believed.
    sigma : float
        Standard deviation of the frame's noise.
    rest : ndarray of shape (3,), float64
        Overwritten: the plane at (0, 0), its rise by column and by row.

    Returns
    -------
    bool
        Whether there was a rest to take off.
    """
    rest[:] = 0.0
    step = 1
    while (frame.shape[0] // step) * (frame.shape[1] // step) > _MOST_TAXELS:
        step += 1
    seen, seen_usable = frame[::step, ::step], usable[::step, ::step]
    rows, cols = seen.shape
    values = np.empty(rows * cols)
    n = 0
    for r in range(rows):
        for c in range(cols):
            if seen_usable[r, c]:
                values[n] = seen[r, c]
                n += 1
    if n < 16 or rows < 4 or cols < 4:
        return False
    ordered = np.partition(values[:n], int(_QUANTILE * n))
    start, peak, low = ordered[int(_QUANTILE * n)], values[:n].max(), values[:n].min()
    span = peak - low
    if not span > _LEAST_SPAN * max(abs(peak), abs(low)):
        return False
    plane = np.zeros(6)
    plane[0] = start
    band = _BAND * span
    for _ in range(_ROUNDS):
        _plane(seen, seen_usable, plane[0], plane[1], plane[2], band, plane)
        if plane[3] < max(_FEWEST_FREE * n, 8.0) or plane[5] < _LEAST_SPREAD:
            return False
        tighter = max(_KEPT * plane[4], _KEPT * sigma, 1e-6 * span)
        if tighter >= 0.98 * band:
            break
        band = tighter
    scatter = max(plane[4], sigma)
    corners = np.array(
        [0.0, plane[1] * (cols - 1), plane[2] * (rows - 1), plane[1] * (cols - 1) + plane[2] * (rows - 1)]
    )
    lowest, highest = plane[0] + corners.min(), plane[0] + corners.max()
    rise = max(abs(lowest), abs(highest))
    if plane[4] > max(_MOST_SCATTER_SIGMAS * sigma, _MOST_SCATTER * span) or highest - lowest > _MOST_RISE * span:
        return False
    if rise < max(_LEAST_RISE * span, 6.0 * scatter / np.sqrt(plane[3])):
        return False
    below, standing, near = 0, 0, 0
    clear = max(_STANDS * span, _STANDS_SIGMAS * scatter, _STANDS_COUNTS * count_of(frame, usable))
    for r in range(rows):
        for c in range(cols):
            if seen_usable[r, c]:
                residual = seen[r, c] - (plane[0] + plane[1] * c + plane[2] * r)
                below += residual < -max(_KEPT * scatter, 0.02 * span)
                standing += residual > clear
                near += (residual > band) & (residual <= 2.0 * band)
    if below > _MOST_BELOW * n or standing < _FEWEST_STANDING or near > _MOST_NEAR * plane[3]:
        return False
    rest[0], rest[1], rest[2] = plane[0], plane[1] / step, plane[2] / step
    for r in range(frame.shape[0]):
        for c in range(frame.shape[1]):
            frame[r, c] -= rest[0] + rest[1] * c + rest[2] * r
    return True


def level(frame: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> Levelled:
    """Take off the plane that the taxels lie in which nothing presses.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Finite inside the field.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is known to be broken.

    Returns
    -------
    Levelled

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[-6:6, -6:6]
    >>> frame = 50.0 + 5.0 * np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> taken = level(frame)
    >>> float(taken.values.max()), [round(v, 6) for v in taken.rest]
    (20.0, [50.0, 0.0, 0.0])
    """
    values = np.array(frame, dtype=np.float64, order="C")
    usable = np.ones(values.shape, np.bool_) if field is None else np.array(field, dtype=np.bool_)
    if valid is not None:
        usable &= np.asarray(valid, dtype=np.bool_)
    rest = np.zeros(3)
    level_into(values, usable, float(noise_sigma(values, usable, np.empty(values.size))), rest)
    return Levelled(values, (float(rest[0]), float(rest[1]), float(rest[2])))
