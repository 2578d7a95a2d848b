"""Frames of shapes that are none of the known surfaces, and the names that they are given."""

from __future__ import annotations

import numpy as np

from benchmarks._strange_shapes import SHAPES, Height
from benchmarks.touch_distortions import SURE, answer_of
from varishold.evaluation.yardstick.forms import Face
from varishold.evaluation.yardstick.media import height_map, pressed
from varishold.evaluation.yardstick.rows import NOISE

SEED = 2500
FRAMES_PER_KIND = 60
_BREADTH = {32: (14.0, 24.0), 16: (9.0, 13.0)}


def strange_face(rng: np.random.Generator, shape: Height, breadth: float, pad: tuple[int, int]) -> Face:
    """Return a shape of that breadth, taxels, on a pad of any shape; its turn and its place are drawn."""
    turn, depth = float(rng.uniform(0, 2 * np.pi)), 0.2 * breadth
    free = np.maximum(np.array(pad[::-1]) / 2 - 0.6 * breadth, 0.0)
    dx, dy = rng.uniform(-free, free)

    def gap(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        x, y = (x - dx) * 2 / breadth, (y - dy) * 2 / breadth
        u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        inside = (abs(u) <= 1) & (abs(v) <= 1)
        height = np.where(inside, shape(u, v), 0.0).astype(float)
        return np.where(height > 0, depth * (1 - height), np.inf)

    return Face("stranger", gap, depth, breadth)


def stranger(rng: np.random.Generator, shape: Height, side: int, medium: str) -> np.ndarray:
    """Return a frame of a shape of random breadth, turn and place, without noise; its peak is 1."""
    face = strange_face(rng, shape, float(rng.uniform(*_BREADTH[side])), (side, side))
    frame = height_map(face, side) if medium == "ideal" else pressed(face, side, medium, rng)
    return frame / frame.max()


def measured(
    side: int, per_kind: int = FRAMES_PER_KIND, seed: int = SEED
) -> dict[str, tuple[float, float, dict[str, int]]]:
    """Return, by kind, the share called unknown, the share named with p > .9, and the names given."""
    result = {}
    for k, (kind, shape) in enumerate(SHAPES.items()):
        rng = np.random.default_rng([seed, side, k])
        unknown, sure, names = 0, 0, dict[str, int]()
        for index in range(per_kind):
            frame = stranger(rng, shape, side, ("ideal", "cover")[index % 2])
            answer = answer_of(frame + rng.normal(0, NOISE[side], frame.shape))
            unknown += answer.name == "unknown"
            if answer.name != "unknown":
                sure += answer.probability > SURE
                names[answer.name] = names.get(answer.name, 0) + 1
        result[kind] = (unknown / per_kind, sure / per_kind, names)
    return result


def means(shares: dict[str, tuple[float, float, dict[str, int]]]) -> tuple[float, float]:
    """Return the mean share called unknown and the mean share named with p > .9, over kinds."""
    return float(np.mean([u for u, _, _ in shares.values()])), float(np.mean([s for _, s, _ in shares.values()]))
