"""The coordinates of the fingers: where the joint angles put each phalanx, in the palm's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.hand.bench import Sensed
from varishold.hand.design import HandDesign
from varishold.hand.layouts import Layout
from varishold.hand.model import DIGITS, JOINTS

__all__ = ["Phalanges", "feels_held", "gripped", "phalanges", "touching"]

#: Digits that meet nearer than this have met each other: with the palm touched, and away from it. Metres.
_NO_ROOM_M, _NO_ROOM_FAR_M = 0.010, 0.032

#: What is held does not shrink below this part of the breadth that it had a step earlier.
_LEAST_PART = 0.5


@dataclass(frozen=True)
class Phalanges:
    """Each phalanx in the palm's frame, in the order of `JOINTS`.

    Parameters
    ----------
    start_m : ndarray of shape (15, 3)
        Where its joint's axis passes through its middle line. Metres.
    along : ndarray of shape (15, 3)
        Unit vector from its joint to its far end.
    inward : ndarray of shape (15, 3)
        Unit vector to the side that it closes to.
    length_m, radius_m : ndarray of shape (15,)
        Metres.
    """

    start_m: NDArray[np.float64]
    along: NDArray[np.float64]
    inward: NDArray[np.float64]
    length_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]

    @property
    def middle_m(self) -> NDArray[np.float64]:
        """The middle of each phalanx's inner side, shape (15, 3), metres: where a switch says "here"."""
        half = (self.length_m / 2)[:, None]
        return self.start_m + half * self.along + self.radius_m[:, None] * self.inward


def phalanges(angles_rad: NDArray[np.float64], design: HandDesign) -> Phalanges:
    """Place every phalanx from the joint angles.

    Parameters
    ----------
    angles_rad : ndarray of shape (15,)
        In the order of `JOINTS`.
    design : HandDesign

    Examples
    --------
    >>> straight = phalanges(np.zeros(15), HandDesign())
    >>> straight.middle_m[0].round(3)
    array([0.011, 0.042, 0.033])
    """
    n = len(JOINTS)
    start, along, inward = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    length, radius = np.zeros(n), np.zeros(n)
    x, y = design.knuckle_m
    for d, digit in enumerate(DIGITS):
        rows = slice(3 * d, 3 * d + 3)
        side = -1.0 if digit == "thumb" else 1.0
        heading = -side * np.cumsum(angles_rad[rows])
        length[rows] = design.finger_lengths_m(digit)
        radius[rows] = design.radius_of(digit)
        along[rows, 0], along[rows, 1] = np.cos(heading), np.sin(heading)
        inward[rows, 0], inward[rows, 1] = side * np.sin(heading), -side * np.cos(heading)
        steps = length[rows, None] * along[rows]
        knuckle = np.array([x, side * y, design.height_of(digit)])
        start[rows] = knuckle + np.cumsum(steps, axis=0) - steps
    return Phalanges(start, along, inward, length, radius)


def touching(sensed: Sensed, layout: Layout) -> NDArray[np.bool_]:
    """Which phalanges have a closed switch; shape (15,), in the order of `JOINTS`."""
    closed = {switch.part for switch, on in zip(layout.switches, sensed.switches, strict=True) if on}
    return np.array([joint in closed for joint in JOINTS])


def gripped(sensed: Sensed, design: HandDesign, layout: Layout) -> tuple[float, float] | None:
    """Return breadth and middle (metres, along the palm's y) of what fingers and thumb hold between them.

    Returns
    -------
    tuple of 2 floats, or None
        None unless a finger and the thumb both touch something.
    """
    touched = touching(sensed, layout)
    if not (touched[:12].any() and touched[12:].any()):
        return None
    y = phalanges(sensed.angles_rad, design).middle_m[:, 1]
    upper, lower = float(y[:12][touched[:12]].max()), float(y[12:][touched[12:]].min())
    return upper - lower, (upper + lower) / 2


def feels_held(sensed: Sensed, design: HandDesign, layout: Layout, *, before: Sensed | None = None) -> bool:
    """Whether touch and angles alone say that something is between fingers and thumb.

    Digits that close on nothing touch each other; their angles then say that there is no room for an object
    between them, or far less than before, and the palm feels nothing.

    Parameters
    ----------
    sensed : Sensed
    design : HandDesign
    layout : Layout
    before : Sensed, optional
        What was felt a step earlier, when something was held.
    """
    grip = gripped(sensed, design, layout)
    if grip is None:
        return False
    palm = any(on and switch.part == "palm" for switch, on in zip(layout.switches, sensed.switches, strict=True))
    if palm:
        return grip[0] > _NO_ROOM_M
    earlier = None if before is None else gripped(before, design, layout)
    return grip[0] > max(_NO_ROOM_FAR_M, 0.0 if earlier is None else _LEAST_PART * earlier[0])
