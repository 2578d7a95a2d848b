"""The loop: the hand touches, the perceiver decides what to touch next and when it is enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from varishold.errors import require
from varishold.exploration.episode import Episode
from varishold.exploration.senses import what_senses_say
from varishold.exploration.touch import Felt, PadSurfaces
from varishold.exploration.touches import TOUCHES, touches_of
from varishold.hand import Bench, HandSetting, PadSetting, Step, set_up
from varishold.hand.objects import right_names
from varishold.perceive import BeliefUpdate, Evidence, NextTouch, Perceiver, Perception
from varishold.solids import MeshSolid

__all__ = ["Exploration", "MadeTouch", "perceive"]

_FIRST = "grasp"


@dataclass(frozen=True)
class MadeTouch:
    """One touch of an exploration.

    Parameters
    ----------
    felt : Felt
        What the hand did and felt.
    surfaces : dict of str to PadSurface or None
        The surface under each pad; None where nothing presses it.
    evidence : Evidence
    update : BeliefUpdate
        What was believed afterwards.
    chosen_for : float or None
        Nats of information about the name that the touch was chosen for; None for a touch that was not chosen.
    then : tuple of str and float or None, optional
        The touch that is wanted next, and the nats that it is chosen for; None where the exploration ends.
    seconds : float or None, optional
        What it took the hand, from the end of the touch before; falls and misses between them included.
    planned : NextTouch or None, optional
        The touch that is wanted next and what it is chosen for; None where it was not chosen.
    """

    felt: Felt
    surfaces: PadSurfaces
    evidence: Evidence
    update: BeliefUpdate
    chosen_for: float | None
    then: tuple[str, float | None] | None = None
    seconds: float | None = None
    planned: NextTouch | None = None


@dataclass(frozen=True)
class Exploration:
    """A sequence of touches at one object, and the answer.

    Parameters
    ----------
    name : str
        What the object truly is.
    size_m : float
        Its true size. Metres.
    seed : int
    touches : tuple of MadeTouch
    drops : int
        How often the object fell or was missed, and was stood up again.
    perception : Perception or None
        None where the hand never got hold of the object.
    senses : tuple of (str, dict of str to float)
        Where something was said of the name before the first touch: who, and what is believed by that alone;
        ``"touch"``, and what all touches say without it; ``"together"``. Of each object, likeliest in the end first.
    """

    name: str
    size_m: float
    seed: int
    touches: tuple[MadeTouch, ...]
    drops: int
    perception: Perception | None
    senses: tuple[tuple[str, dict[str, float]], ...] = ()
    also_right: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """What all touches took the hand."""
        return sum(touch.seconds or 0.0 for touch in self.touches)


def perceive(
    name: str | MeshSolid,
    size_m: float,
    *,
    seed: int,
    perceiver: Perceiver | None = None,
    setting: HandSetting | None = None,
    order: Sequence[str] | None = None,
    on_touch: Callable[[MadeTouch], None] | None = None,
    watch: Callable[[Bench, Step], None] | None = None,
) -> Exploration:
    """Touch an object until it is known.

    Parameters
    ----------
    name : str or MeshSolid
        A key of `varishold.hand.OBJECTS`, another that `varishold.hand.graspable` knows, or a thing of a mesh.
    size_m : float
        Diameter or breadth. Metres.
    seed : int
        The same seed gives the same exploration, bit by bit.
    perceiver : Perceiver, optional
        Default: one that knows the ten objects. It begins anew, and is told how the object is set up.
    setting : HandSetting, optional
        Default: the usual hand with pads, which must search for the object.
    order : sequence of str, optional
        Names of `TOUCHES` in a fixed order, instead of choosing each next touch by what it is expected to tell.
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
    perceiver.forget(pose=setting.pose)
    can = touches_of(setting.design)
    strange = [touch for touch in order or () if touch not in can]
    require(not strange, f"unknown touch {[*strange, ''][0]!r}; known are {', '.join(can)}")
    bench, rng = set_up(name, size_m, seed=seed, setting=setting)
    episode = Episode(bench, rng, setting, lambda touch: perceiver.failed(touch.name), watch)
    touches: list[MadeTouch] = []
    wanted: NextTouch | str | None = (order or (_FIRST,))[0]
    while wanted is not None:
        planned = wanted if isinstance(wanted, NextTouch) else None
        name_wanted = wanted.touch if isinstance(wanted, NextTouch) else wanted
        begun_s = episode.seconds
        felt = episode.touch(TOUCHES[name_wanted])
        if felt is None:
            break
        evidence, surfaces = felt.touch.evidence(felt, setting)
        update = perceiver.feel(evidence)
        chosen_for = planned.nats if planned is not None and felt.touch.name == name_wanted else None
        wanted = None if perceiver.stopped else _next(perceiver, order, can)
        touches.append(_made(felt, surfaces, evidence, update, chosen_for, wanted, episode.seconds - begun_s))
        if on_touch is not None:
            on_touch(touches[-1])
    return Exploration(
        name if isinstance(name, str) else name.called,
        size_m,
        seed,
        tuple(touches),
        episode.drops,
        perceiver.answer() if touches else None,
        what_senses_say(perceiver) if touches else (),
        right_names(name, size_m, seed=seed, pose=setting.pose)[1:],
    )


def _made(
    felt: Felt,
    surfaces: PadSurfaces,
    evidence: Evidence,
    update: BeliefUpdate,
    chosen_for: float | None,
    wanted: NextTouch | str | None,
    seconds: float,
) -> MadeTouch:
    planned = wanted if isinstance(wanted, NextTouch) else None
    then: tuple[str, float | None] | None = (wanted, None) if isinstance(wanted, str) else None
    if planned is not None:
        then = planned.touch, planned.nats
    return MadeTouch(felt, surfaces, evidence, update, chosen_for, then, seconds, planned)


def _next(perceiver: Perceiver, order: Sequence[str] | None, among: Iterable[str] = TOUCHES) -> NextTouch | str | None:
    """Return the touch that is chosen next, or the first of the order that is left; None where none is left."""
    made = perceiver.belief.touches
    if order is not None:
        return next((touch for touch in order if touch not in made), None)
    can = [name for name in among if name not in made and not TOUCHES[name].begins]
    return perceiver.plan(can)
