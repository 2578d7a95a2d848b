"""Names given to depth maps, as optical sensors make them: 128 x 128 to 640 x 480, noise of 1 %.

Faces are drawn by the yardstick: 11 kinds, edges and planes apart, from 8 to 22 taxels (bars from 5) up to as large
a share of the map as they have of a pad of 32. Rows: the height map; a rest of .3 of the peak
that nobody took off; columns 1.05 times as far apart as taken to be; the skirt of a gel, which follows the object
down to a fifth of its depth and from there falls off within a twelfth of the breadth. The name is that of the largest
contact; each other contact is a false one. Of the rest, what must not happen is a sure "plane".
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from benchmarks._figures import share
from benchmarks.touch_distortions import SURE, answer_of
from varishold.evaluation.yardstick.forms import ENDLESS, KINDS, Change, Face, draw_face

SEED = 640
NOISE = 0.01
#: Shapes, and how many frames of each kind.
SHAPES = (((128, 128), 14), ((240, 320), 10), ((480, 640), 8))
#: Least right, most with a false contact.
BARS = (0.98, 0.05)
REST, STRETCH, SKIRT_FROM, SKIRT_LENGTH = 0.3, 1.05, 0.2, 1 / 12
ROWS = ("height map", "rest left on", "stretch 1.05", "gel's skirt")
_ONE_KIND = {"hip": "ridge"}


def on_grid(face: Face, shape: tuple[int, int], cells: int, stretch: float = 1.0) -> np.ndarray:
    """Return how deep a face stands in each taxel of a pad of any shape, negative where it does not reach."""
    rows, cols = shape
    y = (np.arange(rows * cells) + 0.5) / cells - rows / 2
    x = ((np.arange(cols * cells) + 0.5) / cells - cols / 2) * stretch
    depth = face.depth - np.minimum(face.gap(*np.meshgrid(x, y)), 1e6)
    return depth.reshape(rows, cells, cols, cells)


def taxels(depth: np.ndarray) -> np.ndarray:
    """Return the taxels' means of what is touched."""
    return np.maximum(depth, 0.0).mean(axis=(1, 3))


def draw(seed: tuple[int, ...], kind: str, index: int, shape: tuple[int, int]) -> Face:
    """Return a face that fits on a pad of any shape."""
    for attempt in range(200):
        face = draw_face((*seed, attempt), kind, index, min(shape), Change())
        if face is not None:
            return face
    raise RuntimeError(f"no {kind} fits on {shape}")


def magnified(face: Face, times: float) -> Face:
    """Return a face `times` as large in every way."""
    return Face(
        face.kind, lambda x, y: times * face.gap(x / times, y / times), times * face.depth, times * face.breadth
    )


def draw_large(seed: tuple[int, ...], kind: str, index: int, shape: tuple[int, int]) -> Face:
    """Return a face of a pad of 32, magnified by chance up to what fits on the map."""
    times = (min(shape) / 32) ** float(np.random.default_rng(seed).uniform())
    return magnified(draw(seed, kind, index, (32, 32)), times)


def with_skirt(face: Face, shape: tuple[int, int]) -> np.ndarray:
    """Return the depth of a gel that follows the face and falls off beside it."""
    deep = on_grid(face, shape, 1)[:, 0, :, 0]
    away, (row, col) = ndimage.distance_transform_edt(deep < SKIRT_FROM * face.depth, return_indices=True)
    near = np.minimum(deep[row, col], face.depth) * np.where(away > 0, SKIRT_FROM, 1.0)
    near = np.where(away > 0, np.minimum(near, SKIRT_FROM * face.depth), deep)
    return near * np.exp(-away / (SKIRT_LENGTH * face.breadth))


def frame(row: str, face: Face, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Return a noisy frame of one row; the face alone peaks at 1."""
    if row == "gel's skirt":
        clean = with_skirt(face, shape)
    else:
        clean = taxels(on_grid(face, shape, 2, STRETCH if row == "stretch 1.05" else 1.0))
    clean = clean / clean.max()
    return clean + (REST if row == "rest left on" else 0.0) + NOISE * rng.standard_normal(shape)


def main(argv: Sequence[str] = ()) -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--quick", action="store_true", help="128 x 128 only")
    asked = parser.parse_args(list(argv))
    kinds = [kind for kind in KINDS if kind not in ENDLESS]
    for shape, per_kind in SHAPES[:1] if asked.quick else SHAPES:
        faces = {
            (k, i): draw_large((asked.seed, *shape, k, i), kind, i, shape)
            for k, kind in enumerate(kinds)
            for i in range(per_kind)
        }
        for row in ROWS:
            right, several, unknown, sure, plane = [], [], [], [], []
            missed: dict[str, int] = {}
            for k, kind in enumerate(kinds):
                for index in range(per_kind):
                    made = frame(row, faces[k, index], shape, np.random.default_rng([asked.seed, *shape, k, index, 7]))
                    answer = answer_of(made)
                    ok = answer.name == _ONE_KIND.get(kind, kind)
                    right.append(ok)
                    several.append(answer.contacts > 1)
                    unknown.append(answer.name == "unknown")
                    sure.append(not ok and answer.name != "unknown" and answer.probability > SURE)
                    plane.append(answer.name == "plane" and answer.probability > SURE)
                    if not ok:
                        missed[f"{kind} as {answer.name}"] = missed.get(f"{kind} as {answer.name}", 0) + 1
            of = f"{shape[1]:3} x {shape[0]:3} {row:13}"
            said = {
                name: share(f"{of}: {name}", np.mean(given), spec, bar=bar)
                for name, given, spec, bar in (
                    ("right", right, "5.1f", f">= {100 * BARS[0]:.0f}"),
                    ("false contact", several, "5.1f", f"<= {100 * BARS[1]:.0f}"),
                    ("unknown", unknown, "5.1f", ""),
                    ("wrong with p > .9", sure, "4.1f", ""),
                    ("plane with p > .9", plane, "4.1f", ""),
                )
            }
            most = "; ".join(f"{pair} {n}" for pair, n in sorted(missed.items(), key=lambda item: -item[1])[:3])
            print(f"  {of} {'  '.join(f'{name} {value}' for name, value in said.items())}  {most}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
