"""Time from a frame to a named answer, through Python: CPU, median and 99 % of many.

Two pads, a noisy cone on each, 32 thresholds. Beside the whole stands what it is made of: contacts, the
name, all outlines. Other work on the machine makes it slower: the load average is printed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from benchmarks._figures import figure
from varishold.solids import Cone, ideal_frame
from varishold.touch import find_contacts, recognize

CALLS = 2000
# Side of the pad: bars of the median and of 99 %, and of the median with reasons, microseconds.
#: Most microseconds: frame to name, its 99 %, with reasons.
BARS = {16: ("<= 40", "<= 100", "<= 120"), 32: ("<= 80", "", "")}


def times_of(call: Callable[[], object], calls: int = CALLS) -> tuple[float, float]:
    """Return the median and the 99th of a hundred of a call's CPU time, microseconds."""
    call()
    times = []
    for _ in range(calls):
        begun = time.process_time_ns()
        call()
        times.append(time.process_time_ns() - begun)
    return float(np.median(times)) / 1e3, float(np.percentile(times, 99)) / 1e3


def main() -> None:
    """Print the times on two pads."""
    rng = np.random.default_rng(0)
    for side in (16, 32):
        frame = ideal_frame(Cone(0.6 * side, 0.2 * side), (side, side), 1.0)
        frame = frame + rng.normal(0, 0.01 * frame.max(), frame.shape)
        contact = find_contacts(frame)[0]
        levels = range(len(contact.profile))
        named, named_99 = times_of(lambda frame=frame: recognize(find_contacts(frame)[0]).name)
        reasoned, _ = times_of(lambda frame=frame: recognize(find_contacts(frame)[0]).reasons, CALLS // 4)
        found, _ = times_of(lambda frame=frame: find_contacts(frame))
        recognized, _ = times_of(lambda contact=contact: recognize(contact))
        outlined, _ = times_of(
            lambda contact=contact, levels=levels: [contact.outlines(i) for i in levels], CALLS // 20
        )
        times = (
            ("frame to name", named, BARS[side][0]),
            ("frame to name, 99 %", named_99, BARS[side][1]),
            ("with reasons", reasoned, BARS[side][2]),
            ("contacts", found, ""),
            ("name", recognized, ""),
            ("all outlines", outlined, ""),
        )
        of = f"{side} x {side}"
        said = (f"{what} {figure(f'{of}: {what}', time_us, '.0f', 'us', bar=bar)}" for what, time_us, bar in times)
        print(f"{of}: {'; '.join(said)}")
    print(f"load average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
