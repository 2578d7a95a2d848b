"""Where a reconstructed pressure touches, and where that is sure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from varishold.skin.media import Cells

__all__ = ["AROUND", "FEWEST_CORE", "contact_mask", "eroded"]

Floats = NDArray[np.float64]

# The contact reaches to where the pressure, smoothed over this share of a taxel, falls below this share of
# the highest within half a taxel around it, and of the whole frame's peak.
_SMOOTH_TAXELS = 0.28
_LOCAL_SHARE, _PEAK_SHARE = 0.35, 0.06
# A piece of the contact that carries less than this share of the load is noise.
_LEAST_LOAD = 0.03
#: A core of fewer cells says nothing of a tilt.
FEWEST_CORE = 12
#: A cell and its eight neighbours.
AROUND = np.ones((3, 3), dtype=bool)


def contact_mask(pressure: Floats, per_taxel: int) -> NDArray[np.bool_]:
    """Mark the contact: one piece, its holes filled.

    The border of a flat face stands where the pressure falls from its rim; that of a round one where it
    fades. A share of the highest pressure nearby finds both, a share of the frame's peak only one. Around a
    shoulder, which presses hardest, it leaves a gap, which is closed where pressure stands on both sides.
    """
    smooth = ndimage.gaussian_filter(pressure, _SMOOTH_TAXELS * per_taxel)
    loaded = _heaviest(smooth > _PEAK_SHARE * smooth.max(), pressure, alone=True)
    nearby = ndimage.maximum_filter(smooth, per_taxel + 1)
    mask = loaded & (smooth > _LOCAL_SHARE * nearby)
    # The closing must not end at the field's border, beyond which the contact goes on.
    spare = 2
    wide = np.pad(mask, spare, mode="edge")
    mask = ndimage.binary_closing(wide, structure=AROUND)[spare:-spare, spare:-spare]
    return ndimage.binary_fill_holes(_heaviest(mask, pressure, alone=False))


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


def eroded(mask: NDArray[np.bool_], depth_m: float, cells: Cells) -> NDArray[np.bool_]:
    """Take off the border; the field's own border is none, for the contact goes on beyond it."""
    if depth_m <= 0 or mask.all():
        return mask
    around = np.pad(mask, 1, mode="edge")
    away = ndimage.distance_transform_edt(around, sampling=(cells.row_m, cells.col_m))[1:-1, 1:-1]
    core: NDArray[np.bool_] = away > depth_m
    return core if np.count_nonzero(core) >= FEWEST_CORE else mask
