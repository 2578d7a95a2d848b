"""The paper's four groups of function: points of contact or surface shape, without or with coordinates.

Section 3: "one type is to detect a point of contact with the surface of the object, another is to recognize the
surface shape of the object [...]. In the each case, a possibility of detecting a coordinate of the artificial
hand or finger must be included and the function [...] is classified into 4 groups."
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.hand.actions import Step
from varishold.hand.coordinates import contact_points, grip_circle
from varishold.hand.hand import Hand
from varishold.hand.layouts import Layout
from varishold.hand.pads import PadFrames, PadSetting
from varishold.skin import Skin

__all__ = ["FEATURE_GROUPS", "FeatureGroup", "Features", "features"]

#: The part of the peak above which a pad's frame is looked at: far above the taxels' noise.
_CUT = 0.4

#: What is flatter than this everywhere is flat; the taxels' noise curves more. 1/m.
_LEAST_CURVATURE = 0.5

#: A smaller gripped size is taken for this one, so that no coordinate grows without bound. Metres.
_LEAST_SIZE_M = 0.02


@dataclass(frozen=True)
class FeatureGroup:
    """One of the four groups.

    Parameters
    ----------
    name : str
    sense : {"contact", "surface"}
        On-off switches, or the shape of what presses each pad.
    coordinates : bool
        Whether the fingers' coordinates are known too.
    """

    name: str
    sense: Literal["contact", "surface"]
    coordinates: bool


#: The groups by name, in the paper's order.
FEATURE_GROUPS: dict[str, FeatureGroup] = {
    group.name: group
    for group in (
        FeatureGroup("contact", "contact", False),
        FeatureGroup("contact+coordinates", "contact", True),
        FeatureGroup("surface", "surface", False),
        FeatureGroup("surface+coordinates", "surface", True),
    )
}


@dataclass(frozen=True)
class Features:
    """One grasp as named numbers.

    Parameters
    ----------
    on_off : dict of str to bool
        Switches, by column name of a grasp table.
    analog : dict of str to float
        What a threshold has yet to make on-off: shapes and coordinates, without a unit or in metres.
    """

    on_off: dict[str, bool]
    analog: dict[str, float]


def features(step: Step, group: str, *, design: Hand, layout: Layout, skin: Skin | None = None) -> Features:
    """Describe the end of a step in one of the four groups.

    Parameters
    ----------
    step : Step
    group : str
        A key of `FEATURE_GROUPS`.
    design : Hand
    layout : Layout
    skin : Skin, optional
        The pads' skin; default: that of a `PadSetting`.

    Raises
    ------
    InputError
        If there is no such group, or surface shape is asked of a step without pad frames.
    """
    if group not in FEATURE_GROUPS:
        raise InputError(f"unknown feature group {group!r}; known are {', '.join(FEATURE_GROUPS)}")
    chosen = FEATURE_GROUPS[group]
    skin = skin or PadSetting().skin
    on_off: dict[str, bool] = {}
    analog: dict[str, float] = {}
    if chosen.sense == "contact":
        names = layout.names
        on_off = {f"switch.{n}": bool(v) for n, v in zip(names, step.sensed.switches, strict=True)}
    else:
        if step.pads is None:
            raise InputError("surface shape needs pad frames; give the setting pads")
        analog = _surface(step.pads, skin)
    if chosen.coordinates:
        analog |= _coordinates(step, design, layout, with_pads=chosen.sense == "surface")
    return Features(on_off, analog)


def _surface(pads: PadFrames, skin: Skin) -> dict[str, float]:
    """Extremes of the curvature (1/m) over the touched pads in decades, and how uneven it is in parts of itself.

    A cylinder is as curved wherever it is touched, whatever its size; a pillar is flat here and a corner there.
    Curvatures range from 1/m to hundreds, so that a threshold halfway between two examples is meant as their
    geometric mean.
    """
    bends = (_curvature(frame, pads.pitch_m[part], skin) for part, frame in pads.frames.items())
    felt = np.array([bend for bend in bends if bend is not None] or [0.0])
    largest = max(float(np.abs(felt).max()), _LEAST_CURVATURE)
    usual = max(float(np.abs(felt).mean()), _LEAST_CURVATURE)
    return {
        "surface.flattest": _decades(float(felt.min())),
        "surface.sharpest": _decades(float(felt.max())),
        "surface.range": float(felt.max() - felt.min()) / largest,
        "surface.spread": float(felt.std()) / usual,
    }


def _decades(curvature: float) -> float:
    return float(np.copysign(np.log10(1 + abs(curvature)), curvature))


def _curvature(frame: NDArray[np.float64], pitch_m: float, skin: Skin) -> float | None:
    """Curvature of the pressing surface along a pad's columns, 1/m; None where nothing presses.

    A thin layer's pressure is its stiffness times how deep the surface is pressed in, so that the surface's
    curvature is the pressure's second derivative: near 0 for a flat side, large for a corner, negative where a
    flat face's rim presses hardest.
    """
    # A phalanx lies across an upright object, so what tells forms apart runs along its columns.
    line = frame.mean(axis=0)
    top = int(line.argmax())
    if line[top] <= 0:
        return None
    first = last = top
    while first > 0 and line[first - 1] > _CUT * line[top]:
        first -= 1
    while last < line.size - 1 and line[last + 1] > _CUT * line[top]:
        last += 1
    if last - first < 2:
        first, last = max(0, top - 1), min(line.size - 1, top + 1)
    if last - first < 2:
        first, last = (0, 2) if first == 0 else (line.size - 3, line.size - 1)
    x = (np.arange(first, last + 1) - top) * pitch_m
    second = 2 * float(np.polyfit(x, line[first : last + 1], 2)[0])
    return -second / _stiffness(skin)


def _stiffness(skin: Skin) -> float:
    """Pressure over depth of a wide contact, Pa/m: the confined layer's modulus over its thickness."""
    nu, modulus = skin.poisson, skin.youngs_modulus_pa or 1.0
    return modulus * (1 - nu) / ((1 + nu) * (1 - 2 * min(nu, 0.49))) / (skin.thickness_m or 0.004)


def _coordinates(step: Step, design: Hand, layout: Layout, *, with_pads: bool) -> dict[str, float]:
    """How the touched phalanges lie about the circle that fits the grip best, scaled by its diameter.

    On a cylinder every phalanx lies against that circle, whatever its size and wherever along the phalanx it
    touches, and it touches where the circle's middle stands square to it. On a pillar's sides and corners they
    do not.
    """
    contacts = contact_points(step.sensed, design, layout, pads=step.pads if with_pads else None)
    off, beyond = dict.fromkeys(design.parts[:-1], 0.0), 0.0
    circle = grip_circle(contacts)
    if circle is not None:
        size = max(circle.diameter_m, _LEAST_SIZE_M)
        off |= {part: float(d) / size for part, d in zip(contacts.parts, np.abs(circle.off_m), strict=True)}
        slack = np.maximum(np.abs(circle.beside_m) - contacts.slack_m, 0.0)
        beyond = float(slack.max()) / size
    values = np.array(list(off.values()))
    return {
        **{f"coordinate.{joint}.off": value for joint, value in off.items()},
        "coordinate.off": float(np.sqrt((values**2).sum() / max(1, len(contacts.parts)))),
        "coordinate.beyond": beyond,
    }
