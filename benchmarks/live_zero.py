"""The zero that follows through ten minutes of warming up, creep and a held contact, beside plain baselines.

The skin and its course are drawn by seed (`_drifting_skin.py`), apart from what judges them. All baselines are judged
by the same eye: three neighbours above eight standard deviations of the skin's own noise, or one taxel above 32.
A frame is free while nothing presses, from the moment in which a press ends. The worst of ten seeds is printed.

Run: python -m benchmarks.live_zero [--seeds N] [--first SEED] [--only baselines|watched|worlds|hours] [--hours H]
"""

from __future__ import annotations

import argparse
import copy
import pickle
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks._drifting_skin import DriftingSkin, Press, World
from benchmarks._figures import figure, share
from benchmarks._plain_zeros import PLAIN_ZEROS
from varishold.frame import FollowingZero
from varishold.live import Sample, Watcher

_LOOKS_HZ = 20.0
_NEIGHBOURS = np.ones((3, 3), np.int_)


@dataclass
class Outcome:
    """What came of one baseline on one skin; shares, 0 is right.

    Parameters
    ----------
    hold_first, hold_last : float
        Error of the held contact's force one second after it began and in its last second, by the force that pressed
        before it crept.
    crept : float
        How far true creep had gone in that last second.
    later : float
        Median error of the force of short presses in the second half, their creep not counted as one.
    false : float
        Of free frames, those in which a contact was seen.
    own_false : float
        The same by what the baseline itself takes for pressed; NaN where it says nothing.
    missed : int
        Presses that were not seen.
    refused, asked : int
        Zeros that were asked for while something pressed, and those of them that were refused.
    wrongly_refused : int
        Zeros that were asked for while nothing pressed, and refused.
    cpu_us : float
        CPU time a frame, microseconds.
    """

    hold_first: float
    hold_last: float
    crept: float
    later: float
    false: float
    own_false: float
    missed: int
    refused: int
    asked: int
    wrongly_refused: int
    cpu_us: float


