"""What the hand can do: search, the five-step grasp, a grip elsewhere, the touch of a fingertip."""

from __future__ import annotations

from varishold.hand.actions.fingertip import Fingertip, come_down, fingertip
from varishold.hand.actions.five_step import FIVE_STEPS, five_step
from varishold.hand.actions.regrasp import CLEAR_M, let_go, move_round, object_middle, regrasp
from varishold.hand.actions.search import Search, approach, open_hand, search, square_up
from varishold.hand.actions.squeeze import squeeze
from varishold.hand.actions.step import Step, record_step

__all__ = [
    "CLEAR_M",
    "FIVE_STEPS",
    "Fingertip",
    "Search",
    "Step",
    "approach",
    "come_down",
    "fingertip",
    "five_step",
    "let_go",
    "move_round",
    "object_middle",
    "open_hand",
    "record_step",
    "regrasp",
    "search",
    "square_up",
    "squeeze",
]
