"""What a contact shows to a fit: a window of taxels, their weights, and where to begin."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact
from varishold.skin import Relief, Skin
from varishold.skin.synthesis import Synthesis, synthesis_of
from varishold.touch.exact.fit import Seen
from varishold.touch.exact.form import Grid, Start

__all__ = ["MODEL_SHARE", "see"]

Floats = NDArray[np.float64]

#: Standard deviation of the forward model, as a share of the frame's peak: the coarse grid's error, and
#: that of a skin which is never quite the one in its file.
MODEL_SHARE = 0.02
#: The same for the outermost taxels of the pad: a face may go on beyond them over skin without taxels, or the
#: skin may end there, and neither is known.
BORDER_SHARE = 0.15
_BORDER_TAXELS = 2
# Taxels around the contact's own that are fitted too: they say where it ends.
_MARGIN = 2
# Windows come in steps of so many taxels, so that few forward models are made.
_STEP = 4
# About as many cells as a contact may have: the time of a factor grows with the cube.
_CELLS = 420
_MOST_PER_TAXEL = 4
# Contacts of more taxels are fitted on means over k x k of them.
_MOST_TAXELS = 1100


def see(contact: Contact, relief: Relief, skin: Skin) -> tuple[Seen, Start, tuple[float, float]]:
    """Return what of a contact is fitted, where to begin, and the window's centre (x, y) in metres on the pad."""
    rows, cols = contact.shape
    pitch = contact.spacing
    k = math.ceil(math.sqrt(contact.n_taxels / _MOST_TAXELS))
    window = tuple(_widened(part, length, k) for part, length in zip(contact.window, (rows, cols), strict=True))
    label = contact.frame.label[1:-1, 1:-1][window]
    values = contact.frame.padded[1:-1, 1:-1][window]
    counts = _pooled(np.isfinite(values) & ((label == contact.index) | (label < 0)), k) == 1
    frame = np.where(counts, _pooled(np.where(np.isfinite(values), values, 0.0), k), 0.0)
    near = _pooled(_near_border((rows, cols))[window], k) > 0
    peak = contact.peak
    sigma = np.hypot(contact.sigma / peak / k, np.where(near, BORDER_SHARE, MODEL_SHARE))
    n = int(min(max(math.sqrt(_CELLS / max(contact.n_taxels, 1)), 1), _MOST_PER_TAXEL))
    coarse_pitch = (pitch[0] * k, pitch[1] * k)
    unit = math.sqrt(coarse_pitch[0] * coarse_pitch[1])
    synthesis = synthesis_of(skin, *frame.shape, coarse_pitch, n)
    fine = synthesis_of(skin, *frame.shape, coarse_pitch, 2 * n)
    middle_y, middle_x = (
        ((part.start + part.stop) / 2 - length / 2) * side
        for part, length, side in zip(window, (rows, cols), pitch, strict=True)
    )
    active = _active(relief, window, synthesis, k)
    seen = Seen(
        frame=frame / peak,
        weight=counts / sigma,
        synthesis=synthesis,
        grid=_grid(synthesis, unit),
        fine=fine,
        fine_grid=_grid(fine, unit),
        active=active,
        count=int(np.count_nonzero(counts)),
        unit_m=unit,
    )
    return seen, _start(active, seen), (middle_x, middle_y)


def _pooled(values: NDArray[Any], k: int) -> Floats:
    """Return the means over k x k taxels."""
    rows, cols = values.shape
    return np.asarray(values.reshape(rows // k, k, cols // k, k).mean(axis=(1, 3)), dtype=np.float64)


def _near_border(shape: tuple[int, int]) -> NDArray[np.bool_]:
    # A small pad has one such row, lest nothing be left.
    n = _BORDER_TAXELS if min(shape) > 6 * _BORDER_TAXELS else 1
    near = np.ones(shape, dtype=bool)
    near[n:-n, n:-n] = False
    return near


def _grid(synthesis: Synthesis, unit: float) -> Grid:
    x, y = synthesis.points_m
    return Grid(x / unit, y / unit, synthesis.cells.col_m / unit, synthesis.cells.row_m / unit)


def _widened(part: slice, length: int, k: int) -> slice:
    first, last = max(part.start - _MARGIN * k, 0), min(part.stop + _MARGIN * k, length)
    size = min(-(-(last - first) // (_STEP * k)) * _STEP * k, length // k * k)
    first = max(min(first, length - size), 0)
    return slice(first, first + size)


def _active(relief: Relief, window: tuple[slice, ...], synthesis: Synthesis, k: int) -> NDArray[np.bool_]:
    n, m = synthesis.per_taxel, relief.per_taxel
    at = [((np.arange(synthesis.shape[axis] * n) + 0.5) * k / n + window[axis].start) * m for axis in (0, 1)]
    mask: NDArray[np.bool_] = relief.mask[at[0].astype(int)[:, None], at[1].astype(int)[None, :]].ravel()
    return mask


def _start(active: NDArray[np.bool_], seen: Seen) -> Start:
    x, y = seen.grid.x[active], seen.grid.y[active]
    mx, my = float(x.mean()), float(y.mean())
    z = (x - mx) + 1j * (y - my)
    cell = seen.grid.width * seen.grid.height
    area = max(len(z) * cell, 1.0)
    spread = complex(np.mean(z * z))
    trace = max(float(np.mean(np.abs(z) ** 2)), 1e-6)
    share = min(abs(spread) / trace, 0.98)
    aspect = math.sqrt((1 + share) / (1 - share))
    down_y, down_x = np.gradient(seen.frame)
    # Away from the side on which more lies: of a border within the field, downhill.
    descent = math.atan2(-float(down_y.sum()), -float(down_x.sum()))
    return Start(
        x=mx,
        y=my,
        long=math.sqrt(area * aspect),
        short=math.sqrt(area / aspect),
        yaw=0.5 * math.atan2(spread.imag, spread.real),
        # The fourth moment of a square points away from its sides.
        square_yaw=_fourth(z),
        descent=descent,
    )


def _fourth(z: NDArray[np.complex128]) -> float:
    moment = complex(np.mean(z**4))
    return (math.atan2(moment.imag, moment.real) + math.pi) / 4
