"""Where the palm is, from what its carriage reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.hand.hand import Hand

__all__ = ["palm_place"]


def palm_place(carriage: NDArray[np.float64], design: Hand) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the palm's origin (metres) and axes (columns, shape (3, 3)) from its carriage's values, as of `Sensed`.

    Examples
    --------
    >>> from varishold.hand import HandDesign
    >>> origin, axes = palm_place(np.array([0.1, 0.0, 0.02, np.pi / 2, 0.0, 0.0]), HandDesign())
    >>> origin.round(3), axes[:, 0].round(3)
    (array([0.1 , 0.  , 0.02]), array([0., 1., 0.]))
    """
    turn, roll, wrist = carriage[3:]
    about_z, about_x, about_y = _turned(turn, 0, 1), _turned(roll, 1, 2), _turned(wrist, 0, 2)
    axis = np.array([-design.wrist_m, 0.0, 0.0])
    arm = about_z @ about_x
    return carriage[:3] + arm @ (axis - about_y @ axis), arm @ about_y


def _turned(angle_rad: float, first: int, second: int) -> NDArray[np.float64]:
    """The turn from one axis toward another."""
    out = np.eye(3)
    out[[first, second], [first, second]] = np.cos(angle_rad)
    out[second, first], out[first, second] = np.sin(angle_rad), -np.sin(angle_rad)
    return out
