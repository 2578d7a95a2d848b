"""A hand of a user: an MJCF with its joints, parts, switches and pads named in a TOML file.

`read_hand` reads it; `MjcfHand` is what comes of it, and stands wherever a `HandDesign` does.
"""

from __future__ import annotations

from varishold.hand.mjcf.hand import MjcfHand
from varishold.hand.mjcf.hand_file import SHIPPED_HANDS, hand_files, read_hand

__all__ = ["SHIPPED_HANDS", "MjcfHand", "hand_files", "read_hand"]
