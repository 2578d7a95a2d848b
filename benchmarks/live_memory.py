"""Hours of watching in fast time: what the watcher, its touches and its events take of memory.

The skin is that of `live_zero` (drift, creep, a held contact, presses all day long), watched as `varishold live`
watches it. Memory is what the process holds, by the system's count, after the first hour and at the end.

    python -m benchmarks.live_memory [--hours H] [--seed N]
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks._drifting_skin import DriftingSkin, World
from benchmarks._figures import figure
from varishold.live import Sample, Watcher
from varishold.live.event_log import EventLog

_RATE_HZ, _PRESSES_AN_HOUR = 20.0, 60


def watch(n_hours: float, seed: int) -> None:
    """Watch for so many hours of the skin's time; print what that took."""
    world = World.of_hours(n_hours, rate_hz=_RATE_HZ, n_presses=round(_PRESSES_AN_HOUR * n_hours))
    skin = DriftingSkin(world, seed)
    log, k, early, told = EventLog(), 0, 0.0, 0
    begun, spent = time.process_time(), 0.0
    with Watcher() as watcher:
        for times, frames in skin.blocks():
            drawn = time.process_time()
            for time_s, frame in zip(times.tolist(), frames, strict=True):
                seen = watcher.see(Sample(time_s, time_s, k, {"pad": frame}))
                told += sum(event.kind == "touched" for event in seen.pads["pad"].events)
                log.add_seen(seen)
                k += 1
            spent += time.process_time() - drawn
            if not early and times[-1] > min(3600.0, world.lasts_s / 2):
                early = _held_mb()
        late = _held_mb()
    print(
        f"{n_hours:g} hours, {k} frames, {told} touches told of {len(skin.presses) + 1} presses: the process holds "
        f"{early:.0f} MB after {min(1.0, n_hours / 2):g} hours and "
        f"{figure('memory grows by', late - early, '.1f', 'MB', bar='flat')} more at the end; "
        f"{figure('watching: a frame', 1e6 * spent / k, '.0f', 'us CPU')} a frame "
        f"({time.process_time() - begun:.0f} s in all)"
    )


def main(argv: Sequence[str] = ()) -> None:
    """Print what hours of watching take."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(list(argv))
    watch(asked.hours, asked.seed)


def _held_mb() -> float:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    return pages * 4096 / 1e6
