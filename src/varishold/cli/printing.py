"""How answers are printed: tables for people, JSON Lines for programs."""

from __future__ import annotations

import json as jsonlib
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable
from itertools import islice
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import click

from varishold.errors import InputError

if TYPE_CHECKING:
    from varishold.recording import Recording
    from varishold.touch import Answer

# Columns of a terminal that a reason needs beside its answer.
_NARROWEST = 40
# Names of an answer set, and kinds of notes on frames, that are printed; --json has all.
_MOST_HELD, _MOST_NOTES = 4, 8
# So many rows of a table are lined up at a time.
_ROWS_A_BLOCK = 500

__all__ = ["echo", "parse_shape", "print_answers", "print_json", "printable", "tell"]


def printable(text: str) -> str:
    """Return a text in which nothing can steer a terminal: control characters stand as their codes."""
    return "".join(
        sign if sign.isprintable() or sign in "\n\t" else sign.encode("unicode_escape").decode("ascii") for sign in text
    )


def echo(text: str) -> None:
    """Print a line."""
    click.echo(printable(text))


def tell(words: str) -> None:
    """Print a line beside the output, as the program's own."""
    print(f"varishold: {printable(words)}", file=sys.stderr, flush=True)


def parse_shape(text: str | None) -> tuple[int, int] | None:
    """Return (rows, cols) of a text like ``16x16``.

    Raises
    ------
    InputError
        If it is not two positive whole numbers with an x between them.
    """
    if text is None:
        return None
    match = re.fullmatch(r"\s*(\d{1,6})\s*[x×X]\s*(\d{1,6})\s*", text)
    if match is None or 0 in (int(match[1]), int(match[2])):
        raise InputError(f"--shape must be ROWSxCOLS, as in 16x16, got {text!r}")
    return int(match[1]), int(match[2])


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON line."""
    sys.stdout.write(jsonlib.dumps(value, allow_nan=False) + "\n")


def print_answers(answers: Iterable[Answer], recording: Recording, *, json: bool) -> None:
    """Print answers as they come, as JSON Lines or as a table; none is kept."""
    if json:
        for answer in answers:
            print_json(answer.to_dict())
        return
    columns = get_terminal_size().columns
    for remark in recording.remarks:
        _note(remark, columns)
    several = len(recording.pads) > 1
    headings = ["frame", *(["pad"] if several else []), "name", "p", "else", "at (x, y)", "size", "why"]
    widths, notes, total = [len(heading) for heading in headings], Counter[str](), 0
    coming = iter(answers)
    while some := list(islice(coming, _ROWS_A_BLOCK)):
        rows = [_row(answer, several) for answer in some]
        widths = [max(wide, *(len(row[column]) for row in rows)) for column, wide in enumerate(widths)]
        if total == 0:
            _print_row(columns, headings, headings, widths, bold=True)
        for row, answer in zip(rows, some, strict=True):
            _print_row(columns, headings, row, widths)
            if (more := _unsure(answer)) is not None:
                _line(" " * (widths[0] + 2) + more, dim=True)
        notes.update(note for answer in some for note in dict.fromkeys(answer.frame_notes))
        total += len(some)
    if total == 0:
        _line("no contact above the noise")
    for note in _frame_notes(notes, total):
        _note(note, columns)


def _line(text: str, **style: Any) -> None:
    """Print a line; in a terminal in a style, unless that is not wanted."""
    click.echo(click.style(printable(text), **style), color=False if os.environ.get("NO_COLOR") else None)


def _note(words: str, columns: int) -> None:
    """Print a note, in lines of so many columns."""
    for line in wrap(f"note: {words}", max(columns, _NARROWEST), break_on_hyphens=False):
        _line(line, fg="yellow")


def _print_row(columns: int, headings: list[str], row: list[str], widths: list[int], *, bold: bool = False) -> None:
    """Print a row of a table, frame and probability at the right."""
    cells = [
        cell.rjust(wide) if heading in ("frame", "p") else cell.ljust(wide)
        for heading, cell, wide in zip(headings[:-1], row[:-1], widths[:-1], strict=True)
    ]
    # The reason takes what the window leaves it; in a narrow one --json and the report hold it.
    left = columns - sum(widths[:-1]) - 2 * len(cells)
    line = "  ".join([*cells, row[-1]] if left >= _NARROWEST else cells).rstrip()
    _line(line if len(line) <= columns else line[: columns - 1] + "…", bold=bold or None)


def _frame_notes(counts: Counter[str], total: int) -> list[str]:
    """Return what was done to frames, each thing once, with how many contacts it was done to if not to all."""
    said = [note if count == total else f"{note} ({count} of {total} contacts)" for note, count in counts.items()]
    more = len(said) - _MOST_NOTES
    return said if more <= 0 else [*said[:_MOST_NOTES], f"{more} more notes on frames; --json has them"]


def _unsure(answer: Answer) -> str | None:
    """Return what holds where the name alone does not: the outline, the names that hold 90 %, where it is cut."""
    from varishold.report.wording import cut_at

    surface = answer.surface
    said = []
    if len(surface.answer_set) > 1:
        names, more = surface.answer_set[:_MOST_HELD], len(surface.answer_set) - _MOST_HELD
        held = ", ".join(names) + (f" and {more} more" if more > 0 else "")
        said += [f"outline {surface.outline} {surface.outline_probability:.2f}", f"90 %: {held}"]
    if hidden := cut_at(surface):
        said.append(f"cut at the pad's {', '.join(hidden)}")
    return "; ".join(said) or None


def _row(answer: Answer, several: bool) -> list[str]:
    s = answer.surface
    other = next(iter(s.alternatives.items()), None)
    scale, unit = (1e3, "mm") if answer.pitch_m is not None else (1.0, "taxels")
    x, y = s.position
    return [
        f"{answer.frame}",
        *((answer.pad,) if several else ()),
        s.name,
        f"{s.probability:.2f}",
        "" if other is None else f"{other[0]} {other[1]:.2f}",
        f"{round(x * scale, 1) + 0.0:.1f}, {round(y * scale, 1) + 0.0:.1f}",
        _lengths(answer.size, scale, unit),
        s.reasons[0] if s.reasons else "",
    ]


def _lengths(size: tuple[float, float], scale: float, unit: str) -> str:
    long, short = size[0] * scale, size[1] * scale
    return f"{long:.1f} {unit}" if abs(long - short) < 1e-9 * long else f"{long:.1f} x {short:.1f} {unit}"
