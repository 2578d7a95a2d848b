"""Seeing the object through the skin: from a frame back to pressure, and on to the surface it makes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from varishold.errors import InputError
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, medium_of, wave_numbers
from varishold.skin.nonnegative import solve_nonnegative
from varishold.skin.properties import Skin
from varishold.skin.transmission import Transmission

__all__ = ["Relief", "reconstruct"]

Floats = NDArray[np.float64]
Floating = NDArray[np.floating[Any]]

# Cells of the answer along each side of a taxel.
_PER_TAXEL = 2
# Penalty on pressure, as a share of its own even transmission, for noise of this share of the peak.
_PENALTY, _PENALTY_NOISE = 0.01, 0.015
# The penalty follows the noise within these bounds: less leaves rounding, more leaves nothing.
_LEAST_NOISE, _MOST_NOISE = 0.002, 0.15
# The gradient may remain at this share of the data's own.
_TOLERANCE = 3e-3
_MOST_ITERATIONS = 60
# Share of the penalty that the pad's outermost cells bear.
_RIM_PENALTY = 0.5
# The contact reaches to where the pressure, smoothed over this share of a taxel, falls below this share of
# the highest within half a taxel around it, and of the whole frame's peak.
_SMOOTH_TAXELS = 0.28
_LOCAL_SHARE, _PEAK_SHARE = 0.35, 0.06
# A piece of the contact that carries less than this share of the load is noise.
_LEAST_LOAD = 0.03
# Up to so many taxels a matrix is faster than transforms, whose cost is then mostly the calls.
_MATRIX_TAXELS = 320
# A frame whose highest value is less than this share of its lowest holds nothing.
_LEAST_PEAK = 1e-6
# A sensing depth beyond this many taxels leaves no form to see: noise is amplified 1900 times at 3.
_DEEPEST_TAXELS = 4.0
# A core of fewer cells says nothing of a tilt.
_FEWEST_CORE = 12
_AROUND = np.ones((3, 3), dtype=bool)


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

    The pressure minimizes |B T p - y|^2 + lambda |p|^2 over p >= 0, with T the skin's transmission to the
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
    from varishold.recording import frame_noise

    given, spacing = _check(frame, skin, pitch)
    scale = float(given.max())
    if scale <= _LEAST_PEAK * float(-given.min()):
        raise InputError(f"the frame holds no contact: its largest value is {scale:g}")
    sigma = float(frame_noise(given)) if noise is None else float(noise)
    share = min(max(sigma / scale, _LEAST_NOISE), _MOST_NOISE)
    # Few steps, so that few operators are made: the penalty's exact value does not matter.
    penalty = _PENALTY * 2.0 ** round(np.log2(share / _PENALTY_NOISE))
    operators = _operators(skin, given.shape[0], given.shape[1], spacing, penalty)
    warm = None if start is None or start.pressure.shape != operators.shape else start.pressure / scale
    pressure, iterations = operators.pressure((given / scale).astype(np.float32), warm)
    displacement = operators.displacement(pressure)
    mask = _contact(pressure)
    core = _eroded(mask, skin.sensing_depth_m, operators.cells)
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
    given = np.asarray(frame, dtype=np.float64)
    if given.ndim != 2 or min(given.shape) < 3:
        raise InputError(f"a frame must have 3 x 3 taxels or more, got an array of shape {given.shape}")
    if not np.isfinite(given).all():
        row, col = np.argwhere(~np.isfinite(given))[0]
        raise InputError(f"a frame must be finite, got {given[row, col]} at (row, col) = ({row}, {col})")
    spacing = np.broadcast_to(np.asarray(pitch, dtype=np.float64), (2,))
    if not (np.isfinite(spacing).all() and (spacing > 0).all()):
        raise InputError(f"pitch must be positive metres, one number or (row, column) spacing, got {pitch!r}")
    row_m, col_m = float(spacing[0]), float(spacing[1])
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


class _Operators:
    """What `reconstruct` computes once for a skin, a pad and a penalty."""

    def __init__(self, skin: Skin, rows: int, cols: int, spacing: tuple[float, float], penalty: float) -> None:
        n = _PER_TAXEL
        self.cells = Cells(rows * n, cols * n, spacing[0] / n, spacing[1] / n)
        self.shape = (rows * n, cols * n)
        medium = medium_of(skin)
        self._transmission = Transmission(medium, self.cells, skin.sensing_depth_m, n, np.float32)
        self._influence = influence_of(medium, self.cells, *self.shape, single=True)
        # B B' has the gain 1 / n^2 at an even load.
        self._penalty = np.float32(penalty / n**2)
        # Where a face goes on beyond the pad, its pressure is singular along the pad's border.
        self._penalties = np.full(self.shape, self._penalty, dtype=np.float32)
        for rim in (self._penalties[:1], self._penalties[-1:], self._penalties[:, :1], self._penalties[:, -1:]):
            rim[...] = self._penalty * np.float32(_RIM_PENALTY)
        size = self._size = self._transmission.size
        ky, kx = wave_numbers(*size, self.cells.row_m, self.cells.col_m)
        mean = np.outer(np.sinc(ky * spacing[0] / (2 * np.pi)), np.sinc(kx * spacing[1] / (2 * np.pi)))
        symbol = self._transmission.symbol
        normal = (symbol * mean / n) ** 2 + self._penalty
        self._inverse = (1.0 / normal).astype(np.float32)
        self._matrix: Floating | None = None
        if rows * cols <= _MATRIX_TAXELS:
            units = np.eye(rows * cols, dtype=np.float32).reshape(-1, rows, cols)
            matrix = np.stack([self._transmission.adjoint(unit).ravel() for unit in units]).astype(np.float64)
            # Woodbury's identity: (L + M'M)^-1 = L^-1 - L^-1 M' (1 + M L^-1 M')^-1 M L^-1.
            core = np.linalg.inv(np.eye(rows * cols) + (matrix / self._penalties.ravel()) @ matrix.T)
            self._matrix, self._core = matrix.astype(np.float32), core.astype(np.float32)
        # Frame noise is white over taxels; B' spreads it over n^2 cells each with the weight 1 / n^2.
        k = np.hypot(ky[:, None], kx[None, :])
        k[0, 0] = min(ky[1], kx[1])
        gain = medium.compliance(k) * symbol * mean / n**2 / normal
        twice = np.full(kx.shape, 2.0)
        twice[0] = 1.0
        power = np.sum((gain * mean) ** 2 * twice[None, :]) / (size[0] * size[1])
        self.noise_gain = float(np.sqrt(power * n**2))

    def pressure(self, frame: Floating, start: Floats | None) -> tuple[Floats, int]:
        b = self._transmission.adjoint(frame)
        first = np.maximum(self._precondition(b), 0) if start is None else start.astype(np.float32)
        solved = solve_nonnegative(
            self._normal,
            self._precondition,
            b,
            first,
            tolerance=_TOLERANCE * float(np.sqrt(np.mean(b * b))),
            max_iterations=_MOST_ITERATIONS,
        )
        return solved.x.astype(np.float64), solved.iterations

    def _normal(self, pressure: Floating) -> Floating:
        if self._matrix is not None:
            seen: Floating = (self._matrix.T @ (self._matrix @ pressure.ravel())).reshape(pressure.shape)
        else:
            seen = self._transmission.adjoint(self._transmission.forward(pressure))
        out: Floating = seen + self._penalties * pressure
        return out

    def displacement(self, pressure: Floats) -> Floats:
        return self._influence.displacement(pressure.astype(np.float32)).astype(np.float64)

    def _precondition(self, residual: Floating) -> Floating:
        if self._matrix is not None:
            first = (residual / self._penalties).ravel()
            taken = (self._matrix.T @ (self._core @ (self._matrix @ first))).reshape(residual.shape)
            solved: Floating = first.reshape(residual.shape) - taken / self._penalties
            return solved
        spectrum = scipy.fft.rfft2(residual, s=self._size)
        spectrum *= self._inverse
        out: Floating = scipy.fft.irfft2(spectrum, s=self._size, overwrite_x=True)
        return out[: residual.shape[0], : residual.shape[1]]


@lru_cache(maxsize=32)
def _operators(skin: Skin, rows: int, cols: int, spacing: tuple[float, float], penalty: float) -> _Operators:
    return _Operators(skin, rows, cols, spacing, penalty)


def _contact(pressure: Floats) -> NDArray[np.bool_]:
    """Mark the contact: one piece, its holes filled.

    The border of a flat face stands where the pressure falls from its rim; that of a round one where it
    fades. A share of the highest pressure nearby finds both, a share of the frame's peak only one. Around a
    shoulder, which presses hardest, it leaves a gap, which is closed where pressure stands on both sides.
    """
    smooth = ndimage.gaussian_filter(pressure, _SMOOTH_TAXELS * _PER_TAXEL, truncate=3.0)
    loaded = _heaviest(smooth > _PEAK_SHARE * smooth.max(), pressure, alone=True)
    nearby = ndimage.maximum_filter(smooth, _PER_TAXEL + 1)
    mask = loaded & (smooth > _LOCAL_SHARE * nearby)
    # The closing must not end at the field's border, beyond which the contact goes on.
    spare = 2
    wide = np.pad(mask, spare, mode="edge")
    mask = ndimage.binary_closing(wide, structure=_AROUND)[spare:-spare, spare:-spare]
    filled: NDArray[np.bool_] = ndimage.binary_fill_holes(_heaviest(mask, pressure, alone=False))
    return filled


def _heaviest(mask: NDArray[np.bool_], pressure: Floats, *, alone: bool) -> NDArray[np.bool_]:
    """Keep the piece that carries the most load, or all pieces that carry a share of it."""
    pieces, count = ndimage.label(mask)
    if count <= 1:
        return mask
    load = np.bincount(pieces.ravel(), weights=pressure.ravel())
    load[0] = 0.0
    keep = load == load.max() if alone else load > _LEAST_LOAD * load.sum()
    out: NDArray[np.bool_] = keep[pieces]
    return out


def _eroded(mask: NDArray[np.bool_], depth_m: float, cells: Cells) -> NDArray[np.bool_]:
    """Take off the border; the field's own border is none, for the contact goes on beyond it."""
    if depth_m <= 0 or mask.all():
        return mask
    around = np.pad(mask, 1, mode="edge")
    away = ndimage.distance_transform_edt(around, sampling=(cells.row_m, cells.col_m))[1:-1, 1:-1]
    core: NDArray[np.bool_] = away > depth_m
    return core if np.count_nonzero(core) >= _FEWEST_CORE else mask


def _points(cells: Cells) -> tuple[Floats, Floats]:
    y = (np.arange(cells.rows, dtype=np.float64) + 0.5 - cells.rows / 2) * cells.row_m
    x = (np.arange(cells.cols, dtype=np.float64) + 0.5 - cells.cols / 2) * cells.col_m
    return np.broadcast_to(x[None, :], (cells.rows, cells.cols)), np.broadcast_to(y[:, None], (cells.rows, cells.cols))


def _tilt(displacement: Floats, core: NDArray[np.bool_], cells: Cells) -> tuple[float, float]:
    """Slope of the plane that fits the displacement best over the core."""
    if np.count_nonzero(core) < _FEWEST_CORE:
        return 0.0, 0.0
    x, y = _points(cells)
    x, y, u = x[core], y[core], displacement[core]
    x, y, u = x - x.mean(), y - y.mean(), u - u.mean()
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
    around = ndimage.binary_dilation(mask, iterations=_PER_TAXEL, structure=_AROUND)
    ring = around & ~ndimage.binary_dilation(mask, iterations=_PER_TAXEL - 1, structure=_AROUND)
    if not ring.any():
        return 0.0
    level = _without_tilt(displacement, mask, tilt, cells)
    return float(np.median(level[ring]))
