"""The artificial hand of the paper's section 3, simulated: it searches, grasps in five steps, and feels.

`HandDesign` holds its proportions, `LAYOUTS` its switch tables, `Randomization` what differs from grasp to
grasp; `HandSetting` joins them. `read_hand` reads another hand, an MJCF of a user's; `Hand` is what is asked of either.
`grasp_object` makes one `Grasp`, `collect_grasps` a table of many, `photograph` a picture. What the hand can do step by
step is in `varishold.hand.actions`, what it feels in `bench`, `coordinates` and `pads`. Nothing here recognizes
anything.

The extra ``sim`` (MuJoCo) is loaded when a bench is built, not before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "LAYOUTS",
    "OBJECTS",
    "PAPER_22",
    "TABLE_5_OBJECTS",
    "Bench",
    "Camera",
    "Digit",
    "Grasp",
    "Hand",
    "HandDesign",
    "HandSetting",
    "Job",
    "Layout",
    "PadSetting",
    "Randomization",
    "Step",
    "Switch",
    "SwitchSetting",
    "collect_grasps",
    "grasp_object",
    "grasp_rows",
    "grasp_table",
    "hand_setting",
    "photograph",
    "read_hand",
    "run_jobs",
    "set_up",
]

if TYPE_CHECKING:
    from varishold.hand.actions import Step
    from varishold.hand.bench import Bench
    from varishold.hand.collect import Job, run_jobs
    from varishold.hand.collect import collect as collect_grasps
    from varishold.hand.design import HandDesign
    from varishold.hand.digit import Digit
    from varishold.hand.grasping import Grasp, HandSetting, hand_setting, set_up
    from varishold.hand.grasping import grasp as grasp_object
    from varishold.hand.hand import Hand
    from varishold.hand.layouts import LAYOUTS, PAPER_22, Layout, Switch
    from varishold.hand.mjcf import read_hand
    from varishold.hand.objects import OBJECTS, TABLE_5_OBJECTS
    from varishold.hand.pads import PadSetting
    from varishold.hand.picture import Camera, photograph
    from varishold.hand.randomization import Randomization
    from varishold.hand.rows import grasp_rows, grasp_table
    from varishold.hand.switches import SwitchSetting
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
