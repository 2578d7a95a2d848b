"""What the hand can do: search, the five-step grasp, a grip elsewhere, the touch of a fingertip."""

from __future__ import annotations

from varishold.hand.actions.five_step import FIVE_STEPS, five_step
from varishold.hand.actions.search import Search, approach, open_hand, search
from varishold.hand.actions.step import Step, feels_held, record_step

__all__ = [
    "FIVE_STEPS",
    "Search",
    "Step",
    "approach",
    "feels_held",
    "five_step",
    "open_hand",
    "record_step",
    "search",
]
