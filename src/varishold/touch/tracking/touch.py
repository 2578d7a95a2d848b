"""One touch as the tracker follows it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.event import EventKind
from varishold.touch.tracking.evidence import Evidence
from varishold.touch.tracking.felt import Felt
from varishold.touch.tracking.motion import Motion
from varishold.touch.tracking.sliding import Shear

__all__ = ["Touch"]

Point = tuple[float, float]
# What overlaps nothing is looked for so far beyond the contact's own radius, in taxels.
_BEYOND = 1.5


@dataclass(eq=False)
class Touch:
    """What is known of one touch, from the first frame that may show it.

    Parameters
    ----------
    felt : Felt
        As it was last seen.
    onset_s, seen_s : float
        Times of the first and of the newest frame that showed it.
    part_of : Touch, optional
        The touch from whose contact it fell off, or beside which it came in, until it is one of its own.
    number : int
        0 until it is told.
    frames, missed : int
        So many frames showed it, so many in a row did not.
    is_visible : bool
        Whether the newest frame has a contact for it.
    is_whole : bool
        Whether that is one contact; parts of it may have fallen off.
    widest : Felt
        As it was when its load was largest.
    peak : float
        Its highest, in the unit of the frame.
    alone : Felt, optional
        Of a touch that shares its contact: as it was before.
    shared : Felt, optional
        The shared contact, as it then was.
    evidence : Evidence
    motion : Motion
    word : {"moved", "slid", "slip", "tipped"}
        What its newest motion is called.
    shear : Shear
    """

    felt: Felt
    onset_s: float
    seen_s: float
    part_of: Touch | None = None
    number: int = 0
    frames: int = 1
    missed: int = 0
    is_visible: bool = True
    is_whole: bool = True
    widest: Felt = field(init=False)
    peak: float = field(init=False)
    alone: Felt | None = None
    shared: Felt | None = None
    evidence: Evidence = field(default_factory=Evidence)
    motion: Motion = field(default_factory=Motion)
    word: EventKind = "moved"
    shear: Shear = field(default_factory=Shear)

    def __post_init__(self) -> None:
        self.widest, self.peak = self.felt, self.felt.peak

    @property
    def is_sure(self) -> bool:
        """Whether it was told."""
        return self.number > 0

    @property
    def is_merged(self) -> bool:
        """Whether it shares its contact with another touch."""
        return self.alone is not None

    @property
    def taxels(self) -> NDArray[np.intp]:
        """Its taxels when it was last seen; of what is merged, those it had before, moved along."""
        if self.alone is None:
            return self.felt.taxels
        rows, cols = self.felt.contact.shape
        right, down = self._moved
        row, col = self.alone.taxels // cols + down, self.alone.taxels % cols + right
        inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        return np.asarray(row[inside] * cols + col[inside], dtype=np.intp)

    @property
    def expected(self) -> Point:
        """Where its centre of load is expected, in taxels."""
        if self.alone is None:
            return self.felt.position
        (x, y), (right, down) = self.alone.position, self._moved
        return x + right, y + down

    @property
    def reach(self) -> float:
        """How far from there it may be found if nothing overlaps it, in taxels."""
        return math.sqrt(len(self.felt.taxels) / math.pi) + _BEYOND

    @property
    def _moved(self) -> tuple[int, int]:
        """How far the shared contact moved, in taxels: as far as both its sides did, for one side may have left it."""
        assert self.shared is not None
        rows, cols = self.felt.contact.window
        rows_then, cols_then = self.shared.contact.window
        return _together(cols, cols_then), _together(rows, rows_then)

    def see(self, felt: Felt, time_s: float, *, is_whole: bool = True) -> None:
        """Take the contact that is it in a new frame."""
        self.is_whole = is_whole
        self.felt, self.seen_s = felt, time_s
        self.frames += 1
        self.missed, self.is_visible = 0, True
        self.peak = max(self.peak, felt.peak)
        if felt.load > self.widest.load:
            self.widest = felt

    def merge(self, felt: Felt) -> None:
        """Begin to share a contact with another touch, or go on so."""
        if self.alone is None:
            self.alone, self.shared = self.felt, felt

    def part(self) -> None:
        """Have a contact of its own again, and rest anew."""
        if self.alone is not None:
            self.alone, self.shared, self.motion = None, None, Motion()


def _together(now: slice, then: slice) -> int:
    first, last = now.start - then.start, now.stop - then.stop
    return min(first, last, key=abs) if first * last > 0 else 0
