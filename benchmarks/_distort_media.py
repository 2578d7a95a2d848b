"""Frames of pressed faces on three media, by a solver that is used for measuring alone.

- ideal: the height map, depth minus gap where that is positive, averaged over each taxel.
- cover: a bonded elastic layer .6 to 2 taxels thick, Poisson's ratio .2 to .45, read .3 to .8 of its thickness deep.
- half-space: read .4 to 1 taxel deep on a pad of 32, half that on one of 16 (the same skin, twice the pitch).

On the elastic media `_distort_solver` solves the contact on cells of a third of a taxel. Every frame's peak is 1.
"""

from __future__ import annotations

import ast
import hashlib
from pathlib import Path

import numpy as np
from scipy import fft

from benchmarks import _distort_forms, _distort_solver
from benchmarks._distort_forms import ENDLESS, KINDS, Change, Face, draw_face
from benchmarks._distort_solver import CELLS, half_space_response, layer_compliance, solve, waves

MEDIA = ("ideal", "cover", "half-space")
_IDEAL_CELLS = 6
# Taxels that are solved for beyond each border of the pad; edges and planes on a half-space take half a pad.
_MARGIN, _HALF_SPACE_MARGIN = 5, 8
#: Forms that taper are drawn so much larger, as they touch on less than they overlap.
_GROW = {"ideal": 1.0, "cover": 1.1, "half-space": 1.3}
# Frames with fewer loaded taxels (of a pad of 32, of one of 16) are drawn again.
_LEAST_TAXELS = {32: 24, 16: 11}
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
    """Return a short digest of the drawing code, docstrings apart: other code, other files."""
    modules = (__file__, str(_distort_forms.__file__), str(_distort_solver.__file__))
    code = ""
    for module in modules:
        tree = ast.parse(Path(module).read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                node.value.value = ""
        code += ast.dump(tree)
    return hashlib.sha256(code.encode()).hexdigest()[:10]


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
    if medium == "half-space":
        return half_space_reading(face, side, rng.uniform(0.4, 1.0) * side / 32)
    n = (side + 2 * _MARGIN) * CELLS
    thick, nu, deep = rng.uniform(0.6, 2.0), rng.uniform(0.2, 0.45), rng.uniform(0.3, 0.8)
    size = fft.next_fast_len(n, real=True)
    return _reading(face, side, _MARGIN, layer_compliance(size, thick, nu), size, deep * thick)


def half_space_reading(face: Face, side: int, sensed: float) -> np.ndarray:
    """Return the taxels of a face pressed into a half-space of E / (1 - nu^2) = 1, read `sensed` taxels deep."""
    margin = side // 2 if face.kind in ENDLESS else _HALF_SPACE_MARGIN
    n = (side + 2 * margin) * CELLS
    size = fft.next_fast_len(2 * n, real=True)
    return _reading(face, side, margin, half_space_response(size, n), size, sensed)


def _reading(face: Face, side: int, margin: int, spectrum: np.ndarray, size: int, sensed: float) -> np.ndarray:
    """Return the taxels' means of the stress at a depth of `sensed` taxels."""
    x, y = cell_centres(side + 2 * margin, CELLS)
    n = len(x)
    p = solve(face.depth - np.minimum(face.gap(x, y), 1e6), spectrum, size)
    k = waves(size)
    seen = fft.irfft2(fft.rfft2(p, (size, size)) * (1 + k * sensed) * np.exp(-k * sensed), (size, size))[:n, :n]
    return taxel_means(seen, CELLS)[margin:-margin, margin:-margin]
