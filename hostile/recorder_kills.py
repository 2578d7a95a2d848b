"""A recorder killed at random moments: every file opens, holds what the skin said, and lacks at most its last second.

The skin is a simulated one, whose readings are known: each file must hold the first so many of them, none left out.
Every fifth kill may come before the first reading, the others come up to four seconds after it.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from varishold.errors import VarisholdError
from varishold.live import samples_of, source_at
from varishold.recording import read
from varishold.recording.mcap import gather

__all__ = ["Killed", "kills", "main"]

_PROGRAM = (sys.executable, "-c", "from varishold.cli import main; main()")
_RATE_HZ, _LONGEST_S = 1000, 4.0
# A recorder that has not begun after so long never will.
_BEGINS_S = 120.0
_MOST_MISSING_S = 1.0


@dataclass(frozen=True)
class Killed:
    """What a kill left.

    Parameters
    ----------
    readings : int
        In the file; 0 where there is none yet.
    missing_s : float
        From the last of them to the kill.
    fault : str
        What is wrong; empty where nothing is.
    """

    readings: int
    missing_s: float
    fault: str


def kills(number: int, *, seed: int = 0, rate_hz: float = _RATE_HZ) -> Iterator[Killed]:
    """Kill a recorder so many times, and yield what each left."""
    rng = np.random.default_rng(seed)
    source = f"sim:sphere?seed={seed}&rate_hz={rate_hz:g}&shape=8x8"
    with tempfile.TemporaryDirectory() as folder:
        for k in range(number):
            path = Path(folder, f"{k}.mcap")
            killed_s = _kill_once(source, path, float(rng.uniform(0, _LONGEST_S)), at_once=k % 5 == 4)
            yield _left(source, path, killed_s)


def _kill_once(source: str, path: Path, after_s: float, *, at_once: bool) -> float:
    """Kill a recorder after some time, which begins with its first reading or at once; return when that was."""
    begun_s = time.monotonic()
    process = subprocess.Popen([*_PROGRAM, "record", source, "-o", str(path)], stdout=subprocess.DEVNULL)
    while not (at_once or path.exists()) and process.poll() is None and time.monotonic() - begun_s < _BEGINS_S:
        time.sleep(0.002)
    time.sleep(after_s)
    process.kill()
    killed_s = time.time()
    process.wait()
    return killed_s


def _left(source: str, path: Path, killed_s: float) -> Killed:
    if not path.exists():
        return Killed(0, 0.0, "")
    try:
        recording, series = read(path), gather(path).pads["pad"]
    except VarisholdError as error:
        return Killed(0, 0.0, f"it does not open: {error}")
    n = recording.n_frames
    missing_s = killed_s - float(series.log_ns[-1]) / 1e9
    known = np.array([sample.pads["pad"] for sample in islice(samples_of(source_at(f"{source}&speed=0")), n)])
    if series.sequence is None or not np.array_equal(series.sequence, np.arange(n)):
        return Killed(n, missing_s, "readings are left out")
    if not np.array_equal(recording.pads["pad"].frames, known):
        return Killed(n, missing_s, "its frames are not those of the skin")
    if not any("has no end" in remark for remark in recording.remarks):
        return Killed(n, missing_s, "it does not say that it breaks off")
    return Killed(n, missing_s, f"{missing_s:.2f} s are missing" if missing_s > _MOST_MISSING_S else "")


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--number", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    done: list[Killed] = []
    for killed in kills(given.number, seed=given.seed):
        done.append(killed)
        if killed.fault:
            print(f"kill {len(done) - 1}: {killed.fault}", flush=True)
        print(f"\r{len(done)} kills", end="", file=sys.stderr)
    print(file=sys.stderr)
    begun = [killed for killed in done if killed.readings]
    faults = sum(bool(killed.fault) for killed in done)
    print(
        f"{len(done)} kills of a recorder at {_RATE_HZ} readings a second, {len(begun)} of them with readings, "
        f"{sum(killed.readings for killed in begun)} in all: {faults} faults; missing at most "
        f"{max((killed.missing_s for killed in begun), default=0.0):.2f} s, in the median "
        f"{np.median([killed.missing_s for killed in begun] or [0.0]):.2f} s"
    )
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
