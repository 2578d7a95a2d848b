"""What the exploring hand can do; one file a touch, `TOUCHES` is the registry."""

from __future__ import annotations

import numpy as np

from varishold.exploration.touch import Touch
from varishold.exploration.touches.fingertip import Fingertip
from varishold.exploration.touches.grasp import Grasp, Squeeze
from varishold.exploration.touches.grip import Grip
from varishold.exploration.touches.regrasp import Regrasp
from varishold.hand.hand import Hand

__all__ = ["TOUCHES", "Fingertip", "Grasp", "Grip", "Regrasp", "Squeeze", "touches_of"]

#: The touches by name. The first is the paper's; a squeeze takes its place after a fall.
TOUCHES: dict[str, Touch] = {
    touch.name: touch
    for touch in (
        Grasp(name="grasp"),
        Squeeze(name="squeeze"),
        Regrasp(name="regrasp-higher", raise_m=0.02),
        Regrasp(name="regrasp-lower", raise_m=-0.02),
        Regrasp(name="regrasp-turned-45", turn_rad=float(np.pi / 4)),
        Regrasp(name="regrasp-turned-90", turn_rad=float(np.pi / 2)),
        Fingertip(name="fingertip-edge", inward=0.15),
        Fingertip(name="fingertip-middle", inward=0.5),
        # Behind what is as deep as it is broad, and still on what is deeper.
        Fingertip(name="fingertip-beyond", inward=1.2),
    )
}


def touches_of(hand: Hand) -> dict[str, Touch]:
    """Return the touches that a hand can make."""
    return {name: touch for name, touch in TOUCHES.items() if touch.fits(hand)}
