"""Charts of shares: points with their intervals, and curves, over another share or over steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

__all__ = ["Point", "Series", "share_chart"]

_WIDTH, _HEIGHT = 360, 270
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 14, 12, 42


@dataclass(frozen=True)
class Point:
    """A point of a chart: shares of the chart's width and height; ends of an interval; the radius of its dot."""

    x: float
    y: float
    low: float | None = None
    high: float | None = None
    radius: float = 3.5
    says: str = ""


@dataclass(frozen=True)
class Series:
    """Points that belong together.

    Parameters
    ----------
    kind : str
        Its CSS class: ``ours`` or ``peer``.
    points : sequence of Point
    line : bool
        Whether a line joins them.
    """

    kind: str
    points: Sequence[Point]
    line: bool = True


def share_chart(
    series: Sequence[Series],
    *,
    x_ticks: Sequence[tuple[float, str]],
    y_top: float = 1.0,
    x_name: str,
    label: str,
    diagonal: bool = False,
) -> Markup:
    """Draw a chart whose height is a share.

    Parameters
    ----------
    series : sequence of Series
    x_ticks : sequence of (float, str)
        Places along the width, from 0 to 1, and what stands there.
    y_top : float
        The share at the top.
    x_name : str
        What the width is.
    label : str
        Description for those who cannot see it.
    diagonal : bool
        Draw the line on which height and width are equal.
    """
    body = [_across(share, share / y_top) for share in _y_ticks(y_top)]
    for x, text in x_ticks:
        body.append(f'<text x="{_x(x):.1f}" y="{_HEIGHT - _BOTTOM + 17}" text-anchor="middle">{escape(text)}</text>')
    if diagonal:
        body.append(f'<path class="chord" d="M{_x(0):.1f} {_y(0):.1f}L{_x(1):.1f} {_y(1 / y_top):.1f}"/>')
    for one in reversed(series):
        body.append(_drawn(one, y_top))
    middle = (_LEFT + _WIDTH - _RIGHT) / 2
    body.append(f'<text x="{middle}" y="{_HEIGHT - 6}" text-anchor="middle">{escape(x_name)}</text>')
    return Markup(
        f'<svg class="growth shares" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(label)}">'
        f"{''.join(body)}</svg>"
    )


def _x(share: float) -> float:
    return _LEFT + (_WIDTH - _LEFT - _RIGHT) * share


def _y(share: float) -> float:
    return _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * share


def _y_ticks(top: float) -> list[float]:
    step = next((step for step in (0.01, 0.02, 0.05, 0.1, 0.2, 0.25) if top / step <= 5), 0.25)
    return [k * step for k in range(int(top / step + 1e-9) + 1)]


def _across(share: float, place: float) -> str:
    at = _y(place)
    return (
        f'<path class="{"rule" if share else "base"}" d="M{_LEFT} {at:.1f}H{_WIDTH - _RIGHT}"/>'
        f'<text x="{_LEFT - 7}" y="{at + 3.5:.1f}" text-anchor="end">{100 * share:g}\u202f%</text>'
    )


def _drawn(one: Series, y_top: float) -> str:
    parts = []
    for point in one.points:
        if point.low is not None and point.high is not None:
            low, high = _y(point.low / y_top), _y(min(point.high / y_top, 1.0))
            parts.append(f'<path class="ends" d="M{_x(point.x):.1f} {low:.1f}V{high:.1f}"/>')
    if one.line and len(one.points) > 1:
        steps = "L".join(f"{_x(point.x):.1f} {_y(point.y / y_top):.1f}" for point in one.points)
        parts.append(f'<path class="line" d="M{steps}"/>')
    for point in one.points:
        told = f"<title>{escape(point.says)}</title>" if point.says else ""
        parts.append(
            f'<circle class="spot" cx="{_x(point.x):.1f}" cy="{_y(point.y / y_top):.1f}" r="{point.radius:.1f}">'
            f"{told}</circle>"
        )
    return f'<g class="{escape(one.kind)}">{"".join(parts)}</g>'
