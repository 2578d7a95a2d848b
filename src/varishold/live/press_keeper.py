"""The frames of the press that lasts, and what the press was when it has ended."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fill import fill_invalid
from varishold.touch.course.one_sensor import SensorScale
from varishold.touch.course.presses import Press

__all__ = ["KeptPress", "PressKeeper"]

Floats = NDArray[np.float64]
Masks = Mapping[str, NDArray[np.bool_]]

# So many frames before the first touch show the rest.
_REST_FRAMES = 8
# A press has ended when nothing has touched for so long: what lifts off and comes back sooner is one press. Seconds.
_APART_S = 0.15
# A press of more frames than this is kept with every second of them, and so on.
_MOST_FRAMES = 2048
_UNKNOWN = SensorScale()
_ALL_WORK: Masks = {}


@dataclass(frozen=True, eq=False)
class _Kept:
    """A reading: its broken taxels are filled, and those are told of the pads that have any."""

    time_s: float
    frames: Mapping[str, Floats]
    broken: Masks


@dataclass(frozen=True, eq=False)
class KeptPress:
    """A press that was seen, or what there is of one that lasts.

    Parameters
    ----------
    number : int
        Counted from 0.
    press : Press
        As `varishold.learning` takes it.
    start_s, end_s : float
        When it first and last touched.
    """

    number: int
    press: Press
    start_s: float
    end_s: float


class PressKeeper:
    """Keeps the frames of all pads from shortly before a touch until nothing touches any more.

    Attributes
    ----------
    number : int
        Of the press that lasts, or comes next.
    """

    def __init__(self) -> None:
        self.number = 0
        self._fields: Masks = {}
        self._scale = SensorScale()
        self._rest: deque[_Kept] = deque(maxlen=_REST_FRAMES)
        self._frames: list[_Kept] = []
        # Of how many frames one is kept, and how many were left out since.
        self._every: int
        self._skipped: int
        self._touched_s: tuple[float, float] | None = None

    @property
    def lasts(self) -> bool:
        """Whether a press lasts."""
        return self._touched_s is not None

    def begin_anew(self, fields: Masks, scale: SensorScale = _UNKNOWN) -> None:
        """Forget what was kept: from now on there are these pads, with taxels where the fields say.

        Parameters
        ----------
        fields : mapping of str to ndarray of shape (rows, cols), bool
        scale : SensorScale
            The unit of the readings and how far taxels are apart, as far as the source says.
        """
        self._fields, self._scale = dict(fields), scale
        self._rest.clear()
        self._touched_s, self._frames = None, []

    def see(
        self, time_s: float, frames: Mapping[str, Floats], works: Masks = _ALL_WORK, *, touched: bool
    ) -> KeptPress | None:
        """Take the next reading; return the press that has ended with it, or None.

        Parameters
        ----------
        time_s : float
            Never less than that of the reading before.
        frames : mapping of str to ndarray of shape (rows, cols), float64
            Of every pad, zero at rest.
        works : mapping of str to ndarray of shape (rows, cols), bool
            Which taxels are believed, of the pads on which not all are.
        touched : bool
            Whether anything touches.
        """
        filled = {name: fill_invalid(frames[name], good, self._fields[name]) for name, good in works.items()}
        kept = _Kept(time_s, {**frames, **filled}, {name: self._fields[name] & ~good for name, good in works.items()})
        if self._touched_s is None:
            if not touched:
                self._rest.append(kept)
                return None
            self._frames = [*self._rest]
            self._rest.clear()
            self._every, self._skipped = 1, 0
            self._touched_s = time_s, time_s
        first_s, last_s = self._touched_s
        if touched:
            self._touched_s = first_s, time_s
        elif time_s - last_s > _APART_S:
            ended = self.so_far()
            self._touched_s, self._frames = None, []
            self._rest.append(kept)
            self.number += 1
            return ended
        self._keep(kept)
        return None

    def so_far(self) -> KeptPress | None:
        """Return what there is of the press that lasts."""
        if self._touched_s is None:
            return None
        pads = {name: np.array([kept.frames[name] for kept in self._frames]) for name in self._fields}
        times_s = np.array([kept.time_s for kept in self._frames])
        place, of = f"press {self.number}", self._scale
        press = Press(pads, self._fields, times_s, {}, place, of.unit, of.pitch_m, self._mostly_broken())
        return KeptPress(self.number, press, *self._touched_s)

    def _mostly_broken(self) -> Masks:
        """Return which taxels were filled in more than half of the frames, of the pads that have such."""
        frames: dict[str, list[NDArray[np.bool_]]] = {}
        for kept in self._frames:
            for name, broken in kept.broken.items():
                frames.setdefault(name, []).append(broken)
        mostly = {name: np.sum(broken, axis=0) > len(self._frames) / 2 for name, broken in frames.items()}
        return {name: broken for name, broken in mostly.items() if broken.any()}

    def _keep(self, kept: _Kept) -> None:
        self._skipped += 1
        if self._skipped < self._every:
            return
        self._skipped = 0
        self._frames.append(kept)
        if len(self._frames) >= _MOST_FRAMES:
            del self._frames[1::2]
            self._every *= 2
