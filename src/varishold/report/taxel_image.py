"""The frame as the sensor saw it: every taxel a square, broken ones crossed out, the contact framed."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.report.colours import palette
from varishold.report.outline_path import UNITS_PER_TAXEL, path_data
from varishold.report.picture import png_data_uri
from varishold.report.screen import fit, scale_bar, screen
from varishold.report.section_stack import SectionStack

__all__ = ["image_element", "taxel_image", "thumbnail"]

_COLOURS = 96
_THUMBNAIL_COLOURS = 24
_THUMBNAIL_TAXELS = 32


def taxel_image(
    stack: SectionStack,
    *,
    valid: NDArray[np.bool_] | None,
    unit_m: float | None,
    label: str,
) -> Markup:
    """Draw the whole frame with the contact's lowest outline.

    Parameters
    ----------
    stack : SectionStack
        The contact.
    valid : ndarray of shape (rows, cols), bool, or None
        False where a taxel is broken.
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
    if valid is not None and not valid.all():
        body.append(f'<path class="dead" d="{_crosses(valid, stack.step)}"/>')
    body.append(f'<path class="window" d="M{left:.0f} {top:.0f}h{wide:.0f}v{high:.0f}h{-wide:.0f}z"/>')
    if len(stack):
        body.append(f'<path class="now" d="{path_data(stack.outlines[-1])}"/>')
    body += ["</g>", scale_bar(place, unit_m)]
    return screen("".join(body), label=label, kind="taxels")


def image_element(stack: SectionStack, rows_cols: tuple[slice, slice], *, dim: bool = False) -> str:
    """Return an SVG image of some taxels, at their place in path units."""
    rows, cols = rows_cols
    uri = png_data_uri(*_indexed(stack, stack.values[rows, cols], _COLOURS), transparent=_COLOURS)
    x, y = cols.start * stack.step[0], rows.start * stack.step[1]
    w, h = (cols.stop - cols.start) * stack.step[0], (rows.stop - rows.start) * stack.step[1]
    u = UNITS_PER_TAXEL
    return (
        f'<image class="{"dim" if dim else "lit"}" x="{u * x:.0f}" y="{u * y:.0f}" width="{u * w:.0f}" '
        f'height="{u * h:.0f}" preserveAspectRatio="none" href="{uri}"/>'
    )


def thumbnail(stack: SectionStack) -> str:
    """Return a small picture of the contact's window as a data URI."""
    left, top, wide, high = stack.window
    rows = slice(int(top / stack.step[1]), int(np.ceil((top + high) / stack.step[1])))
    cols = slice(int(left / stack.step[0]), int(np.ceil((left + wide) / stack.step[0])))
    every = max(1, -(-max(rows.stop - rows.start, cols.stop - cols.start) // _THUMBNAIL_TAXELS))
    values = stack.values[rows, cols][::every, ::every]
    return png_data_uri(*_indexed(stack, values, _THUMBNAIL_COLOURS), transparent=_THUMBNAIL_COLOURS)


def _indexed(stack: SectionStack, values: NDArray[np.float64], colours: int) -> tuple[NDArray[np.uint8], bytes]:
    there = np.isfinite(values)
    place = stack.place(np.where(there, values, 0.0))
    index = np.where(there, np.round(place * (colours - 1)), colours).astype(np.uint8)
    return index, palette(colours) + b"\0\0\0"


def _crosses(valid: NDArray[np.bool_], step: tuple[float, float]) -> str:
    drawn = []
    for row, col in np.argwhere(~valid).tolist():
        x0, y0 = ((col + 0.2) * step[0] * UNITS_PER_TAXEL, (row + 0.2) * step[1] * UNITS_PER_TAXEL)
        w, h = 0.6 * step[0] * UNITS_PER_TAXEL, 0.6 * step[1] * UNITS_PER_TAXEL
        drawn.append(f"M{x0:.0f} {y0:.0f}l{w:.0f} {h:.0f}m0 {-h:.0f}l{-w:.0f} {h:.0f}")
    return "".join(drawn)
