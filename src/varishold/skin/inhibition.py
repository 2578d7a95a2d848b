"""Lateral inhibition: the nerve's part of the Mach phenomenon.

Near the surface edges already stand out by mechanics: a flat face presses hardest at its rim. Deeper down
the skin has blurred them, and neighbours that inhibit each other undo the blur to second order. It is for
showing and finding edges; areas must be cut before it, for it overshoots on both sides of an edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from varishold.errors import InputError
from varishold.frame.checks import as_floats, as_pitch

__all__ = ["edge_map", "lateral_inhibition"]

Floats = NDArray[np.float64]

# Width of the centre as a share of the sensing depth, and of the surround as a multiple of the centre.
_CENTRE_DEPTHS, _CENTRE_PITCHES, _SURROUND = 0.3, 0.5, 1.6


def lateral_inhibition(
    frame: ArrayLike,
    *,
    pitch_m: float | tuple[float, float],
    depth_m: float,
    centre_m: float | None = None,
    surround_m: float | None = None,
) -> Floats:
    """Sharpen a frame by neighbours that inhibit each other: G_c + w (G_c - G_s), even loads unchanged.

    w is such that 1 - (d^2 / 2) Laplacian results to second order, the inverse of a blur by the depth d.

    Parameters
    ----------
    frame : array_like of shape (rows, cols)
        Stress over each taxel.
    pitch_m : float or (float, float)
        Taxel spacing in metres, one for both ways or (row, column).
    depth_m : float
        Sensing depth, metres; 0 leaves nothing to undo.
    centre_m, surround_m : float, optional
        Widths (standard deviations) of the centre and the surround, metres; default: the larger of half a
        pitch and .3 of the depth, and 1.6 times that.

    Returns
    -------
    ndarray of shape (rows, cols), float64

    Raises
    ------
    InputError
        If the frame has not two dimensions, or a length is impossible.
    """
    centre, edges = _stages(frame, pitch_m, depth_m, centre_m, surround_m)
    return centre + edges


def edge_map(
    frame: ArrayLike,
    *,
    pitch_m: float | tuple[float, float],
    depth_m: float,
    centre_m: float | None = None,
    surround_m: float | None = None,
) -> Floats:
    """Return the edge stage of `lateral_inhibition` alone, w (G_c - G_s): zero on even and on sloping loads.

    Parameters and errors are those of `lateral_inhibition`.

    Returns
    -------
    ndarray of shape (rows, cols), float64
        Positive on the loaded side of an edge, negative on the other.
    """
    return _stages(frame, pitch_m, depth_m, centre_m, surround_m)[1]


def _stages(
    frame: ArrayLike,
    pitch_m: float | tuple[float, float],
    depth_m: float,
    centre_m: float | None,
    surround_m: float | None,
) -> tuple[Floats, Floats]:
    given = as_floats(frame, 2, "a frame")
    spacing = as_pitch(pitch_m)
    if not (np.isfinite(depth_m) and depth_m >= 0):
        raise InputError(f"depth_m must be finite and not negative, got {depth_m!r}")
    if centre_m is None:
        centre_m = max(_CENTRE_PITCHES * max(spacing), _CENTRE_DEPTHS * depth_m)
    if surround_m is None:
        surround_m = _SURROUND * centre_m
    if not 0 < centre_m < surround_m < np.inf:
        raise InputError(
            f"the surround must be wider than the centre, got centre_m={centre_m!r}, surround_m={surround_m!r}"
        )
    weight = depth_m**2 / (surround_m**2 - centre_m**2)
    centre, surround = (
        gaussian_filter(given, (sigma / spacing[0], sigma / spacing[1]), mode="nearest")
        for sigma in (centre_m, surround_m)
    )
    return centre, weight * (centre - surround)
