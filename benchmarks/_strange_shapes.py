"""Shapes that are none of the known surfaces, as heights over the unit square: for measuring alone.

Each is a function of (u, v), both in [-1, 1], that returns a height in [0, 1]; 0 is where the shape is not. All are
in one piece, so that a frame holds one contact. Shapes whose frame a known surface gives on another skin are left out
(a bowl presses as a cylinder does on a half-space).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _box(u: np.ndarray, v: np.ndarray, left: float, right: float, low: float, high: float) -> np.ndarray:
    return (u >= left) & (u <= right) & (v >= low) & (v <= high)


def _disc(u: np.ndarray, v: np.ndarray, x: float, y: float, r: float) -> np.ndarray:
    return np.hypot(u - x, v - y) <= r


def _bar(u: np.ndarray, v: np.ndarray, a: tuple[float, float], b: tuple[float, float], r: float) -> np.ndarray:
    """Return a stroke with round ends from a to b."""
    (ax, ay), (bx, by) = a, b
    along = ((u - ax) * (bx - ax) + (v - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
    along = np.clip(along, 0.0, 1.0)
    return np.hypot(u - ax - along * (bx - ax), v - ay - along * (by - ay)) <= r


def _gear(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.hypot(u, v) <= np.where(np.cos(8 * np.arctan2(v, u)) > 0, 0.98, 0.68)


def _key(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    bow = _disc(u, v, -0.55, 0, 0.43) & ~_disc(u, v, -0.55, 0, 0.18)
    return bow | _box(u, v, -0.2, 0.98, -0.12, 0.12) | _box(u, v, 0.5, 0.65, 0, 0.42) | _box(u, v, 0.8, 0.98, 0, 0.42)


def _letter_a(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    legs = _bar(u, v, (-0.7, -0.85), (0, 0.85), 0.14) | _bar(u, v, (0.7, -0.85), (0, 0.85), 0.14)
    return legs | _bar(u, v, (-0.45, -0.25), (0.45, -0.25), 0.13)


def _letter_e(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    arms = _box(u, v, -0.7, 0.7, -0.95, -0.65) | _box(u, v, -0.7, 0.7, 0.65, 0.95) | _box(u, v, -0.7, 0.5, -0.15, 0.15)
    return arms | _box(u, v, -0.7, -0.38, -0.95, 0.95)


def _letter_h(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    posts = _box(u, v, -0.8, -0.45, -0.95, 0.95) | _box(u, v, 0.45, 0.8, -0.95, 0.95)
    return posts | _box(u, v, -0.8, 0.8, -0.17, 0.17)


def _letter_k(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    arms = _bar(u, v, (-0.5, 0), (0.6, 0.82), 0.15) | _bar(u, v, (-0.4, 0.05), (0.65, -0.82), 0.15)
    return arms | _box(u, v, -0.75, -0.42, -0.95, 0.95)


def _heart(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    x, y = 1.2 * u, 1.2 * v + 0.1
    return (x**2 + y**2 - 1) ** 3 - x**2 * y**3 <= 0


def _chevron(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (abs(v - 0.9 * abs(u) + 0.35) <= 0.3) & (abs(u) <= 0.95)


def _dumbbell(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _disc(u, v, -0.6, 0, 0.38) | _disc(u, v, 0.6, 0, 0.38) | _box(u, v, -0.6, 0.6, -0.13, 0.13)


def _keyhole(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    plate = _box(u, v, -0.8, 0.8, -0.95, 0.95)
    hole = _disc(u, v, 0, 0.35, 0.33) | ((abs(u) <= 0.12 - 0.25 * (v - 0.2)) & (v <= 0.2) & (v >= -0.7))
    return plate & ~hole


def _ring_segment(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    r = np.hypot(u, v)
    return (r <= 0.97) & (r >= 0.6) & (np.arctan2(v, u) > -0.9)


def _three_blobs(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    balls = [np.maximum(1 - ((u - x) ** 2 + v**2) / 0.19, 0.0) for x in (-0.55, 0.0, 0.55)]
    return np.maximum(np.sqrt(np.maximum.reduce(balls)), 0.66 * _bar(u, v, (-0.55, 0), (0.55, 0), 0.2))


def _lattice(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    line = lambda t: np.abs((1.5 * t + 1.5) % 1.0 - 0.5) > 0.33  # noqa: E731
    return (line(u) | line(v)) & _box(u, v, -0.88, 0.88, -0.88, 0.88)


def _screw_thread(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    shaft = np.sqrt(np.maximum(1 - (v / 0.5) ** 2, 0.0)) * (abs(u) <= 0.97)
    return shaft * (0.7 + 0.3 * np.cos(2 * np.pi * (1.9 * u + 0.5 * v)))


def _comb(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    tines = (np.abs((2 * u + 2) % 1.0 - 0.5) > 0.26) & (v <= 0.5)
    return (tines | (v > 0.35)) & _box(u, v, -0.87, 0.87, -0.8, 0.8)


def _u_channel(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _box(u, v, -0.8, 0.8, -0.9, 0.9) & ~_box(u, v, -0.42, 0.42, -0.5, 1.0)


def _saddle(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.where(_disc(u, v, 0, 0, 0.97), 0.6 + 0.4 * (u**2 - v**2) / 0.95, 0.0)


def _spiral(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    r, turn = np.hypot(u, v), np.arctan2(v, u)
    arm = np.abs((r / 0.56 - turn / (2 * np.pi)) % 1.0 - 0.5) < 0.25
    return arm & (r <= 0.97)


def _stairs(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    step = np.where(u < -0.3, 0.35, np.where(u < 0.33, 0.68, 1.0))
    return step * _box(u, v, -0.95, 0.95, -0.6, 0.6)


def _two_roofs(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    roofs = np.maximum(1 - 2 * abs(v - 0.42) / 0.84, 1 - 2 * abs(v + 0.42) / 0.84)
    return np.maximum(roofs, 0.6) * _box(u, v, -0.8, 0.8, -0.84, 0.84)


def _checker(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    black = (np.floor(1.5 * (u + 1)) + np.floor(1.5 * (v + 1))) % 2 == 0
    joints = ((u / 0.333 + 5) % 2 < 0.3) | ((u / 0.333 + 5) % 2 > 1.7)
    joints &= ((v / 0.333 + 5) % 2 < 0.3) | ((v / 0.333 + 5) % 2 > 1.7)
    return (black | joints) & _box(u, v, -0.98, 0.98, -0.98, 0.98)


def _round_cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _bar(u, v, (-0.72, 0), (0.72, 0), 0.24) | _bar(u, v, (0, -0.72), (0, 0.72), 0.24)


def _arrow(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _box(u, v, -0.97, 0.2, -0.2, 0.2) | ((u >= 0.1) & (abs(v) <= 0.8 * (0.97 - u) / 0.87))


def _puzzle_piece(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    body = _box(u, v, -0.65, 0.6, -0.62, 0.62) | _disc(u, v, 0.72, 0, 0.26) | _disc(u, v, 0, 0.74, 0.26)
    return body & ~_disc(u, v, -0.55, 0, 0.28)


def _crescent(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _disc(u, v, 0, 0, 0.97) & ~_disc(u, v, 0.48, 0, 0.72)


def _finger_pair(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    left, right = _bar(u, v, (-0.38, -0.55), (-0.38, 0.62), 0.3), _bar(u, v, (0.38, -0.55), (0.38, 0.3), 0.3)
    return np.maximum((left | right).astype(float), 0.7 * _box(u, v, -0.4, 0.4, -0.7, -0.4))


def _hand_print(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    palm = _disc(u, v, 0, -0.4, 0.48) | _bar(u, v, (0.2, -0.5), (0.85, -0.05), 0.13)
    tips = ((-0.48, 0.45), (-0.19, 0.8), (0.12, 0.82), (0.42, 0.6))
    for k, tip in enumerate(tips):
        palm |= _bar(u, v, (-0.33 + 0.22 * k, -0.2), tip, 0.11)
    return palm


def _wrench(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    head = _disc(u, v, 0.5, 0, 0.47) & ~_box(u, v, 0.45, 1.0, -0.2, 0.2)
    return head | _bar(u, v, (-0.8, 0), (0.2, 0), 0.17)


def _clover(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    leaves = [_disc(u, v, x, y, 0.42) for x, y in ((0.53, 0), (-0.53, 0), (0, 0.53), (0, -0.53))]
    return np.logical_or.reduce(leaves)


def _zigzag(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    stroke = np.zeros_like(u, bool)
    corners = ((-0.85, -0.5), (-0.3, 0.6), (0.3, -0.6), (0.85, 0.5))
    for a, b in pairwise(corners):
        stroke |= _bar(u, v, a, b, 0.14)
    return stroke


def _half_disc(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _disc(u, v, 0, -0.45, 0.95) & (v >= -0.45)


def _kidney(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _bar(u, v, (-0.5, -0.1), (0, 0.2), 0.45) | _bar(u, v, (0.5, -0.1), (0, 0.2), 0.45)


def _teardrop(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _disc(u, v, -0.35, 0, 0.6) | ((u >= -0.1) & (abs(v) <= 0.52 * (0.95 - u)))


def _twin_peaks(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    near = np.minimum(np.hypot(u - 0.38, v), np.hypot(u + 0.38, v))
    return np.maximum(1.0 - near / 0.6, 0.55 * _disc(u, v, 0, 0, 0.3))


def _t_bar(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return _box(u, v, -0.9, 0.9, 0.4, 0.85) | _box(u, v, -0.22, 0.22, -0.9, 0.5)


def _pear(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    body = np.maximum(1 - ((u + 0.3) ** 2 + v**2) / 0.4, 0.0)
    neck = 0.7 * np.maximum(1 - ((u - 0.5) ** 2 + v**2) / 0.2, 0.0)
    return np.sqrt(np.maximum(body, neck))


#: Height of every shape by its name.
SHAPES: dict[str, Height] = {
    "gear": _gear,
    "key": _key,
    "letter A": _letter_a,
    "letter E": _letter_e,
    "letter H": _letter_h,
    "letter K": _letter_k,
    "heart": _heart,
    "chevron": _chevron,
    "dumbbell": _dumbbell,
    "keyhole plate": _keyhole,
    "ring segment": _ring_segment,
    "three blobs": _three_blobs,
    "lattice": _lattice,
    "screw thread": _screw_thread,
    "comb": _comb,
    "U-channel": _u_channel,
    "saddle": _saddle,
    "spiral": _spiral,
    "stairs": _stairs,
    "two roofs": _two_roofs,
    "checker": _checker,
    "cross, round ends": _round_cross,
    "arrow": _arrow,
    "puzzle piece": _puzzle_piece,
    "crescent": _crescent,
    "pair of fingers": _finger_pair,
    "hand print": _hand_print,
    "wrench": _wrench,
    "clover": _clover,
    "zigzag": _zigzag,
    "half disc": _half_disc,
    "kidney": _kidney,
    "teardrop": _teardrop,
    "twin peaks": _twin_peaks,
    "T-bar": _t_bar,
    "pear": _pear,
}
