"""Five-step grasps a minute: without search, with search, and with taxel pads at step 5.

Run: ``python -m benchmarks.hand_speed [--grasps 40]``. Processor time of one process, so that other work on the
machine counts less; two cores make twice as many, for grasps share nothing.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

import numpy as np

from benchmarks._figures import figure
from varishold.hand import TABLE_5_OBJECTS, HandSetting, PadSetting, grasp_object

_FIRST_SEED = 3_000_000_000

#: Wanted on two cores.
_WANTED = {"place known": 800, "searched": 400, "place known, pads at step 5": 150}


def main(argv: Sequence[str] = ()) -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--grasps", type=int, default=40, help="grasps of each kind")
    options = parser.parse_args(list(argv))
    kinds = {
        "place known": HandSetting(),
        "searched": HandSetting(search=True),
        "place known, pads at step 5": HandSetting(pads=PadSetting()),
    }
    for setting in kinds.values():
        grasp_object("cylinder", 0.09, seed=_FIRST_SEED, setting=setting)
    seconds: dict[str, list[float]] = {kind: [] for kind in kinds}
    for n in range(options.grasps):
        name, size_m = TABLE_5_OBJECTS[n % 10]
        for kind, setting in kinds.items():
            start = time.process_time()
            grasp_object(name, size_m, seed=_FIRST_SEED + n, setting=setting)
            seconds[kind].append(time.process_time() - start)
    for kind, spent in seconds.items():
        each = float(np.mean(spent))
        rate = figure(kind, 2 * 60 / each, ".0f", "a minute on two cores", bar=f">= {_WANTED[kind]}")
        print(f"{kind}: {1e3 * each:.0f} ms a grasp (median {1e3 * float(np.median(spent)):.0f}), {rate}")


if __name__ == "__main__":
    main(sys.argv[1:])
