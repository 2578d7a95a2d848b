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


def run(frames: list[np.ndarray], rate_hz: float = 200.0, **options: object) -> tuple[list[Event], ContactTracker]:
    """Return the events of a sequence of frames, and the tracker that told them."""
    tracker = ContactTracker(**options)
    events = []
    for k, frame in enumerate(frames):
        events += tracker.update(k / rate_hz, find_contacts(frame), frame)
    return events, tracker


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
    assert moved[-1].distance_taxels == pytest.approx(2.0, abs=0.3)
    assert moved[-1].direction_rad == pytest.approx(0.0, abs=0.1)
    # .2 taxel is reached after four frames of motion.
    assert moved[0].told_s - 0.22 < 0.02


def test_a_lost_frame_is_no_release_and_a_long_gap_is() -> None:
    held = [ball(0, 0)] * 30
    held[15] = np.zeros((SIDE, SIDE))
    events, tracker = run(noisy(held))
    assert [event.kind for event in events] == ["touched"]
    late = tracker.update(9.0, find_contacts(held[0]), held[0])
    assert [event.kind for event in late] == ["released"]


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


@pytest.mark.parametrize("time_s", [float("nan"), float("inf")])
def test_a_time_that_is_none_is_refused(time_s: float) -> None:
    with pytest.raises(InputError, match="time must be finite"):
        ContactTracker().update(time_s, [], np.zeros((4, 4)))


def test_frames_of_another_shape_are_refused() -> None:
    tracker = ContactTracker()
    tracker.update(0.0, [], np.zeros((4, 4)))
    with pytest.raises(InputError, match=r"must keep their shape, got \(5, 4\) after \(4, 4\)"):
        tracker.update(0.1, [], np.zeros((5, 4)))
