"""Surfaces of strangers after twelve touches, each made where it would tell most: how far off, and how honest the band.

Four kinds of thing that no library knows, in two sizes, and lumps made by chance, each clamped to the table where the
hand must search for it. None of these, and no seed of these, was felt while anything was chosen: that was done on
cylinders, boxes, prisms, balls, frustums, pyramids and lumps of lower numbers. Distances are those of points drawn
evenly by area from the true surface to the mesh. A hand cannot reach the face that stands on the table: figures are
over all else, and over everything. The way back, from the mesh to the true surface, is printed beside them: it counts
what is too much. The band is the signed distance's mean -+ 1.645 standard deviations; it holds a true point where
zero lies in it.

Run: python -m benchmarks.perceive_shape [--touches N] [--seed N]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from benchmarks._evaluation_hand import WHAT_DIFFERS, evaluation_setting
from benchmarks._figures import figure, share
from benchmarks._true_surface import distances_m, mesh_points_m, true_points
from varishold.exploration import SurfaceExploration, explore_surface
from varishold.hand.objects import STRANGERS, graspable

_FIRST_SEED = 8_200_000_000
_THINGS = (
    *((name, size_m) for name in STRANGERS for size_m in (0.06, 0.08)),
    *((f"lump-{k}", 0.07) for k in range(901, 905)),
)
_POINTS, _DENSE = 6000, 60_000
_BAND_SIGMAS = 1.645
# What stands on the table looks down, and lies no higher than this. Metres.
_FOOT_M = 5e-4


@dataclass(frozen=True)
class Scored:
    """One surface against the truth: distances in metres, and which true points the band holds."""

    off_m: np.ndarray
    held: np.ndarray
    reached: np.ndarray
    back_m: np.ndarray


def scored(felt: SurfaceExploration) -> Scored:
    """Compare a surface with the true one."""
    solid = graspable(felt.name, felt.size_m)
    origin, axes = felt.pose
    own, normals = true_points(solid, _POINTS)
    places = own @ axes.T + origin
    distance, sigma = felt.surface.distance(places)
    dense = cKDTree(true_points(solid, _DENSE, seed=1)[0] @ axes.T + origin)
    mesh = mesh_points_m(felt.mesh, _POINTS)
    mesh = mesh[mesh[:, 2] > origin[2] + 2 * _FOOT_M]
    return Scored(
        distances_m(places, felt.mesh),
        np.abs(distance) <= _BAND_SIGMAS * sigma,
        (own[:, 2] > _FOOT_M) | (normals[:, 2] > -0.9),
        dense.query(mesh)[0],
    )


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--touches", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(list(argv))
    setting = replace(evaluation_setting(), clamped=True)
    print(f"{options.touches} touches of each stranger, seed {options.seed}; {WHAT_DIFFERS}\n")
    print(f"{'':<22}{'reachable':>10}{'all':>9}{'back':>9}{'in the band':>13}{'sigma':>9}   touches")
    everything = []
    for k, (name, size_m) in enumerate(_THINGS):
        seed = _FIRST_SEED + 1000 * options.seed + k
        felt = explore_surface(name, size_m, seed=seed, touches=options.touches, setting=setting)
        one = scored(felt)
        everything.append(one)
        label = f"{name} {1e3 * size_m:.0f} mm"
        kinds = "".join(touch.kind[0] for touch in felt.touches)
        off = figure(f"{label}: mean distance", 1e3 * one.off_m[one.reached].mean(), "10.2f")
        held = share(f"{label}: in the band", one.held[one.reached].mean(), "11.1f")
        rest = f"{1e3 * one.off_m.mean():9.2f}{1e3 * one.back_m.mean():9.2f}{held}{1e3 * felt.history_m[-1]:9.2f}"
        print(f"{label:<22}{off}{rest}   {kinds}", flush=True)
    _print_together(everything)


def _print_together(everything: list[Scored]) -> None:
    """Print means over all things, each counted alike."""

    def mean(values: list[float]) -> float:
        return float(np.mean(values))

    reach = [float(1e3 * each.off_m[each.reached].mean()) for each in everything]
    near = figure("mean distance, reachable", mean(reach), ".2f", "mm", bar="<= 3")
    print(f"\nmean distance, what a hand can reach: {near}")
    print(f"largest of the {len(reach)}: {figure('largest mean distance, reachable', max(reach), '.2f', 'mm')}")
    far = mean([float(1e3 * np.quantile(each.off_m[each.reached], 0.95)) for each in everything])
    print(f"95 % of the points within: {figure('95 % within, reachable', far, '.2f', 'mm')}")
    all_ = mean([float(1e3 * each.off_m.mean()) for each in everything])
    print(f"mean distance, with the face on the table: {figure('mean distance, all', all_, '.2f', 'mm')}")
    back = mean([float(1e3 * each.back_m.mean()) for each in everything])
    print(f"from the mesh back to the true surface: {figure('mean distance, back', back, '.2f', 'mm')}")
    held = mean([float(each.held[each.reached].mean()) for each in everything])
    print(f"true points in the 90 % band, reachable: {share('in the band, reachable', held, bar='85 to 97')}")
    whole = mean([float(each.held.mean()) for each in everything])
    print(f"true points in the 90 % band, all: {share('in the band, all', whole)}")


if __name__ == "__main__":
    main(sys.argv[1:])
