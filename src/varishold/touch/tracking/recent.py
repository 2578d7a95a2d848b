"""The last moments of a touch: how its load changed, and whether its centre of load stays."""

from __future__ import annotations

import math
from collections import deque

from varishold.touch.tracking.felt import Felt

__all__ = ["Recent"]

Point = tuple[float, float]
# Times are compared to within this: frames stand at multiples of a period that no float holds.
_SAME_S = 1e-6
# No more are remembered, should the time stand still.
_MOST = 4096


class Recent:
    """The frames of the last moments.

    Parameters
    ----------
    kept_s : float
        How long frames are remembered; the newest of those that are older stays too.
    """

    def __init__(self, kept_s: float) -> None:
        self._kept_s = kept_s
        self._moments: deque[tuple[float, Point, float]] = deque(maxlen=_MOST)

    def add(self, time_s: float, felt: Felt) -> None:
        """Remember a frame."""
        self._moments.append((time_s, felt.position, felt.load))
        while len(self._moments) > 2 and time_s - self._moments[1][0] >= self._kept_s - _SAME_S:
            self._moments.popleft()

    @property
    def step_s(self) -> float:
        """How long ago the frame before the newest was."""
        return self._moments[-1][0] - self._moments[-2][0] if len(self._moments) > 1 else 0.0

    def reaches(self, ago_s: float) -> bool:
        """Tell whether there is a frame that is at least so old."""
        return self._moments[-1][0] - self._moments[0][0] >= ago_s - _SAME_S

    def load_change(self, ago_s: float) -> float:
        """Return by which share of it the newest load differs from the one so long ago."""
        return abs(self._load(ago_s) - self._moments[-1][2]) / self._moments[-1][2]

    def load_range(self, ago_s: float) -> float:
        """Return by which share of it the newest load differs at most from those since so long ago."""
        now, load = self._moments[-1][0], self._moments[-1][2]
        since = [other for time_s, _, other in self._moments if now - time_s <= ago_s + _SAME_S]
        return max(abs(other - load) for other in (*since, self._load(ago_s))) / load

    def drift(self, ago_s: float) -> float:
        """Return how far the centre of load went from the first half of the last moment to its second half."""
        now = self._moments[-1][0]
        halves: tuple[list[Point], list[Point]] = ([], [])
        for time_s, point, _ in self._moments:
            if now - time_s <= ago_s + _SAME_S:
                halves[now - time_s < ago_s / 2].append(point)
        before, since = halves
        return math.dist(_mean(before), _mean(since)) if before and since else math.inf

    def _load(self, ago_s: float) -> float:
        now = self._moments[-1][0]
        older = (load for time_s, _, load in reversed(self._moments) if now - time_s >= ago_s - _SAME_S)
        return next(older, self._moments[0][2])


def _mean(points: list[Point]) -> Point:
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)
