"""The live page in a headless Chromium: how old a frame is when it is drawn, what the server costs, who delays whom.

Run by ``python -m benchmarks.live_page``. A recording of a simulated skin (16 x 16 and 32 x 32 taxels, pressed nearly
half of the time) is replayed by `varishold live` in a process of its own, whose CPU time is read from the system;
reading and replaying are part of it. Ages are those of the clock, from the moment a reading had come until it is
drawn: they tell about this page only on a machine that does nothing else, for the browser draws in software and
takes most of a core itself. CPU shares do not depend on that.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from websockets.sync.client import connect

from benchmarks._chromium import Chromium, chromium_program
from benchmarks._figures import figure, share
from varishold.live import samples_of, source_at, watch
from varishold.recording import Pad, Recording, read, write

_WATCHED_S = 20.0
_STATE = "JSON.stringify({drawn: varisholdLive.drawn, lags: varisholdLive.lags})"


def write_frames(path: Path, *, side: int, rate_hz: float, duration_s: float) -> None:
    """Write a recording of a simulated skin that is pressed by all forms in turn."""
    address = f"sim:all?seed=2&speed=0&shape={side}x{side}&rate_hz={rate_hz:g}&duration_s={duration_s:g}"
    frames = np.array([sample.pads["pad"] for sample in samples_of(source_at(address))])
    times_s = np.arange(len(frames)) / rate_hz
    write(Recording({"pad": Pad(frames, pitch_m=2e-3)}, times_s), path)


class Served:
    """`varishold live` in a process of its own."""

    def __init__(self, address: str, folder: str) -> None:
        words = [sys.executable, "-m", "varishold", "live", address, "--port", "0", "--no-open", "--folder", folder]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        told = re.match(r"http://\S+", self._process.stdout.readline())
        assert told is not None
        self.address = told[0]

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.communicate()

    def cpu_s(self) -> float:
        """Return the CPU time that it has taken so far."""
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def ask(self, do: str = "", **more: Any) -> dict[str, Any]:
        """Ask it for something; return what it says of the source then."""
        answered = not do
        with connect(self.address.replace("http", "ws") + "ws", compression=None) as page:
            if do:
                page.send(json.dumps({"do": do, **more}))
            for message in page:
                told = json.loads(message) if isinstance(message, str) else {"kind": "picture"}
                answered = answered or told["kind"] == "answer"
                if answered and told["kind"] == "status":
                    return dict(told)
        raise AssertionError


@contextmanager
def stalled_browser(server: Served) -> Iterator[None]:
    """Connect a browser that never reads what it gets."""
    with connect(server.address.replace("http", "ws") + "ws", compression=None, max_queue=1):
        yield


def watched(server: Served, seconds: float) -> dict[str, Any]:
    """Watch the page for so long; return ages in milliseconds, pictures a second, and the server's share of a core."""
    with Chromium(1240, 900) as chromium:
        chromium.open(server.address)
        chromium.wait("window.varisholdLive && varisholdLive.drawn > 50")
        chromium.value("varisholdLive.lags.length = 0")
        before, cpu, begun = chromium.value("varisholdLive.drawn"), server.cpu_s(), time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - begun
        cpu = server.cpu_s() - cpu
        state = json.loads(chromium.value(_STATE))
    ages = np.array(state["lags"])
    return {
        "p50": float(np.quantile(ages, 0.5)),
        "p99": float(np.quantile(ages, 0.99)),
        "pictures": (state["drawn"] - before) / passed,
        "cpu": cpu / passed,
    }


def show(what: str, found: dict[str, Any], *, bars: tuple[str, str] = ("", "")) -> None:
    """Print what was found of one case."""
    p50, p99 = (
        figure(f"{what}: age of a frame when drawn, {q}", found[q], ".1f", "ms", bar=bar)
        for q, bar in (("p50", ""), ("p99", bars[0]))
    )
    cpu = share(f"{what}: server, of a core", found["cpu"], bar=bars[1])
    pictures = figure(f"{what}: pictures a second", found["pictures"], ".0f")
    print(
        f"{what}: age of a frame when drawn p50 {p50}, p99 {p99}; server {cpu} of a core; {pictures} pictures a second"
    )


def recorded(folder: Path, address: str, frames: np.ndarray) -> tuple[dict[str, Any], int, int]:
    """Record while the page is watched; return what was found of the page, readings written, and readings lost."""
    with Served(address, str(folder)) as server:
        server.ask("record", on=True)
        found = watched(server, _WATCHED_S)
        server.ask("record", on=False)
        time.sleep(2)
    (file,) = folder.glob("varishold-*.mcap")
    written = read(file).pads["pad"].frames
    # The recording begins anywhere in the loop; each frame must be the one that follows the frame before.
    place = {frame.tobytes(): k for k, frame in enumerate(frames)}
    at = np.array([place[np.asarray(frame).tobytes()] for frame in written])
    return found, len(at), int(((np.diff(at) - 1) % len(frames)).sum())


def event_delay_ms(path: Path) -> tuple[float, float]:
    """Return p50 and p99 of the time from a reading that shows an event until the event is told."""
    delays: list[float] = []
    for seen in watch(f"replay:{path}?speed=1"):
        if seen.sample is not None and any(pad.events for pad in seen.pads.values()):
            delays.append(1e3 * (time.time() - seen.sample.host_time_s))
    return float(np.quantile(delays, 0.5)), float(np.quantile(delays, 0.99))


def main() -> None:
    """Print the figures."""
    if chromium_program() is None:
        print("there is no Chromium here: nothing was measured")
        return
    with tempfile.TemporaryDirectory() as folder:
        small, large = Path(folder, "small.npz"), Path(folder, "large.npz")
        write_frames(small, side=16, rate_hz=100, duration_s=30)
        write_frames(large, side=32, rate_hz=300, duration_s=10)
        with Served(f"replay:{small}?speed=1&loop=1", folder) as server:
            show("16 x 16 at 100/s", watched(server, _WATCHED_S), bars=("< 50", "< 15"))
            with stalled_browser(server):
                show("the same, beside a browser that stalls", watched(server, _WATCHED_S), bars=("< 50", "< 15"))
            left_out = server.ask()["left_out"]
            print(f"    readings left out: {figure('16 x 16 at 100/s: readings left out', left_out, 'd', bar='0')}")
        with Served(f"replay:{large}?speed=1&loop=1", folder) as server:
            show("32 x 32 at 300/s", watched(server, _WATCHED_S))
            left_out = server.ask()["left_out"]
            print(f"    readings left out: {figure('32 x 32 at 300/s: readings left out', left_out, 'd', bar='0')}")
        fast = Path(folder, "fast.npz")
        write_frames(fast, side=16, rate_hz=1000, duration_s=10)
        frames = read(fast).pads["pad"].frames
        found, written, lost = recorded(Path(folder), f"replay:{fast}?speed=1&loop=1", frames)
        show("16 x 16 at 1000/s, recorded", found)
        print(
            f"    {figure('1000/s: readings recorded', written, 'd')} recorded, "
            f"{figure('1000/s: readings lost', lost, 'd', bar='0')} of them lost"
        )
        half, most = event_delay_ms(small)
        print(
            f"from a reading to its event: p50 {figure('reading to event, p50', half, '.2f', 'ms')}, "
            f"p99 {figure('reading to event, p99', most, '.2f', 'ms', bar='<= 10')}"
        )


if __name__ == "__main__":
    main()
