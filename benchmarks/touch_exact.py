"""Names given by fitting forms through the skin, beside the learned table's on the same frames, and what they cost."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._scores import Scores
from benchmarks.touch_skins import SETTINGS, frames
from varishold.skin import Skin
from varishold.touch import find_contacts, recognize
from varishold.touch.exact import recognize_exact
from varishold.touch.relief import relief_of

# Seeds of the generator of `benchmarks.touch_skins` that neither it nor the choice of a constant uses.
FIRST_SEED = 500
FRAMES_PER_KIND = 16


def score(setting: int, *, first_seed: int, per_kind: int) -> None:
    """Print the figures of one setting."""
    name, skin, side, pitch, noise, *_ = SETTINGS[setting]
    fitted, learned, seconds, factor = Scores(), Scores(), [], []
    named = frames(skin, side, pitch, noise, first_seed + setting, per_kind)
    for truth, frame in named:
        contacts = find_contacts(frame, pitch=pitch)
        if not contacts:
            for scores in (fitted, learned):
                scores.add(truth, "unknown", 1.0)
            continue
        start = time.process_time()
        relief = relief_of(contacts[0], skin, among=contacts)
        surface = recognize_exact(contacts[0], skin, relief=relief)
        seconds.append(time.process_time() - start)
        fitted.add(truth, surface.name, surface.probability)
        best = next(iter(surface.fits.values()))
        factor.append(best.chi2 / surface.count)
        table = recognize(contacts[0], relief=relief)
        learned.add(truth, table.name, table.probability)
    # The first frames compile code and make operators.
    milliseconds = 1e3 * np.array(seconds[5:])
    of = f"{name}, noise {noise:.0%}"
    print(f"{of}, fitted through the skin:")
    fitted.report(f"{of}, fitted")
    print(f"{of}, learned table on the same frames:")
    learned.report(f"{of}, learned table")
    print(f"  chi^2 a taxel of the best fit: median {np.median(factor):.2f}, 95 % {np.percentile(factor, 95):.2f}")
    print(
        "  CPU a frame, reconstruction included: "
        f"median {figure(f'{of}: median', np.median(milliseconds), '.0f', 'ms')}, "
        f"95 % {np.percentile(milliseconds, 95):.0f} ms, "
        f"longest {figure(f'{of}: longest', milliseconds.max(), '.0f', 'ms', bar='<= 200')}"
    )
    if skin.thickness_m is not None:
        for wrong in (0.7, 1.3):
            right = _right_with(replace(skin, thickness_m=wrong * skin.thickness_m), named, pitch)
            what = f"thickness in the skin file {wrong:.0%} of the true one"
            print(f"  {what}: right name {share(f'{of}, {what}: right name', right, '.2f')}")


def _right_with(skin: Skin, named: list[tuple[str, np.ndarray]], pitch: float) -> float:
    scores = Scores()
    for truth, frame in named:
        for contact in find_contacts(frame, pitch=pitch)[:1]:
            surface = recognize_exact(contact, skin)
            scores.add(truth, surface.name, surface.probability)
    return float(scores.right.sum()) / len(named)


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures of every setting, or of those whose numbers are given."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--setting", type=int, choices=range(len(SETTINGS)), action="append", help="only this one")
    for setting in parser.parse_args(list(argv)).setting or range(len(SETTINGS)):
        score(setting, first_seed=FIRST_SEED, per_kind=FRAMES_PER_KIND)


if __name__ == "__main__":
    main(sys.argv[1:])
