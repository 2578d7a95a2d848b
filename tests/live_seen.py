"""What is seen of heaps of pressure, made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from varishold.live import PadLayout, Sample
from varishold.live.pad_watcher import SeenPad
from varishold.live.watcher import Seen
from varishold.touch import ContactTracker, find_contacts

ROWS, COLS = 12, 16


def heap(x: float, y: float, peak: float = 100.0, reach: float = 3.0) -> np.ndarray:
    """Return a heap of pressure whose middle stands at column x, row y."""
    rows, cols = np.mgrid[:ROWS, :COLS]
    return np.asarray(peak * np.exp(-((cols - x) ** 2 + (rows - y) ** 2) / reach**2))


def seen_pad(*heaps: np.ndarray, pitch: tuple[float, float] | None = None, name: str = "pad", **more: Any) -> SeenPad:
    """Return what is seen of some heaps that were held for a while."""
    frame = np.sum([np.zeros((ROWS, COLS)), *heaps], axis=0)
    tracker = ContactTracker(pad=name)
    for k in range(20):
        tracker.update(k / 100, find_contacts(frame, pitch=pitch, sigma=0.5), frame)
    layout = PadLayout((ROWS, COLS), pitch_m=pitch)
    return SeenPad(name, layout, frame, frame, frame, tracks=tracker.tracks, sigma=0.5, **more)


def seen(*pads: SeenPad, **more: Any) -> Seen:
    return Seen(7, 1.5, Sample(1.5, 1e9, 3, {}), {pad.name: pad for pad in pads}, **more)
