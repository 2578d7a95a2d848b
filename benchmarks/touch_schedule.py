"""Thresholds until a sure answer: an even schedule against one that chooses its next threshold.

Both see sections only (a bit a taxel and threshold, summed up as sum X_i dtheta_i), of presses into a 6 mm layer.
Each begins with the same three thresholds and stops when the name has probability .9, or after 24.
"""

from __future__ import annotations

import numpy as np

from benchmarks._figures import figure, share
from benchmarks.touch_skins import LAYER, frames
from varishold.touch import find_contacts, next_threshold, recognize
from varishold.touch.surface import Surface

SEED, PER_KIND = 7, 30
SURE, MOST = 0.9, 24
_SAME = {"hip": "ridge"}


def seen(frame: np.ndarray, cuts: list[float], floor: float) -> Surface | None:
    """Recognize what the sections at `cuts` and at the floor say of a frame."""
    levels = np.sort(np.array([floor, *cuts]))
    middle = np.concatenate([(levels[1:] + levels[:-1]) / 2, [levels[-1] + (levels[-1] - levels[-2]) / 2]])
    rebuilt = np.concatenate([[0.0], middle])[np.searchsorted(levels, frame)]
    contacts = find_contacts(rebuilt, floor=floor)
    return recognize(contacts[0]) if contacts else None


def run(frame: np.ndarray, *, adaptive: bool) -> tuple[int, str]:
    """Return how many thresholds were cut and the name at the end."""
    top = float(frame.max())
    floor = max(0.05, 4 * 0.02) * top
    even = [top - (i + 0.5) / MOST * (top - floor) for i in range(MOST)]
    # The even schedule falls in ever finer rounds, so that it may stop early too.
    order = sorted(range(MOST), key=lambda i: (bin(i).count("0") if i % 8 else -1, (i * 7) % MOST))
    cuts = [top - q * (top - floor) for q in (0.04, 0.35, 0.7)]
    while True:
        surface = seen(frame, cuts, floor)
        if surface is not None and surface.probability >= SURE:
            return len(cuts), _SAME.get(surface.name, surface.name)
        if len(cuts) >= MOST:
            return len(cuts), "unknown" if surface is None else _SAME.get(surface.name, surface.name)
        if adaptive and surface is not None:
            cuts.append(next_threshold(surface, cuts))
        else:
            cuts.append(even[order[len(cuts) - 3]])


def main() -> None:
    """Print thresholds, bits and shares of right names of both schedules."""
    named = frames(LAYER, 16, 2e-3, 0.02, SEED, PER_KIND)
    taxels = named[0][1].size
    print(f"every taxel at 12 bits: {12 * taxels} bits a frame")
    for adaptive in (False, True):
        runs = [run(frame, adaptive=adaptive) for _, frame in named]
        counts = np.array([count for count, _ in runs])
        right = np.mean([name == _SAME.get(truth, truth) for (_, name), (truth, _) in zip(runs, named, strict=True)])
        of = f"{'chosen' if adaptive else 'even'} thresholds"
        print(
            f"{of}: mean {figure(of, counts.mean(), '.1f')}, median {np.median(counts):.0f}, "
            f"{figure(f'{of}: bits', counts.mean() * taxels, '.0f', 'bits')}, "
            f"right name {share(f'{of}: right name', right)} of {len(runs)}"
        )


if __name__ == "__main__":
    main()
