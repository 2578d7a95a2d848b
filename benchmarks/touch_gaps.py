"""Names over holes of broken taxels, over gaps in the pad, and on taxels that stand on no grid.

The yardstick's faces, as height maps with its noise. A hole is a square of so many taxels at the middle of what stands
highest, or somewhere on the flank; its taxels are broken (``valid``) or not there (``field``). On no grid taxels stand
on a hexagonal grid, on rings or strewn at random over the pad, and read the face where they stand. What a hole takes
nobody knows: what is wanted is that nothing wrong is said for sure.

    python -m benchmarks.touch_gaps
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from benchmarks._drawn_frames import frames
from benchmarks._figures import share
from benchmarks.touch_distortions import SURE, Tally, answer_of
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.rows import NOISE, as_one
from varishold.sensor import Sensor

SEED = 81
PER_KIND = 12
BROAD = (2, 3, 4, 6, 8)
TAXELS = (60, 120, 250)
BAR = 0.01
_SIDE_MM = 31.0
# Where a hole may begin to be put: shares of the face's height.
_TOP, _FLANK = (0.9, 1.1), (0.2, 0.7)


def faces(side: int) -> tuple[np.ndarray, list[tuple[str, ...]]]:
    """Return faces of height 1, shape (n, side, side), and the name of each."""
    drawn, kinds = frames("ideal", side, Change(), PER_KIND, SEED)
    return drawn / drawn.max(axis=(1, 2), keepdims=True), [(as_one(kind),) for kind in kinds.tolist()]


def hole(face: np.ndarray, rng: np.random.Generator, broad: int, heights: tuple[float, float]) -> np.ndarray:
    """Return where taxels are left, shape (side, side): a square of `broad` taxels is gone."""
    side, (low, high) = len(face), heights
    places = np.argwhere((face > low) & (face < high))
    places = places if len(places) else np.argwhere(face > low)
    middle = places.mean(axis=0).round().astype(int) if heights == _TOP else places[rng.integers(len(places))]
    row, col = np.clip(middle - broad // 2, 0, side - broad)
    left = np.ones(face.shape, np.bool_)
    left[row : row + broad, col : col + broad] = False
    return left


def over_holes(side: int, lost: str, broad: int, heights: tuple[float, float]) -> Tally:
    """Return the answers given over holes of one kind."""
    rng, tally = np.random.default_rng([SEED, side, broad]), Tally()
    for face, truth in zip(*faces(side), strict=True):
        read = face + NOISE[side] * rng.standard_normal(face.shape)
        tally.add(truth, answer_of(read, **{lost: hole(face, rng, broad, heights)}))
    return tally


def hexagonal(n: int, _: np.random.Generator) -> np.ndarray:
    """Return the places of about `n` taxels, shape (n, 2), millimetres from a corner."""
    apart = _SIDE_MM / math.sqrt(n * math.sqrt(0.75))
    rows, cols = np.mgrid[:99, :99]
    places = np.column_stack([((cols + rows % 2 / 2) * apart).ravel(), (rows * apart * math.sqrt(0.75)).ravel()])
    return places[(places <= _SIDE_MM).all(axis=1)]


def rings(n: int, _: np.random.Generator) -> np.ndarray:
    """As `hexagonal`, on rings around the middle."""
    count = round(math.sqrt(n / math.pi))
    turns = [(r / count, 2 * math.pi * k / (6 * r)) for r in range(1, count + 1) for k in range(6 * r)]
    around = [(radius * math.cos(turn), radius * math.sin(turn)) for radius, turn in turns]
    return _SIDE_MM / 2 * (1.0 + np.array([(0.0, 0.0), *around]))


def strewn(n: int, rng: np.random.Generator) -> np.ndarray:
    """As `hexagonal`, anywhere."""
    return rng.uniform(0.0, _SIDE_MM, (n, 2))


def on_no_grid(stand: Callable[[int, np.random.Generator], np.ndarray], n: int) -> Tally:
    """Return the answers given on taxels that stand on no grid."""
    from scipy.ndimage import map_coordinates

    rng, tally = np.random.default_rng([SEED, n]), Tally()
    for face, truth in zip(*faces(32), strict=True):
        places = stand(n, rng)
        read = map_coordinates(face, places[:, ::-1].T, order=1) + NOISE[32] * rng.standard_normal(len(places))
        tally.add(truth, answer_of(read[None], sensor=Sensor(positions_m=1e-3 * places)))
    return tally


def print_row(of: str, tally: Tally) -> None:
    """Print one row."""
    f = tally.figures()
    wrong = share(f"{of}: wrong with p > {SURE:g}", f["wrong_sure"], "4.1f", bar=f"<= {100 * BAR:.0f}")
    right, unknown = (share(f"{of}: {key}", f[key], "5.1f") for key in ("right", "unknown"))
    print(f"  {of:44} wrong with p > {SURE:g} {wrong}  right {right}  unknown {unknown}", flush=True)


def main() -> None:
    """Print the shares."""
    for side in (32, 16):
        for lost, what in (("valid", "broken"), ("field", "no taxels")):
            for heights, where in ((_TOP, "at the top"), (_FLANK, "on the flank")):
                for broad in BROAD:
                    row = over_holes(side, lost, broad, heights)
                    print_row(f"{side} x {side}, {what}, {broad} x {broad} {where}", row)
    for stand in (hexagonal, rings, strewn):
        for n in TAXELS:
            print_row(f"{n} taxels, {stand.__name__}", on_no_grid(stand, n))


if __name__ == "__main__":
    main()
