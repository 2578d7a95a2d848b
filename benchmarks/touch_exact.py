"""Names given by fitting forms through the skin, beside the learned table's on the same frames, and what they cost."""

from __future__ import annotations

import sys
import time

import numpy as np

from benchmarks._scores import Scores
from benchmarks.touch_skins import SETTINGS, frames
from varishold.touch import find_contacts, recognize
from varishold.touch.exact import recognize_exact
from varishold.touch.relief import relief_of

# Seeds of the generator of `benchmarks.touch_skins` that neither it nor the choice of a constant uses.
FIRST_SEED = 500
FRAMES_PER_KIND = 16
#: The settings of `benchmarks.touch_skins` whose speed and share are told here.
FITTED_SETTINGS = 2


def score(setting: int, *, first_seed: int, per_kind: int) -> None:
    """Print the figures of one setting."""
    name, skin, side, pitch, noise, *_ = SETTINGS[setting]
    fitted, learned, seconds, factor = Scores(), Scores(), [], []
    for truth, frame in frames(skin, side, pitch, noise, first_seed + setting, per_kind):
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
    print(f"{name}, noise {noise:.0%}, fitted through the skin:")
    fitted.report()
    print(f"{name}, noise {noise:.0%}, learned table on the same frames:")
    learned.report()
    print(f"  chi^2 a taxel of the best fit: median {np.median(factor):.2f}, 95 % {np.percentile(factor, 95):.2f}")
    print(
        f"  CPU a frame, reconstruction included: median {np.median(milliseconds):.0f} ms, "
        f"95 % {np.percentile(milliseconds, 95):.0f} ms, longest {milliseconds.max():.0f} ms (bar 200 ms)"
    )


def main() -> None:
    """Print the figures of every setting, or of those whose numbers are given."""
    chosen = [int(word) for word in sys.argv[1:] if word.isdigit()] or list(range(FITTED_SETTINGS))
    for setting in chosen:
        score(setting, first_seed=FIRST_SEED, per_kind=FRAMES_PER_KIND)


if __name__ == "__main__":
    main()
