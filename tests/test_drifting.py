"""Laws of a rest that drifts: what all taxels do together is taken off, and what presses is not."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.pressed_things import told

from varishold import Pad, Recording, recognize_recording, write
from varishold.frame.drifting import drifting_rest
from varishold.frame.together import shares_of
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.stored import stored_of

Frames = NDArray[np.float64]
COURSE = np.r_[np.zeros(14), np.linspace(0.1, 1.0, 8), np.ones(6), np.linspace(0.9, 0.1, 6), np.zeros(6)]
ALL = np.ones((14, 14), np.bool_)
ROW, COL = np.indices(ALL.shape) - 6.5
BALL = np.sqrt(np.maximum(1.0 - (ROW**2 + COL**2) / 20.0, 0.0))
CONE = np.maximum(1.0 - np.hypot(ROW, COL) / 5.0, 0.0)
PLANE = np.ones(ALL.shape)
PRESSES = (BALL, CONE, BALL, PLANE, CONE, BALL)
NAMES = ["sphere", "cone", "sphere", "plane", "cone", "sphere"]
N = len(PRESSES) * len(COURSE)
TIME = np.arange(N) / N
WAYS = {
    "up": 400.0 * TIME,
    "down": -400.0 * TIME,
    "far": 900.0 * TIME,
    "back and forth": 150.0 * np.sin(9.0 * TIME),
    "a jump": 200.0 * (TIME > 0.42),
    "a jump down": -200.0 * (TIME > 0.42),
}


def pressed(seed: int = 0, noise: float = 10.0, forms: tuple[NDArray[np.float64], ...] = PRESSES) -> Frames:
    frames = np.concatenate([COURSE[:, None, None] * form for form in forms])
    made: Frames = 300.0 + 1000.0 * frames + np.random.default_rng(seed).normal(0.0, noise, frames.shape)
    return made


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("unlike", [0.0, 0.2])
def test_presses_on_a_rest_that_drifts_are_named_as_on_one_that_stays(way: str, unlike: float) -> None:
    share = 1.0 + unlike * np.random.default_rng(1).normal(0.0, 1.0, ALL.shape)
    recording = Recording({"pad": Pad(pressed() + WAYS[way][:, None, None] * share)})
    mended = without_faults(recording).pads["pad"]
    assert any(note.startswith("the rest of all taxels goes") for note in mended.notes)
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == NAMES
    # Where it jumps within a press nobody knows when.
    assert np.abs(mended.frames - pressed()).max() < (220.0 if "jump" in way else 130.0)


@pytest.mark.parametrize("pause", [3, 6])
@pytest.mark.parametrize("drift", [-300.0, 60.0, 300.0])
def test_drift_is_taken_off_where_pauses_are_short_and_some_taxels_are_pressed_in_most_frames(
    pause: int, drift: float
) -> None:
    course = np.r_[np.linspace(0.1, 1.0, 4), np.ones(8), np.linspace(0.9, 0.1, 4), np.zeros(pause)]
    forms = (BALL, CONE) * 4
    frames = np.concatenate([np.zeros((8, *ALL.shape)), *(course[:, None, None] * form for form in forms)])
    frames = 1000.0 * frames + drift * np.linspace(0, 1, len(frames))[:, None, None] + 300.0
    frames += np.random.default_rng(0).normal(0.0, 10.0, frames.shape)
    answers = list(recognize_recording(Recording({"pad": Pad(frames)}), frames="press"))
    assert [answer.surface.name for answer in answers] == ["sphere", "cone"] * 4
    assert any(note.startswith("the rest of all taxels goes") for note in answers[0].frame_notes)


@pytest.mark.parametrize("noise", [0.0, 0.5, 10.0])
@pytest.mark.parametrize("whole", [False, True])
def test_a_rest_that_stays_is_left_as_it_is(noise: float, whole: bool) -> None:
    for seed in range(4):
        for forms in (PRESSES, (PLANE, PLANE, BALL), (PLANE,) * 5, (BALL,), (1.0 * (COL > 0), BALL)):
            frames = pressed(seed, noise, forms)
            frames = np.rint(frames).astype(np.uint16) if whole else frames
            assert drifting_rest(frames, ALL) is None
    assert drifting_rest(pressed()[:20], ALL) is None
    assert drifting_rest(np.full((60, 14, 14), 7.0), ALL) is None


@pytest.mark.parametrize("held", [0.3, 0.6, 0.8])
def test_what_is_pressed_all_over_for_long_is_no_drift(held: float) -> None:
    course = np.clip(np.minimum(TIME / 0.05, (held + 0.1 - TIME) / 0.05), 0.0, 1.0)
    noise = np.random.default_rng(3).normal(0.0, 10.0, (N, *ALL.shape))
    assert drifting_rest(300.0 + 1000.0 * course[:, None, None] * PLANE + noise, ALL) is None
    # Bladders press unequal taxels.
    gains = 1.0 + 0.2 * np.random.default_rng(4).normal(0.0, 1.0, ALL.shape)
    assert drifting_rest(300.0 + 1000.0 * course[:, None, None] * gains + noise, ALL) is None


def test_something_that_creeps_where_it_was_pressed_is_no_drift() -> None:
    frames = pressed(forms=(BALL, BALL, BALL))
    frames[len(COURSE) :] += 150.0 * BALL
    assert drifting_rest(frames, ALL) is None


def test_where_all_stay_every_taxel_goes_alike() -> None:
    assert np.array_equal(shares_of(np.ones((20, 5)), np.full(20, 3.0), 0.0), np.ones(5))


def test_blocks_are_mended_as_the_whole_in_whole_numbers() -> None:
    frames = np.rint(pressed() + WAYS["up"][:, None, None]).clip(0, 4095).astype(np.uint16)
    recording = Recording({"pad": Pad(frames)})
    whole = without_faults(recording).pads["pad"].frames
    assert whole.dtype == np.uint16
    mended = stored_without_faults(stored_of(recording))
    for many in (1, 7, 40):
        bounds = [*range(0, N, many), N]
        parts = [mended.part(first, last).pads["pad"].frames for first, last in pairwise(bounds)]
        assert np.array_equal(np.concatenate(parts), whole)


def test_dead_taxels_and_places_without_one_stay_and_so_does_what_is_saturated() -> None:
    frames, field = np.minimum(pressed() + WAYS["up"][:, None, None], 1500.0), ALL.copy()
    field[:3, :2] = False
    frames[:, ~field] = np.nan
    frames[:, 13, 13] = 300.0
    mended = without_faults(Recording({"pad": Pad(frames, field=field)})).pads["pad"].frames
    assert np.isnan(mended[:, ~field]).all()
    assert np.array_equal(mended[:, 13, 13], frames[:, 13, 13])
    assert np.array_equal(mended[frames == 1500.0], frames[frames == 1500.0])


def test_a_command_tells_of_it(tmp_path: object) -> None:
    file = f"{tmp_path}/drifting.npz"
    write(Recording({"pad": Pad(pressed() + WAYS["up"][:, None, None])}), file)
    words = " ".join(told("touch", file, "--frames", "press").output.split())
    assert "the rest of all taxels goes -" in words
