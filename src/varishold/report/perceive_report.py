"""The page of `varishold perceive`: the answer, how the belief moved, and a card for each touch."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from varishold._counted import counted
from varishold.exploration import Exploration, Grip, MadeTouch, SurfaceExploration, grip_contacts
from varishold.hand import HandSetting
from varishold.hand.scene import Scene
from varishold.perceive import NONE_OF_THESE
from varishold.report.belief_chart import belief_chart, size_strip
from varishold.report.exploration_words import (
    answer_in_words,
    chosen_in_words,
    in_words,
    information,
    size_in_words,
    spoken,
    truth_in_words,
    verdict_in_words,
    was_right,
    with_article,
)
from varishold.report.grip_drawing import grip_drawing
from varishold.report.pad_hand import SURFACE_COLOURS, pad_hand, tip_pad
from varishold.report.page import render_page, write_page
from varishold.report.photo import Photo, photo_data_uri
from varishold.report.quantities import percent, prefixed
from varishold.report.scene_data import SceneData
from varishold.report.senses import belief_before, sense_bars
from varishold.report.surface_drawing import surface_pane
from varishold.report.wording import Bar, bars, sentence, sentences

__all__ = ["render_perceive_report", "write_perceive_report"]


@dataclass(frozen=True)
class TouchCard:
    """Everything that the page shows of one touch.

    Parameters
    ----------
    anchor, name, done, felt : str
    likeliest, probability : str
    photo : str or None
        Data URI.
    grip, tip, hand, strip : Markup or None
        Drawings.
    peak : str or None
        What the brightest taxel reads.
    verdict : str
        Whether it goes on.
    why : str
    reasons : tuple of str
    bars : tuple of Bar
    facts : tuple of (str, str)
    following : str or None
        The next touch, and what it is chosen for.
    """

    anchor: str
    name: str
    done: str
    felt: str
    likeliest: str
    probability: str
    photo: str | None
    grip: Markup | None
    tip: Markup | None
    hand: Markup | None
    strip: Markup | None
    peak: str | None
    verdict: str
    why: str
    reasons: tuple[str, ...]
    bars: tuple[Bar, ...]
    facts: tuple[tuple[str, str], ...]
    following: str | None


def write_perceive_report(
    path: str | os.PathLike[str],
    sequence: Exploration,
    *,
    setting: HandSetting | None = None,
    pictures: Sequence[Photo] = (),
    scenes: Sequence[Scene] = (),
    no_pictures: str | None = None,
    error: float | None = None,
    surface: SurfaceExploration | None = None,
) -> None:
    """Write a self-contained page about a sequence of touches.

    Parameters
    ----------
    path : str or path-like
        The HTML file to write.
    sequence : Exploration
    setting : HandSetting, optional
        The hand that touched; default: the usual one.
    pictures : sequence of ndarray of shape (height, width, 3), uint8
        One a touch; none leaves them out.
    scenes : sequence of tuple of SceneBody
        One a touch, which can be turned on the page; none leaves them out.
    no_pictures : str, optional
        Why there are none.
    error : float, optional
        The error that was accepted.
    surface : SurfaceExploration, optional
        What was felt of the whole surface afterwards.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_page(
        path,
        render_perceive_report(
            sequence,
            setting=setting,
            pictures=pictures,
            scenes=scenes,
            no_pictures=no_pictures,
            error=error,
            surface=surface,
        ),
    )


def render_perceive_report(
    sequence: Exploration,
    *,
    setting: HandSetting | None = None,
    pictures: Sequence[Photo] = (),
    scenes: Sequence[Scene] = (),
    no_pictures: str | None = None,
    error: float | None = None,
    surface: SurfaceExploration | None = None,
) -> str:
    """Return the page that `write_perceive_report` writes."""
    setting = setting or HandSetting()
    touches = sequence.touches
    photos = [photo_data_uri(picture) for picture in pictures] if len(pictures) == len(touches) else []
    cards = [
        _card(number, touch, sequence, setting, photos[number - 1] if photos else None)
        for number, touch in enumerate(touches, start=1)
    ]
    data = SceneData(scenes if len(scenes) == len(touches) else ())
    beliefs, names = [t.update.probability for t in touches], [in_words(t.felt.touch.name) for t in touches]
    return render_page(
        "perceive.html",
        title=_title(sequence),
        answer=spoken(answer_in_words(sequence), _names(sequence)),
        truth=truth_in_words(sequence),
        right={True: "right", False: "wrong", None: "open"}[was_right(sequence)],
        facts=_facts(sequence, error),
        notes=_notes(sequence, no_pictures),
        chart=None if not touches else belief_chart(beliefs, names, before=belief_before(sequence)),
        narrow_chart=None if not touches else belief_chart(beliefs, names, narrow=True, before=belief_before(sequence)),
        senses=sense_bars(sequence),
        cards=cards,
        turned=len(scenes) == len(touches),
        surface_colours=list(SURFACE_COLOURS.items()),
        felt=None if surface is None else surface_pane(surface, data),
        # After the surface was added to them.
        scenes=data.markup,
    )


