"""Laws of enlarged frames: they are answered as what they were enlarged from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.test_drifting import NAMES, pressed

from varishold import Pad, Recording, recognize_recording
from varishold.frame.enlarged import enlargement
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of


def larger(frames: np.ndarray, rows: int, cols: int) -> np.ndarray:
    return np.repeat(np.repeat(frames, rows, axis=1), cols, axis=2)


@given(st.integers(0, 99), st.integers(1, 5), st.integers(1, 5), st.sampled_from([np.float64, np.uint8]))
def test_it_is_known_how_often_taxels_stand(seed: int, rows: int, cols: int, kind: type) -> None:
    frames = np.random.default_rng(seed).integers(0, 256, (4, 8, 7)).astype(kind)
    assert enlargement(larger(frames, rows, cols)) == (rows, cols)


def test_what_is_even_tells_nothing() -> None:
    assert enlargement(np.zeros((3, 8, 8))) == (1, 1)
    assert enlargement(np.full((3, 8, 8), np.nan)) == (1, 1)
    pillar = np.zeros((1, 16, 16))
    pillar[:, 4:12, 4:12] = 1.0
    assert enlargement(pillar) == (1, 1)
    assert enlargement(np.repeat(np.arange(16.0)[None, :, None], 16, axis=2)) == (1, 1)


def test_where_there_is_no_taxel_is_enlarged_too() -> None:
    frames = np.random.default_rng(0).normal(0, 1, (4, 9, 9))
    frames[:, 2:4, 5:] = np.nan
    assert enlargement(larger(frames, 3, 2)) == (3, 2)
    frames[:, 5, 3] = np.nan
    wrong = larger(frames, 3, 2)
    wrong[:, 15, 6] = 0.0
    assert enlargement(wrong) == (1, 1)


@pytest.mark.parametrize("times", [(2, 2), (10, 10), (3, 1)])
def test_presses_are_named_as_before(times: tuple[int, int]) -> None:
    recording = Recording({"pad": Pad(larger(pressed(), *times), pitch_m=(0.001, 0.001))})
    mended = without_faults(recording).pads["pad"]
    assert np.array_equal(mended.frames, pressed())
    assert mended.pitch_m == pytest.approx((0.001 * times[0], 0.001 * times[1]))
    answers = list(recognize_recording(recording, frames="press"))
    if times[0] == times[1]:
        assert [answer.surface.name for answer in answers] == NAMES
    assert f"stands {times[0]} x {times[1]} times" in answers[0].frame_notes[0]


def test_a_single_picture_is_taken_apart_and_its_masks_with_it() -> None:
    field = np.ones((14, 14), np.bool_)
    field[:2, 5:] = False
    one = pressed()[18:19]
    pad = Pad(larger(one, 4, 4), field=larger(field[None], 4, 4)[0], valid=larger(field[None], 4, 4)[0])
    mended = without_faults(Recording({"pad": pad})).pads["pad"]
    assert mended.shape == (14, 14)
    assert np.array_equal(mended.field, field)
    assert np.array_equal(mended.valid, field)


def test_blocks_are_taken_apart_as_the_whole() -> None:
    recording = Recording({"pad": Pad(larger(pressed(), 2, 2)), "other": Pad(pressed(1))})
    whole, stored = without_faults(recording), stored_without_faults(stored_of(recording))
    part = stored.part(20, 60)
    for name in recording.pads:
        assert np.array_equal(part.pads[name].frames, whole.pads[name].frames[20:60])
        assert part.pads[name].shape == (14, 14)
