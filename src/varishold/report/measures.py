"""A contact's measures as pairs of a name and a text."""

from __future__ import annotations

import math

from varishold.report.quantities import angle, area, length, number, prefixed, reading
from varishold.report.wording import cut_at
from varishold.touch import Answer

__all__ = ["measures"]

#: Forms whose size belongs to their top face.
_SIZED_AT_TOP = ("pillar", "frustum")


def measures(answer: Answer) -> list[tuple[str, str]]:
    """Return what was measured of a contact, as (name, text), in the order of interest.

    Lengths are metres with a prefix where the pitch is known, taxels where it is not.
    """
    surface, contact = answer.surface, answer.surface.contact
    metres = answer.pitch_m is not None
    unit = min(contact.spacing)
    # A thousandth of a taxel is beyond what any sensor tells.
    x, y = (length(v if abs(v) >= 1e-3 * unit else 0.0, metres=metres) for v in surface.position)
    rows = [*_size(answer), ("position x", x), ("position y", y)]
    if surface.orientation is not None:
        rows.append(("orientation, x to y", angle(surface.orientation)))
    rows.append(("area", _area(answer)))
    if answer.radius_m is not None:
        rows.append(("radius of curvature", _with_interval(answer.radius_m, answer.radius_interval_m, True)))
    if answer.depth_m is not None:
        rows.append(("depth", _with_interval(answer.depth_m, answer.depth_interval_m, True)))
    if answer.tilt_rad is not None:
        rows.append(("tilt", angle(answer.tilt_rad)))
    if answer.force_n is not None:
        rows.append(("force", prefixed(answer.force_n, "N")))
    if surface.exponent is not None:
        rows.append(("apex exponent k", number(round(surface.exponent, 2), 2)))
    if hidden := cut_at(surface):
        rows.append(("cut by the pad's border", ", ".join(hidden)))
    rows.append(("form, section", f"{surface.form}, {surface.section}"))
    if surface.holes:
        rows.append(("holes at half height", str(surface.holes)))
    rows.append(("highest taxel θ₁", reading(contact.peak, answer.unit)))
    rows.append(("standard plane δ", reading(contact.floor, answer.unit)))
    rows.append(("noise σ", reading(contact.sigma, answer.unit)))
    return rows


def _size(answer: Answer) -> list[tuple[str, str]]:
    surface, metres = answer.surface, answer.pitch_m is not None
    if surface.form in ("plane", "edge"):
        return []
    long, short = answer.size
    of_long, of_short = answer.size_interval if surface.has_size else (None, None)
    where = " of the top" if surface.form in _SIZED_AT_TOP else ""
    if surface.completed is not None:
        where += ", completed"
    if surface.section in ("circle", "square"):
        name = "diameter" if surface.section == "circle" else "breadth"
        return [(name + where, _with_interval(long, of_long, metres))]
    return [
        ("long side" + where, _with_interval(long, of_long, metres)),
        ("short side" + where, _with_interval(short, of_short, metres)),
    ]


def _with_interval(value: float, bounds: tuple[float, float] | None, metres: bool) -> str:
    """Write a length and its interval, if it has one; the unit is said once where all three have it."""
    if bounds is None or not all(map(math.isfinite, bounds)):
        return length(value, metres=metres)
    texts = [length(v, metres=metres) for v in (*bounds, value)]
    numbers, units = zip(*(text.split("\u202f") for text in texts), strict=True)
    low, high = numbers[:2] if len(set(units)) == 1 else texts[:2]
    return f"{texts[2]} ({low} to {high})"


def _area(answer: Answer) -> str:
    surface = answer.surface
    taxels = number(surface.area / surface.contact.taxel_area)
    if answer.pitch_m is None:
        return f"{taxels}\u202ftaxels"
    return f"{area(surface.area, metres=True)} ({taxels}\u202ftaxels)"
