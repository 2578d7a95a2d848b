"""Seeing the object through the skin: from a frame back to pressure, and on to the surface it makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from varishold.errors import InputError, require_a
from varishold.frame.checks import MOST_READ, as_floats, as_floor, as_pitch
from varishold.sensor.cover import Skin
from varishold.skin.contact_mask import AROUND, FEWEST_CORE, contact_mask, eroded
from varishold.skin.inversion import inversion_of
from varishold.skin.media import Cells

__all__ = ["Relief", "reconstruct"]

Floats = NDArray[np.float64]

# Cells of the answer along each side of a taxel.
_PER_TAXEL = 2
# Penalty on pressure, as a share of its own even transmission, for noise of this share of the peak.
_PENALTY, _PENALTY_NOISE = 0.01, 0.015
# The penalty follows the noise within these bounds: less leaves rounding, more leaves nothing.
_LEAST_NOISE, _MOST_NOISE = 0.002, 0.15
# A frame whose highest value is less than this share of its lowest holds nothing.
_LEAST_PEAK = 1e-6
# A sensing depth beyond this many taxels leaves no form to see: noise is amplified 1900 times at 3.
_DEEPEST_TAXELS = 4.0


@dataclass(frozen=True)
class Relief:
    """A surface seen through a skin.

    All arrays have `per_taxel` cells along each side of a taxel, so that cell (i, j) belongs to taxel
    (i // per_taxel, j // per_taxel).

    Parameters
    ----------
    pressure : ndarray of shape (rows, cols), float64
        Surface pressure, in the frame's unit.
    displacement : ndarray of shape (rows, cols), float64
        How far the surface is pressed down: metres where the skin's modulus is known and the frame is in
        pascal, else the frame's unit times metres (metres but for an unknown factor).
    mask : ndarray of shape (rows, cols), bool
        The contact, without holes.
    core : ndarray of shape (rows, cols), bool
        The contact less one sensing depth along its border, where the displacement is sure.
    height : ndarray of shape (rows, cols), float64
        Displacement above the contact line with its tilt removed, on the core; 0 elsewhere. The
        object's form, in the unit of `displacement`: a frame that can be cut like any other.
    line : float
        Displacement of the free skin around the contact, from which `height` is measured.
    tilt : (float, float)
        Slope along x and y that was removed, displacement a metre.
    noise : float
        Standard deviation of `height` due to the frame's noise.
    pitch_m : (float, float)
        (row, column) spacing of the cells, metres.
    per_taxel : int
        Cells along each side of a taxel.
    iterations : int
        Steps of the solver.
    """

    pressure: Floats
    displacement: Floats
    mask: NDArray[np.bool_]
    core: NDArray[np.bool_]
    height: Floats
    line: float
    tilt: tuple[float, float]
    noise: float
    pitch_m: tuple[float, float]
    per_taxel: int
    iterations: int


def reconstruct(
    frame: ArrayLike,
    skin: Skin,
    *,
    pitch: float | tuple[float, float],
    noise: float | None = None,
    start: Relief | None = None,
) -> Relief:
    """Find the pressure that makes a frame, and the surface that makes the pressure.

    The pressure minimizes ``|B T p - y|^2 + lambda |p|^2`` over p >= 0, with T the skin's transmission to the
    sensing depth and B the mean over a taxel; lambda follows the noise. Its contact is masked, and the
    displacement G p is taken there, without its tilt, above the free skin around it.

    Parameters
    ----------
    frame : array_like of shape (rows, cols)
        Stress over each taxel, zero where nothing touches. Broken taxels must be filled before.
    skin : Skin
        The skin over the taxels.
    pitch : float or (float, float)
        Taxel spacing in metres, one for both ways or (row, column).
    noise : float, optional
        Standard deviation of the frame's noise, in its unit; default: estimated from the frame.
    start : Relief, optional
        The answer for the frame before, of the same pad: on a stream the solver goes on from it.

    Returns
    -------
    Relief

    Raises
    ------
    InputError
        If the frame is not a finite array of two dimensions with something on it, the pitch is impossible,
        or the taxels are too fine or too shallow a sample for the sensing depth.

    Examples
    --------
    >>> from varishold.skin import press, sense
    >>> from varishold.solids import Sphere
    >>> skin = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
    >>> pressed = press(Sphere(30e-3), skin, depth=1e-3)
    >>> relief = reconstruct(sense(pressed), skin, pitch=1e-3)
    >>> bool(abs(relief.displacement.max() / pressed.displacement_m.max() - 1) < 0.03)
    True
    """
    # Compiled code: whoever only presses need not wait for it.
    from varishold.frame import frame_noise

    given, spacing = _check(frame, skin, pitch)
    scale = float(given.max())
    if scale <= _LEAST_PEAK * float(-given.min()):
        raise InputError(f"the frame holds no contact: its largest value is {scale:g}")
    sigma = float(frame_noise(given)) if noise is None else as_floor(noise, "noise")
    share = min(max(sigma / scale, _LEAST_NOISE), _MOST_NOISE)
    # Few steps, so that few operators are made: the penalty's exact value does not matter.
    penalty = _PENALTY * 2.0 ** round(np.log2(share / _PENALTY_NOISE))
    operators = inversion_of(skin, given.shape[0], given.shape[1], spacing, penalty, _PER_TAXEL)
    warm = None if start is None or start.pressure.shape != operators.shape else start.pressure / scale
    pressure, iterations = operators.pressure((given / scale).astype(np.float32), warm)
    displacement = operators.displacement(pressure)
    mask = contact_mask(pressure, _PER_TAXEL)
    if not mask.any():
        raise InputError(f"the frame holds no contact: its largest value, {scale:g}, is drowned by what lies below 0")
    core = eroded(mask, skin.sensing_depth_m, operators.cells)
    tilt = _tilt(displacement, core, operators.cells)
    line = _line(displacement, mask, tilt, operators.cells)
    level = _without_tilt(displacement, core, tilt, operators.cells)
    height = np.where(core, np.maximum(level - line, 0.0), 0.0)
    to_displacement = scale / skin.contact_modulus
    return Relief(
        pressure=pressure * scale,
        displacement=displacement * to_displacement,
        mask=mask,
        core=core,
        height=height * to_displacement,
        line=line * to_displacement,
        tilt=(tilt[0] * to_displacement, tilt[1] * to_displacement),
        noise=sigma * operators.noise_gain / skin.contact_modulus,
        pitch_m=(operators.cells.row_m, operators.cells.col_m),
        per_taxel=_PER_TAXEL,
        iterations=iterations,
    )


def _check(frame: ArrayLike, skin: Skin, pitch: float | tuple[float, float]) -> tuple[Floats, tuple[float, float]]:
    given = as_floats(frame, 2, "a frame")
    if min(given.shape) < 3:
        raise InputError(f"a frame must have 3 x 3 taxels or more, got an array of shape {given.shape}")
    for right, must in ((np.isfinite(given), "finite"), (np.abs(given) <= MOST_READ, f"within +-{MOST_READ:g}")):
        if not right.all():
            row, col = np.argwhere(~right)[0]
            raise InputError(f"a frame must be {must}, got {given[row, col]} at (row, col) = ({row}, {col})")
    row_m, col_m = as_pitch(pitch, "pitch")
    require_a(Skin, skin, "skin", "as read_skin(path) gives it")
    if skin.sensing_depth_m > _DEEPEST_TAXELS * max(row_m, col_m):
        raise InputError(
            f"the taxels lie too deep to be seen through: sensing depth {skin.sensing_depth_m:g} m is more than "
            f"{_DEEPEST_TAXELS:g} times the pitch, {max(row_m, col_m):g} m"
        )
    if 0 < skin.sensing_depth_m < max(row_m, col_m) / (4 * _PER_TAXEL):
        raise InputError(
            f"the grid is too coarse for the sensing depth: a depth of {skin.sensing_depth_m:g} m needs a pitch "
            f"of {4 * _PER_TAXEL * skin.sensing_depth_m:g} m or less, got {max(row_m, col_m):g} m; "
            "or use 0 for taxels at the surface"
        )
    return given, (row_m, col_m)


def _points(cells: Cells) -> tuple[Floats, Floats]:
    """Places (x, y) of the cells, metres from the first."""
    y, x = np.indices((cells.rows, cells.cols), dtype=np.float64)
    return x * cells.col_m, y * cells.row_m


def _tilt(displacement: Floats, core: NDArray[np.bool_], cells: Cells) -> tuple[float, float]:
    """Slope of the plane that fits the displacement best over the core."""
    if np.count_nonzero(core) < FEWEST_CORE:
        return 0.0, 0.0
    x, y = _points(cells)
    x, y, u = x[core], y[core], displacement[core]
    x, y = x - x.mean(), y - y.mean()
    xx, xy, yy = x @ x, x @ y, y @ y
    determinant = xx * yy - xy * xy
    if determinant <= 1e-9 * xx * yy:
        return 0.0, 0.0
    xu, yu = x @ u, y @ u
    return float((yy * xu - xy * yu) / determinant), float((xx * yu - xy * xu) / determinant)


def _without_tilt(displacement: Floats, core: NDArray[np.bool_], tilt: tuple[float, float], cells: Cells) -> Floats:
    x, y = _points(cells)
    out: Floats = displacement - tilt[0] * (x - x[core].mean()) - tilt[1] * (y - y[core].mean())
    return out


def _line(displacement: Floats, mask: NDArray[np.bool_], tilt: tuple[float, float], cells: Cells) -> float:
    """Median displacement of the free skin one taxel around the contact; 0 where the contact fills the field."""
    around = ndimage.binary_dilation(mask, iterations=_PER_TAXEL, structure=AROUND)
    ring = around & ~ndimage.binary_dilation(mask, iterations=_PER_TAXEL - 1, structure=AROUND)
    if not ring.any():
        return 0.0
    level = _without_tilt(displacement, mask, tilt, cells)
    return float(np.median(level[ring]))
