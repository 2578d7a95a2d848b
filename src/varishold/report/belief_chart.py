"""How the belief moves from touch to touch, and the size that it holds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from markupsafe import Markup, escape

from varishold._counted import counted
from varishold.report.exploration_words import in_words
from varishold.report.quantities import percent

__all__ = ["belief_chart", "size_strip"]

# In a wide window, and in a narrow one: width, height, and room for labels on the right.
_WIDE, _NARROW = (940, 230, 210), (400, 240, 128)
_LEFT, _TOP, _BOTTOM = 44, 14, 34
# An object gets a colour and a label if it was ever at least so likely; so many at most.
_LEAST, _MOST = 0.05, 6
_LABEL_APART = 16
# The sizes that the strip shows, where nothing lies outside. Metres.
_SIZES_M = (0.03, 0.13)
_STRIP_WIDTH, _STRIP_HEIGHT = 360, 44


def belief_chart(
    beliefs: Sequence[dict[str, float]],
    touches: Sequence[str],
    *,
    narrow: bool = False,
    before: dict[str, float] | None = None,
) -> Markup:
    """Draw the probability of every object over the touches, beginning before the first.

    Parameters
    ----------
    beliefs : sequence of dict of str to float
        After each touch.
    touches : sequence of str
        Their names.
    narrow : bool
        For a narrow window: touches are numbered, and the labels tell no probabilities.
    before : dict of str to float, optional
        Before the first touch; default: all alike.
    """
    width, height, right = _NARROW if narrow else _WIDE
    names = list(beliefs[-1])
    rows = [before or dict.fromkeys(names, 1 / len(names)), *beliefs]
    by_rise = sorted(names, key=lambda name: -max(row.get(name, 0.0) for row in beliefs))
    shown = [name for name in by_rise if max(row.get(name, 0.0) for row in beliefs) >= _LEAST][:_MOST]
    # The likeliest at the end gets the first colour.
    shown.sort(key=lambda name: -beliefs[-1][name])
    step = (width - _LEFT - right) / len(beliefs)
    high = height - _TOP - _BOTTOM

    def y_of(p: float) -> float:
        return _TOP + high * (1 - p)

    def line(name: str) -> str:
        return "M" + "L".join(f"{_LEFT + k * step:.1f} {y_of(row.get(name, 0.0)):.1f}" for k, row in enumerate(rows))

    body = []
    for p in (0.0, 0.25, 0.5, 0.75, 1.0):
        kind = "base" if p == 0 else "rule"
        body.append(f'<path class="{kind}" d="M{_LEFT} {y_of(p):.1f}H{width - right}"/>')
        body.append(f'<text x="{_LEFT - 7}" y="{y_of(p) + 3.5:.1f}" text-anchor="end">{100 * p:.0f}\u202f%</text>')
    for k, touch in enumerate(("before", *(map(str, range(1, len(touches) + 1)) if narrow else touches))):
        anchor = "start" if k == 0 else "middle"
        body.append(f'<text x="{_LEFT + k * step:.1f}" y="{height - 12}" text-anchor="{anchor}">{escape(touch)}</text>')
    body += [f'<path class="line rest" d="{line(name)}"/>' for name in names if name not in shown]
    for rank in reversed(range(len(shown))):
        body.append(f'<path class="line k{rank}" d="{line(shown[rank])}"/>')
        for k, row in enumerate(rows[1:], start=1):
            p = row.get(shown[rank], 0.0)
            body.append(f'<circle class="spot k{rank}" cx="{_LEFT + k * step:.1f}" cy="{y_of(p):.1f}" r="3.6"/>')
    at = _spread([y_of(beliefs[-1][name]) for name in shown], _TOP, height - _BOTTOM)
    for rank, name in enumerate(shown):
        text = in_words(name) if narrow else f"{in_words(name)} {percent(beliefs[-1][name])}"
        body.append(f'<text class="end k{rank}" x="{width - right + 10}" y="{at[rank] + 4:.1f}">{escape(text)}</text>')
    told = ", ".join(f"{in_words(name)} {percent(beliefs[-1][name])}" for name in shown)
    label = f"Probability of each object over {counted(len(beliefs), 'touch')}; at the end {told}"
    return Markup(
        f'<svg class="growth belief" viewBox="0 0 {width} {height}" role="img" aria-label="{escape(label)}">'
        f"{''.join(body)}</svg>"
    )


def size_strip(size_m: float | None, interval_m: tuple[float, float] | None, true_m: float) -> Markup | None:
    """Draw the size that is believed, with the interval that holds it with 95 %, and the true one; None if unknown."""
    if size_m is None or interval_m is None:
        return None
    low, high = min(_SIZES_M[0], interval_m[0], true_m), max(_SIZES_M[1], interval_m[1], true_m)
    left, right, y = 8.0, _STRIP_WIDTH - 8.0, 18.0

    def x_of(value_m: float) -> float:
        return left + (right - left) * (value_m - low) / (high - low)

    body = [f'<path class="base" d="M{left} {y}H{right}"/>']
    every = 0.02
    for k in range(math.ceil(low / every - 1e-9), math.floor(high / every + 1e-9) + 1):
        x = x_of(k * every)
        body.append(f'<path class="base" d="M{x:.1f} {y}v5"/>')
        body.append(f'<text x="{x:.1f}" y="{y + 19}" text-anchor="middle">{1e3 * k * every:.0f}</text>')
    a, b = x_of(interval_m[0]), x_of(interval_m[1])
    body.append(f'<rect class="interval" x="{a:.1f}" y="{y - 5}" width="{max(b - a, 2):.1f}" height="10" rx="5"/>')
    body.append(f'<path class="median" d="M{x_of(size_m):.1f} {y - 8}v16"/>')
    x = x_of(true_m)
    body.append(f'<path class="true" d="M{x:.1f} {y - 9}l-4.5 -7h9z"/>')
    label = f"Size {1e3 * size_m:.0f} mm, with 95 % between {1e3 * interval_m[0]:.0f} and {1e3 * interval_m[1]:.0f} mm"
    return Markup(
        f'<svg class="growth strip" viewBox="0 0 {_STRIP_WIDTH} {_STRIP_HEIGHT}" role="img" '
        f'aria-label="{escape(label)}; truly {1e3 * true_m:.0f} mm">{"".join(body)}</svg>'
    )


def _spread(at: list[float], low: float, high: float) -> list[float]:
    """Move labels apart so that none covers another, in their order, within the chart."""
    order = sorted(range(len(at)), key=lambda k: at[k])
    out = list(at)
    for before, k in zip([None, *order], order, strict=False):
        least = low if before is None else out[before] + _LABEL_APART
        out[k] = max(at[k], least)
    most = high
    for k in reversed(order):
        out[k] = min(out[k], most)
        most = out[k] - _LABEL_APART
    return out