def _names(sequence: Exploration) -> list[str]:
    return [sequence.name, *(sequence.touches[-1].update.probability if sequence.touches else ())]


def _title(sequence: Exploration) -> str:
    perception = sequence.perception
    if perception is None:
        return "Nothing was gripped"
    if perception.object == NONE_OF_THESE:
        return "None of the objects it knows"
    text = with_article(perception.object)
    if perception.size_m is not None:
        text += f" of {1e3 * perception.size_m:.0f}\u202fmm"
    return text[0].upper() + text[1:]


def _facts(sequence: Exploration, error: float | None) -> list[tuple[str, str]]:
    facts = [
        ("object", f"{in_words(sequence.name)}, {1e3 * sequence.size_m:g}\u202fmm"),
        ("seed", str(sequence.seed)),
        ("touches", str(len(sequence.touches))),
    ]
    if sequence.seconds:
        facts.append(("time of the hand", f"{sequence.seconds:.1f}\u202fs"))
    if sequence.drops:
        facts.append(("missed or dropped", f"{counted(sequence.drops, 'time')}"))
    if error is not None:
        facts.append(("accepted error", percent(error)))
    return facts


def _notes(sequence: Exploration, no_pictures: str | None) -> list[str]:
    notes = []
    if no_pictures is not None:
        notes.append(f"Pictures are left out. {sentence(no_pictures)}")
    if sequence.drops and sequence.touches:
        notes.append(
            "After a miss or a fall the object is stood up at a new place and gripped by all digits. What was known of "
            "its pose is then forgotten; what was learned of its name and size is kept."
        )
    if sequence.perception is not None:
        notes += sentences(spoken(remark, ()) for remark in sequence.perception.remarks)
    return notes


def _card(number: int, touch: MadeTouch, sequence: Exploration, setting: HandSetting, photo: str | None) -> TouchCard:
    update, felt = touch.update, touch.felt
    names = list(update.probability)
    sensed, pads = felt.step.sensed, felt.step.pads
    grip = tip = hand = None
    if not isinstance(felt.touch, Grip):
        name = next(iter(touch.surfaces), setting.design.tip)
        if pads is not None and name in pads.frames:
            tip = tip_pad(pads.frames[name], pads.pitch_m[name], touch.surfaces.get(name))
    else:
        grip = grip_drawing(grip_contacts(sensed, setting.design, setting.layout), names[0])
        if pads is not None and pads.frames:
            closed = dict(zip(setting.layout.names, sensed.switches.tolist(), strict=True))
            hand = pad_hand(pads, touch.surfaces, closed, setting.design, setting.layout)
    peak = 0.0 if pads is None else max((float(frame.max()) for frame in pads.frames.values()), default=0.0)
    following = None
    if touch.then is not None:
        wanted, nats = touch.then
        following = in_words(wanted)
        if nats is not None:
            following += f": {spoken(chosen_in_words(nats, touch.planned), ())}"
    return TouchCard(
        anchor=f"t{number}",
        name=f"{number} · {in_words(felt.touch.name)}",
        done=sentence(felt.touch.done),
        felt=sentence(felt.touch.felt_in_words(felt, touch.surfaces)),
        likeliest=in_words(names[0]),
        probability=percent(update.probability[names[0]]),
        photo=photo,
        grip=grip,
        tip=tip,
        hand=hand,
        strip=size_strip(update.size_m, update.size_interval_m, sequence.size_m),
        peak=prefixed(peak, "Pa") if peak > 0 else None,
        verdict=verdict_in_words(touch),
        why=spoken(update.why, names),
        reasons=sentences(spoken(reason, names) for reason in update.reasons),
        bars=bars((in_words(name), p) for name, p in update.probability.items()),
        facts=_card_facts(touch),
        following=following,
    )


def _card_facts(touch: MadeTouch) -> tuple[tuple[str, str], ...]:
    update = touch.update
    facts = [
        ("size", size_in_words(update.size_m, update.size_interval_m)),
        ("just as odd", f"{percent(update.p_value)} of touches of {with_article(next(iter(update.probability)))}"),
        ("entropy of the name", information(_entropy(update.probability))),
    ]
    if touch.chosen_for is not None:
        facts.append(("chosen for", information(touch.chosen_for)))
    if touch.seconds is not None:
        facts.append(("took the hand", f"{touch.seconds:.1f}\u202fs"))
    return tuple(facts)


def _entropy(probability: dict[str, float]) -> float:
    return -sum(p * math.log(p) for p in probability.values() if p > 0) + 0.0
