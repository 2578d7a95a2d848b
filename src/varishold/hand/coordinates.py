"""The coordinates of the fingers: where the joint angles put each phalanx, in the palm's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.hand.bench import Sensed
from varishold.hand.hand import Hand
from varishold.hand.layouts import Layout
from varishold.hand.pads import PadFrames
from varishold.hand.phalanges import Phalanges

__all__ = [
    "ContactPoints",
    "GripCircle",
    "Phalanges",
    "contact_points",
    "feels_held",
    "grip_circle",
    "gripped",
    "phalanges",
    "touching",
]

#: Digits that meet nearer than this have met each other: with the palm touched, and away from it. Metres.
_NO_ROOM_M, _NO_ROOM_FAR_M = 0.010, 0.032

#: A pad that is pressed with more than this touches. Newtons.
_TOUCH_N = 0.1

#: What is held does not shrink below this part of the breadth that it had a step earlier.
_LEAST_PART = 0.5


def phalanges(angles_rad: NDArray[np.float64], design: Hand) -> Phalanges:
    """Place every phalanx from the joint angles.

    Parameters
    ----------
    angles_rad : ndarray of shape (n,)
        In the order of `Hand.joints`.
    design : Hand

    Examples
    --------
    >>> from varishold.hand import HandDesign
    >>> straight = phalanges(np.zeros(15), HandDesign())
    >>> straight.middle_m[0].round(3)
    array([0.011, 0.044, 0.033])
    """
    return design.phalanges(angles_rad)


def touching(sensed: Sensed, design: Hand, layout: Layout) -> NDArray[np.bool_]:
    """Which phalanges have a closed switch; shape (n,), in the order of `Hand.parts`."""
    closed = {switch.part for switch, on in zip(layout.switches, sensed.switches, strict=True) if on}
    return np.array([part in closed for part in design.parts[:-1]])


def gripped(sensed: Sensed, design: Hand, layout: Layout) -> tuple[float, float] | None:
    """Return breadth and middle (metres, along the palm's y) of what fingers and thumb hold between them.

    Returns
    -------
    tuple of 2 floats, or None
        None unless a finger and the thumb both touch something.
    """
    touched, place = touching(sensed, design, layout), phalanges(sensed.angles_rad, design)
    fingers, thumb = touched & ~place.opposed, touched & place.opposed
    if not (fingers.any() and thumb.any()):
        return None
    y = place.middle_m[:, 1]
    upper, lower = float(y[fingers].max()), float(y[thumb].min())
    return upper - lower, (upper + lower) / 2


@dataclass(frozen=True)
class ContactPoints:
    """Where the digits touch, in the palm's frame.

    Parameters
    ----------
    parts : tuple of str
        Touched phalanges.
    point_m : ndarray of shape (n, 3)
        Metres.
    normal, along : ndarray of shape (n, 3)
        Unit vectors: from the phalanx into the object, and along the phalanx away from the palm.
    slack_m : ndarray of shape (n,)
        How far along the phalanx the touch may lie to either side of the point: half a phalanx for a switch, nothing
        for a pad. Metres.
    """

    parts: tuple[str, ...]
    point_m: NDArray[np.float64]
    normal: NDArray[np.float64]
    along: NDArray[np.float64]
    slack_m: NDArray[np.float64]


def contact_points(sensed: Sensed, design: Hand, layout: Layout, *, pads: PadFrames | None = None) -> ContactPoints:
    """Return where the digits touch, from joint angles and switches, or from pads where they are given."""
    place = phalanges(sensed.angles_rad, design)
    if pads is None:
        touched, slack = touching(sensed, design, layout), place.length_m / 2
        point = place.middle_m
    else:
        touched = np.array([pads.force_n[part] > _TOUCH_N for part in place.parts])
        slack = np.zeros(len(place.parts))
        middles = np.array([_middle(pads.frames[part]) * pads.pitch_m[part] for part in place.parts])
        point = place.middle_m + middles[:, None] * place.along
    return ContactPoints(
        tuple(joint for joint, on in zip(place.parts, touched, strict=True) if on),
        point[touched],
        place.inward[touched],
        place.along[touched],
        slack[touched],
    )


def _middle(frame: NDArray[np.float64]) -> float:
    """Columns from the middle of a frame to the middle of its pressure; 0 for an empty frame."""
    weight = frame.clip(0).sum(axis=0)
    total = float(weight.sum())
    return float(weight @ (np.arange(weight.size) + 0.5 - weight.size / 2)) / total if total > 0 else 0.0


@dataclass(frozen=True)
class GripCircle:
    """The circle that touches the palm's plane and lies best against the touched phalanges.

    Parameters
    ----------
    diameter_m, middle_y_m : float
        Its size, and its middle along the palm's y. Metres.
    off_m : ndarray of shape (n,)
        How far each phalanx is off the circle: positive beyond it. Metres.
    beside_m : ndarray of shape (n,)
        How far along each phalanx the circle's middle stands from the point of touch. Metres.
    """

    diameter_m: float
    middle_y_m: float
    off_m: NDArray[np.float64]
    beside_m: NDArray[np.float64]


def grip_circle(contacts: ContactPoints) -> GripCircle | None:
    """Fit a circle to a grip by least squares; None where fewer than two phalanges touch.

    A circle that touches the palm's plane x = 0, of diameter D and with its middle at c = (D / 2, y), lies against a
    phalanx with a point p and a normal n where (c - p) . n = D / 2: a linear equation in D and y that holds
    wherever along the phalanx it touches.

    Examples
    --------
    >>> turn = np.array([0.4, 1.2, -0.9])  # a cylinder of 80 mm, touched in three directions
    >>> normal = -np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    >>> along = np.column_stack([-np.sin(turn), np.cos(turn), 0 * turn])
    >>> point = np.array([0.04, 0.0, 0.0]) - 0.04 * normal
    >>> circle = grip_circle(ContactPoints(("a", "b", "c"), point, normal, along, 0 * turn))
    >>> round(circle.diameter_m, 6), bool(np.abs(circle.off_m).max() < 1e-9)
    (0.08, True)
    """
    if len(contacts.parts) < 2:
        return None
    point, normal = contacts.point_m[:, :2], contacts.normal[:, :2]
    rows = np.column_stack([normal[:, 0] - 1, normal[:, 1]])
    (half_m, y_m), *_ = np.linalg.lstsq(rows, (point * normal).sum(axis=1), rcond=None)
    to_middle = np.array([half_m, y_m]) - point
    return GripCircle(
        2 * float(half_m),
        float(y_m),
        (to_middle * normal).sum(axis=1) - float(half_m),
        (to_middle * contacts.along[:, :2]).sum(axis=1),
    )


def feels_held(
    sensed: Sensed, design: Hand, layout: Layout, *, before: Sensed | None = None, palm: bool = False
) -> bool:
    """Whether touch and angles alone say that something is between fingers and thumb.

    Digits that close on nothing touch each other; their angles then say that there is no room for an object
    between them, or far less than before, and the palm feels nothing.

    Parameters
    ----------
    sensed : Sensed
    design : Hand
    layout : Layout
    before : Sensed, optional
        What was felt a step earlier, when something was held.
    palm : bool
        Whether the palm felt something just before.
    """
    grip = gripped(sensed, design, layout)
    if grip is None:
        return False
    palm = palm or any(
        on and switch.part == "palm" for switch, on in zip(layout.switches, sensed.switches, strict=True)
    )
    if palm:
        return grip[0] > _NO_ROOM_M
    earlier = None if before is None else gripped(before, design, layout)
    return grip[0] > max(_NO_ROOM_FAR_M, 0.0 if earlier is None else _LEAST_PART * earlier[0])
