"""Plain stand-ins for the zero that follows and the tracker of contacts, until those are there."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact
from varishold.touch import Surface, recognize

__all__ = ["ContactTracker", "Event", "FollowingZero", "Track"]


class FollowingZero:
    """The median of the first frames."""

    def __init__(self, shape: tuple[int, int], *, field: Any = None, valid: Any = None) -> None:
        self._first: list[NDArray[np.float64]] = []
        self._zero = np.zeros(shape)
        self.sigma: float | None = None
        self.log: list[str] = []

    def update(self, time_s: float, frame: NDArray[np.float64]) -> NDArray[np.float64]:
        if len(self._first) < 16:
            self._first.append(frame)
            self._zero = np.median(self._first, axis=0)
            self.sigma = None
            return np.zeros(frame.shape)
        elif self.sigma is None:
            self.sigma = float(np.std(np.asarray(self._first) - self._zero)) or None
        return frame - self._zero


@dataclass(frozen=True)
class Event:
    kind: str
    time_s: float
    track: int
    values: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        return {"kind": self.kind, "time_s": self.time_s, "track": self.track, **self.values}


@dataclass
class Track:
    identity: int
    state: str
    contact: Contact
    surface: Surface
    since_s: float


class ContactTracker:
    """Contacts joined to the nearest of the frame before."""

    def __init__(self) -> None:
        self.tracks: list[Track] = []
        self._next = 0

    def update(self, time_s: float, contacts: list[Contact], frame: NDArray[np.float64]) -> list[Event]:
        events, kept, free = [], [], list(self.tracks)
        for contact in contacts:
            surface = recognize(contact)
            x, y = contact.peak_position
            reach = 4 * contact.spacing[0]
            near = [t for t in free if math.dist(t.contact.peak_position, (x, y)) < reach]
            if near:
                track = near[0]
                free.remove(track)
                track.contact, track.surface, track.state = contact, surface, "held"
            else:
                track = Track(self._next, "onset", contact, surface, time_s)
                self._next += 1
                events.append(Event("touched", time_s, track.identity))
            kept.append(track)
        events += [Event("released", time_s, gone.identity) for gone in free]
        self.tracks = kept
        return events
