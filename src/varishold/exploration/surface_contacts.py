"""Where a touch of the hand met the object: points, normals and bends of the surface, and what is free.

All of it from what a hand knows: its joint angles, its own place, and its pads. Phalanges are round bars, so that the
normal at a contact stands on the bar; how far it leans to the side is told by the slope that the pad feels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.exploration.touch import PadSurfaces
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import phalanges
from varishold.hand.hand import Hand
from varishold.hand.palm_place import palm_place
from varishold.hand.phalanges import Phalanges
from varishold.touch import PadSurface
from varishold.touch.pads.measures import MEASURES

__all__ = ["TouchedPoints", "touched_points"]

Floats = NDArray[np.float64]

#: A pad sees a slope smaller than it is, for its frame is one of a flat skin.
_SLOPE_GAIN = 1.5

#: Standard deviations of a point along its normal, of a point that was told from the bend beside it, and of a point of
#: the palm (metres); of a normal, and of one whose lean to the side is not told (1).
_POINT_M, _BESIDE_M, _PALM_M, _NORMAL, _LEAN_UNKNOWN = 0.0006, 0.001, 0.0012, 0.08, 0.35

#: What bends more is an edge, whose normal says little (1/m); contacts nearer to an end of a bar may lie on its round
#: end (metres), and are vague where an edge lies there, or where the end comes so steeply (radians): the standard
#: deviation of such a point is this (metres), and its normal's this (1).
_EDGE_1_M, _END_M, _MOST_TIP_RAD, _VAGUE_M, _VAGUE = 60.0, 0.005, 0.6, 0.004, 0.6

#: Points beside a contact: so far along the phalanx at most, and so that the normal turns by so much at most.
_BESIDE_REACH_M, _BESIDE_RAD = 0.006, 0.4

#: Half of a single bar's pad, beyond most of which a contact lies at the border (1); a thumb's pad reads so far off its
#: middle where it touches with one of its two bars alone. Metres.
_AT_BORDER, _ONE_BAR_M = 0.7, 0.006


@dataclass(frozen=True)
class TouchedPoints:
    """What one touch says of the surface, in the frame that the palm's zero has.

    Parameters
    ----------
    point_m, normal : ndarray of shape (n, 3)
        Metres; unit vectors out of the object.
    sigma_m, normal_sigma : ndarray of shape (n,)
        Standard deviations, metres and 1.
    free_m : ndarray of shape (k, 3)
        Middles of the hand's own parts: no object is there. Metres.
    """

    point_m: Floats
    normal: Floats
    sigma_m: Floats
    normal_sigma: Floats
    free_m: Floats


_Contact = tuple[Floats, Floats, float, float]


def touched_points(sensed: Sensed, surfaces: PadSurfaces, design: Hand) -> TouchedPoints:
    """Return where the hand met the object.

    Parameters
    ----------
    sensed : Sensed
        Joint angles and the palm's place.
    surfaces : dict of str to PadSurface or None
        The surface under each pad.
    design : Hand
    """
    place = phalanges(sensed.angles_rad, design)
    origin, axes = palm_place(sensed.carriage, design)
    found: list[_Contact] = []
    for part, surface in surfaces.items():
        if surface is None:
            continue
        if part == "palm":
            (y, z), (bend_y, bend_z) = surface.centre_m, surface.curvature_1_m
            middle_y, middle_z = design.palm_middle_m
            at, out, across, up = np.array([0.0, y + middle_y, z + middle_z]), -np.eye(3)[0], np.eye(3)[1], np.eye(3)[2]
            found += _bent((at, out, _PALM_M, 2 * _NORMAL), across, bend_y, 1.5 * _BESIDE_REACH_M)
            found += _bent((at, out, _PALM_M, 2 * _NORMAL), up, bend_z, 1.5 * _BESIDE_REACH_M)[1:]
        else:
            k = place.parts.index(part)
            for contact, straight in _on_bars(surface, place, k, float(place.half_breadth_m[k])):
                found += _bent(contact, place.along[k], surface.curvature_1_m[0], _BESIDE_REACH_M if straight else 0.0)
    middles = np.concatenate([place.start_m + part * place.length_m[:, None] * place.along for part in (0.0, 0.5, 1.0)])
    points, normals = (np.array([each[k] for each in found]).reshape(-1, 3) @ axes.T for k in (0, 1))
    return TouchedPoints(
        origin + points,
        normals,
        np.array([each[2] for each in found]),
        np.array([each[3] for each in found]),
        origin + middles @ axes.T,
    )


def _on_bars(surface: PadSurface, place: Phalanges, k: int, half_breadth_m: float) -> Iterator[tuple[_Contact, bool]]:
    """The contacts of a phalanx, one or one on each of the thumb's two bars; whether they lie on its straight part."""
    radius, half = float(place.radius_m[k]), float(place.length_m[k]) / 2
    along_m, beside_m = surface.centre_m
    measures = dict(zip(MEASURES, surface.measures.tolist(), strict=True))
    tip, lean = (float(np.arctan(_SLOPE_GAIN * np.sinh(measures[f"tilt_along_{way}"]) / 5)) for way in ("cols", "rows"))
    edge = abs(surface.curvature_1_m[0]) > _EDGE_1_M
    unsure = _LEAN_UNKNOWN if edge else _NORMAL
    at_end = abs(along_m) > half - _END_M
    sigma, vague = _POINT_M, at_end and (edge or tip > _MOST_TIP_RAD)
    if vague:
        sigma, unsure = _VAGUE_M, _VAGUE
    if not at_end or edge:
        tip = 0.0
    elif tip > _NORMAL:
        # The round end of the bar touches; the pad ends before it.
        along_m = float(np.copysign(half, along_m))
        unsure = max(unsure, _NORMAL + _LEAN_UNKNOWN * tip)
    tip = float(np.copysign(tip, along_m))
    if half_breadth_m and abs(beside_m) < _ONE_BAR_M:
        bars: tuple[tuple[float, float], ...] = ((-half_breadth_m, 0.0), (half_breadth_m, 0.0))
    else:
        side = float(np.sign(beside_m))
        bars = ((side * half_breadth_m, side * lean),)
        if abs(beside_m) - half_breadth_m > _AT_BORDER * radius and lean < 0.5:
            unsure = max(unsure, _LEAN_UNKNOWN)
    up = np.array([0.0, 0.0, 1.0])
    for bar, turn in bars:
        flat = np.cos(tip) * place.inward[k] + np.sin(tip) * place.along[k]
        toward = np.cos(turn) * flat + np.sin(turn) * up
        middle = place.start_m[k] + (half + along_m) * place.along[k] + bar * up
        yield (middle + radius * toward, -toward, sigma, unsure), not (edge or at_end)


def _bent(contact: _Contact, along: Floats, bend_1_m: float, reach_m: float) -> list[_Contact]:
    """A contact, and points to either side of it on the circle that has its bend."""
    at, out, sigma, unsure = contact
    if not reach_m:
        return [contact]
    aside = min(reach_m, _BESIDE_RAD / max(abs(bend_1_m), 1e-9))
    more = []
    for step in (-aside, aside):
        normal = out + bend_1_m * step * along
        point = at + step * along - bend_1_m * step * step / 2 * out
        more.append((point, normal / np.linalg.norm(normal), float(np.hypot(sigma, _BESIDE_M)), unsure + _NORMAL))
    return [contact, *more]
