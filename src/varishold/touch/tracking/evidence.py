"""When a touch is looked at, and what it is by all that was seen of it."""

from __future__ import annotations

from varishold.touch.caution import unsure_of_top
from varishold.touch.pooling import EvidencePool
from varishold.touch.recognizer import recognize
from varishold.touch.surface import Surface
from varishold.touch.tracking.felt import Felt
from varishold.touch.tracking.steady_mean import SteadyMean

__all__ = ["Evidence"]

# A section of fewer taxels has no form yet.
_FEWEST_TAXELS = 4
# Looks at a touch are so far apart, and in a long one this share of its length.
_LEAST_INTERVAL_S, _INTERVAL_SHARE = 0.02, 1 / 16


class Evidence:
    """The answer of one touch, pooled over its looks.

    A look costs a recognition. It is at the mean of the frames since the contact lies still, and counts the more, the
    more there are. How many frames a second the sensor sends does not change when one is taken.
    """

    def __init__(self) -> None:
        self._pool = EvidencePool()
        self._mean = SteadyMean()
        self._best: Surface | None = None
        self._best_load = 0.0
        self._answer: Surface | None = None
        self._first_s = self._next_s = float("-inf")

    @property
    def looks(self) -> int:
        """How many looks there were."""
        return self._pool.looks

    def look(self, time_s: float, felt: Felt) -> None:
        """Take in one more frame, and look at it if it is time for that."""
        if felt.contact.n_taxels < _FEWEST_TAXELS:
            return
        self._mean.add(felt)
        if time_s < self._next_s:
            return
        if not self.looks:
            self._first_s = time_s
        self._next_s = time_s + max(_LEAST_INTERVAL_S, _INTERVAL_SHARE * (time_s - self._first_s))
        surface = unsure_of_top(recognize(self._mean.contact(felt)))
        self._pool.add(surface, frames=self._mean.frames)
        self._answer = None
        if self._best is None or felt.load > self._best_load:
            self._best, self._best_load = surface, felt.load

    @property
    def answer(self) -> Surface | None:
        """What it is; the measures are those of the heaviest look."""
        if self._answer is None and self._best is not None:
            self._answer = self._pool.answer(self._best)
        return self._answer
