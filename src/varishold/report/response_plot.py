"""A sensor's response: reading over stress, the curve that is used and the points that were measured."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.calibration.result import Curve
from varishold.sensor import Response

__all__ = ["response_plot"]

_WIDTH, _HEIGHT = 360, 260
_LEFT, _RIGHT, _TOP, _BOTTOM = 40, 10, 8, 38
_POINTS = 120


def response_plot(response: Response, curve: Curve, dead_band: float, saturation: float | None) -> Markup:
    """Draw a response and the points it was fitted to.

    Parameters
    ----------
    response : Response
        The curve that is used.
    curve : Curve
        What was measured.
    dead_band : float
        Share of full scale that is not felt; told in the axis.
    saturation : float or None
        Where readings end.
    """
    most = max([1.0, *curve.stress.tolist(), *curve.reading.tolist()])
    x = np.linspace(0.0, most, _POINTS)
    y = response.reading(x)
    if saturation is not None:
        y = np.minimum(y, saturation)
    top = max(most, float(y.max()))
    lines = []
    for tick in np.linspace(0.0, 1.0, 5).tolist():
        _, at = _place(np.zeros(1), np.array([tick]), most, top)
        lines.append(f'<path class="{"rule" if tick else "base"}" d="M{_LEFT} {at[0]:.1f}H{_WIDTH - _RIGHT}"/>')
        lines.append(f'<text x="{_LEFT - 7}" y="{at[0] + 3.5:.1f}" text-anchor="end">{tick:g}</text>')
    px, py = _place(x, y, most, top)
    path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(px.tolist(), py.tolist(), strict=True))
    straight, level = _place(np.array([0.0, min(most, top)]), np.array([0.0, min(most, top)]), most, top)
    cx, cy = _place(curve.stress, curve.reading, most, top)
    dots = "".join(
        f'<circle class="dot" cx="{a:.1f}" cy="{b:.1f}" r="3" fill="currentColor"/>'
        for a, b in zip(cx.tolist(), cy.tolist(), strict=True)
    )
    beneath = f", above a dead band of {100 * dead_band:.2g} %" if dead_band else ""
    return Markup(
        f'<svg class="growth" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="Reading over stress: the {response.kind} response and the points measured">{"".join(lines)}'
        f'<path class="chord" d="M{straight[0]:.1f} {level[0]:.1f}L{straight[1]:.1f} {level[1]:.1f}"/>'
        f'<path class="curve" d="{path}"/>{dots}'
        f'<text class="name" x="{(_LEFT + _WIDTH - _RIGHT) / 2}" y="{_HEIGHT - _BOTTOM + 31}" text-anchor="middle">'
        f"stress, of full scale{beneath} → (a linear sensor dashed)</text></svg>"
    )


def _place(
    x: NDArray[np.float64], y: NDArray[np.float64], most: float, top: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return (
        _LEFT + (_WIDTH - _LEFT - _RIGHT) * x / most,
        _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * y / top,
    )
