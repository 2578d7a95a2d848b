"""When a touch is looked at, and what it is by all that was seen of it."""

from __future__ import annotations

from varishold.levelset.contact import Contact
from varishold.touch.pooling import EvidencePool
from varishold.touch.recognizer import recognize
from varishold.touch.surface import Surface

__all__ = ["Evidence"]

# A section of fewer taxels has no form yet.
_FEWEST_TAXELS = 4
# Looks at a touch are so far apart, and in a long one this share of its length.
_LEAST_INTERVAL_S, _INTERVAL_SHARE = 0.02, 1 / 16


class Evidence:
    """The answer of one touch, pooled over its looks.

    A look costs a recognition. What noise does to an answer is averaged away by a few dozen looks; how many frames a
    second the sensor sends does not change when one is taken.
    """

    def __init__(self) -> None:
        self._pool = EvidencePool()
        self._best: Surface | None = None
        self._best_load = 0.0
        self._answer: Surface | None = None
        self._first_s = self._next_s = float("-inf")

    @property
    def looks(self) -> int:
        """How many looks there were."""
        return self._pool.looks

    def look(self, time_s: float, contact: Contact, load: float) -> None:
        """Take one more look, if it is time for one."""
        if time_s < self._next_s or contact.n_taxels < _FEWEST_TAXELS:
            return
        if not self.looks:
            self._first_s = time_s
        self._next_s = time_s + max(_LEAST_INTERVAL_S, _INTERVAL_SHARE * (time_s - self._first_s))
        surface = recognize(contact)
        self._pool.add(surface)
        self._answer = None
        if self._best is None or load > self._best_load:
            self._best, self._best_load = surface, load

    @property
    def answer(self) -> Surface | None:
        """What it is; the measures are those of the heaviest look."""
        if self._answer is None and self._best is not None:
            self._answer = self._pool.answer(self._best)
        return self._answer
