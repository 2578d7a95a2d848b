"""Contacts in time: a touch keeps its number, its answer grows, and what happens to it is told."""

from __future__ import annotations

import json

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.touch import ContactTracker, Event, find_contacts

SIDE = 16
Y, X = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2


def ball(x: float, y: float, depth: float = 1.0, reach: float = 4.0) -> np.ndarray:
    """Return the pressure of a ball on a thin layer."""
    return np.maximum(depth - ((X - x) ** 2 + (Y - y) ** 2) / reach**2, 0.0)


def run(
    frames: list[np.ndarray], rate_hz: float = 200.0, *, shears: list[np.ndarray] | None = None, **options: object
) -> tuple[list[Event], ContactTracker]:
    """Return the events of a sequence of frames, and the tracker that told them."""
    tracker = ContactTracker(**options)
    events = []
    for k, frame in enumerate(frames):
        shear = None if shears is None else shears[k]
        events += tracker.update(k / rate_hz, find_contacts(frame), frame, shear=shear)
    return events, tracker


def punch(x: float, lean: float = 0.0, half: float = 4.0) -> np.ndarray:
    """Return the pressure of a round flat face, averaged over taxels, that leans toward +x."""
    at = (np.arange(SIDE * 8) + 0.5) / 8 - SIDE / 2
    face = (1 + lean * (at[None] - x) / half) * (np.hypot(at[None] - x, at[:, None]) <= half)
    return np.asarray(face.reshape(SIDE, 8, SIDE, 8).mean(axis=(1, 3)))


def noisy(frames: list[np.ndarray], sigma: float = 0.01, seed: int = 0) -> list[np.ndarray]:
    """Return frames with white noise."""
    rng = np.random.default_rng(seed)
    return [frame + rng.normal(0, sigma, frame.shape) for frame in frames]


def press(n: int = 60, **where: float) -> list[np.ndarray]:
    """Return frames of a press: rise, hold and fall, with rest around."""
    depth = np.concatenate([np.zeros(10), np.linspace(0.1, 1, 20), np.ones(n), np.linspace(1, 0.1, 10), np.zeros(20)])
    return [ball(where.get("x", 0.0), where.get("y", 0.0), d) for d in depth]


def test_a_press_is_touched_and_released_once_and_named() -> None:
    frames = noisy(press())
    events, _ = run(frames)
    assert [event.kind for event in events] == ["touched", "released"]
    assert {event.track for event in events} == {1}
    _, tracker = run(frames[:80])
    (track,) = tracker.tracks
    assert track.answer is not None
    assert (track.answer.name, track.state) == ("sphere", "hold")
    assert track.looks > 5


def test_a_motion_is_told_with_its_way() -> None:
    held = [ball(0, 0)] * 40 + [ball(k * 0.05, 0) for k in range(41)] + [ball(2.0, 0)] * 80
    events, _ = run(noisy(held))
    moved = [event for event in events if event.kind == "moved"]
    assert [event.kind for event in events] == ["touched"] + ["moved"] * len(moved)
    assert moved[-1].resting
    assert moved[-1].distance_taxels == pytest.approx(2.0, abs=0.1)
    assert moved[-1].direction_rad == pytest.approx(0.0, abs=0.1)
    # .2 taxel is reached after four frames of motion.
    assert moved[0].told_s - 0.22 < 0.02


def test_a_flat_face_that_moves_slides_and_a_ball_may_roll() -> None:
    words = []
    for thing in (punch, lambda x: ball(x, 0)):
        held = [thing(0.0)] * 80 + [thing(k * 0.05) for k in range(31)] + [thing(1.5)] * 60
        events, tracker = run(noisy([np.zeros((SIDE, SIDE))] * 6 + held))
        words.append([event.kind for event in events])
        assert tracker.tracks[0].answer is not None
    assert set(words[0]) == {"touched", "slid"}
    assert set(words[1]) == {"touched", "moved"}


def test_a_face_that_leans_is_tipped_and_has_not_moved() -> None:
    course = [*[0.0] * 60, *np.linspace(0, 0.7, 30), *[0.7] * 60]
    events, _ = run(noisy([punch(0.0, lean) for lean in course]))
    assert {event.kind for event in events} == {"touched", "tipped"}
    last = events[-1]
    assert last.resting
    # The load of a round face moves by a quarter of its radius times the lean.
    assert last.distance_taxels == pytest.approx(0.7, abs=0.1)
    assert last.direction_rad == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("pull", "word"), [(0.3, "slip"), (-0.3, "moved"), (0.0, "moved")])
