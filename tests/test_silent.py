"""Laws of frames without a picture: a pad that says nothing is taken as it was, and what is pressed all over stays."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.silent import silent_frames
from varishold.live.pad_watcher import PadWatcher
from varishold.live.sample import PadLayout
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
COURSE = np.r_[np.zeros(20), np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6), np.zeros(20)]
N = len(COURSE)
ALL = np.ones((12, 12), np.bool_)
ROW, COL = np.indices(ALL.shape) - 5.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 16.0, 0.0))


def pressed(seed: int = 0, noise: float = 10.0, rest: float = 300.0, form: NDArray[np.float64] = BALL) -> Frames:
    rng = np.random.default_rng(seed)
    frames: Frames = rest + 1000.0 * COURSE[:, None, None] * form + rng.normal(0.0, noise, (N, *ALL.shape))
    return frames


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0])
@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("rest", [0.0, 300.0])
def test_every_picture_stays(noise: float, whole: bool, rest: float) -> None:
    for form in (BALL, np.ones(ALL.shape), 1.0 * (COL > 0)):
        for seed in range(3):
            frames = np.maximum(pressed(seed, noise, rest, form), 0.0)
            frames = np.rint(frames).astype(np.uint16) if whole else frames
            assert silent_frames(frames, ALL) is None
            # Pressed all over until all of it is at the sensor's end, and let go.
            assert silent_frames(np.minimum(frames, 900), ALL) is None


@pytest.mark.parametrize("value", [0.0, 4095.0, -20.0])
@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int32])
def test_a_pad_that_says_nothing_any_more_is_taken_as_unpressed(value: float, kind: type) -> None:
    for at in (12, 30, 50):
        frames = pressed().astype(kind)
        frames[at:] = value
        mended = without_faults(Recording({"pad": Pad(frames)})).pads["pad"]
        assert mended.frames.dtype == frames.dtype
        assert np.array_equal(mended.frames[:at], frames[:at])
        assert np.abs(mended.frames[at:].astype(float) - 300.0).max() < 70.0
        assert mended.notes[0].startswith(f"frames {at} to {N - 1}: all taxels show one and the same value")


def test_frames_that_are_lost_again_and_again_are_as_those_before() -> None:
    lost = pressed()
    lost[3::7] = 0.0
    lost[30:33] = 0.0
    mended = without_faults(Recording({"pad": Pad(lost)})).pads["pad"].frames
    assert np.abs(mended - pressed()).max() < 320.0
    (answer,) = recognize_recording(Recording({"pad": Pad(lost)}), frames="press")
    assert answer.surface.name == "sphere"


def test_another_pad_is_no_plane_when_its_plug_comes_off() -> None:
    other = np.random.default_rng(3).normal(300.0, 10.0, (N, 8, 8))
    other[25:] = 4095.0
    recording = Recording({"left": Pad(pressed()), "right": Pad(other)})
    assert [(answer.pad, answer.surface.name) for answer in recognize_recording(recording, frames="press")] == [
        ("left", "sphere")
    ]


def test_blocks_are_mended_as_the_whole() -> None:
    frames = pressed()
    frames[3::7] = 0.0
    frames[45:] = 0.0
    recording = Recording({"pad": Pad(frames)})
    whole = without_faults(recording).pads["pad"].frames
    mended = stored_without_faults(stored_of(recording))
    for many in (1, 7, 40):
        bounds = [*range(0, N, many), N]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)


@pytest.mark.parametrize("value", [0.0, 4095.0])
def test_in_a_stream_a_pad_that_says_nothing_releases_what_it_felt_and_feels_nothing(value: float) -> None:
    frames = np.concatenate([pressed(0, form=0.0 * BALL), pressed(1), pressed(2)])
    frames[N + 31 :] = value
    watcher = PadWatcher("pad", PadLayout(shape=(12, 12)))
    seen = [watcher.see(k / 50, frame) for k, frame in enumerate(frames)]
    assert [event.kind for one in seen for event in one.events if event.kind != "moved"] == ["touched", "released"]
    assert not seen[-1].tracks
    assert any("says nothing" in note for note in seen[-1].notes)


def test_in_a_stream_lost_readings_are_as_those_before() -> None:
    frames = np.concatenate([pressed(0, form=0.0 * BALL), *(pressed(seed) for seed in range(1, 4))])
    frames[40::7] = 0.0
    watcher = PadWatcher("pad", PadLayout(shape=(12, 12)))
    kinds = [event.kind for k, frame in enumerate(frames) for event in watcher.see(k / 50, frame).events]
    assert (kinds.count("touched"), kinds.count("released")) == (3, 3)


def test_in_a_stream_a_pad_without_noise_and_one_pressed_all_over_say_what_they_feel() -> None:
    still = np.rint(np.concatenate([pressed(0, 0.0, form=0.0 * BALL), pressed(1, 0.0), pressed(2, 0.0)])).astype(
        np.uint16
    )
    whole = np.minimum(np.concatenate([pressed(0, form=0.0 * BALL), pressed(1, form=np.ones(ALL.shape))]), 1100.0)
    for frames, times in ((still, 2), (whole, 1)):
        watcher = PadWatcher("pad", PadLayout(shape=(12, 12)))
        kinds = [event.kind for k, frame in enumerate(frames) for event in watcher.see(k / 50, frame).events]
        assert (kinds.count("touched"), kinds.count("released")) == (times, times)


def test_what_is_no_taxel_may_read_anything() -> None:
    frames, field = pressed(), ALL.copy()
    field[:3, :2] = False
    frames[40:] = 0.0
    frames[:, ~field] = np.nan
    mended = without_faults(Recording({"pad": Pad(frames, field=field)})).pads["pad"].frames
    assert np.isnan(mended[:, ~field]).all()
    assert mended[40:, field].min() > 200.0


def test_a_command_tells_of_it(tmp_path: object) -> None:
    frames = pressed()
    frames[50:] = 0.0
    file = f"{tmp_path}/silent.npz"
    write(Recording({"pad": Pad(frames)}), file)
    assert "frames 50 to 59: all taxels show one and the same value" in told("touch", file).output
