"""Events of presses in time: touched, moved, tipped, released, on a contact model of its own; confusion and latency.

Presses are those of `_live_presses`: a ball, a round and a square punch, a bar, a round bar on a thin layer, some
pressed in askew, held with a tremor; taxels with gains (10 %), crosstalk, noise, drift left over from zeroing, counts
of 8 bits. Each is a hold, a move, a tip, a move and a tip, or two fingers at once.

A press is right if every finger is touched once, released once, and told to move or tip where it does and nowhere else:
touched and released within .12 s of the first and last contact, at its place; each move and tip with the right word,
its direction within 30 (a tip's: 40) degrees, its distance within .3 taxel or a quarter. "Told after .2 taxel": when
the first motion is told, less when the object has gone .2 taxel; negative is before. "False": events in holds of 20 s.

Seeds: 1 to 12 were looked at while building; the default was not.

    python -m benchmarks.live_events [--seed N] [--quick]
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks._figures import figure, share
from benchmarks._live_presses import Action, Conditions, Finger, Press, draw_press
from varishold.touch import ContactTracker, Event, find_contacts

FINAL_SEED = 1976
PER_KIND, QUICK_PER_KIND = 80, 12
PRESSES = ("hold", "move", "tip", "both", "two")
SMALL_PRESSES = ("hold", "move")
HOLDS, HOLD_S = 12, 20.0
_TOUCH_S, _BEFORE_S, _AFTER_S = 0.12, 0.02, 0.34
_ANGLE = {"moved": math.radians(30), "tipped": math.radians(40)}
_LATEST_S = 0.02
#: What building did not know: other rates, pads, noise, and slow rolls.
VARIATIONS = {
    "50 frames/s": Conditions(rate_hz=50.0, seconds=(0.2, 0.6)),
    "1000 frames/s": Conditions(rate_hz=1000.0),
    "32 x 32": Conditions(shape=(32, 32)),
    "noise 4 % of the peak": Conditions(noise_share=0.04),
    "gains 20 %": Conditions(gains=0.2),
    "slow: 1 to 3 s": Conditions(seconds=(1.0, 3.0)),
    "a soft skin: blurred by .7 taxel": Conditions(blur=0.7),
}


@dataclass
class Tally:
    """What became of some presses."""

    presses: int = 0
    right: int = 0
    by_kind: dict[str, list[bool]] = field(default_factory=dict)
    faults: Counter[str] = field(default_factory=Counter)
    confusion: Counter[tuple[str, str]] = field(default_factory=Counter)
    slid: dict[str, list[bool]] = field(default_factory=dict)
    latency_s: dict[str, list[float]] = field(default_factory=lambda: {"touched": [], "moved": [], "released": []})

    def add(self, kind: str, press: Press, events: Sequence[Event]) -> None:
        """Judge one press."""
        before = self.faults.total()
        told = {event.track for event in events if event.kind == "touched"}
        for finger in press.fingers:
            touch = _touch_of(finger, press, events, told)
            if touch is None:
                self.faults["not touched"] += 1
                continue
            told.discard(touch.track)
            self.latency_s["touched"].append(touch.told_s - finger.begin_s)
            self._judge(finger, press, [event for event in events if event.track == touch.track])
        self.faults["touched once too often"] += len(told)
        good = self.faults.total() == before
        self.presses += 1
        self.right += good
        self.by_kind.setdefault(kind, []).append(good)

    def _judge(self, finger: Finger, press: Press, events: list[Event]) -> None:
        released = [event for event in events if event.kind == "released"]
        if len(released) != 1 or abs(released[0].time_s - finger.end_s) > _TOUCH_S:
            self.faults["released at another time"] += 1
        else:
            self.latency_s["released"].append(released[0].told_s - finger.end_s)
        left = [event for event in events if event.kind not in ("touched", "released")]
        for action in finger.actions:
            during = [e for e in left if action.begin_s - _BEFORE_S <= e.told_s <= action.end_s + _AFTER_S]
            left = [event for event in left if event not in during]
            self._judge_action(action, finger, press, during)
        for event in left:
            self.confusion["nothing", _word(event)] += 1
            self.faults[f"false {_word(event)}"] += 1

    def _judge_action(self, action: Action, finger: Finger, press: Press, during: list[Event]) -> None:
        words = " and ".join(sorted({_word(event) for event in during})) or "nothing"
        self.confusion[action.kind, words] += 1
        if words != action.kind:
            self.faults[f"{action.kind} told as {words}"] += 1
            return
        x, y = _way(during)
        far = math.hypot(*action.way)
        off = math.atan2(y, x) - math.atan2(action.way[1], action.way[0])
        if abs((off + math.pi) % (2 * math.pi) - math.pi) > _ANGLE[action.kind]:
            self.faults[f"{action.kind} in another direction"] += 1
        elif abs(math.hypot(x, y) - far) > max(0.3, far / 4):
            self.faults[f"{action.kind} another distance"] += 1
        if action.kind == "moved":
            rolls = "balls and round bars" if "ball" in finger.shape or "round bar" in finger.shape else "flat faces"
            self.slid.setdefault(rolls, []).append(during[0].kind == "slid")
            start = int(np.searchsorted(press.time_s, action.begin_s))
            gone = np.hypot(finger.x - finger.x[start], finger.y - finger.y[start])[start:]
            reached = press.time_s[start + int(np.argmax(gone >= 0.2))]
            self.latency_s["moved"].append(during[0].told_s - float(reached))


def _way(events: list[Event]) -> tuple[float, float]:
    """Return the way that events tell together: each begins where the contact last rested."""
    x = y = 0.0
    for event in events:
        if event.resting or event is events[-1]:
            assert event.direction_rad is not None
            assert event.distance_taxels is not None
            x += event.distance_taxels * math.cos(event.direction_rad)
            y += event.distance_taxels * math.sin(event.direction_rad)
    return x, y


def _word(event: Event) -> str:
    """Return moved for everything that a move may be called."""
    return "tipped" if event.kind == "tipped" else "moved"


def _touch_of(finger: Finger, press: Press, events: Sequence[Event], free: set[int]) -> Event | None:
    """Return the event that tells this finger's touch."""
    i = int(np.searchsorted(press.time_s, finger.begin_s + 0.03))
    near = []
    for event in events:
        if event.kind != "touched" or event.track not in free or abs(event.time_s - finger.begin_s) > _TOUCH_S:
            continue
        x, y = event.position_taxels
        if math.hypot(x - finger.x[i], y - finger.y[i]) < finger.reach + 0.7:
            near.append(event)
    return min(near, key=lambda event: abs(event.time_s - finger.begin_s), default=None)


