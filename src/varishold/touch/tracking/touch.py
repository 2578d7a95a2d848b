"""One touch as the tracker follows it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from varishold.touch.tracking.evidence import Evidence
from varishold.touch.tracking.felt import Felt

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
    fragment_of : Touch, optional
        The touch whose contact it fell off from.
    number : int
        0 until it is told.
    frames, missed : int
        So many frames showed it, so many in a row did not.
    is_visible : bool
        Whether the newest frame has a contact for it.
    own_taxels, own_position, merged_at
        Of a touch that shares its contact: its own taxels and centre of load before, and where that contact then was.
    peak_load, peak : float
        The largest so far.
    widest : ndarray of shape (n_taxels,), intp
        Its taxels when its load was largest.
    evidence : Evidence
    """

    felt: Felt
    onset_s: float
    seen_s: float
    fragment_of: Touch | None = None
    number: int = 0
    frames: int = 1
    missed: int = 0
    is_visible: bool = True
    merged_at: Point = (0.0, 0.0)
    own_position: Point = (0.0, 0.0)
    own_taxels: NDArray[np.intp] | None = None
    peak_load: float = 0.0
    peak: float = 0.0
    widest: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, np.intp))
    evidence: Evidence = field(default_factory=Evidence)

    def __post_init__(self) -> None:
        self.peak_load, self.peak, self.widest = self.felt.load, self.felt.peak, self.felt.taxels

    @property
    def is_sure(self) -> bool:
        """Whether it was told."""
        return self.number > 0

    @property
    def is_merged(self) -> bool:
        """Whether it shares its contact with another touch."""
        return self.own_taxels is not None

    @property
    def taxels(self) -> NDArray[np.intp]:
        """Its taxels when it was last seen; of what is merged, those it had before, moved along."""
        if self.own_taxels is None:
            return self.felt.taxels
        rows, cols = self.felt.contact.shape
        right, down = (round(now - then) for now, then in zip(self.felt.position, self.merged_at, strict=True))
        row, col = self.own_taxels // cols + down, self.own_taxels % cols + right
        inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        return np.asarray(row[inside] * cols + col[inside], dtype=np.intp)

    @property
    def expected(self) -> Point:
        """Where its centre of load is expected."""
        if self.own_taxels is None:
            return self.felt.position
        moved = (now - then for now, then in zip(self.felt.position, self.merged_at, strict=True))
        x, y = (own + by for own, by in zip(self.own_position, moved, strict=True))
        return x, y

    @property
    def reach(self) -> float:
        """How far from there it may be found if nothing overlaps it."""
        return math.sqrt(len(self.felt.taxels) / math.pi) + _BEYOND

    def lay_at(self, felt: Felt) -> bool:
        """Tell whether a contact lies where this touch was when it pressed most."""
        return bool(np.isin(felt.taxels, self.widest, assume_unique=True).any())

    def see(self, felt: Felt, time_s: float) -> None:
        """Take the contact that is it in a new frame."""
        self.felt, self.seen_s = felt, time_s
        if felt.load > self.peak_load:
            self.widest = felt.taxels
        self.frames += 1
        self.missed = 0
        self.is_visible = True
        self.peak_load, self.peak = max(self.peak_load, felt.load), max(self.peak, felt.peak)

    def merge(self, felt: Felt) -> None:
        """Begin to share a contact with another touch."""
        if self.own_taxels is None:
            self.own_taxels, self.own_position, self.merged_at = self.felt.taxels, self.felt.position, felt.position

    def part(self) -> None:
        """Have a contact of its own again."""
        self.own_taxels = None
