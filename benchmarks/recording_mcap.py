"""MCAP: how fast frames are written and read, and what recording at a thousand frames a second takes.

Run: ``python -m benchmarks.recording_mcap`` (seed 0; CPU seconds, the median of five).
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from benchmarks._figures import figure, share
from varishold.live import Recorder, Stream, source_at
from varishold.live.sample_file import Limits
from varishold.recording import Pad, Recording, read, write
from varishold.recording.mcap import Moments

SEED, FRAMES, ROUNDS = 0, 100_000, 5
RECORDED_S, RATE_HZ = 20, 1000


def frames() -> np.ndarray:
    """A noisy skin that is pressed now and then."""
    rng = np.random.default_rng(SEED)
    rest = rng.normal(200, 4, (FRAMES, 16, 16))
    y, x = np.mgrid[:16, :16]
    ball = 3000 * np.maximum(1 - np.hypot(x - 7.5, y - 7.5) / 5, 0)
    for start in range(2000, FRAMES, 5000):
        rest[start : start + 1000] += ball
    return rest.astype(np.uint16)


def cpu_s(work: Callable[[], object]) -> float:
    """The median CPU time of a call, threads included."""
    taken = []
    for _ in range(ROUNDS):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return float(np.median(taken))


def messages(path: Path) -> int:
    """Count a file's messages by the package mcap, which takes none apart."""
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())


def container(folder: Path) -> None:
    """Print what writing and reading take."""
    recording = Recording({"pad": Pad(frames(), pitch_m=1e-3)}, time_s=np.arange(FRAMES) / RATE_HZ)
    path = folder / "many.mcap"
    wrote = FRAMES / cpu_s(lambda: write(recording, path))
    again = read(path)
    assert np.array_equal(again.pads["pad"].frames, recording.pads["pad"].frames)
    got = FRAMES / cpu_s(lambda: read(path))
    one_by_one = FRAMES / cpu_s(lambda: sum(1 for _ in Moments(path)))
    theirs = FRAMES / cpu_s(lambda: messages(path))
    raw = recording.pads["pad"].frames.nbytes
    print(f"{FRAMES} frames of 16 x 16 uint16, {raw / 1e6:.0f} MB:")
    print(f"    written: {figure('written', wrote, ',.0f', 'frames per CPU s')}")
    print(f"    read: {figure('read', got, ',.0f', 'frames per CPU s', bar='>= 60000')}")
    print(f"    read one by one, as replay does: {figure('one by one', one_by_one, ',.0f', 'frames per CPU s')}")
    print(f"    messages alone, by the package mcap: {figure('by mcap', theirs, ',.0f', 'messages per CPU s')}")
    print(f"    size: {share('size beside the plain numbers', path.stat().st_size / raw)} of the plain numbers")


def recorder(folder: Path) -> None:
    """Print what recording takes beside the simulated skin itself."""
    address = f"sim:sphere?seed={SEED}&rate_hz={RATE_HZ}"
    path = folder / "live.mcap"

    def spent_s(record: bool) -> tuple[float, int, int]:
        with Stream(source_at(address), keep=4096) as stream:
            assert stream.wait_open(60)
            begun = resource.getrusage(resource.RUSAGE_SELF)
            if record:
                with Recorder(stream, path, limits=Limits(seconds=RECORDED_S)) as writes:
                    writes.wait(10 * RECORDED_S)
                samples, missed = writes.tally.samples, writes.missed
            else:
                time.sleep(RECORDED_S)
                samples, missed = stream.received, 0
            ended = resource.getrusage(resource.RUSAGE_SELF)
        return ended.ru_utime + ended.ru_stime - begun.ru_utime - begun.ru_stime, samples, missed

    alone, _, _ = spent_s(record=False)
    whole, samples, missed = spent_s(record=True)
    print(f"{RATE_HZ} frames of 16 x 16 a second for {RECORDED_S} s, {os.cpu_count()} processors:")
    print(f"    recorded: {figure('recorded', samples, '.0f', 'frames')}")
    print(f"    missed: {figure('missed', missed, '.0f', 'frames', bar='0')}")
    print(f"    the recorder's share of a core: {share('share of a core', max(whole - alone, 0) / RECORDED_S)}")


def main(argv: Sequence[str] = ()) -> None:
    """Print the figures."""
    with tempfile.TemporaryDirectory() as folder:
        container(Path(folder))
        recorder(Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])
