"""What is asked of a hand: all that the bench, the actions and the touches know of it.

`HandDesign` is the built-in hand, `MjcfHand` one that a user describes in a file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.hand.layouts import Layout
from varishold.hand.phalanges import Phalanges

__all__ = ["FIVE_STEPS", "Hand", "HandDigit", "Wiring"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

#: The paper's steps in short.
FIVE_STEPS = (
    "thumb and index finger grasp",
    "the wrist lifts",
    "the little finger grasps too",
    "the index finger is removed",
    "thumb and all fingers grasp",
)


@dataclass(frozen=True)
class Wiring:
    """Where a hand's joints, motors, parts and switches are in a compiled model.

    Parameters
    ----------
    angles, motors : mapping of str to ndarray of int
        By digit: addresses of its joints' angles, and numbers of its actuators.
    joints : ndarray of int
        Addresses of `Hand.joints`.
    part_of_geom : ndarray of int
        For each geom of the model its place in `Hand.parts`; -1 for what is no part.
    shown : mapping of str to ndarray of int
        By switch: the geoms that are painted when it closes.
    forces_n : callable
        Takes the model's data and returns the force on each switch, newtons.
    """

    angles: Mapping[str, Indices]
    motors: Mapping[str, Indices]
    joints: Indices
    part_of_geom: Indices
    shown: Mapping[str, Indices]
    forces_n: Callable[[Any], Floats]


class HandDigit(Protocol):
    """A digit: its name, its phalanges from the palm outward, and whether it closes toward the others."""

    @property
    def name(self) -> str: ...
    @property
    def parts(self) -> tuple[str, ...]: ...
    @property
    def opposed(self) -> bool: ...
    @property
    def side(self) -> float:
        """-1 for an opposed digit, 1 for the others: on which side of the palm (y) it stands."""
        ...

    @property
    def height_m(self) -> float:
        """Height (z) of its middle line in the palm's frame. Metres."""
        ...


class Hand(Protocol):
    """A hand. Its palm's frame: x out of the palm, y toward the fingers' side, z up along the palm."""

    @property
    def identity(self) -> str:
        """Which hand it is: a library is of use to the hand that felt it."""
        ...

    @property
    def digits(self) -> Mapping[str, HandDigit]:
        """All digits by name, fingers before opposed ones."""
        ...

    @property
    def fingers(self) -> tuple[HandDigit, ...]: ...
    @property
    def opposers(self) -> tuple[HandDigit, ...]: ...
    @property
    def pointer(self) -> str:
        """The finger that feels and grasps first."""
        ...

    @property
    def supporter(self) -> str | None:
        """The finger that joins when the object is lifted; None where there is but one finger."""
        ...

    @property
    def tip(self) -> str | None:
        """The phalanx that can come down on an object from above; None where none can."""
        ...

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints whose angles are the hand's coordinates."""
        ...

    @property
    def parts(self) -> tuple[str, ...]:
        """All phalanges, and "palm" at the end."""
        ...

    @property
    def pads(self) -> tuple[str, ...]:
        """The parts that can carry a pad."""
        ...

    @property
    def steps(self) -> Mapping[int, str]:
        """The steps of the paper's grasp that its digits can make: what is done, by number."""
        ...

    @property
    def pinch(self) -> Mapping[str, float]:
        """The digits that grasp first, each with a gain on its usual torque."""
        ...

    @property
    def grip(self) -> Mapping[str, float]:
        """All digits, each with the gain with which it holds against the others."""
        ...

    @property
    def search_gain(self) -> float: ...
    @property
    def lift_rad(self) -> float: ...
    @property
    def wrist_m(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def torsion_m(self) -> float: ...
    @property
    def palm_above_middle_m(self) -> float: ...
    @property
    def button_radius_m(self) -> float: ...
    @property
    def finger_scale(self) -> float: ...
    @property
    def sizes_m(self) -> tuple[float, float]:
        """The sizes of objects that it can close on and open around. Metres."""
        ...

    @property
    def longer_m(self) -> float:
        """How much farther than the usual hand its open digits reach before the palm; at least 0. Metres."""
        ...

    @property
    def tip_place_m(self) -> tuple[float, float]:
        """Where the tip's middle is (x, z) while the pointer is straight. Metres."""
        ...

    @property
    def palm_middle_m(self) -> tuple[float, float]:
        """Where the middle of the palm's pad is (y, z). Metres."""
        ...

    def opened(self) -> Floats:
        """Angles of all `joints` of the open hand. Radians, or metres of a joint that slides."""
        ...

    def closing(self, digit: str) -> Floats:
        """What a digit's actuators are told to close it with the usual torque."""
        ...

    def opening(self, digit: str) -> Floats:
        """What a digit's actuators are told to open it."""
        ...

    def holding(self, digit: str) -> tuple[Floats | float, Floats]:
        """Stiffness with which a digit's joints hold an angle, and their largest torque."""
        ...

    def driven(self, digit: str) -> bool:
        """Whether a digit's actuators are its own, told where to go, and no motors that are told a torque."""
        ...

    def to_come_down(self) -> Mapping[str, tuple[float, ...] | None]:
        """By digit, the angles to hold while the tip comes down; None for one that opens."""
        ...

    def phalanges(self, angles_rad: Floats) -> Phalanges:
        """Place every phalanx from the angles of `joints`."""
        ...

    def add_body(self, mj: Any, spec: Any, palm: Any, layout: Layout, contact: Mapping[str, Any]) -> None:
        """Add all that the hand consists of below the carriage's body "palm", whose frame is the palm's."""
        ...

    def add_motors(self, mj: Any, spec: Any) -> None:
        """Add the actuators."""
        ...

    def wire(self, model: Any, layout: Layout) -> Wiring:
        """Find it in a compiled model."""
        ...

    def pad_frame(self, data: Any, part: str) -> tuple[Floats, ...]:
        """Middle of a part's pad and its unit vectors along columns, along rows and out of it, in the world."""
        ...

    def pad_size_m(self, part: str) -> tuple[float, float]:
        """Height (along rows) and length (along columns) of a part's pad. Metres."""
        ...

    def pad_pitch_m(self, part: str) -> float | None:
        """Taxel spacing of a part's pad; None where the pads' setting says it. Metres."""
        ...
