"""Laws of lines that flicker: what each row or column does for itself is taken off, and what presses is not."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.test_drifting import ALL, NAMES, N, pressed

from varishold import Pad, Recording, recognize_recording
from varishold.frame.line_noise import column_noise, row_noise
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of


def flicker(axis: int, spread: float = 40.0, seed: int = 9) -> NDArray[np.float64]:
    shape = (N, 14, 1) if axis == 2 else (N, 1, 14)
    return np.random.default_rng(seed).normal(0.0, spread, shape)


@pytest.mark.parametrize("axis", [1, 2])
def test_presses_are_named_as_without_it(axis: int) -> None:
    recording = Recording({"pad": Pad(pressed() + flicker(axis))})
    mended = without_faults(recording).pads["pad"]
    assert mended.notes[0].startswith("rows" if axis == 2 else "columns")
    assert [answer.surface.name for answer in recognize_recording(recording, frames="press")] == NAMES
    before, after = (np.abs(frames - pressed()).mean() for frames in (recording.pads["pad"].frames, mended.frames))
    assert after < 0.6 * before


def test_rows_and_columns_may_both_flicker() -> None:
    frames = pressed() + flicker(1) + flicker(2, seed=10)
    notes = without_faults(Recording({"pad": Pad(frames)})).pads["pad"].notes
    assert [note.split()[0] for note in notes] == ["rows", "columns"]


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0, 60.0])
def test_what_does_not_flicker_is_left_as_it_is(noise: float) -> None:
    for seed in range(8):
        frames = pressed(seed, noise)
        for find in (row_noise, column_noise):
            assert find(frames, ALL) is None
            assert find(np.rint(frames).astype(np.int32), ALL) is None
    # What all do together is none of a line's own, nor what presses frame by frame elsewhere.
    together = np.random.default_rng(0).normal(0.0, 40.0, (N, 1, 1))
    assert row_noise(pressed() + together, ALL) is None
    jumbled = pressed()[np.random.default_rng(0).permutation(N)]
    assert row_noise(jumbled, ALL) is None
    assert column_noise(jumbled, ALL) is None
    assert row_noise(pressed()[:20] + flicker(2)[:20], ALL) is None
    assert row_noise((pressed() + flicker(2))[:, :3], ALL[:3]) is None


def test_blocks_are_mended_as_the_whole_in_whole_numbers() -> None:
    frames = np.clip(np.rint(pressed() + flicker(2)), 0, 1300).astype(np.uint16)
    recording = Recording({"pad": Pad(frames)})
    whole = without_faults(recording).pads["pad"].frames
    assert whole.dtype == frames.dtype
    mended = stored_without_faults(stored_of(recording))
    for bounds in ([0, N], [0, 1, 3, 17, N // 2, N - 2, N]):
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)


def test_where_there_is_no_taxel_nothing_is_read() -> None:
    field = ALL.copy()
    field[:, :4] = field[0] = False
    frames = pressed() + flicker(2)
    frames[:, ~field] = np.nan
    mended = without_faults(Recording({"pad": Pad(frames, field=field)})).pads["pad"]
    assert mended.notes[0].startswith("rows")
    assert np.isnan(mended.frames[:, ~field]).all()
    assert np.isfinite(mended.frames[:, field]).all()


@pytest.mark.parametrize("shape", [(16, 16), (32, 32), (12, 44)])
def test_lines_that_flicker_while_nothing_presses_are_all_taken_off(shape: tuple[int, int]) -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        frames = 300.0 + rng.normal(0.0, 8.0, (300, shape[0], 1)) + rng.normal(0.0, 1.0, (300, *shape))
        found = row_noise(frames, np.ones(shape, np.bool_))
        assert found is not None
        rows = found.mended(0, 300).mean(axis=2)
        # A row that noise makes look pressed is as far off as before.
        assert np.mean(np.abs(rows - np.median(rows, axis=0)) > 3.0) < 0.008


@pytest.mark.parametrize("shape", [(6, 10), (12, 44)])
def test_a_press_beside_rows_that_flicker_is_one_press(shape: tuple[int, int]) -> None:
    """What each taxel reads at rest is known as well as all frames tell it, not as a few do."""
    y, x = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    for seed in range(4):
        rng = np.random.default_rng(seed)
        frames = 300.0 + rng.normal(0.0, 8.0, (300, shape[0], 1)) + rng.normal(0.0, 1.0, (300, *shape))
        frames[100:160] += 60.0 * (np.hypot(y, x) < 2.3)
        found = row_noise(np.rint(frames), np.ones(shape, np.bool_))
        assert found is not None
        assert np.std((found.rest - 300.0) - (found.rest - 300.0).mean(axis=1, keepdims=True)) < 0.3
        free = np.r_[0:100, 160:300]
        mended = found.mended(0, 300)[free]
        assert np.percentile(np.abs(mended.mean(axis=2) - np.median(mended, axis=0).mean(axis=1)), 99) < 0.6


@pytest.mark.parametrize("axis", [1, 2])
def test_lines_that_are_pressed_for_most_of_the_time_are_taken_off_from_the_first_frame_on(axis: int) -> None:
    """A taxel that is pressed for long rests no higher by what its line does, and ends of a recording are no rest."""
    course = np.r_[np.linspace(0.1, 1.0, 6), np.ones(20), np.linspace(0.9, 0.1, 6), np.zeros(15)]
    y, x = np.indices((32, 32)) - 15.5
    forms = [1.0 * (np.maximum(np.abs(y - a), np.abs(x - b)) < 8) for a, b in ((-3, 2), (4, -4), (0, 5), (-2, -3))]
    clean = 800.0 * np.concatenate([np.zeros((20, 32, 32)), *(course[:, None, None] * form for form in forms)])
    for seed in range(3):
        rng = np.random.default_rng(seed)
        n = len(clean)
        lines = rng.normal(0.0, 20.0, (n, 32, 1) if axis == 2 else (n, 1, 32))
        recording = Recording({"pad": Pad(np.rint(200.0 + clean + lines + rng.normal(0.0, 2.0, clean.shape)))})
        mended = without_faults(recording).pads["pad"]
        assert float(mended.notes[0].split(" by ")[1].split()[0]) == pytest.approx(20.0, rel=0.1)
        off = (mended.frames - clean - 200.0).mean(axis=axis)
        free = clean.max(axis=(1, 2)) == 0.0
        assert np.mean(np.abs(off[free]) > 6.0) < 0.001
        answers = list(recognize_recording(recording, frames="press"))
        assert [answer.surface.name for answer in answers] == ["square pillar"] * 4
        assert not any("hill" in note for answer in answers for note in answer.frame_notes)


@pytest.mark.parametrize("times", [2, 3])
def test_readings_that_come_again_are_no_flicker(times: int) -> None:
    """A sensor that is read more often than it measures says the same again."""
    for seed in range(4):
        frames = np.repeat(np.rint(pressed(seed)), times, axis=0)
        for find in (row_noise, column_noise):
            assert find(frames, ALL) is None
        found = row_noise(np.repeat(pressed(seed) + flicker(2), times, axis=0), ALL)
        assert found is not None
