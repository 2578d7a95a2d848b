"""The grip from above: every phalanx as a capsule, and the section that lies against all of them at once."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from varishold.perceive import GRIP_SECTIONS, GripContacts, SectionFit, fit_section

__all__ = ["SECTION_OF", "grip_drawing"]

Floats = NDArray[np.float64]

#: The section of each object, and whether it changes with height. Any other object is drawn as round.
SECTION_OF: dict[str, tuple[str, bool]] = {
    "cylinder": ("circle", False),
    "square-pillar": ("square", False),
    "box": ("rectangle", False),
    "hexagonal-prism": ("hexagon", False),
    "triangular-prism": ("triangle", False),
    "sphere": ("circle", False),
    "cone": ("circle", True),
    "pyramid": ("square", True),
    "cone-frustum": ("circle", True),
    "pyramid-frustum": ("square", True),
}

_WIDTH, _HEIGHT = 360, 300
_PADDING = 14
# What is always shown: the palm and the room that open fingers take. Metres.
_LEAST_M = (-0.03, -0.075, 0.12, 0.075)
_ROUND_CORNERS = 72
# A growth that says nothing is not drawn at several heights.
_LEAST_GROWTH = 0.05
# The palm's plate and a scale bar. Metres.
_PALM_M, _PALM_HALF_M, _BAR_M = 0.014, 0.042, 0.02


def grip_drawing(contacts: GripContacts, name: str) -> Markup | None:
    """Draw a grip from above, with the fitted section of an object.

    Parameters
    ----------
    contacts : GripContacts
        In the palm's frame; x, out of the palm, is drawn to the right, y upward.
    name : str
        The object, as a key of `SECTION_OF`.

    Returns
    -------
    Markup or None
        SVG; None where there is nothing to draw.
    """
    if not contacts.parts:
        return None
    section, grows = SECTION_OF.get(name, ("circle", False))
    fit = fit_section(contacts, section, grows=grows)
    sections = [] if fit is None else _sections(contacts, fit)
    points = np.vstack([contacts.start_m[:, :2], contacts.end_m[:, :2], *(outline for outline, _ in sections)])
    low = np.minimum(points.min(axis=0) - 0.01, _LEAST_M[:2])
    high = np.maximum(points.max(axis=0) + 0.01, _LEAST_M[2:])
    scale = float(min((_WIDTH - 2 * _PADDING) / (high[0] - low[0]), (_HEIGHT - 2 * _PADDING) / (high[1] - low[1])))
    middle = (low + high) / 2

    def place(xy: Floats) -> Floats:
        out: Floats = np.array([_WIDTH / 2, _HEIGHT / 2]) + (xy - middle) * scale * np.array([1.0, -1.0])
        return out

    body = [_palm(place, scale)]
    body += [f'<path class="section{kind}" d="{_path(place(outline))}"/>' for outline, kind in sections]
    certain = contacts.on_object()
    # Lower parts first, so that the upper ones lie over them as seen from above; what touches lies on top.
    order = sorted(
        range(len(contacts.parts)), key=lambda k: (bool(contacts.touched[k]), float(contacts.start_m[k, 2]), k)
    )
    for k in order:
        kind = "on" if certain[k] else "other" if contacts.touched[k] else "off"
        body.append(
            _capsule(place(contacts.start_m[k, :2]), place(contacts.end_m[k, :2]), contacts.radius_m[k] * scale, kind)
        )
    body.append(_bar(scale))
    n = int(contacts.touched.sum())
    label = f"The grip from above: {n} of {len(contacts.parts)} parts touch"
    return Markup(
        f'<svg class="screen grip" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(label)}">'
        f"{''.join(body)}</svg>"
    )


def _sections(contacts: GripContacts, fit: SectionFit) -> list[tuple[Floats, str]]:
    """The fitted outline at the palm's height, and where it changes with height at the ends of what touches."""
    out = [(_outline(fit, fit.size_m), "")]
    heights = contacts.start_m[contacts.touched, 2]
    if abs(fit.growth) >= _LEAST_GROWTH and heights.size:
        for height in (float(heights.min()), float(heights.max())):
            out.append((_outline(fit, max(fit.size_m + fit.growth * height, 0.004)), " else"))
    return out


def _outline(fit: SectionFit, size_m: float) -> Floats:
    shape = GRIP_SECTIONS[fit.section]
    if len(shape.corners) == 1:
        angle = 2 * np.pi * np.arange(_ROUND_CORNERS) / _ROUND_CORNERS
        corners = shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        c, s = math.cos(fit.turn_rad), math.sin(fit.turn_rad)
        corners = shape.corners @ np.array([[c, s], [-s, c]])
    return np.array(fit.middle_m) + size_m * corners


def _palm(place: Callable[[Floats], Floats], scale: float) -> str:
    corner = place(np.array([-_PALM_M - 0.003, _PALM_HALF_M]))
    return (
        f'<rect class="palm" x="{corner[0]:.1f}" y="{corner[1]:.1f}" width="{_PALM_M * scale:.1f}" '
        f'height="{2 * _PALM_HALF_M * scale:.1f}" rx="4"/>'
    )


def _capsule(start: Floats, end: Floats, radius: float, kind: str) -> str:
    along = end - start
    length = float(np.hypot(*along))
    if length < 1e-9:
        return f'<circle class="part {kind}" cx="{start[0]:.1f}" cy="{start[1]:.1f}" r="{radius:.1f}"/>'
    side = radius * np.array([-along[1], along[0]]) / length
    a, b, c, d = start + side, end + side, end - side, start - side
    arc = f"A{radius:.1f} {radius:.1f} 0 0 0 "
    return (
        f'<path class="part {kind}" d="M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}{arc}{c[0]:.1f} {c[1]:.1f}'
        f'L{d[0]:.1f} {d[1]:.1f}{arc}{a[0]:.1f} {a[1]:.1f}z"/>'
    )


def _path(points: Floats) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points.tolist()) + "z"


def _bar(scale: float) -> str:
    wide, y = _BAR_M * scale, _HEIGHT - _PADDING
    return (
        f'<path class="bar" d="M{_PADDING} {y - 4}v4h{wide:.1f}v-4"/>'
        f'<text x="{_PADDING + wide + 7:.1f}" y="{y}">{1e3 * _BAR_M:.0f}\u202fmm</text>'
    )
