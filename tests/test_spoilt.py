"""Laws of frames that are spoilt: what broke off or is full of noise is replaced, and every picture stays."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from varishold import Pad, Recording, recognize_recording
from varishold.frame import polarity
from varishold.frame.running_spoilt import RunningSpoilt
from varishold.frame.spoilt import spoilt_frames
from varishold.live.pad_watcher import PadWatcher
from varishold.live.sample import PadLayout
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 20.0, 0.0))
COURSE = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6), np.zeros(20)]
FORMS = {"ball": BALL, "plane": np.ones(ALL.shape), "half": 1.0 * (COL > 0), "low": np.roll(BALL, 4, axis=0)}


def pressed(seed: int = 0, noise: float = 10.0, rest: float = 300.0, form: Frames = BALL) -> Frames:
    rng = np.random.default_rng(seed)
    frames: Frames = rest + 1000.0 * COURSE[:, None, None] * form + rng.normal(0.0, noise, (len(COURSE), *ALL.shape))
    return frames


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0])
@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("rest", [0.0, 300.0])
@pytest.mark.parametrize("form", FORMS)
def test_every_picture_stays(noise: float, whole: bool, rest: float, form: str) -> None:
    for seed in range(3):
        frames = np.maximum(pressed(seed, noise, rest, FORMS[form]), 0.0)
        frames = np.rint(frames).astype(np.uint16) if whole else frames
        assert spoilt_frames(frames, ALL) is None
        # Through a press of a single frame too, on taxels of unequal gains, and one that loads noise.
        gains = 1.0 + 0.3 * np.random.default_rng(seed).uniform(-1, 1, ALL.shape)
        short = frames.astype(np.float64)
        short[45] += 1000.0 * gains * FORMS[form]
        assert spoilt_frames(short, ALL) is None


@pytest.mark.parametrize("at", [5, 24, 30, 55])
@pytest.mark.parametrize("kind", [np.float64, np.float32, np.uint16])
def test_what_is_missing_at_the_end_of_a_frame_is_as_beside(at: int, kind: type) -> None:
    frames = np.rint(pressed()).astype(kind)
    good = frames.astype(np.float64)
    frames[at].flat[70:] = 0
    frames[at + 3].flat[100:] = 0
    found = spoilt_frames(frames, ALL)
    assert found is not None
    assert found.begins == {at: 70, at + 3: 100}
    mended = found.mended(0, len(frames))
    assert mended.dtype == frames.dtype
    assert np.abs(mended.astype(np.float64) - good).max() < 170.0
    assert np.array_equal(mended[at].ravel()[:70], frames[at].ravel()[:70])
    assert found.words() == ("2 frames broken off before the last taxel: taken as between the frames beside",)


def test_a_press_that_breaks_off_on_a_rest_of_zero_goes_on() -> None:
    frames = np.maximum(pressed(noise=5.0, rest=0.0) - 10.0, 0.0)
    good = frames.copy()
    frames[30, 7:] = 0.0
    found = spoilt_frames(frames, ALL)
    assert found is not None
    assert list(found.begins) == [30]
    assert np.abs(found.mended(0, len(frames)) - good).max() < 60.0
    # What is let go for a frame is let go in all of its taxels.
    let_go = good.copy()
    let_go[30] = good[2]
    assert spoilt_frames(let_go, ALL) is None


@pytest.mark.parametrize("at", [[0], [59], [10], [31], [10, 11, 30], [0, 1, 2]])
def test_noise_that_no_frame_beside_has_is_replaced(at: list[int]) -> None:
    frames = pressed()
    frames[at] = 3000.0 * np.random.default_rng(1).random((len(at), *ALL.shape))
    found = spoilt_frames(frames, ALL)
    assert found is not None
    assert sorted(found.begins) == at
    assert np.abs(found.mended(0, len(frames)) - pressed()).max() < 250.0
    assert found.words()[0].startswith(f"{len(at)} frame")


def test_noise_that_lasts_is_no_burst() -> None:
    frames = pressed()
    frames[25:] += np.random.default_rng(1).normal(0.0, 100.0, frames[25:].shape)
    assert spoilt_frames(frames, ALL) is None


def test_blocks_are_mended_as_the_whole_is(monkeypatch: pytest.MonkeyPatch) -> None:
    frames = pressed()
    frames[0] = 3000.0 * np.random.default_rng(1).random(ALL.shape)
    for k in (14, 15, 29, 44):
        frames[k, 8:] = 0.0 if k != 15 else frames[k, 8:]
    whole = without_faults(Recording({"pad": Pad(frames)})).pads["pad"]
    monkeypatch.setattr("varishold.frame.fault._TOGETHER", 15 * 8 * frames[0].size)
    stored = stored_without_faults(stored_of(Recording({"pad": Pad(frames)}))).pads["pad"].frames
    parts = np.concatenate([stored[k : k + 7] for k in range(0, len(frames), 7)])
    assert np.array_equal(parts, whole.frames)
    assert len(whole.notes) == 2


def test_a_recording_that_begins_with_what_stood_in_a_buffer_is_as_one_that_does_not() -> None:
    rest = 200.0 * np.random.default_rng(3).random(ALL.shape)
    frames = pressed() + rest
    frames[0] = 5000.0 * np.random.default_rng(1).random(ALL.shape)
    (answer,) = recognize_recording(Recording({"pad": Pad(frames)}), frames="press")
    assert answer.surface.name == "sphere"
    assert "zeroed on frames 0 to" in " ".join(answer.frame_notes)


def test_a_sensor_that_settles_in_its_first_frames_is_no_falling_one() -> None:
    frames = pressed()
    settles = frames + 800.0 * np.exp(-np.arange(len(frames)) / 6.0)[:, None, None]
    assert polarity.find_fall(settles, ALL) is None
    assert polarity.find_fall(2000.0 - frames, ALL) is not None
    names = [a.surface.name for a in recognize_recording(Recording({"pad": Pad(settles)}), frames="press")]
    assert "sphere" in names


def streamed(frames: Frames) -> tuple[list[str], tuple[str, ...]]:
    watcher = PadWatcher("pad", PadLayout(shape=(12, 12)))
    seen = [watcher.see(k / 50, frame) for k, frame in enumerate(frames)]
    return [event.kind for one in seen for event in one.events if event.kind != "moved"], seen[-1].notes


def test_in_a_stream_what_is_spoilt_is_as_before() -> None:
    frames = np.concatenate([pressed(0, form=0.0 * BALL), *(pressed(seed) for seed in range(1, 4))])
    rng = np.random.default_rng(5)
    for k in range(65, len(frames), 13):
        frames[k] += rng.normal(0.0, 400.0, ALL.shape)
    for k in range(70, len(frames), 17):
        frames[k].flat[rng.integers(20, 130) :] = 0.0
    kinds, notes = streamed(frames)
    assert (kinds.count("touched"), kinds.count("released")) == (3, 3)
    assert any("broken off or full of noise: taken as before" in note for note in notes)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0])
def test_in_a_stream_every_picture_stays(form: str, noise: float) -> None:
    frames = np.concatenate([pressed(0, noise, form=0.0 * BALL), pressed(1, noise, form=FORMS[form])])
    fast = np.concatenate(
        [pressed(0, noise, form=0.0 * BALL), pressed(1, noise, form=FORMS[form])[[0, 30, 30, 0, 31, 1]]]
    )
    for given in (frames, np.rint(frames).astype(np.uint16), fast):
        _, notes = streamed(given)
        assert not any("broken off" in note for note in notes)


def test_in_a_stream_noise_that_stays_is_taken() -> None:
    spoilt = RunningSpoilt(ALL)
    rng = np.random.default_rng(0)
    frames = 50 + rng.normal(0, 1, (90, *ALL.shape))
    frames[60:] += rng.normal(0, 100, frames[60:].shape)
    shown = [spoilt.update(frame) for frame in frames]
    assert np.array_equal(shown[61], frames[59])
    assert np.array_equal(shown[70:], frames[70:])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_in_a_stream_what_is_no_number_spoils_nothing_else(wrong: float) -> None:
    frames = np.concatenate([pressed(0, form=0.0 * BALL), pressed(1)])
    frames[62::5, 3, 3] = wrong
    frames[70, 4:] = wrong
    spoilt = RunningSpoilt(ALL)
    shown = np.array([spoilt.update(frame) for frame in frames])
    assert np.array_equal(shown[71:], frames[71:], equal_nan=True)
