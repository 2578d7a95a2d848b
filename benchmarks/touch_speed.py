"""Time from a frame to a named answer, through Python: CPU, median and 99 % of many.

Two pads, a noisy cone on each, 32 thresholds. Beside the whole stands what it is made of: contacts, the
name, all outlines, each in many short rounds. Other work on the machine makes it slower: the load average is printed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from benchmarks._figures import figure
from varishold.solids import Cone, ideal_frame
from varishold.touch import find_contacts, recognize

# Calls of the quickest in a round; a machine that is slower for a second is so for all that is compared.
CALLS, ROUNDS = 100, 60
#: Most microseconds: frame to name, its 99 %, with reasons.
BARS = {16: ("<= 40", "<= 100", "<= 120"), 32: ("<= 80", "", "")}


def times_of(call: Callable[[], object], calls: int) -> list[float]:
    """Return the CPU time of some calls after a first one, microseconds."""
    call()
    times = []
    for _ in range(calls):
        begun = time.process_time_ns()
        call()
        times.append((time.process_time_ns() - begun) / 1e3)
    return times


def calls_of(side: int) -> dict[str, tuple[Callable[[], object], int]]:
    """Return what is timed on a pad of so many rows and columns, and how often in a round."""
    frame = ideal_frame(Cone(0.6 * side, 0.2 * side), (side, side), 1.0)
    frame = frame + np.random.default_rng(side).normal(0, 0.01 * frame.max(), frame.shape)
    contact = find_contacts(frame)[0]
    levels = range(len(contact.profile))
    return {
        "frame to name": (lambda: recognize(find_contacts(frame)[0]).name, CALLS),
        "with reasons": (lambda: recognize(find_contacts(frame)[0]).reasons, CALLS // 4),
        "contacts": (lambda: find_contacts(frame), CALLS),
        "name": (lambda: recognize(contact), CALLS),
        "all outlines": (lambda: [contact.outlines(i) for i in levels], CALLS // 20),
    }


def main() -> None:
    """Print the times on two pads."""
    work = {(side, what): call for side in BARS for what, call in calls_of(side).items()}
    times: dict[tuple[int, str], list[float]] = {key: [] for key in work}
    for _ in range(ROUNDS):
        for key, (call, calls) in work.items():
            times[key] += times_of(call, calls)
    for side, (bar, bar_99, bar_reasons) in BARS.items():
        bars = {"frame to name": bar, "with reasons": bar_reasons}
        told = {what: float(np.median(times[side, what])) for of, what in work if of == side}
        of = f"{side} x {side}"
        said = [
            f"{what} {figure(f'{of}: {what}', us, '.0f', 'us', bar=bars.get(what, ''))}" for what, us in told.items()
        ]
        rare = float(np.percentile(times[side, "frame to name"], 99))
        said.insert(1, f"99 % {figure(f'{of}: frame to name, 99 %', rare, '.0f', 'us', bar=bar_99)}")
        print(f"{of}: {'; '.join(said)}")
    print(f"load average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
