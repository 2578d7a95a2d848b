"""Live sources: what serial skins' bytes cost, what damage costs, how soon a pulled cable is told.

    python -m benchmarks.live_sources

Seed 0. CPU seconds, but for the cable, which is a pair of pseudo-terminals on the clock of a machine that may be busy.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks._figures import figure
from benchmarks._skin_senders import SENDERS, Frame, frames_of
from varishold.live import Stream, samples_of, source_at
from varishold.live.framing import Framing, decoder_of, framing_of

SEED = 0
FRAMES = 1000
# Share of bytes that are changed, and of frames from which some bytes are lost.
CHANGED, CUT = 1e-3, 0.05


def _framing(name: str) -> Framing:
    return framing_of(name).with_shape((6, 6)) if name == "arduino-line" else framing_of(name)


def _key(pads: Frame) -> tuple[tuple[str, bytes], ...]:
    return tuple(sorted((name, values.tobytes()) for name, values in pads.items()))


def _decoded(name: str, data: bytes, piece: int = 1000) -> list[tuple[tuple[str, bytes], ...]]:
    decoder = decoder_of(_framing(name))
    found = []
    for at in range(0, len(data), piece):
        found += [_key(dict(reading.pads)) for reading in decoder.feed(data[at : at + piece])]
    return found


def _changed(part: bytes, rng: np.random.Generator) -> bytes:
    raw = np.frombuffer(part, np.uint8).copy()
    hit = rng.random(raw.size) < CHANGED
    raw[hit] ^= rng.integers(1, 256, int(hit.sum()), np.uint8)
    return raw.tobytes()


def _cut(part: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() > CUT:
        return part
    at, lost = int(rng.integers(0, len(part))), int(rng.integers(1, 40))
    return part[:at] + part[at + lost :]


def damage(name: str, harm: Callable[[bytes, np.random.Generator], bytes]) -> tuple[float, int]:
    """Return the share of untouched frames that come out, and the most of them that are missing on end."""
    rng = np.random.default_rng(SEED)
    frames = frames_of(name, FRAMES, SEED)
    sent = [SENDERS[name].bytes_of(frame) for frame in frames]
    harmed = [harm(part, rng) for part in sent]
    found = set(_decoded(name, b"".join(harmed)))
    untouched = come = missing = worst = 0
    # The last ones may be waiting for what comes behind them.
    for frame, before, after in list(zip(frames, sent, harmed, strict=True))[:-4]:
        if before != after:
            missing = 0
            continue
        untouched += 1
        here = _key(frame) in found
        come += here
        missing = 0 if here else missing + 1
        worst = max(worst, missing)
    return come / untouched, worst


def decoders() -> None:
    print(f"{'preset':16} {'frames/CPU s':>12}  {CHANGED:.1%} of bytes changed    bytes lost from {CUT:.0%} of frames")
    for name in SENDERS:
        data = b"".join(SENDERS[name].bytes_of(frame) for frame in frames_of(name, FRAMES, SEED))
        decoder, begun = decoder_of(_framing(name)), time.process_time()
        count = sum(len(decoder.feed(data[at : at + 1000])) for at in range(0, len(data), 1000))
        rate = count / (time.process_time() - begun)
        words = [figure(f"{name}: frames a CPU second", rate, "12.0f")]
        for what, harm in (("changed", _changed), ("lost", _cut)):
            share, worst = damage(name, harm)
            words += [
                figure(f"{name}: untouched frames that come out, bytes {what}", 100 * share, "6.2f", "%"),
                figure(f"{name}: untouched frames missing on end, bytes {what}", worst, "d", bar="<= 2"),
            ]
        print(f"{name:16} {'  '.join(words)}")


def floods() -> None:
    rng = np.random.default_rng(SEED)
    worst = 0.0
    for name in SENDERS:
        heads = SENDERS[name].bytes_of(frames_of(name, 1, SEED)[0])[:2]
        for flood in (rng.integers(0, 256, 500_000, np.uint8).tobytes(), heads * 250_000, bytes(500_000)):
            decoder, begun = decoder_of(_framing(name)), time.process_time()
            for at in range(0, len(flood), 1000):
                decoder.feed(flood[at : at + 1000])
            worst = max(worst, (time.process_time() - begun) / len(flood))
    said = figure("CPU of a megabyte of nonsense, worst", 1e6 * worst, ".2f", "s")
    print(f"a megabyte of nonsense, noise or nothing but heads, takes at most {said}")


def pulled_cable(rounds: int = 10) -> None:
    if sys.platform == "win32":
        return
    import tty

    late = []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            skin, other = os.openpty()
            tty.setraw(other)
            port = Path(folder, "port")
            port.symlink_to(os.ttyname(other))
            os.close(other)
            with Stream(source_at(f"serial:{port}?preset=flexitac")) as stream:
                stream.wait_open(10)
                pulled_s = time.time()
                port.unlink()
                os.close(skin)
                while stream.state != "lost":
                    time.sleep(1e-3)
                late.append(next(c.host_time_s for c in stream.changes if c.state == "lost") - pulled_s)
    said = figure("a pulled cable is told after, worst", max(late), ".3f", "s", bar="<= 1")
    print(f"a pulled cable is told after {said}, the worst of {rounds}")


def simulated() -> None:
    for shape in ("16x16", "32x32"):
        source, begun = source_at(f"sim:all?speed=0&duration_s=60&shape={shape}"), time.process_time()
        count = sum(1 for _ in samples_of(source))
        said = figure(f"sim: {shape}, frames a CPU second", count / (time.process_time() - begun), ".0f")
        print(f"sim: {shape}: {said} frames a CPU second")
    begun, wall = time.process_time(), time.monotonic()
    with Stream(source_at("sim:sphere?rate_hz=1000&duration_s=3"), keep=4096) as stream:
        reader = stream.reader()
        count = sum(1 for _ in reader)
    share = (time.process_time() - begun) / (time.monotonic() - wall)
    said = figure(
        "a stream of 1000 frames/s of 16 x 16: share of a core, the simulation with it", 100 * share, ".0f", "%"
    )
    lost = figure("a stream of 1000 frames/s: frames missed", 3000 - count, ".0f", bar="0")
    print(f"1000 frames/s of 16 x 16 through a stream: {said} of a core, the simulation with it; missed: {lost}")


def main() -> int:
    decoders()
    floods()
    pulled_cable()
    simulated()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
