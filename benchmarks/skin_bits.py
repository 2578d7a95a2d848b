"""What a recognition costs in bits: VARISHOLD's sections against reading every taxel at 12 bits.

Random presses (seeded) into a layer of 6 mm, Poisson's ratio .45, 16 x 16 taxels of 2 mm, 1 mm deep, 1 % noise. The
recognizer is given only what the sections say, sum X_i dtheta_i. Sent are a bit a taxel and threshold (raster),
or each taxel's address once, when it first fires, and an end mark a threshold (events).

Run: python -m benchmarks.skin_bits [presses a form] [picture.png]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._figures import figure, share
from varishold.skin import PressDraw, Skin, Taxels, draw_press, varishold_sections
from varishold.solids import SOLIDS
from varishold.touch import find_contacts, recognize

SEED = 2089
LEVELS = (2, 3, 4, 6, 8, 12, 16, 24, 32)
DRAW = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), (16, 16), 2e-3, size_taxels=(5, 12), taxels=Taxels(noise=0.01))


def named(frame: NDArray[np.float64]) -> str:
    """Return the name of a frame's largest contact, ridge and hip as one."""
    contacts = find_contacts(frame, pitch=2e-3)
    if not contacts:
        return "none"
    name = recognize(max(contacts, key=lambda contact: contact.profile.area[-1])).name
    return "ridge" if name == "hip" else name


def main(argv: Sequence[str] = ()) -> None:
    """Print bits and shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--presses", type=int, default=20, help="of each solid")
    parser.add_argument("--figure", type=Path, help="write the curves here")
    asked = parser.parse_args(list(argv))
    rng = np.random.default_rng(SEED)
    presses = [draw_press(rng, DRAW, solid=solid) for solid in SOLIDS for _ in range(asked.presses)]
    truth = ["ridge" if press.name == "hip" else press.name for press in presses]
    taxels = DRAW.shape[0] * DRAW.shape[1]
    read = np.mean([named(press.frame) == name for press, name in zip(presses, truth, strict=True)])
    print(f"{len(presses)} presses, seed {SEED}")
    print(f"every taxel at 12 bits: {12 * taxels} bits, right {share('every taxel at 12 bits: right', read)}")
    curves: dict[str, list[float]] = {"raster": [], "events": []}
    shares: list[float] = []
    for count in LEVELS:
        sections = [varishold_sections(press.frame, count) for press in presses]
        right = np.mean([named(one.rebuilt()) == name for one, name in zip(sections, truth, strict=True)])
        raster = np.mean([one.bits(coding="raster") for one in sections])
        events = np.mean([one.bits(coding="events") for one in sections])
        shares.append(float(right))
        curves["raster"].append(float(raster))
        curves["events"].append(float(events))
        of = f"{count:2d} thresholds"
        in_raster, in_events = (
            figure(f"{of}: {coding}", mean, "5.0f", "bits") for coding, mean in (("raster", raster), ("events", events))
        )
        print(f"{of}: raster {in_raster}, events {in_events}, right {share(f'{of}: right', right)}")
    if asked.figure is not None:
        from benchmarks._bits_figure import BitsCurve, write_bits_figure

        write_bits_figure(
            asked.figure,
            [
                BitsCurve("sections, a bit a taxel and threshold", curves["raster"], shares),
                BitsCurve("sections, an address a taxel", curves["events"], shares),
                BitsCurve("every taxel at 12 bits", [12.0 * taxels], [float(read)]),
            ],
            title="16 x 16 taxels on a layer of 6 mm, 1 % noise",
        )


if __name__ == "__main__":
    main(sys.argv[1:])
