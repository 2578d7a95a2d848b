"""A contact that is followed through time, as it stands at one frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from varishold.levelset.contact import Contact
from varishold.touch.surface import Surface

__all__ = ["Track", "TrackState"]

TrackState = Literal["onset", "hold", "motion", "merged", "lost"]


@dataclass(frozen=True)
class Track:
    """One touch, from its onset until its release.

    Parameters
    ----------
    number : int
        Counted from 1 for each tracker; no other touch gets it again.
    pad : str
    onset_s : float
        Time of the first frame that showed it.
    seen_s : float
        Time of the newest frame that showed it.
    state : {"onset", "hold", "motion", "merged", "lost"}
        ``onset``: the load still rises. ``merged``: one contact with another touch for now; what is measured is
        theirs together. ``lost``: not in the newest frame, and not yet taken for released.
    position : (float, float)
        Centre of load (x, y) from the pad's centre: metres where the pitch is known, taxels otherwise.
    area : float
        Area above the contact's floor: square metres where the pitch is known, taxels otherwise.
    load : float
        Sum over the contact's taxels, in the unit of the frame.
    peak_load : float
        The largest so far.
    force_n : float or None
        The load in newtons, where the unit is a pressure and the pitch is known.
    contact : Contact
        The contact of the newest frame that showed it.
    answer : Surface or None
        What it is, pooled over the touch so far; None while too few taxels are touched.
    looks : int
        So many frames are pooled in the answer.
    """

    number: int
    pad: str
    onset_s: float
    seen_s: float
    state: TrackState
    position: tuple[float, float]
    area: float
    load: float
    peak_load: float
    force_n: float | None
    contact: Contact
    answer: Surface | None
    looks: int

    @property
    def position_taxels(self) -> tuple[float, float]:
        """Centre of load (x, y) from the pad's centre, in taxels."""
        row_pitch, col_pitch = self.contact.spacing
        return self.position[0] / col_pitch, self.position[1] / row_pitch

    def to_dict(self) -> dict[str, Any]:
        """Return the track as plain values that JSON can hold; its answer with name, probability and alternatives."""
        known = self.contact.pitch is not None
        answer = self.answer
        return {
            "track": self.number,
            "pad": self.pad,
            "onset_s": self.onset_s,
            "seen_s": self.seen_s,
            "state": self.state,
            "position_m": list(self.position) if known else None,
            "position_taxels": list(self.position_taxels),
            "area_m2": self.area if known else None,
            "area_taxels": self.area / self.contact.taxel_area,
            "load": self.load,
            "peak_load": self.peak_load,
            "force_n": self.force_n,
            "name": None if answer is None else answer.name,
            "probability": None if answer is None else round(answer.probability, 4),
            "alternatives": {} if answer is None else {n: round(p, 4) for n, p in answer.alternatives.items()},
            "looks": self.looks,
        }
