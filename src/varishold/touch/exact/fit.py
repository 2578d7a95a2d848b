"""Fitting one form to one frame through the skin: Levenberg-Marquardt with the gain profiled out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.errors import NotConvergedError
from varishold.skin.synthesis import Synthesis, Synthetic
from varishold.touch.exact.form import Form, Grid

__all__ = ["Fit", "Seen", "fit_form", "refine"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_MOST_STEPS = 8
_REFINING_STEPS = 5
# A step that lowers chi^2 by less, or by less than this share of it, decides nothing between forms.
_ENOUGH, _ENOUGH_SHARE = 0.3, 2e-3
# After so many steps a fit whose chi^2 is so many times another form's is given up; sooner for contacts of
# so many cells, whose factors take long.
_PATIENCE, _HOPELESS = 3, 8.0
_LARGE, _PATIENCE_LARGE = 600, 1
_DAMPING, _MOST_DAMPING = 1e-3, 10.0
# Longest step: taxels for lengths, radians for angles, a share for shares.
_LONGEST = {"yaw": 0.35, "top_share": 0.2, "steepness": 0.2}
_LONGEST_LENGTH = 1.5
# A frustum with a larger top is a pillar, with a smaller one a cone or pyramid.
_TOPS = (0.15, 0.8)
# Below, a sphere's face is a paraboloid; above, the deepest press that is still a cap.
_STEEPNESS = (0.02, 0.8)
_SMALLEST = 1.0


@dataclass(frozen=True)
class Seen:
    """What a form is fitted to: a window of taxels around a contact.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        The window, as a share of its peak.
    weight : ndarray of shape (rows, cols), float64
        1 / sigma_tot of each taxel; 0 where there is none.
    synthesis : Synthesis
        The skin's forward model over the window.
    grid : Grid
        Its cells, in taxels.
    fine, fine_grid
        The same on cells half as large.
    active : ndarray of shape (n_cells,), bool
        About the cells in contact.
    count : int
        Taxels that count.
    unit_m : float
        Side of a taxel, metres.
    """

    frame: Floats
    weight: Floats
    synthesis: Synthesis
    grid: Grid
    fine: Synthesis
    fine_grid: Grid
    active: Mask
    count: int
    unit_m: float


@dataclass(frozen=True)
class Fit:
    """A form fitted to a frame.

    Parameters
    ----------
    form : Form
    q : ndarray of shape (n_parameters,), float64
        Its parameters, by `form.names`; lengths in taxels from the window's centre.
    gain : float
        What the unit face's frame is multiplied by: modulus times depth over the frame's peak.
    chi2 : float
        Sum of squares of the weighted residuals.
    cost : float
        chi2 + n_parameters ln n_taxels.
    steps : int
        Steps taken.
    active : ndarray of shape (n_cells,), bool
        The cells in contact.
    """

    form: Form
    q: Floats
    gain: float
    chi2: float
    cost: float
    steps: int
    active: Mask


@dataclass(frozen=True)
class _Tried:
    q: Floats
    made: Synthetic
    model: Floats
    gain: float
    residual: Floats
    chi2: float


def fit_form(
    form: Form, start: Floats, seen: Seen, *, rival: float = np.inf, most_steps: int = _MOST_STEPS
) -> Fit | None:
    """Fit a form to a frame, or return None where it loses the contact at once.

    Parameters
    ----------
    form : Form
    start : ndarray of shape (n_parameters,), float64
        Where to begin.
    seen : Seen
    rival : float
        Chi^2 of the best form so far: what stays far above it need not be fitted to the end.
    most_steps : int
        Steps at most.

    Returns
    -------
    Fit or None

    References
    ----------
    L. Kaufman, "A variable projection method for solving separable nonlinear least squares problems",
    BIT 15, 1975.
    """
    now = _try(form, _bounded(form, start, seen), seen, seen.active)
    if now is None:
        return None
    damping, steps = _DAMPING, 0
    patience = _PATIENCE if np.count_nonzero(seen.active) <= _LARGE else _PATIENCE_LARGE
    while steps < most_steps and len(now.q):
        steps += 1
        q = _bounded(form, now.q + _step(form, now, seen, damping), seen)
        then = _try(form, q, seen, now.made.active)
        if then is None or then.chi2 >= now.chi2:
            damping = max(damping * 30, 1e-2)
            if damping > _MOST_DAMPING:
                break
            continue
        gained = now.chi2 - then.chi2
        now, damping = then, max(damping / 10, 1e-6)
        if gained < max(_ENOUGH, _ENOUGH_SHARE * now.chi2) or (steps >= patience and now.chi2 > _HOPELESS * rival):
            break
    return _fit(form, now, seen, steps)


def refine(fit: Fit, seen: Seen) -> Fit:
    """Fit again on a grid of half the cells' size, with the coarse grid's gradients.

    A coarse grid errs most under a wall, where the pressure has no bound: without this, a pillar's rim
    would be explained by a frustum's slope. A frame of the finer grid costs few steps of conjugate gradients
    from a pressure that is nearly right; only its gradients would cost more.

    Parameters
    ----------
    fit : Fit
    seen : Seen

    Returns
    -------
    Fit
    """
    form = fit.form
    coarse = _try(form, fit.q, seen, fit.active)
    if coarse is None:
        return fit
    now, pressure = _try_finely(form, coarse.q, coarse.made, seen, _halved(coarse.made.pressure, seen))
    damping, steps = _DAMPING, 0
    while steps < _REFINING_STEPS and len(fit.q):
        steps += 1
        q = _bounded(form, now.q + _step(form, now, seen, damping), seen)
        then, pressure = _try_finely(form, q, coarse.made, seen, pressure)
        if then.chi2 >= now.chi2:
            damping = max(damping * 30, 0.1)
            continue
        gained = now.chi2 - then.chi2
        now, damping = then, max(damping / 10, 1e-6)
        if gained < _ENOUGH:
            break
    return _fit(form, now, seen, fit.steps + steps)


def _fit(form: Form, tried: _Tried, seen: Seen, steps: int) -> Fit:
    cost = tried.chi2 + len(tried.q) * np.log(seen.count)
    return Fit(form, tried.q, tried.gain, tried.chi2, float(cost), steps, tried.made.active)


def _halved(pressure: Floats, seen: Seen) -> Floats:
    cells = seen.synthesis.cells
    square = pressure.reshape(cells.rows, cells.cols)
    return np.repeat(np.repeat(square, 2, axis=0), 2, axis=1).ravel()


def _try_finely(form: Form, q: Floats, made: Synthetic, seen: Seen, start: Floats) -> tuple[_Tried, Floats]:
    """Compare the finer grid's frame; `made` keeps the gradients. Also return the fine pressure."""
    pressure = seen.fine.pressure(form.face(q, seen.fine_grid), start=start)
    return _compared(q, made, seen.fine.sensed(pressure), seen), pressure


