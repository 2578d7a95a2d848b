"""Names of presses as they come in life: without pauses, on a rest that drifts, one held for long, on uneven taxels.

The yardstick's faces, as height maps with its noise, each pressed, held and let go, eight a recording where no other
number stands. A press is found where an answer's frame lies in it; its name is that answer's.

    python -m benchmarks.touch_lively
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks._drawn_frames import frames
from benchmarks._figures import figure, share
from benchmarks.touch_distortions import SURE
from varishold import Pad, Recording, recognize_recording
from varishold.evaluation.yardstick.forms import Change
from varishold.evaluation.yardstick.rows import NOISE, as_one

SEED = 82
PER_KIND = 8
PRESSES = 8
#: Frames without a press at either end, on the way into one, and of one that is held.
LEAD, RAMP, HELD, LONG = 10, 4, 8, 60
PAUSES = (0, 1, 3, 6, 12)
DRIFTS = (0.1, 0.3)
UNEVEN = (0.1, 0.2)
#: Presses of a recording that tell what each taxel reads.
MANY = 26

Noise = np.random.Generator


@dataclass(frozen=True)
class Way:
    """How a recording goes: frames between presses, whether one is held long, how far the rest drifts, and gains.

    `drift` is a share of the highest press; `gains` returns what each taxel reads of 1, shape (side, side).
    """

    pause: int = 12
    long: bool = False
    drift: float = 0.0
    gains: Callable[[Noise, int], np.ndarray] = lambda rng, side: np.ones((side, side))
    ends: bool = True
    presses: int = PRESSES


def lines(spread: float) -> Callable[[Noise, int], np.ndarray]:
    """Return gains of rows and of columns that scatter by so much."""
    return lambda rng, side: np.exp(spread * rng.normal(size=(side, 1))) * np.exp(spread * rng.normal(size=side))


def taxels(spread: float) -> Callable[[Noise, int], np.ndarray]:
    """Return gains of taxels that scatter by so much."""
    return lambda rng, side: np.exp(spread * rng.normal(size=(side, side)))


WAYS = {
    **{f"pauses of {n} frame{'s' * (n != 1)}": Way(n) for n in PAUSES},
    **{f"pauses of {n} frames, drift {d:g}": Way(n, drift=d) for n in (3, 6) for d in DRIFTS},
    "one held long, drift 0.3": Way(long=True, drift=0.3),
    "begins and ends in a press, pauses of 6 frames": Way(6, ends=False),
    **{f"lines' gains {by:g}": Way(gains=lines(by)) for by in UNEVEN},
    **{f"taxels' gains {by:g}": Way(gains=taxels(by)) for by in UNEVEN},
    **{f"taxels' gains {by:g}, {MANY} presses": Way(gains=taxels(by), presses=MANY) for by in UNEVEN},
}


def recording(way: Way, pressed: np.ndarray, rng: Noise) -> tuple[Recording, list[range]]:
    """Return a recording of some faces, shape (n, side, side), and the frames of each press."""
    side = pressed.shape[1]
    up = np.sin(np.arange(1, RAMP + 1) / (RAMP + 1) * np.pi / 2) ** 2
    parts, where, begun = [np.zeros((LEAD, side, side))], [], LEAD
    for k, face in enumerate(pressed):
        held = LONG if way.long and k == len(pressed) // 2 else HELD
        course = np.concatenate([up, np.ones(held), up[::-1]])
        parts += [rng.uniform(0.6, 1.0) * course[:, None, None] * face, np.zeros((way.pause, side, side))]
        where.append(range(begun, begun + len(course)))
        begun += len(course) + way.pause
    made = np.concatenate([*parts, np.zeros((LEAD, side, side))]) * way.gains(rng, side)
    made += 0.5 + way.drift * np.linspace(0.0, 1.0, len(made))[:, None, None]
    made += NOISE[side] * rng.standard_normal(made.shape)
    first, last = (0, len(made)) if way.ends else (LEAD + RAMP + 1, where[-1].stop - RAMP - 1)
    spans = [range(max(span.start - first, 0), min(span.stop, last) - first) for span in where]
    return Recording({"pad": Pad(made[first:last])}), spans


def main() -> None:
    """Print the shares."""
    for side in (32, 16):
        drawn, kinds = frames("ideal", side, Change(), PER_KIND, SEED)
        drawn = drawn / drawn.max(axis=(1, 2), keepdims=True)
        for number, (name, way) in enumerate(WAYS.items()):
            rng = np.random.default_rng([SEED, side, number])
            order = rng.permutation(len(drawn))
            right = sure = miscounted = 0
            some = [order[k : k + way.presses] for k in range(0, len(order) - way.presses + 1, way.presses)]
            for chosen in some:
                if not way.ends:
                    # Where most of a pad is pressed at either end nobody knows that it is.
                    most = np.isin(kinds[chosen], ("plane", "edge"))
                    chosen = np.insert(chosen[~most], np.count_nonzero(~most) // 2, chosen[most])
                made, spans = recording(way, drawn[chosen], rng)
                answers = list(recognize_recording(made, frames="press"))
                for span, kind in zip(spans, kinds[chosen].tolist(), strict=True):
                    mine = [answer.surface for answer in answers if answer.frame in span]
                    named = bool(mine) and as_one(mine[0].name) == as_one(kind)
                    right += named
                    sure += bool(mine) and not named and mine[0].name != "unknown" and mine[0].probability > SURE
                    miscounted += len(mine) != 1
            n, of = way.presses * len(some), f"{side} x {side}, {name}"
            print(
                f"  {of:58} right {share(f'{of}: right', right / n, '5.1f')}  "
                f"wrong with p > {SURE:g} {share(f'{of}: wrong with p > {SURE:g}', sure / n, '4.1f')}  "
                f"not one answer {share(f'{of}: not one answer', miscounted / n, '4.1f')}  "
                f"of {figure(f'{of}: presses', n, 'd')}",
                flush=True,
            )


if __name__ == "__main__":
    main()
