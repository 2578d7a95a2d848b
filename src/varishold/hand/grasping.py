"""One grasp from beginning to end: set the object up, search, five steps, and again after a miss or a fall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from varishold.errors import InputError, require
from varishold.hand.actions import Search, Step, approach, five_step, record_step, search, square_up
from varishold.hand.bench import Bench
from varishold.hand.design import HandDesign
from varishold.hand.hand import Hand
from varishold.hand.layouts import PAPER_22, Layout
from varishold.hand.mjcf import MjcfHand
from varishold.hand.objects import POSES, Pose, graspable, laid_to_grip
from varishold.hand.pads import PadSetting
from varishold.hand.randomization import Circumstances, Randomization
from varishold.hand.switches import SwitchSetting
from varishold.solids import MeshSolid, Solid

__all__ = [
    "Attempt",
    "Grasp",
    "HandSetting",
    "come_before",
    "grasp",
    "hand_setting",
    "set_up",
    "stand_up",
    "stand_up_at",
]

Outcome = Literal["held", "missed", "dropped"]

#: Where an object stands whose place is unknown: the middle of its base before the palm's zero. Metres.
_NOMINAL_M = 0.10

#: What reaches farther than this from its middle toward the palm lies so much farther away. Metres.
_NEAR_M = 0.06

#: A search starts with the palm so far back, where open fingers reach no object. Metres.
_BACK_M = -0.05

#: Gap between palm and object when the place is known. Metres.
_GAP_M = 0.004

#: The palm goes forward at most so far from where it knows the object to be near. Metres.
_LAST_WAY_M = 0.03


@dataclass(frozen=True)
class HandSetting:
    """Everything about the hand and its world that a grasp depends on, but for object and seed.

    Parameters
    ----------
    design : Hand
    layout : Layout
    switches : SwitchSetting
    randomization : Randomization
    pads : PadSetting or None
        The taxel pads, which take most of a grasp's time; None leaves them out.
    search : bool
        Whether place and turn of the object are unknown, so that the hand must search.
    still : bool
        Leave the physics as designed and vary the object's place alone.
    clamped : bool
        Whether the object is clamped where it stands, so that no touch moves it.
    pose : {"upright", "lying"}
        Whether the object stands, or lies on its side: its proportions and the side are then drawn by chance.
    most_attempts : int
        Grasps after which a miss or a fall is left as it is.
    """

    design: Hand = field(default_factory=HandDesign)
    layout: Layout = PAPER_22
    switches: SwitchSetting = field(default_factory=SwitchSetting)
    randomization: Randomization = field(default_factory=Randomization)
    pads: PadSetting | None = None
    search: bool = False
    still: bool = False
    clamped: bool = False
    pose: Pose = "upright"
    most_attempts: int = 3

    def __post_init__(self) -> None:
        if self.most_attempts < 1:
            raise InputError(f"most_attempts must be at least 1, got {self.most_attempts!r}")
        require(self.pose in POSES, f"pose must be one of {', '.join(POSES)}, got {self.pose!r}")


def hand_setting(hand: MjcfHand | None = None, *, pads: PadSetting | None = None, **more: Any) -> HandSetting:
    """Return a setting of a hand of a user's, with its switches and its pads; or of the usual hand.

    Parameters
    ----------
    hand : MjcfHand, optional
        Default: the built-in hand.
    pads : PadSetting, optional
        Default: the usual ones. A hand without pads has none.
    **more
        Other fields of `HandSetting`.
    """
    pads = pads or PadSetting()
    if hand is None:
        return HandSetting(pads=pads, **more)
    return HandSetting(design=hand, layout=hand.layout, pads=pads if hand.pads else None, **more)


@dataclass(frozen=True)
class Attempt:
    """One try at an object that was set up.

    Parameters
    ----------
    search : Search or None
        How the search went; None where the place was known.
    steps : tuple of Step
        The steps of the grasp; without any that a fall or a miss left out.
    outcome : {"held", "missed", "dropped"}
        What touch and angles say: nothing between the digits at first, or nothing any more later.
    """

    search: Search | None
    steps: tuple[Step, ...]
    outcome: Outcome


@dataclass(frozen=True)
class Grasp:
    """A grasp with its attempts.

    Parameters
    ----------
    name : str
        The object's name in `OBJECTS`.
    size_m : float
        Its size. Metres.
    seed : int
    circumstances : Circumstances
        The physics of all attempts, and the place of the first.
    attempts : tuple of Attempt
    end : Step
        What the hand felt at the end: the last step, or step 0 where there was none.
    """

    name: str
    size_m: float
    seed: int
    circumstances: Circumstances
    attempts: tuple[Attempt, ...]
    end: Step

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps of the last attempt."""
        return self.attempts[-1].steps

    @property
    def held(self) -> bool:
        """The truth at the end: whether the object hangs in the hand after step 5."""
        return self.end.number == 5 and self.end.held


