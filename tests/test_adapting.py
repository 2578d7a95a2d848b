"""Laws of readings that adapt to what presses: undone where they do, untouched where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.frame.adapting import adapting_readings
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 20.0, 0.0))
ONCE = np.r_[np.zeros(25), np.linspace(0.1, 1.0, 6), np.ones(30), np.linspace(0.9, 0.1, 5), np.zeros(60)]
COURSE = np.r_[ONCE, 0.6 * ONCE, ONCE]


def forces(course: Frames = COURSE, form: Frames = BALL) -> Frames:
    return 1000.0 * course[:, None, None] * form


def adapted(force: Frames, pace: float, share: float = 1.0) -> Frames:
    """Return forces less a share of what follows them."""
    shown, follows = np.empty_like(force), np.zeros_like(force[0])
    for k, frame in enumerate(force):
        follows = follows + (frame - follows) / pace
        shown[k] = frame - share * follows
    return shown


def read(shown: Frames, noise: float = 8.0, seed: int = 0) -> Frames:
    rng = np.random.default_rng(seed)
    frames: Frames = 300.0 + 100.0 * rng.random(ALL.shape) + shown + rng.normal(0.0, noise, shown.shape)
    return frames


@pytest.mark.parametrize("pace", [20.0, 50.0, 150.0])
@pytest.mark.parametrize("share", [0.3, 0.6, 1.0])
def test_what_adapts_reads_as_what_presses(pace: float, share: float) -> None:
    force = forces()
    found = adapting_readings(read(adapted(force, pace, share)), ALL)
    assert found is not None
    made = found.mended(0, len(force)) - found.rest
    scale = float((made * force).sum() / (force * force).sum())
    assert 0.8 < scale < 1.2
    assert np.abs(made - scale * force).mean() < 30.0
    assert "readings adapt to what presses" in found.words()[0]


@pytest.mark.parametrize("noise", [0.0, 1.0, 8.0, 40.0])
@pytest.mark.parametrize("form", [BALL, np.ones(ALL.shape), 1.0 * (COL > 0)])
def test_what_does_not_adapt_stays(noise: float, form: Frames) -> None:
    for seed in range(3):
        plain = read(forces(form=form), noise, seed)
        assert adapting_readings(plain, ALL) is None
        # Nor what drifts, jumps, or begins within a press.
        time = np.arange(len(plain))[:, None, None] / len(plain)
        own = np.random.default_rng(seed).normal(0.0, 100.0, ALL.shape)
        assert adapting_readings(plain - 200.0 * time, ALL) is None
        assert adapting_readings(plain + own * time, ALL) is None
        assert adapting_readings(plain - 150.0 * (time > 0.3), ALL) is None
        assert adapting_readings(plain[40:], ALL) is None
        # Nor what creeps the other way.
        assert adapting_readings(read(adapted(forces(form=form), 40.0, -0.3), noise, seed), ALL) is None


def test_whole_numbers_become_floating_point_ones() -> None:
    frames = np.rint(read(adapted(forces(), 50.0) + 1500.0)).astype(np.uint16)
    mended = without_faults(Recording({"pad": Pad(frames)})).pads["pad"]
    assert mended.frames.dtype == np.float32
    assert any("adapt" in note for note in mended.notes)


def test_blocks_are_mended_as_the_whole_is() -> None:
    recording = Recording({"pad": Pad(read(adapted(forces(), 50.0)))})
    whole = without_faults(recording).pads["pad"].frames
    stored = stored_without_faults(stored_of(recording)).pads["pad"].frames
    parts = np.concatenate([stored[k : k + 50] for k in range(0, stored.shape[0], 50)])
    assert np.array_equal(parts, whole)


@pytest.mark.parametrize("pace", [30.0, 80.0])
def test_each_press_is_named(pace: float) -> None:
    recording = Recording({"pad": Pad(read(adapted(forces(), pace)))})
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == ["sphere"] * 3
    assert [answer.frame // len(ONCE) for answer in answers] == [0, 1, 2]