def test_only_shear_that_pulls_along_tells_a_slip(pull: float, word: str) -> None:
    held = noisy([ball(0, 0)] * 40 + [ball(k * 0.05, 0) for k in range(31)] + [ball(1.5, 0)] * 60)
    rng = np.random.default_rng(1)
    shears = [np.stack([pull * frame, 0 * frame], axis=2) + rng.normal(0, 0.01, (SIDE, SIDE, 2)) for frame in held]
    events, _ = run(held, shears=shears)
    assert {event.kind for event in events} == {"touched", word}


@pytest.mark.parametrize(
    ("shear", "says"),
    [
        (np.zeros((16, 16)), r"shape \(rows, cols, 2\), here \(16, 16, 2\); got \(16, 16\)"),
        ("pull", "shear must be numbers"),
        (np.full((16, 16, 2), np.nan), r"shear must be finite, got \[nan, nan\] at \(row, col\) = \(0, 0\)"),
    ],
)
def test_shear_that_does_not_fit_is_refused(shear: object, says: str) -> None:
    frame = ball(0, 0)
    with pytest.raises(InputError, match=says):
        ContactTracker().update(0.0, find_contacts(frame), frame, shear=shear)


def test_what_comes_in_in_parts_is_one_touch_in_the_end() -> None:
    ends = [0.2 * (ball(-4, 0, 1, 2) + ball(4, 0, 1, 2))] * 8
    bar = [0.2 * np.maximum(ball(-4, 0, 1, 2) + ball(4, 0, 1, 2), (abs(Y) < 2) * (abs(X) < 4))] * 40
    events, tracker = run(noisy([np.zeros((SIDE, SIDE))] * 6 + ends + bar, 0.002))
    assert [event.kind for event in events] == ["touched", "touched", "released"]
    assert [track.state for track in tracker.tracks] == ["hold"]


def two_balls(at: float, left: float = 1.0) -> np.ndarray:
    """Return two fingers at +-at; below 1.8 they are one contact."""
    return np.maximum(ball(-at, 0, left, 2.5), ball(at, 0, 0.8, 2.5))


def test_a_finger_that_leaves_while_two_are_one_contact_is_released() -> None:
    course = [*[4.0] * 40, *np.linspace(4, 1.6, 30), *[1.6] * 20]
    leaves = [two_balls(1.6, left) for left in np.linspace(1, 0, 20)] + [two_balls(1.6, 0.0)] * 20
    events, tracker = run(noisy([two_balls(at) for at in course] + leaves))
    ends = [(event.kind, event.track) for event in events if event.kind in ("touched", "released")]
    assert ends == [("touched", 1), ("touched", 2), ("released", 1)]
    assert tracker.tracks[0].position[0] == pytest.approx(1.6, abs=0.2)


def test_two_fingers_that_move_as_one_contact_keep_their_numbers() -> None:
    course = [*[4.0] * 40, *np.linspace(4, 1.6, 30), *[1.6] * 20]
    moves = [np.roll(two_balls(1.6), k, axis=0) for k in (0, 1, 2, 3, 4) for _ in range(8)]
    parts = [np.roll(two_balls(at), 4, axis=0) for at in np.linspace(1.6, 4, 30)]
    events, tracker = run(noisy([two_balls(at) for at in course] + moves + parts))
    assert [event.kind for event in events if event.kind in ("touched", "released")] == ["touched", "touched"]
    assert [track.position[0] for track in tracker.tracks] == pytest.approx([-4, 4], abs=0.3)


def test_what_a_touch_leaves_behind_is_no_touch() -> None:
    creep = [0.12 * ball(0, 0) * np.exp(-k / 50) for k in range(150)]
    rest = [np.zeros((SIDE, SIDE))] * 3
    events, _ = run(noisy([ball(0, 0)] * 60 + rest + creep, 0.005))
    assert [event.kind for event in events] == ["touched", "released"]


def test_one_wild_frame_is_no_touch() -> None:
    frames = [np.zeros((SIDE, SIDE))] * 60
    frames[30] = 5 * ball(0, 0)
    frames[40] = np.random.default_rng(0).uniform(0, 9, (SIDE, SIDE))
    assert run(noisy(frames))[0] == []


def test_a_clock_that_jumps_back_ends_every_touch() -> None:
    frames = noisy([ball(0, 0)] * 40)
    _, tracker = run(frames)
    (event,) = tracker.update(0.0, find_contacts(frames[0]), frames[0])
    assert event.kind == "released"
    assert event.time_s <= event.told_s
    assert tracker.tracks == ()


