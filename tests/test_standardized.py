"""Laws of taxels that were each scaled to their own mean and spread: found, taken back, and told."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.frame.standardized import ROUGHLY, standardized_taxels
from varishold.recording.mended import without_faults

Frames = NDArray[np.float64]
ALL = np.ones((16, 16), np.bool_)
UP = np.linspace(0.1, 1.0, 6)


def recorded(seed: int = 0, rest: int = 20, held: int = 10) -> Frames:
    """Return a press of a ball, shape (n_frames, 16, 16), noise 1, on rests of taxels' own."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:16, :16] - 7.5 - rng.uniform(-1.0, 1.0, (2, 1, 1))
    course = np.r_[np.zeros(rest), UP, np.ones(held), UP[::-1], np.zeros(rest)]
    form = np.maximum(1.0 - (y**2 + x**2) / 25.0, 0.0)
    frames: Frames = rng.uniform(100.0, 300.0, (16, 16)) + 80.0 * course[:, None, None] * form
    return frames + rng.normal(0.0, 1.0, frames.shape)


def standard(frames: Frames, of: int | None = None, ddof: int = 0) -> Frames:
    """Return frames with each taxel's mean and spread, of all frames or of the first ones, taken out."""
    return np.asarray((frames - frames[:of].mean(axis=0)) / frames[:of].std(axis=0, ddof=ddof))


@pytest.mark.parametrize("ddof", [0, 1])
@pytest.mark.parametrize("of", [None, 10, 18])
def test_scaled_taxels_are_taken_back_but_for_a_factor_and_their_rest(of: int | None, ddof: int) -> None:
    for seed in range(4):
        frames = recorded(seed, rest=120)
        found = standardized_taxels(standard(frames, of, ddof), ALL)
        assert found is not None
        mended = found.mended(0, len(frames))
        loads = frames - frames.mean(axis=0)
        assert (mended - loads)[125] == pytest.approx(np.zeros((16, 16)), abs=0.3 * 80.0)
        factors = mended.std(axis=0) / frames.std(axis=0)
        assert np.std(factors) < 2.0 * found.error * np.mean(factors)
        assert found.error < 0.1
        assert (found.mended(7, 9) == mended[7:9]).all()


@pytest.mark.parametrize("of", [None, 10])
def test_a_press_has_its_name_again_and_no_sure_one_where_few_frames_tell_the_noise(of: int | None) -> None:
    right = 0
    for seed in range(6):
        recording = without_faults(Recording({"pad": Pad(standard(recorded(seed), of))}))
        answers = list(recognize_recording(recording))
        assert len(answers) == 1
        right += answers[0].surface.outline == "round"
        assert answers[0].surface.probability <= 0.85 + 1e-9
        assert any(note.startswith(ROUGHLY) for note in answers[0].frame_notes)
    assert right >= 5


def test_many_frames_tell_the_noise_well() -> None:
    long = without_faults(Recording({"pad": Pad(standard(recorded(1, rest=400)))}))
    (answer,) = recognize_recording(long)
    assert not any(note.startswith(ROUGHLY) for note in answer.frame_notes)
    assert any("scaled to its own mean and spread" in note for note in answer.frame_notes)
    assert answer.surface.name == "sphere"


def test_other_recordings_are_left_alone() -> None:
    for seed in range(5):
        frames = recorded(seed)
        for other in (
            frames,
            frames - frames[:10].mean(axis=0),
            (frames - frames.mean()) / frames.std(),
            (frames - frames.mean(axis=(1, 2), keepdims=True)) / frames.std(axis=(1, 2), keepdims=True),
            (frames - frames.mean(axis=0)) / frames.std(),
            np.random.default_rng(seed).normal(0.0, 1.0, frames.shape),
            np.rint(frames),
        ):
            assert standardized_taxels(other, ALL) is None


def test_few_frames_few_taxels_and_whole_numbers_tell_nothing() -> None:
    scaled = standard(recorded())
    assert standardized_taxels(scaled, ALL) is not None
    assert standardized_taxels(standard(recorded()[:7]), ALL) is None
    few = np.zeros((16, 16), np.bool_)
    few[:3, :5] = True
    assert standardized_taxels(scaled, few) is None
    few[:4, :4] = True
    assert standardized_taxels(scaled, few) is not None
    assert standardized_taxels(np.rint(scaled).astype(np.int16), ALL) is None
