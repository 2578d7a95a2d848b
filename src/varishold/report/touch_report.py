"""The page of `varishold touch`: a table of every contact, and a card with its drawings and reasons."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from varishold._counted import counted
from varishold.recording import Recording
from varishold.report.contact_card import draw_contact_card
from varishold.report.page import render_page, write_page
from varishold.report.quantities import length, number, percent
from varishold.report.section_stack import stack_sections
from varishold.report.taxel_image import thumbnail
from varishold.report.wording import sentences
from varishold.touch import Answer

__all__ = ["MOST_CARDS", "MOST_ROWS", "render_touch_report", "write_touch_report"]

#: So many contacts get a card, and so many a line in the table; of more, an evenly spread choice is shown.
MOST_CARDS = 48
MOST_ROWS = 1000
# Odd values that a recording remarks upon; more are only counted.
_MOST_REMARKS = 12


@dataclass(frozen=True)
class Row:
    """A contact's line in the table.

    Parameters
    ----------
    anchor : str or None
        Its card, where it has one.
    picture, name, probability, outline, frame, time, pad, contact, size : str
    share : float
        P(name).
    """

    anchor: str | None
    picture: str
    name: str
    probability: str
    outline: str
    share: float
    frame: int
    time: str
    pad: str
    contact: int
    size: str


def write_touch_report(
    path: str | os.PathLike[str],
    answers: Iterable[Answer],
    *,
    recording: Recording,
    title: str | None = None,
    skin: str | None = None,
) -> None:
    """Write a self-contained page about a recording's contacts.

    Parameters
    ----------
    path : str or path-like
        The HTML file to write.
    answers : iterable of Answer
        What touch said, in the order to be shown.
    recording : Recording
        Where the contacts come from.
    title : str, optional
        Heading; default: the name of the recording's file.
    skin : str, optional
        The skin in words, where it is known.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_page(path, render_touch_report(tuple(answers), recording=recording, title=title, skin=skin))


def render_touch_report(
    answers: Sequence[Answer], *, recording: Recording, title: str | None = None, skin: str | None = None
) -> str:
    """Return the page that `write_touch_report` writes."""
    with_card = set(_spread(len(answers), MOST_CARDS))
    in_table = set(_spread(len(answers), MOST_ROWS)) | with_card
    done = _done_to_all(answers)
    rows, cards = [], []
    for i, answer in enumerate(answers):
        if i not in in_table:
            continue
        stack = stack_sections(answer.surface.contact)
        anchor = f"c{i + 1}" if i in with_card else None
        rows.append(_row(answer, anchor, thumbnail(stack)))
        if anchor is not None:
            valid = recording.pads[answer.pad].valid if answer.pad in recording.pads else None
            cards.append(
                draw_contact_card(
                    answer,
                    anchor=anchor,
                    place=_place(answer, recording),
                    valid=valid,
                    done=[note for note in answer.frame_notes if note not in done],
                    stack=stack,
                )
            )
    return render_page(
        "touch.html",
        title=title or PurePath(recording.source).name or "Touch",
        facts=_facts(recording, answers),
        headline=_headline(answers),
        notes=_notes(answers, recording, skin, len(cards), len(rows)),
        done=sentences(done),
        rows=rows,
        cards=cards,
        n_answers=len(answers),
        several_pads=len(recording.pads) > 1,
        timed=recording.time_s is not None,
    )


def _spread(n: int, most: int) -> list[int]:
    """Return at most so many of the numbers 0 to n - 1, evenly spread."""
    if n <= most:
        return list(range(n))
    return [int(i) for i in np.round(np.linspace(0, n - 1, most))]


def _row(answer: Answer, anchor: str | None, picture: str) -> Row:
    surface, metres = answer.surface, answer.pitch_m is not None
    size = "–"
    if surface.form not in ("plane", "edge"):
        long, short = answer.size
        one = surface.section in ("circle", "square")
        size = (
            length(long, metres=metres)
            if one
            else f"{_bare(length(long, metres=metres))} × {length(short, metres=metres)}"
        )
    return Row(
        anchor=anchor,
        picture=picture,
        name=surface.name,
        probability=percent(surface.probability),
        outline=f"{surface.outline}, {percent(surface.outline_probability)}",
        share=surface.probability,
        frame=answer.frame,
        time="" if answer.time_s is None else f"{answer.time_s:.2f}\u202fs",
        pad=answer.pad,
        contact=answer.contact,
        size=size,
    )


def _bare(text: str) -> str:
    return text.rpartition("\u202f")[0]


