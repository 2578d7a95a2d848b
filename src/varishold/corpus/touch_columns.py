"""The columns of ``varishold touch -o``: what `Answer.to_dict` says, each number in a column of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from varishold.corpus.columns import Column, Kind

__all__ = ["SAID", "Said"]


@dataclass(frozen=True)
class Said:
    """A column, and where its cell stands in what an answer says.

    Parameters
    ----------
    column : Column
    key : str
        Of `Answer.to_dict`.
    path : tuple of int
        The place in the list that stands there; empty for all of it.
    """

    column: Column
    key: str
    path: tuple[int, ...] = ()

    def of(self, told: Mapping[str, Any]) -> Any:
        """Return the cell; None where there is none."""
        value = told[self.key]
        for place in self.path:
            if value is None:
                return None
            value = value[place]
        if self.column.kind == "shares":
            return [{"name": name, "probability": share} for name, share in value.items()]
        return value


def _said(name: str, kind: Kind, meaning: str, key: str = "", *path: int) -> Said:
    return Said(Column(name, kind, meaning), key or name, path)


def _interval(name: str, unit: str, of: str, *path: int) -> tuple[Said, Said]:
    """Return the two ends of an interval."""
    key = f"{name.split('_')[0]}_interval_{unit}"
    meaning = f"end of the interval that holds the true {of} in 90 %"
    return (
        _said(f"{name}_low_{unit}", "number", f"lower {meaning}", key, *path, 0),
        _said(f"{name}_high_{unit}", "number", f"upper {meaning}", key, *path, 1),
    )


#: Every column after the first, which names the file.
SAID: tuple[Said, ...] = (
    _said("frame", "whole", "number of the frame, from 0; of a press, its heaviest frame"),
    _said("time_s", "number", "time of that frame by the recording's clock"),
    _said("pad", "text", "name of the pad"),
    _said("contact", "whole", "number of the contact in its frame, 0 the largest"),
    _said("name", "text", "the surface's name"),
    _said("form", "text", "its form: pillar, frustum, pyramidal, spherical, ridge, edge, plane, unknown"),
    _said("section", "text", "the shape of its sections"),
    _said("probability", "number", "of the name"),
    _said("alternatives", "shares", "the other names of probability .01 or more"),
    _said("outline", "text", "round, square ...: what can be said where the name cannot"),
    _said("outline_probability", "number", "of the outline"),
    _said("answer_set", "texts", "the fewest names that hold 90 %"),
    _said("cut", "texts", "the pad's sides that end the contact"),
    _said("reasons", "texts", "why, in words"),
    _said("position_x_m", "number", "along the columns, from the pad's centre", "position_m", 0),
    _said("position_y_m", "number", "along the rows, from the pad's centre", "position_m", 1),
    _said("orientation_rad", "number", "of the long side, from +x toward +y"),
    _said("size_long_m", "number", "long side, or diameter", "size_m", 0),
    _said("size_short_m", "number", "short side", "size_m", 1),
    *_interval("size_long", "m", "long side", 0),
    *_interval("size_short", "m", "short side", 1),
    _said("radius_m", "number", "radius of curvature, where the depth is known"),
    *_interval("radius", "m", "radius"),
    _said("area_m2", "number", "of the lowest section"),
    _said("position_x_taxels", "number", "as position_x_m, in taxels", "position_taxels", 0),
    _said("position_y_taxels", "number", "as position_y_m, in taxels", "position_taxels", 1),
    _said("size_long_taxels", "number", "as size_long_m, in taxels", "size_taxels", 0),
    _said("size_short_taxels", "number", "as size_short_m, in taxels", "size_taxels", 1),
    _said("area_taxels", "number", "as area_m2, in taxels"),
    _said("apex_exponent", "number", "k of area ~ (top - threshold)^k"),
    _said("defect_sqrt_area", "number", "how far the square root of the area falls below its chord"),
    _said("defect_perimeter", "number", "the same of the perimeter"),
    _said("bulge_sqrt_area", "number", "how far the square root of the area rises above its chord"),
    _said("bulge_perimeter", "number", "the same of the perimeter"),
    _said("holes", "whole", "in its sections"),
    _said("force_n", "number", "where the unit is a pressure and the pitch is known"),
    _said("depth_m", "number", "height of the top above the rest, of a height map or a fit"),
    *_interval("depth", "m", "depth"),
    _said("tilt_rad", "number", "how far a flat face leans, of a height map"),
    _said("rounding_m", "number", "radius at which edges are rounded, of a fit"),
    _said("sensor", "text", "the sensor file that was used"),
    _said("frame_notes", "texts", "what was done to the frame before contacts were looked for"),
)
