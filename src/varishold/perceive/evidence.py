"""The evidence of one touch: named numbers, from any hand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require, require_a
from varishold.frame.checks import as_positive, is_number
from varishold.perceive.grip import GRIP_SECTIONS, GripContacts, fit_ball_size, fit_section, grip_size
from varishold.touch.pads.surface import PadSurface, SurfaceName

__all__ = ["SIZE_PREFIX", "Evidence", "form_values", "grip_reasons", "grip_values", "pad_values", "switch_values"]

#: Numbers whose names begin so are logarithms of sizes and tell size; all others tell shape.
SIZE_PREFIX = "size."

# Fitted sizes are compared within this factor (logarithm) and growths within this range.
_MOST_RATIO, _MOST_GROWTH = 0.7, 1.5

# What a pad says: whether it is pressed, how curved the surface is (in parts of the gripped size), which surface it
# is, and where on the pad it lies.
_PAD_NUMBERS = ("on", "curve", "curve_up", "curved", "edge", "point", "x", "y", "area")
_MOST_LOG_RATIO = 8.0
_MOST_FORM = 5.0
_ROUND_OR_NOT: tuple[SurfaceName, ...] = ("flat", "curved", "edge")
# A gripped size outside of this, or an unknown one, is taken for the nearest, or for the usual one. Metres.
_LEAST_SIZE_M, _MOST_SIZE_M, _USUAL_SIZE_M = 0.03, 0.15, 0.07


@dataclass(frozen=True)
class Evidence:
    """What one touch said.

    Parameters
    ----------
    touch : str
        What was done, as "grasp" or "fingertip-edge": touches are compared with those of the same name.
    values : mapping of str to float
        Named numbers; NaN, or no entry, where something is unknown.
    remarks : tuple of str
        What was odd: missing or dead pads, a hand without coordinates.
    reasons : tuple of str
        What the numbers say, in words.
    failed : bool
        The touch was tried, and nothing was held or met: that says something too. It has no values then.
    seconds : float or None
        What it took the hand, from the end of the touch before; None where nobody looked at the clock.

    Raises
    ------
    InputError
        If the touch has no name, the values have none, a value is no number or infinite, or it took no time.
    """

    touch: str
    values: Mapping[str, float]
    remarks: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()
    failed: bool = False
    seconds: float | None = None

    def __post_init__(self) -> None:
        require(isinstance(self.touch, str) and self.touch.strip(), f"a touch needs a name, got {self.touch!r}")
        what = type(self.values).__name__
        require(isinstance(self.values, Mapping), f"values of touch {self.touch!r} must be numbers by name, got {what}")
        values = {}
        given: Mapping[Any, Any] = self.values
        for name, value in given.items():
            require(isinstance(name, str), f"values of touch {self.touch!r} must be numbers by name, got {name!r}")
            try:
                # What is on or off counts as 1 or 0; a text is no number, whatever stands in it.
                number = None if isinstance(value, str | bytes) else float(value)
            except (TypeError, ValueError, OverflowError):
                number = None
            if number is None:
                raise InputError(f"{name} of touch {self.touch!r} must be a number, got {value!r}")
            if np.isinf(number):
                raise InputError(f"{name} of touch {self.touch!r} must be finite, got {number}")
            values[name] = number
        flag = isinstance(self.failed, bool | np.bool_)
        require(flag, f"failed of touch {self.touch!r} must be True or False, got {self.failed!r}")
        empty = not any(np.isfinite(number) for number in values.values())
        require(
            empty or not self.failed, f"touch {self.touch!r} failed, so that it cannot have values; got {len(values)}"
        )
        for word in ("remarks", "reasons"):
            said = getattr(self, word)
            texts = isinstance(said, tuple | list) and all(isinstance(text, str) for text in said)
            got = "one text" if isinstance(said, str) else repr(said)[:40]
            require(texts, f"{word} of touch {self.touch!r} must be a tuple of texts, got {got}")
        object.__setattr__(self, "values", values)
        if self.seconds is not None:
            object.__setattr__(self, "seconds", as_positive(self.seconds, f"the seconds of touch {self.touch!r}"))

    def vector(self, names: Iterable[str]) -> NDArray[np.float64]:
        """Return the values of these names, NaN for those that are unknown; shape (n_names,)."""
        return np.array([self.values.get(name, np.nan) for name in names])


def switch_values(switches: Mapping[str, bool | None]) -> dict[str, float]:
    """Return on-off switches as evidence; None for one that is broken."""
    what = type(switches).__name__
    require(isinstance(switches, Mapping), f"switches must be True, False or None by name, got {what}")
    for name, on in switches.items():
        require(isinstance(name, str), f"switches must be True, False or None by name, got {name!r}")
        known = isinstance(on, bool | np.bool_) or (is_number(on) and (on in (0, 1) or on != on))
        require(on is None or known, f"switch {name!r} must be True, False or None, got {on!r}")
    return {f"switch.{name}": float("nan") if on is None else float(on) for name, on in switches.items()}


def grip_values(contacts: GripContacts | None) -> dict[str, float]:
    """Return how every section and a ball fit a grip: their misfits and forms, and their sizes.

    Parameters
    ----------
    contacts : GripContacts or None
        None, or fewer than three touched parts, gives nothing: what is missing does not count.
    """
    if contacts is None:
        return {}
    require_a(GripContacts, contacts, "contacts", "where a hand's parts touch")
    out: dict[str, float] = {"fit.parts": float(contacts.touched.sum())}
    for section in GRIP_SECTIONS:
        fit, grown = fit_section(contacts, section), fit_section(contacts, section, grows=True)
        if fit is None or grown is None:
            return {}
        own, own_grown = float(np.log(fit.size_m)), float(np.log(max(grown.size_m, 0.005)))
        # The circle is the first of the sections.
        circle_log = out.get(f"{SIZE_PREFIX}circle", own)
        out[f"fit.{section}.off"] = float(np.log1p(fit.cost))
        out[f"fit.{section}.growing.off"] = float(np.log1p(grown.cost))
        out[f"fit.{section}.growth"] = float(np.clip(grown.growth, -_MOST_GROWTH, _MOST_GROWTH))
        if section != "circle":
            out[f"fit.{section}.ratio"] = float(np.clip(own - circle_log, -_MOST_RATIO, _MOST_RATIO))
        out[f"fit.{section}.growing.ratio"] = float(np.clip(own_grown - circle_log, -_MOST_RATIO, _MOST_RATIO))
        out[f"{SIZE_PREFIX}{section}"] = own
        out[f"{SIZE_PREFIX}{section}.growing"] = own_grown
    ball = fit_ball_size(contacts)
    if ball is not None:
        size_m, cost = ball
        out["fit.ball.off"] = float(np.log1p(cost))
        out["fit.ball.ratio"] = float(np.clip(np.log(size_m) - circle_log, -_MOST_RATIO, _MOST_RATIO))
        out[f"{SIZE_PREFIX}ball"] = float(np.log(size_m))
    out["fit.least.off"] = min(value for name, value in out.items() if name.endswith(".off"))
    return out


def pad_values(name: str, surface: PadSurface | None, *, size_m: float | None = None) -> dict[str, float]:
    """Return what a pad says as evidence: likelihoods of surfaces, not a surface.

    Parameters
    ----------
    name : str
        Of the pad.
    surface : PadSurface or None
        From `feel_surface`; None where nothing presses. A pad that is missing or dead is left out altogether.
    size_m : float, optional
        The gripped size: curvatures are compared with it, so that a large cylinder feels like a small one. Metres.
    """
    require(isinstance(name, str), f"a pad needs a name, got {name!r}")
    require(size_m is None or is_number(size_m), f"size_m of a pad's object must be a number, got {size_m!r}")
    if surface is None:
        numbers = [0.0] * len(_PAD_NUMBERS)
    else:
        require_a(PadSurface, surface, f"surface of pad {name!r}", "as feel_surface returns it, or None")
        radius_m = float(np.clip(size_m or _USUAL_SIZE_M, _LEAST_SIZE_M, _MOST_SIZE_M)) / 2
        log = surface.by_name
        over_flat = (log["curved"] - log["flat"], log["edge"] - log["flat"], log["point"] - log["flat"])
        ratios = [float(np.clip(ratio, -_MOST_LOG_RATIO, _MOST_LOG_RATIO)) for ratio in over_flat]
        bends = [float(np.arcsinh(4 * bend * radius_m)) for bend in surface.curvature_1_m]
        place = [float(np.arcsinh(at / 0.01)) for at in surface.centre_m]
        numbers = [1.0, *bends, *ratios, *place, surface.area_share]
    return {f"pad.{name}.{key}": value for key, value in zip(_PAD_NUMBERS, numbers, strict=True)}


def form_values(
    contacts: GripContacts | None, surfaces: Mapping[str, PadSurface | None] | None = None
) -> dict[str, float]:
    """Return the few numbers that tell round from angular whatever the size: what two objects of one size can teach.

    Parameters
    ----------
    contacts : GripContacts or None
        How much better a circle fits the grip than a square, without any training.
    surfaces : mapping of str to PadSurface or None, optional
        How much likelier curved is than flat or edge, over all pressed pads and at the least one.
    """
    out: dict[str, float] = {}
    what = type(surfaces).__name__
    require(surfaces is None or isinstance(surfaces, Mapping), f"surfaces must be given by the pads' names, got {what}")
    for name, surface in (surfaces or {}).items():
        if surface is not None:
            require_a(PadSurface, surface, f"surface of pad {name!r}", "as feel_surface returns it, or None")
    size = None if contacts is None else grip_size(contacts)
    if size is not None:
        out["form.grip_round"] = float(np.arcsinh(size.pillar.cost - size.cylinder.cost))
    pressed = [surface.by_name for surface in (surfaces or {}).values() if surface is not None]
    if pressed:
        flat, curved, edge = (np.array([log[name] for log in pressed]) for name in _ROUND_OR_NOT)
        ratio = np.clip(curved - np.logaddexp(flat, edge) + np.log(2), -_MOST_FORM, _MOST_FORM)
        out["form.pads_round"] = float(np.arcsinh(ratio.sum()))
        out["form.least_round"] = float(ratio.min())
    return out


def grip_reasons(contacts: GripContacts | None) -> tuple[str, ...]:
    """Return in words what a grip alone says of size: as of a cylinder and of a square pillar."""
    size = None if contacts is None else grip_size(contacts)
    if contacts is None or size is None:
        return ()
    touched = contacts.on_object()
    if not touched.any():
        return ()
    words = [
        f"a {what} of {1e3 * fit.size_m:.0f} ± {1e3 * fit.sigma_m:.1f} mm leaves "
        f"{1e3 * float(np.sqrt((fit.off_m[touched] ** 2).mean())):.1f} mm"
        for what, fit in (("circle", size.cylinder), ("square", size.pillar))
    ]
    return (f"the grip alone: {words[0]}, {words[1]} between it and the touched parts",)
