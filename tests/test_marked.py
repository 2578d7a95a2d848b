"""Laws of readings that are none: one number far beyond all others, here and there for a moment."""

from __future__ import annotations

import numpy as np
import pytest
from tests.test_drifting import NAMES, pressed

from varishold import InputError, Pad, Recording, recognize_recording
from varishold.frame.marked import marked_readings
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

ALL = np.ones((14, 14), np.bool_)


def marked(mark: float, share: float, frames: np.ndarray | None = None) -> np.ndarray:
    """Return presses in which so many readings are the mark."""
    made = pressed() if frames is None else frames.copy()
    made[np.random.default_rng(0).random(made.shape) < share] = mark
    return made


@pytest.mark.parametrize("mark", [65535.0, -9999.0, 1e6])
@pytest.mark.parametrize("share", [0.0003, 0.003, 0.02])
def test_what_is_no_reading_is_as_those_beside_it(mark: float, share: float) -> None:
    frames = marked(mark, share)
    found = marked_readings(frames, ALL)
    assert found is not None
    assert found.mark == mark
    n = int(np.count_nonzero(frames == mark))
    assert found.words() == (
        f"{n} readings are exactly {mark:g}, alone and far beyond all others: taken for none, and as those beside in "
        "time",
    )
    mended = found.mended(0, len(frames))
    assert np.array_equal(mended[frames != mark], frames[frames != mark])
    assert pressed().min() - 20.0 < mended.min()
    assert mended.max() < pressed().max() + 20.0
    assert np.array_equal(np.concatenate([found.mended(k, k + 7) for k in range(0, len(frames), 7)]), mended)


@pytest.mark.parametrize("mark", [65535.0, 1e6])
def test_presses_are_named_as_before(mark: float) -> None:
    recording = Recording({"pad": Pad(np.rint(marked(mark, 0.003)).astype(np.uint32))})
    mended = without_faults(recording).pads["pad"]
    assert mended.frames.dtype == np.uint32
    assert "alone and far beyond all others" in mended.notes[0]
    stored = stored_without_faults(stored_of(recording)).pads["pad"].frames
    assert np.array_equal(np.concatenate([stored[k : k + 10] for k in range(0, len(stored[:]), 10)]), mended.frames)
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == NAMES


def test_readings_are_left_as_they_are() -> None:
    rng = np.random.default_rng(1)
    noise = rng.normal(0.0, 1.0, (60, 14, 14))
    press = np.zeros((60, 14, 14))
    press[20:40, 4:9, 5:10] = 50.0
    # A thing that comes for a moment, hard, and reads the sensor's end all over.
    hard = press + noise
    hard[30:32, 4:9, 5:10] = 1023.0
    # Taxels that touch for a moment, where nothing lasts; on and off; one that sticks.
    taps = noise.copy()
    taps[rng.random(taps.shape) < 0.001] = 255.0
    stuck = press + noise
    stuck[:, 2, 3] = 65535.0
    for frames in (press + noise, hard, taps, press, (taps > 100.0) * 1.0, stuck, np.zeros((60, 14, 14)), noise[:5]):
        assert marked_readings(frames, ALL) is None
    # Near presses a reading far out is a glitch, or a reading.
    near = marked(2.0 * float(np.abs(pressed() - pressed()[0]).max()) + 300.0, 0.003)
    assert marked_readings(near, ALL) is None


def test_where_none_is_near_in_time_it_is_at_rest() -> None:
    frames = pressed()
    frames[10:30, 0, 0] = 65535.0
    found = marked_readings(frames, ALL)
    assert found is not None
    assert abs(float(found.mended(0, len(frames))[20, 0, 0]) - float(np.median(frames[:, 0, 0]))) < 1.0


def test_a_number_for_no_reading_is_named_where_readings_seem_to_be_negative() -> None:
    frames = marked(-9999.0, 0.2)
    with pytest.raises(InputError, match="where -9999 stands for no reading, mark those taxels in valid"):
        Pad(frames)
    with pytest.raises(InputError, match=r"under pressure$"):
        Pad(-pressed())
