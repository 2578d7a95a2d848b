"""Where the readings of a stream end although the sensor could show more: found press by press while it runs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.frame.reading_end import (
    BEYOND,
    FEWEST_TAXELS,
    EndOfPress,
    EndsOfPresses,
    PressFrame,
    ReadingEnd,
    clearer_end,
    reach_of,
    uneven,
)

__all__ = ["RunningEnd"]

# A press that still goes on shows an end only where it stays there for so many frames.
_FEWEST_FRAMES = 4

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class RunningEnd:
    """Watches a pad's zeroed frames; what it keeps does not grow.

    As in `reading_end`, a press shows an end where its top stays while it goes on growing: for itself while it lasts,
    and for others where two agree. A press that goes clearly beyond takes it back.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Attributes
    ----------
    agreed, end : ReadingEnd or None
        As presses that are over agree, and as it is best known now; None where none is known.

    Examples
    --------
    >>> y, x = np.mgrid[-6:7, -6:7]
    >>> cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    >>> watched = RunningEnd(np.ones(x.shape, bool))
    >>> for k in range(120):
    ...     force = max(k % 40 - 10, 0)
    ...     watched.update(np.minimum(force * cone, 60.0), np.zeros(x.shape), 0.1, is_pressed=force > 0)
    ...     if k in (35, 40, 80):
    ...         print(k, None if watched.end is None else round(watched.end.height, 1))
    35 59.4
    40 None
    80 59.4
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self._knows = int(np.count_nonzero(usable)) >= FEWEST_TAXELS
        # Above each taxel's own rest, and as readings.
        self._own, self._common = _Presses(), _Presses()
        self.agreed: ReadingEnd | None = None
        self.end: ReadingEnd | None = None
        self._is_pressed = False

    def update(self, zeroed: Floats, rest: Floats, sigma: float, *, is_pressed: bool) -> None:
        """Take a frame.

        Parameters
        ----------
        zeroed, rest : ndarray of shape (rows, cols), float64
            Upright and zero at rest; what was taken off.
        sigma : float
            Standard deviation of the noise.
        is_pressed : bool
            Whether anything presses.
        """
        if not self._knows or not (is_pressed or self._is_pressed):
            return
        self._is_pressed = is_pressed
        if is_pressed:
            values, apart = zeroed[self._usable], uneven(rest, self._usable)[self._usable]
            self._own.see(values, values, sigma)
            self._common.see(values, values + apart, sigma)
        else:
            self._own.finish()
            self._common.finish()
        self.agreed = clearer_end(self._own.ends, self._common.ends, sigma)
        self.end = self.agreed or self._of_this_press(sigma)

    def _of_this_press(self, sigma: float) -> ReadingEnd | None:
        """Return the end that the press which lasts shows by itself."""
        own, common = self._own.shown, self._common.shown
        of_readings = common is not None and (own is None or common.taxels > own.taxels)
        shown, frames = (common, self._common.frames) if of_readings else (own, self._own.frames)
        if shown is None or frames < _FEWEST_FRAMES:
            return None
        return ReadingEnd(shown.top - reach_of(shown.top, sigma), of_readings)


class _Presses:
    """Presses by one way to look at their tops.

    Attributes
    ----------
    ends : EndsOfPresses
        Of those that are over.
    shown : EndOfPress or None
        Of the one that lasts.
    frames : int
        In which that was at its top.
    """

    def __init__(self) -> None:
        self.ends = EndsOfPresses()
        self.shown: EndOfPress | None = None
        self._highest, self._tops, self.frames = 0.0, 0.0, 0
        self._first: PressFrame | None = None
        self._heaviest: PressFrame | None = None

    def see(self, values: Floats, shown: Floats, sigma: float) -> None:
        """Take a frame of the press that lasts: its taxels, zero at rest, and what of them is looked at."""
        if float(shown.max()) < self._highest - reach_of(self._highest, sigma):
            return
        frame = PressFrame.of(values, shown)
        self._highest = max(self._highest, frame.top)
        reach = reach_of(self._highest, sigma)
        if self._highest <= 2 * reach:
            return
        agreed = self.ends.agreed(sigma)
        if agreed is not None and self._highest > agreed + BEYOND * reach:
            self.ends.clear()
        least = self._highest - reach
        if self._first is None or self._heaviest is None or self._first.top < least:
            # The top went on growing.
            self._first = self._heaviest = frame
            self._tops, self.frames, self.shown = frame.top, 1, None
        elif frame.top >= least:
            self._tops += frame.top
            self.frames += 1
            if frame.load > self._heaviest.load or self._heaviest.top < least:
                self._heaviest = frame
                self.shown = frame.end_since(self._first, self._tops / self.frames, self._highest, reach)

    def finish(self) -> None:
        """Take it that the press is over."""
        self.ends.add(self.shown, self._highest)
        self.shown = self._first = self._heaviest = None
        self._highest = 0.0
