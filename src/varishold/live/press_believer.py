"""An object that is pressed again and again until it is known: each press is a touch of a perceiver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from varishold.errors import InputError
from varishold.live.pad_watcher import PadWatcher
from varishold.live.press_keeper import KeptPress
from varishold.perceive import NONE_OF_THESE, BeliefUpdate, Perceiver, Perception, evidence_of_recording
from varishold.recording import Pad, Recording

__all__ = ["BelievedObject", "PressBeliever"]

# The touch that a press is where a library knows several.
_USUAL_TOUCH = "grasp"
_DIGITS = 6


@dataclass(frozen=True, eq=False)
class BelievedObject:
    """What is believed of an object after one press more.

    Parameters
    ----------
    update : BeliefUpdate
        What this press changed, and whether that is enough.
    answer : Perception
        The answer so far; its trace has one update a press of this object.
    """

    update: BeliefUpdate
    answer: Perception

    @property
    def touches(self) -> int:
        """How many presses of this object were felt."""
        return len(self.answer.trace)

    @property
    def probability(self) -> float:
        """Of the object."""
        return self.answer.probability

    @property
    def unknown(self) -> bool:
        """Whether it is none of the library's objects."""
        return self.answer.object == NONE_OF_THESE

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        interval = self.answer.size_interval_m
        return {
            "object": self.answer.object,
            "probability": round(self.answer.probability, _DIGITS),
            "alternatives": {name: round(p, _DIGITS) for name, p in self.answer.alternatives.items()},
            "size_m": self.answer.size_m,
            "size_interval_m": None if interval is None else list(interval),
            "p_value": round(self.update.p_value, _DIGITS),
            "touches": self.touches,
            "verdict": self.update.verdict,
            "why": self.update.why,
            "reasons": list(self.update.reasons),
            "remarks": list(self.answer.remarks),
        }


class PressBeliever:
    """Says of every press which object it is by all presses of it so far.

    The object is taken to lie otherwise in each press. The press after the one that was enough is of another object.

    Parameters
    ----------
    perceiver : Perceiver
    pads : mapping of str to PadWatcher
        Pads that are watched, as they come.

    Raises
    ------
    InputError
        If the library knows several touches, and "grasp" is none of them.
    """

    def __init__(self, perceiver: Perceiver, pads: Mapping[str, PadWatcher]) -> None:
        self.perceiver, self._pads = perceiver, pads
        touches = tuple(perceiver.library.touches)
        if len(touches) > 1 and _USUAL_TOUCH not in touches:
            raise InputError(f"a press is one touch, and the library knows {', '.join(touches)}, not {_USUAL_TOUCH}")
        self._touch = _USUAL_TOUCH if _USUAL_TOUCH in touches else touches[0]
        self._another = True

    def next_object(self) -> None:
        """Say that another object is pressed from now on."""
        self._another = True

    def __call__(self, kept: KeptPress) -> BelievedObject:
        """Feel a press that has ended.

        Raises
        ------
        InputError
            If nothing that the library knows was felt in it; what is believed stays as it was.
        """
        evidence = evidence_of_recording(self._recording(kept), touch=self._touch)
        if not evidence.values:
            raise InputError("; ".join(evidence.remarks) or "no pad felt anything")
        if self._another or self.perceiver.stopped:
            self.perceiver.forget()
            self._another = False
        else:
            self.perceiver.moved()
        update = self.perceiver.feel(evidence)
        return BelievedObject(update, self.perceiver.answer())

    def _recording(self, kept: KeptPress) -> Recording:
        """Return the press as a recording of the pads that it was felt with."""
        watched = {name: self._pads[name] for name in kept.press.pads}
        pads = {
            name: Pad(kept.press.pads[name], pitch_m=pad.pitch_m, field=pad.field, valid=pad.sound)
            for name, pad in watched.items()
        }
        units = np.unique([pad.unit for pad in watched.values()]).tolist()
        return Recording(pads, time_s=kept.press.time_s, unit=units[0] if len(units) == 1 else "raw")
