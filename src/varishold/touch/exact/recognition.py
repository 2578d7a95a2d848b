"""Recognition by analysis by synthesis: which form, fitted through the skin, makes the frame best."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.levelset.contact import Contact
from varishold.skin import Relief, Skin
from varishold.touch.exact.fit import Fit, Seen, fit_form, refine
from varishold.touch.exact.form import Start
from varishold.touch.exact.forms import FITTED
from varishold.touch.exact.window import see
from varishold.touch.names import KINDS
from varishold.touch.recognizer import fills_evenly, recognize, surface_from
from varishold.touch.relief import relief_of
from varishold.touch.surface import Sides, Surface

__all__ = ["INDEPENDENT", "MISFIT", "FittedSurface", "recognize_exact"]

#: A frame's residuals count as so many numbers that err each for itself: what the skin's model, a gain or a bent
#: response gets wrong, it gets wrong in many taxels at once. Chosen on presses of other forms than the fitted ones.
INDEPENDENT = 8.0
#: Chi^2 a taxel beyond which even the best form does not fit, and the surface is unknown.
MISFIT = 12.0
# A fit's errors are at least this share of what is awaited (chi^2 a taxel).
_LEAST_ERROR = 0.1
# What lies beyond `MISFIT` counts for so much less than taxels' noise alone would.
_BEYOND_MISFIT = 4.0
# So many of the table's most probable kinds are fitted, and those easily taken for the first of them.
_MOST_PROBABLE = 3
_MOST_FITTED = 6
# Of contacts of more cells, whose factors take long, fewer kinds: most of them are flat and leave the field.
_LARGE, _MOST_FITTED_LARGE = 600, 4
# Fits within this factor of the best one's chi^2, at most so many, are refined on a finer grid.
_IN_REACH = 3.0
_MOST_REFINED = 3
# Kinds that a skin makes alike.
_ALIKE: tuple[tuple[str, ...], ...] = (
    ("cylinder", "cone-frustum", "sphere", "cone"),
    ("square-pillar", "pyramid-frustum", "pyramid"),
    ("ridge", "hip", "lying-cylinder", "rectangular-pillar"),
    ("edge", "plane", "wedge", "lying-cylinder"),
)
# What holds 90 % of true sizes, in taxels: a tenth where the skin is just as it is said to be, and what another solver
# of the same skin makes of it.
_OFF_ELSE = 0.3
_OFF_TAXELS = {"ridge": 0.5, "hip": 0.5, "lying cylinder": 1.2}
_KEYS = [kind.key for kind in KINDS]
_STRANGER = _KEYS.index("stranger")
_LEAST = 1e-12


@dataclass(frozen=True)
class FittedSurface(Surface):
    """A surface whose forms were fitted through the skin.

    Parameters
    ----------
    fits : dict of str to Fit
        The best fit of each kind that was tried, by its key, best first.
    count : int
        Taxels that were fitted.
    centre : (float, float)
        Centre (x, y) of the fitted window, metres from the pad's centre.
    unit : float
        Side of a fitted taxel, metres: the unit of the fits' lengths.
    reach : float
        Half the breadth of the contact under the best fit, in the fits' unit.
    depth_m : float or None
        Depth of the best fit, metres, where the skin's modulus is known and the frame is in pascal.
    """

    fits: dict[str, Fit]
    count: int
    centre: tuple[float, float]
    unit: float
    reach: float
    depth_m: float | None

    @cached_property
    def reasons(self) -> tuple[str, ...]:
        """What was fitted and how well, then what was measured."""
        return (*_told(self), *super().reasons)

    @cached_property
    def size(self) -> tuple[float, float]:
        """Lengths (long, short) of the best fit, where it is of the kind that the surface is called."""
        return self._fitted_size or super().size

    @property
    def radius_m(self) -> float | None:
        """Radius of curvature, metres, of a fitted sphere or lying cylinder whose depth is known.

        The circle through the form's top and its end. Of a paraboloid, fitted for a circle, that is where the contact
        ends: farther down the two part, and nothing there was felt.
        """
        key = self._fitted_key
        if self.depth_m is None or key not in ("sphere", "lying-cylinder"):
            return None
        fitted = self.fitted
        half = 0.5 * fitted["diameter_m" if key == "sphere" else "breadth_m"]
        chord = half if "steepness" in fitted else min(self.unit * self.reach, half)
        drop = self.depth_m * (chord / half) ** 2
        return (chord * chord + drop * drop) / (2 * drop) if drop > 0 else None

    @property
    def _fitted_key(self) -> str | None:
        """The kind of the best fit, where the surface is called by it."""
        key = next(iter(self.fits), None)
        return key if key is not None and KINDS[_KEYS.index(key)].name == self.name else None

    @cached_property
    def _fitted_size(self) -> tuple[float, float] | None:
        if self._fitted_key is None:
            return None
        fitted = self.fitted
        share = fitted.get("top_share", 1.0)
        if "diameter_m" in fitted:
            return share * fitted["diameter_m"], share * fitted["diameter_m"]
        if "breadth_m" not in fitted or self._fitted_key == "wedge":
            return None
        breadth, length = share * fitted["breadth_m"], fitted.get("length_m", share * fitted["breadth_m"])
        return max(length, breadth), min(length, breadth)

    def size_interval_of(self, *, height_map: bool) -> Sides:
        """Return the intervals of both sides; those of a fitted form by what fits of drawn presses are off."""
        if self._fitted_size is None:
            return super().size_interval_of(height_map=height_map)
        half = self.unit * _OFF_TAXELS.get(self.name, _OFF_ELSE)
        long, short = self._fitted_size
        return (max(long - half, 0.0), long + half), (max(short - half, 0.0), short + half)

    @property
    def fitted(self) -> dict[str, float]:
        """Parameters of the best fit in metres and radians, x and y from the pad's centre; a share as it is."""
        fit = next(iter(self.fits.values()))
        out = {}
        for name, value in zip(fit.form.names, fit.q.tolist(), strict=True):
            if name == "yaw":
                out["yaw_rad"] = (value + math.pi / 2) % math.pi - math.pi / 2
            elif name in ("top_share", "steepness"):
                out[name] = value
            elif name in ("x", "y"):
                out[f"{name}_m"] = value * self.unit + self.centre["xy".index(name)]
            else:
                out[f"{name}_m"] = value * self.unit
        return out


