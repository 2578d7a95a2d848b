"""Whether a touch rests, moves or tips."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.change import Change, Rest
from varishold.touch.tracking.felt import Felt
from varishold.touch.tracking.recent import Recent

__all__ = ["Motion", "MotionKind", "Told"]

Point = tuple[float, float]
MotionKind = Literal["moved", "tipped"]
# The load is steady where it changed by less than this share in so long.
_STEADY, _STEADY_S = 0.1, 0.05
# Frames are compared while the load is between these shares of what it was at rest.
_LEAST_LOAD, _MOST_LOAD = 0.6, 1.6
# A rest is compared with after so many frames and so long; later frames count less, and slow drift is forgotten.
_REST_FRAMES, _REST_S, _FORGOTTEN_S = 3, 0.02, 4.0
# A contact has moved, or its load within the outline, from so far on, and is told again after so much more. Taxels.
_MOVED, _TIPPED, _AGAIN = 0.14, 0.12, 1.0
# A tip must move the load by so much of its own scatter too.
_TIPPED_SHARE = 0.12
# What has not gone this share of the way surely rests.
_SURELY = 0.5
# Noise is so many sigma wide, and so many frames in a row must say the same.
_SIGMAS, _FRAMES = 4.0, 2
# What a motion changes must stand so many sigma out of the noise, all taxels together.
_CLEAR = 4.0
# What explains the change must come to this share of the way, within an angle that has this cosine.
_EXPLAINED, _ALIKE = 0.6, 0.5
# Where the load is not what it was, a face that leans comes to lie or lifts off: the centre of load must go farther, by
# this share of the load's scatter times the share of the change. While it is changing, a tip must go farther still, by
# this share of the contact's radius times what changed in a moment.
_BY_LOAD, _TIPPED_BY_LOADING = 0.4, 1.0
# A contact has moved unless a lean explains so many times as much. What is narrower than four taxels tips unseen: so
# far its load must scatter.
_DOUBT, _BROAD = 1.18, 0.9
# The centre of load rests that drifts by less than so many taxels between the halves of so long.
_STILL, _STILL_S = 0.06, 0.2


@dataclass(frozen=True)
class Told:
    """A motion or a tip.

    Parameters
    ----------
    kind : {"moved", "tipped"}
    way : (float, float)
        Of the centre of load since the contact last rested, in taxels.
    time_s : float
        When it came so far.
    is_new : bool
        Whether nothing was told of this motion before.
    resting : bool
        Whether it is over.
    """

    kind: MotionKind
    way: Point
    time_s: float
    is_new: bool = False
    resting: bool = False


class Motion:
    """What one touch does while it lasts.

    At first the load rises, and nothing is told. Once it is steady, the contact rests, and each frame is compared with
    the rest's mean. What has moved or tipped is followed by its centre of load until that rests again.
    """

    def __init__(self) -> None:
        self._recent = Recent(_STILL_S)
        self._rest: Rest | None = None
        self._going: MotionKind | None = None
        self._rest_s = self._first_s = 0.0
        self._count = 0
        self._told: Point = (0.0, 0.0)
        self._steady: Point = (0.0, 0.0)
        self._load = 0.0

    @property
    def state(self) -> Literal["onset", "hold", "motion"]:
        """What the touch does."""
        if self._going is not None:
            return "motion"
        return "onset" if self._rest is None else "hold"

    def update(self, time_s: float, felt: Felt, frame: NDArray[np.float64]) -> Told | None:
        """Return what is to be told of a new frame."""
        self._recent.add(time_s, felt)
        rest = self._rest
        if rest is None:
            if self._recent.reaches(_STEADY_S) and self._recent.load_range(_STEADY_S) <= _STEADY:
                self._settle(time_s, felt)
            return None
        if self._going is not None:
            return self._follow(time_s, felt, rest, self._going)
        if rest.frames < _REST_FRAMES or time_s - self._rest_s < _REST_S:
            rest.add(felt, frame, 1 / (rest.frames + 1))
            return None
        return self._compare(time_s, felt, frame, rest)

    def _settle(self, time_s: float, felt: Felt) -> None:
        """Begin to rest."""
        self._rest, self._rest_s = Rest(felt), time_s
        self._going, self._count = None, 0

    def _compare(self, time_s: float, felt: Felt, frame: NDArray[np.float64], rest: Rest) -> Told | None:
        """Look whether what rested still does."""
        change = rest.change(frame, felt.sigma)
        if not _LEAST_LOAD < change.load < _MOST_LOAD:
            self._rest = None
            return None
        loading = self._recent.load_change(_STEADY_S) * math.sqrt(len(felt.taxels) / math.pi)
        way = _way(rest.position, felt.position)
        kind = _kind(change, way, loading, felt.sigma)
        if kind is None:
            self._count = 0
            share = self._recent.step_s / _FORGOTTEN_S
            if math.hypot(*way) < _SURELY * _MOVED:
                share = max(share, 1 / (rest.frames + 1))
            rest.add(felt, frame, share)
            return None
        if self._count == 0:
            self._first_s = time_s
        self._count += 1
        if self._count < _FRAMES:
            return None
        self._going, self._load = kind, felt.load
        self._told = self._steady = felt.position
        return Told(kind, way, self._first_s, is_new=True)

    def _follow(self, time_s: float, felt: Felt, rest: Rest, kind: MotionKind) -> Told | None:
        """Look how far what moves has come."""
        if felt.load < _LEAST_LOAD * self._load:
            # It leaves before it has come to rest.
            self._rest = self._going = None
            unsaid = math.dist(self._steady, self._told) >= _MOVED
            return Told(kind, _way(rest.position, self._steady), time_s, resting=True) if unsaid else None
        if self._recent.load_change(_STEADY_S) <= _STEADY:
            self._steady = felt.position
        way = _way(rest.position, felt.position)
        if time_s - self._first_s >= _STILL_S and self._recent.drift(_STILL_S) < _STILL:
            self._settle(time_s, felt)
            return Told(kind, way, time_s, resting=True)
        if math.dist(felt.position, self._told) >= _AGAIN:
            self._told = felt.position
            return Told(kind, way, time_s)
        return None


def _way(start: Point, end: Point) -> Point:
    return end[0] - start[0], end[1] - start[1]


def _kind(change: Change, way: Point, loading: float, sigma: float) -> MotionKind | None:
    """Return what a change is, if it is large enough to be anything."""
    breadth = change.breadth(way)
    by_load = _BY_LOAD * breadth * abs(change.load - 1)
    if change.by_lean > _DOUBT * change.by_shift and breadth >= _BROAD:
        least = max(_TIPPED, _TIPPED_SHARE * breadth, _SIGMAS * change.lean_sigma)
        far = _is_far(change.lean, way, least + by_load + _TIPPED_BY_LOADING * loading)
        return "tipped" if far and change.by_lean > (_CLEAR * sigma) ** 2 else None
    least = max(_MOVED, _SIGMAS * change.shift_sigma)
    far = _is_far(change.shift, way, least + by_load)
    return "moved" if far and change.by_shift > (_CLEAR * sigma) ** 2 else None


def _is_far(by: Point, way: Point, least: float) -> bool:
    """Tell whether the centre of load has gone far enough, and a shift or a lean explains it."""
    far, gone = math.hypot(*by), math.hypot(*way)
    alike = by[0] * way[0] + by[1] * way[1]
    return gone >= least and far >= _EXPLAINED * least and alike >= _ALIKE * far * gone
