"""What the drawings of one contact share: its sections in drawing units, their heights and their colours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from varishold.report.colours import BELOW, INSIDE, css
from varishold.report.outline_path import thinned
from varishold.touch import Contact

__all__ = ["MOST_LEVELS", "SectionStack", "stack_sections"]

#: A drawing shows at most this many sections; a finer profile is drawn at evenly chosen ones.
MOST_LEVELS = 32
# Outlines are thinned until they are off by this share of the window's longer side: half a pixel on screen.
_THINNING = 1 / 500
# Taxels shown around a contact.
_MARGIN = 1.0


@dataclass(frozen=True)
class SectionStack:
    """A contact's sections, ready to be drawn; entry 0 is nearest the top.

    Lengths are drawing units, the smaller of the two taxel spacings; (x, y) counts from the frame's upper
    left corner, y downwards.

    Parameters
    ----------
    contact : Contact
    shape : (int, int)
        Rows and columns of the frame.
    step : (float, float)
        Width and height of a taxel.
    values : ndarray of shape (rows, cols), float64
        The frame, not finite where there is no taxel.
    window : (float, float, float, float)
        Left, top, width and height of what is shown of it.
    level : ndarray of shape (n,), intp
        Place of each section in the contact's profile.
    threshold : ndarray of shape (n,), float64
        Theta_i, falling.
    height : ndarray of shape (n,), float64
        (theta_i - floor) / (peak - floor).
    peak, floor : float
        Highest taxel and standard plane.
    """

    contact: Contact
    shape: tuple[int, int]
    step: tuple[float, float]
    values: NDArray[np.float64]
    window: tuple[float, float, float, float]
    level: NDArray[np.intp]
    threshold: NDArray[np.float64]
    height: NDArray[np.float64]
    peak: float
    floor: float

    def __len__(self) -> int:
        return len(self.threshold)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the frame."""
        return self.shape[1] * self.step[0], self.shape[0] * self.step[1]

    @property
    def taxels(self) -> tuple[slice, slice]:
        """Rows and columns of the taxels that the window shows."""
        left, top, wide, high = self.window
        x, y = self.step
        # A place over its step is a whole number but for rounding.
        return slice(round(top / y), round((top + high) / y)), slice(round(left / x), round((left + wide) / x))

    @cached_property
    def outlines(self) -> tuple[tuple[NDArray[np.float64], ...], ...]:
        """The closed polygons of each section; outer ones turn from +x toward +y, holes the other way."""
        middle = (self.size[0] / 2, self.size[1] / 2)
        tolerance = _THINNING * max(self.window[2:])
        width, height = self.step
        found = self.contact.filled(self.threshold.tolist(), (height, width))
        return tuple(tuple(thinned(line + middle, tolerance) for line in lines) for lines in found.by_level())

    def place(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where values stand on the colour scale: the floor at `INSIDE`, the peak at 1; NaN where not finite."""
        share = np.where(np.isfinite(value), (value - self.floor) / (self.peak - self.floor), np.nan)
        below = BELOW + 0.1 * np.clip(value / self.floor, 0.0, 1.0) if self.floor > 0 else np.full_like(share, BELOW)
        return np.where(share < 0, below, INSIDE + (1 - INSIDE) * np.clip(share, 0.0, 1.0))

    @cached_property
    def colours(self) -> tuple[str, ...]:
        """The colour of each section as CSS."""
        return tuple(css(INSIDE + (1 - INSIDE) * height) for height in self.height.tolist())


def stack_sections(contact: Contact) -> SectionStack:
    """Prepare a contact's sections for drawing.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    SectionStack
    """
    rows, cols = contact.shape
    row_pitch, col_pitch = contact.pitch or (1.0, 1.0)
    unit = min(row_pitch, col_pitch)
    step = (col_pitch / unit, row_pitch / unit)
    shown = np.flatnonzero(np.nan_to_num(contact.profile.area) > 0)
    if len(shown) > MOST_LEVELS:
        shown = shown[np.round(np.linspace(0, len(shown) - 1, MOST_LEVELS)).astype(int)]
    window = _window(contact, step)
    threshold = contact.profile.threshold[shown]
    span = max(contact.peak - contact.floor, math.ulp(contact.peak))
    return SectionStack(
        contact=contact,
        shape=(rows, cols),
        step=step,
        values=contact.frame.padded[1:-1, 1:-1],
        window=window,
        level=shown,
        threshold=threshold,
        height=np.clip((threshold - contact.floor) / span, 0.0, 1.0),
        peak=contact.peak,
        floor=contact.peak - span,
    )


def _window(contact: Contact, step: tuple[float, float]) -> tuple[float, float, float, float]:
    rows, cols = contact.shape
    in_rows, in_cols = contact.window
    left, right = max(in_cols.start - _MARGIN, 0.0), min(in_cols.stop + _MARGIN, float(cols))
    top, bottom = max(in_rows.start - _MARGIN, 0.0), min(in_rows.stop + _MARGIN, float(rows))
    return left * step[0], top * step[1], (right - left) * step[0], (bottom - top) * step[1]
