"""Growth of the sections: sqrt(area) or perimeter against the threshold, with its chord (eq. [18], corrected)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from varishold.report.section_stack import SectionStack

__all__ = ["chord_plot"]

_WIDTH, _HEIGHT = 360, 230
_LEFT, _RIGHT, _TOP, _BOTTOM = 40, 8, 8, 38


def chord_plot(
    stack: SectionStack,
    growth: NDArray[np.float64],
    usable: NDArray[np.bool_],
    *,
    label: str,
    tick: Callable[[float], str],
    theta: Callable[[float], str],
) -> Markup:
    """Draw how a measure J grows while the threshold falls, against its chord.

    What lies above the chord (a bulge) is filled, what lies below (a defect) is hatched.

    Parameters
    ----------
    stack : SectionStack
        The contact.
    growth : ndarray of shape (n,), float64
        J of each drawn section, degree 1: sqrt(area) or perimeter.
    usable : ndarray of shape (n,), bool
        Sections large enough to be believed; the chord joins the highest with the lowest of them.
    label : str
        Description for those who cannot see it.
    tick, theta : callable
        How a value of J, and a threshold, are written.
    """
    n = len(stack)
    most = float(growth.max()) if n else 1.0
    step = _round_step(most)
    top = step * max(math.ceil(most / step - 1e-9), 1)
    x = _LEFT + (_WIDTH - _LEFT - _RIGHT) * (1 - stack.height)
    y = _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * growth / top
    body = [_axes(top, step, tick), _theta_axis(stack, theta)]
    used = np.flatnonzero(usable)
    if len(used) >= 2:
        body.append(_against_chord(x[used], y[used]))
    if n > 1:
        body.append(f'<path class="curve" d="{_line(x, y)}"/>')
    for i in range(n):
        kind = "dot" if usable[i] else "dot small"
        body.append(
            f'<circle class="{kind}" data-i="{i}" cx="{x[i]:.1f}" cy="{y[i]:.1f}" '
            f'r="{3.4 if usable[i] else 2}" fill="{stack.colours[i]}"/>'
        )
    return Markup(
        f'<svg class="growth" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(label)}">'
        f"{''.join(body)}</svg>"
    )


def _against_chord(x: NDArray[np.float64], y: NDArray[np.float64]) -> str:
    """Fill what lies above the chord and hatch what lies below it."""
    chord = y[0] + (y[-1] - y[0]) * (x - x[0]) / (x[-1] - x[0])
    above, below = np.minimum(y, chord), np.maximum(y, chord)
    parts = [f'<path class="bulge" d="{_line(x, above)}L{x[-1]:.1f} {y[-1]:.1f}L{x[0]:.1f} {y[0]:.1f}z"/>']
    if np.any(below - chord > 0.5):
        parts.append(f'<path class="defect" d="{_line(x, below)}L{x[-1]:.1f} {y[-1]:.1f}L{x[0]:.1f} {y[0]:.1f}z"/>')
    parts.append(f'<path class="chord" d="M{x[0]:.1f} {y[0]:.1f}L{x[-1]:.1f} {y[-1]:.1f}"/>')
    return "".join(parts)


def _axes(top: float, step: float, tick: Callable[[float], str]) -> str:
    lines = []
    for k in range(round(top / step) + 1):
        y = _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * k * step / top
        lines.append(f'<path class="{"base" if k == 0 else "rule"}" d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}"/>')
        lines.append(f'<text x="{_LEFT - 7}" y="{y + 3.5:.1f}" text-anchor="end">{escape(tick(k * step))}</text>')
    return "".join(lines)


def _theta_axis(stack: SectionStack, theta: Callable[[float], str]) -> str:
    y = _HEIGHT - _BOTTOM
    left, right = _LEFT, _WIDTH - _RIGHT
    return (
        f'<path class="base" d="M{left} {y}v4M{right} {y}v4"/>'
        f'<text x="{left}" y="{y + 16}">θ₁ {escape(theta(stack.peak))}</text>'
        f'<text x="{right}" y="{y + 16}" text-anchor="end">δ {escape(theta(stack.floor))}</text>'
        f'<text class="name" x="{(left + right) / 2}" y="{y + 31}" text-anchor="middle">'
        "the threshold falls → (chord dashed)</text>"
    )


def _round_step(most: float) -> float:
    """Return the round step that cuts 0 to `most` into three to five."""
    if not most > 0:
        return 1.0
    power: float = 10.0 ** math.floor(math.log10(most))
    for step in (0.2, 0.25, 0.5, 1.0, 2.0, 2.5):
        if most / (step * power) <= 5:
            return step * power
    return 5 * power


def _line(x: NDArray[np.float64], y: NDArray[np.float64]) -> str:
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
