"""Whether readings fall under pressure: what is told from frames, and what is told of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame.polarity import find_fall
from varishold.recording import Pad, Recording
from varishold.recording.stored import stored_of
from varishold.sensor import Sensor, upright_recording
from varishold.sensor.recordings import upright_stored
from varishold.touch import find_contacts, recognize, recognize_recording

Y, X = np.mgrid[:16, :16]
BALL = np.maximum(1.0 - ((X - 7.0) ** 2 + (Y - 8.0) ** 2) / 25.0, 0.0)
EVERYWHERE = np.ones((16, 16), np.bool_)
FORCE = np.r_[np.zeros(10), np.linspace(0.1, 1.0, 10), np.zeros(5)]


def falling(noise: float = 1.0, force: np.ndarray = FORCE, seed: int = 0) -> np.ndarray:
    frames = 250.0 - 120.0 * force[:, None, None] * BALL
    return frames + np.random.default_rng(seed).normal(0.0, noise, frames.shape)


@given(
    st.integers(0, 10_000),
    st.floats(0.0, 5.0),
    st.sampled_from([1e-9, 1.0, 1e6]),
    st.booleans(),
    st.floats(0.0, 0.02),
)
def test_readings_fall_or_rise_wherever_they_rest_and_however_they_begin(
    seed: int, rest: float, scale: float, loaded: bool, noise: float
) -> None:
    rng = np.random.default_rng(seed)
    force = FORCE[15:] if loaded else FORCE
    uneven = rng.normal(0.0, 0.02, BALL.shape)
    rising = scale * (rest + uneven + force[:, None, None] * BALL + rng.normal(0.0, noise, (len(force), 16, 16)))
    assert find_fall(rising, EVERYWHERE) is None
    fall = find_fall(-rising, EVERYWHERE)
    assert fall is not None
    assert fall.pressed < fall.rest
    assert force[fall.frame] > 0


def test_what_is_told_of_a_fall_are_readings_of_its_frame() -> None:
    frames = falling(noise=0.0)
    fall = find_fall(frames, EVERYWHERE)
    assert fall is not None
    assert fall.frame == int(np.argmax(FORCE))
    assert fall.rest == 250.0
    assert frames[fall.frame].min() < fall.pressed < 250.0


@pytest.mark.parametrize(
    ("what", "frames"),
    [
        ("a whole pad that falls alike", np.linspace(250.0, 100.0, 20)[:, None, None] * np.ones((16, 16))),
        ("a row that fails", np.where((np.arange(20)[:, None, None] > 9) & (Y == 4), 0.0, 200.0)),
        ("a column that fails", np.where((np.arange(20)[:, None, None] > 9) & (X == 4), 0.0, 200.0)),
        ("two taxels that fail", np.where((np.arange(20)[:, None, None] > 9) & (Y == 4) & (X < 2), 0.0, 200.0)),
        ("one count less here and there", np.where((np.arange(20)[:, None, None] > 9) & (BALL > 0.5), 12, 13)),
        ("nothing at all", np.full((20, 16, 16), 13)),
        ("three frames", falling()[[0, 12, 18]]),
        ("as much above as below", np.concatenate([falling(0.0), 500.0 - falling(0.0)])),
    ],
)
def test_what_may_be_something_else_is_no_fall(what: str, frames: np.ndarray) -> None:
    assert find_fall(frames, EVERYWHERE) is None, what


@pytest.mark.parametrize("all_over", [1.0, 4.0])
def test_a_press_all_over_hides_no_fall(all_over: float) -> None:
    plane = 250.0 - 30.0 * all_over * FORCE[:, None, None] + np.random.default_rng(1).normal(0.0, 1.0, (25, 16, 16))
    for frames in (np.concatenate([plane, falling()]), np.concatenate([falling(), plane])):
        fall = find_fall(frames, EVERYWHERE)
        assert fall is not None
        assert fall.pressed < fall.rest == pytest.approx(250.0, abs=1.0)
        assert find_fall(500.0 - frames, EVERYWHERE) is None


def test_readings_that_fall_are_refused_with_what_to_say() -> None:
    recording = Recording({"tip": Pad(falling())}, source="press.npy")
    wanted = (
        r"press.npy: readings of pad 'tip' fall where something presses, from about 2\d\d\.?\d* to 1\d\d\.?\d*: "
        r"give a sensor file that says polarity = 'down' and rest = 2\d\d\.?\d*; where they do not fall, "
        r"mark failed taxels in valid, or say polarity = 'up'"
    )
    with pytest.raises(InputError, match=wanted):
        next(recognize_recording(recording))
    with pytest.raises(InputError, match=wanted):
        upright_stored(stored_of(recording), None)
    assert upright_stored(stored_of(recording), None, checked=True).n_frames == len(FORCE)


def test_with_that_said_the_form_is_named() -> None:
    recording = Recording({"pad": Pad(falling())})
    (answer,) = recognize_recording(recording, sensor=Sensor(polarity="down", rest=250.0))
    assert answer.surface.name == "sphere"


def test_a_pad_that_is_known_to_fall_is_refused_without_a_sensor() -> None:
    recording = Recording({"pad": Pad(np.full((2, 4, 4), 9), polarity="down")})
    for turn in (lambda: upright_recording(recording, None), lambda: upright_stored(stored_of(recording), None)):
        with pytest.raises(InputError, match=r"^smaller readings mean more pressure here; give"):
            turn()


def test_a_sensor_that_says_down_is_believed_where_hardly_anything_changes() -> None:
    frames = np.full((20, 16, 16), 242)
    frames[10:, 3, 3] += 1
    assert upright_recording(Recording({"pad": Pad(frames)}), Sensor(polarity="down", rest=255.0)).n_frames == 20


@pytest.mark.parametrize("slope", [0.0, 2.0])
@pytest.mark.parametrize("depth", [5.0, 120.0, 240.0])
def test_a_hollow_in_a_plane_is_not_surely_a_plane(slope: float, depth: float) -> None:
    frame = 250.0 + slope * X - depth * BALL + np.random.default_rng(2).normal(0.0, 0.02 * depth, BALL.shape)
    (contact, *_) = find_contacts(frame)
    surface = recognize(contact)
    assert surface.names["plane"] <= 0.5501
    (answer, *_) = recognize_recording(Recording({"pad": Pad(frame[None])}))
    assert any(note.startswith("a hollow in a plane") for note in answer.frame_notes)


@pytest.mark.parametrize("dead", [np.s_[5], np.s_[:, 7], np.s_[[2, 5, 9, 12], [3, 11, 6, 13]]])
def test_dead_taxels_are_no_hollow(dead: object) -> None:
    from varishold.touch.recognizer import has_hollow

    frame = 250.0 + np.random.default_rng(2).normal(0.0, 2.0, BALL.shape)
    frame[dead] = 100.0  # type: ignore[index]
    assert not any(has_hollow(contact) for contact in find_contacts(frame))


def test_a_plane_that_leans_or_bulges_has_no_hollow() -> None:
    from varishold.touch.recognizer import has_hollow

    noise = np.random.default_rng(2).normal(0.0, 1.0, BALL.shape)
    rim = 3.0 * np.maximum(np.abs(X - 7.5), np.abs(Y - 7.5)) ** 2
    for frame in (250.0 + noise, 250.0 + 4.0 * X + noise, 250.0 - rim + noise, 100.0 + rim + noise):
        assert not has_hollow(find_contacts(frame)[0])


@pytest.mark.parametrize("height", [40.0, 300.0])
@pytest.mark.parametrize("uneven", [0.5, 5.0])
def test_a_hill_on_a_plane_is_not_surely_a_plane(height: float, uneven: float) -> None:
    frame = 1000.0 + height * BALL + np.random.default_rng(2).normal(0.0, uneven, BALL.shape)
    (contact, *_) = find_contacts(frame, floor=50.0)
    assert recognize(contact).names["plane"] <= 0.5501


@given(st.integers(0, 10_000), st.floats(0.0, 0.3), st.floats(-0.02, 0.02))
def test_no_plane_has_a_hill_however_uneven_its_taxels(seed: int, spread: float, slope: float) -> None:
    from varishold.touch.recognizer import has_hill

    rng = np.random.default_rng(seed)
    frame = (1.0 + slope * X) * rng.lognormal(0.0, spread, BALL.shape) + rng.normal(0.0, 0.01, BALL.shape)
    assert not any(has_hill(contact) for contact in find_contacts(frame))


def test_a_hill_on_a_plane_is_told() -> None:
    frame = 30_000.0 + 4500.0 * BALL + np.random.default_rng(2).normal(0.0, 900.0, BALL.shape)
    (answer, *_) = recognize_recording(Recording({"pad": Pad(frame[None])}))
    assert answer.surface.name == "plane"
    assert answer.surface.probability <= 0.5501
    assert any(note.startswith("a hill on a plane") for note in answer.frame_notes)
