"""Many frames and large ones: the cost of a taxel, of threads, and the memory of a million frames.

CPU time of one thread but for the threads themselves, which are measured by the clock, taken in turns, the best of ten.

    python -m benchmarks.streams
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks._figures import figure
from varishold.levelset import find_contacts, find_contacts_batch

SEED = 31
FRAMES = 1_000_000
MOST_MB = 300
# Runs the command in a process of its own, and says how many kB of memory it took at most.
RUN = """
import sys
from varishold.cli.app import run
status = run()
with open("/proc/self/status") as told:
    print(next(line.split()[1] for line in told if line.startswith("VmHWM")), file=sys.stderr)
sys.exit(status)
"""


def ball(rng: np.random.Generator, side: int, reach: float) -> np.ndarray:
    """Return a frame with one round contact of peak 1 and 1 % noise."""
    y, x = np.mgrid[:side, :side]
    depth = np.hypot(x - 0.5 * side, y - 0.5 * side) / (reach * side)
    return np.maximum(1 - depth**2, 0) + rng.normal(0, 0.01, (side, side))


def nanoseconds_a_taxel(side: int, rounds: int) -> float:
    """Return the median CPU time of `find_contacts` over the frame's taxels.

    Every frame is another: of a small one that comes again and again the processor remembers which way its branches go,
    as it cannot of a sensor's, nor of a large one (a quarter less at 128 x 128).
    """
    rng = np.random.default_rng(SEED)
    find_contacts(ball(rng, side, 0.3))
    taken = []
    for _ in range(rounds):
        frame = ball(rng, side, 0.3)
        begun = time.process_time_ns()
        find_contacts(frame)
        taken.append(time.process_time_ns() - begun)
    return float(np.median(taken)) / side**2


def gain_of_two_threads(rounds: int = 10) -> float:
    """Return the best gain of two threads over one, each on as many frames, in turns."""
    rng = np.random.default_rng(SEED)
    halves = [np.array([ball(rng, 16, rng.uniform(0.1, 0.4)) for _ in range(4000)]) for _ in range(2)]
    gains = []
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(find_contacts_batch, halves))
        for _ in range(rounds):
            begun = time.perf_counter()
            for half in halves:
                find_contacts_batch(half)
            alone = time.perf_counter() - begun
            begun = time.perf_counter()
            list(pool.map(find_contacts_batch, halves))
            gains.append(alone / (time.perf_counter() - begun))
    return max(gains)


def write_frames(path: Path, n: int) -> None:
    """Write frames of 16 x 16 taxels of 8 bits: noise on an offset, and a press every 5000."""
    rng = np.random.default_rng(SEED)
    rest = np.rint(20 + rng.normal(0, 2, (5000, 16, 16)))
    rest[1000:1050] += np.rint(150 * np.maximum(ball(rng, 16, 0.3), 0))
    block = rest.clip(0, 255).astype(np.uint8)
    out = np.lib.format.open_memmap(path, "w+", np.uint8, (n, 16, 16))
    for start in range(0, n, len(block)):
        out[start : start + len(block)] = block[: n - start]
    out.flush()


def main() -> None:
    """Print what many frames and large ones cost."""
    small, large = nanoseconds_a_taxel(128, 40), nanoseconds_a_taxel(2000, 5)
    print("find_contacts, 32 levels, CPU time a taxel:")
    print(f"    128 x 128: {figure('128 x 128: a taxel', small, '.1f', 'ns')}")
    print(f"    2000 x 2000: {figure('2000 x 2000: a taxel', large, '.1f', 'ns')}")
    print(
        f"    the one over the other: {figure('2000 x 2000 over 128 x 128', large / small, '.2f', 'times', bar='<= 2')}"
    )
    gain = figure("two threads over one", gain_of_two_threads(), ".2f", "times", bar=">= 1.7")
    print(f"batches of 16 x 16 in two threads, the best of ten: {gain}; {os.cpu_count()} processors")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "frames.npy")
        write_frames(path, FRAMES)
        begun = time.perf_counter()
        arguments = [sys.executable, "-c", RUN, "touch", str(path), "--frames", "all", "--json"]
        done = subprocess.run(arguments, capture_output=True, text=True, check=True)
        seconds = time.perf_counter() - begun
    most = figure("a million frames: memory", int(done.stderr.split()[-1]) / 1000, ".0f", "MB", bar=f"<= {MOST_MB}")
    print(f"varishold touch --frames all, {FRAMES} frames of 16 x 16, one in a hundred pressed:")
    print(f"    {most}, {figure('a million frames: time', seconds, '.0f', 's')}")
    print(f"    {figure('a million frames: answers', done.stdout.count(chr(10)), '.0f')} answers")


if __name__ == "__main__":
    main()
