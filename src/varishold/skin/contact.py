"""The contact problem: where a rigid face touches a skin, and how hard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.sensor.cover import Skin
from varishold.skin.face import Face
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, Medium, medium_of
from varishold.skin.nonnegative import Nonnegative, solve_nonnegative

__all__ = ["Contact", "contact_box", "partial_springs", "solve_contact"]

Floats = NDArray[np.float64]
Floating = NDArray[np.floating[Any]]

# Single precision carries a residual down to about this share of the depth; below it, double is needed.
_SINGLE_LIMIT = 3e-6
# A coarser grid's answer is only a start, and need not be better than this share of the depth.
_COARSE_TOLERANCE = 2e-3
# Boxes are cut in steps of this many cells, so that few transform sizes occur and two coarser grids fit.
_BOX_STEP = 8
# A box smaller than this gains nothing from a coarser grid.
_SMALLEST_COARSE = 24
# Cells without a face are held this many depths away.
_NO_FACE = 100.0


@dataclass(frozen=True)
class Contact:
    """A solved contact, for a contact modulus of 1.

    Parameters
    ----------
    pressure, displacement_m, gap_m : ndarray of shape (rows, cols), float64
        Surface pressure, how far the surface is pressed down, and the distance left to the face.
    rms_gap : float
        Root mean square of the gap over contact and penetration, as a share of the depth.
    iterations : int
        Steps on the finest grid.
    """

    pressure: Floats
    displacement_m: Floats
    gap_m: Floats
    rms_gap: float
    iterations: int


def solve_contact(
    face: Face,
    skin: Skin,
    cells: Cells,
    depth: float,
    tolerance: float,
    max_iterations: int,
    start: Floats | None = None,
) -> Contact:
    """Solve the contact of a face pressed `depth` metres deep."""
    medium = medium_of(skin)
    wanted = np.where(np.isfinite(face.below_top_m), depth - face.below_top_m, -_NO_FACE * depth)
    wanted = np.maximum(wanted, -_NO_FACE * depth)
    inside = wanted > 0
    if start is not None:
        inside = inside | (start > 0)
    if not inside.any():
        raise InputError(f"nothing touches at a depth of {depth:g} m")
    pressure = np.zeros_like(wanted) if start is None else start
    steps = 0
    single = tolerance >= _SINGLE_LIMIT
    goal = tolerance
    while True:
        whole = influence_of(medium, cells, cells.rows, cells.cols, single=single)
        box = contact_box(inside)
        part = _solve_box(
            medium,
            cells,
            wanted[box],
            face.loaded[box],
            pressure[box],
            goal * depth,
            max_iterations - steps,
            single,
        )
        steps += part.iterations
        pressure = np.zeros_like(wanted)
        pressure[box] = part.x
        displacement = whole.displacement(pressure.astype(whole.dtype)).astype(np.float64)
        gap = displacement + partial_springs(medium, whole.own, face.loaded) * pressure - wanted
        open_ = (pressure > 0) | (gap < 0)
        rms = float(np.sqrt(np.mean(gap[open_] ** 2))) / depth if open_.any() else 0.0
        if rms <= tolerance or steps >= max_iterations:
            break
        # Either the skin bulged up to the body outside the box, or single precision did not reach.
        bulged = (gap < -0.1 * tolerance * depth) & ~_in_box(box, gap.shape)
        if bulged.any():
            inside = inside | bulged
        else:
            if part.iterations == 0 or not single:
                goal /= 2
            single = False
    return Contact(pressure, displacement, np.where(wanted > -_NO_FACE * depth, gap, np.inf), rms, steps)


def partial_springs(medium: Medium, own: float, loaded: Floats) -> Floats:
    """Return the compliance that cells add of which a wall leaves a part only, metres."""
    out = np.zeros_like(loaded)
    part = (loaded > 0) & (loaded < 1)
    out[part] = medium.partial_cell(loaded[part], own)
    return out


def _in_box(box: tuple[slice, slice], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    inside = np.zeros(shape, dtype=bool)
    inside[box] = True
    return inside


def contact_box(inside: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Smallest box around the marked cells, with a cell to spare, in steps of `_BOX_STEP` where it fits."""
    out = []
    for axis, length in ((1, inside.shape[0]), (0, inside.shape[1])):
        where = np.flatnonzero(inside.any(axis=axis))
        low, high = max(int(where[0]) - 1, 0), min(int(where[-1]) + 2, length)
        size = min(-(-(high - low) // _BOX_STEP) * _BOX_STEP, length)
        low = max(min(low, length - size), 0)
        out.append(slice(low, low + size))
    return out[0], out[1]


def _solve_box(
    medium: Medium,
    cells: Cells,
    wanted: Floats,
    loaded: Floats,
    start: Floats,
    tolerance: float,
    max_iterations: int,
    single: bool,
) -> Nonnegative:
    rows, cols = wanted.shape
    influence = influence_of(medium, cells, rows, cols, single=single)
    dtype = np.float32 if single else np.float64
    if not start.any() and rows % 2 == 0 and cols % 2 == 0 and min(rows, cols) >= _SMALLEST_COARSE:
        coarse_cells = Cells(-(-cells.rows // 2), -(-cells.cols // 2), cells.row_m * 2, cells.col_m * 2)
        rough = max(tolerance, _COARSE_TOLERANCE * float(wanted.max()))
        coarse = _solve_box(
            medium,
            coarse_cells,
            _halve(np.maximum(wanted, -2 * wanted.max())),
            np.where(_halve(loaded) > 0, 1.0, 0.0),
            np.zeros((rows // 2, cols // 2)),
            rough,
            max_iterations,
            True,
        )
        start = np.repeat(np.repeat(coarse.x, 2, axis=0), 2, axis=1)
        start = start * loaded
    spring: Floating = partial_springs(medium, influence.own, loaded).astype(dtype)
    if not spring.any():
        return solve_nonnegative(
            influence.displacement,
            influence.inverse,
            wanted.astype(dtype),
            start.astype(dtype),
            tolerance=tolerance,
            max_iterations=max_iterations,
        )
    # The rough inverse knows nothing of the springs; a partial cell is nearly its own and its spring's alone.
    ease: Floating = (1.0 / np.sqrt(1.0 + spring / influence.own)).astype(dtype)
    return solve_nonnegative(
        lambda p: influence.displacement(p) + spring * p,
        lambda r: ease * influence.inverse(ease * r),
        wanted.astype(dtype),
        start.astype(dtype),
        tolerance=tolerance,
        max_iterations=max_iterations,
    )


def _halve(values: Floats) -> Floats:
    out: Floats = values.reshape(values.shape[0] // 2, 2, values.shape[1] // 2, 2).mean(axis=(1, 3))
    return out
