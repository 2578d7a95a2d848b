"""A camera that sees an object's silhouette and says what it may be, confused as cameras are.

No picture is drawn by a graphics library: the outline of each convex part follows from how far the part reaches in
every direction of the picture, so that the same seed gives the same picture on every machine. The picture is coarse,
blurred and noisy, and something may stand before the object. What the camera makes of it was learned from looks at the
ten kinds by a kernel over whitened measures of the outline, chosen on looks left out, which is the library's own.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from varishold.hand import OBJECTS
from varishold.hand.objects import graspable
from varishold.perceive import Belief, Evidence, Library, NameEvidence, SizePrior
from varishold.solids.body import Part

__all__ = ["camera_says", "learned", "look", "silhouette"]

Floats = NDArray[np.float64]

#: Pixels along a side, and what they show. Metres.
PIXELS, FIELD_M = 64, 0.28

#: The camera stands anywhere round the object, so high above the table's plane. Degrees.
ELEVATION_DEG = (25.0, 60.0)

#: Blur of the outline in pixels; noise of a pixel, where 1 is the whole contrast.
BLUR, NOISE = 1.3, 0.1

#: How often something stands before the object, and how much of the picture it covers at most.
COVERED, MOST_COVERED = 0.15, 0.2

#: The camera's distance, and so the size it tells, is known to so many parts.
DISTANCE = 0.12

#: Looks at each kind that it has learned from, and by which it has learned how far it is to be trusted; seeds from here
#: on, which no hand uses.
LOOKS, LOOKS_FOR_TRUST, FIRST_SEED = 300, 60, 8_000_000_000

#: What looks stranger than so is none of its kinds to it, and it says no name.
LEAST_P = 0.005

#: Sizes that it has learned. Metres.
SIZES_M = (0.04, 0.125)

_DIRECTIONS, _ROWS = 72, 16
_WEIGHTS = np.linspace(0.3, 1.2, 19)


def silhouette(parts: tuple[Part, ...], azimuth: float, elevation: float) -> NDArray[np.bool_]:
    """Return which pixels a body covers, seen along parallel rays, from an azimuth and elevation in radians."""
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    back = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    up = np.cross(back, right)
    angle = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    level = np.column_stack([np.cos(angle), np.sin(angle)])
    across = (np.arange(PIXELS) + 0.5 - PIXELS / 2) * FIELD_M / PIXELS
    pixels = np.stack(np.meshgrid(across, across[::-1] + 0.07 * np.cos(elevation)), axis=-1)
    far = np.stack([_reaches(part, level @ np.stack([right, up])) for part in parts])
    inside: NDArray[np.bool_] = (pixels[None] @ level.T <= far[:, None, None, :]).all(axis=-1).any(axis=0)
    return inside


def _reaches(part: Part, toward: Floats) -> Floats:
    """How far a part reaches along unit vectors, shape (n, 3). Metres."""
    if part.kind == "hull":
        return np.asarray((toward @ np.array(part.corners_m).T).max(axis=1))
    half = np.array(part.half_m)
    middle = toward @ np.array(part.centre_m)
    if part.kind == "box":
        return np.asarray(middle + np.abs(toward) @ half)
    if part.kind == "ellipsoid":
        return np.asarray(middle + np.linalg.norm(toward * half, axis=1))
    return np.asarray(middle + np.linalg.norm(toward[:, :2] * half[:2], axis=1) + np.abs(toward[:, 2]) * half[2])


def look(name: str, size_m: float, seed: int) -> tuple[dict[str, float], float]:
    """Return measures of what the camera sees of an object, and the size it tells. Metres."""
    rng = np.random.default_rng([seed, 0xCA3E])
    apart = float(np.exp(DISTANCE * rng.normal()))
    seen = silhouette(
        graspable(name, size_m).body(), rng.uniform(0, 2 * np.pi), np.deg2rad(rng.uniform(*ELEVATION_DEG))
    )
    picture = np.asarray(gaussian_filter(seen.astype(float), BLUR), dtype=np.float64)
    if rng.random() < COVERED:
        side = np.array([np.cos(turn := rng.uniform(0, 2 * np.pi)), np.sin(turn)])
        rows, columns = np.nonzero(seen)
        along = np.column_stack([columns, rows]) @ side
        edge = np.quantile(along, 1 - rng.uniform(0, MOST_COVERED))
        grid = np.stack(np.meshgrid(np.arange(PIXELS), np.arange(PIXELS)), axis=-1) @ side
        picture[grid > edge] = 0.0
    picture += NOISE * gaussian_filter(rng.normal(size=picture.shape), 0.7)
    return _measures(np.asarray(gaussian_filter(picture, 0.6), dtype=np.float64) > 0.5), size_m * apart


def _measures(mask: NDArray[np.bool_]) -> dict[str, float]:
    """Return measures of an outline that do not depend on its size nor place."""
    rows, columns = np.nonzero(mask)
    if len(rows) < 8:
        return {}
    low, high = np.quantile(rows, [0.02, 0.98])
    tall = high - low + 1
    broad = float(np.ptp(np.quantile(columns, [0.02, 0.98]))) + 1
    values = {"aspect": float(np.log(tall / broad)), "fill": len(rows) / (tall * broad)}
    at = np.clip(((rows - low) / tall * _ROWS).astype(int), 0, _ROWS - 1)
    for k in range(_ROWS):
        own = columns[at == k]
        values[f"breadth.{k}"] = len(own) / (tall / _ROWS) / broad
        values[f"aside.{k}"] = float((own.mean() - columns.mean()) / broad) if len(own) else 0.0
    up, aside = (rows - rows.mean()) / tall, (columns - columns.mean()) / broad
    values |= {"up.3": float((up**3).mean()), "up.4": float((up**4).mean()), "aside.4": float((aside**4).mean())}
    return values | {"both": float((up * aside).mean()), "round": float(((up**2) * (aside**2)).mean())}


def _looks(kind: int, name: str, first: int, n: int) -> list[Evidence]:
    rng = np.random.default_rng([FIRST_SEED, kind, first])
    sizes_m = np.exp(rng.uniform(*np.log(SIZES_M), n)).tolist()
    seeds = range(FIRST_SEED + 10_000 * kind + first, FIRST_SEED + 10_000 * kind + first + n)
    seen = [look(name, size_m, seed)[0] for size_m, seed in zip(sizes_m, seeds, strict=True)]
    return [Evidence("look", values) for values in seen if values]


def _shares(library: Library, seen: Evidence) -> Floats:
    """What a look says of each of `OBJECTS`."""
    probability = Belief.before(library).after(seen).probability
    shares = np.array([probability[name] for name in OBJECTS])
    return np.asarray(shares / shares.sum())


@cache
def learned() -> tuple[Library, float]:
    """Return what the camera knows, and the power that its answers are to be raised to: learned on further looks."""
    library = Library.from_examples(
        {name: [[seen] for seen in _looks(k, name, 0, LOOKS)] for k, name in enumerate(OBJECTS)}
    )
    kinds = [(k, seen) for k, name in enumerate(OBJECTS) for seen in _looks(k, name, LOOKS, LOOKS_FOR_TRUST)]
    logs = np.log(np.maximum([_shares(library, seen) for _, seen in kinds], 1e-12))
    true = np.array([k for k, _ in kinds])
    losses = []
    for weight in _WEIGHTS:
        p = np.exp(weight * logs)
        losses.append(-np.log((p / p.sum(axis=1, keepdims=True))[np.arange(len(true)), true]).mean())
    return library, float(_WEIGHTS[int(np.argmin(losses))])


def camera_says(name: str, size_m: float, seed: int) -> NameEvidence | None:
    """Return what the camera says of an object that nobody has touched: names and size; None where it sees nothing."""
    values, said_m = look(name, size_m, seed)
    if not values:
        return None
    library, weight = learned()
    seen = Evidence("look", values)
    p = _shares(library, seen) ** weight
    said = dict(zip(OBJECTS, (p / p.sum()).tolist(), strict=True))
    return NameEvidence(
        "camera",
        said,
        p_value=Belief.before(library).after(seen).p_value,
        error=LEAST_P,
        pose=SizePrior(said_m, DISTANCE * said_m),
    )
