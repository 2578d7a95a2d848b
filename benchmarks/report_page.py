"""How long a contact's card takes to draw and how large the page becomes.

Run by ``python -m benchmarks.report_page``; prints CPU milliseconds a card (median of several pages), and the
page's size for one, fourteen and five hundred contacts, at 32 x 32 taxels, and for one at 240 x 320.
"""

from __future__ import annotations

import statistics
import time

import numpy as np

from benchmarks._figures import figure
from varishold.recording import Pad, Recording
from varishold.report import render_touch_report
from varishold.solids import SOLIDS, draw_contact
from varishold.solids.ideal import ideal_frame
from varishold.touch import recognize_recording

__all__ = ["main"]

_SEED = 11
_PAGES = 7


def surfaces(n: int, shape: tuple[int, int] = (32, 32), pitch_m: float = 0.002) -> Recording:
    """Return n ideal frames of all solids in turn, with 1 % noise."""
    rng = np.random.default_rng(_SEED)
    side = min(shape) * pitch_m
    frames = np.empty((n, *shape))
    for i in range(n):
        drawn = draw_contact(
            rng,
            list(SOLIDS)[i % len(SOLIDS)],
            field_m=(shape[0] * pitch_m, shape[1] * pitch_m),
            size_m=(0.3 * side, 0.6 * side),
        )
        frame = ideal_frame(drawn.solid, shape, pitch_m, depth_m=min(drawn.depth_m, drawn.solid.top_m), pose=drawn.pose)
        frames[i] = frame / frame.max() + rng.normal(scale=0.01, size=shape)
    return Recording({"pad": Pad(1e5 * frames, pitch_m=pitch_m)}, unit="Pa", source="surfaces.npz")


def main() -> None:
    """Print the figures."""
    one_of_each = surfaces(len(SOLIDS))
    answers = list(recognize_recording(one_of_each, frames="all"))
    page = render_touch_report(answers, recording=one_of_each)
    taken = []
    for _ in range(_PAGES):
        start = time.process_time()
        page = render_touch_report(answers, recording=one_of_each)
        taken.append((time.process_time() - start) / len(answers))
    print(f"a card, 32 x 32: {figure('a card, 32 x 32', 1e3 * statistics.median(taken), '.1f', 'ms')} of CPU time")
    for recording in (surfaces(1), one_of_each, surfaces(500), surfaces(1, (240, 320), 1e-4)):
        answers = list(recognize_recording(recording, frames="all"))
        page = render_touch_report(answers, recording=recording)
        rows, cols = recording.pads["pad"].shape
        of = f"page of {len(answers)} contacts, {rows} x {cols}"
        print(f"{of}: {figure(of, len(page.encode()) / 1e3, '.0f', 'kB')}")


if __name__ == "__main__":
    main()
