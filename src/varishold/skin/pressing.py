"""Pressing a rigid body into a skin, by depth or by force."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError, NotConvergedError, require_a
from varishold.frame.checks import as_pitch, as_positive, as_whole
from varishold.frame.readings import as_shape
from varishold.sensor.cover import Skin
from varishold.skin.contact import Contact, solve_contact
from varishold.skin.face import Face, face_of_map, face_of_solid
from varishold.skin.media import MOST_CELLS, Cells
from varishold.solids import Pose, Solid

__all__ = ["PressedSolid", "contact_cells", "press"]

Floats = NDArray[np.float64]

# A force is met to so many times the solver's own tolerance, within so many trial depths.
_FORCE_TOLERANCES = 10.0
_FORCE_TRIALS = 40


@dataclass(frozen=True)
class PressedSolid:
    """A rigid body pressed into a skin.

    Parameters
    ----------
    skin : Skin
        The skin.
    x_m, y_m : ndarray of shape (cols,), (rows,), float64
        Middles of the cells, metres from the pad's centre.
    pressure : ndarray of shape (rows, cols), float64
        Surface pressure: pascal, or units of the contact modulus where the skin's modulus is unknown.
    displacement_m : ndarray of shape (rows, cols), float64
        How far the surface is pressed down, metres.
    gap_m : ndarray of shape (rows, cols), float64
        Distance between surface and body, metres; 0 in contact, infinite where there is no body.
    contact : ndarray of shape (rows, cols), bool
        Where the pressure is positive.
    depth_m : float
        How far the body's highest point is pressed below the free surface, metres.
    force_n : float
        Total force, newton; in units of the contact modulus times square metres where the modulus is unknown.
    rms_gap : float
        Root mean square, over contact and penetration, of the gap that should be 0, as a share of the depth.
    iterations : int
        Steps of the solver on the finest grid.
    converged : bool
        Whether `rms_gap` came down to the tolerance.
    shape, pitch_m
        The pad under the skin: rows and columns of taxels, and (row spacing, column spacing) in metres.
    """

    skin: Skin
    x_m: Floats
    y_m: Floats
    pressure: Floats
    displacement_m: Floats
    gap_m: Floats
    contact: NDArray[np.bool_]
    depth_m: float
    force_n: float
    rms_gap: float
    iterations: int
    converged: bool
    shape: tuple[int, int]
    pitch_m: tuple[float, float]


def contact_cells(
    shape: tuple[int, int], pitch_m: float | tuple[float, float], per_taxel: int | None
) -> tuple[Cells, tuple[float, float]]:
    """Return the solver's cells over a pad, and the pad's (row, column) spacing.

    Raises
    ------
    InputError
        If the shape, the pitch or the number of cells a taxel is impossible.
    """
    rows, cols = as_shape(shape)
    spacing = as_pitch(pitch_m)
    if per_taxel is None:
        per_taxel = max(1, round(128 / max(rows, cols)))
    per_taxel = as_whole(per_taxel, "per_taxel")
    if rows * cols * per_taxel**2 > MOST_CELLS:
        raise InputError(
            f"{rows} x {cols} taxels of {per_taxel} x {per_taxel} cells are more than {MOST_CELLS:,} cells; "
            "give fewer per_taxel"
        )
    row_m, col_m = spacing
    return Cells(rows * per_taxel, cols * per_taxel, row_m / per_taxel, col_m / per_taxel), (row_m, col_m)


def press(
    solid: Solid | ArrayLike,
    skin: Skin,
    *,
    depth: float | None = None,
    force: float | None = None,
    shape: tuple[int, int] = (32, 32),
    pitch_m: float | tuple[float, float] = 1e-3,
    pose: Pose | None = None,
    per_taxel: int | None = None,
    tolerance: float = 1e-5,
    max_iterations: int = 400,
) -> PressedSolid:
    """Press a rigid body into a skin, by depth or by force, without friction.

    Parameters
    ----------
    solid : Solid or array_like of two dimensions
        The body, or a height map in metres over the whole field (highest where it touches first).
    skin : Skin
        The skin; pressure is found on the pad only, the skin's body goes on beyond it.
    depth : float
        How far the highest point is pressed below the free surface, metres. Give this or `force`.
    force : float
        Total force in newton; needs the skin's modulus.
    shape, pitch_m
        Rows and columns of taxels, and their spacing in metres, one for both ways or (row, column).
    pose : Pose, optional
        Where the solid lies; default: centred. Not with a height map.
    per_taxel : int, optional
        Solver cells along each side of a taxel; default: about 128 cells along the pad's longer side.
    tolerance : float
        Wanted root mean square of the gap in contact, as a share of the depth.
    max_iterations : int
        Solver steps before giving up.

    Returns
    -------
    PressedSolid

    Raises
    ------
    InputError
        If a value is impossible, the body lies outside the field, or nothing touches.

    Warns
    -----
    RuntimeWarning
        If the solver stopped short of its tolerance; the answer says by how much in `rms_gap`.

    References
    ----------
    H. M. Stanley and T. Kato, "An FFT-based method for rough surface contact", J. Tribology 119, 1997;
    Polonsky and Keer 1999 (`solve_nonnegative`).

    Examples
    --------
    >>> from varishold.solids import Sphere
    >>> pressed = press(Sphere(20e-3), Skin("half-space"), depth=0.2e-3, shape=(16, 16), pitch_m=0.5e-3)
    >>> round(pressed.force_n / (4 / 3 * 10e-3**0.5 * 0.2e-3**1.5), 2)  # over Hertz's force
    1.0
    """
    cells, spacing = contact_cells(shape, pitch_m, per_taxel)
    require_a(Skin, skin, "skin", "as read_skin(path) gives it")
    _check_load(depth, force, skin)
    tolerance, max_iterations = as_positive(tolerance, "tolerance"), as_whole(max_iterations, "max_iterations")
    if pose is not None:
        require_a(Pose, pose, "pose", "as Pose(x_m, y_m, yaw_rad)")
    if isinstance(solid, Solid):
        limit = solid.top_m
        body, place = solid, pose or Pose()

        def face_at(depth_m: float) -> Face:
            return face_of_solid(body, cells, place, depth_m)

    else:
        if pose is not None:
            raise InputError("a pose moves a solid; a height map lies where it is, so give no pose with it")
        limit = math.inf
        mapped = face_of_map(solid, cells)

        def face_at(depth_m: float) -> Face:
            return mapped

    if depth is not None:
        if depth > limit * (1 + 1e-12):
            raise InputError(f"depth must not exceed the solid's height, {limit:g} m, got {depth!r}")
        outcome = solve_contact(face_at(depth), skin, cells, depth, tolerance, max_iterations)
    else:
        target = (force or 0.0) / skin.contact_modulus
        depth, outcome = _by_force(face_at, skin, cells, target, limit, tolerance, max_iterations)
    return _as_press(outcome, depth, skin, cells, shape, spacing, tolerance)


def _check_load(depth: float | None, force: float | None, skin: Skin) -> None:
    if (depth is None) == (force is None):
        raise InputError("give either depth (metres) or force (newton), not both and not neither")
    name, value = ("depth", depth) if depth is not None else ("force", force)
    as_positive(value, name)
    if force is not None and skin.youngs_modulus_pa is None:
        raise InputError("a press by force needs the skin's youngs_modulus_pa; press by depth without it")


def _by_force(
    face_at: Callable[[float], Face],
    skin: Skin,
    cells: Cells,
    target: float,
    limit: float,
    tolerance: float,
    max_iterations: int,
) -> tuple[float, Contact]:
    """Find the depth that gives a force, by secants of the logarithms: force grows as a power of depth."""
    area = cells.row_m * cells.col_m
    depth = min(0.1 * cells.rows * cells.row_m, limit if math.isfinite(limit) else math.inf) / 10
    low = high = None
    tried: list[tuple[float, float]] = []
    solved: Contact | None = None
    for _ in range(_FORCE_TRIALS):
        solved = solve_contact(
            face_at(depth), skin, cells, depth, tolerance, max_iterations, solved.pressure if solved else None
        )
        force = float(solved.pressure.sum()) * area
        if abs(force / target - 1) < _FORCE_TOLERANCES * tolerance:
            return depth, solved
        if force < target:
            low = depth
            if depth >= limit:
                raise InputError(
                    f"the force is too large: the whole solid, {limit:g} m high, is pressed in at "
                    f"{force * skin.contact_modulus:g} N"
                )
        else:
            high = depth
        tried.append((math.log(depth), math.log(force)))
        power = 1.5
        if len(tried) > 1 and tried[-1][0] != tried[-2][0]:
            power = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
        shift = (math.log(target) - tried[-1][1]) / min(max(power, 0.5), 4.0)
        depth = min(depth * math.exp(min(max(shift, -3.0), 1.5)), limit)
        if low is not None and high is not None and not low < depth < high:
            depth = math.sqrt(low * high)
    raise NotConvergedError(f"no depth found for the force within {_FORCE_TRIALS} trials; last {depth:g} m")


def _as_press(
    solved: Contact,
    depth: float,
    skin: Skin,
    cells: Cells,
    shape: tuple[int, int],
    spacing: tuple[float, float],
    tolerance: float,
) -> PressedSolid:
    converged = solved.rms_gap <= tolerance
    if not converged:
        warnings.warn(
            f"the contact did not converge: rms gap {solved.rms_gap:.2g} of the depth after "
            f"{solved.iterations} steps, wanted {tolerance:.2g}",
            RuntimeWarning,
            stacklevel=3,
        )
    return PressedSolid(
        skin=skin,
        x_m=_middles(cells.cols, cells.col_m),
        y_m=_middles(cells.rows, cells.row_m),
        pressure=solved.pressure * skin.contact_modulus,
        displacement_m=solved.displacement_m,
        gap_m=solved.gap_m,
        contact=solved.pressure > 0,
        depth_m=depth,
        force_n=float(solved.pressure.sum()) * cells.row_m * cells.col_m * skin.contact_modulus,
        rms_gap=solved.rms_gap,
        iterations=solved.iterations,
        converged=converged,
        shape=(int(shape[0]), int(shape[1])),
        pitch_m=spacing,
    )


def _middles(count: int, side_m: float) -> Floats:
    return (np.arange(count, dtype=np.float64) + 0.5 - count / 2) * side_m