def _place(answer: Answer, recording: Recording) -> str:
    parts = [f"frame {answer.frame}"]
    if answer.time_s is not None:
        parts.append(f"{answer.time_s:.2f}\u202fs")
    if len(recording.pads) > 1:
        parts.append(f"pad {answer.pad}")
    parts.append(f"contact {answer.contact}")
    return " · ".join(parts)


def _headline(answers: Sequence[Answer]) -> list[tuple[str, int]]:
    """Return how often each name was given, the most frequent first."""
    counts: dict[str, int] = {}
    for answer in answers:
        counts[answer.surface.name] = counts.get(answer.surface.name, 0) + 1
    return sorted(counts.items(), key=lambda item: (-item[1], item[0]))


def _done_to_all(answers: Sequence[Answer]) -> tuple[str, ...]:
    """Return what was done to the frame of every contact."""
    shared = set.intersection(*(set(answer.frame_notes) for answer in answers)) if answers else set()
    return tuple(note for note in answers[0].frame_notes if note in shared) if answers else ()


def _facts(recording: Recording, answers: Sequence[Answer]) -> list[tuple[str, str]]:
    facts = []
    if recording.sensor:
        facts.append(("sensor", recording.sensor))
    read_as = next((answer.sensor for answer in answers if answer.sensor), None)
    if read_as is not None:
        facts.append(("undone as", read_as))
    pads = [
        f"{pad.shape[0]} × {pad.shape[1]}"
        + ("" if pad.pitch_m is None else f" at {_pitch(pad.pitch_m)}")
        + ("" if len(recording.pads) == 1 else f" ({name})")
        for name, pad in list(recording.pads.items())[:4]
    ]
    if len(recording.pads) > len(pads):
        pads.append(f"{len(recording.pads) - len(pads)} more pads")
    facts.append(("taxels", ", ".join(pads)))
    facts.append(("frames", str(recording.n_frames)))
    if recording.time_s is not None and recording.n_frames > 1:
        facts.append(("duration", f"{number(float(recording.time_s[-1] - recording.time_s[0]))}\u202fs"))
    facts.append(("unit", recording.unit))
    return facts


def _pitch(pitch_m: tuple[float, float]) -> str:
    rows, cols = (length(p, metres=True) for p in pitch_m)
    return rows if rows == cols else f"{_bare(rows)} × {cols}"


def _notes(answers: Sequence[Answer], recording: Recording, skin: str | None, n_cards: int, n_rows: int) -> list[str]:
    """Return what a reader must know before believing the answers."""
    notes = []
    if len(answers) > n_rows:
        notes.append(
            f"{len(answers)} contacts were found. The table lists {n_rows} and {n_cards} have a card below, "
            "both evenly spread over the recording; the command prints all of them."
        )
    elif len(answers) > n_cards:
        notes.append(
            f"{len(answers)} contacts were found. The table lists all; {n_cards} have a card below, "
            "evenly spread over the recording."
        )
    if skin is not None:
        notes.append(f"Skin: {skin}.")
    elif answers and recording.unit.lower() not in ("m", "metre", "meter"):
        notes.append(
            "The skin is not known, so it is taken as unknown: names are weighed over hard, thin and thick elastic "
            "skins together, on which pressure need not have the object's form."
        )
    if recording.unit == "raw":
        notes.append("The sensor gives no unit: readings are raw numbers, and no force can be told.")
    unpitched = [name for name, pad in recording.pads.items() if pad.pitch_m is None]
    if unpitched:
        notes.append("The spacing of the taxels is not known: lengths are in taxels; with it they are in metres.")
    for name, pad in recording.pads.items():
        if pad.valid is not None and not pad.valid.all():
            n = int((~pad.valid).sum())
            of = "" if len(recording.pads) == 1 else f" of pad {name}"
            notes.append(
                f"{counted(n, 'taxel')}{of} {'is' if n == 1 else 'are'} marked broken "
                f"({_places(~pad.valid)}); filled from the neighbours and crossed out in the frames."
            )
    remarks = recording.remarks
    notes += sentences(remarks[:_MOST_REMARKS])
    if len(remarks) > _MOST_REMARKS:
        notes.append(f"The recording has {counted(len(remarks) - _MOST_REMARKS, 'remark')} more.")
    return notes


def _places(where: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], most: int = 4) -> str:
    places = np.argwhere(where).tolist()
    told = ", ".join(f"({row}, {col})" for row, col in places[:most])
    return f"(row, col) = {told}" + (f" and {len(places) - most} more" if len(places) > most else "")
