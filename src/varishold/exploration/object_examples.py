"""Examples of a thing for a library: the hand feels it many times, in places and under physics drawn by chance."""

from __future__ import annotations

import hashlib
import os
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from varishold.errors import InputError, require
from varishold.exploration.kept import Example, keeper, kept_examples
from varishold.exploration.touch import Felt, PoseEstimate
from varishold.exploration.touches import TOUCHES, touches_of
from varishold.files import spread
from varishold.files.crew import processors
from varishold.hand import HandSetting, set_up
from varishold.hand.grasping import hand_setting, stand_up_at
from varishold.hand.mjcf import MjcfHand
from varishold.perceive import Evidence
from varishold.solids import MeshSolid

__all__ = [
    "USUAL_EXAMPLES",
    "example_setting",
    "feel_examples",
    "feel_once",
    "kept_beside",
    "seeds_of",
    "touch_in_turn",
]

#: Examples of an object that are felt unless another number is asked for.
USUAL_EXAMPLES = 50

# What is kept is read again only by who keeps it in the same way.
_FORMAT = 3


@dataclass(frozen=True)
class _Feel:
    """What a process does with a seed."""

    thing: MeshSolid
    setting: HandSetting

    def __call__(self, seed: int) -> Example:
        return feel_once(self.thing, self.thing.size_m, seed=seed, setting=self.setting)


def feel_once(thing: str | MeshSolid, size_m: float, *, seed: int, setting: HandSetting) -> Example:
    """Return the evidence of every touch of a thing, as `touch_in_turn` makes them; none where it was never gripped."""
    felt = touch_in_turn(thing, size_m, seed=seed, setting=setting)
    made = {
        name: Evidence(name, what.touch.evidence(what, setting)[0].values, seconds=what.seconds)
        for name, what in felt.items()
    }
    can = touches_of(setting.design)
    # After a grip that held every touch was tried.
    return [made.get(name) or Evidence(name, {}, failed=True) for name in can] if made else []


def touch_in_turn(
    thing: str | MeshSolid, size_m: float | None = None, *, seed: int, setting: HandSetting
) -> dict[str, Felt]:
    """Grasp a thing and make every other touch in an order drawn by chance, as an exploration would; then squeeze it.

    What was missed or has fallen is stood up again where it was, and squeezed before the next touch.

    Parameters
    ----------
    thing : str or MeshSolid
        As of `varishold.hand.set_up`.
    size_m : float, optional
        Metres; a thing of a mesh has its own.
    seed : int
        The same seed gives the same example, bit by bit.
    setting : HandSetting

    Returns
    -------
    dict of str to Felt
        By name of `TOUCHES`; without the touches that missed or dropped the thing.
    """
    if size_m is None:
        require(isinstance(thing, MeshSolid), "the size of what is no mesh is needed, metres")
        size_m = cast("MeshSolid", thing).size_m
    bench, _ = set_up(thing, size_m, seed=seed, setting=setting)
    chance = bench.circumstances
    felt: dict[str, Felt | None] = {}

    def grip(name: str) -> PoseEstimate | None:
        """Grip it where it was set up; None where it was missed."""
        stand_up_at(bench, setting, (chance.forward_m, chance.sideways_m, chance.yaw_rad))
        pose = PoseEstimate()
        made = TOUCHES[name].make_timed(bench, pose, setting)
        felt.setdefault(name, made)
        return None if made is None else pose

    pose = grip("grasp")
    others = [touch for touch in touches_of(setting.design).values() if not touch.begins]
    for k in np.random.default_rng(seed + 77).permutation(len(others)):
        pose = pose or grip("squeeze")
        if pose is None:
            break
        felt[others[k].name] = others[k].make_timed(bench, pose, setting)
        pose = pose if felt[others[k].name] is not None else None
    if "squeeze" not in felt:
        grip("squeeze")
    return {name: made for name, made in felt.items() if made is not None}


def example_setting(hand: MjcfHand | None = None) -> HandSetting:
    """Return the hand that examples are made with: it must search, and has pads where it can."""
    return hand_setting(hand, search=True)


def feel_examples(
    thing: MeshSolid,
    *,
    examples: int = USUAL_EXAMPLES,
    seed: int = 0,
    setting: HandSetting | None = None,
    processes: int | None = None,
    keep: str | os.PathLike[str] | None = None,
    progress: Callable[[], None] | None = None,
) -> list[Example]:
    """Feel a thing many times, each time with every touch, where place, turn and physics are drawn by chance.

    The same thing, name, number and seed give the same examples, whatever the number of processes and however often
    it was stopped.

    Parameters
    ----------
    thing : MeshSolid
    examples : int
        How many times it is set up.
    seed : int
        Of all that is drawn.
    setting : HandSetting, optional
        Default: the hand that the shipped library was made with.
    processes : int, optional
        Default: one a processor. 1 works in this process.
    keep : path-like, optional
        A file in which what was felt is kept, so that a call that was stopped goes on; see `kept_beside`.
    progress : callable, optional
        Called after each example, those that were kept included.

    Returns
    -------
    list of list of Evidence
        For `Library.with_object`: one list an example in which the hand got hold of the thing.

    Raises
    ------
    InputError
        If a number is out of its range, or the hand never got hold of the thing.
    MissingExtraError
        If MuJoCo is not installed.
    """
    require(examples >= 1, f"examples must be at least 1, got {examples!r}")
    require(seed >= 0, f"seed must be a whole number from 0 on, got {seed!r}")
    count = processors() if processes is None else processes
    require(count >= 1, f"processes must be at least 1, got {processes!r}")
    seeds = seeds_of(thing.called, seed, examples)
    felt = {} if keep is None else kept_examples(Path(keep))
    felt = {each: felt[each] for each in seeds if each in felt}
    missing = [each for each in seeds if each not in felt]
    for _ in felt:
        if progress is not None:
            progress()
    work = _Feel(thing, setting or example_setting())
    with keeper(keep, felt) as say:
        for each, made in zip(missing, spread(work, missing, processes=min(count, len(missing))), strict=True):
            felt[each] = made
            say(each, made)
            if progress is not None:
                progress()
    held = [felt[each] for each in seeds if felt[each]]
    if not held:
        raise InputError(
            f"the hand never got hold of {thing.called!r} in {examples} tries; give another size, or lay it otherwise"
        )
    return held


def kept_beside(
    path: str | os.PathLike[str], thing: MeshSolid, *, seed: int, setting: HandSetting | None = None
) -> Path:
    """Return where what was felt of a thing is kept beside a library: in a file named after all that it depends on."""
    depends = (_FORMAT, thing.called, thing.parts, seed, setting or example_setting())
    digest = hashlib.sha256(repr(depends).encode()).hexdigest()[:24]
    return Path(f"{os.fspath(path)}.felt", f"{digest}.jsonl")


def seeds_of(called: str, seed: int, examples: int) -> list[int]:
    """A seed an example: none of two things, or of two examples, is the same but by chance."""
    name = zlib.crc32(called.encode("utf-8", "surrogatepass"))
    drawn = (np.random.SeedSequence([seed, name, k]).generate_state(1) for k in range(examples))
    return [int(each[0]) for each in drawn]