def events_of(press: Press) -> list[Event]:
    """Return what the tracker tells of a press."""
    tracker = ContactTracker()
    events = []
    for time_s, frame in zip(press.time_s.tolist(), press.frames, strict=True):
        events += tracker.update(time_s, find_contacts(frame), frame)
    return events + tracker.end()


def measure(seed: int, presses: Sequence[str], per_kind: int, conditions: Conditions) -> Tally:
    """Return what became of presses of each kind."""
    tally = Tally()
    for kind in presses:
        for index in range(per_kind):
            press = draw_press((seed, PRESSES.index(kind), index), kind, conditions)
            tally.add(kind, press, events_of(press))
    return tally


def _print(name: str, tally: Tally, *, bars: bool = False) -> None:
    right = share(f"{name}: presses right", tally.right / tally.presses, bar=">= 97" if bars else "")
    print(f"\n{name}: {tally.presses} presses, right {right}")
    parts = [f"{kind} {share(f'{name}, {kind}: right', float(np.mean(r)))}" for kind, r in tally.by_kind.items()]
    print(f"  {'  '.join(parts)}")
    for fault, n in tally.faults.most_common():
        if n:
            print(f"  {n:4} {fault}")
    late = np.array(tally.latency_s["moved"])
    if len(late):
        in_time = share(f"{name}: first motion in time", float(np.mean(late <= _LATEST_S + 1e-9)))
        at = ", ".join(
            f"{q} % {figure(f'{name}: told after .2 taxel, {q} %', 1e3 * float(np.percentile(late, q)), '.0f', 'ms')}"
            for q in (50, 95, 99)
        )
        print(f"  first motion told after .2 taxel: {at}; within 20 ms {in_time}")


