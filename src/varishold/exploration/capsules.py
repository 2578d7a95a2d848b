"""The parts of the simulated hand about an object, as the perceiver takes them from any hand."""

from __future__ import annotations

import numpy as np

from varishold.hand import Layout
from varishold.hand.bench import Sensed
from varishold.hand.coordinates import phalanges
from varishold.hand.hand import Hand
from varishold.perceive import GripContacts

__all__ = ["grip_contacts"]


def grip_contacts(sensed: Sensed, design: Hand, layout: Layout) -> GripContacts:
    """Return every phalanx, and every button of the palm, as a capsule in the palm's frame."""
    place = phalanges(sensed.angles_rad, design)
    pressed = list(zip(layout.switches, sensed.switches.tolist(), strict=True))
    closed = {switch.part for switch, on in pressed if on}
    buttons = [(switch, on) for switch, on in pressed if switch.part == "palm"]
    button_m = np.array([(-design.button_radius_m, button.y_m, button.z_m) for button, _ in buttons]).reshape(-1, 3)
    button_radius = np.full(len(buttons), design.button_radius_m)
    return GripContacts(
        (*place.parts, *(f"palm.{button.name}" for button, _ in buttons)),
        np.vstack([place.start_m, button_m]),
        np.vstack([place.start_m + place.length_m[:, None] * place.along, button_m]),
        np.concatenate([place.radius_m, button_radius]),
        np.array([part in closed for part in place.parts] + [on for _, on in buttons]),
        np.concatenate([place.radius_m + place.half_breadth_m, button_radius]),
    )
