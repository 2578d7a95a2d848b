"""Time of `recognize` on a contact that has been found: CPU, median of many."""

from __future__ import annotations

import time

import numpy as np

from varishold.solids import Cone, ideal_frame
from varishold.touch import find_contacts, recognize


def main() -> None:
    """Print the time on two pads."""
    rng = np.random.default_rng(0)
    for side in (16, 32):
        frame = ideal_frame(Cone(0.6 * side, 0.2 * side), (side, side), 1.0)
        contact = find_contacts(frame + rng.normal(0, 0.01 * frame.max(), frame.shape))[0]
        recognize(contact)
        times = []
        for _ in range(500):
            begun = time.process_time_ns()
            recognize(contact)
            times.append(time.process_time_ns() - begun)
        print(f"{side} x {side}: recognize {np.median(times) / 1e3:.0f} microseconds (bar 60)")


if __name__ == "__main__":
    main()
