"""The pads of a hand unrolled: thumb, palm and fingers seen from inside, each pad with the surface that presses it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from varishold.hand import FINGERS, PHALANGES, Layout, PadFrames
from varishold.perceive import SURFACES, PadSurface
from varishold.report.colours import palette
from varishold.report.picture import png_data_uri
from varishold.report.quantities import percent

__all__ = ["SURFACE_COLOURS", "pad_hand", "tip_pad"]

#: Of each surface, on the dark pane.
SURFACE_COLOURS: dict[str, str] = dict(zip(SURFACES, ("#7fb2ff", "#f2c14e", "#ff7d5c", "#c995ff"), strict=True))

Frame = NDArray[np.float64]

_COLOURS = 96
_UNITS_PER_M = 3600.0
_GAP, _EDGE = 7.0, 16.0
# Room under a pad for its bar and two lines.
_BELOW = 44.0
_BAR = 5.0
_TIP_SIZE = (360.0, 300.0)


def pad_hand(
    pads: PadFrames, surfaces: Mapping[str, PadSurface | None], closed: Mapping[str, bool], layout: Layout
) -> Markup:
    """Draw all pads in their places.

    Parameters
    ----------
    pads : PadFrames
    surfaces : mapping of str to PadSurface or None
        The surface under each pad; None where nothing presses it.
    closed : mapping of str to bool
        Switches by name.
    layout : Layout
        Where the switches are.
    """
    size = {name: _size(frame, pads.pitch_m[name]) for name, frame in pads.frames.items()}
    digits = {digit: [f"{digit}.{phalanx}" for phalanx in PHALANGES] for digit in ("thumb", *FINGERS)}
    lengths = {d: sum(size[p][0] for p in parts) + _GAP * (len(parts) - 1) for d, parts in digits.items()}
    rows = [max(size[p][1] for p in digits[finger]) + _BELOW for finger in FINGERS]
    height = max(sum(rows), size["palm"][1] + _BELOW) + 2 * _EDGE
    palm_left = _EDGE + lengths["thumb"] + 2 * _GAP
    width = palm_left + size["palm"][0] + 2 * _GAP + max(lengths[finger] for finger in FINGERS) + _EDGE
    peak = max(float(frame.max()) for frame in pads.frames.values()) or 1.0
    places = {"palm": (palm_left, (height - size["palm"][1] - _BELOW) / 2 + _EDGE / 2)}
    top = (height - sum(rows)) / 2 + _EDGE / 2
    for finger, row in zip(FINGERS, rows, strict=True):
        left = palm_left + size["palm"][0] + 2 * _GAP
        for part in digits[finger]:
            places[part] = (left, top)
            left += size[part][0] + _GAP
        top += row
    left = _EDGE + lengths["thumb"]
    for part in digits["thumb"]:
        left -= size[part][0]
        places[part] = (left, (height - size[part][1] - _BELOW) / 2 + _EDGE / 2)
        left -= _GAP
    body = []
    for name, (x, y) in places.items():
        away = name.startswith("thumb")
        body.append(_pad(x, y, *size[name], pads.frames[name], peak, surfaces.get(name), mirrored=away))
    for switch in layout.switches:
        x, y = places[switch.part]
        wide, high = size[switch.part]
        if switch.part == "palm":
            x, y = x + wide / 2 + switch.y_m * _UNITS_PER_M, y + high / 2 - switch.z_m * _UNITS_PER_M
        else:
            x, y = x + wide - 8, y + 8
        on = bool(closed.get(switch.name))
        body.append(
            f'<circle class="switch{" on" if on else ""}" cx="{x:.1f}" cy="{y:.1f}" r="4">'
            f"<title>switch {escape(switch.name)}: {'closed' if on else 'open'}</title></circle>"
        )
    pressed = [f"{name} {surface.name}" for name, surface in surfaces.items() if surface is not None]
    label = f"The pads of the hand; pressed: {', '.join(pressed) or 'none'}"
    return Markup(
        f'<svg class="screen pads" viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="{escape(label)}">'
        f"{''.join(body)}</svg>"
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
    # The square root shows what is pressed lightly too.
    index = np.round(np.sqrt(np.clip(seen / peak, 0, 1)) * (_COLOURS - 1)).astype(np.uint8)
    uri = png_data_uri(index, palette(_COLOURS))
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
