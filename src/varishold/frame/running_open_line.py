"""Rows and columns that come off while a stream runs and stand at one high value from then on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fill import filled_above_rest
from varishold.frame.neighbours import whole_lines
from varishold.frame.sticking import SIGMAS

__all__ = ["RunningOpenLine"]

# A line is open that has not changed for so long, and in so many readings, while at least half of the others have; a
# bar that presses along it is felt beside it, too. Seconds.
_STILL_S, _READINGS, _HALF = 10.0, 30, 0.5
# It is looked for so often, and a gap in the stream counts no longer than this. Seconds.
_LOOK_S, _LONGEST_S = 0.5, 0.5

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class RunningOpenLine:
    """Watches a pad's readings; what it keeps does not grow.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    open : ndarray of shape (rows, cols), bool, or None
        The taxels of lines that are open and stand high; None where there are none.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> watched = RunningOpenLine(np.ones((8, 8), bool))
    >>> for k in range(300):
    ...     frame = rng.normal(0, 1, (8, 8))
    ...     frame[3] = 1023.0
    ...     mended = watched.update(k / 20, frame, np.zeros((8, 8)), 1.0)
    >>> print(np.flatnonzero(watched.open.all(axis=1)).tolist(), bool(abs(mended[3]).max() < 3))
    [3] True
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self.open: Mask | None = None
        self._last: tuple[float, NDArray[Any]] | None = None
        self._still_s, self._still = np.zeros((2, *usable.shape))
        self._waited_s = 0.0

    def update(self, time_s: float, values: NDArray[Any], rest: Floats, sigma: float) -> NDArray[Any]:
        """Return what stands for the next reading: an open line rests, and rises as those beside it do.

        Parameters
        ----------
        time_s : float
        values : ndarray of shape (rows, cols), float or integer
        rest : ndarray of shape (rows, cols), float64
            What each taxel reads at rest.
        sigma : float
            Standard deviation of the noise of the usual taxel.

        Returns
        -------
        ndarray of shape (rows, cols)
            The values themselves where no line is open.
        """
        if self._last is not None:
            passed_s = min(max(time_s - self._last[0], 0.0), _LONGEST_S)
            same = values == self._last[1]
            self._still_s = (self._still_s + passed_s) * same
            self._still = (self._still + 1.0) * same
            self._waited_s += passed_s
            if self._waited_s >= _LOOK_S or (self.open is not None and not same[self.open].all()):
                self._waited_s = 0.0
                self.open = self._found(values, rest, sigma)
        self._last = time_s, values
        return values if self.open is None else filled_above_rest(values, self.open, rest, self._usable)

    def words(self) -> tuple[str, ...]:
        """Return which lines are open, in words; nothing where none is."""
        if self.open is None:
            return ()
        lines = self.open | ~self._usable
        told = [f"row {row}" for row in np.flatnonzero(lines.all(axis=1) & self.open.any(axis=1))]
        told += [f"column {col}" for col in np.flatnonzero(lines.all(axis=0) & self.open.any(axis=0))]
        return (f"{', '.join(told)} stands high and never changes, an open line: filled from those beside",)

    def _found(self, values: NDArray[Any], rest: Floats, sigma: float) -> Mask | None:
        still = (self._still_s >= _STILL_S) & (self._still >= _READINGS) & self._usable
        if not still.any():
            return None
        with np.errstate(invalid="ignore"):
            high = (values - rest > SIGMAS * sigma) & self._usable
        lines = whole_lines(still & high, self._usable) & still & high
        if self.open is None:
            # What is pressed across an open line later is felt beside it.
            lines &= whole_lines(high, self._usable)
        others = self._usable & ~lines
        live = np.count_nonzero(still & others) <= _HALF * np.count_nonzero(others)
        return lines if live and lines.any() else None
