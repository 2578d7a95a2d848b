"""The automatic loop: the hand touches, the perceiver decides what to touch next and when it is enough."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from varishold.errors import InputError
from varishold.exploration.feel import evidence_of
from varishold.exploration.touches import PLANS, Felt, Station, TouchPlan, make_touch
from varishold.hand import Bench, HandSetting, PadSetting, Step, set_up, stand_up
from varishold.perceive import Evidence, Perceiver, Perception, Thought
from varishold.touch import PadSurface

__all__ = ["Episode", "SequenceTouch", "TouchSequence", "perceive"]

#: The first touch; after a fall or a miss, its place is taken by a grip of all digits.
_FIRST, _AFTER_A_FALL = "grasp", "squeeze"

#: Falls and misses after which the hand gives up.
_MOST_DROPS = 12


@dataclass(frozen=True)
class SequenceTouch:
    """One touch of a sequence.

    Parameters
    ----------
    felt : Felt
        What the hand did and felt.
    surfaces : dict of str to PadSurface or None
        The surface under each pad; None where nothing presses it.
    evidence : Evidence
    thought : Thought
        What was believed afterwards.
    chosen_for : float or None
        Nats of information about the name that the touch was chosen for; None for a touch that was not chosen.
    then : tuple of str and float or None, optional
        The touch that is wanted next, and the nats that it is chosen for; None where the sequence ends.
    """

    felt: Felt
    surfaces: dict[str, PadSurface | None]
    evidence: Evidence
    thought: Thought
    chosen_for: float | None
    then: tuple[str, float | None] | None = None


@dataclass(frozen=True)
class TouchSequence:
    """A sequence of touches at one object, and the answer.

    Parameters
    ----------
    name : str
        What the object truly is.
    size_m : float
        Its true size. Metres.
    seed : int
    touches : tuple of SequenceTouch
    drops : int
        How often the object fell or was missed, and was stood up again.
    perception : Perception or None
        None where the hand never got hold of the object.
    """

    name: str
    size_m: float
    seed: int
    touches: tuple[SequenceTouch, ...]
    drops: int
    perception: Perception | None


def perceive(
    name: str,
    size_m: float,
    *,
    seed: int,
    perceiver: Perceiver | None = None,
    setting: HandSetting | None = None,
    order: Sequence[str] | None = None,
    on_touch: Callable[[SequenceTouch], None] | None = None,
    watch: Callable[[Bench, Step], None] | None = None,
) -> TouchSequence:
    """Touch an object until it is known.

    Parameters
    ----------
    name : str
        A key of `varishold.hand.OBJECTS` or `varishold.hand.STRANGERS`.
    size_m : float
        Diameter or breadth. Metres.
    seed : int
        The same seed gives the same sequence, bit by bit.
    perceiver : Perceiver, optional
        Default: one that knows the ten objects. It begins anew.
    setting : HandSetting, optional
        Default: the usual hand with pads, which must search for the object.
    order : sequence of str, optional
        Names of `PLANS` in a fixed order, instead of choosing each next touch by what it is expected to tell.
    on_touch : callable, optional
        Called after each touch.
    watch : callable, optional
        Called with the bench and the hand's step when a touch is complete, as to take its picture.

    Raises
    ------
    InputError
        If the object is unknown or does not fit the hand, the seed is negative, or the order names no known touch.
    MissingExtraError
        If MuJoCo is not installed.
    """
    setting = setting or HandSetting(search=True, pads=PadSetting())
    perceiver = perceiver or Perceiver()
    perceiver.forget()
    strange = [touch for touch in order or () if touch not in PLANS]
    if strange:
        raise InputError(f"unknown touch {strange[0]!r}; known are {', '.join(PLANS)}")
    bench, rng = set_up(name, size_m, seed=seed, setting=setting)
    episode = Episode(bench, rng, setting, lambda plan: perceiver.failed(plan.name), watch)
    touches: list[SequenceTouch] = []
    wanted: tuple[str, float | None] | None = ((order or (_FIRST,))[0], None)
    while wanted is not None:
        felt = episode.touch(PLANS[wanted[0]])
        if felt is None:
            break
        evidence, surfaces = evidence_of(felt.plan, felt.step.sensed, felt.step.pads, setting, height_m=felt.height_m)
        thought = perceiver.feel(evidence)
        chosen_for = wanted[1] if felt.plan.name == wanted[0] else None
        wanted = None if perceiver.stopped else _next(perceiver, order)
        touches.append(SequenceTouch(felt, surfaces, evidence, thought, chosen_for, wanted))
        if on_touch is not None:
            on_touch(touches[-1])
    return TouchSequence(name, size_m, seed, tuple(touches), episode.drops, perceiver.answer() if touches else None)


def _next(perceiver: Perceiver, order: Sequence[str] | None) -> tuple[str, float | None] | None:
    made = perceiver.belief.touches
    if order is not None:
        left = [touch for touch in order if touch not in made]
        return (left[0], None) if left else None
    can = [touch for touch in PLANS if touch not in made and touch not in (_FIRST, _AFTER_A_FALL)]
    return perceiver.next_touch(can)


@dataclass
class Episode:
    """The hand at one object, with what it takes to go on after a fall.

    Parameters
    ----------
    bench : Bench
    rng : numpy.random.Generator
        Places the object again; both from `varishold.hand.set_up`.
    setting : HandSetting
    on_fall : callable, optional
        Called with the touch that failed, when the object was stood up again at a new place.
    watch : callable, optional
        Called with the bench and the hand's step when a touch is complete.
    """

    bench: Bench
    rng: np.random.Generator
    setting: HandSetting
    on_fall: Callable[[TouchPlan], None] | None = None
    watch: Callable[[Bench, Step], None] | None = None
    station: Station = field(default_factory=Station)
    drops: int = 0

    def touch(self, plan: TouchPlan) -> Felt | None:
        """Make a touch; after a fall or a miss stand the object up again and close all digits about it.

        Returns
        -------
        Felt or None
            None where the hand gives up.
        """
        for tried in self._tries(plan):
            felt = make_touch(self.bench, tried, self.station, self.setting, watch=self.watch)
            if felt is not None:
                return felt
            self.drops += 1
            stand_up(self.bench, self.setting, self.rng)
            self.station = Station()
            if self.on_fall is not None:
                self.on_fall(tried)
        return None

    def _tries(self, plan: TouchPlan) -> Iterator[TouchPlan]:
        yield plan
        while self.drops < _MOST_DROPS:
            yield PLANS[_AFTER_A_FALL]
