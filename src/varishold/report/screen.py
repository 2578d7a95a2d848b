"""The dark pane on which frames, outlines and slices are drawn: its size, and how a picture is fitted into it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup, escape

from varishold.report.quantities import length

__all__ = ["SCREEN_HEIGHT", "SCREEN_WIDTH", "Fit", "fit", "scale_bar", "screen"]

SCREEN_WIDTH, SCREEN_HEIGHT = 360, 300
_PADDING = 14


@dataclass(frozen=True)
class Fit:
    """Where drawing units land on the screen: x' = left + scale x.

    Parameters
    ----------
    left, top : float
        The screen's place of the drawing's origin.
    scale : float
        Screen units to a drawing unit.
    """

    left: float
    top: float
    scale: float

    def transform(self, units: float = 1.0) -> str:
        """Return the SVG transform for coordinates of so many units to a drawing unit."""
        return f"translate({self.left:.2f} {self.top:.2f}) scale({self.scale / units:.5g})"


def fit(window: tuple[float, float, float, float], *, below: float = 0.0) -> Fit:
    """Centre a window (left, top, width, height) on the screen, keeping free so much below it."""
    left, top, width, height = window
    wide, high = SCREEN_WIDTH - 2 * _PADDING, SCREEN_HEIGHT - 2 * _PADDING - below
    scale = min(wide / width, high / height)
    x = (SCREEN_WIDTH - scale * width) / 2 - scale * left
    y = _PADDING + (high - scale * height) / 2 - scale * top
    return Fit(x, y, scale)


def screen(body: str, *, label: str, kind: str) -> Markup:
    """Wrap a drawing into an SVG pane.

    Parameters
    ----------
    body : str
        SVG elements, safe as they are.
    label : str
        What a person who cannot see it is told; escaped here.
    kind : str
        Its CSS class.
    """
    return Markup(
        f'<svg class="screen {kind}" viewBox="0 0 {SCREEN_WIDTH} {SCREEN_HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{body}</svg>'
    )


def scale_bar(place: Fit, unit_m: float | None) -> str:
    """Draw a bar of a round length at the screen's lower left.

    Parameters
    ----------
    place : Fit
        How the picture was fitted.
    unit_m : float or None
        A drawing unit in metres; None draws the bar in taxels.
    """
    unit = 1.0 if unit_m is None else unit_m
    most = 0.3 * SCREEN_WIDTH / place.scale * unit
    power = 10.0 ** math.floor(math.log10(most))
    bar = max(step * power for step in (1, 2, 5) if step * power <= most)
    if unit_m is None:
        bar = max(round(bar), 1)
    wide = bar / unit * place.scale
    y = SCREEN_HEIGHT - _PADDING
    return (
        f'<path class="bar" d="M{_PADDING} {y - 4}v4h{wide:.1f}v-4"/>'
        f'<text x="{_PADDING + wide + 7:.1f}" y="{y}">{escape(length(bar, metres=unit_m is not None))}</text>'
    )
