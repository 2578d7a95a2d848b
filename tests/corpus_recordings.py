"""Small recordings for the tests of the corpus: noise, presses, drift, faults."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording import Pad, Recording

SHAPE = (9, 8)


def pressed_frames(
    seed: int, n: int = 40, *, rest: float = 0.0, drift: float = 0.0, height: float = 800.0
) -> NDArray[np.float64]:
    """Return frames of a skin that is pressed every twenty frames for ten of them, with noise and a falling rest."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    frames = rest + rng.normal(0, 2.0, (n, *SHAPE)) - drift * np.arange(n)[:, None, None]
    for begun in range(10, n, 20):
        row, col, radius = rng.uniform(3, 5), rng.uniform(3, 5), rng.uniform(2.5, 4)
        form = (
            np.clip(1 - np.hypot(y - row, x - col) / radius, 0, 1)
            if rng.random() < 0.5
            else 1.0 * (np.hypot(y - row, x - col) < radius)
        )
        course = np.sin(np.linspace(0.3, np.pi - 0.3, min(10, n - begun)))
        frames[begun : begun + 10] += height * course[:, None, None] * form
    return frames


def recording(seed: int, n: int = 40, *, n_pads: int = 1, whole: bool = False, **how: Any) -> Recording:
    """Return a recording of such frames."""
    pads = {}
    for number in range(n_pads):
        frames: NDArray[Any] = pressed_frames(seed + 100 * number, n, **how)
        if whole:
            frames = np.rint(frames).clip(0, 1023).astype(np.uint16)
        pads[f"p{number}" if n_pads > 1 else "pad"] = Pad(frames, pitch_m=0.003 if seed % 2 else None)
    return Recording(pads, time_s=np.arange(n) / 50, unit="kPa" if seed % 3 else "raw")
