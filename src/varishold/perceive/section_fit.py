"""The fit of a section to capsules, one turn after another: how the kernel's is called."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind, work_space

__all__ = ["fit_ball", "fit_turns", "meeting"]

Floats = NDArray[np.float64]

# struct vh_parts and struct vh_section of varishold.h.
_PARTS = struct.Struct("@i4Pd")
_SECTION = struct.Struct("@iPdi")
_fit_turns = bind("vh_fit_turns", "pppippppp")
_fit_turns_work = bind("vh_fit_turns_work", "pp", "z")
_fit_ball = bind("vh_fit_ball", "pp", "d")
_meeting = bind("vh_meeting", "pppp")


class _Parts:
    """Capsules as the kernel takes them; `packed` is good as long as this is kept."""

    def __init__(self, start: Floats, end: Floats, radius: Floats, touch: NDArray[np.int64], sigma: float) -> None:
        self.n = len(start)
        self._kept = [_copied(array) for array in (start, end, radius)]
        self._kept.append(_copied(touch, np.int64))
        self.packed = _PARTS.pack(self.n, *(address(array) for array in self._kept), sigma)


def _copied(array: NDArray[Any], dtype: type = np.float64) -> NDArray[Any]:
    """Return an array that can be written, in one piece and not empty."""
    return np.array(array, dtype=dtype, order="C") if array.size else np.zeros(1, dtype)


def fit_turns(
    start: Floats,
    end: Floats,
    radius: Floats,
    touch: NDArray[np.int64],
    corners: Floats,
    rounding: float,
    turns: Floats,
    grows: bool,
    sigma: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Fit middle, size, turn and growth, beginning at every turn.

    Parameters
    ----------
    start, end : ndarray of shape (n, 3)
        Metres.
    radius : ndarray of shape (n,)
        Metres.
    touch : ndarray of shape (n,), int
        2 for a part that must be just so far off, 1 for one that may be, 0 for one that must be at least so far off.
    corners : ndarray of shape (n_corners, 2)
        Of the section of size 1.
    rounding : float
        Radius around the corners, of the section of size 1.
    turns : ndarray of shape (n_turns,)
        Radians.
    grows : bool
    sigma : float
        Standard deviation of one part's distance. Metres.

    Returns
    -------
    found : ndarray of shape (n_turns, 5)
        Middle x and y, size (metres), turn (radians) and growth.
    off : ndarray of shape (n_turns, n)
        Distance less what it should be. Metres.
    cost : ndarray of shape (n_turns,)
    variance : ndarray of shape (n_turns,)
        Of the size. Square metres.
    """
    parts, corner_list, beginnings = _Parts(start, end, radius, touch, sigma), _copied(corners), _copied(turns)
    section = _SECTION.pack(len(corners), address(corner_list), rounding, grows)
    n = len(turns)
    found, cost, variance = np.zeros((n, 5)), np.zeros(n), np.zeros(n)
    off = np.zeros((n, max(parts.n, 1)))
    _fit_turns(
        *(parts.packed, section, address(beginnings), n, address(found), address(off), address(cost)),
        *(address(variance), work_space(_fit_turns_work(parts.packed, section))),
    )
    return found, off[:, : parts.n], cost, variance


def fit_ball(
    start: Floats, end: Floats, radius: Floats, touch: NDArray[np.int64], sigma: float
) -> tuple[Floats, float]:
    """Fit a ball, whose middle may be at any height; arguments as of `fit_turns`.

    Returns
    -------
    found : ndarray of shape (4,)
        Middle x, y and z, and diameter. Metres.
    cost : float
    """
    parts, found = _Parts(start, end, radius, touch, sigma), np.zeros(4)
    cost: float = _fit_ball(parts.packed, address(found))
    return found, cost


def meeting(
    start: Floats, end: Floats, radius: Floats, half_height: Floats, digit: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Tell which parts meet a part of another digit, so that what they touch may be that.

    Parameters
    ----------
    start, end : ndarray of shape (n, 3)
        Metres.
    radius, half_height : ndarray of shape (n,)
        Metres.
    digit : ndarray of shape (n,), int
        Which digit each part belongs to.

    Returns
    -------
    ndarray of shape (n,), bool
    """
    parts = _Parts(start, end, radius, np.zeros(len(start), np.int64), 1.0)
    heights, digits, out = _copied(half_height), _copied(digit, np.int64), np.zeros(max(parts.n, 1), np.bool_)
    _meeting(parts.packed, address(heights), address(digits), address(out))
    return out[: parts.n]
