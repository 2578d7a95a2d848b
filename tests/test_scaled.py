"""Laws of frames that were each scaled to their largest reading, or lost their mean: taken back, and no others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.scaled import centred_frames, scaled_frames, scaled_words
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

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
        assert scaled_frames(frames, ALL) is None
        assert centred_frames(frames, ALL) is None
        assert centred_frames(np.rint(50.0 * frames).astype(np.int32), ALL) is None


@pytest.mark.parametrize("how", ["stretched", "lossy"])
def test_frames_of_one_range_each_are_told(how: str) -> None:
    rng = np.random.default_rng(4)
    frames = LOAD[:, None, None] * BALL + rng.normal(0.0, 0.02, (len(LOAD), 12, 12))
    assert scaled_words(frames, ALL) == ()
    (words,) = scaled_words({"stretched": stretched, "lossy": lossy}[how](frames), ALL)
    assert words.startswith("each frame seems to be scaled to its own range, about 0 to 255: ")


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.1, 0.3])
def test_what_ends_alike_of_itself_is_not(noise: float) -> None:
    rng = np.random.default_rng(5)
    at_rest = rng.normal(0.0, noise, (len(LOAD), 12, 12))
    held = 0.9 * BALL + at_rest
    for frames in (
        held,
        np.minimum(2.0 * held, 1.0),
        LOAD[:, None, None] * BALL + at_rest,
        np.clip(3.0 * (LOAD[:, None, None] * BALL + at_rest), 0.0, 1.0),
        # Taxels that rest everywhere in the range; one that sticks at each end of it.
        0.1 * LOAD[:, None, None] * BALL + rng.random((12, 12)) + 0.1 * at_rest,
        np.where(np.arange(144).reshape(12, 12) == 7, 1.0, LOAD[:, None, None] * BALL + at_rest),
        # Something always presses, and more of the pad now and then.
        np.clip(BALL + LOAD[:, None, None] * np.roll(BALL, 5, axis=0) + at_rest, 0.0, 1.0),
    ):
        assert scaled_words(frames, ALL) == ()
        assert scaled_frames(frames, ALL) is None


def test_of_a_few_taxels_nothing_is_told() -> None:
    frames = np.random.default_rng(6).integers(0, 2, (40, 1, 2)) * 255.0
    assert scaled_words(frames, np.ones((1, 2), np.bool_)) == ()


def test_commands_tell_of_it(tmp_path: Path) -> None:
    file = str(tmp_path / "scaled.npz")
    write(Recording({"pad": Pad(255.0 * pressed() / pressed().max(axis=(1, 2), keepdims=True))}), file)
    for command in ("info", "touch"):
        assert "each frame seems to be scaled" in " ".join(told(command, file).output.split())


def scaled(frames: np.ndarray) -> np.ndarray:
    low = frames.min(axis=(1, 2), keepdims=True)
    return np.rint(255.0 * (frames - low) / np.ptp(frames, axis=(1, 2), keepdims=True))


def centred(frames: np.ndarray) -> np.ndarray:
    return frames - frames.mean(axis=(1, 2), keepdims=True)


def stretched(frames: np.ndarray) -> np.ndarray:
    low, high = np.percentile(frames, [2.0, 98.0], axis=(1, 2), keepdims=True)
    return np.rint(255.0 * np.clip((frames - low) / (high - low), 0.0, 1.0))


def lossy(frames: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(scaled(frames) + np.random.default_rng(2).normal(0.0, 4.0, frames.shape)), 0.0, 255.0)


@pytest.mark.parametrize("how", [scaled, centred, lambda frames: np.rint(200.0 * centred(frames)), stretched, lossy])
def test_what_was_done_to_each_frame_is_taken_back(how: Callable[[np.ndarray], np.ndarray]) -> None:
    rng = np.random.default_rng(1)
    frames = LOAD[:, None, None] * BALL + 0.1 * rng.random(ALL.shape) + rng.normal(0.0, 0.01, (len(LOAD), 12, 12))
    recording = Recording({"pad": Pad(how(frames))})
    mended = without_faults(recording).pads["pad"]
    assert "each frame seems to" in mended.notes[0]
    # What nothing presses is alike in all frames.
    corner = mended.frames[:, :2, :2].mean(axis=(1, 2))
    assert np.ptp(corner) < 0.1 * float(mended.frames.max())
    stored = stored_without_faults(stored_of(recording)).pads["pad"].frames
    assert np.array_equal(np.concatenate([stored[k : k + 10] for k in range(0, len(LOAD), 10)]), mended.frames)
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.frame // 18 for answer in answers] == [0, 1, 2]
    assert {answer.surface.outline for answer in answers} == {"round"}
