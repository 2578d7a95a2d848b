"""Where the pad ends a contact, and what is completed of it beyond."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact

__all__ = [
    "SIDES",
    "Side",
    "completed_circle",
    "corner_alone",
    "cut_sides",
    "ends_crookedly",
    "falls_off_all_round",
    "goes_across",
    "half_hidden",
]

Side = Literal["left", "right", "top", "bottom"]
SIDES: tuple[Side, ...] = ("left", "right", "top", "bottom")

# A contact is cut where it still stands so high at the field's border, as a share of the way from floor to peak.
_HIGH = 0.3
# A contact has its outline from the pad where more than this share of it is a border off the straight lines of the pad.
_CROOKED = 0.1
# What goes less far in from the border than this share of its length along it may be half of a contact, or less.
_HALF = 0.5
# A plane bends where it reads less than this share of its middle third along each border, in the outer part of so much
# of the field.
_FALLS_OFF, _MIDDLE, _OUTER = 0.8, 1 / 3, 1 / 6
# Outline points this near the border (taxels) belong to the cut, not to the outline.
_NEAR = 0.8
_FEWEST_POINTS = 6
# A circle that is known from less than this share of its outline is not completed.
_LEAST_ARC = 0.25


def cut_sides(contact: Contact) -> tuple[Side, ...]:
    """Return the sides of the field at which the contact still stands high, and therefore goes on beyond.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    tuple of str
        Out of left, right, top and bottom.
    """
    if not contact.at_border:
        return ()
    borders = contact.borders
    ends, high = _ends(np.where(contact.mask, contact.values, -np.inf)), _high(contact)
    return tuple(side for side in SIDES if getattr(borders, side) and float(ends[side].max()) > high)


def _ends(values: NDArray[Any]) -> dict[Side, NDArray[Any]]:
    """Return the line of values along each side."""
    return {"left": values[:, 0], "right": values[:, -1], "top": values[0], "bottom": values[-1]}


def _high(contact: Contact) -> float:
    """Return above which value a contact still stands high."""
    return contact.floor + _HIGH * (contact.peak - contact.floor)


def goes_across(contact: Contact) -> bool:
    """Tell whether a contact leaves the field at two sides and more, and covers none of its corners, or opposite ones.

    So a strip does. A face that ends in one straight border covers what lies behind it, a corner too.
    """
    if len(cut_sides(contact)) < 2:
        return False
    own = contact.frame.label[1:-1, 1:-1] == contact.index
    high = own & (contact.frame.padded[1:-1, 1:-1] > _high(contact))
    first, second = (high[0, 0], high[-1, -1]), (high[0, -1], high[-1, 0])
    return not (any(first) and any(second)) and all(first) == any(first) and all(second) == any(second)


def half_hidden(contact: Contact) -> bool:
    """Tell whether one border of the field may hide half of a contact or more: much less is seen of it than it is long.

    So a square looks like a bar along the border, and of a round thing the middle is not seen.
    """
    sides = cut_sides(contact)
    if len(sides) != 1:
        return False
    rows, cols = contact.mask.shape
    height, width = rows * contact.spacing[0], cols * contact.spacing[1]
    inward, along = (width, height) if sides[0] in ("left", "right") else (height, width)
    return bool(inward < _HALF * along)


def corner_alone(contact: Contact) -> bool:
    """Tell whether two borders that meet cut a contact over half of its breadth or more: neither length has both ends.

    So the corner of a square looks like that of a bar, whichever way it goes on.
    """
    sides = cut_sides(contact)
    if len(sides) != 2 or sides in (("left", "right"), ("top", "bottom")):
        return False
    at = _ends(contact.mask & (contact.values > _high(contact)))
    return all(int(np.count_nonzero(at[side])) > _HALF * len(at[side]) for side in sides)


def falls_off_all_round(contact: Contact) -> bool:
    """Tell whether a contact all over the field falls off from its middle to every border, as no flat face does."""
    if not all(contact.borders):
        return False
    values, mask = contact.values, contact.mask
    rows, cols = mask.shape
    high, wide = int(rows * _MIDDLE), int(cols * _MIDDLE)
    row, col = max(int(rows * _OUTER), 1), max(int(cols * _OUTER), 1)
    within = np.s_[high : rows - high, wide : cols - wide]
    if not mask[within].any():
        return False
    least = _FALLS_OFF * np.median(values[within][mask[within]])
    along = (np.s_[:row], np.s_[-row:], np.s_[:, :col], np.s_[:, -col:])
    return all(bool(np.median(values[part][mask[part]]) < least) for part in along)


def ends_crookedly(contact: Contact) -> bool:
    """Tell whether much of a contact's outline is a border of the field that is not straight, where it is cut.

    Where a straight border cuts a form is known; a round one looks like a form of its own.
    """
    if not contact.frame.has_gaps:
        return False
    around = tuple(slice(part.start, part.stop + 2) for part in contact.window)
    there, mask = np.pad(contact.frame.field, 1)[around], np.pad(contact.mask, 1)
    high = mask & (np.pad(contact.values, 1) > _high(contact))
    outline = crooked = 0
    for axis, way in ((0, -1), (0, 1), (1, -1), (1, 1)):
        outline += int(np.count_nonzero(mask & ~np.roll(mask, way, axis)))
        # Of each side what lies on its longest line is straight.
        lines = np.count_nonzero(high & ~np.roll(there, way, axis), axis=1 - axis)
        crooked += int(lines.sum() - lines.max())
    return crooked > _CROOKED * outline


def completed_circle(contact: Contact, level: int, sides: tuple[Side, ...]) -> tuple[float, float, float] | None:
    """Return the circle (x, y, diameter) whose visible part is the outline of a cut contact's section.

    Parameters
    ----------
    contact : Contact
    level : int
        Which section, as in `Contact.outlines`.
    sides : tuple of str
        Where it is cut.

    Returns
    -------
    (float, float, float) or None
        In the unit of the profile's lengths; None where too little of the outline is seen.
    """
    outlines = contact.outlines(level)
    if not outlines:
        return None
    points = max(outlines, key=len)
    rows, cols = contact.shape
    row_pitch, col_pitch = contact.spacing
    half_x, half_y = cols * col_pitch / 2, rows * row_pitch / 2
    keep = np.ones(len(points), np.bool_)
    away = {
        "left": points[:, 0] + half_x,
        "right": half_x - points[:, 0],
        "top": points[:, 1] + half_y,
        "bottom": half_y - points[:, 1],
    }
    for side in sides:
        keep &= away[side] > _NEAR * (col_pitch if side in ("left", "right") else row_pitch)
    seen = points[keep]
    if len(seen) < _FEWEST_POINTS:
        return None
    x, y, radius = _circle(seen)
    angle = np.sort(np.arctan2(seen[:, 1] - y, seen[:, 0] - x))
    gap = float(np.max(np.diff(np.append(angle, angle[0] + 2 * math.pi))))
    if 1 - gap / (2 * math.pi) < _LEAST_ARC or radius > 2 * max(half_x, half_y):
        return None
    return x, y, 2 * radius


def _circle(points: NDArray[np.float64]) -> tuple[float, float, float]:
    """Fit a circle (x, y, radius) by least squares of its equation (Kasa 1976), then by Gauss-Newton of distances."""
    middle = points.mean(axis=0)
    u, v = (points - middle).T
    a = np.stack([u, v, np.ones_like(u)], axis=1)
    solution = np.linalg.lstsq(a, u * u + v * v, rcond=None)[0]
    cx, cy = solution[0] / 2, solution[1] / 2
    radius = math.sqrt(max(float(solution[2] + cx * cx + cy * cy), 1e-300))
    for _ in range(8):
        distance = np.maximum(np.hypot(u - cx, v - cy), 1e-300)
        jacobian = np.stack([(cx - u) / distance, (cy - v) / distance, -np.ones_like(u)], axis=1)
        step = np.linalg.lstsq(jacobian, radius - distance, rcond=None)[0]
        cx, cy, radius = cx + step[0], cy + step[1], radius + step[2]
    return float(cx + middle[0]), float(cy + middle[1]), abs(float(radius))
