"""One contact's card: every drawing, number and sentence that the page shows of it."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.report.axonometry import stacked_slices, view_of
from varishold.report.chord_plot import chord_plot
from varishold.report.measures import measures
from varishold.report.outline_plot import outline_plot
from varishold.report.quantities import area, length, number, percent, reading
from varishold.report.section_stack import SectionStack, stack_sections
from varishold.report.taxel_image import Marks, taxel_image
from varishold.report.wording import Bar, cut_at, likeliest_bars, sentences
from varishold.touch import Answer
from varishold.touch.chords import USABLE_TAXELS

__all__ = ["ContactCard", "draw_contact_card"]

# Most cells of the surface along one side: more are not seen at a card's size.
_MOST_CELLS = 44


@dataclass(frozen=True)
class Growth:
    """One measure against its chord.

    Parameters
    ----------
    title : str
        What grows.
    plot : Markup
        The drawing.
    bulge, defect : str or None
        How far it rises above its chord and falls below it; None with too few sections for a chord.
    """

    title: str
    plot: Markup
    bulge: str | None
    defect: str | None


@dataclass(frozen=True)
class ContactCard:
    """What the page shows of one contact.

    Parameters
    ----------
    anchor : str
        Its name in the page's address.
    name, probability, place : str
        The answer and where it was.
    outline : str
        The outline and its probability.
    held : tuple of str
        The fewest names that hold 90 %.
    done : tuple of str
        What was done to this contact's frame, and not to all.
    legend : str
        What the marks in the frame mean.
    frame, outlines, solid : Markup
        The three pictures.
    growths : tuple of Growth
        Sqrt(area) and perimeter.
    bars, outline_bars : tuple of Bar
        Probabilities of names and of outlines, the largest first.
    reasons : tuple of str
    measures : tuple of (str, str)
    levels : str
        JSON for the page's script: of each section its height, threshold, area, perimeter, parts and holes.
    colours : str
        The colour scale from the top down, as CSS colour stops.
    theta_top, theta_floor : str
        The ends of the scale.
    scene : str
        JSON for the page's script: the view and the taxels of the surface.
    """

    anchor: str
    name: str
    probability: str
    place: str
    outline: str
    held: tuple[str, ...]
    done: tuple[str, ...]
    legend: str
    frame: Markup
    outlines: Markup
    solid: Markup
    growths: tuple[Growth, ...]
    bars: tuple[Bar, ...]
    outline_bars: tuple[Bar, ...]
    reasons: tuple[str, ...]
    measures: tuple[tuple[str, str], ...]
    levels: str
    colours: str
    theta_top: str
    theta_floor: str
    scene: str

    @property
    def has_interval(self) -> bool:
        """Whether a size is given, and with it its interval."""
        return any("(" in text for name, text in self.measures if name != "area")

    @property
    def count(self) -> int:
        """Number of sections shown."""
        return len(json.loads(self.levels))


def draw_contact_card(
    answer: Answer,
    *,
    anchor: str,
    place: str,
    valid: NDArray[np.bool_] | None = None,
    done: Sequence[str] = (),
    stack: SectionStack | None = None,
) -> ContactCard:
    """Draw and write all that the page shows of one contact.

    Parameters
    ----------
    answer : Answer
        What touch says of it.
    anchor, place : str
        Its name in the page's address, and its frame, time and pad in words.
    valid : ndarray of shape (rows, cols), bool, optional
        False where a taxel is broken.
    done : sequence of str
        What was done to its frame, and not to all.
    stack : SectionStack, optional
        Its sections, where they are already prepared.
    """
    surface, contact = answer.surface, answer.surface.contact
    stack = stack_sections(contact) if stack is None else stack
    metres = answer.pitch_m is not None
    unit_m = None if answer.pitch_m is None else min(answer.pitch_m)
    theta = partial(reading, unit=answer.unit)
    rows, cols = stack.shape
    marks = _marks(answer, valid)
    what = f"{surface.name}, {percent(surface.probability)}"
    return ContactCard(
        anchor=anchor,
        name=surface.name,
        probability=percent(surface.probability),
        place=place,
        outline=f"{surface.outline}, {percent(surface.outline_probability)}",
        held=surface.answer_set,
        done=sentences(done),
        legend=marks.legend,
        frame=taxel_image(
            stack,
            marks=marks,
            unit_m=unit_m,
            label=f"Frame of {rows} by {cols} taxels, {place}; the contact called {what} is framed",
        ),
        outlines=outline_plot(
            stack, unit_m=unit_m, label=f"{len(stack)} nested outlines of the contact, coloured by threshold"
        ),
        solid=stacked_slices(stack, label=f"The contact's {len(stack)} sections stacked to a solid"),
        growths=_growths(answer, stack, theta),
        bars=likeliest_bars(surface.names.items()),
        outline_bars=likeliest_bars(surface.outlines.items()),
        reasons=sentences(surface.reasons),
        measures=tuple(measures(answer)),
        levels=_levels(answer, stack, metres),
        colours=", ".join(stack.colours) if len(stack) > 1 else "#888, #888",
        theta_top=theta(stack.peak),
        theta_floor=theta(stack.floor),
        scene=_scene(stack),
    )


def _marks(answer: Answer, valid: NDArray[np.bool_] | None) -> Marks:
    """Return what the sensor lost of a frame: what is marked broken, and what was found so."""
    frame = answer.surface.contact.frame
    broken = frame.dead if valid is None else frame.dead | ~valid
    if frame.losses.repaired is not None:
        broken = broken | frame.losses.repaired
    saturated = np.zeros_like(broken) if frame.losses.saturated is None else frame.losses.saturated
    return Marks(broken, saturated, cut_at(answer.surface))


def _growths(answer: Answer, stack: SectionStack, theta: Callable[[float], str]) -> tuple[Growth, ...]:
    profile, inequality = answer.surface.contact.profile, answer.surface.inequality
    metres = answer.pitch_m is not None
    usable = profile.area[stack.level] >= USABLE_TAXELS * answer.surface.contact.taxel_area
    factor, unit = (1e3, "mm") if metres else (1.0, "taxels")
    drawn = []
    for title, growth, bulge, defect in (
        ("√area", np.sqrt(profile.area), inequality.bulge_sqrt_area, inequality.defect_sqrt_area),
        ("Perimeter", profile.perimeter, inequality.bulge_perimeter, inequality.defect_perimeter),
    ):
        known = math.isfinite(bulge) and math.isfinite(defect)
        verdict = f"bulge {bulge:.2f}, defect {defect:.2f}" if known else "too few usable sections for a chord"
        plot = chord_plot(
            stack,
            factor * growth[stack.level],
            usable,
            label=f"{title} of the sections while the threshold falls: {verdict}",
            tick=number,
            theta=theta,
        )
        told = (f"{bulge:.2f}", f"{defect:.2f}") if known else (None, None)
        drawn.append(Growth(f"{title}, {unit}", plot, *told))
    return tuple(drawn)


def _levels(answer: Answer, stack: SectionStack, metres: bool) -> str:
    profile = answer.surface.contact.profile
    rows = [
        [
            round(float(stack.height[k]), 4),
            reading(float(profile.threshold[i]), answer.unit),
            area(float(profile.area[i]), metres=metres),
            length(float(profile.perimeter[i]), metres=metres),
            int(profile.parts[i]),
            int(profile.holes[i]),
        ]
        for k, i in enumerate(stack.level.tolist())
    ]
    return json.dumps(rows, ensure_ascii=False, separators=(",", ":"))


def _scene(stack: SectionStack) -> str:
    rows, cols = stack.taxels
    every = -(-max(rows.stop - rows.start, cols.stop - cols.start) // _MOST_CELLS)
    values = stack.values[rows, cols][::every, ::every]
    share = np.clip(
        (np.where(np.isfinite(values), values, stack.floor) - stack.floor) / (stack.peak - stack.floor), 0, 1
    )
    view = view_of(stack)
    scene = {
        "window": [round(v, 4) for v in stack.window],
        "azimuth": view.azimuth,
        "elevation": view.elevation,
        "scale": round(view.scale, 4),
        "top": round(view.top, 4),
        "rows": values.shape[0],
        "cols": values.shape[1],
        "cell": [round(every * step, 4) for step in stack.step],
        "taxel": [round(step, 4) for step in stack.step],
        "values": base64.b64encode(np.round(255 * share).astype(np.uint8).tobytes()).decode("ascii"),
    }
    return json.dumps(scene, separators=(",", ":"))
