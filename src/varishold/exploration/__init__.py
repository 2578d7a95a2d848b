"""The automatic loop: the hand touches, the perceiver decides.

`perceive` runs it; `PLANS` are the touches it chooses from.
"""

from __future__ import annotations

from varishold.exploration.feel import evidence_of, feel_pads, grip_contacts
from varishold.exploration.loop import Episode, SequenceTouch, TouchSequence, perceive
from varishold.exploration.touches import PLANS, Felt, Station, TouchPlan, make_touch
from varishold.exploration.worlds import touch_all, touch_beyond

__all__ = [
    "PLANS",
    "Episode",
    "Felt",
    "SequenceTouch",
    "Station",
    "TouchPlan",
    "TouchSequence",
    "evidence_of",
    "feel_pads",
    "grip_contacts",
    "make_touch",
    "perceive",
    "touch_all",
    "touch_beyond",
]
