"""Streams in which something presses while the zero is found: touches told, and how clean the zero is.

Readings are whole counts of pads of 8 x 8 to 32 x 32 taxels at 50 to 200 a second, drawn by seed: what stands there at
rest differs from taxel to taxel, noise is 1 to 3 % of the peak, gains scatter by 10 %. A press is told where a touch
begins from .05 s before it to .3 s after; any other touch is false. The zero is clean where no taxel is off by more
than four standard deviations of the noise, looked at so long after the stream began.

    python -m benchmarks.live_begins [--seed N] [--streams N]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks._figures import figure, share
from varishold.live import Sample, Watcher

SEED = 1957
STREAMS = 40
LASTS_S = 8.0
LOOKS_S = (1.5, 3.0, 6.0)
_EARLY_S, _LATE_S = 0.05, 0.3
_CLEAN_SIGMAS = 4.0

Draw = np.random.Generator


@dataclass(frozen=True)
class Press:
    """From when to when, rising and falling within so many seconds of either."""

    begin_s: float
    end_s: float
    ramp_s: float

    def share(self, time_s: float) -> float:
        """Return the share of its force."""
        return max(0.0, min(1.0, (time_s - self.begin_s) / self.ramp_s, (self.end_s - time_s) / self.ramp_s))


def slow(rng: Draw) -> list[Press]:
    """Return a press that rises slowly within the first second, and one long after it."""
    begin, lasts = rng.uniform(0.15, 0.95), rng.uniform(1.0, 3.0)
    ramp = rng.uniform(0.1, 0.4)
    return [Press(begin, begin + lasts, ramp), Press(6.0, 7.0, 0.1)]


def lively(rng: Draw, begin_s: float) -> list[Press]:
    """Return presses with short pauses."""
    presses = []
    while begin_s < LASTS_S - 0.6:
        end_s = begin_s + rng.uniform(0.15, 0.4)
        presses.append(Press(begin_s, end_s, 0.04))
        begin_s = end_s + rng.uniform(0.1, 0.25)
    return presses


def after(rng: Draw, first: float, last: float) -> list[Press]:
    """Return a press from before the stream until some time, and lively ones after it."""
    end = rng.uniform(first, last)
    return [Press(-1.0, end, 0.1), *lively(rng, end + rng.uniform(0.1, 0.25))]


WAYS: dict[str, Callable[[Draw], list[Press]]] = {
    "a slow press in the first second": slow,
    "lively from the first second on": lambda rng: lively(rng, rng.uniform(0.1, 0.7)),
    "pressed until .2 to .8 s, then lively": lambda rng: after(rng, 0.2, 0.8),
    "pressed until 1.5 to 4 s, then lively": lambda rng: after(rng, 1.5, 4.0),
    "nothing for three seconds": lambda rng: lively(rng, 3.0),
}


@dataclass
class Tally:
    """What became of streams of one way."""

    presses: int = 0
    told: int = 0
    false: int = 0
    off: dict[float, list[float]] = field(default_factory=lambda: {look: [] for look in LOOKS_S})


def _form(rng: Draw, side: int) -> np.ndarray:
    """Return what a press of force 1 is."""
    y, x = np.mgrid[:side, :side]
    reach = rng.uniform(0.15, 0.28) * side if side < 16 else rng.uniform(2.3, 4.5)
    row, col = rng.uniform(0.25 * side, 0.7 * side, 2)
    far = np.hypot(y - row, x - col) / reach
    kind = rng.integers(4)
    if kind == 0:
        return np.sqrt(np.maximum(1.0 - far**2, 0.0))
    if kind == 1:
        return np.maximum(1.0 - far, 0.0)
    if kind == 2:
        return np.clip((1.0 - far) * reach + 0.5, 0.0, 1.0)
    return np.clip(reach + 0.5 - np.maximum(abs(y - row), abs(x - col)), 0.0, 1.0)


def judge(rng: Draw, presses: list[Press], tally: Tally) -> None:
    """Draw a stream with these presses, and count what is told of it."""
    side, rate = int(rng.choice([8, 12, 16, 32])), float(rng.choice([50.0, 100.0, 200.0]))
    peak = rng.uniform(100.0, 400.0)
    noise = rng.uniform(0.01, 0.03) * peak
    rest = rng.uniform(20, 80) + rng.uniform(0.01, 0.05) * peak * rng.normal(size=(side, side))
    gains = 1 + 0.1 * rng.normal(size=(side, side))
    forms = [rng.uniform(0.6, 1.0) * peak * gains * _form(rng, side) for _ in presses]
    looks, touched = list(LOOKS_S), []
    with Watcher() as watcher:
        for k in range(round(LASTS_S * rate)):
            time_s = k / rate
            pressed = np.max([form * press.share(time_s) for form, press in zip(forms, presses, strict=True)], axis=0)
            frame = np.rint(rest + pressed + noise * rng.normal(size=(side, side))).astype(np.int32)
            seen = watcher.see(Sample(time_s, 0.0, k, {"pad": frame}))
            touched += [event.time_s for event in seen.pads["pad"].events if event.kind == "touched"]
            if looks and time_s >= looks[0]:
                off = np.abs(watcher.pads["pad"].zero.baseline - rest)
                free = (
                    np.max(
                        [
                            form * (press.end_s > 0 and press.share(time_s) > 0)
                            for form, press in zip(forms, presses, strict=True)
                        ],
                        axis=0,
                    )
                    == 0
                )
                tally.off[looks.pop(0)].append(float(off[free].max() / noise))
    for press in presses:
        if press.begin_s < 0:
            continue
        tally.presses += 1
        near = [at for at in touched if press.begin_s - _EARLY_S <= at <= press.begin_s + _LATE_S]
        tally.told += bool(near)
        if near:
            touched.remove(near[0])
    tally.false += len(touched)


def main(argv: Sequence[str] = ()) -> None:
    """Print what is told of streams that begin so."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--streams", type=int, default=STREAMS, help="of each kind")
    asked = parser.parse_args(list(argv))
    print(f"{'':40}{'touches told':>14}{'false a stream':>16}   zero clean " + ", ".join(f"{s:g} s" for s in LOOKS_S))
    for number, (name, way) in enumerate(WAYS.items()):
        tally = Tally()
        for stream in range(asked.streams):
            rng = np.random.default_rng((asked.seed, number, stream))
            judge(rng, way(rng), tally)
        told = share(f"{name}: told", tally.told / tally.presses)
        false = figure(f"{name}: false touches", tally.false / asked.streams, ".2f", "a stream")
        clean = [
            share(f"{name}: clean at {look:g} s", float(np.mean(np.array(off) < _CLEAN_SIGMAS)))
            for look, off in tally.off.items()
        ]
        print(f"{name:40}{told:>14}{false:>16}   {', '.join(clean)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
