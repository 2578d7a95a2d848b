"""Presses as a sensor feels them in time: drawn for measuring alone, apart from all that the program knows of skins.

An object is a gap over (u, v), how far its face lies behind its foremost point; it is pressed into a thin layer, whose
pressure is depth minus gap where that is positive, averaged over each taxel. In time the depth rises, holds and falls,
the object is shifted, and its face leans; a hand's tremor is in all of them. The sensor leaks to its neighbours, has
gains of its own, white noise, what zeroing left of its drift, and counts of 8 bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

__all__ = ["Action", "Conditions", "Finger", "Press", "draw_press"]

Face = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

# Points a side at which a taxel's pressure is averaged.
_CELLS = 5
_REST_COUNTS = 20


@dataclass(frozen=True)
class Action:
    """What a finger does between two times.

    Parameters
    ----------
    kind : {"moved", "tipped"}
    begin_s, end_s : float
    way : (float, float)
        Of the object, or of the centre of load within it, in taxels.
    """

    kind: str
    begin_s: float
    end_s: float
    way: tuple[float, float]


@dataclass
class Finger:
    """One object that presses, with its course in time; every course has shape (n_frames,).

    Parameters
    ----------
    shape : str
    face : callable
        Gap at (u, v) in the object's own axes, and how far inside its walls that is, in taxels.
    reach : float
        No point of it that touches is farther from its middle, in taxels.
    turn : float
        Angle of u from x.
    depth, x, y, lean_x, lean_y : ndarray
        Depth, place, and how much deeper the face lies a taxel farther along x and y.
    begin_s, end_s : float
        Between them it touches.
    actions : list of Action
    """

    shape: str
    face: Face
    reach: float
    turn: float
    depth: np.ndarray
    x: np.ndarray
    y: np.ndarray
    lean_x: np.ndarray
    lean_y: np.ndarray
    begin_s: float = 0.0
    end_s: float = 0.0
    actions: list[Action] = field(default_factory=list)

    def pressure(self, shape: tuple[int, int]) -> np.ndarray:
        """Return the pressure on each taxel; shape (n_frames, rows, cols)."""
        rows, cols = shape
        at_x = (np.arange(cols * _CELLS) + 0.5) / _CELLS - cols / 2
        at_y = (np.arange(rows * _CELLS) + 0.5) / _CELLS - rows / 2
        out = np.zeros((len(self.depth), rows, cols))
        for i in np.flatnonzero(self.depth > -np.inf):
            near_x = np.flatnonzero(abs(at_x - self.x[i]) < self.reach + 1)
            near_y = np.flatnonzero(abs(at_y - self.y[i]) < self.reach + 1)
            if not len(near_x) or not len(near_y):
                continue
            left, right = near_x[0] // _CELLS, near_x[-1] // _CELLS + 1
            top, bottom = near_y[0] // _CELLS, near_y[-1] // _CELLS + 1
            dx = at_x[None, left * _CELLS : right * _CELLS] - self.x[i]
            dy = at_y[top * _CELLS : bottom * _CELLS, None] - self.y[i]
            u = dx * np.cos(self.turn) + dy * np.sin(self.turn)
            v = dy * np.cos(self.turn) - dx * np.sin(self.turn)
            gap, inside = self.face(u, v)
            p = np.maximum(self.depth[i] + self.lean_x[i] * dx + self.lean_y[i] * dy - gap, 0.0)
            # A wall that crosses a cell covers a part of it.
            p = p * np.clip(inside * _CELLS + 0.5, 0.0, 1.0)
            cells = p.reshape(bottom - top, _CELLS, right - left, _CELLS)
            out[i, top:bottom, left:right] = cells.mean(axis=(1, 3))
        return out


@dataclass(frozen=True)
class Press:
    """Frames of a press, and what is true of it.

    Parameters
    ----------
    time_s : ndarray of shape (n_frames,)
    frames : ndarray of shape (n_frames, rows, cols), float64
        Counts, the rest taken off.
    fingers : tuple of Finger
    """

    time_s: np.ndarray
    frames: np.ndarray
    fingers: tuple[Finger, ...]


@dataclass(frozen=True)
class Conditions:
    """How a press is felt.

    Parameters
    ----------
    shape : (int, int)
    rate_hz : float
    noise : float
        Standard deviation, counts; or as a share of the peak where `noise_share` is given.
    seconds : (float, float)
        Least and greatest duration of an action.
    gains : float
        Spread of the taxels' gains.
    hold_s : float, optional
        How long a press is held in which nothing happens. Default: .3 to 1.2 s.
    blur : float
        Standard deviation of what a soft skin spreads, taxels.
    """

    shape: tuple[int, int] = (16, 16)
    rate_hz: float = 200.0
    noise: float = 1.0
    noise_share: float | None = None
    seconds: tuple[float, float] = (0.06, 0.5)
    gains: float = 0.1
    hold_s: float | None = None
    blur: float = 0.0


def draw_press(seed: tuple[int, ...], kind: str, conditions: Conditions = Conditions()) -> Press:
    """Return a press.

    Parameters
    ----------
    seed : tuple of int
    kind : str
        ``hold``, ``move``, ``tip``, ``both`` (a move and a tip, in either order) or ``two`` (two fingers at once).
    conditions : Conditions
    """
    rng = np.random.default_rng(seed)
    count = 2 if kind == "two" else 1
    plans = []
    for place in range(count):
        actions = {"hold": (), "move": ("moved",), "tip": ("tipped",), "both": ("moved", "tipped")}.get(kind)
        if actions is None:
            actions = () if rng.uniform() < 0.4 else ("moved",)
        if kind == "both" and rng.uniform() < 0.5:
            actions = actions[::-1]
        plans.append(_plan(rng, actions, conditions, place if count == 2 else None))
    seconds = 0.2 + max(plan["end_s"] for plan in plans) + 0.2
    time_s = np.arange(int(seconds * conditions.rate_hz)) / conditions.rate_hz
    fingers = tuple(_finger(rng, plan, time_s) for plan in plans)
    pressures = [finger.pressure(conditions.shape) for finger in fingers]
    for finger, pressure in zip(fingers, pressures, strict=True):
        finger.actions = [_measured(action, finger, pressure, time_s) for action in finger.actions]
    return Press(time_s, _felt(rng, sum(pressures), time_s, conditions), fingers)


def _measured(action: Action, finger: Finger, pressure: np.ndarray, time_s: np.ndarray) -> Action:
    """Return a tip with the way of its centre of load: where a face lifts off in part no formula tells it."""
    if action.kind != "tipped":
        return action
    rows, cols = pressure.shape[1:]
    within = []
    for at in (action.begin_s, action.end_s):
        i = min(int(np.searchsorted(time_s, at)), len(time_s) - 1)
        total = pressure[i].sum()
        x = pressure[i].sum(axis=0) @ (np.arange(cols) - (cols - 1) / 2) / total - finger.x[i]
        y = pressure[i].sum(axis=1) @ (np.arange(rows) - (rows - 1) / 2) / total - finger.y[i]
        within.append(np.array([x, y]))
    return replace(action, way=tuple((within[1] - within[0]).tolist()))


def _face(rng: np.random.Generator, shape: str, unit: float) -> tuple[Face, float, tuple[float, float]]:
    """Return the face, how far it reaches, and its half-lengths along u and v."""
    if shape == "ball":
        reach = unit * rng.uniform(2.0, 4.5)
        return (lambda u, v: ((u * u + v * v) / reach**2, np.ones_like(u))), reach, (reach, reach)
    if shape == "round punch":
        half = unit * rng.uniform(1.8, 4.0)
        return (lambda u, v: (np.zeros_like(u), half - np.hypot(u, v))), half, (half, half)
    if shape == "square punch":
        half = unit * rng.uniform(1.6, 3.6)
        return (lambda u, v: (np.zeros_like(u), half - np.maximum(abs(u), abs(v)))), 1.5 * half, (half, half)
    long, broad = unit * rng.uniform(3.2, 5.5), unit * rng.uniform(1.1, 1.8)
    halves = long, broad
    if shape == "bar":
        return (lambda u, v: (np.zeros_like(u), np.minimum(long - abs(u), broad - abs(v)))), 1.2 * long, halves
    return (lambda u, v: ((v / broad) ** 2, long - abs(u))), 1.2 * long, halves


_SHAPES = ("ball", "round punch", "square punch", "bar", "round bar")


def _plan(rng: np.random.Generator, actions: tuple[str, ...], conditions: Conditions, place: int | None) -> dict:
    rows, cols = conditions.shape
    unit = min(rows, cols) / 16
    if min(rows, cols) < 10:
        unit = max(unit, 0.45)
    shapes = _SHAPES[1:] if "tipped" in actions else _SHAPES
    shape = str(rng.choice(shapes if place is None else _SHAPES[:3]))
    face, reach, halves = _face(rng, shape, unit if place is None else 0.62 * unit)
    turn = float(rng.uniform(-np.pi, np.pi))
    begin = 0.2 + float(rng.uniform(0, 0.15))
    rise, fall = (float(rng.uniform(0.04, 0.25)) for _ in range(2))
    at = begin + rise + float(rng.uniform(0.25, 0.5))
    planned = []
    for action in actions:
        lasts = float(rng.uniform(*conditions.seconds))
        planned.append((action, at, at + lasts))
        at += lasts + float(rng.uniform(0.35, 0.6))
    if not actions:
        at += float(rng.uniform(0.3, 1.2)) if conditions.hold_s is None else conditions.hold_s
    return {
        "shape": shape,
        "face": face,
        "reach": reach,
        "halves": halves,
        "turn": turn,
        "begin_s": begin,
        "rise": rise,
        "fall": fall,
        "end_s": at + fall,
        "planned": planned,
        "place": place,
        "field": (rows, cols),
        "askew": rng.uniform() < 0.4 and shape != "ball",
    }


def _eased(time_s: np.ndarray, begin: float, end: float) -> np.ndarray:
    t = np.clip((time_s - begin) / (end - begin), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _tremor(rng: np.random.Generator, time_s: np.ndarray, size: float) -> np.ndarray:
    """Return a slow wander and a tremor of 8 to 12 Hz, together of about that standard deviation."""
    waves = [(rng.uniform(0.3, 2.0), 0.9), (rng.uniform(2.0, 5.0), 0.35), (rng.uniform(8.0, 12.0), 0.25)]
    parts = [share * np.sin(2 * np.pi * (f * time_s + rng.uniform())) for f, share in waves]
    return size * np.sqrt(2) * np.sum(parts, axis=0)


def _finger(rng: np.random.Generator, plan: dict, time_s: np.ndarray) -> Finger:
    rows, cols = plan["field"]
    begin, end = plan["begin_s"], plan["end_s"]
    load = _eased(time_s, begin, begin + plan["rise"]) * (1 - _eased(time_s, end - plan["fall"], end))
    load = load * (1 + _tremor(rng, time_s, 0.03))
    span = plan["reach"] * (0.75 if plan["shape"] in ("bar", "round bar") else 1.0)
    free_x, free_y = max(cols / 2 - span - 0.8, 0.0), max(rows / 2 - span - 0.8, 0.0)
    if plan["place"] is None:
        x0, y0 = rng.uniform(-free_x, free_x), rng.uniform(-free_y, free_y)
    else:
        side = -1 if plan["place"] == 0 else 1
        x0, y0 = side * cols * rng.uniform(0.24, 0.3), rng.uniform(-free_y, free_y)
    x, y = x0 + _tremor(rng, time_s, 0.02), y0 + _tremor(rng, time_s, 0.02)
    lean = np.zeros((2, len(time_s)))
    if plan["askew"]:
        # A hand holds an angle: while the load is small, the face touches with one side alone.
        lean += _slope(rng, plan, rng.uniform(0.15, 0.4))[:, None] * (1 + _tremor(rng, time_s, 0.05))
    actions = []
    for kind, start, stop in plan["planned"]:
        share = _eased(time_s, start, stop)
        if kind == "moved":
            way = _way(rng, (x0, y0), (free_x, free_y), plan["place"])
            x, y = x + share * way[0], y + share * way[1]
            x0, y0 = x0 + way[0], y0 + way[1]
        else:
            slope = _slope(rng, plan, rng.uniform(0.5, 0.9))
            if lean[:, -1] @ slope > 0:
                slope = -slope
            lean = lean + share * slope[:, None]
            way = (0.0, 0.0)
        actions.append(Action(kind, start, stop, way))
    # What leans touches with its foremost corner first, and leaves with it last.
    foremost = _corner(plan, lean)
    depth = np.where(load > 0, load * (1 + foremost) - foremost, -np.inf)
    return Finger(
        *(plan["shape"], plan["face"], plan["reach"], plan["turn"]),
        *(depth, x, y, lean[0], lean[1]),
        *(begin, end, actions),
    )


def _corner(plan: dict, lean: np.ndarray) -> np.ndarray:
    """Return how much deeper than its middle the deepest point of a face lies, of shape (n_frames,)."""
    if plan["shape"] == "ball":
        return np.zeros(lean.shape[1])
    half_u, half_v = plan["halves"]
    if plan["shape"] == "round punch":
        return half_u * np.hypot(*lean)
    c, s = np.cos(plan["turn"]), np.sin(plan["turn"])
    along, across = abs(c * lean[0] + s * lean[1]), abs(c * lean[1] - s * lean[0])
    return half_u * along + (half_v * across if plan["shape"] != "round bar" else 0.0)


def _slope(rng: np.random.Generator, plan: dict, size: float) -> np.ndarray:
    """Return a lean (x, y), shares of the depth a taxel, that changes the pressure at the rim by a share `size`."""
    half_u, half_v = plan["halves"]
    angle = rng.uniform(-np.pi, np.pi)
    if plan["shape"] in ("bar", "round bar"):
        # A bar tips along its length.
        angle = rng.choice([0.0, np.pi]) + rng.uniform(-0.1, 0.1)
    across = np.array([np.cos(angle), np.sin(angle)])
    corner = abs(across[0]) * half_u + abs(across[1]) * half_v
    if plan["shape"] == "round punch":
        corner = half_u
    return _turn(size / corner * across, plan["turn"])


def _turn(vector: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def _way(
    rng: np.random.Generator, at: tuple[float, float], free: tuple[float, float], place: int | None
) -> tuple[float, float]:
    """Return a way that stays on the pad."""
    for _ in range(1000):
        angle, far = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 3.0 if place is None else 1.2)
        way = far * np.cos(angle), far * np.sin(angle)
        if all(abs(a + w) <= f + 0.3 for a, w, f in zip(at, way, free, strict=True)):
            return float(way[0]), float(way[1])
    return float(0.5 * np.cos(angle)), float(0.5 * np.sin(angle))


def _felt(rng: np.random.Generator, clean: np.ndarray, time_s: np.ndarray, conditions: Conditions) -> np.ndarray:
    """Return what the sensor says of a pressure whose deepest point is about 1."""
    shape = conditions.shape
    if conditions.blur > 0:
        clean = _blurred(clean, conditions.blur)
    padded = np.pad(clean, ((0, 0), (1, 1), (1, 1)), mode="edge")
    near = padded[:, 2:, 1:-1] + padded[:, :-2, 1:-1] + padded[:, 1:-1, 2:] + padded[:, 1:-1, :-2]
    leaked = (clean + 0.05 * near) / 1.2
    full = rng.uniform(60, 200)
    noise = conditions.noise if conditions.noise_share is None else conditions.noise_share * full
    gains = np.maximum(1 + conditions.gains * rng.standard_normal(shape), 0.3)
    left = 0.4 * rng.standard_normal(shape) * np.sin(2 * np.pi * (0.1 * time_s + rng.uniform()))[:, None, None]
    common = 0.5 * np.sin(2 * np.pi * (0.07 * time_s + rng.uniform()))[:, None, None]
    said = _REST_COUNTS + full * gains * leaked + left + common + noise * rng.standard_normal(clean.shape)
    return np.clip(np.rint(said), 0, 255) - _REST_COUNTS


def _blurred(frames: np.ndarray, sigma: float) -> np.ndarray:
    """Return frames blurred by a Gaussian."""
    at = np.arange(-4, 5)
    kernel = np.exp(-(at**2) / (2 * sigma**2))
    kernel /= kernel.sum()
    for axis in (1, 2):
        wide = [(0, 0), (0, 0), (0, 0)]
        wide[axis] = (4, 4)
        padded = np.pad(frames, wide, mode="edge")
        n = frames.shape[axis]
        frames = sum(share * np.take(padded, np.arange(k, k + n), axis) for k, share in enumerate(kernel))
    return frames
