"""The frame as the sensor saw it: every taxel a square, broken ones crossed out, the contact framed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.report.outline_path import UNITS_PER_TAXEL, path_data
from varishold.report.picture import png_data_uri
from varishold.report.screen import fit, scale_bar, screen
from varishold.report.section_stack import SectionStack

__all__ = ["Marks", "image_element", "taxel_image", "thumbnail"]

_COLOURS = 96
_THUMBNAIL_COLOURS = 24
_THUMBNAIL_TAXELS = 32
# Of more taxels than these the marks would hide the frame.
_MOST_MARKS = 600
# A cross over a broken taxel, and a caret in a saturated one, which felt at least that: steps of a share of the taxel.
_CROSS = (((0.2, 0.2), (0.6, 0.6)), ((0.2, 0.8), (0.6, -0.6)))
_CARET = (((0.25, 0.62), (0.25, -0.25)), ((0.5, 0.37), (0.25, 0.25)))


@dataclass(frozen=True, eq=False)
class Marks:
    """What the sensor lost of a frame.

    Parameters
    ----------
    broken, saturated : ndarray of shape (rows, cols), bool
    cut : tuple of str
        The sides of the pad (left, right, top, bottom) that cut the contact.
    """

    broken: NDArray[np.bool_]
    saturated: NDArray[np.bool_]
    cut: tuple[str, ...] = ()

    @property
    def legend(self) -> str:
        """What the marks in the frame mean."""
        said = [
            words
            for words, shown in (
                ("× broken and filled", 0 < self.broken.sum() <= _MOST_MARKS),
                ("^ saturated", 0 < self.saturated.sum() <= _MOST_MARKS),
                ("orange border: cut there", bool(self.cut)),
            )
            if shown
        ]
        return "; ".join(["", *said])


def taxel_image(
    stack: SectionStack,
    *,
    marks: Marks,
    unit_m: float | None,
    label: str,
) -> Markup:
    """Draw the whole frame with the contact's lowest outline.

    Parameters
    ----------
    stack : SectionStack
        The contact.
    marks : Marks
        What the sensor lost of it.
    unit_m : float or None
        The smaller taxel spacing in metres, where known.
    label : str
        Description for those who cannot see it.
    """
    width, height = stack.size
    place = fit((0.0, 0.0, width, height), below=20)
    left, top, wide, high = (v * UNITS_PER_TAXEL for v in stack.window)
    body = [
        f'<g transform="{place.transform(UNITS_PER_TAXEL)}">',
        image_element(stack, (slice(0, stack.shape[0]), slice(0, stack.shape[1]))),
        f'<path class="pad" d="M0 0h{width * UNITS_PER_TAXEL:.0f}v{height * UNITS_PER_TAXEL:.0f}H0z"/>',
    ]
    body += [_drawn("dead", _CROSS, marks.broken, stack.step), _drawn("full", _CARET, marks.saturated, stack.step)]
    body.append(f'<path class="window" d="M{left:.0f} {top:.0f}h{wide:.0f}v{high:.0f}h{-wide:.0f}z"/>')
    if len(stack):
        body.append(f'<path class="now" d="{path_data(stack.outlines[-1])}"/>')
    if marks.cut:
        body.append(f'<path class="ends" d="{_ends(stack, marks.cut)}"/>')
    body += ["</g>", scale_bar(place, unit_m)]
    return screen("".join(body), label=label, kind="taxels")


def image_element(stack: SectionStack, rows_cols: tuple[slice, slice], *, dim: bool = False) -> str:
    """Return an SVG image of some taxels, at their place in path units."""
    rows, cols = rows_cols
    uri = png_data_uri(stack.place(stack.values[rows, cols]), _COLOURS)
    x, y = cols.start * stack.step[0], rows.start * stack.step[1]
    w, h = (cols.stop - cols.start) * stack.step[0], (rows.stop - rows.start) * stack.step[1]
    u = UNITS_PER_TAXEL
    return (
        f'<image class="{"dim" if dim else "lit"}" x="{u * x:.0f}" y="{u * y:.0f}" width="{u * w:.0f}" '
        f'height="{u * h:.0f}" preserveAspectRatio="none" href="{uri}"/>'
    )


def thumbnail(stack: SectionStack) -> str:
    """Return a small picture of the contact's window as a data URI."""
    rows, cols = stack.taxels
    every = -(-max(rows.stop - rows.start, cols.stop - cols.start) // _THUMBNAIL_TAXELS)
    return png_data_uri(stack.place(stack.values[rows, cols][::every, ::every]), _THUMBNAIL_COLOURS)


def _drawn(
    kind: str,
    strokes: tuple[tuple[tuple[float, float], tuple[float, float]], ...],
    where: NDArray[np.bool_],
    step: tuple[float, float],
) -> str:
    """Draw strokes, each from a point of the taxel so far on, over every taxel that is marked."""
    places = np.argwhere(where).tolist()
    if not 0 < len(places) <= _MOST_MARKS:
        return ""
    x, y = step[0] * UNITS_PER_TAXEL, step[1] * UNITS_PER_TAXEL
    path = "".join(
        f"M{(col + left) * x:.0f} {(row + top) * y:.0f}l{right * x:.0f} {down * y:.0f}"
        for row, col in places
        for (left, top), (right, down) in strokes
    )
    return f'<path class="{kind}" d="{path}"/>'


def _ends(stack: SectionStack, sides: tuple[str, ...]) -> str:
    """Return the parts of the pad's border, along the contact, at which it is cut."""
    left, top, wide, high = (v * UNITS_PER_TAXEL for v in stack.window)
    width, height = (v * UNITS_PER_TAXEL for v in stack.size)
    lines = {
        "left": f"M0 {top:.0f}v{high:.0f}",
        "right": f"M{width:.0f} {top:.0f}v{high:.0f}",
        "top": f"M{left:.0f} 0h{wide:.0f}",
        "bottom": f"M{left:.0f} {height:.0f}h{wide:.0f}",
    }
    return "".join(lines[side] for side in sides)
