"""Haptic exploration: the simulated hand touches, the perceiver decides.

`perceive` runs the loop; `TOUCHES` are the touches it chooses from.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "TOUCHES",
    "Episode",
    "Exploration",
    "Felt",
    "Grip",
    "MadeTouch",
    "PadSurfaces",
    "PoseEstimate",
    "SurfaceExploration",
    "SurfaceTouch",
    "Touch",
    "TouchedPoints",
    "check_touches",
    "explore_surface",
    "feel_examples",
    "grip_contacts",
    "kept_beside",
    "mesh_to_grip",
    "perceive",
    "touch_all",
]

if TYPE_CHECKING:
    from varishold.exploration.capsules import grip_contacts
    from varishold.exploration.episode import Episode
    from varishold.exploration.examples import touch_all
    from varishold.exploration.loop import Exploration, MadeTouch, perceive
    from varishold.exploration.mesh_object import mesh_to_grip
    from varishold.exploration.object_examples import feel_examples, kept_beside
    from varishold.exploration.shape import SurfaceExploration, SurfaceTouch, check_touches, explore_surface
    from varishold.exploration.surface_contacts import TouchedPoints
    from varishold.exploration.touch import Felt, PadSurfaces, PoseEstimate, Touch
    from varishold.exploration.touches import TOUCHES, Grip
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
