"""Laws of glitches: what stands alone in time and place goes, and nothing else does."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.glitches import glitch_rule
from varishold.recording import stored
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of
from varishold.sensor import upright_recording

Frames = NDArray[np.float64]
RAMP = np.r_[np.zeros(12), np.linspace(0.1, 1.0, 10), np.ones(6), np.linspace(0.8, 0.0, 5), np.zeros(8)]


def pressed(shape: tuple[int, int] = (16, 16), seed: int = 0, noise: float = 5.0) -> Frames:
    """Return the frames of a cone that is pressed once."""
    rng = np.random.default_rng(seed)
    row, col = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    cone = np.maximum(1.0 - np.hypot(row, col) / (0.35 * min(shape)), 0.0)
    frames: Frames = 1000.0 * RAMP[:, None, None] * cone + rng.normal(0.0, noise, (len(RAMP), *shape))
    return frames


def recorded(frames: NDArray[np.generic]) -> Recording:
    return Recording({"pad": Pad(frames)})


@pytest.mark.parametrize("noise", [0.0, 5.0, 50.0])
@pytest.mark.parametrize("shape", [(1, 8), (4, 4), (16, 16)])
def test_a_press_without_faults_is_left_as_it_is(shape: tuple[int, int], noise: float) -> None:
    for seed in range(20):
        recording = recorded(pressed(shape, seed, noise))
        assert without_faults(recording) is recording


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.uint16, np.int32])
@pytest.mark.parametrize("at", [0, 1, 5, 16, 24, 39, 40])
def test_a_spike_is_replaced_wherever_it_stands(dtype: type, at: int) -> None:
    clean: NDArray[Any] = np.maximum(pressed(noise=3.0), 0.0).astype(dtype)
    spiked = clean.copy()
    spiked[at, 4, 11] = 4095
    frames = without_faults(recorded(spiked)).pads["pad"].frames
    assert frames.dtype == clean.dtype
    assert np.array_equal(np.delete(frames, at, axis=0), np.delete(clean, at, axis=0))
    assert frames[at].astype(float) == pytest.approx(clean[at].astype(float), abs=60.0)


@pytest.mark.parametrize(("rows", "cols"), [(3, slice(None)), (slice(None), 9), (slice(None), slice(None))])
@pytest.mark.parametrize("reading", [0.0, 4095.0])
def test_a_line_and_a_frame_are_replaced(rows: int | slice, cols: int | slice, reading: float) -> None:
    clean = pressed() + 200.0
    spoiled = clean.copy()
    spoiled[25, rows, cols] = reading
    mended = without_faults(recorded(spoiled))
    assert mended.pads["pad"].frames == pytest.approx(clean, abs=40.0)
    assert any(said in remark for remark in mended.remarks for said in ("alone in time and place", "said nothing"))


def test_two_frames_that_are_lost_near_each_other_are_replaced() -> None:
    clean = pressed()
    spoiled = clean.copy()
    spoiled[[20, 22, 27]] = 0.0
    assert without_faults(recorded(spoiled)).pads["pad"].frames == pytest.approx(clean, abs=200.0)


def test_taxels_that_are_touched_for_a_frame_each_are_no_glitches() -> None:
    frames = 100.0 * np.eye(16)[np.random.default_rng(0).permutation(16)].reshape(16, 4, 4)
    for given in (frames, np.repeat(frames, 2, axis=0) * np.tile([1.0, 0.0], 16)[:, None, None]):
        assert np.array_equal(without_faults(recorded(given)).pads["pad"].frames, given)


def test_presses_of_a_frame_are_no_glitches() -> None:
    cone = pressed(noise=0.0)[25]
    for on, off in ((1, 1), (1, 3), (2, 1), (3, 1)):
        load = np.tile(np.r_[np.ones(on), np.zeros(off)], 10)[:, None, None]
        assert np.array_equal(without_faults(recorded(load * cone)).pads["pad"].frames, load * cone)


def test_unrelated_frames_have_no_glitches() -> None:
    rng = np.random.default_rng(1)
    frames = np.array([np.roll(pressed()[25], tuple(rng.integers(-5, 6, 2)), (0, 1)) for _ in range(60)])
    assert np.array_equal(without_faults(recorded(frames)).pads["pad"].frames, frames)


def test_a_quick_tap_is_no_glitch() -> None:
    cone = pressed(noise=0.0)[25]
    frames = np.random.default_rng(2).normal(0.0, 5.0, (60, 16, 16))
    frames[20:40] += cone
    frames[50] += cone
    assert np.array_equal(without_faults(recorded(frames)).pads["pad"].frames, frames)


def test_a_press_with_spikes_is_one_press_of_what_it_is() -> None:
    rng = np.random.default_rng(3)
    for seed in range(10):
        frames = pressed(seed=seed)
        frames[rng.random(frames.shape) < 0.0005] = 1200.0
        frames[rng.integers(25, 30)] = 0.0
        (answer,) = recognize_recording(recorded(frames), frames="press")
        assert answer.surface.name == "cone"
        assert any("alone in time and place" in note for note in answer.frame_notes)


def test_a_command_tells_of_them(tmp_path: object) -> None:
    frames = pressed()
    frames[24, 2, 2] = 1500.0
    file = f"{tmp_path}/spiked.npz"
    write(recorded(frames), file)
    assert "1 reading stands alone in time and place: replaced by those beside it" in told("touch", file).output


def test_blocks_are_mended_as_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(4)
    frames = np.concatenate([pressed(seed=seed) for seed in range(8)])
    frames[rng.random(frames.shape) < 0.0005] = 1500.0
    whole = without_faults(recorded(frames)).pads["pad"].frames
    mended = stored_without_faults(stored_of(recorded(frames)))
    for many in (1, 3, 50):
        bounds = [*range(0, len(frames), many), len(frames)]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)
    # What is too large for memory is mapped from a file.
    monkeypatch.setattr(stored, "_IN_MEMORY", 1000)
    mapped = upright_recording(recorded(frames), None).pads["pad"].frames
    base: Any = mapped
    while not isinstance(base, np.memmap):
        base = base.base
    assert np.array_equal(mapped, whole)


def test_what_is_no_taxel_may_read_anything() -> None:
    frames = pressed()
    field = np.ones((16, 16), np.bool_)
    field[:2] = False
    frames[:, ~field] = np.nan
    frames[24, 5, 12] = 1500.0
    recording = Recording({"pad": Pad(frames, field=field)})
    assert without_faults(recording).pads["pad"].frames[24, 5, 12] < 100.0


@pytest.mark.parametrize("frames", [np.zeros((7, 4, 4)), np.zeros((50, 4, 4)), np.eye(50).reshape(50, 50, 1)[:, :1]])
def test_too_little_to_tell(frames: NDArray[np.generic]) -> None:
    assert glitch_rule(frames, np.ones(frames.shape[1:], np.bool_)) is None
