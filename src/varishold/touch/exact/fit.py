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
_REFINING_STEPS = 3
# A step that lowers the cost by less decides nothing between forms.
_ENOUGH = 0.3
_DAMPING, _MOST_DAMPING = 1e-3, 1e3
# Longest step: taxels for lengths, radians for angles, a share for shares.
_LONGEST = {"yaw": 0.35, "top_share": 0.2, "steepness": 0.2}
_LONGEST_LENGTH = 1.5
# A frustum with a larger top is a pillar, with a smaller one a cone or pyramid.
_TOPS = (0.15, 0.75)
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
    """

    frame: Floats
    weight: Floats
    synthesis: Synthesis
    grid: Grid
    fine: Synthesis
    fine_grid: Grid
    active: Mask
    count: int


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


def fit_form(form: Form, start: Floats, seen: Seen, *, most_steps: int = _MOST_STEPS) -> Fit | None:
    """Fit a form to a frame, or return None where it loses the contact at once.

    Parameters
    ----------
    form : Form
    start : ndarray of shape (n_parameters,), float64
        Where to begin.
    seen : Seen
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
    found = _descend(form, _try(form, _bounded(form, start, seen), seen, seen.active), seen, most_steps)
    return None if found is None else _fit(form, found[0], seen, found[1])


def refine(fit: Fit, seen: Seen) -> Fit:
    """Fit again with what a finer grid says of the coarse one's error.

    A coarse grid errs most under a wall, where the pressure has no bound: without this, a pillar's rim
    would be explained by a frustum's slope. The error is taken at the first fit and kept while the
    parameters settle; the cost is that of the finer grid at the end.

    Parameters
    ----------
    fit : Fit
    seen : Seen

    Returns
    -------
    Fit
    """
    form = fit.form
    now = _try(form, fit.q, seen, fit.active)
    if now is None:
        return fit
    pressure = _halved(now.made.pressure, seen)
    error, pressure = _error(form, now, seen, pressure)
    found = _descend(form, _try(form, fit.q, seen, now.made.active, error), seen, _REFINING_STEPS, error)
    if found is None:
        return fit
    then, steps = found
    if len(fit.q):
        error, _ = _error(form, then, seen, pressure)
        last = _try(form, then.q, seen, then.made.active, error)
        then = then if last is None else last
    return _fit(form, then, seen, fit.steps + steps)


def _fit(form: Form, tried: _Tried, seen: Seen, steps: int) -> Fit:
    cost = tried.chi2 + len(tried.q) * np.log(seen.count)
    return Fit(form, tried.q, tried.gain, tried.chi2, float(cost), steps, tried.made.active)


def _halved(pressure: Floats, seen: Seen) -> Floats:
    cells = seen.synthesis.cells
    square = pressure.reshape(cells.rows, cells.cols)
    return np.repeat(np.repeat(square, 2, axis=0), 2, axis=1).ravel()


def _error(form: Form, tried: _Tried, seen: Seen, start: Floats) -> tuple[Floats, Floats]:
    """Return what the coarse frame lacks, and the fine pressure that tells it."""
    pressure = seen.fine.pressure(form.face(tried.q, seen.fine_grid), start=start)
    return seen.fine.sensed(pressure) - tried.made.frame, pressure


def _descend(
    form: Form, first: _Tried | None, seen: Seen, most_steps: int, error: Floats | float = 0.0
) -> tuple[_Tried, int] | None:
    if first is None:
        return None
    now, damping, steps = first, _DAMPING, 0
    while steps < most_steps and len(now.q):
        steps += 1
        q = _bounded(form, now.q + _step(form, now, seen, damping), seen)
        then = _try(form, q, seen, now.made.active, error)
        if then is None or then.chi2 >= now.chi2:
            damping = max(damping * 10, 1e-2)
            if damping > _MOST_DAMPING:
                break
            continue
        gained = now.chi2 - then.chi2
        now, damping = then, max(damping / 10, 1e-6)
        if gained < _ENOUGH:
            break
    return now, steps


def _try(form: Form, q: Floats, seen: Seen, active: Mask, error: Floats | float = 0.0) -> _Tried | None:
    try:
        made = seen.synthesis.frame(form.face(q, seen.grid), start=active)
    except NotConvergedError:
        return None
    model = (made.frame + error) * seen.weight
    data = seen.frame * seen.weight
    power = float(np.vdot(model, model))
    if not power > 0:
        return None
    gain = max(float(np.vdot(model, data)) / power, 0.0)
    residual = data - gain * model
    return _Tried(q, made, model, gain, residual, float(np.vdot(residual, residual)))


def _step(form: Form, now: _Tried, seen: Seen, damping: float) -> Floats:
    count = len(now.q)
    slope: Floats = (now.gain * now.made.gradient * seen.weight).reshape(count, -1)
    model = now.model.ravel()
    # What a change of the gain would do is none of the parameters' business.
    slope -= np.outer(slope @ model, model / float(model @ model))
    normal = slope @ slope.T
    scale = np.maximum(np.diag(normal), 1e-9 * max(float(np.diag(normal).max()), 1e-300))
    step: Floats = np.linalg.solve(normal + damping * np.diag(scale), slope @ now.residual.ravel()).astype(np.float64)
    longest = np.array([_LONGEST.get(name, _LONGEST_LENGTH) for name in form.names])
    too_long = float(np.max(np.abs(step) / longest))
    out: Floats = step / max(too_long, 1.0)
    return out


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
