"""Reading, writing and judging recordings: how fast, in how much memory, how well.

Run: ``python -m benchmarks.recording [--rows N]`` (seed 0; CPU seconds; N grasp rows, one million by default).
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks._figures import figure
from varishold.frame import frame_noise
from varishold.frame.noise import noise_sigma
from varishold.recording import (
    Pad,
    Recording,
    iter_grasp_table,
    peak_frame,
    presses,
    read,
    write,
)
from varishold.solids import SOLIDS, draw_contact, ideal_frame


def _median_seconds(call: object, repeats: int = 2000) -> float:
    call()  # type: ignore[operator]
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()  # type: ignore[operator]
        times.append(time.process_time() - start)
    return float(np.median(times))


def _noisy_frames(n: int, count: int, noise: float) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    frames = []
    for k in range(count):
        drawn = draw_contact(
            rng, list(SOLIDS)[k % len(SOLIDS)], field_m=(n * 1e-3,) * 2, size_m=(n * 0.4e-3, n * 0.75e-3)
        )
        frame = ideal_frame(drawn.solid, (n, n), 1e-3, depth_m=drawn.depth_m, pose=drawn.pose)
        frames.append(frame / frame.max() + rng.normal(0, noise, (n, n)))
    return frames


def noise_accuracy() -> None:
    print("noise of single frames under random contacts of every solid: estimate / truth")
    for n, noise in ((16, 0.02), (16, 0.005), (32, 0.01)):
        ratio = np.array([frame_noise(frame) / noise for frame in _noisy_frames(n, 700, noise)])
        low, middle, high = np.quantile(ratio, (0.05, 0.5, 0.95))
        of = f"{n} x {n}, {noise:.1%}"
        middle = figure(f"noise, estimate / truth, {of}: median", middle, ".2f")
        print(f"  {of}: median {middle}, 5-95 % {low:.2f} to {high:.2f}, largest {ratio.max():.2f}")


def noise_speed() -> None:
    for n in (16, 32, 64, 240):
        frame = _noisy_frames(n, 1, 0.02)[0]
        usable = np.ones(frame.shape, bool)
        seconds = _median_seconds(lambda f=frame, u=usable: noise_sigma(f, u))
        of = f"noise_sigma, {n} x {n}"
        print(f"{of}: {figure(of, seconds * 1e6, '.1f', 'us')} a frame")


def million_frames(folder: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 4, (1_000_000, 16, 16), dtype=np.uint8)
    frames[500_000:500_400, 4:9, 4:9] = 200
    for name, save in (
        ("million.npz", lambda p: write(Recording({"pad": Pad(frames)}), p)),
        ("million.npy", lambda p: np.save(p, frames)),
    ):
        path = folder / name
        start = time.process_time()
        save(path)
        wrote = time.process_time()
        recording = read(path)
        loaded = time.process_time()
        assert peak_frame(recording) in range(500_000, 500_400)
        assert presses(recording) == [range(500_000, 500_400)]
        done = time.process_time()
        print(
            f"{name}, 16 x 16 uint8: written in {figure(f'{name}: written', wrote - start, '.1f', 's')}, "
            f"read and checked in {figure(f'{name}: read and checked', loaded - wrote, '.1f', 's')}, "
            f"peak and presses found in {figure(f'{name}: peak and presses', done - loaded, '.1f', 's')}"
        )
        path.unlink()


def grasp_rows(folder: Path, rows: int) -> None:
    rng = np.random.default_rng(0)
    path = folder / "grasps.csv"
    names = [f"switch.v{k}" for k in range(12)] + [f"angle_rad.j{k}" for k in range(6)]
    block = [
        f"object{k % 36},0.03,{k},0,1,"
        + ",".join(map(str, rng.integers(0, 2, 12)))
        + ","
        + ",".join(f"{angle:.5f}" for angle in rng.normal(size=6))
        for k in range(10_000)
    ]
    text = "\n".join(block) + "\n"
    with path.open("w") as file:
        file.write("object,size_m,seed,step,held," + ",".join(names) + "\n")
        for _ in range(rows // 10_000):
            file.write(text)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    n = sum(len(chunk) for chunk in iter_grasp_table(path))
    seconds = time.process_time() - start
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    print(
        f"grasp table, {n} rows of 23 columns ({path.stat().st_size / 1e6:.0f} MB): "
        f"{figure('grasp table', n / seconds, ',.0f', 'rows/s')}, "
        f"peak memory grew by {figure('grasp table: peak memory grew by', grown, '.0f', 'MB')}"
    )


def csv_frames(folder: Path) -> None:
    path = folder / "frames.csv"
    frames = np.random.default_rng(0).integers(0, 4096, (20_000, 256))
    np.savetxt(path, frames, fmt="%d", delimiter=",")
    start = time.process_time()
    recording = read(path, shape=(16, 16))
    seconds = time.process_time() - start
    assert np.array_equal(recording.pads["pad"].frames.reshape(-1, 256), frames)
    print(f"plain CSV of 16 x 16, a frame a line: {figure('plain CSV', len(frames) / seconds, ',.0f', 'frames/s')}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rows", type=int, default=1_000_000)
    rows = parser.parse_args(list(argv)).rows
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        grasp_rows(folder, rows)
        csv_frames(folder)
        million_frames(folder)
    noise_accuracy()
    noise_speed()


if __name__ == "__main__":
    main(sys.argv[1:])
