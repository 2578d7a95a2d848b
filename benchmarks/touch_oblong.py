"""Names on taxels that are longer than broad, where the pitch says so.

The yardstick's faces, as height maps of 32 x 32, of which so many rows and columns are one taxel; noise of 1.5 % of the
peak. Square taxels stand beside them: oblong ones show no less, and are not to be wrong for sure.

    python -m benchmarks.touch_oblong
"""

from __future__ import annotations

import numpy as np

from benchmarks._drawn_frames import frames
from benchmarks._figures import share
from benchmarks.touch_distortions import SURE, Tally, answer_of
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.rows import as_one

SEED = 82
PER_KIND = 30
SIDE = 32
NOISE = 0.015
BAR = 0.01
#: Rows and columns that are one taxel.
TAXELS = ((1, 1), (2, 1), (1, 2), (2, 2), (4, 1), (1, 4), (4, 4))


def answers(rows: int, cols: int) -> Tally:
    """Return the answers given on taxels of so many rows and columns."""
    drawn, kinds = frames("ideal", SIDE, Change(), PER_KIND, SEED)
    rng, tally = np.random.default_rng([SEED, rows, cols]), Tally()
    for face, kind in zip(drawn, kinds.tolist(), strict=True):
        read = face.reshape(SIDE // rows, rows, SIDE // cols, cols).mean(axis=(1, 3))
        read = read / read.max() + NOISE * rng.standard_normal(read.shape)
        tally.add((as_one(kind),), answer_of(read, pitch=(1e-3 * rows, 1e-3 * cols)))
    return tally


def main() -> None:
    """Print the shares."""
    for rows, cols in TAXELS:
        f = answers(rows, cols).figures()
        of = f"taxels of {rows} x {cols}, {SIDE // rows} x {SIDE // cols} of them"
        wrong = share(f"{of}: wrong with p > {SURE:g}", f["wrong_sure"], "4.1f", bar=f"<= {100 * BAR:.0f}")
        right, unknown = (share(f"{of}: {key}", f[key], "5.1f") for key in ("right", "unknown"))
        print(f"  {of:36} wrong with p > {SURE:g} {wrong}  right {right}  unknown {unknown}", flush=True)


if __name__ == "__main__":
    main()
