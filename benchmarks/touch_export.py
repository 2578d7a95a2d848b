"""Names of the exported recognizer beside Python's, over drawn frames: by the size of the pad and the kind of weights.

Then names that own presses taught (`learn --portable`), over presses of another simulated day (`learn_days`): of the
ten things that were learned, and of as many strangers.

Needs a C compiler and make. What a Cortex-M4F needs is printed by ``pytest -s tests/test_touch_export.py -k emulated``.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._figures import share
from benchmarks.learn_days import PRESSES, THINGS, draw_days, draw_thing, presses
from varishold.learning import PortableClassifier
from varishold.learning.portable import strongest_frames
from varishold.touch.course.presses import as_presses
from varishold.touch.writers import Export, c99_files
from varishold.touch.writers.vectors import check_vectors

FRAMES, SEED = 1000, 5
SHAPES = ((9, 8), (16, 16), (32, 32))
BARS = {"int8": ">= 99", "float32": ">= 100"}


def learned_there(shape: tuple[int, int]) -> Export:
    """Return an export of what presses of a simulated day taught, tested on those of another."""
    rng = np.random.default_rng((SEED, *shape))
    things = [draw_thing(rng, shape) for _ in range(2 * THINGS)]
    one, two = draw_days(rng, shape)
    clf = PortableClassifier().fit(*presses(things[:THINGS], one, PRESSES, rng))
    felt = as_presses(presses(things, two, FRAMES // len(things), rng)[0])
    frames = [strongest_frames(press)["pad_0"] for press in felt]
    return Export(parameters=replace(clf.networks["pad_0"], examples=np.array(frames, dtype=np.float32)))


def same_names(wanted: Export) -> tuple[int, str]:
    """Export, compile and run; return how many names are the same, and what the test says."""
    vectors = check_vectors(wanted, FRAMES, seed=SEED)[:FRAMES]
    with tempfile.TemporaryDirectory() as folder:
        for name, text in c99_files(wanted, vectors).items():
            Path(folder, name).write_text(text, encoding="utf-8")
        done = subprocess.run(["make", "-s", "test"], cwd=folder, capture_output=True, text=True, check=False)
    said = done.stdout.splitlines()[-1] if done.stdout else done.stderr
    found = re.match(r"(\d+) of \d+", said)
    return int(found[1]) if found else 0, said


def main() -> None:
    """Print how many names are the same."""
    for what, exported in {"": lambda shape: Export(shape=shape), ", own things": learned_there}.items():
        for shape in SHAPES:
            wanted = exported(shape)
            for weights, bar in BARS.items():
                same, said = same_names(replace(wanted, weights=weights))
                of = f"{weights}, {shape[0]} x {shape[1]}{what}"
                print(f"{of}: {share(f'{of}: same names', same / FRAMES, bar=bar)}: {said}", flush=True)


if __name__ == "__main__":
    main()
