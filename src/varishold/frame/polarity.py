"""Do readings fall where something presses? Some frames tell it: what is pressed stands off the taxels beside it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import pieces_at
from varishold.frame.noise import ROUNDING
from varishold.frame.spread import spread_over

__all__ = ["Fall", "find_fall"]

_FEWEST_FRAMES, _FEWEST_TAXELS = 4, 9
# Frames, and values, that are looked at.
_MOST_FRAMES, _MOST_VALUES = 64, 1 << 20
# Of the largest change: taxels that change less are beside the press, those that change more are in it.
_BESIDE, _PRESSED = 0.2, 0.5
# Where the frame that differs most is pressed all over, the next is asked that differs by this share of it at least.
_REACH = 0.2
# The share of the taxels that must stay beside it, and the fewest in it: a single one may have failed.
_BESIDE_SHARE, _FEWEST_PRESSED = 0.2, 3
# Where it is pressed it stands so many times as far off the taxels beside as where it is not, off their scatter, and
# off how they wander in time.
_STANDS_OFF, _SCATTERS, _WANDERS = 2.0, 4.0, 12.0
# Over all frames it lies below its surroundings so many times as much as above: what creeps or drifts does both.
_OUTWEIGHS = 5.0


@dataclass(frozen=True)
class Fall:
    """Readings that fall under pressure.

    Parameters
    ----------
    frame : int
        One in which something presses.
    rest, pressed : float
        What its taxels show beside the press, and in it.
    taxels : ndarray of shape (rows, cols), bool
        Those that are not beside the press.
    """

    frame: int
    rest: float
    pressed: float
    taxels: NDArray[np.bool_] = field(compare=False, repr=False)


def find_fall(frames: NDArray[Any], usable: NDArray[np.bool_]) -> Fall | None:
    """Tell whether readings fall where something presses.

    Between the first frame and the one that differs most from it, of those not pressed all over, some taxels change and
    others do not; so between the last frame, or a usual one, and another, as a sensor may settle in its first. Of the
    two, where they are pressed they stand off the others: above as a rule, below where readings fall. Where some rise
    and others fall, as beside a press that pulls a skin, those that fall are pressed only where they change more both
    in all and at the most. A whole pad that rises or falls alike tells nothing, nor does a single taxel or line, which
    may have failed.

    Parameters
    ----------
    frames : ndarray of shape (n, rows, cols), integer or float
        Finite where usable; at most 64 of them are looked at.
    usable : ndarray of shape (rows, cols), bool

    Returns
    -------
    Fall or None
        None where they rise, or nobody can tell.

    Examples
    --------
    >>> y, x = np.mgrid[-6:7, -6:7]
    >>> force = np.repeat([0.0, 1.0, 3.0], 4)[:, None, None]
    >>> falling = 250 - 20 * force * np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> fall = find_fall(falling, np.ones((13, 13), bool))
    >>> fall.frame, fall.rest, round(fall.pressed)
    (8, 250.0, 91)
    >>> find_fall(250 - falling, np.ones((13, 13), bool)) is None
    True
    """
    n, n_taxels = frames.shape[0], int(np.count_nonzero(usable))
    if n < _FEWEST_FRAMES or n_taxels < _FEWEST_TAXELS:
        return None
    number = spread_over(n, min(_MOST_FRAMES, max(2, _MOST_VALUES // usable.size)))
    seen = np.array([frame[usable] for (frame,) in pieces_at(frames, number.tolist())], dtype=np.float64)
    found = _fall_of_all(seen, usable)
    if found is None:
        return None
    at, rest, pressed, patch = found
    taxels = np.zeros_like(usable)
    taxels[usable] = patch
    # Where others rise by more than a pulled skin does beside a press, what falls has failed.
    rise = None if np.count_nonzero(~patch) < _FEWEST_TAXELS else _fall_of_all(-seen[:, ~patch], usable & ~taxels)
    if rise is not None and rise[1] - rise[2] > _BESIDE * (rest - pressed):
        return None
    return Fall(int(number[at]), rest, pressed, taxels)


def _fall_of_all(
    seen: NDArray[np.float64], usable: NDArray[np.bool_]
) -> tuple[int, float, float, NDArray[np.bool_]] | None:
    """Return what `_fall` does against the first frame, where the last one or a usual one agrees."""
    found = _fall(seen, usable, 0)
    if found is None:
        return None
    usual = int(np.argmin(np.abs(seen - np.median(seen, axis=0)).sum(axis=1)))
    agrees = any(_fall(seen, usable, reference) is not None for reference in (usual, len(seen) - 1))
    return found if agrees else None


def _fall(
    seen: NDArray[np.float64], usable: NDArray[np.bool_], reference: int
) -> tuple[int, float, float, NDArray[np.bool_]] | None:
    """Return a frame in which readings have fallen against a reference, what is read beside the press and in it.

    And which taxels are not beside it.
    """
    change = seen - seen[reference]
    found = _part(change, usable)
    if found is None:
        return None
    most, beside, pressed = found
    off = seen[:, pressed].mean(axis=1) - np.median(seen[:, beside], axis=1)
    at, other = (most, reference) if abs(off[most]) >= abs(off[reference]) else (reference, most)
    scatter = _middle_deviation(seen[reference, beside])
    wander = _middle_deviation(seen[:, beside] - np.median(seen[:, beside], axis=0))
    # Counts differ by one of them where nothing changes.
    wander = max(wander, ROUNDING * float(np.diff(np.unique(seen)).min()))
    below, above = -float(off[off < 0].sum()), float(off[off > 0].sum())
    if (
        off[at] >= 0
        or -off[at] < max(_STANDS_OFF * abs(off[other]), _SCATTERS * scatter, _WANDERS * wander)
        or below < _OUTWEIGHS * above
    ):
        return None
    return at, float(np.median(seen[at, beside])), float(seen[at, pressed].mean()), ~beside


def _part(
    change: NDArray[np.float64], usable: NDArray[np.bool_]
) -> tuple[int, NDArray[np.bool_], NDArray[np.bool_]] | None:
    """Return which frame has changed most of those pressed in part, and its taxels beside and in the press."""
    amounts = np.abs(change).sum(axis=1)
    falls, rises = (np.partition(one, -_FEWEST_PRESSED, axis=1)[:, -_FEWEST_PRESSED] for one in (-change, change))
    way = np.where((falls > rises) & (change.sum(axis=1) < 0.0), -1.0, 1.0)
    reach = (way[:, None] * change).max(axis=1)
    looked_at = np.argsort(-amounts, kind="stable")
    for k in looked_at[reach[looked_at] > _REACH * reach[looked_at[0]]].tolist():
        beside = np.abs(change[k]) <= _BESIDE * reach[k]
        pressed = way[k] * change[k] >= _PRESSED * reach[k]
        if np.count_nonzero(beside) >= _BESIDE_SHARE * beside.size and _is_patch(pressed, usable):
            return k, beside, pressed
    return None


def _middle_deviation(values: NDArray[np.float64]) -> float:
    return float(np.median(np.abs(values - np.median(values))))


def _is_patch(pressed: NDArray[np.bool_], usable: NDArray[np.bool_]) -> bool:
    """Tell whether taxels are no single ones, and no single row or column."""
    if np.count_nonzero(pressed) < _FEWEST_PRESSED:
        return False
    row, col = (places[pressed] for places in np.nonzero(usable))
    return min(usable.shape) == 1 or min(int(np.ptp(row)), int(np.ptp(col))) >= 1
