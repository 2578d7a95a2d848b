"""Names of the exported recognizer beside Python's, over drawn frames: by the size of the pad and the kind of weights.

Needs a C compiler and make. What a Cortex-M4F needs is printed by ``pytest -s tests/test_touch_export.py -k emulated``.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

from benchmarks._figures import share
from varishold.touch.writers import Export, c99_files
from varishold.touch.writers.vectors import check_vectors

FRAMES, SEED = 1000, 5
SHAPES = ((9, 8), (16, 16), (32, 32))
BARS = {"int8": ">= 99", "float32": ">= 100"}


def same_names(wanted: Export) -> tuple[int, str]:
    """Export, compile and run; return how many names are the same, and what the test says."""
    vectors = check_vectors(wanted, FRAMES, seed=SEED)
    with tempfile.TemporaryDirectory() as folder:
        for name, text in c99_files(wanted, vectors).items():
            Path(folder, name).write_text(text, encoding="utf-8")
        done = subprocess.run(["make", "-s", "test"], cwd=folder, capture_output=True, text=True, check=False)
    said = done.stdout.splitlines()[-1] if done.stdout else done.stderr
    found = re.match(r"(\d+) of \d+", said)
    return int(found[1]) if found else 0, said


def main() -> None:
    """Print how many names are the same."""
    for weights, bar in BARS.items():
        for shape in SHAPES:
            wanted = replace(Export(shape=shape), weights=weights)
            same, said = same_names(wanted)
            of = f"{weights}, {shape[0]} x {shape[1]}"
            print(f"{of}: {share(f'{of}: same names', same / FRAMES, bar=bar)}: {said}")


if __name__ == "__main__":
    main()