def _print_confusion(tally: Tally) -> None:
    told = sorted({words for _, words in tally.confusion})
    print("\nwhat was done, and what was told")
    print(f"  {'':10}" + "".join(f"{words:>18}" for words in told))
    for done in ("moved", "tipped", "nothing"):
        print(f"  {done:10}" + "".join(f"{tally.confusion[done, words]:18}" for words in told))
    for rolls, slid in sorted(tally.slid.items()):
        print(f"  told as slid, of moves of {rolls}: {share(f'slid, {rolls}', float(np.mean(slid)))}")
    for name, of in (("touched", "first contact"), ("released", "last contact")):
        late = 1e3 * np.array(tally.latency_s[name])
        at = ", ".join(
            f"{q} % {figure(f'{name} told, {q} %', float(np.percentile(late, q)), '.0f', 'ms')}" for q in (50, 95)
        )
        print(f"  {name} told after the {of} of all: {at}")


def _print_cost(seed: int, frames: int = 3) -> None:
    """Print what a frame costs, by the best of some runs over presses whose contacts are found already."""
    presses = [draw_press((seed, PRESSES.index(kind), 0), kind) for kind in PRESSES]
    found = [
        [
            (time_s, find_contacts(frame), frame)
            for time_s, frame in zip(press.time_s.tolist(), press.frames, strict=True)
        ]
        for press in presses
    ]
    costs = []
    for _ in range(frames):
        begun = time.process_time()
        for readings in found:
            tracker = ContactTracker()
            for reading in readings:
                tracker.update(*reading)
        costs.append((time.process_time() - begun) / sum(map(len, found)))
    cost = figure("tracker: a frame", 1e6 * min(costs), ".0f", "us CPU")
    print(f"  the tracker takes {cost} a frame of 16 x 16, recognition included, contacts found before")


def _print_holds(seed: int, holds: int) -> None:
    conditions = Conditions(hold_s=HOLD_S)
    false = Counter(
        _word(event)
        for index in range(holds)
        for event in events_of(draw_press((seed, 9, index), "hold", conditions))
        if event.kind not in ("touched", "released")
    )
    minutes = holds * HOLD_S / 60
    rate = figure("false events in holds", false.total() / minutes, ".2f", "a minute", bar="0")
    print(f"\nholds of {HOLD_S:g} s, {minutes:.0f} minutes: {rate} {dict(false) or ''}")


def main(argv: Sequence[str] = ()) -> None:
    """Print how presses are told."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=FINAL_SEED)
    parser.add_argument("--quick", action="store_true", help="a seventh of the presses")
    asked = parser.parse_args(list(argv))
    per_kind = QUICK_PER_KIND if asked.quick else PER_KIND
    tally = measure(asked.seed, PRESSES, per_kind, Conditions())
    _print("16 x 16, 200 frames/s", tally, bars=True)
    _print_confusion(tally)
    _print_cost(asked.seed)
    _print_holds(asked.seed, 2 if asked.quick else HOLDS)
    few = max(per_kind // 4, 4)
    for name, conditions in VARIATIONS.items():
        _print(name, measure(asked.seed + 1, PRESSES, few, conditions))
    small = replace(Conditions(), shape=(6, 4))
    _print("6 x 4, hold and move", measure(asked.seed + 1, SMALL_PRESSES, 2 * few, small))


if __name__ == "__main__":
    main(sys.argv[1:])
