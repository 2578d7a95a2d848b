"""Live sources over a network: how soon a frame is there, what it costs, and whether all come as they were sent.

    python -m benchmarks.live_network [--frames N] [--rate-hz R]

Each sender is a process of its own on this machine. Delay is from the sender's clock just before it sends to the
return of `read`, without the first 50 frames, on a machine that may be busy; CPU time is all of the reader's process,
its library's threads with it. Where a library or the broker is not installed, its row says so.
"""

from __future__ import annotations

import argparse
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np

from benchmarks._figures import figure
from benchmarks._network_senders import ARRAY, SENDERS, TEXT, _cdr, frame_of
from benchmarks._silent_servers import silent_broker, silent_web_socket
from varishold.errors import InputError, LostSourceError, MissingExtraError
from varishold.live import Sample, Source, source_at
from varishold.recording.messages import message_decoder, read_message

ADDRESSES = {
    "ws": "ws://127.0.0.1:{port}?shape=16x16",
    "foxglove": "foxglove://127.0.0.1:{port}/skin",
    "zenoh": "zenoh://127.0.0.1:{port}/skin",
    "lsl": "lsl:skin-{port}",
    "mqtt": "mqtt://127.0.0.1:{port}/skin",
}
FIRST = 50


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@contextmanager
def running(*words: str) -> Iterator[None]:
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.kill()


def broker(port: int, folder: str) -> tuple[str, ...]:
    """Return the command that runs a broker."""
    found = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
    if found is None:
        raise FileNotFoundError("mosquitto is not installed")
    path = Path(folder, "broker.conf")
    path.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    return found, "-c", str(path)


def opened(source: Source) -> None:
    """Open a source that is about to be there."""
    for _ in range(200):
        try:
            source.open()
            return
        except LostSourceError:
            source.close()
            time.sleep(0.05)
    raise TimeoutError(f"{source.address} is not there")


def heard(source: Source, n_frames: int) -> tuple[list[Sample], list[float], float]:
    """Return all samples, the delay of each in seconds, and the CPU seconds of reading them."""
    samples: list[Sample] = []
    delays: list[float] = []
    begun, quiet_s = time.process_time(), time.monotonic()
    while len(samples) < n_frames and time.monotonic() < quiet_s + 8:
        with suppress(LostSourceError):
            came = source.read(0.1)
            now_s = time.time()
            samples += came
            delays += [now_s - (sample.device_time_s or np.nan) for sample in came]
            quiet_s = time.monotonic() if came else quiet_s
    return samples, delays, time.process_time() - begun


def told(kind: str, n_frames: int, rate_hz: float) -> str:
    """Return what is told of a source; errors where it cannot be had here."""
    port = free_port()
    source = source_at(ADDRESSES[kind].format(port=port))
    with ExitStack() as stack:
        if kind == "mqtt":
            stack.enter_context(running(*broker(port, stack.enter_context(tempfile.TemporaryDirectory()))))
            opened(source)
        words = (sys.executable, "-m", "benchmarks._network_senders", kind, str(port), str(n_frames), str(rate_hz))
        stack.enter_context(running(*words))
        if kind != "mqtt":
            opened(source)
        stack.callback(source.close)
        samples, delays, spent_s = heard(source, n_frames)
    equal = sum(
        np.array_equal(next(iter(sample.pads.values())), frame_of(number)) for number, sample in enumerate(samples)
    )
    # The first ones waited until the source was open.
    late = 1e3 * np.array(delays[FIRST:])
    p50, p99 = np.percentile(late, [50, 99]) if late.size else (np.nan, np.nan)
    return "  ".join(
        [
            figure(f"{kind}: frames that came as they were sent", equal, "6d", bar=f">= {n_frames}"),
            figure(f"{kind}: delay, median", p50, "7.2f", "ms"),
            figure(f"{kind}: delay, 99 % of frames", p99, "7.2f", "ms"),
            figure(f"{kind}: CPU a frame", 1e6 * spent_s / max(len(samples), 1), "6.0f", "us"),
        ]
    )


def pulled_cables(rounds: int = 5) -> Iterator[str]:
    """Yield how long after the last word it is told that a server says nothing more, the worst of some rounds."""
    for kind, serve in (("ws", silent_web_socket), ("mqtt", silent_broker)):
        late = []
        for _ in range(rounds):
            with serve() as port:
                source = source_at(f"{kind}://127.0.0.1:{port}/skin")
                source.open()
                begun_s = time.monotonic()
                with suppress(LostSourceError):
                    while time.monotonic() < begun_s + 10:
                        source.read(0.1)
                late.append(time.monotonic() - begun_s)
                source.close()
        yield figure(f"{kind}: a pulled cable is told after, worst", max(late), ".2f", "s", bar="<= 1")


def decoding(rounds: int = 3000) -> str:
    """Return what taking apart and understanding one message costs."""
    decode, content = message_decoder("cdr", ARRAY, TEXT), _cdr(frame_of(0))
    begun = time.process_time()
    for _ in range(rounds):
        read_message(decode(content))
    return figure("a Float32MultiArray of 16 x 16, CPU", 1e6 * (time.process_time() - begun) / rounds, ".0f", "us")


def main(argv: Sequence[str] = ()) -> int:
    parser = argparse.ArgumentParser(prog="live_network", description=__doc__)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--rate-hz", type=float, default=200.0)
    asked = parser.parse_args(list(argv))
    print(f"{asked.frames} frames of 16 x 16 at {asked.rate_hz:g}/s: came as sent; delay, median and 99 %; CPU a frame")
    for kind in SENDERS:
        try:
            print(f"    {kind:10} {told(kind, asked.frames, asked.rate_hz)}")
        except (MissingExtraError, FileNotFoundError, InputError) as error:
            print(f"    {kind:10} {error}")
    with suppress(MissingExtraError):
        print(f"a pulled cable is told, ws and mqtt, after: {', '.join(pulled_cables())}")
    print(f"taking a message apart and understanding it: {decoding()}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
