"""What happened to a contact, and when."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

__all__ = ["Event", "EventKind"]

EventKind = Literal["touched", "moved", "slid", "slip", "tipped", "released"]


@dataclass(frozen=True)
class Event:
    """Something that happened to a tracked contact.

    Positions and lengths stand in taxels, x with the column and y with the row from the pad's centre, and in metres
    too where the pitch is known.

    Parameters
    ----------
    kind : {"touched", "moved", "slid", "slip", "tipped", "released"}
        ``moved``: the contact lies elsewhere; whether it rolled or slid its form does not tell. ``slid``: it does.
        ``slip``: shear was measured, and pulled along. ``tipped``: the load moved within an outline that stayed.
    time_s : float
        When it happened, in the time of the frames.
    told_s : float
        Time of the frame by which it was sure, not before `time_s`.
    track : int
        Number of the track.
    pad : str
    position_taxels : (float, float)
        Centre of load.
    position_m : (float, float) or None
    area_taxels : float
        Taxels above the contact's floor.
    area_m2 : float or None
    load : float
        Sum over the contact's taxels, in the unit of the frame.
    force_n : float or None
        The load where the unit is a pressure and the pitch is known.
    direction_rad : float or None
        Of a motion, or in which the load moved within the outline: from +x toward +y, in (-pi, pi].
    distance_taxels : float or None
        How far, since the contact last rested.
    distance_m : float or None
    resting : bool or None
        Of a motion: whether it has come to rest.
    duration_s : float or None
        Of a release: how long the touch was.
    peak_load : float or None
        Of a release: the largest load of the touch.
    """

    kind: EventKind
    time_s: float
    told_s: float
    track: int
    pad: str
    position_taxels: tuple[float, float]
    position_m: tuple[float, float] | None
    area_taxels: float
    area_m2: float | None
    load: float
    force_n: float | None
    direction_rad: float | None = None
    distance_taxels: float | None = None
    distance_m: float | None = None
    resting: bool | None = None
    duration_s: float | None = None
    peak_load: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the event as plain values that JSON can hold; the kind is called ``event``."""
        values = asdict(self)
        kind = values.pop("kind")
        listed = {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}
        return {"event": kind, **listed}
