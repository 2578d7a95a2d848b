"""Frames of pressed faces on four media, by a solver that is used for measuring alone.

- ideal: the height map, depth minus gap where that is positive, averaged over each taxel.
- cover: a bonded elastic layer .6 to 2 taxels thick, Poisson's ratio .2 to .45, read .3 to .8 of its thickness deep.
- half-space: read .4 to 1 taxel deep on a pad of 32, half that on one of 16 (the same skin, twice the pitch).
- surface: a half-space that is read where it is pressed: sharp edges and corners press without limit there.

On the elastic media `solver` solves the contact on cells of a third of a taxel. Every frame's peak is 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from varishold.evaluation.yardstick.forms import ENDLESS, KINDS, Change, Face, draw_face
from varishold.evaluation.yardstick.solver import CELLS, Spectrum, half_space_response, layer_compliance, solve, waves

__all__ = ["MEDIA", "clean_frames", "half_space_reading", "height_map", "pressed"]

Floats = NDArray[np.float64]

MEDIA = ("ideal", "cover", "half-space", "surface")
_IDEAL_CELLS = 6
# Taxels that are solved for beyond each border of the pad; edges and planes on a half-space take half a pad.
_MARGIN, _HALF_SPACE_MARGIN = 5, 8
#: Forms that taper are drawn so much larger, as they touch on less than they overlap.
_GROW = {"ideal": 1.0, "cover": 1.1, "half-space": 1.3, "surface": 1.3}
# Frames with fewer loaded taxels (of a pad of 32, of one of 16) are drawn again.
_LEAST_TAXELS = {32: 24, 16: 11}


def clean_frames(
    medium: str,
    side: int,
    change: Change,
    per_kind: int,
    seed: int,
    *,
    tick: Callable[[], object] = lambda: None,
) -> tuple[Floats, NDArray[np.str_]]:
    """Return frames of every kind without any fault, and the name of the form of each.

    Parameters
    ----------
    medium : str
        One of `MEDIA`.
    side : int
        Taxels a side, 16 or 32.
    change : Change
    per_kind : int
        Frames of each kind; fewer are the first of more.
    seed : int
    tick : callable
        Called after each kind.

    Returns
    -------
    frames : ndarray of shape (n_kinds * per_kind, side, side), float64
        Their peak is 1; values are those of single precision.
    kinds : ndarray of shape (n_kinds * per_kind,), str
    """
    made = []
    for k, kind in enumerate(KINDS):
        for index in range(per_kind):
            made.append(_draw(medium, side, change, (seed, side, MEDIA.index(medium), k, index), kind, index))
        tick()
    return np.array(made, np.float32).astype(np.float64), np.repeat(KINDS, per_kind)


def _draw(medium: str, side: int, change: Change, seed: tuple[int, ...], kind: str, index: int) -> Floats:
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
            return np.asarray(frame / peak)
    raise RuntimeError(f"no {kind} fits on {side} x {side} taxels with {change}")


def taxel_means(cells: Floats, n: int) -> Floats:
    """Return the means of n x n cells."""
    rows, cols = cells.shape[0] // n, cells.shape[1] // n
    return np.asarray(cells.reshape(rows, n, cols, n).mean(axis=(1, 3)))


def cell_centres(taxels: int, cells: int) -> tuple[Floats, Floats]:
    """Return x and y of the centres of cells, in taxels from the middle."""
    at = (np.arange(taxels * cells) + 0.5) / cells - taxels / 2
    x, y = np.meshgrid(at, at)
    return x, y


def height_map(face: Face, side: int) -> Floats:
    """Return how deep the face stands in each taxel."""
    x, y = cell_centres(side, _IDEAL_CELLS)
    return taxel_means(np.maximum(face.depth - face.gap(x, y), 0.0), _IDEAL_CELLS)


def pressed(face: Face, side: int, medium: str, rng: np.random.Generator) -> Floats:
    """Return the taxels of a face pressed into an elastic medium drawn at random."""
    if medium == "surface":
        return half_space_reading(face, side, 0.0)
    if medium == "half-space":
        return half_space_reading(face, side, rng.uniform(0.4, 1.0) * side / 32)
    n = (side + 2 * _MARGIN) * CELLS
    thick, nu, deep = rng.uniform(0.6, 2.0), rng.uniform(0.2, 0.45), rng.uniform(0.3, 0.8)
    size = fft.next_fast_len(n, real=True)
    return _reading(face, side, _MARGIN, layer_compliance(size, thick, nu), size, deep * thick)


def half_space_reading(face: Face, side: int, sensed: float) -> Floats:
    """Return the taxels of a face pressed into a half-space of E / (1 - nu^2) = 1, read `sensed` taxels deep."""
    margin = side // 2 if face.kind in ENDLESS else _HALF_SPACE_MARGIN
    n = (side + 2 * margin) * CELLS
    size = fft.next_fast_len(2 * n, real=True)
    return _reading(face, side, margin, half_space_response(size, n), size, sensed)


def _reading(face: Face, side: int, margin: int, spectrum: Spectrum, size: int, sensed: float) -> Floats:
    """Return the taxels' means of the stress at a depth of `sensed` taxels."""
    x, y = cell_centres(side + 2 * margin, CELLS)
    n = len(x)
    p = solve(face.depth - np.minimum(face.gap(x, y), 1e6), spectrum, size)
    k = waves(size)
    seen = fft.irfft2(fft.rfft2(p, (size, size)) * (1 + k * sensed) * np.exp(-k * sensed), (size, size))[:n, :n]
    return taxel_means(seen, CELLS)[margin:-margin, margin:-margin]
