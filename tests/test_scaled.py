"""Laws of frames that were each scaled to their largest reading: it is told, and of no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import told

from varishold import Pad, Recording, write
from varishold.frame.scaled import scaled_words

ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 16.0, 0.0))
LOAD = np.tile(np.r_[np.zeros(8), np.linspace(0.1, 1.0, 6), np.zeros(4)], 3)


def pressed(noise: float = 0.02) -> np.ndarray:
    return LOAD[:, None, None] * BALL + np.abs(np.random.default_rng(0).normal(0.0, noise, (len(LOAD), 12, 12)))


@pytest.mark.parametrize("top", [1.0, 255.0])
@pytest.mark.parametrize("whole", [False, True])
def test_scaled_frames_are_told(top: float, whole: bool) -> None:
    frames = top * pressed() / pressed().max(axis=(1, 2), keepdims=True)
    if whole and top > 1.0:
        frames = np.rint(frames).astype(np.uint8)
    (words,) = scaled_words(frames, ALL)
    assert f"largest reading, {top:g}:" in words


def test_others_are_not() -> None:
    stuck = pressed()
    stuck[:, 3, 3] = 2.0
    for frames in (
        pressed(),
        np.minimum(pressed(), 0.5),
        np.minimum(3.0 * pressed(), 1.0),
        stuck,
        np.rint(4.0 * pressed()),
        (pressed() > 0.3) * 1.0,
        np.zeros((30, 12, 12)),
        np.ones((30, 12, 12)),
        pressed()[:8] / pressed()[:8].max(axis=(1, 2), keepdims=True),
    ):
        assert scaled_words(frames, ALL) == ()


def test_commands_tell_of_it(tmp_path: Path) -> None:
    file = str(tmp_path / "scaled.npz")
    write(Recording({"pad": Pad(255.0 * pressed() / pressed().max(axis=(1, 2), keepdims=True))}), file)
    for command in ("info", "touch"):
        assert "each frame seems to be scaled" in " ".join(told(command, file).output.split())
