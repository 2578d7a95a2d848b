"""When a point that should rest has left its place, how far it goes, and when it rests again."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

__all__ = ["Excursion", "Step"]

Point = tuple[float, float]
# So many frames in a row must say the same.
_FRAMES = 2
# A point rests that stays within this share of the least distance for so long.
_STILL, _STILL_S = 0.5, 0.2
# Noise is so many sigma wide.
_SIGMAS = 5.0


@dataclass(frozen=True)
class Step:
    """What is told of an excursion: the way from where the point last rested, and whether it rests again."""

    way: Point
    begun_s: float
    resting: bool


class Excursion:
    """Watches a point.

    Parameters
    ----------
    least : float
        From so far on it has left its place.
    again : float
        It is told again after so much more.
    """

    def __init__(self, least: float, again: float) -> None:
        self._least, self._again = least, again
        self._anchor: Point | None = None
        self._told: Point | None = None
        self._count = 0
        self._first_s = 0.0
        self._recent: deque[tuple[float, Point]] = deque()

    @property
    def is_moving(self) -> bool:
        """Whether the point has left its place and does not rest yet."""
        return self._told is not None

    def shift(self, by: Point) -> None:
        """Count a jump of the point as none."""
        self._anchor = None
        self._told = None
        self._count = 0
        self._recent.clear()

    def update(self, time_s: float, point: Point, sigma: float) -> Step | None:
        """Return what is to be told of the point's newest place."""
        if self._anchor is None:
            self._anchor = point
        self._recent.append((time_s, point))
        while len(self._recent) > 2 and self._recent[1][0] <= time_s - _STILL_S:
            self._recent.popleft()
        least = max(self._least, _SIGMAS * sigma)
        from_anchor = math.dist(point, self._anchor)
        if self._told is None:
            if from_anchor < least:
                self._count = 0
                return None
            if self._count == 0:
                self._first_s = time_s
            self._count += 1
            if self._count < _FRAMES:
                return None
            self._told = point
            return Step(_way(self._anchor, point), self._first_s, False)
        if self._rests(time_s, point, least):
            step = Step(_way(self._anchor, point), time_s, True)
            self._anchor, self._told, self._count = point, None, 0
            return step
        if math.dist(point, self._told) >= self._again:
            self._told = point
            return Step(_way(self._anchor, point), time_s, False)
        return None

    def _rests(self, time_s: float, point: Point, least: float) -> bool:
        if time_s - self._recent[0][0] < _STILL_S:
            return False
        return all(math.dist(point, then) < _STILL * least for _, then in self._recent)


def _way(start: Point, end: Point) -> Point:
    return end[0] - start[0], end[1] - start[1]
