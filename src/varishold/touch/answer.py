"""What touch answers about one contact of a recording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from varishold.touch.surface import Surface

__all__ = ["Answer"]


@dataclass(frozen=True)
class Answer:
    """One contact of a recording, recognized.

    Parameters
    ----------
    file : str or None
        Where the recording came from.
    frame : int
        Zero-based frame; of a press, the frame of largest total.
    time_s : float or None
        The frame's time.
    pad : str
        Name of the pad.
    contact : int
        Number of the contact in its frame, 0 the largest.
    surface : Surface
        What it is.
    unit : str
        Unit of the taxels, ``"raw"`` where unknown.
    pascals_per_unit : float or None
        What one unit is in pascal, where it is a pressure.
    pitch_m : (float, float) or None
        Row and column spacing.
    sensor : str or None
        The sensor file that was used, or the sensor's name.
    frame_notes : tuple of str
        What was done to the frame before contacts were looked for.
    """

    file: str | None
    frame: int
    time_s: float | None
    pad: str
    contact: int
    surface: Surface
    unit: str
    pascals_per_unit: float | None
    pitch_m: tuple[float, float] | None
    sensor: str | None = None
    frame_notes: tuple[str, ...] = ()

    @property
    def force_n(self) -> float | None:
        """Force of the contact in newtons, where the unit is a pressure and the pitch is known."""
        if self.pascals_per_unit is None or self.pitch_m is None:
            return None
        contact = self.surface.contact
        felt = contact.values[contact.mask] + contact.state.beneath
        return float(felt.sum()) * contact.taxel_area * self.pascals_per_unit

    @property
    def depth_m(self) -> float | None:
        """Height of the contact's top above the standard plane, metres, where the frame is a height map."""
        if self.unit not in ("m", "metre", "meter"):
            return None
        return float(self.surface.contact.peak)

    @property
    def radius_m(self) -> float | None:
        """Radius of curvature, metres, of a sphere or lying cylinder where the frame is a height map."""
        surface, depth = self.surface, self.depth_m
        if depth is None or self.pitch_m is None or surface.name not in ("sphere", "lying cylinder"):
            return None
        # A chord of breadth b at depth h below the top: r = (b^2 / 4 + h^2) / 2 h, at half height.
        contact = surface.contact
        middle = surface.middle
        h = contact.peak - float(contact.profile.threshold[middle])
        if h <= 0:
            return None
        b = surface.breadths(middle)[1]
        return (b * b / 4 + h * h) / (2 * h)

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain values that JSON can hold."""
        s, contact = self.surface, self.surface.contact
        known = self.pitch_m is not None
        unit = math.sqrt(contact.taxel_area)
        x, y = s.position
        spacing_y, spacing_x = contact.spacing
        size = None if s.size is None else list(s.size)
        inequality = s.inequality
        return {
            "file": self.file,
            "frame": self.frame,
            "time_s": self.time_s,
            "pad": self.pad,
            "contact": self.contact,
            "name": s.name,
            "form": s.form,
            "section": s.section,
            "probability": _rounded(s.probability),
            "alternatives": {name: _rounded(p) for name, p in s.alternatives.items()},
            "reasons": list(s.reasons),
            "position_m": [x, y] if known else None,
            "orientation_rad": s.orientation,
            "size_m": size if known else None,
            "radius_m": self.radius_m,
            "area_m2": s.area if known else None,
            "position_taxels": [x / spacing_x, y / spacing_y],
            "size_taxels": None if size is None else [length / unit for length in size],
            "area_taxels": s.area / contact.taxel_area,
            "apex_exponent": s.exponent,
            "defect_sqrt_area": _finite(inequality.defect_sqrt_area),
            "defect_perimeter": _finite(inequality.defect_perimeter),
            "bulge_sqrt_area": _finite(inequality.bulge_sqrt_area),
            "bulge_perimeter": _finite(inequality.bulge_perimeter),
            "holes": s.holes,
            "force_n": self.force_n,
            "depth_m": self.depth_m,
            "sensor": self.sensor,
            "frame_notes": list(self.frame_notes),
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _rounded(p: float) -> float:
    return round(p, 4)
