"""Bits of contact: which bodies of a scene meet which.

The table and the object touch everything but the hand and the table leave each other alone; fingers and opposed digits,
which can meet behind a small object, touch each other but not their neighbours.
"""

from __future__ import annotations

__all__ = ["BUTTON_RGBA", "FINGER", "SKIN_RGBA", "THUMB", "WORLD"]

WORLD, FINGER, THUMB = 1, 2, 4

#: Colours of a phalanx and of a palm's button.
SKIN_RGBA, BUTTON_RGBA = (0.38, 0.50, 0.66, 1), (0.22, 0.28, 0.36, 1)
