"""The skin: the body that feels, and seeing the object through it.

`press` pushes a rigid solid into an elastic `Skin`; `sense` says what the taxels under the surface read
of it. What a recording of a real sensor calls pressure is this stress: smoothed by the skin, highest where
the object's rim is, and not the object's form. `reconstruct` goes back: from a frame to the pressure on the
surface, and from there to the surface itself, which inside the contact is the object's.

Media (`media`) are one file each in one registry, `MEDIA`; lengths are metres, stresses pascal where the
skin's modulus is known and units of the contact modulus E / (1 - nu^2) where it is not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "MEDIA",
    "RECEPTORS",
    "FiredSections",
    "LabelledPress",
    "PressDraw",
    "PressedSolid",
    "Receptor",
    "Relief",
    "Skin",
    "Taxels",
    "collect_presses",
    "draw_press",
    "edge_map",
    "lateral_inhibition",
    "medium_of",
    "potential",
    "press",
    "pulse_rate",
    "pulses",
    "read_skin",
    "reconstruct",
    "sense",
    "taxel_stress",
    "unit_output",
    "varishold_sections",
]

if TYPE_CHECKING:
    from varishold.sensor.cover import Skin, read_skin
    from varishold.skin.draws import LabelledPress, PressDraw, collect_presses, draw_press
    from varishold.skin.inhibition import edge_map, lateral_inhibition
    from varishold.skin.media import MEDIA, medium_of
    from varishold.skin.pressing import PressedSolid, press
    from varishold.skin.receptor import (
        RECEPTORS,
        FiredSections,
        Receptor,
        potential,
        pulse_rate,
        pulses,
        unit_output,
        varishold_sections,
    )
    from varishold.skin.reconstruction import Relief, reconstruct
    from varishold.skin.taxels import Taxels, sense, taxel_stress
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
