"""Readings of a stream that are spoilt: broken off before their last taxel, or full of noise for a moment."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.fault import Mask
from varishold.frame.spoilt import (
    FEWEST_COLS,
    FEWEST_TAXELS,
    LONGEST,
    ROUGH,
    broken_off,
    is_white,
    least_fall,
    median_bend,
    three_on_end,
)
from varishold.frame.spread import spread_over

__all__ = ["RunningSpoilt"]

# Readings after which it is known how rough steps are, and how much a step changes that.
_KNOWN, _CHANGES = 30, 0.05
# So many rows are looked at.
_MOST_ROWS = 8


class RunningSpoilt:
    """Watches a pad's readings; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> spoilt = RunningSpoilt(np.ones((8, 8), bool))
    >>> rng = np.random.default_rng(0)
    >>> for k in range(60):
    ...     frame = 50 + rng.normal(0, 1, (8, 8))
    ...     if k == 40:
    ...         frame = 500 * rng.random((8, 8))
    ...     if k == 50:
    ...         frame[5:] = 0.0
    ...     read = spoilt.update(frame)
    ...     if k in (40, 50):
    ...         print(k, bool(np.abs(read - 50).max() < 5))
    40 True
    50 True
    """

    def __init__(self, usable: Mask) -> None:
        self._usable, self._places = usable, np.flatnonzero(usable)
        self._rows = spread_over(usable.shape[0], _MOST_ROWS)
        self._three = three_on_end(usable[self._rows])
        self._looks = self._places.size >= FEWEST_TAXELS and usable.shape[1] >= FEWEST_COLS
        self._last: NDArray[Any] = np.zeros(usable.shape)
        self._begun = False
        self._usual, self._lowest, self._highest = 0.0, np.inf, -np.inf
        self._n_known = self._n_spoilt = 0
        self._n_all = 0

    def update(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return what stands for the next reading, shape (rows, cols): what is spoilt of it is as it was before."""
        if not self._looks or not self._begun:
            self._last, self._begun = values, True
            return values
        # What is no number is none of this, and others tell of it.
        with np.errstate(invalid="ignore", over="ignore"):
            return self._looked_at(values)

    def _looked_at(self, values: NDArray[Any]) -> NDArray[Any]:
        rough = float(
            median_bend(np.subtract(values[self._rows], self._last[self._rows], dtype=np.float64), self._three)
        )
        least = 1.0 if values.dtype.kind in "iu" else 0.0
        known = self._n_known >= _KNOWN and self._n_spoilt < LONGEST
        if known and rough > ROUGH * max(self._usual, least) and is_white((self._last, values), self._usable):
            return self._as_before(values, 0)
        begin = self._breaks_off(values, least) if known else None
        if begin is not None:
            return self._as_before(values, begin)
        self._take(values, rough)
        return values

    def _breaks_off(self, values: NDArray[Any], least: float) -> int | None:
        """Return the first taxel that is missing; None where none is."""
        flat, ends = values.ravel(), self._places[-FEWEST_COLS:]
        if not (flat[ends] == flat[ends[-1]]).all():
            return None
        far = least_fall(self._highest - self._lowest, self._usual, least)
        three = np.stack([self._last, values, self._last])
        return broken_off(three, self._places, far, values.shape[1]).get(1)

    def _as_before(self, values: NDArray[Any], begin: int) -> NDArray[Any]:
        self._n_spoilt += 1
        self._n_all += 1
        whole = values.copy()
        whole.flat[begin:] = self._last.flat[begin:]
        return whole

    def words(self) -> tuple[str, ...]:
        """Return how many readings were spoilt, in words; nothing where none was."""
        many = self._n_all
        return (f"{counted(many, 'reading')} broken off or full of noise: taken as before",) if many else ()

    def _take(self, values: NDArray[Any], rough: float) -> None:
        """Take a good reading in."""
        # What goes on is no burst: the pad is as rough as that now.
        share = 1.0 if self._n_spoilt >= LONGEST else max(_CHANGES, 1.0 / (self._n_known + 1))
        self._usual += share * (rough - self._usual)
        self._last, self._n_spoilt = values, 0
        self._n_known += 1
        some = values[self._usable]
        self._lowest = min(self._lowest, float(some.min()))
        self._highest = max(self._highest, float(some.max()))
