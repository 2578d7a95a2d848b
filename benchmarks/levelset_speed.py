"""Speed of `find_contacts` against what one would otherwise write, at the same thresholds.

CPU time of one thread, peers interleaved frame by frame in one process, medians over frames and rounds.
Peers: OpenCV, per level threshold, findContours, moments and minAreaRect of each contour and
connectedComponentsWithStats; and contourpy's lines (on a frame closed by a low rim) with a compiled shoelace for
the totals of area, perimeter and moments alone. Frames: one to three cones, domes or flat bumps with 1 % noise.

    python -m benchmarks.levelset_speed
"""

from __future__ import annotations

import ctypes
import importlib.util
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import contourpy
import cv2
import numpy as np

from benchmarks._figures import figure
from varishold.levelset.contacts import find_contacts, find_contacts_batch

SEED = 11
LEVELS = 64
NOISE = 0.01
# Rows, columns, frames, rounds.
SIZES = ((16, 16, 24, 15), (32, 32, 24, 10), (64, 64, 16, 8), (240, 320, 6, 4))
SHOELACE = """
#include <math.h>
#include <stdint.h>

void shoelace(const double *points, const uint32_t *offsets, int n, double *out)
{
    for (int k = 0; k < n; k++) {
        for (uint32_t i = offsets[k]; i + 1 < offsets[k + 1]; i++) {
            const double x0 = points[2 * i], y0 = points[2 * i + 1], x1 = points[2 * i + 2], y1 = points[2 * i + 3];
            const double cross = x0 * y1 - x1 * y0;
            out[0] += cross / 2;
            out[1] += cross * (x0 + x1) / 6;
            out[2] += cross * (y0 + y1) / 6;
            out[3] += cross * (x0 * x0 + x0 * x1 + x1 * x1) / 12;
            out[4] += cross * (x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0) / 24;
            out[5] += cross * (y0 * y0 + y0 * y1 + y1 * y1) / 12;
            out[6] += sqrt((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0));
        }
    }
}
"""
GOALS = {"OpenCV": {16: 25, 64: 16, 240: 18}, "contourpy": {16: 9, 32: 9, 64: 8}}
BATCH_GOAL = 60_000


def frame_with_contacts(rng: np.random.Generator, rows: int, cols: int) -> np.ndarray:
    """Return a frame of peak about 1 with one to three contacts and noise."""
    y, x = np.mgrid[0:rows, 0:cols]
    frame = np.zeros((rows, cols))
    for _ in range(rng.integers(1, 4)):
        radius = rng.uniform(0.15, 0.35) * rows
        cy, cx = rng.uniform(0.1, 0.9) * rows, rng.uniform(0.1, 0.9) * cols
        depth = np.hypot((x - cx) * rng.uniform(0.7, 1.3), y - cy) / radius
        frame = np.maximum(frame, rng.uniform(0.5, 1) * np.maximum(1 - depth ** rng.choice([1, 2, 4]), 0))
    return frame + rng.normal(0, NOISE * frame.max(), frame.shape)


def shoelace(points: np.ndarray, offsets: np.ndarray, out: np.ndarray) -> None:
    """Add the area, the moments and the length of closed lines to out."""
    compiled()(points.ctypes.data, offsets.ctypes.data, offsets.size - 1, out.ctypes.data)