def seen(zeroed: NDArray[np.float64], sigma: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return where contacts are seen."""
    hot = zeroed > 8.0 * sigma
    if not hot.any():
        return hot
    labels, n = ndimage.label(hot, _NEIGHBOURS)
    sizes = np.bincount(labels.ravel(), minlength=n + 1)
    large = sizes >= 3
    large[0] = False
    return np.asarray(large[labels] | (zeroed > 32.0 * sigma))


def force(zeroed: NDArray[np.float64], press: Press) -> float:
    """Return what the taxels of a press show together, by what it puts on them."""
    on = press.form > 0.05 * press.form.max()
    return float(zeroed[on].sum() / press.form[on].sum())


class Judge:
    """Looks at zeroed frames as they come."""

    def __init__(self, skin: DriftingSkin) -> None:
        self.skin = skin
        self.sigma = np.maximum(np.hypot(skin.sigma, 12**-0.5), np.median(skin.sigma))
        self.courses = np.array([press.course(skin.times_s) for press in [skin.hold, *skin.presses]])
        # Before it begins a zero is not to be had.
        self.free = ~(self.courses > 0).any(axis=0)
        self.crept = [skin.crept(press) for press in [skin.hold, *skin.presses]]
        self.every = max(1, round(skin.world.rate_hz / _LOOKS_HZ))
        self.n_free = self.n_false = self.n_own_false = 0
        self.felt = np.zeros(len(self.courses), np.bool_)
        self.forces: list[list[tuple[float, float]]] = [[] for _ in self.courses]
        self.first: list[float] = []
        self.last: list[float] = []

    def look(self, k: int, zeroed: NDArray[np.float64], zero: Any) -> None:
        """Look at frame k."""
        if k % self.every:
            return
        skin, time_s = self.skin, k / self.skin.world.rate_hz
        found = seen(zeroed, self.sigma)
        if self.free[k]:
            self.n_free += 1
            self.n_false += bool(found.any())
            self.n_own_false += isinstance(zero, FollowingZero) and bool(zero.pressed.any())
            return
        for i in np.flatnonzero(self.courses[:, k] >= 0.999):
            press = skin.hold if i == 0 else skin.presses[i - 1]
            self.felt[i] |= bool((found & (press.form > 0.2 * press.form.max())).any())
            begins, crept = self.crept[i]
            self.forces[i].append((force(zeroed, press), float(crept[k - begins])))
        _, stands, falls, _ = skin.hold.corners_s
        if stands + 0.5 <= time_s < stands + 1.5:
            self.first.append(force(zeroed, skin.hold))
        elif falls - 1.0 <= time_s < falls:
            self.last.append(force(zeroed, skin.hold))

    def outcome(self, refusals: tuple[int, int, int], cpu_us: float, *, own: bool) -> Outcome:
        """Return what came of it."""
        half_s = self.skin.world.lasts_s / 2
        later = [
            float(np.mean([felt / true for felt, true in found])) - 1.0
            for press, found in zip(self.skin.presses, self.forces[1:], strict=True)
            if press.corners_s[0] > half_s and found
        ]
        begins, crept = self.crept[0]
        at_end = int(np.searchsorted(self.skin.times_s, self.skin.hold.corners_s[2] - 0.5))
        return Outcome(
            float(np.mean(self.first)) - 1.0,
            float(np.mean(self.last)) - 1.0,
            float(crept[at_end - begins]) - 1.0,
            float(np.median(later)) if later else 0.0,
            self.n_false / max(self.n_free, 1),
            self.n_own_false / max(self.n_free, 1) if own else float("nan"),
            int(np.count_nonzero(~self.felt)),
            *refusals,
            cpu_us,
        )


def run(skin: DriftingSkin, zero: Any) -> Outcome:
    """Run a skin's course past a baseline."""
    judge = Judge(skin)
    asks = ask_times(skin) if isinstance(zero, FollowingZero) else {}
    refused = asked = wrong = 0
    trials: list[tuple[Any, bool, float]] = []
    k, cpu = 0, 0.0
    for times, frames in skin.blocks():
        for time_s, frame in zip(times.tolist(), frames, strict=True):
            begun = time.process_time()
            zeroed = zero.update(time_s, frame)
            cpu += time.process_time() - begun
            judge.look(k, zeroed, zero)
            if k in asks:
                # Whoever asks gets a copy: the others go on as if nobody had.
                trial = copy.deepcopy(zero)
                trial.ask(time_s)
                trials.append((trial, asks[k], time_s))
            for trial, _, _ in trials:
                trial.update(time_s, frame)
            for trial, pressed, _ in [each for each in trials if time_s > each[2] + 1.2]:
                taken = trial.log[-1].taken
                asked += pressed
                refused += pressed and not taken
                wrong += not pressed and not taken
            trials = [each for each in trials if time_s <= each[2] + 1.2]
            k += 1
    return judge.outcome((refused, asked, wrong), 1e6 * cpu / k, own=isinstance(zero, FollowingZero))


def ask_times(skin: DriftingSkin) -> dict[int, bool]:
    """Return the frames in which a zero is asked for, and whether something presses then or within .4 s."""
    rate, asks = skin.world.rate_hz, {}
    for press in skin.presses:
        begins, stands, falls, ends = press.corners_s
        asks[round(rate * (stands + falls) / 2)] = True
        # It has its full force before the zero is taken.
        if stands - begins < 0.2:
            asks[round(rate * (begins - 0.1))] = True
        if not skin.hold.corners_s[0] - 1.5 < ends + 2.0 < skin.hold.corners_s[0]:
            asks[round(rate * (ends + 2.0))] = bool(skin.hold.corners_s[0] <= ends + 2.0 < skin.hold.corners_s[3])
    begins, _, _, ends = skin.hold.corners_s
    for time_s in np.arange(begins + 5.0, ends - 5.0, 20.0):
        asks[round(rate * time_s)] = True
    return asks


def following(skin: DriftingSkin) -> FollowingZero:
    """Return the zero that is judged."""
    return FollowingZero(skin.world.shape, valid=~skin.dead if skin.dead.any() else None)


def worst(outcomes: Sequence[Outcome]) -> Outcome:
    """Return the worst of each."""

    def most(name: str, key: Callable[[float], float] = abs) -> Any:
        return max((getattr(outcome, name) for outcome in outcomes), key=key)

    names = ("hold_first", "hold_last", "crept", "later", "false", "own_false", "missed")
    found = {name: most(name) for name in names}
    total = {name: sum(getattr(each, name) for each in outcomes) for name in ("refused", "asked", "wrongly_refused")}
    return Outcome(**found, **total, cpu_us=float(np.median([each.cpu_us for each in outcomes])))


def tell(name: str, found: Outcome, *, bars: bool = False) -> None:
    """Print and keep the figures of a baseline."""
    parts = [
        f"held {share(f'{name}: held force after 1 s', found.hold_first, '+.1f')} after 1 s, "
        + share(f"{name}: held force at its end", found.hold_last, "+.1f", bar="within 15" if bars else "")
        + f" at its end (creep {100 * found.crept:.0f} %)",
        f"later presses {share(f'{name}: later presses', found.later, '+.1f')}",
        f"false contact {share(f'{name}: false contact', found.false, '.2f', bar='<= 1' if bars else '')}",
        f"missed {figure(f'{name}: missed', found.missed, '.0f', bar='0' if bars else '')}",
    ]
    if found.asked:
        pressed_on = share(f"{name}: refused of zeros pressed on", found.refused / found.asked, bar="100" * bars)
        parts.append(
            f"zeros pressed on refused {pressed_on} of {found.asked}, others refused {found.wrongly_refused}; "
            f"its own word false {share(f'{name}: own word false', found.own_false, '.2f')}; "
            f"{figure(f'{name}: CPU a frame', found.cpu_us, '.0f', 'us')} a frame"
        )
    print(f"{name}: " + "; ".join(parts), flush=True)


# The same world, changed in one respect.
WORLDS = {
    "30 frames/s": World(rate_hz=30.0),
    "1000 frames/s, two minutes": World(
        rate_hz=1000.0, lasts_s=120.0, hold_s=(70.0, 105.0), n_presses=10, warm_up_s=50.0, warmth=20.0
    ),
    "4 x 4": World(shape=(4, 4)),
    "6 x 4": World(shape=(6, 4)),
    "1 x 16": World(shape=(1, 16)),
    "32 x 32": World(shape=(32, 32), rate_hz=50.0),
    "warm-up in a minute": World(warm_up_s=60.0),
    "cooling": World(warmth=-58.0),
    "swaying by 10 counts in 40 s": World(warmth=20.0, sways=10.0, sway_s=40.0),
    "wet over 60 % of the pad": World(covers=0.6),
    "twice the walk": World(walk=0.12),
    "dead and noisy taxels, impulses": World(faults=True),
}


def watched(seeds: Sequence[int]) -> None:
    """Watch the same skin as `varishold live` does: how often each press is told, and what is told where none is."""
    presses = touched = free = wrong = 0
    for seed in seeds:
        skin = DriftingSkin(World(rate_hz=50.0), seed)
        none = ~np.any([press.course(skin.times_s) > 0 for press in [skin.hold, *skin.presses]], axis=0)
        presses += 1 + len(skin.presses)
        with Watcher() as watcher:
            k = 0
            for times, frames in skin.blocks():
                for time_s, frame in zip(times.tolist(), frames, strict=True):
                    seen = watcher.see(Sample(time_s, time_s, k, {"pad": frame}))
                    touched += sum(event.kind == "touched" for event in seen.pads["pad"].events)
                    free += bool(none[k])
                    wrong += bool(none[k]) and seen.touched
                    k += 1
    print(
        f"watched: {figure('watched: touches told', touched, '.0f')} touches told of {presses} presses, "
        f"a contact in {share('watched: false contact', wrong / free, '.2f')} of the free frames"
    )


def hours(n_hours: float, seed: int) -> None:
    """Run for hours at ten frames a second: what it keeps, and how far the zero is off at the end."""
    skin = DriftingSkin(World.of_hours(n_hours, rate_hz=10.0, n_presses=200), seed)
    zero, off, early = following(skin), [], 0
    last = max(press.corners_s[3] for press in skin.presses)
    for times, frames in skin.blocks():
        for time_s, frame in zip(times.tolist(), frames, strict=True):
            zeroed = zero.update(time_s, frame)
            if time_s > last + 1.0:
                off.append(zeroed)
        if early == 0 and times[-1] > 1800.0:
            early = len(pickle.dumps(zero))
    mean = np.mean(off, axis=0)
    grown = figure("hours: what it keeps grew by", (len(pickle.dumps(zero)) - early) / early * 100, ".1f", "%")
    print(
        f"{n_hours:g} hours, {skin.world.warmth:g} counts of drift and {len(skin.presses) + 1} presses: "
        f"the zero is off by {figure('hours: zero off, mean', float(mean.mean()), '.2f', 'counts')} in the mean, "
        f"{figure('hours: zero off, worst taxel', float(np.abs(mean).max()), '.2f', 'counts')} at most; "
        f"what it keeps grew by {grown} after the first half hour, to {len(pickle.dumps(zero)) / 1e3:.0f} kB"
    )


def main(argv: Sequence[str] = ()) -> None:
    """Print the worst of the seeds of each baseline, of each changed world, and of hours."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="how many skins")
    parser.add_argument("--first", type=int, default=0, help="the first skin's seed")
    parser.add_argument("--only", choices=("baselines", "watched", "worlds", "hours"), help="default: all")
    parser.add_argument("--hours", type=float, default=8.0)
    asked = parser.parse_args(list(argv))
    seeds = range(asked.first, asked.first + asked.seeds)
    if asked.only in (None, "baselines"):
        for name, make in PLAIN_ZEROS.items():
            tell(name, worst([run(skin, make(_floored(skin))) for skin in (DriftingSkin(World(), s) for s in seeds)]))
        tell("following", worst([run(s, following(s)) for s in (DriftingSkin(World(), s) for s in seeds)]), bars=True)
    if asked.only in (None, "watched"):
        watched(list(seeds)[: max(1, asked.seeds // 5)])
    if asked.only in (None, "worlds"):
        for name, world in WORLDS.items():
            skins = [DriftingSkin(world, seed) for seed in list(seeds)[: max(1, asked.seeds // 5)]]
            tell(name, worst([run(skin, following(skin)) for skin in skins]))
    if asked.only in (None, "hours"):
        hours(asked.hours, asked.first)


def _floored(skin: DriftingSkin) -> NDArray[np.float64]:
    """Return a skin's noise, nowhere below its median."""
    return np.maximum(np.hypot(skin.sigma, 12**-0.5), np.median(skin.sigma))


if __name__ == "__main__":
    main(sys.argv[1:])
