"""The side that nobody touched: solids touched on one half, and what is said of the other half.

None of these solids, and no seed of these, was used while anything was chosen: that was done on other blocks, upright
and lying cylinders, ellipsoids, a ball, an L-block, a frustum of a cone and lumps of other numbers. Points of
the true surface are drawn evenly by area, without the face on the table. A solid is cut in two halves of equal area,
upright or nearly so, along its own axes or anyhow; what is longer than 140 mm is touched on one third, at its end.
Touches fall by chance on one part, five points each, which are .7 mm off, with normals that are 7 degrees off. Two of
three solids stand on a table. The band is the signed distance's mean -+ 1.645 standard deviations; it holds a true
point where zero lies in it. Around the surface, up to 20 mm from it on each axis, it holds a place where the true
signed distance lies in it.

Run: python -m benchmarks.perceive_far [--touches N] [--solids N] [--seed N]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from benchmarks._figures import figure, share
from benchmarks._true_surface import corners_of, true_points
from varishold.hand.objects import graspable
from varishold.perceive import ImplicitSurface, SurfaceContacts
from varishold.solids import Part, Solid

Floats = NDArray[np.float64]

_FIRST_SEED = 8_300_000_000
_POINTS, _DENSE, _POINTS_A_TOUCH, _SPOT = 2500, 20_000, 5, 40
_OFF_M, _OFF_NORMAL = 0.0007, 0.12
_BAND_SIGMAS = 1.645
# What stands on the table looks down, and lies no higher than this; no place is judged lower than that. Metres.
_FOOT_M, _LOW_M, _AROUND_M = 5e-4, 0.003, 0.02
_LONG_M = 0.14


@dataclass(frozen=True)
class _Parts:
    """A solid of a few convex pieces."""

    parts: tuple[Part, ...]

    def body(self) -> tuple[Part, ...]:
        return self.parts


def _block(*lengths_m: tuple[float, float, float, float, float]) -> _Parts:
    """Blocks that stand side by side: lengths along x, y and z, and the middle's x and y."""
    return _Parts(
        tuple(
            replace(Part.box(x, y, z), centre_m=(at_x, at_y, Part.box(x, y, z).centre_m[2]))
            for x, y, z, at_x, at_y in lengths_m
        )
    )


def _lying(length_m: float, diameter_m: float) -> _Parts:
    turn = 2 * np.pi * np.arange(60) / 60
    ring = diameter_m / 2 * np.column_stack([0 * turn, np.cos(turn), 1 + np.sin(turn)])
    along = length_m / 2 * np.array([1.0, 0.0, 0.0])
    return _Parts((Part.hull(np.vstack([ring - along, ring + along])),))


_KINDS: dict[str, Callable[[], Solid | _Parts]] = {
    "cube 50 mm": partial(_block, (0.05, 0.05, 0.05, 0, 0)),
    "block 80 mm": partial(_block, (0.08, 0.045, 0.07, 0, 0)),
    "block 110 mm": partial(_block, (0.11, 0.07, 0.05, 0, 0)),
    "block 180 mm": partial(_block, (0.18, 0.05, 0.05, 0, 0)),
    "narrow cylinder": lambda: _Parts((Part.cylinder(0.05, 0.13),)),
    "broad cylinder": lambda: _Parts((Part.cylinder(0.095, 0.06),)),
    "lying cylinder 80 mm": partial(_lying, 0.08, 0.06),
    "lying cylinder 150 mm": partial(_lying, 0.15, 0.045),
    "tall ellipsoid": lambda: _Parts((Part.ellipsoid(0.06, 0.06, 0.1),)),
    "flat ellipsoid": lambda: _Parts((Part.ellipsoid(0.12, 0.08, 0.05),)),
    "L-block": partial(_block, (0.11, 0.04, 0.06, 0, 0), (0.04, 0.06, 0.06, 0.035, 0.05)),
    "T-block": partial(_block, (0.1, 0.035, 0.07, 0, 0), (0.035, 0.06, 0.07, 0, 0.0475)),
    "stepped block": partial(_block, (0.06, 0.06, 0.1, 0, 0), (0.05, 0.06, 0.05, 0.055, 0)),
    "hexagonal prism": partial(graspable, "hexagonal-prism", 0.08),
    "half cylinder": partial(graspable, "half-cylinder", 0.08),
    **{f"lump {k}": partial(graspable, f"lump-{k}", 0.08) for k in range(31, 35)},
}


@dataclass(frozen=True)
class Told:
    """What is told of one part: shares of true points and of places in the band, mean error and deviation in metres."""

    held: float
    held_around: float
    off_m: float
    sigma_m: float


