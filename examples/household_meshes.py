"""Ten things of a household as meshes, of equal size: to try `varishold objects add` on.

Run: ``python examples/household_meshes.py FOLDER [--size-m 0.08]``. Each STL stands upright, is closed, and has the
same larger level extent, so that no grip tells them by their size alone. Lengths are metres.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.perceive import SurfaceMesh, write_stl

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]

_ROUND = 64


def rings(sections: NDArray[np.float64], *, ring: bool = False) -> Mesh:
    """Skin over polygons of shape (n_sections, n, 3), each joined to the next: a ring, or capped at both ends."""
    count, n, _ = sections.shape
    corner = np.arange(n)
    faces = []
    for k in range(count if ring else count - 1):
        here, there = k * n + corner, (k + 1) % count * n + corner
        onward, there_onward = np.roll(here, -1), np.roll(there, -1)
        faces += [np.column_stack([here, onward, there_onward]), np.column_stack([here, there_onward, there])]
    vertices = sections.reshape(-1, 3)
    if not ring:
        vertices = np.vstack([vertices, sections[0].mean(axis=0), sections[-1].mean(axis=0)])
        for k, middle, turned in ((0, count * n, True), (count - 1, count * n + 1, False)):
            here = k * n + corner
            fan = np.column_stack([np.full(n, middle), here, np.roll(here, -1)])
            faces.append(fan[:, ::-1] if turned else fan)
    return vertices, np.concatenate(faces).astype(np.int64)


def circle(n: int = _ROUND) -> NDArray[np.float64]:
    """Corners of a circle of radius 1, shape (n, 2)."""
    turn = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(turn), np.sin(turn)])


def turned(profile: list[tuple[float, float]], *, ring: bool = False) -> Mesh:
    """What a profile of (radius, height) makes on a potter's wheel, from below upward on the outside."""
    return rings(
        np.array([np.column_stack([radius * circle(), np.full(_ROUND, height)]) for radius, height in profile]),
        ring=ring,
    )


def upright(section: NDArray[np.float64], low: float, high: float) -> Mesh:
    """A prism on a polygon of shape (n, 2)."""
    return rings(np.array([np.column_stack([section, np.full(len(section), z)]) for z in (low, high)]))


def lying(section: NDArray[np.float64], length: float) -> Mesh:
    """A prism along x on a polygon of (y, z)."""
    return rings(np.array([np.column_stack([np.full(len(section), x), section]) for x in (-length / 2, length / 2)]))


def together(*meshes: Mesh) -> Mesh:
    """Several bodies as one mesh."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.vstack([vertices for vertices, _ in meshes]), np.vstack(faces)


def mug() -> Mesh:
    """A cup with a handle on one side."""
    radius, wall, tall = 0.37, 0.05, 0.95
    cup = turned([(radius, 0), (radius, tall), (radius - wall, tall), (radius - wall, 0.06), (1e-4, 0.06)])
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 17)
    along = np.column_stack([radius - 0.025 + 0.23 * np.cos(turn), np.zeros(17), 0.5 * tall + 0.27 * np.sin(turn)])
    out = np.column_stack([np.cos(turn), np.zeros(17), np.sin(turn)])
    bar = 0.055 * circle(16)
    sections = along[:, None] + bar[None, :, :1] * np.array([0.0, 1.0, 0.0]) - bar[None, :, 1:] * out[:, None]
    return together(cup, rings(sections))


def bottle() -> Mesh:
    """A round body with shoulders and a neck."""
    return turned([(0.5, 0), (0.5, 0.9), (0.42, 1.1), (0.2, 1.3), (0.16, 1.4), (0.16, 1.8)])


def bowl() -> Mesh:
    """A shell on a foot, open above."""
    outside = [(0.22, 0.0), (0.24, 0.03), (0.36, 0.14), (0.45, 0.29), (0.5, 0.5)]
    inside = [(0.44, 0.5), (0.39, 0.31), (0.30, 0.18), (0.18, 0.09), (1e-4, 0.07)]
    return turned(outside + inside)


def ball() -> Mesh:
    """A ball."""
    height = np.linspace(-np.pi / 2, np.pi / 2, 25)[1:-1]
    return turned([(0.5 * float(np.cos(h)), 0.5 + 0.5 * float(np.sin(h))) for h in height])


def brick() -> Mesh:
    """A brick that lies flat."""
    return upright(np.array([[-0.5, -0.24], [0.5, -0.24], [0.5, 0.24], [-0.5, 0.24]]), 0.0, 0.45)


def can() -> Mesh:
    """A tin with a rim below and above."""
    return turned(
        [(0.47, 0), (0.5, 0.03), (0.5, 0.08), (0.48, 0.1), (0.48, 1.3), (0.5, 1.32), (0.5, 1.37), (0.47, 1.4)]
    )


def pen() -> Mesh:
    """A thick six-sided pen that lies, pointed at one end."""
    hexagon = 0.19 * circle(6)
    low = hexagon[:, 1].min()
    middle = np.array([0.0, -low])
    shape = [(-0.5, 0.95), (-0.47, 1.0), (0.22, 1.0), (0.46, 0.3), (0.5, 0.12)]
    return rings(np.array([np.column_stack([np.full(6, x), hexagon * scale + middle]) for x, scale in shape]))


def die() -> Mesh:
    """A cube with its corners and edges taken off."""
    half, cut = 0.5, 0.09
    section = np.array(
        [
            (half, -half + cut), (half, half - cut), (half - cut, half), (-half + cut, half),
            (-half, half - cut), (-half, -half + cut), (-half + cut, -half), (half - cut, -half),
        ]
    )  # fmt: skip
    heights = ((0.0, 1 - cut / half), (cut, 1.0), (1 - cut, 1.0), (1.0, 1 - cut / half))
    return rings(np.array([np.column_stack([section * scale, np.full(8, z)]) for z, scale in heights]))


def wedge() -> Mesh:
    """A doorstop: its top slopes down along x."""
    vertices, faces = upright(np.array([[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]), 0.0, 1.0)
    slope = np.interp(vertices[:, 0], [-0.5, 0.5], [0.9, 0.15])
    return vertices * np.column_stack([np.ones((len(vertices), 2)), slope]), faces


def funnel() -> Mesh:
    """A funnel that stands on its wide rim, its spout up."""
    outside = [(0.5, 0.0), (0.5, 0.05), (0.15, 0.6), (0.11, 1.1)]
    inside = [(0.05, 1.1), (0.08, 0.6), (0.43, 0.0)]
    return turned(outside + inside, ring=True)


FORMS: dict[str, Callable[[], Mesh]] = {
    make.__name__: make for make in (mug, bottle, bowl, ball, brick, can, pen, die, wedge, funnel)
}


def make_meshes(folder: Path, *, size_m: float = 0.08) -> dict[str, Path]:
    """Write the ten as STL, scaled so that the larger level extent of each is `size_m`; return their files by name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for name, make in FORMS.items():
        vertices, faces = make()
        vertices = vertices * (size_m / np.ptp(vertices[:, :2], axis=0).max())
        files[name] = folder / f"{name}.stl"
        write_stl(files[name], SurfaceMesh(vertices, faces, np.zeros(len(vertices))))
    return files


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size-m", type=float, default=0.08)
    options = parser.parse_args()
    for name, path in make_meshes(options.folder, size_m=options.size_m).items():
        print(f"{name:7s} {path}")


if __name__ == "__main__":
    main()
