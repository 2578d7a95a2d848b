"""Plain stand-ins for the zero that follows and the tracker of contacts, until those are there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
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
    pad: str

    def to_dict(self) -> dict[str, Any]:
        return {"event": self.kind, "time_s": self.time_s, "track": self.track, "pad": self.pad}


@dataclass(frozen=True)
class Track:
    number: int
    pad: str
    onset_s: float
    state: str
    contact: Contact
    answer: Surface | None

    @property
    def position_taxels(self) -> tuple[float, float]:
        return self.contact.peak_position

    def to_dict(self) -> dict[str, Any]:
        answer = self.answer
        return {
            "track": self.number,
            "pad": self.pad,
            "onset_s": self.onset_s,
            "state": self.state,
            "position_taxels": list(self.position_taxels),
            "name": None if answer is None else answer.name,
            "probability": None if answer is None else round(answer.probability, 4),
        }


class ContactTracker:
    """Contacts joined to the nearest of the frame before."""

    def __init__(self, *, pad: str = "pad", pascals_per_unit: float | None = None) -> None:
        self.tracks: tuple[Track, ...] = ()
        self._pad = pad
        self._count = 0

    def update(self, time_s: float, contacts: list[Contact], frame: NDArray[np.float64]) -> list[Event]:
        events, kept, free = [], [], list(self.tracks)
        for contact in contacts:
            if contact.peak < 12 * contact.sigma:
                continue
            reach = 6 * contact.spacing[0]
            near = [t for t in free if math.dist(t.contact.peak_position, contact.peak_position) < reach]
            surface = recognize(contact)
            if near:
                free.remove(near[0])
                kept.append(replace(near[0], contact=contact, answer=surface, state="hold"))
            else:
                self._count += 1
                kept.append(Track(self._count, self._pad, time_s, "onset", contact, surface))
                events.append(Event("touched", time_s, self._count, self._pad))
        events += [Event("released", time_s, gone.number, self._pad) for gone in free]
        self.tracks = tuple(kept)
        return events

    def end(self, time_s: float | None = None) -> list[Event]:
        self.tracks = ()
        return []
