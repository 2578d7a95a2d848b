"""The surface under one pad: right names, calibration, radii and time, on drawn scenes and on grasps.

``python -m benchmarks.perceive_surfaces`` (about 4 minutes on one core) draws scenes and grasps with seeds, friction,
noise and skins that nothing was learned from. All shares are over surfaces taken equally often but where said.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import figure, share
from training.pad_grasps import grasped_pads
from training.pad_scenes import NOMINAL, LabelledPad, scenes
from varishold.skin import Skin, reconstruct
from varishold.touch.pads.surface import SURFACES, feel_surface

Floats = NDArray[np.float64]

_SEED = 6_000_000_000
_RADII_M = (0.015, 0.06)
_BINS = 10


@dataclass(frozen=True)
class Felt:
    """What was felt of many pads, beside the truth; a row a pad."""

    surface: NDArray[np.intp]
    posterior: Floats
    radius_m: Floats
    read_m: Floats
    interval_m: Floats
    curvature: Floats
    read_curvature: Floats
    sigma: Floats
    nothing: int


def feel(pads: Sequence[LabelledPad], skin: Skin | None) -> Felt:
    """Feel every pad as if it had the nominal skin, or none that is known."""
    rows, nothing = [], 0
    for pad in sorted(pads, key=lambda pad: pad.frame.shape):
        felt = feel_surface(pad.frame, skin, pitch_m=pad.pitch_m)
        if felt is None:
            nothing += 1
            continue
        interval = felt.radius_interval_m or (np.nan, np.nan)
        rows.append(
            (
                pad.surface,
                felt.posterior(),
                pad.radius_m,
                felt.radius_m or np.nan,
                interval,
                pad.curvature_1_m,
                felt.curvature_1_m,
                felt.curvature_sigma_1_m,
            )
        )
    return Felt(*(np.array(column) for column in zip(*rows, strict=True)), nothing)


def calibration_error(posterior: Floats, surface: NDArray[np.intp], weight: Floats) -> float:
    """Expected calibration error of the named surface over even bins."""
    sure, right = posterior.max(axis=1), posterior.argmax(axis=1) == surface
    of = np.minimum((sure * _BINS).astype(int), _BINS - 1)
    gaps = [abs(float((weight * (sure - right))[of == b].sum())) for b in range(_BINS)]
    return sum(gaps) / float(weight.sum())


def show(title: str, felt: Felt) -> None:
    """Print the figures of one set of pads."""
    count = np.bincount(felt.surface, minlength=len(SURFACES))
    even = (1 / np.maximum(count, 1))[felt.surface]
    named = felt.posterior.argmax(axis=1)
    right = named == felt.surface
    print(f"\n{title}: {len(felt.surface)} pads, nothing felt on {felt.nothing} more")
    print(f"{'truth':>8} {'pads':>6} " + " ".join(f"{name:>7}" for name in SURFACES))
    for k, name in enumerate(SURFACES):
        row = np.bincount(named[felt.surface == k], minlength=len(SURFACES)) / max(count[k], 1)
        print(f"{name:>8} {count[k]:>6} " + " ".join(f"{value:>7.3f}" for value in row))
    loss = -np.log(np.maximum(felt.posterior[np.arange(len(named)), felt.surface], 1e-12))
    of_even = share(f"{title}: right, even surfaces", np.average(right, weights=even))
    print(f"right: {of_even} of even surfaces, {share(f'{title}: right, these pads', right.mean())} of these pads")
    of_even = figure(f"{title}: log loss, even surfaces", np.average(loss, weights=even), ".3f")
    print(f"log loss: {of_even} of even surfaces, {loss.mean():.3f} of these pads")
    # Pads as they come have a prior of their own; equal weights or that prior, the likelihoods are the same.
    own = felt.posterior * (count / count.sum())
    own /= own.sum(axis=1, keepdims=True)
    error = calibration_error(felt.posterior, felt.surface, even)
    print(
        f"expected calibration error: {figure(f'{title}: calibration error', error, '.3f')} of even surfaces, "
        f"{calibration_error(own, felt.surface, np.ones(len(named))):.3f} of these pads with their own prior"
    )
    print("reliability, all four probabilities under an equal prior: said, seen, share")
    said, weight = felt.posterior.ravel(), np.repeat(even / even.sum(), len(SURFACES))
    true = (felt.surface[:, None] == np.arange(len(SURFACES))).ravel()
    of = np.minimum((said * _BINS).astype(int), _BINS - 1)
    for b in range(_BINS):
        here = of == b
        if here.any():
            means = [float(np.average(value[here], weights=weight[here])) for value in (said, true)]
            print(f"  {means[0]:.3f}  {means[1]:.3f}  {weight[here].sum() / len(SURFACES):.3f}")
    in_range = (felt.surface == 1) & (felt.radius_m >= _RADII_M[0]) & (felt.radius_m <= _RADII_M[1])
    given = in_range & np.isfinite(felt.read_m)
    error = np.abs(felt.read_m[given] / felt.radius_m[given] - 1)
    low, high = felt.interval_m[given].T
    inside = (low <= felt.radius_m[given]) & (felt.radius_m[given] <= high)
    print(
        f"radius {1e3 * _RADII_M[0]:.0f}-{1e3 * _RADII_M[1]:.0f} mm: "
        f"median relative error {share(f'{title}: radius, median error', np.median(error))}, "
        f"95 % within {share(f'{title}: radius, 95 % within', np.quantile(error, 0.95))}, "
        f"interval holds {share(f'{title}: radius, interval holds', inside.mean())}, "
        f"median high/low {np.median(high / low):.2f}, given on {given.sum()} of {in_range.sum()}"
    )
    z = np.abs(felt.curvature - felt.read_curvature) / felt.sigma
    print(
        f"curvatures (columns, rows) within one sigma {(z < 1).mean(axis=0).round(3)}, "
        f"within two {(z < 2).mean(axis=0).round(3)}"
    )


def time_pads(pads: Sequence[LabelledPad]) -> None:
    """Print the median processor time a pad, operators made before, by shape, beside the reconstruction alone."""
    shapes: dict[tuple[int, int], list[LabelledPad]] = {}
    for pad in pads:
        shapes.setdefault(pad.frame.shape, []).append(pad)
    print("\nmilliseconds a pad: seen through the skin, reconstruction alone, bare pressure")
    for shape in sorted(shapes, key=lambda shape: (shape[0] * shape[1], shape)):
        taken: list[list[float]] = []
        for _ in range(2):
            taken = []
            for pad in shapes[shape][:40]:
                at = [time.process_time()]
                feel_surface(pad.frame, NOMINAL, pitch_m=pad.pitch_m)
                at.append(time.process_time())
                reconstruct(pad.frame, NOMINAL, pitch=pad.pitch_m, noise=0.015 * pad.frame.max())
                at.append(time.process_time())
                feel_surface(pad.frame, None, pitch_m=pad.pitch_m)
                at.append(time.process_time())
                taken.append(np.diff(at).tolist())
        milliseconds = 1e3 * np.median(taken, axis=0)
        of = f"{shape[0]:>2} x {shape[1]:>2}"
        whole = figure(f"{of}: a pad seen through the skin", milliseconds[0], ".2f", "ms")
        print(f"  {of}  {whole}  " + "  ".join(f"{value:.2f}" for value in milliseconds[1:]))


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--grasps", type=int, default=150)
    wanted = parser.parse_args(list(argv))
    drawn = list(scenes(_SEED, wanted.scenes, noise=(0.004, 0.025)))
    show("drawn scenes, skin known within 30 %", feel(drawn, NOMINAL))
    show("drawn scenes, skin unknown", feel(drawn, None))
    exact = list(scenes(_SEED + 2, wanted.scenes // 3, spread=0.0, noise=(0.004, 0.025)))
    show("drawn scenes, skin known exactly", feel(exact, NOMINAL))
    other = list(scenes(_SEED + 1, wanted.scenes // 3, skin=None, noise=(0.004, 0.025)))
    show("drawn scenes, skins of many kinds, unknown", feel(other, None))
    for scale in ((1.0, 1.0), (1.2, 1.2)):
        seeds = range(_SEED + int(1000 * scale[0]), _SEED + int(1000 * scale[0]) + wanted.grasps // 2)
        held = [
            pad
            for _, _, pad in grasped_pads(seeds, noise=(0.005, 0.02), friction=0.65, finger_scale=scale, steps=(3, 5))
        ]
        show(f"grasps, digits x {scale[0]:g}, skin known within 30 %", feel(held, NOMINAL))
        show(f"grasps, digits x {scale[0]:g}, skin unknown", feel(held, None))
        if scale[0] == 1.0:
            time_pads(held)


if __name__ == "__main__":
    main(sys.argv[1:])
