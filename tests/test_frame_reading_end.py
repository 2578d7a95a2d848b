"""Where readings end although the sensor could show more, as presses show it."""

from __future__ import annotations

import numpy as np
import pytest

from varishold import Pad, Recording, recognize_recording
from varishold.frame.reading_end import reading_end
from varishold.recording import presses
from varishold.sensor import Sensor
from varishold.touch.pad_frames import pad_frames

SIDE = 20
Y, X = np.mgrid[:SIDE, :SIDE] - 9.5
R = np.hypot(X, Y)
RISE = np.concatenate([np.linspace(0.1, 1, 10), np.ones(6), np.linspace(1, 0.1, 6)])
FLAT = (R < 6).astype(float)


def ball(depth: float) -> np.ndarray:
    return np.maximum(depth - (R / 7) ** 2, 0)


def cone(depth: float) -> np.ndarray:
    return np.maximum(depth - R / 7, 0)


def flat(depth: float) -> np.ndarray:
    return depth * FLAT


def pressed(thing, peaks=(1.0, 0.8, 1.0, 0.9), end=np.inf, sigma=0.004, scale=500.0, seed=1):
    """Presses of a thing, each so deep, of a sensor that reads no more than `end`; rest, gains and noise of its own."""
    rng = np.random.default_rng(seed)
    still = [np.zeros((SIDE, SIDE))] * 15
    course = [*still]
    for peak in peaks:
        course += [thing(peak * share) for share in RISE] + still
    clean = np.minimum(np.array(course) * (1 + 0.05 * rng.standard_normal((SIDE, SIDE))), end)
    rest = 40 + 10 * rng.standard_normal((SIDE, SIDE))
    return scale * (clean + sigma * rng.standard_normal(clean.shape)) + rest


def end_in(frames: np.ndarray) -> float | None:
    end = pad_frames(Recording({"pad": Pad(frames)}))["pad"].ends_at
    return None if end is None else end.height


@pytest.mark.parametrize("thing", [ball, cone])
@pytest.mark.parametrize("end", [0.5, 0.65])
def test_where_a_top_stays_while_its_press_grows_readings_end(thing, end) -> None:
    found = end_in(pressed(thing, end=end))
    assert found == pytest.approx(500 * end, rel=0.03)
    assert found < 500 * end


@pytest.mark.parametrize("thing", [ball, cone, flat])
@pytest.mark.parametrize("sigma", [0.001, 0.02])
def test_a_top_that_grows_with_its_press_ends_nowhere(thing, sigma) -> None:
    for seed in range(5):
        assert end_in(pressed(thing, sigma=sigma, seed=seed)) is None
        assert end_in(pressed(thing, peaks=(1.0, 1.0, 1.0), sigma=sigma, seed=seed)) is None


def test_a_flat_face_that_reaches_the_end_tells_nothing_of_it() -> None:
    # All its taxels stop at once, and the press grows no more: it might be held.
    assert end_in(pressed(flat, end=0.6)) is None


def test_a_second_touch_beside_one_that_is_held_is_no_end() -> None:
    held, other = np.roll(FLAT, (-5, -5), (0, 1)) * (R < 99), np.roll(ball(1.0), (5, 5), (0, 1))
    assert end_in(pressed(lambda share: min(3 * share, 1.0) * held + 0.7 * max(share - 0.4, 0) * other)) is None


def test_one_press_is_not_enough() -> None:
    assert end_in(pressed(ball, peaks=(1.0,), end=0.5)) is None
    frames = pressed(ball, end=0.5)
    runs, usable = presses(Recording({"pad": Pad(frames)})), np.ones((SIDE, SIDE), bool)
    assert reading_end(frames, usable, np.median(frames[:15], axis=0), runs, 2.0) is not None
    assert reading_end(frames, usable, np.median(frames[:15], axis=0), runs[:1], 2.0) is None
    few = np.zeros_like(usable)
    few[8:11, 8:13] = True
    assert reading_end(frames, few, np.median(frames[:15], axis=0), runs, 2.0) is None


def test_what_stands_at_the_end_is_saturated_and_told() -> None:
    answers = list(recognize_recording(Recording({"pad": Pad(pressed(ball, end=0.5))}), frames="press"))
    assert len(answers) == 4
    for answer in answers:
        assert any("readings end at about 24" in note for note in answer.frame_notes)
        assert answer.surface.contact.state.saturated > 20
        assert answer.surface.name == "sphere" or answer.surface.probability < 0.9
        assert "sphere" in answer.surface.answer_set


def test_noise_hides_no_taxel_at_an_end_that_is_known() -> None:
    frames = pressed(ball, peaks=(1.0, 0.9), end=0.5)
    at_end = np.count_nonzero(ball(1.0) > 0.55)
    sensor = Sensor(span=500.0, saturation=0.5)
    answer = next(recognize_recording(Recording({"pad": Pad(frames)}), frames="press", sensor=sensor))
    assert answer.surface.contact.state.saturated >= 0.95 * at_end


@pytest.mark.parametrize("counts", [6, 10, 15, 30])
def test_few_counts_are_no_end(counts: int) -> None:
    # A top of few counts stays at one of them while its press grows.
    for seed in range(3):
        for thing in (ball, cone):
            frames = np.rint(pressed(thing, peaks=(1.0, 0.7, 0.9, 0.5), scale=counts, seed=seed))
            assert end_in(frames) is None
            assert end_in(frames / counts) is None


def test_a_press_that_goes_beyond_shows_that_there_is_no_end() -> None:
    two, more = pressed(ball, end=0.5, peaks=(1.0, 0.8)), pressed(ball, end=0.9, peaks=(1.0, 0.8))
    assert end_in(two) is not None
    assert end_in(np.concatenate([two, more])) is None