def recognize_exact(
    contact: Contact,
    skin: Skin,
    *,
    relief: Relief | None = None,
    pascal: float | None = None,
    among: Collection[str] | None = None,
) -> FittedSurface:
    """Say what surface a contact is by fitting forms to it through the skin.

    The learned table names the forms that are worth it. Each is fitted: its pressure on the skin is solved
    for, transmitted to the taxels and compared with the frame. Forms compete by
    ``|residual / sigma_tot|^2 + n_parameters ln n_taxels``, which counts as of `INDEPENDENT` numbers whose errors' size
    is not known, beside what the table says.

    Parameters
    ----------
    contact : Contact
        From `find_contacts`, with its pitch.
    skin : Skin
        The skin over the taxels.
    relief : Relief, optional
        The reconstructed surface under the contact, from `varishold.touch.relief.relief_of`.
    pascal : float, optional
        What one unit of the frame is in pascal; with the skin's modulus the depth can be told.
    among : collection of str, optional
        The only names that can occur here.

    Returns
    -------
    FittedSurface

    Raises
    ------
    InputError
        If the contact's pitch is unknown.
    """
    if contact.pitch is None:
        raise InputError("fitting through a skin needs the contact's pitch; give it to find_contacts")
    if relief is None:
        relief = relief_of(contact, skin)
    table = recognize(contact, relief=relief, among=among)
    seen, start, centre = see(contact, relief, skin)
    # No outline, no flank: every solid larger than the pad fits such a frame, and the table has named it.
    fits = {} if fills_evenly(contact) else _fits(table.kind_probability, seen, start)
    # How far a face that leaves the pad all around goes on, and the skin with it, decides what its middle looks like.
    logits = _logits(table.kind_probability, {} if all(contact.borders) else fits, seen.count)
    named = surface_from(contact, table.inputs, logits, table.parameters)
    depth = None
    if fits and pascal is not None and skin.youngs_modulus_pa is not None:
        depth = next(iter(fits.values())).gain * contact.peak * pascal / skin.contact_modulus
    return FittedSurface(
        **{field.name: getattr(named, field.name) for field in fields(named)},
        fits=fits,
        count=seen.count,
        centre=centre,
        unit=seen.unit_m,
        reach=_reach(next(iter(fits.values())), seen) if fits else 0.0,
        depth_m=depth,
    )


def _reach(fit: Fit, seen: Seen) -> float:
    """Return half the breadth of the contact under a fit: of a long one across it, of a round one its radius."""
    grid = seen.grid
    if "yaw" not in fit.form.names:
        return math.sqrt(np.count_nonzero(fit.active) * grid.width * grid.height / math.pi)
    yaw = float(fit.q[fit.form.names.index("yaw")])
    across = math.cos(yaw) * grid.y[fit.active] - math.sin(yaw) * grid.x[fit.active]
    return math.sqrt(3) * float(across.std())


