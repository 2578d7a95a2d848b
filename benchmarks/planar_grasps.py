"""Generated grasps: 22 on-off switches on phalanges that close on a shape in the plane.

A palm and three fingers, of which the thumb opposes the other two, close joint by joint on a convex
shape: each phalanx turns until it or one beyond it touches. A switch is on where its place on the phalanx
(or palm) lies within the switch's travel of the surface. Pose, size and rotation of the shape vary from
grasp to grasp, and every switch reads wrongly in one grasp out of fifty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SHAPES = ("cylinder", "square pillar", "rectangular pillar", "triangular pillar", "hexagonal pillar", "oval pillar")

_DIRECTIONS = np.linspace(-np.pi, np.pi, 48, endpoint=False)
_NORMALS = np.column_stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])
_TRAVEL_M = 0.0025
_FLIP_RATE = 0.02
_STEP_RAD = np.deg2rad(1.5)


@dataclass(frozen=True)
class _Finger:
    """A chain of phalanges: base (m), first direction (rad), turn (+1 or -1), lengths (m), switches a phalanx."""

    base: tuple[float, float]
    start: float
    turn: int
    lengths: tuple[float, ...]
    switches: tuple[int, ...]


_PALM = ((-0.03, 0.0), (-0.01, 0.0), (0.01, 0.0), (0.03, 0.0))
_FINGERS = (
    _Finger((-0.05, 0.0), np.deg2rad(105), -1, (0.050, 0.040), (3, 3)),
    _Finger((0.05, 0.0), np.deg2rad(75), 1, (0.045, 0.030, 0.025), (2, 2, 2)),
    _Finger((0.045, 0.0), np.deg2rad(80), 1, (0.035, 0.025, 0.020), (2, 2, 2)),
)


def planar_grasps(
    shapes: tuple[str, ...], n: int, rng: np.random.Generator
) -> tuple[NDArray[np.bool_], NDArray[np.str_]]:
    """Return `n` grasps of each shape: patterns (n * shapes, 22) bool, and the shapes' names."""
    patterns = np.concatenate([_grasp(name, n, rng) for name in shapes])
    return patterns, np.repeat(np.array(shapes), n)


def _vertices(name: str) -> NDArray[np.float64]:
    """Corners of a shape of unit size (diameter or breadth), or of a fine polygon where it is round."""
    round_angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    if name == "cylinder":
        return 0.5 * np.column_stack([np.cos(round_angles), np.sin(round_angles)])
    if name == "oval pillar":
        return 0.5 * np.column_stack([1.2 * np.cos(round_angles), 0.8 * np.sin(round_angles)])
    if name in ("square pillar", "rectangular pillar"):
        wide, high = (1.0, 1.0) if name == "square pillar" else (1.25, 0.75)
        return 0.5 * np.array([[wide, high], [-wide, high], [-wide, -high], [wide, -high]])
    sides = 3 if name == "triangular pillar" else 6
    angles = np.pi / 2 + 2 * np.pi * np.arange(sides) / sides
    return 0.58 * np.column_stack([np.cos(angles), np.sin(angles)])


def _grasp(name: str, n: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    size = (0.09 if name == "cylinder" else 0.075) * (1 + 0.04 * rng.standard_normal(n))
    yaw = np.deg2rad(10) * rng.standard_normal(n)
    turned = _vertices(name)[None] * size[:, None, None]
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y = turned[..., 0], turned[..., 1]
    corners = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    support = (corners @ _NORMALS.T).max(axis=1)
    centre = np.column_stack([0.004 * rng.standard_normal(n), np.zeros(n)])
    # The shape is drawn against the palm, up to a gap that varies.
    centre[:, 1] = -corners[..., 1].min(axis=1) + np.abs(0.002 * rng.standard_normal(n))

    def distance(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return ((points - centre[:, None]) @ _NORMALS.T - support[:, None]).max(axis=2)

    palm = np.broadcast_to(np.array(_PALM), (n, len(_PALM), 2))
    read = [distance(palm) < _TRAVEL_M, *(_close(finger, distance, n) for finger in _FINGERS)]
    return np.concatenate(read, axis=1) ^ (rng.random((n, 22)) < _FLIP_RATE)


def _close(finger: _Finger, distance, n: int) -> NDArray[np.bool_]:  # type: ignore[no-untyped-def]
    """Turn one joint after the other until something touches; return the switches."""
    joints = len(finger.lengths)
    angles = np.zeros((n, joints))
    along = np.linspace(0, 1, 7)[1:]

    def places(fractions: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        at = np.broadcast_to(np.array(finger.base), (n, 2))
        heading = np.full(n, finger.start)
        out = []
        for k, length in enumerate(finger.lengths):
            heading = heading + angles[:, k]
            direction = np.column_stack([np.cos(heading), np.sin(heading)])
            out.append(at[:, None] + length * fractions[k][None, :, None] * direction[:, None])
            at = at + length * direction
        return out

    for k in range(joints):
        moving = np.ones(n, dtype=bool)
        limit = np.deg2rad(75 if k == 0 else 95)
        while moving.any():
            angles[moving, k] += finger.turn * _STEP_RAD
            touched = distance(np.concatenate(places([along] * joints)[k:], axis=1)).min(axis=1) <= 0.0005
            moving &= ~touched & (np.abs(angles[:, k]) < limit)
    switches = [(np.arange(count) + 1) / (count + 0.5) for count in finger.switches]
    return distance(np.concatenate(places(switches), axis=1)) < _TRAVEL_M