def touched(points: Floats, normals: Floats, some: Floats, touches: int, rng: np.random.Generator) -> SurfaceContacts:
    """Touch the points that `some` holds and that do not look down."""
    some = np.flatnonzero(some & (normals[:, 2] > -0.5))
    spots = [some[np.argsort(((points[some] - points[k]) ** 2).sum(axis=1))[:_SPOT]] for k in rng.choice(some, touches)]
    felt = np.concatenate([rng.choice(spot, _POINTS_A_TOUCH, replace=False) for spot in spots])
    return SurfaceContacts(
        points[felt] + _OFF_M * rng.normal(size=(len(felt), 3)),
        normals[felt] + _OFF_NORMAL * rng.normal(size=(len(felt), 3)),
        touch=np.repeat(np.arange(touches), _POINTS_A_TOUCH),
    )


def compared(solid: Solid | _Parts, *, touches: int, seed: int, number: int) -> dict[str, Told]:
    """Touch a solid on one part, and compare what is said of that part (near) and of the other one (far)."""
    rng = np.random.default_rng(seed)
    points, normals = true_points(solid, _POINTS, seed=seed)
    stands, long = number % 3 != 2, float(np.ptp(points[:, 0])) > _LONG_M
    quarters = rng.integers(2) * 2 if long else rng.integers(4) if number % 2 else rng.uniform(0, 4)
    toward = points @ [np.cos(quarters * np.pi / 2), np.sin(quarters * np.pi / 2), 0.2]
    far = toward < np.quantile(toward, 2 / 3 if long else 1 / 2)
    surface = ImplicitSurface(touched(points, normals, ~far, touches, rng), table_m=0.0 if stands else None)
    open_ = (points[:, 2] > _FOOT_M) | (normals[:, 2] > -0.9)
    around = points + rng.uniform(-_AROUND_M, _AROUND_M, points.shape)
    true = _signed_distance(solid, around, seed)
    on, off = surface.distance(points), surface.distance(around)
    held, held_around = np.abs(on[0]) <= _BAND_SIGMAS * on[1], np.abs(off[0] - true) <= _BAND_SIGMAS * off[1]
    high = open_ & (around[:, 2] > _LOW_M)
    return {
        name: Told(
            float(held[part & open_].mean()),
            float(held_around[part & high].mean()),
            float(np.abs(on[0])[part & open_].mean()),
            float(on[1][part & open_].mean()),
        )
        for name, part in (("near", ~far), ("far", far))
    }


def _signed_distance(solid: Solid | _Parts, places: Floats, seed: int) -> Floats:
    """Signed distance from the true surface without the face on the table."""
    points, normals = true_points(solid, _DENSE, seed=seed + 1)
    away, _ = cKDTree(points[(points[:, 2] > _FOOT_M) | (normals[:, 2] > -0.9)]).query(places)
    inside = np.zeros(len(places), bool)
    for part in solid.body():
        faces = ConvexHull(corners_of(part)).equations
        inside |= (places @ faces[:, :3].T + faces[:, 3]).max(axis=1) < 0
    return np.where(inside, -away, away)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--touches", type=int, default=12)
    parser.add_argument("--solids", type=int, default=12, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(list(argv))
    print(f"{options.touches} touches on one part of each solid, {options.solids} of each kind, seed {options.seed}\n")
    columns = f"{'around':>9}{'off':>8}{'sigma':>8}"
    print(f"{'':<24}{'far: held':>11}{columns}{'near: held':>14}{columns}")
    kinds = []
    for k, (name, made) in enumerate(_KINDS.items()):
        first = _FIRST_SEED + 100_000 * options.seed + 1000 * k
        solids = [
            compared(made(), touches=options.touches, seed=first + number, number=number)
            for number in range(options.solids)
        ]
        kinds.append({part: _mean([each[part] for each in solids]) for part in ("far", "near")})
        far, near = kinds[-1]["far"], kinds[-1]["near"]
        held = share(f"{name}: far, in the band", far.held, "9.1f")
        print(f"{name:<24}{held}{_rest(far)}{100 * near.held:12.1f} %{_rest(near)}", flush=True)
    print(
        f"\nleast kind: {share('far, in the band, least kind', min(each['far'].held for each in kinds), bar='>= 80')}"
    )
    for part, bar in (("far", ">= 88"), ("near", "")):
        all_ = _mean([each[part] for each in kinds])
        print(f"{part}: true points in the 90 % band {share(f'{part}, in the band', all_.held, bar=bar)}")
        print(f"{part}: places around in it {share(f'{part}, around, in the band', all_.held_around)}")
        print(f"{part}: mean distance said {figure(f'{part}, mean off', 1e3 * all_.off_m, '.1f', 'mm')}")
        print(f"{part}: standard deviation {figure(f'{part}, sigma', 1e3 * all_.sigma_m, '.1f', 'mm')}")


def _rest(told: Told) -> str:
    return f"{100 * told.held_around:7.1f} %{1e3 * told.off_m:8.1f}{1e3 * told.sigma_m:8.1f}"


def _mean(all_: list[Told]) -> Told:
    rows = np.mean([[each.held, each.held_around, each.off_m, each.sigma_m] for each in all_], axis=0)
    return Told(*rows.tolist())


if __name__ == "__main__":
    main(sys.argv[1:])