def test_a_pad_with_gaps_and_a_pitch_is_followed_in_metres() -> None:
    field = np.hypot(X, Y) < 8
    tracker = ContactTracker(pascals_per_unit=1000.0)
    events = []
    for k, frame in enumerate(noisy([ball(2, 1)] * 20)):
        contacts = find_contacts(frame, field=field, pitch=(0.002, 0.003))
        events += tracker.update(0.01 * k, contacts, contacts[0].frame.padded[1:-1, 1:-1])
    (event,) = events
    assert event.position_m == pytest.approx((2 * 0.003, 1 * 0.002), abs=2e-4)
    assert event.force_n == pytest.approx(event.load * 6e-6 * 1000)
    (track,) = tracker.tracks
    assert track.position == pytest.approx(event.position_m, abs=2e-4)
    assert track.to_dict()["area_m2"] == pytest.approx(track.to_dict()["area_taxels"] * 6e-6)


def test_a_lost_frame_is_no_release_and_a_long_gap_is() -> None:
    held = [ball(0, 0)] * 30
    held[15] = np.zeros((SIDE, SIDE))
    events, tracker = run(noisy(held))
    assert [event.kind for event in events] == ["touched"]
    late = tracker.update(9.0, find_contacts(held[0]), held[0])
    assert [event.kind for event in late] == ["released"]


@pytest.mark.parametrize("rate_hz", [0.2, 1.0, 1.9, 30.0])
def test_slow_frames_are_followed_as_fast_ones_are(rate_hz: float) -> None:
    held = [ball(0, 0)] * 12
    rest = [np.zeros((SIDE, SIDE))] * 12
    events, _ = run(noisy((rest + held) * 3 + rest), rate_hz)
    assert [event.kind for event in events] == ["touched", "released"] * 3
    assert [event.time_s * rate_hz for event in events[::2]] == pytest.approx([12, 36, 60])


def test_frames_that_become_slow_are_followed_again() -> None:
    held = noisy([np.zeros((SIDE, SIDE))] * 10 + [ball(0, 0)] * 60)
    _, tracker = run(held, 50.0)
    for k in range(8):
        tracker.update(10.0 + k, find_contacts(held[-1]), held[-1])
    assert len(tracker.tracks) == 1


def test_two_touches_that_merge_and_part_keep_their_numbers() -> None:
    apart = [ball(-5, 0, 1, 2.5) + ball(5, 0, 0.8, 2.5)] * 10
    way = np.concatenate([np.linspace(5, 1, 40), np.full(10, 1.0), np.linspace(1, 5, 40)])
    frames = [np.maximum(ball(-w, 0, 1, 2.5), ball(w, 0, 0.8, 2.5)) for w in way]
    events, tracker = run(noisy(apart + frames + apart))
    assert sorted(event.track for event in events if event.kind == "touched") == [1, 2]
    assert not [event for event in events if event.kind == "released"]
    first, second = tracker.tracks
    assert first.position[0] == pytest.approx(-5, abs=0.3)
    assert second.position[0] == pytest.approx(5, abs=0.3)


def test_events_and_tracks_are_json() -> None:
    events, tracker = run(noisy(press())[:60], pad="palm")
    told = json.loads(json.dumps([event.to_dict() for event in events]))
    assert told[0]["event"] == "touched"
    assert told[0]["pad"] == "palm"
    assert told[0]["position_m"] is None
    assert json.loads(json.dumps(tracker.tracks[0].to_dict()))["track"] == 1


def test_frames_of_other_contacts_are_refused() -> None:
    with pytest.raises(InputError, match=r"the frame has shape \(4, 4\), its contacts are of a frame of \(16, 16\)"):
        ContactTracker().update(0.0, find_contacts(ball(0, 0)), np.zeros((4, 4)))


@pytest.mark.parametrize("time_s", [float("nan"), float("inf")])
def test_a_time_that_is_none_is_refused(time_s: float) -> None:
    with pytest.raises(InputError, match="time must be finite"):
        ContactTracker().update(time_s, [], np.zeros((4, 4)))


def test_frames_of_another_shape_are_refused() -> None:
    tracker = ContactTracker()
    tracker.update(0.0, [], np.zeros((4, 4)))
    with pytest.raises(InputError, match=r"must keep their shape, got \(5, 4\) after \(4, 4\)"):
        tracker.update(0.1, [], np.zeros((5, 4)))
