"""Frames of pressed faces on three media, by a solver that is used for measuring alone.

- ideal: the height map, depth minus gap where that is positive, averaged over each taxel.
- cover: a bonded elastic layer .6 to 2 taxels thick, Poisson's ratio .2 to .45, read .3 to .8 of its thickness deep.
- half-space: read .4 to 1 taxel deep on a pad of 32, half that on one of 16 (the same skin, twice the pitch).

On the elastic media the contact problem p >= 0, G p - depth + gap >= 0, one of the two zero, is solved by conjugate
gradients projected on p >= 0 (Polonsky and Keer 1999), on cells of a third of a taxel; the Green's function is
the layer's in the wave domain, or the half-space's for a loaded rectangle (Love 1929). Every frame's peak is 1.
"""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy import fft

from benchmarks import _distort_forms
from benchmarks._distort_forms import ENDLESS, KINDS, Change, Face, draw_face

MEDIA = ("ideal", "cover", "half-space")
_CELLS = 3
_IDEAL_CELLS = 6
#: Taxels that are solved for beyond each border of the pad.
_MARGIN = {"cover": 5, "half-space": 8}
#: Forms that taper are drawn so much larger, as they touch on less than they overlap.
_GROW = {"ideal": 1.0, "cover": 1.1, "half-space": 1.3}
# Frames with fewer loaded taxels (of a pad of 32, of one of 16) are drawn again.
_LEAST_TAXELS = {32: 24, 16: 11}
_STEPS = 150
_CLOSE_ENOUGH = 3e-4
_OUT = Path(__file__).resolve().parents[1] / "out" / "touch_distortions"


def frames(medium: str, side: int, change: Change, per_kind: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return frames of every kind without any fault, and the name of the form of each.

    Kept in `out/` under a name that holds the drawing code's digest, so that a second run is quick.

    Parameters
    ----------
    medium : str
        One of `MEDIA`.
    side : int
        Taxels a side.
    change : Change
    per_kind : int
        Frames of each kind.
    seed : int

    Returns
    -------
    frames : ndarray of shape (n_kinds * per_kind, side, side), float64
        Their peak is 1.
    kinds : ndarray of shape (n_kinds * per_kind,), str
    """
    path = _OUT / f"{medium}-{side}-{change.key}-{per_kind}-seed{seed}-{_digest()}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return kept["frames"].astype(float), kept["kinds"]
    made = []
    for k, kind in enumerate(KINDS):
        for index in range(per_kind):
            made.append(_draw(medium, side, change, (seed, side, MEDIA.index(medium), k, index), kind, index))
    path.parent.mkdir(parents=True, exist_ok=True)
    stacked, named = np.array(made, np.float32), np.repeat(KINDS, per_kind)
    part = path.with_suffix(".part.npz")
    np.savez_compressed(part, frames=stacked, kinds=named)
    part.replace(path)
    return stacked.astype(float), named


def _digest() -> str:
    """Return a short digest of the drawing code: other code, other files."""
    source = b"".join(Path(file).read_bytes() for file in (__file__, str(_distort_forms.__file__)))
    return hashlib.sha256(source).hexdigest()[:10]


def _draw(medium: str, side: int, change: Change, seed: tuple[int, ...], kind: str, index: int) -> np.ndarray:
    for attempt in range(100):
        face = draw_face((*seed, attempt), kind, index, side, change, _GROW[medium])
        if face is None:
            continue
        if medium == "ideal":
            frame = height_map(face, side)
        else:
            frame = pressed(face, side, medium, np.random.default_rng((*seed, attempt, 1)))
        peak = frame.max()
        least = _LEAST_TAXELS[side] * (1 - change.cut) if kind not in ENDLESS else side
        if peak > 0 and np.count_nonzero(frame > 0.1 * peak) >= least:
            return frame / peak
    raise RuntimeError(f"no {kind} fits on {side} x {side} taxels with {change}")


def taxel_means(cells: np.ndarray, n: int) -> np.ndarray:
    """Return the means of n x n cells."""
    rows, cols = cells.shape[0] // n, cells.shape[1] // n
    return cells.reshape(rows, n, cols, n).mean(axis=(1, 3))


def cell_centres(taxels: int, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of the centres of cells, in taxels from the middle."""
    at = (np.arange(taxels * cells) + 0.5) / cells - taxels / 2
    x, y = np.meshgrid(at, at)
    return x, y


def height_map(face: Face, side: int) -> np.ndarray:
    """Return how deep the face stands in each taxel."""
    x, y = cell_centres(side, _IDEAL_CELLS)
    return taxel_means(np.maximum(face.depth - face.gap(x, y), 0.0), _IDEAL_CELLS)


def pressed(face: Face, side: int, medium: str, rng: np.random.Generator) -> np.ndarray:
    """Return the taxels of a face pressed into an elastic medium drawn at random."""
    margin = _MARGIN[medium]
    if medium == "half-space" and face.kind in ENDLESS:
        margin = side // 2
    n = (side + 2 * margin) * _CELLS
    x, y = cell_centres(side + 2 * margin, _CELLS)
    gap = np.minimum(face.gap(x, y), 1e6)
    if medium == "cover":
        thick, nu, deep = rng.uniform(0.6, 2.0), rng.uniform(0.2, 0.45), rng.uniform(0.3, 0.8)
        size = fft.next_fast_len(n, real=True)
        spectrum = _layer(size, thick, nu)
        sensed = deep * thick
    else:
        size = fft.next_fast_len(2 * n, real=True)
        spectrum = _half_space(size, n)
        sensed = rng.uniform(0.4, 1.0) * side / 32
    p = _solve(face.depth - gap, spectrum, size)
    k = _waves(size)
    seen = fft.irfft2(fft.rfft2(p, (size, size)) * (1 + k * sensed) * np.exp(-k * sensed), (size, size))[:n, :n]
    return taxel_means(seen, _CELLS)[margin:-margin, margin:-margin]


@lru_cache(maxsize=8)
def _waves(size: int) -> np.ndarray:
    """Return wave numbers in radians a taxel, as `rfft2` orders them."""
    ky = 2 * np.pi * fft.fftfreq(size, 1 / _CELLS)
    kx = 2 * np.pi * fft.rfftfreq(size, 1 / _CELLS)
    return np.hypot(ky[:, None], kx[None, :])


def _layer(size: int, thick: float, nu: float) -> np.ndarray:
    """Return a bonded layer's compliance by wave number, for a Young's modulus of 1."""
    k = _waves(size)
    a = np.minimum(2 * k * thick, 60.0)
    over = (3 - 4 * nu) * np.sinh(a) - a
    under = (3 - 4 * nu) * np.cosh(a) + a**2 / 2 + 5 - 12 * nu + 8 * nu**2
    with np.errstate(invalid="ignore", divide="ignore"):
        compliance = 2 * (1 - nu**2) / k * over / under
    compliance[0, 0] = thick * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    return compliance


@lru_cache(maxsize=8)
def _half_space(size: int, n: int) -> np.ndarray:
    """Return the spectrum of the displacement under one loaded cell, for linear convolution of n x n cells."""
    at = np.arange(size)
    at = np.where(at < n, at, at - size) / _CELLS
    half = 0.5 / _CELLS

    def corner(x: np.ndarray, y: np.ndarray) -> np.ndarray:
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


def _solve(overlap: np.ndarray, spectrum: np.ndarray, size: int) -> np.ndarray:
    """Return the pressure of a contact: p >= 0, G p = overlap where p > 0, G p >= overlap elsewhere."""
    n = overlap.shape[0]

    def lifted(p: np.ndarray) -> np.ndarray:
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