def _try(form: Form, q: Floats, seen: Seen, active: Mask) -> _Tried | None:
    try:
        made = seen.synthesis.frame(form.face(q, seen.grid), start=active)
    except NotConvergedError:
        return None
    return _compared(q, made, made.frame, seen) if np.any(made.frame * seen.weight) else None


def _compared(q: Floats, made: Synthetic, frame: Floats, seen: Seen) -> _Tried:
    model = frame * seen.weight
    data = seen.frame * seen.weight
    power = float(np.vdot(model, model))
    gain = max(float(np.vdot(model, data)) / power, 0.0) if power > 0 else 0.0
    residual = data - gain * model
    return _Tried(q, made, model, gain, residual, float(np.vdot(residual, residual)))


def _step(form: Form, now: _Tried, seen: Seen, damping: float) -> Floats:
    count = len(now.q)
    slope: Floats = (now.gain * now.made.gradient * seen.weight).reshape(count, -1)
    model = (now.made.frame * seen.weight).ravel()
    # What a change of the gain would do is none of the parameters' business.
    slope -= np.outer(slope @ model, model / float(model @ model))
    normal = slope @ slope.T
    scale = np.maximum(np.diag(normal), 1e-9 * max(float(np.diag(normal).max()), 1e-300))
    step: Floats = np.linalg.solve(normal + damping * np.diag(scale), slope @ now.residual.ravel()).astype(np.float64)
    longest = np.array([_LONGEST.get(name, _LONGEST_LENGTH) for name in form.names])
    too_long = float(np.max(np.abs(step) / longest))
    return step / max(too_long, 1.0)


def _bounded(form: Form, q: Floats, seen: Seen) -> Floats:
    out = np.array(q, dtype=np.float64)
    longest = 3.0 * max(seen.synthesis.shape)
    for i, name in enumerate(form.names):
        if name in ("length", "breadth", "diameter"):
            out[i] = min(max(out[i], _SMALLEST), longest)
        elif name == "top_share":
            out[i] = min(max(out[i], _TOPS[0]), _TOPS[1])
        elif name == "steepness":
            out[i] = min(max(out[i], _STEEPNESS[0]), _STEEPNESS[1])
    if form.key == "hip":
        length, breadth = form.names.index("length"), form.names.index("breadth")
        out[length] = max(out[length], out[breadth])
    return out
