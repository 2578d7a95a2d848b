"""Laws of frames that were laid into larger ones: they are answered as those that they were made of."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.test_drifting import NAMES, pressed

from varishold import Pad, Recording, recognize_recording
from varishold.frame.padded import padding, padding_words
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

ROW, COL = np.indices((10, 10)) - 4.5
LOAD = np.tile(np.r_[np.zeros(8), np.linspace(1.0, 4.0, 8), np.full(8, 4.0)], 3)[:, None, None]
Lines = tuple[int, int, int, int]


def wider(frames: np.ndarray, lines: Lines, value: float = 0.0) -> np.ndarray:
    """Return frames with so many lines at the top, the bottom, on the left and on the right."""
    top, bottom, left, right = lines
    return np.pad(frames, ((0, 0), (top, bottom), (left, right)), constant_values=value)


@given(
    st.integers(0, 99),
    st.tuples(*[st.integers(0, 4)] * 4),
    st.sampled_from([0.0, 7.0, 90.0]),
    st.sampled_from([np.float64, np.uint8]),
)
def test_it_is_known_where_taxels_stand(seed: int, lines: Lines, value: float, kind: type) -> None:
    # Noise at rest, or raw readings with a press.
    rng = np.random.default_rng(seed)
    frames = np.clip(rng.integers(-4, 5, (40, 7, 8)) + value, 0.0, 255.0)
    if value == 7.0:
        frames[4:18, 1:4, 2:5] += 100.0
        frames += 50.0
    frames = wider(frames.astype(kind), lines, value)
    usable = np.ones(frames.shape[1:], np.bool_)
    found = padding(frames, usable)
    if max(lines) < 2:
        assert found is None
    else:
        inside = np.zeros(frames.shape[1:], np.bool_)
        inside[lines[0] : lines[0] + 7, lines[2] : lines[2] + 8] = True
        assert np.array_equal(found, ~inside)
        words = padding_words(found)
        assert f"rows {lines[0]} to {lines[0] + 6} and columns {lines[2]} to {lines[2] + 7} alone" in words


def test_others_are_left_as_they_are() -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, 1.0, (20, 10, 10))
    press = np.zeros((20, 10, 10))
    press[5:15, 2:8, 3:9] = 50.0
    uneven = wider(noise, (3, 0, 0, 0))
    uneven[:, 0] = 4.0
    ones = np.ones((10, 10), np.bool_)
    for frames in (
        noise,
        noise + press,
        # What shows zeros in place of noise reads nothing where nothing presses.
        press,
        np.maximum(press + noise - 5.0, 0.0),
        np.zeros((20, 10, 10)),
        wider(noise[:5], (3, 3, 3, 3)),
        uneven,
        wider(noise[:, :2], (4, 4, 0, 0)),
    ):
        assert padding(frames, np.ones(frames.shape[1:], np.bool_)) is None
    # Lines that are known to be none, or broken, say nothing.
    known = np.pad(ones, 3)
    assert padding(wider(noise, (3, 3, 3, 3)), known) is None


@pytest.mark.parametrize("lines", [(3, 3, 3, 3), (0, 4, 0, 0), (2, 0, 0, 5)])
def test_presses_are_named_as_before(lines: Lines) -> None:
    frames = wider(pressed(), lines)
    recording = Recording({"pad": Pad(frames)})
    mended = without_faults(recording).pads["pad"]
    assert np.array_equal(mended.frames, frames)
    assert mended.usable.sum() == pressed()[0].size
    stored = stored_without_faults(stored_of(recording)).pads["pad"]
    assert np.array_equal(stored.field, mended.field)
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == NAMES
    assert "taxels stand in rows" in answers[0].frame_notes[0]


def test_what_is_pressed_all_over_is_a_plane() -> None:
    rng = np.random.default_rng(1)
    load = np.tile(np.r_[np.zeros(8), np.ones(5)], 3)
    frames = 50.0 * load[:, None, None] + rng.normal(0.0, 1.0, (len(load), 12, 12))
    for lines in ((0, 0, 0, 0), (4, 4, 4, 4)):
        answers = list(recognize_recording(Recording({"pad": Pad(wider(frames, lines))}), frames="press"))
        assert {answer.surface.name for answer in answers} == {"plane"}