def set_up(
    name: str | MeshSolid, size_m: float, *, seed: int, setting: HandSetting | None = None
) -> tuple[Bench, np.random.Generator]:
    """Stand an object before the open hand, with the circumstances that belong to the seed.

    Parameters
    ----------
    name : str or MeshSolid
        As of `graspable`, or a thing of a mesh, which has its size.
    size_m : float
        Diameter or breadth. Metres.
    seed : int
    setting : HandSetting, optional

    Returns
    -------
    tuple of Bench and numpy.random.Generator
        The generator goes on to place the object again after a miss.

    Raises
    ------
    InputError
        If the object is unknown or does not fit the hand, or the seed is negative.
    MissingExtraError
        If MuJoCo is not installed.
    """
    setting = setting or HandSetting()
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed must be a whole number from 0 on, got {seed!r}")
    if not isinstance(name, str | Solid):
        raise InputError(f"name must be an object's name or a Solid, got {type(name).__name__}")
    solid = graspable(name, size_m, setting.design.sizes_m) if isinstance(name, str) else name
    if setting.pose == "lying":
        solid = laid_to_grip(name, size_m, seed=seed)
    rng = np.random.default_rng(seed)
    chance = setting.randomization.draw(
        rng, n_switches=len(setting.layout.switches), search=setting.search, still=setting.still
    )
    bench = Bench(solid, chance, setting.design, setting.layout, setting.switches, seed, setting.clamped)
    _place(bench, setting, (chance.forward_m, chance.sideways_m, chance.yaw_rad))
    return bench, rng


def stand_up(bench: Bench, setting: HandSetting, rng: np.random.Generator) -> None:
    """Stand a fallen or missed object up again at a new place before the open hand, as by a person."""
    stand_up_at(bench, setting, setting.randomization.draw_place(rng, search=setting.search))


def stand_up_at(bench: Bench, setting: HandSetting, place: tuple[float, float, float]) -> None:
    """Stand the object up at a place: offsets forward and aside (metres) and turn (radians), as of `Circumstances`."""
    bench.reset()
    _place(bench, setting, place)


def grasp(
    name: str,
    size_m: float,
    *,
    seed: int,
    setting: HandSetting | None = None,
    pad_steps: tuple[int, ...] = (5,),
    watch: Callable[[Bench, Step], None] | None = None,
) -> Grasp:
    """Grasp an object in the paper's five steps.

    A miss or a fall is what touch and angles alone say it is; the object is then stood up at a new place, as
    by a person, and grasped again.

    Parameters
    ----------
    name : str
        A key of `OBJECTS`.
    size_m : float
        Diameter or breadth. Metres.
    seed : int
        The same seed gives the same grasp, bit by bit.
    setting : HandSetting, optional
    pad_steps : tuple of int
        Numbers of the steps at whose end the taxel pads are pressed, where the setting has pads.
    watch : callable, optional
        Called with the bench and each step when it ends.

    Raises
    ------
    InputError
        If the object is unknown or does not fit the hand, or the seed is negative.
    MissingExtraError
        If MuJoCo is not installed.
    """
    setting = setting or HandSetting()
    bench, rng = set_up(name, size_m, seed=seed, setting=setting)
    attempts: list[Attempt] = []
    while True:
        attempts.append(_attempt(bench, setting, pad_steps, watch))
        if attempts[-1].outcome == "held" or len(attempts) == setting.most_attempts:
            break
        stand_up(bench, setting, rng)
    steps = attempts[-1].steps
    end = steps[-1] if steps else record_step(bench, 0, "search")
    return Grasp(name, size_m, seed, bench.circumstances, tuple(attempts), end)


def come_before(bench: Bench, setting: HandSetting) -> Search | None:
    """Bring the palm against the object that was set up, searching for it where its place is unknown.

    Returns
    -------
    Search or None
        How the search went; None where the place was known. After a search in vain the hand stands where that ended.
    """
    found = search(bench) if setting.search else None
    if found is not None and not found.found:
        return found
    if approach(bench, most_m=_LAST_WAY_M) and found is None:
        square_up(bench)
    return found


def _attempt(
    bench: Bench,
    setting: HandSetting,
    pad_steps: tuple[int, ...],
    watch: Callable[[Bench, Step], None] | None,
) -> Attempt:
    found = come_before(bench, setting)
    if found is not None and not found.found:
        return Attempt(found, (), "missed")
    steps = five_step(bench, pads=setting.pads, pad_steps=pad_steps, watch=watch)
    if steps[-1].felt:
        outcome: Outcome = "held"
    else:
        outcome = "missed" if len(steps) == 1 else "dropped"
    return Attempt(found, steps, outcome)


def _place(bench: Bench, setting: HandSetting, place: tuple[float, float, float]) -> None:
    forward_m, sideways_m, yaw_rad = place
    if setting.search:
        bench.put_carriage({"reach": _BACK_M - setting.design.longer_m})
        # What lies may be long: its near end stays as far from the open fingers as other things do.
        longer_m = max(0.0, _near_side(bench.solid, yaw_rad) - _NEAR_M) if setting.pose == "lying" else 0.0
        bench.place_object(_NOMINAL_M + longer_m + forward_m, sideways_m, yaw_rad)
    else:
        near_m = _near_side(bench.solid, yaw_rad)
        bench.place_object(near_m + _GAP_M + forward_m, sideways_m, yaw_rad)


def _near_side(solid: Solid, yaw_rad: float) -> float:
    """How far an upright solid, turned by `yaw_rad`, reaches from its middle toward the palm; metres."""
    toward = np.array([-np.cos(yaw_rad), np.sin(yaw_rad)])
    return max(0.0, *(part.reach(toward) for part in solid.body()))
