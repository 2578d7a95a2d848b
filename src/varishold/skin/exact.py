"""Analysis by synthesis: each form fitted to a frame through the skin."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.skin.contact import contact_box, partial_springs, solve_contact
from varishold.skin.face import Face
from varishold.skin.forms import FORMS, Form, Hint
from varishold.skin.influence import influence_of
from varishold.skin.media import Cells, Medium, medium_of
from varishold.skin.properties import Skin
from varishold.skin.reconstruction import Relief, reconstruct
from varishold.skin.transmission import Transmission

__all__ = ["FormFit", "fit_forms", "hint_of"]

Floats = NDArray[np.float64]
Floating = NDArray[np.floating[Any]]

# Solver cells along each side of a taxel, so that pads of few taxels are still resolved.
_CELLS_ALONG = 64
# All forms are pressed this deep; the gain stands for the true depth.
_DEPTH = 1e-3
# What the forward model misses (grid, friction, large strain, a skin file that is a little wrong), as a share
# of the frame's peak; along the pad's border, where the skin may end or go on, it is known least.
_MODEL_ERROR, _BORDER_ERROR = 0.02, 0.1
_BORDER_TAXELS = 2
# A trial's contact, and its derivative, need no better than these shares.
_PRESS_TOLERANCE, _DERIVATIVE_TOLERANCE = 3e-4, 3e-2
_DERIVATIVE_STEPS = 12
_MOST_STEPS = 12
# A step that gains less than this share of the cost is the last one.
_LEAST_GAIN = 3e-3
# Forms that cost so many times the best one's after their first steps are not pursued.
_HOPELESS, _FIRST_STEPS = 3.0, 3
# Parameters are moved by these for derivatives of the face, which costs no press.
_NUDGE = 1e-4


@dataclass(frozen=True)
class FormFit:
    """A form fitted to a frame.

    Parameters
    ----------
    solid : str
        Name of the form's solid in `varishold.solids.SOLIDS`.
    parameters : dict of str to float
        Pose and lateral sizes: `x_m`, `y_m`, `yaw_rad` and what the form has of `radius_m`, `length_m`,
        `breadth_m` and `fall_m` (the length over which the face falls by the depth).
    depth : float
        Depth of the press: metres where the skin's modulus is known and the frame is in pascal, else in the
        frame's unit times metres.
    misfit : float
        Mean square of the frame's difference from the model, in units of noise and model error.
    cost : float
        Sum of those squares plus the number of parameters times ln n: lower is better, and half a difference
        is the logarithm of the odds.
    frame : ndarray of shape (rows, cols), float64
        The frame as the model has it.
    steps : int
        Steps of the fit.
    """

    solid: str
    parameters: dict[str, float]
    depth: float
    misfit: float
    cost: float
    frame: Floats
    steps: int


def fit_forms(
    frame: ArrayLike,
    skin: Skin,
    *,
    pitch: float | tuple[float, float],
    forms: Iterable[str] | None = None,
    noise: float | None = None,
    relief: Relief | None = None,
) -> list[FormFit]:
    """Fit forms to a frame through the skin, best first.

    For each form with parameters q the pressure p(q) solves the contact problem, and the frame is g B T p(q)
    with a free gain g. Gauss-Newton steps with damping use exact derivatives: on the contact,
    G dp = d(depth + h_q).

    Parameters
    ----------
    frame : array_like of shape (rows, cols)
        Stress over each taxel, zero where nothing touches.
    skin, pitch
        As for `reconstruct`.
    forms : iterable of str, optional
        Names in `FORMS`; default: all.
    noise : float, optional
        Standard deviation of the frame's noise; default: estimated.
    relief : Relief, optional
        What `reconstruct` gave for the frame, where it is known already.

    Returns
    -------
    list of FormFit
        One a form, by rising cost; forms that were soon hopeless stand with the cost they had.

    Raises
    ------
    InputError
        If a form is unknown, or the frame cannot be reconstructed.

    Examples
    --------
    >>> from varishold.skin import press, sense
    >>> from varishold.solids import Cone
    >>> skin = Skin("layer", 6e-3, 0.45, 1e-3)
    >>> frame = sense(press(Cone(40e-3, 6e-3), skin, depth=1.5e-3, shape=(16, 16), pitch=2e-3))
    >>> fit_forms(frame, skin, pitch=2e-3, forms=["sphere", "cone"])[0].solid
    'cone'
    """
    names = list(FORMS) if forms is None else list(forms)
    for name in names:
        if name not in FORMS:
            raise InputError(f"cannot fit a {name!r}; known are {', '.join(FORMS)}")
    seen = reconstruct(frame, skin, pitch=pitch, noise=noise) if relief is None else relief
    given = np.asarray(frame, dtype=np.float64)
    if noise is None:
        # Compiled code: whoever only presses need not wait for it.
        from varishold.recording import frame_noise

        noise = float(frame_noise(given))
    rows, cols = given.shape
    row_m, col_m = (side * seen.per_taxel for side in seen.pitch_m)
    model = _model(skin, rows, cols, row_m, col_m)
    scale = float(given.max())
    weight = 1.0 / np.hypot(noise / scale, _model_error(rows, cols))
    hint = hint_of(seen)
    searches = [_Search(name, FORMS[name], model, given / scale, weight, hint) for name in names]
    for search in searches:
        search.run(_FIRST_STEPS)
    best = min((search.cost for search in searches), default=0.0)
    for search in searches:
        if search.cost < _HOPELESS * best + 10.0:
            search.run(_MOST_STEPS - _FIRST_STEPS)
    return sorted((search.fit(scale / skin.contact_modulus, scale) for search in searches), key=lambda fit: fit.cost)


def _model_error(rows: int, cols: int) -> Floats:
    error = np.full((rows, cols), _BORDER_ERROR)
    inner = slice(_BORDER_TAXELS, -_BORDER_TAXELS)
    if min(rows, cols) > 4 * _BORDER_TAXELS:
        error[inner, inner] = _MODEL_ERROR
    else:
        error[:] = _MODEL_ERROR
    return error


def hint_of(relief: Relief) -> Hint:
    """Return first guesses of position, size and direction from the mask of a relief."""
    rows, cols = relief.mask.shape
    y_all, x_all = np.mgrid[0:rows, 0:cols]
    y_all = (y_all + 0.5 - rows / 2) * relief.pitch_m[0]
    x_all = (x_all + 0.5 - cols / 2) * relief.pitch_m[1]
    x, y = x_all[relief.mask], y_all[relief.mask]
    x0, y0 = float(x.mean()), float(y.mean())
    z = (x - x0) + 1j * (y - y0)
    second, spread = np.mean(z**2), float(np.mean(np.abs(z) ** 2))
    tilt = min(float(np.abs(second)) / max(spread, 1e-30), 0.98)
    long_m, short_m = (float(np.sqrt(6 * spread * (1 + sign * tilt))) for sign in (1, -1))
    # A square's fourth moment is negative along its sides.
    yaw4 = float(np.angle(-np.mean(z**4))) / 4
    area = float(relief.mask.sum()) * relief.pitch_m[0] * relief.pitch_m[1]
    top = float(relief.displacement[relief.core].max())
    border = relief.mask & ~relief.core
    edge = float(np.median(relief.displacement[border])) if border.any() else 0.0
    rise = 1.0 - max(edge, 0.0) / top if top > 0 else 1.0
    free = ~relief.mask
    if free.any():
        away = complex(float(x_all[free].mean()) - x0, float(y_all[free].mean()) - y0)
        out = away / abs(away) if abs(away) > 0 else 1.0 + 0j
    else:
        out = 1.0 + 0j
    # A straight border lies where the contact's cells along that direction end.
    reach = float(np.quantile((z * np.conj(out)).real, 0.99))
    place = (x0 + reach * out.real, y0 + reach * out.imag, float(np.angle(out)))
    return Hint(x0, y0, long_m, short_m, float(np.angle(second)) / 2, yaw4, area, rise, place)


class _Model:
    """The forward model of a pad: from a form's parameters to a frame, with derivatives."""

    def __init__(self, skin: Skin, rows: int, cols: int, row_m: float, col_m: float) -> None:
        n = max(1, round(_CELLS_ALONG / max(rows, cols)))
        self.skin = skin
        self.medium: Medium = medium_of(skin)
        self.cells = Cells(rows * n, cols * n, row_m / n, col_m / n)
        self.transmission = Transmission(self.medium, self.cells, skin.sensing_depth_m, n, np.float32)
        y = (np.arange(self.cells.rows) + 0.5 - self.cells.rows / 2) * self.cells.row_m
        x = (np.arange(self.cells.cols) + 0.5 - self.cells.cols / 2) * self.cells.col_m
        self.x, self.y = np.meshgrid(x, y)
        self.side = float(np.sqrt(self.cells.row_m * self.cells.col_m))

    def face(self, form: Form, q: Floats) -> tuple[Floats, Floats]:
        """Return how far below the top each cell lies, in depths, and the share of it that can be loaded."""
        drop, distance = form.face(q, self.x, self.y)
        return drop, np.clip(0.5 + distance / self.side, 0.0, 1.0)

    def press(self, form: Form, q: Floats, start: Floats | None) -> tuple[Floats, Floats, Floats] | None:
        """Return pressure, frame and shares of the cells; None where the form misses the pad."""
        drop, loaded = self.face(form, q)
        below = np.where(loaded > 0.02, drop * _DEPTH, np.inf)
        if not (below < _DEPTH).any():
            return None
        loaded = np.where(loaded > 0.02, loaded, 0.0)
        if start is not None:
            start = np.where(loaded > 0, start, 0.0)
        face = Face(below, loaded, 0.0)
        solved = solve_contact(face, self.skin, self.cells, _DEPTH, _PRESS_TOLERANCE, 60, start)
        frame = self.transmission.forward(solved.pressure.astype(np.float32)).astype(np.float64)
        return solved.pressure, frame, loaded

    def derivative(self, form: Form, q: Floats, pressure: Floats, loaded: Floats, scales: Floats) -> Floats:
        """Return the frame's derivatives by the parameters, each in its scale: shape (n_parameters, rows, cols)."""
        box = contact_box(pressure > 0)
        rows, cols = pressure[box].shape
        influence = influence_of(self.medium, self.cells, rows, cols, single=True)
        inside, share = pressure[box], loaded[box]
        right = np.empty((q.size, rows, cols), dtype=np.float32)
        spring = partial_springs(self.medium, influence.own, loaded)[box]
        for k in range(q.size):
            nudge = np.zeros_like(q)
            nudge[k] = _NUDGE * scales[k]
            after, before = self.face(form, q + nudge), self.face(form, q - nudge)
            lower = (after[0] - before[0])[box] * (-_DEPTH / (2 * _NUDGE))
            # A wall that moves changes the share of its cells, and with it their springs.
            wider = (after[1] - before[1])[box] / (2 * _NUDGE)
            softer = -0.5 * (spring + influence.own) / np.maximum(share, 0.05) * wider
            right[k] = lower - softer * inside
        free = inside > 0
        solved = _on_contact(influence.displacement, influence.inverse, spring, influence.own, free, right)
        whole = np.zeros((q.size, *pressure.shape), dtype=np.float32)
        whole[(slice(None), *box)] = solved
        return self.transmission.forward(whole).astype(np.float64)


