"""The state of the sensor under a contact: what its taxels tell of themselves rather than of the form.

Saturated and equal readings, roughness inside the contact and outside it, ghosts along rows and columns, how much
stands close beside it and how much higher, the sides at which the pad ends it, how steep its border is at three
heights, how a face leans. What stands farther off than a quarter of the contact's breadth is another thing. Names rest
on the signature; these numbers say how far it can be trusted. None has a unit. The kernel's `state.c` measures them.
"""

from __future__ import annotations

__all__ = ["STATE_GROUPS", "STATE_NAMES"]

_STATE = (
    ("saturation", "top_share"),
    ("saturation", "near_top_share"),
    ("saturation", "exact_top_share"),
    ("saturation", "spike"),
    ("resolution", "equal_share"),
    ("resolution", "lowest_share"),
    ("roughness", "roughness"),
    ("roughness", "roughness_tail"),
    ("roughness", "mixed_roughness"),
    ("roughness", "free_roughness"),
    ("roughness", "free_level"),
    ("roughness", "ghost"),
    ("roughness", "others"),
    ("prominence", "prominence"),
    ("border", "cut_low"),
    ("border", "cut_half"),
    ("border", "cut_high"),
    ("sharpness", "edge_low"),
    ("sharpness", "edge_half"),
    ("sharpness", "edge_high"),
    ("tilt", "lean"),
    ("tilt", "unevenness"),
    ("tilt", "crown"),
)

#: Name of every number of the state, in order.
STATE_NAMES: tuple[str, ...] = tuple(name for _, name in _STATE)
#: What each number tells of, in the same order.
STATE_GROUPS: tuple[str, ...] = tuple(group for group, _ in _STATE)
