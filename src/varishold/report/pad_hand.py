"""The pads of a hand unrolled: thumb, palm and fingers seen from inside, each pad with the surface that presses it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from varishold.hand import Hand, Layout, Switch
from varishold.hand.pads import PadFrames
from varishold.report.picture import png_data_uri
from varishold.report.quantities import percent
from varishold.touch import SURFACES, PadSurface

__all__ = ["SURFACE_COLOURS", "pad_hand", "tip_pad"]

#: Of each surface, on the dark pane.
SURFACE_COLOURS: dict[str, str] = dict(zip(SURFACES, ("#7fb2ff", "#f2c14e", "#ff7d5c", "#c995ff"), strict=True))

Frame = NDArray[np.float64]

_COLOURS = 96
_UNITS_PER_M = 3600.0
_GAP = 7.0
# Room under a pad for its bar and two lines.
_BELOW = 44.0
_BAR = 5.0
# Brightness is this power of the pressure, so that what is pressed lightly shows too.
_BRIGHTNESS = 0.7
_TIP_SIZE = (360.0, 300.0)


def pad_hand(
    pads: PadFrames,
    surfaces: Mapping[str, PadSurface | None],
    closed: Mapping[str, bool],
    design: Hand,
    layout: Layout,
) -> Markup:
    """Draw all pads in their places.

    Parameters
    ----------
    pads : PadFrames
    surfaces : mapping of str to PadSurface or None
        The surface under each pad; None where nothing presses it.
    closed : mapping of str to bool
        Switches by name.
    design : Hand
        Which digits there are.
    layout : Layout
        Where the switches are.
    """
    peak = max(float(frame.max()) for frame in pads.frames.values()) or 1.0
    thumbs, palm, fingers = (
        [row for row in ([part for part in parts if part in pads.frames] for parts in rows) if row]
        for rows in (
            [reversed(digit.parts) for digit in design.opposers],
            [["palm"]],
            [finger.parts for finger in design.fingers],
        )
    )
    groups = (_Group("thumb", thumbs, mirrored=True), _Group("palm", palm), _Group("fingers", fingers))
    pressed = [f"{name} {surface.name}" for name, surface in surfaces.items() if surface is not None]
    label = f"The pads of the hand; pressed: {', '.join(pressed) or 'none'}"
    drawn = "".join(_draw_group(group, pads, surfaces, closed, layout, peak) for group in groups if group.rows)
    return Markup(f'<div class="screen hand" role="img" aria-label="{escape(label)}">{drawn}</div>')


@dataclass(frozen=True)
class _Group:
    """Pads that stay together where a narrow window breaks the hand up: rows of names, from left to right."""

    name: str
    rows: list[list[str]]
    mirrored: bool = False


def _draw_group(
    group: _Group,
    pads: PadFrames,
    surfaces: Mapping[str, PadSurface | None],
    closed: Mapping[str, bool],
    layout: Layout,
    peak: float,
) -> str:
    """One group as an SVG of its own, whose width on the page is in proportion to its true one."""
    body, top, width = [], _GAP, 0.0
    for row in group.rows:
        left, deepest = _GAP, 0.0
        for name in row:
            wide, high = _size(pads.frames[name], pads.pitch_m[name])
            body.append(
                _pad(left, top, wide, high, pads.frames[name], peak, surfaces.get(name), mirrored=group.mirrored)
            )
            body += [
                _switch(switch, left, top, wide, high, bool(closed.get(switch.name)))
                for switch in layout.switches
                if switch.part == name
            ]
            left, deepest = left + wide + _GAP, max(deepest, high)
        top, width = top + deepest + _BELOW, max(width, left)
    return (
        f'<svg class="pads {group.name}" viewBox="0 0 {width:.0f} {top:.0f}" style="--w: {width:.0f}">'
        f"{''.join(body)}</svg>"
    )


def _switch(switch: Switch, left: float, top: float, wide: float, high: float, on: bool) -> str:
    x, y = left + wide - 8, top + 8
    if switch.part == "palm":
        x, y = left + wide / 2 + switch.y_m * _UNITS_PER_M, top + high / 2 - switch.z_m * _UNITS_PER_M
    return (
        f'<circle class="switch{" on" if on else ""}" cx="{x:.1f}" cy="{y:.1f}" r="4">'
        f"<title>switch {escape(switch.name)}: {'closed' if on else 'open'}</title></circle>"
    )


def tip_pad(frame: Frame, pitch_m: float, surface: PadSurface | None) -> Markup:
    """Draw the pad of a fingertip alone, as large as fits."""
    wide, high = _size(frame, pitch_m)
    scale = min((_TIP_SIZE[0] - 60) / wide, (_TIP_SIZE[1] - _BELOW - 60) / high)
    wide, high = wide * scale, high * scale
    x, y = (_TIP_SIZE[0] - wide) / 2, (_TIP_SIZE[1] - high - _BELOW) / 2
    body = _pad(x, y, wide, high, frame, float(frame.max()) or 1.0, surface, mirrored=False)
    what = "nothing" if surface is None else surface.name
    return Markup(
        f'<svg class="screen pads tip" viewBox="0 0 {_TIP_SIZE[0]:.0f} {_TIP_SIZE[1]:.0f}" role="img" '
        f'aria-label="The pad of the fingertip: {what}">{body}</svg>'
    )


def _size(frame: Frame, pitch_m: float) -> tuple[float, float]:
    rows, cols = frame.shape
    return cols * pitch_m * _UNITS_PER_M, rows * pitch_m * _UNITS_PER_M


def _pad(
    x: float,
    y: float,
    wide: float,
    high: float,
    frame: Frame,
    peak: float,
    surface: PadSurface | None,
    *,
    mirrored: bool,
) -> str:
    """One pad: taxels with height upward, and below it how likely each surface is."""
    box = f'x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}"'
    if not frame.any():
        return f'<rect class="idle" {box} rx="3"/>'
    seen = np.flipud(np.fliplr(frame) if mirrored else frame)
    uri = png_data_uri(np.clip(seen / peak, 0, 1) ** _BRIGHTNESS, _COLOURS)
    out = [f'<image {box} preserveAspectRatio="none" href="{uri}"/>', f'<rect class="rim" {box}/>']
    if surface is None:
        return "".join(out)
    left = x
    for name, p in zip(SURFACES, surface.posterior().tolist(), strict=True):
        out.append(
            f'<rect x="{left:.2f}" y="{y + high + 4:.1f}" width="{p * wide:.2f}" height="{_BAR}" '
            f'fill="{SURFACE_COLOURS[name]}"/>'
        )
        left += p * wide
    out.append(
        f'<text x="{x:.1f}" y="{y + high + 23:.1f}" style="fill:{SURFACE_COLOURS[surface.name]}">'
        f"{surface.name} {percent(round(surface.probability, 2))}</text>"
    )
    if surface.name == "curved" and surface.radius_m is not None:
        out.append(f'<text x="{x:.1f}" y="{y + high + 37:.1f}">r {1e3 * surface.radius_m:.0f}\u202fmm</text>')
    return "".join(out)