@cache
def compiled() -> Callable[..., None]:
    """Compile the shoelace as the kernel is compiled, and return it."""
    spec = importlib.util.spec_from_file_location("native_build", Path(__file__).parents[1] / "native" / "build.py")
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "shoelace.c"), Path(folder, "shoelace.so")
        source.write_text(SHOELACE)
        fast = [*build.FLAGS, *build.variants(build.machine("")[0]).get("avx2", ())]
        subprocess.run([*build.compiler(), *fast, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
        function = ctypes.CDLL(str(library)).shoelace
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p]
    function.restype = None
    return function


def contourpy_totals(frame: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return per level the totals of area, moments and perimeter, from closed lines."""
    generator = contourpy.contour_generator(z=frame, name="serial", line_type="ChunkCombinedOffset")
    totals = np.zeros((levels.size, 7))
    for i, level in enumerate(levels):
        points, offsets = generator.lines(level)
        if points[0] is not None:
            shoelace(points[0], offsets[0], totals[i])
    return totals


def opencv_sections(frame: np.ndarray, levels: np.ndarray) -> list[int]:
    """Return per level the number of parts, having asked for all that OpenCV can tell of them."""
    values = frame.astype(np.float32)
    parts = []
    for level in levels:
        on = cv2.threshold(values, float(level), 255, cv2.THRESH_BINARY)[1].astype(np.uint8)
        contours, _ = cv2.findContours(on, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        for contour in contours:
            cv2.moments(contour)
            cv2.minAreaRect(contour)
        parts.append(cv2.connectedComponentsWithStats(on, connectivity=4)[0] - 1)
    return parts


def check_equality(frame: np.ndarray, levels: np.ndarray) -> float:
    """Return the largest relative difference of total areas from contourpy's, where no contact has ended."""
    floor = 0.05 * float(frame.max())
    rows, cols = frame.shape
    x, y = (np.r_[-0.5, np.arange(n), n - 0.5] for n in (cols, rows))
    generator = contourpy.contour_generator(
        x, y, np.pad(frame, 1, mode="edge"), name="serial", fill_type="ChunkCombinedOffset"
    )
    contacts = find_contacts(frame, levels, floor=floor)
    ends = max(c.floor for c in contacts)
    worst = 0.0
    for i, level in enumerate(levels):
        # A bump between contacts that have ended belongs to none of them.
        if level < ends or contacts[0].frame.label[1:-1, 1:-1][frame > level].min() < 0:
            break
        total = np.zeros(7)
        points, offsets = generator.filled(level, np.inf)
        shoelace(points[0], offsets[0], total)
        area = sum(c.profile.area[i] for c in contacts)
        worst = max(worst, abs(area / total[0] - 1))
    return worst


def cpu(call: Callable[[], object]) -> float:
    start = time.process_time_ns()
    call()
    return (time.process_time_ns() - start) / 1e3


def main() -> None:
    cv2.setNumThreads(1)
    rng = np.random.default_rng(SEED)
    print(f"find_contacts, {LEVELS} levels, everything but outlines; medians of CPU time, seed {SEED}")
    for rows, cols, n_frames, rounds in SIZES:
        frames = [frame_with_contacts(rng, rows, cols) for _ in range(n_frames)]
        levels = [np.linspace(1.0, 0.06, LEVELS, endpoint=False) * f.max() * 0.999 for f in frames]
        worst = max(check_equality(f, t) for f, t in zip(frames, levels, strict=True))
        assert worst < 1e-9, worst
        closed = [np.pad(f, 1, constant_values=-1.0) for f in frames]
        taken: dict[str, list[float]] = {"varishold": [], "its own levels": [], "OpenCV": [], "contourpy": []}
        for _ in range(rounds):
            for f, c, t in zip(frames, closed, levels, strict=True):
                taken["varishold"].append(cpu(lambda f=f, t=t: find_contacts(f, t)))
                taken["OpenCV"].append(cpu(lambda f=f, t=t: opencv_sections(f, t)))
                taken["its own levels"].append(cpu(lambda f=f: find_contacts(f, LEVELS)))
                taken["contourpy"].append(cpu(lambda c=c, t=t: contourpy_totals(c, t)))
        ours = np.array(taken["varishold"])
        of = f"{rows} x {cols}"
        own = figure(f"{of}: levels of its own", np.median(taken["its own levels"]), ".0f", "us")
        print(
            f"{of}: {figure(f'{of}: levels of the peers', np.median(ours), '.0f', 'us')} at the peers' levels, "
            f"{own} at {LEVELS} of each contact's own; areas equal to {worst:.0e}"
        )
        for peer, goals in GOALS.items():
            bar = f">= {goals[rows]}" if rows in goals else ""
            ratio = figure(f"{of}: as fast as {peer}", np.median(np.array(taken[peer]) / ours), ".1f", "times", bar=bar)
            print(f"    {ratio} as fast as {peer} ({np.median(taken[peer]):.0f} us)")
    frames = np.array([frame_with_contacts(rng, 16, 16) for _ in range(500)])
    shared = np.linspace(1.0, 0.06, LEVELS, endpoint=False)
    ways = {"32 levels": 32, f"{LEVELS} levels": LEVELS, f"{LEVELS} levels, the same for all": shared}
    for way, levels in ways.items():
        find_contacts_batch(frames[:2], levels)
        rates = [len(frames) / (cpu(lambda t=levels: find_contacts_batch(frames, t)) * 1e-6) for _ in range(15)]
        of = f"many frames a call, 16 x 16, {way}"
        print(f"{of}: {figure(of, np.median(rates), '.0f', 'frames/s', bar=f'>= {BATCH_GOAL}')}")


if __name__ == "__main__":
    main()
