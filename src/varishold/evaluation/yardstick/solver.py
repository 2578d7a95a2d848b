"""The elastic contact of a rigid face, solved for measuring alone.

p >= 0 and G p - depth + gap >= 0, one of the two zero in every cell, by conjugate gradients projected on p >= 0
(Polonsky and Keer 1999). G is a bonded layer's compliance in the wave domain, or the displacement of a half-space
under a loaded rectangle (Love 1929). Lengths are in taxels, pressures in units of the modulus.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

__all__ = ["CELLS", "Spectrum", "half_space_response", "layer_compliance", "solve", "waves"]

Floats = NDArray[np.float64]
Spectrum = NDArray[np.float64] | NDArray[np.complex128]

#: Cells along a taxel.
CELLS = 3
_STEPS = 150
_CLOSE_ENOUGH = 3e-4


@lru_cache(maxsize=8)
def waves(size: int) -> Floats:
    """Return wave numbers in radians a taxel, as `rfft2` orders them."""
    ky = 2 * np.pi * fft.fftfreq(size, 1 / CELLS)
    kx = 2 * np.pi * fft.rfftfreq(size, 1 / CELLS)
    return np.hypot(ky[:, None], kx[None, :])


def layer_compliance(size: int, thick: float, nu: float) -> Floats:
    """Return a bonded layer's compliance by wave number, for a Young's modulus of 1."""
    k = waves(size)
    a = np.minimum(2 * k * thick, 60.0)
    over = (3 - 4 * nu) * np.sinh(a) - a
    under = (3 - 4 * nu) * np.cosh(a) + a**2 / 2 + 5 - 12 * nu + 8 * nu**2
    with np.errstate(invalid="ignore", divide="ignore"):
        compliance = 2 * (1 - nu**2) / k * over / under
    compliance[0, 0] = thick * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    return compliance


@lru_cache(maxsize=8)
def half_space_response(size: int, n: int) -> NDArray[np.complex128]:
    """Return the spectrum of the displacement under one loaded cell, for linear convolution of n x n cells."""
    cell = np.arange(size)
    at = np.where(cell < n, cell, cell - size) / CELLS
    half = 0.5 / CELLS

    def corner(x: Floats, y: Floats) -> Floats:
        r = np.hypot(x, y)
        return x * np.log(y + r) + y * np.log(x + r)

    x, y = np.abs(at)[None, :], np.abs(at)[:, None]
    # |x| - half may be negative: corner() needs y + r > 0, which holds off the axes.
    kernel = (
        corner(x + half, y + half)
        - corner(x - half, y + half)
        - corner(x + half, y - half)
        + corner(x - half, y - half)
    ) / np.pi
    return fft.rfft2(kernel)


def solve(overlap: Floats, spectrum: Spectrum, size: int) -> Floats:
    """Return the pressure of a contact: p >= 0, G p = overlap where p > 0, G p >= overlap elsewhere."""
    n = overlap.shape[0]

    def lifted(p: Floats) -> Floats:
        return fft.irfft2(fft.rfft2(p, (size, size)) * spectrum, (size, size))[:n, :n]

    # Where the object does not overlap the plane at rest it cannot touch: pressed skin sinks.
    may = overlap > 0
    p = np.where(may, overlap, 0.0)
    p *= (overlap * p).sum() / (p * lifted(p)).sum()
    step, last, was_changed = np.zeros_like(p), 1.0, True
    scale = overlap.max()
    for _ in range(_STEPS):
        r = np.where(may, lifted(p) - overlap, 0.0)
        active = p > 0
        off = np.sqrt((r[active] ** 2).mean())
        if off < _CLOSE_ENOUGH * scale and not np.any(r[may & ~active] < -_CLOSE_ENOUGH * scale):
            break
        size_now = (r[active] ** 2).sum()
        step = np.where(active, r + (0.0 if was_changed else size_now / last) * step, 0.0)
        last = size_now
        bent = lifted(step)
        p = p - (r[active] * step[active]).sum() / (bent[active] * step[active]).sum() * step
        p = np.maximum(p, 0.0)
        length = (r[active] * step[active]).sum() / (bent[active] * step[active]).sum()
        enters = may & (p == 0) & (r < 0)
        was_changed = bool(enters.any())
        p[enters] -= length * r[enters]
    return p
