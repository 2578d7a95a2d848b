"""What the simulated hand felt, as evidence: the only place that knows both the hand and the perceiver."""

from __future__ import annotations

import numpy as np

from varishold.exploration.touches import TouchPlan
from varishold.hand import HandDesign, HandSetting, Layout, PadFrames, PadSetting, Sensed, phalanges
from varishold.perceive import (
    Evidence,
    GripContacts,
    fit_section,
    form_values,
    grip_reasons,
    grip_values,
    pad_values,
    switch_values,
)
from varishold.touch import PadSurface, feel_surface

__all__ = ["evidence_of", "grip_contacts"]


def grip_contacts(sensed: Sensed, design: HandDesign, layout: Layout) -> GripContacts:
    """Return every phalanx, and every button of the palm, as a capsule in the palm's frame."""
    place = phalanges(sensed.angles_rad, design)
    closed = {switch.part for switch, on in zip(layout.switches, sensed.switches, strict=True) if on}
    buttons = [
        (f"palm.{switch.name}", -design.button_radius_m, switch.y_m, switch.z_m, on)
        for switch, on in zip(layout.switches, sensed.switches, strict=True)
        if switch.part == "palm"
    ]
    button_m = np.array([place for _, *place, _ in buttons]).reshape(-1, 3)
    radius = np.concatenate([place.radius_m, np.full(len(buttons), design.button_radius_m)])
    half_height = radius.copy()
    half_height[: len(place.parts)] += [design.digit_of[part].breadth_m / 2 for part in place.parts]
    return GripContacts(
        (*place.parts, *(name for name, *_ in buttons)),
        np.vstack([place.start_m, button_m]),
        np.vstack([place.start_m + place.length_m[:, None] * place.along, button_m]),
        radius,
        np.array([part in closed for part in place.parts] + [bool(on) for *_, on in buttons]),
        half_height,
    )


# The height of a fingertip that met nothing: below every object.
_NOTHING_M = -0.1


def feel_pads(
    pads: PadFrames, setting: PadSetting, *, only: tuple[str, ...] | None = None
) -> dict[str, PadSurface | None]:
    """Return the surface under each pad; None where nothing presses it. A pad with a value that is none is left out."""
    return {
        name: None if not frame.any() else feel_surface(frame, setting.skin, pitch_m=pads.pitch_m[name])
        for name, frame in pads.frames.items()
        if (only is None or name in only) and np.isfinite(frame).all()
    }


def evidence_of(
    plan: TouchPlan,
    sensed: Sensed,
    pads: PadFrames | None,
    setting: HandSetting,
    *,
    height_m: float | None = None,
) -> tuple[Evidence, dict[str, PadSurface | None]]:
    """Return what a touch felt as evidence, and the surface under each pad.

    Parameters
    ----------
    plan : TouchPlan
    sensed : Sensed
    pads : PadFrames or None
    setting : HandSetting
    height_m : float or None
        Of a fingertip: where it came to rest; None where it met nothing. Metres.
    """
    pad_setting = setting.pads or PadSetting()
    values: dict[str, float] = {}
    reasons: tuple[str, ...] = ()
    if plan.kind == "fingertip":
        surfaces = {} if pads is None else feel_pads(pads, pad_setting, only=(setting.design.tip,))
        values = {
            "tip.touched": float(height_m is not None),
            "tip.height": _NOTHING_M if height_m is None else height_m,
        }
        size_m = None
    else:
        contacts = grip_contacts(sensed, setting.design, setting.layout)
        values = grip_values(contacts)
        reasons = grip_reasons(contacts)
        values |= switch_values(dict(zip(setting.layout.names, sensed.switches.tolist(), strict=True)))
        round_ = fit_section(contacts, "circle")
        size_m = None if round_ is None else round_.size_m
        surfaces = {} if pads is None else feel_pads(pads, pad_setting)
        values |= form_values(contacts, surfaces)
    for name, surface in surfaces.items():
        values |= pad_values(name, surface, size_m=size_m)
    remarks = []
    wanted = (setting.design.tip,) if plan.kind == "fingertip" else setting.design.parts
    missing = [name for name in wanted if name not in surfaces]
    if missing:
        which = "all pads" if len(missing) == len(wanted) else f"pad {', '.join(missing)}"
        remarks.append(f"{plan.name}: nothing is known of {which}")
    if plan.kind != "fingertip" and not any(name.startswith("fit.") for name in values):
        remarks.append(f"{plan.name}: fewer than three parts touch, so that no section can be fitted")
    return Evidence(plan.name, values, tuple(remarks), reasons), surfaces