@lru_cache(maxsize=8)
def _model(skin: Skin, rows: int, cols: int, row_m: float, col_m: float) -> _Model:
    return _Model(skin, rows, cols, row_m, col_m)


def _on_contact(
    apply: Any, inverse: Any, spring: Floats, own: float, free: NDArray[np.bool_], right: Floating
) -> Floating:
    """Solve (G + D) x = right on the free cells for several right-hand sides together."""
    mask = free.astype(np.float32)
    soft = spring.astype(np.float32)
    ease = mask / np.sqrt(1 + soft / np.float32(own))
    x = np.zeros_like(right)
    residual = right * mask
    first = np.sqrt(np.sum(residual**2, axis=(1, 2)))
    steepest = ease * inverse(ease * residual)
    along = steepest
    descent = np.sum(residual * steepest, axis=(1, 2))
    for _ in range(_DERIVATIVE_STEPS):
        change = mask * (apply(along) + soft * along)
        curvature = np.sum(along * change, axis=(1, 2))
        step = np.where(curvature > 0, descent / np.where(curvature > 0, curvature, 1), 0).astype(np.float32)
        x = x + step[:, None, None] * along
        residual = residual - step[:, None, None] * change
        if (np.sqrt(np.sum(residual**2, axis=(1, 2))) <= _DERIVATIVE_TOLERANCE * first).all():
            break
        steepest = ease * inverse(ease * residual)
        before, descent = descent, np.sum(residual * steepest, axis=(1, 2))
        memory = np.where(before > 0, descent / np.where(before > 0, before, 1), 0).astype(np.float32)
        along = steepest + memory[:, None, None] * along
    return x


