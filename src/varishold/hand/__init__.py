"""The artificial hand of the paper's section 3, simulated: it searches, grasps in five steps, and feels.

`HandDesign` holds its proportions, `LAYOUTS` its switch tables, `Randomization` what differs from grasp to
grasp; `HandSetting` joins them. `grasp_object` makes one `Grasp`, `collect_grasps` a table of many. `actions`
are what the hand can do with a `Bench`; `press_pads` says what taxel pads would feel, `phalanges` where the
fingers are. Nothing here recognizes anything.

The extra ``sim`` (MuJoCo) is loaded when a bench is built, not before.
"""

from __future__ import annotations

from varishold.hand.actions import (
    FIVE_STEPS,
    Fingertip,
    Search,
    Step,
    approach,
    fingertip,
    five_step,
    let_go,
    move_round,
    object_middle,
    open_hand,
    regrasp,
    search,
    square_up,
    squeeze,
)
from varishold.hand.bench import Bench, Sensed
from varishold.hand.collect import Job, run_jobs
from varishold.hand.collect import collect as collect_grasps
from varishold.hand.coordinates import (
    ContactPoints,
    GripCircle,
    Phalanges,
    contact_points,
    feels_held,
    grip_circle,
    gripped,
    phalanges,
    touching,
)
from varishold.hand.design import PHALANGES, Digit, HandDesign
from varishold.hand.features import FEATURE_GROUPS, FeatureGroup, Features, features
from varishold.hand.grasping import Attempt, Grasp, HandSetting, come_before, set_up, stand_up, stand_up_at
from varishold.hand.grasping import grasp as grasp_object
from varishold.hand.layouts import LAYOUTS, PAPER_22, Layout, Switch
from varishold.hand.model import CARRIAGE
from varishold.hand.objects import OBJECTS, SIZE_RANGE_M, STRANGERS, TABLE_5_OBJECTS, graspable
from varishold.hand.pads import PadFrames, PadSetting, pad_shape, press_pads
from varishold.hand.picture import Camera, photograph
from varishold.hand.randomization import Circumstances, Randomization
from varishold.hand.rows import grasp_rows, grasp_table, grasp_to_dicts, pads_recording, require_layout
from varishold.hand.switches import SwitchSetting, switched

__all__ = [
    "CARRIAGE",
    "FEATURE_GROUPS",
    "FIVE_STEPS",
    "LAYOUTS",
    "OBJECTS",
    "PAPER_22",
    "PHALANGES",
    "SIZE_RANGE_M",
    "STRANGERS",
    "TABLE_5_OBJECTS",
    "Attempt",
    "Bench",
    "Camera",
    "Circumstances",
    "ContactPoints",
    "Digit",
    "FeatureGroup",
    "Features",
    "Fingertip",
    "Grasp",
    "GripCircle",
    "HandDesign",
    "HandSetting",
    "Job",
    "Layout",
    "PadFrames",
    "PadSetting",
    "Phalanges",
    "Randomization",
    "Search",
    "Sensed",
    "Step",
    "Switch",
    "SwitchSetting",
    "approach",
    "collect_grasps",
    "come_before",
    "contact_points",
    "features",
    "feels_held",
    "fingertip",
    "five_step",
    "grasp_object",
    "grasp_rows",
    "grasp_table",
    "grasp_to_dicts",
    "graspable",
    "grip_circle",
    "gripped",
    "let_go",
    "move_round",
    "object_middle",
    "open_hand",
    "pad_shape",
    "pads_recording",
    "phalanges",
    "photograph",
    "press_pads",
    "regrasp",
    "require_layout",
    "run_jobs",
    "search",
    "set_up",
    "square_up",
    "squeeze",
    "stand_up",
    "stand_up_at",
    "switched",
    "touching",
]
