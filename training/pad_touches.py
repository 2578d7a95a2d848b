"""Make the touches by which a library learns how a pad's numbers scatter under poorer taxels.

Run: ``python -m training.pad_touches``, about a minute on two cores. Known things and lumps are touched in every way
with ideal taxels; of each thing some touches are kept at random, with the frame of every pressed pad in 255 steps of
its peak. Examples from 95000 on: seeds below 100,000.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from training.objects import draw_example
from varishold.exploration import Felt, grip_contacts, touch_all
from varishold.exploration.object_examples import example_setting
from varishold.files import write_archive
from varishold.hand import OBJECTS, HandSetting, PadSetting, run_jobs
from varishold.hand.pads import PadFrames
from varishold.perceive import fit_section
from varishold.skin import Taxels

OUTPUT = Path("src/varishold/perceive/pad_touches.npz")
PART, LUMP_PART = 95_000, 97_000
_STEPS = 255


class _Make:
    """What a process does with a thing."""

    def __init__(self, each: int) -> None:
        self.each = each
        setting = example_setting()
        self.setting = replace(setting, pads=PadSetting(taxels=Taxels()))

    def __call__(self, drawn: tuple[int, int, str]) -> list[tuple[float, PadFrames]]:
        part, k, name = drawn
        size_m, seed = draw_example(part, k, name)
        felt = list(touch_all(name, size_m, seed=seed, setting=self.setting).values())
        chosen = np.sort(np.random.default_rng([seed, 5]).permutation(len(felt))[: self.each])
        made = [(_size_m(felt[j], self.setting), felt[j].step.pads) for j in chosen]
        return [(size, pads) for size, pads in made if pads is not None]


def _size_m(felt: Felt, setting: HandSetting) -> float:
    """The size that curvatures are compared with; NaN where none is known. Metres."""
    if felt.height_m is not None:
        return np.nan
    circle = fit_section(grip_contacts(felt.step.sensed, setting.design, setting.layout), "circle")
    return np.nan if circle is None else circle.size_m


def main(argv: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--examples", type=int, default=5, help="of each kind")
    parser.add_argument("--lumps", type=int, default=20)
    parser.add_argument("--each", type=int, default=2, help="touches that are kept of an example")
    parser.add_argument("--processes", type=int, default=None)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args(argv)
    jobs = [(PART, k, name) for k in range(options.examples) for name in OBJECTS]
    jobs += [(LUMP_PART, k, f"lump-{LUMP_PART + k}") for k in range(options.lumps)]
    touches = [made for each in run_jobs(jobs, _Make(options.each), processes=options.processes) for made in each]
    shapes, peaks, pitches, of, levels = [], [], [], [], []
    for k, (_, pads) in enumerate(touches):
        for name, frame in pads.frames.items():
            peak = float(frame.max())
            if peak <= 0:
                continue
            of.append(k)
            shapes.append(frame.shape)
            peaks.append(peak)
            pitches.append(pads.pitch_m[name])
            levels.append(np.round(np.clip(frame / peak, 0, 1) * _STEPS).astype(np.uint8).ravel())
    skin = PadSetting().skin
    arrays = {
        "skin": np.array([skin.thickness_m, skin.poisson, skin.sensing_depth_m, skin.youngs_modulus_pa]),
        "size_m": np.array([size for size, _ in touches], np.float32),
        "touch": np.array(of, np.int16),
        "shape": np.array(shapes, np.uint8),
        "peak": np.array(peaks, np.float32),
        "pitch_m": np.array(pitches, np.float32),
        "levels": np.concatenate(levels),
    }
    write_archive(arrays, options.output, kind="parameters")
    print(f"{options.output}: {len(of)} presses of {len(touches)} touches, {options.output.stat().st_size} bytes")


if __name__ == "__main__":
    main()