def _candidates(probability: NDArray[np.float64], cells: int) -> list[str]:
    ranked = [_KEYS[i] for i in np.argsort(-probability, kind="stable") if _KEYS[i] in FITTED and probability[i] > 0]
    chosen = ranked[:_MOST_PROBABLE]
    if ranked:
        alike = {key for group in _ALIKE if ranked[0] in group for key in group}
        chosen += [key for key in ranked[_MOST_PROBABLE:] if key in alike]
    return chosen[: _MOST_FITTED if cells <= _LARGE else _MOST_FITTED_LARGE]


def _fits(probability: NDArray[np.float64], seen: Seen, start: Start) -> dict[str, Fit]:
    found: dict[str, Fit] = {}
    for key in _candidates(probability, int(np.count_nonzero(seen.active))):
        for form in FITTED[key]:
            # What is no better than the noise is no rival: it would end fits that are still on their way.
            rival = max(min((fit.chi2 for fit in found.values()), default=math.inf), seen.count)
            fit = fit_form(form, form.start(start), seen, rival=rival)
            if fit is not None and _stands(fit, seen) and (key not in found or fit.cost < found[key].cost):
                found[key] = fit
    return _refined(found, seen)


def _stands(fit: Fit, seen: Seen) -> bool:
    rows, cols = seen.synthesis.shape
    grid = seen.grid
    n = seen.synthesis.per_taxel
    return fit.form.possible(fit.q, cols * n * grid.width, rows * n * grid.height)


def _refined(found: dict[str, Fit], seen: Seen) -> dict[str, Fit]:
    """Refine the fits that the finer grid could still put first, and return all of them, best first."""
    ranked = sorted(found.items(), key=lambda item: item[1].cost)
    if not ranked:
        return {}
    near = _IN_REACH * max(ranked[0][1].chi2, seen.count)
    contenders = [key for key, fit in ranked if fit.chi2 <= near][:_MOST_REFINED]
    if len(contenders) > 1:
        found = found | {key: refine(found[key], seen) for key in contenders}
    return dict(sorted(found.items(), key=lambda item: item[1].cost))


def _logits(table: NDArray[np.float64], fits: dict[str, Fit], count: int) -> NDArray[np.float64]:
    """Share the table's probability of the fitted kinds among them by their costs; leave the others theirs."""
    logs: NDArray[np.float64] = np.log(np.maximum(table, _LEAST))
    if not fits:
        return logs
    index = np.array([_KEYS.index(key) for key in fits])
    cost = np.array([fit.cost for fit in fits.values()])
    mass = float(table[index].sum())
    best = min(fit.chi2 for fit in fits.values())
    # How large the errors are, the best fit itself tells (Student's t).
    share = logs[index] - 0.5 * INDEPENDENT * np.log1p((cost - cost.min()) / max(best, _LEAST_ERROR * count))
    share -= share.max()
    share -= math.log(float(np.exp(share).sum()))
    beyond = best - MISFIT * count
    kept = 0.0 if beyond <= 0 else -beyond / _BEYOND_MISFIT
    logs[index] = math.log(max(mass, _LEAST)) + kept + share
    logs[_STRANGER] = math.log(max(float(table[_STRANGER]) - mass * math.expm1(kept), _LEAST))
    return logs


def _told(surface: FittedSurface) -> list[str]:
    if not surface.fits:
        return ["no form could be fitted through the skin"]
    ranked = list(surface.fits.items())
    key, best = ranked[0]
    level = best.chi2 / surface.count
    verdict = "" if level <= MISFIT else f", beyond {MISFIT:g}: no known form"
    said = [
        f"fitted through the skin as {key.replace('-', ' ')}: chi^2 {level:.2f} a taxel "
        f"over {counted(surface.count, 'taxel')}{verdict}"
    ]
    sizes = ", ".join(f"{name} {value:.4g}" for name, value in surface.fitted.items())
    depth = "" if surface.depth_m is None else f", depth_m {surface.depth_m:.4g}"
    if sizes or depth:
        said.append(f"its parameters: {(sizes + depth).removeprefix(', ')}")
    if len(ranked) > 1:
        rival, second = ranked[1]
        said.append(f"next best {rival.replace('-', ' ')}: cost {second.cost:.0f} against {best.cost:.0f}")
    return said