class _Search:
    """Damped Gauss-Newton steps of one form, which can be taken up again."""

    def __init__(self, name: str, form: Form, model: _Model, frame: Floats, weight: Floats, hint: Hint) -> None:
        self.name, self.form, self.model = name, form, model
        self.target, self.weight = frame * weight, weight
        starts = form.starts(hint)
        self.q = starts[0]
        lengths = {"x": model.side, "y": model.side, "yaw": 0.1}
        self.scales = np.array([lengths[kind] for kind in form.pose] + [0.1] * len(form.sizes))
        self.damping = 1e-2
        self.steps = 0
        self.done = False
        self.state: tuple[Floats, Floats, Floats] | None = None
        self.cost = np.inf
        self.gain = 0.0
        for start in starts:
            state = model.press(form, start, None)
            if state is not None:
                gain, cost = self._judge(state[1])
                if cost < self.cost:
                    self.q, self.state, self.gain, self.cost = start, state, gain, cost
        self.done = self.state is None

    def _judge(self, frame: Floats) -> tuple[float, float]:
        frame = frame * self.weight
        gain = float((frame * self.target).sum() / max(float((frame * frame).sum()), 1e-300))
        misfit = float(((gain * frame - self.target) ** 2).sum())
        return gain, misfit + self.q.size * float(np.log(self.target.size))

    def run(self, steps: int) -> None:
        """Take up to so many steps."""
        if self.q.size == 0:
            self.done = True
        for _ in range(steps):
            if self.done or self.state is None:
                return
            self.steps += 1
            pressure, frame, loaded = self.state
            slopes = self.model.derivative(self.form, self.q, pressure, loaded, self.scales)
            slopes = self.gain * (slopes * self.weight).reshape(self.q.size, -1)
            flat = (frame * self.weight).ravel()
            flat = flat / np.linalg.norm(flat)
            # The gain follows: what it can take up is no change of the fit.
            slopes = slopes - (slopes @ flat)[:, None] * flat[None, :]
            residual = (self.target - self.gain * frame * self.weight).ravel()
            normal, right = slopes @ slopes.T, slopes @ residual
            self._step(normal, right)

    def _step(self, normal: Floats, right: Floats) -> None:
        weight = np.diag(np.diag(normal) + 1e-12 * max(float(np.trace(normal)), 1e-300))
        for _ in range(4):
            move = np.linalg.solve(normal + self.damping * weight, right)
            # Sizes change by a factor of 1.6 and places by a few cells a step at most.
            trial = self.q + self.scales * np.clip(move, -5, 5)
            state = self.model.press(self.form, trial, self.state[0] if self.state else None)
            if state is not None:
                gain, cost = self._judge(state[1])
                if cost < self.cost:
                    self.done = self.cost - cost < _LEAST_GAIN * self.cost
                    self.q, self.state, self.gain, self.cost = trial, state, gain, cost
                    self.damping = max(self.damping / 5, 1e-4)
                    return
            self.damping *= 8
        self.done = True

    def fit(self, to_depth: float, scale: float) -> FormFit:
        """Return where the search stands."""
        frame = np.zeros_like(self.target) if self.state is None else self.gain * self.state[1]
        misfit = float(((frame * self.weight - self.target) ** 2).mean())
        return FormFit(
            solid=self.name,
            parameters=self.form.described(self.q),
            depth=self.gain * _DEPTH * to_depth,
            misfit=misfit,
            cost=self.cost,
            frame=frame * scale,
            steps=self.steps,
        )
