"""Laws of contacts in time: what does not change what is told, and what turns, scales or shifts it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks._live_presses import Conditions, Press, draw_press
from varishold.touch import Contact, ContactTracker, Event, Track, find_contacts, recognize
from varishold.touch.pooling import EvidencePool

KINDS = ("hold", "move", "tip", "both", "two")
seeds = st.tuples(st.integers(0, 1), st.sampled_from(KINDS))


@cache
def drawn(seed: int, kind: str, rate_hz: float = 128.0) -> Press:
    """Return a press of 128 frames a second: their times are exact."""
    return draw_press((424, seed), kind, Conditions(rate_hz=rate_hz))


def run(
    frames: np.ndarray, time_s: np.ndarray, *, shuffle: np.random.Generator | None = None
) -> tuple[list[Event], list[tuple[Track, ...]]]:
    """Return the events of a press, and its tracks at every frame."""
    tracker = ContactTracker()
    events, tracks = [], []
    for at, frame in zip(time_s.tolist(), frames, strict=True):
        contacts = find_contacts(frame)
        if shuffle is not None:
            shuffle.shuffle(contacts)  # type: ignore[arg-type]
        events += tracker.update(at, contacts, frame)
        tracks.append(tracker.tracks)
    return events + tracker.end(), tracks


@cache
def told(seed: int, kind: str) -> list[Event]:
    """Return the events of a drawn press."""
    press = drawn(seed, kind)
    return run(press.frames, press.time_s)[0]


def like(event: Event, other: Event, **turned: object) -> bool:
    """Tell whether an event is another but for rounding: a sensor's rest is taken off by sums in another order."""
    for name, value in vars(replace(event, **turned)).items():
        its = getattr(other, name)
        if name == "direction_rad" and value is not None and its is not None:
            same = abs((value - its + math.pi) % (2 * math.pi) - math.pi) < 0.02
        elif name in ("area_taxels", "load"):
            # What stands at the floor is in or out.
            same = value == pytest.approx(its, rel=0.05, abs=3)
        elif isinstance(value, (float, tuple)):
            same = value == pytest.approx(its, rel=1e-2, abs=1e-2)
        else:
            same = value == its
        if not same:
            return False
    return True


@given(seeds, st.integers(0, 2**32 - 1))
@settings(max_examples=8, deadline=None)
def test_the_order_of_contacts_is_nothing(drawing: tuple[int, str], order: int) -> None:
    press = drawn(*drawing)
    shuffled, _ = run(press.frames, press.time_s, shuffle=np.random.default_rng(order))
    assert shuffled == told(*drawing)


@given(seeds, st.integers(-30, 30))
@settings(max_examples=8, deadline=None)
def test_scaling_the_pressure_scales_loads_alone(drawing: tuple[int, str], power: int) -> None:
    press = drawn(*drawing)
    scaled, _ = run(press.frames * 2.0**power, press.time_s)
    plain = told(*drawing)
    assert len(scaled) == len(plain)
    for event, other in zip(scaled, plain, strict=True):
        peak = None if event.peak_load is None else event.peak_load / 2.0**power
        assert like(event, other, load=event.load / 2.0**power, peak_load=peak)


@given(seeds, st.integers(1, 3), st.booleans())
@settings(max_examples=8, deadline=None)
def test_turning_the_pad_turns_what_is_told(drawing: tuple[int, str], turns: int, flip: bool) -> None:
    press = drawn(*drawing)
    frames = np.rot90(press.frames, turns, axes=(1, 2))
    frames = np.ascontiguousarray(frames[:, :, ::-1] if flip else frames)
    turned, _ = run(frames, press.time_s)
    plain = told(*drawing)
    assert [event.kind for event in turned] == [event.kind for event in plain]
    for event, other in zip(turned, plain, strict=True):
        x, y = event.position_taxels
        angle = event.direction_rad
        if flip:
            x, angle = -x, None if angle is None else math.pi - angle
        for _ in range(turns):
            # A quarter turn of the array takes x to -y: here it is undone.
            x, y, angle = -y, x, None if angle is None else angle + math.pi / 2
        assert like(event, other, position_taxels=(x, y), direction_rad=angle)


@given(seeds, st.integers(-(2**20), 2**20))
@settings(max_examples=10, deadline=None)
def test_another_beginning_of_time_shifts_times_alone(drawing: tuple[int, str], begin_s: int) -> None:
    press = drawn(*drawing)
    shifted, _ = run(press.frames, press.time_s + begin_s)
    for event, other in zip(shifted, told(*drawing), strict=True):
        assert replace(event, time_s=event.time_s - begin_s, told_s=event.told_s - begin_s) == other


@given(seeds, st.integers(-1, 1), st.integers(-1, 1))
@settings(max_examples=10, deadline=None)
def test_a_pad_that_is_shifted_by_taxels_shifts_positions_alone(
    drawing: tuple[int, str], down: int, right: int
) -> None:
    press = drawn(*drawing)
    rim = np.rint(np.random.default_rng(drawing[0]).normal(0, 1, (len(press.frames), 20, 20)))
    rim[:, 2:-2, 2:-2] = press.frames
    plain, _ = run(rim, press.time_s)
    shifted, _ = run(np.roll(rim, (down, right), axis=(1, 2)), press.time_s)
    assert [(event.kind, event.track) for event in shifted] == [(event.kind, event.track) for event in plain]
    for event, other in zip(shifted, plain, strict=True):
        x, y = event.position_taxels
        assert (x - right, y - down) == pytest.approx(other.position_taxels, abs=0.2)


@given(seeds, st.integers(0, 10_000))
@settings(max_examples=12, deadline=None)
def test_a_frame_that_is_lost_ends_no_touch_and_begins_none(drawing: tuple[int, str], which: int) -> None:
    press = drawn(*drawing)
    frames = press.frames.copy()
    frames[which % len(frames)] = 0.0
    with_loss, _ = run(frames, press.time_s)
    counts = [[e.track for e in events if e.kind == kind] for events in (with_loss, told(*drawing)) for kind in ENDS]
    assert counts[0] == counts[2]
    assert sorted(counts[1]) == sorted(counts[3])


ENDS = ("touched", "released")


@pytest.mark.parametrize(("kind", "rate_hz"), [*((kind, 50.0) for kind in KINDS), ("move", 1000.0), ("both", 300.0)])
def test_the_rate_of_frames_changes_no_word(kind: str, rate_hz: float) -> None:
    press = drawn(1, kind, rate_hz)
    words = list(dict.fromkeys((e.track, e.kind) for e in run(press.frames, press.time_s)[0]))
    assert sorted(words) == sorted(dict.fromkeys((e.track, e.kind) for e in told(1, kind)))


@given(seeds)
@settings(max_examples=8, deadline=None)
def test_every_touch_is_told_once_and_everything_of_it_in_between(drawing: tuple[int, str]) -> None:
    press = drawn(*drawing)
    events, tracks = run(press.frames, press.time_s)
    assert [event.told_s for event in events] == sorted(event.told_s for event in events)
    for number in {event.track for event in events}:
        its = [event for event in events if event.track == number]
        assert [event.kind for event in its if event.kind in ENDS] == list(ENDS)
        assert (its[0].kind, its[-1].kind) == ENDS
        assert all(event.time_s <= event.told_s for event in its)
        held = [track for now in tracks for track in now if track.number == number]
        looks = [track.looks for track in held]
        assert looks == sorted(looks)
        assert its[-1].peak_load == max(track.peak_load for track in held)
        assert its[-1].duration_s == its[-1].time_s - its[0].time_s
        for track in held:
            assert track.answer is None or sum(track.answer.names.values()) == pytest.approx(1)


blobs = st.lists(st.tuples(st.integers(-2, 17), st.integers(-2, 13), st.floats(0.5, 5), st.floats(0, 1e3)), max_size=5)
steps = st.one_of(st.floats(1e-3, 0.05), st.sampled_from([0.0, 1e-9, 0.3, 0.6, -1.0, 1e6]))


@given(
    st.lists(st.tuples(blobs, steps, st.integers(1, 9)), min_size=1, max_size=12),
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.0, 0.1, 3.0]),
)
@settings(max_examples=60, deadline=None)
def test_whatever_comes_every_touch_is_told_once_in_numbers_that_json_holds(
    course: list[tuple[list[tuple[int, int, float, float]], float, int]], seed: int, noise: float
) -> None:
    y, x = np.mgrid[:12, :16]
    rng = np.random.default_rng(seed)
    tracker = ContactTracker(pascals_per_unit=2.0)
    events: list[Event] = []
    at = 0.0
    for now, step, count in course:
        clean = sum(
            (peak * np.maximum(1 - ((x - a) ** 2 + (y - b) ** 2) / r**2, 0) for a, b, r, peak in now),
            np.zeros((12, 16)),
        )
        for _ in range(count):
            frame = clean + rng.normal(0, noise, clean.shape)
            shear = rng.normal(0, 1, (12, 16, 2)) * frame[..., None]
            events += tracker.update(at, find_contacts(frame, pitch=0.002), frame, shear=shear)
            assert json.dumps([track.to_dict() for track in tracker.tracks], allow_nan=False)
            at += step
    events += tracker.end()
    assert tracker.tracks == ()
    assert json.dumps([event.to_dict() for event in events], allow_nan=False)
    begun = [event.track for event in events if event.kind == "touched"]
    assert begun == list(range(1, len(begun) + 1))
    for number in begun:
        its = [event.kind for event in events if event.track == number]
        assert (its[0], its[-1]) == ENDS
        assert set(its[1:-1]).isdisjoint(ENDS)
    assert all(event.time_s <= event.told_s for event in events)


@pytest.mark.parametrize("power", range(-462, 331, 66))
def test_a_touch_of_any_strength_is_told_in_numbers(power: int) -> None:
    """What is fainter is at rest; what is stronger is no reading."""
    y, x = np.mgrid[:12, :16]
    tracker = ContactTracker()
    events: list[Event] = []
    for k in range(40):
        frame = np.ldexp(np.maximum(1 - ((x - 7) ** 2 + (y - 5 - max(k - 25, 0) / 8) ** 2) / 9, 0), power)
        events += tracker.update(k / 50, find_contacts(frame), frame)
    events += tracker.end()
    assert [event.kind for event in events if event.kind in ENDS] == list(ENDS)
    assert {event.track for event in events} == {1}
    assert json.dumps([event.to_dict() for event in events], allow_nan=False)


def test_a_faster_sensor_costs_no_more_looks() -> None:
    slow, fast = (drawn(1, "move", rate) for rate in (128.0, 1000.0))
    looks = [run(press.frames, press.time_s)[1] for press in (slow, fast)]
    most = [max(track.looks for now in tracks for track in now) for tracks in looks]
    assert most[0] <= most[1] <= 1.25 * most[0]
    assert most[1] < 60


def looked(seed: int, n: int) -> list[Contact]:
    """Return contacts of noisy frames of one object."""
    press = drawn(seed, "hold")
    middle = len(press.frames) // 2
    return [find_contacts(frame)[0] for frame in press.frames[middle : middle + n]]


@given(st.integers(0, 3), st.integers(2, 9), st.randoms(use_true_random=False))
@settings(max_examples=10, deadline=None)
def test_the_order_of_looks_is_nothing(seed: int, n: int, order: object) -> None:
    surfaces = [recognize(contact) for contact in looked(seed, n)]
    shuffled = list(surfaces)
    order.shuffle(shuffled)  # type: ignore[attr-defined]
    pools = EvidencePool(), EvidencePool()
    for pool, its in zip(pools, (surfaces, shuffled), strict=True):
        for surface in its:
            pool.add(surface)
    one, other = (pool.answer(surfaces[0]).kind_probability for pool in pools)
    assert one == pytest.approx(other, abs=1e-9)


@given(st.integers(0, 3), st.integers(1, 30))
@settings(max_examples=10, deadline=None)
def test_the_same_look_again_and_again_makes_nothing_surer(seed: int, n: int) -> None:
    surface = recognize(looked(seed, 1)[0])
    pool = EvidencePool()
    for _ in range(n):
        pool.add(surface)
    assert pool.answer(surface).kind_probability == pytest.approx(surface.kind_probability, abs=1e-6)


@given(st.integers(0, 3), st.integers(2, 30))
@settings(max_examples=10, deadline=None)
def test_looks_that_scatter_are_worth_more_and_not_much_more(seed: int, n: int) -> None:
    surfaces = [recognize(contact) for contact in looked(seed, n)]
    pool = EvidencePool()
    for surface in surfaces:
        pool.add(surface)
    names = np.array(list(pool.answer(surfaces[0]).names.values()))
    logs = np.array([[np.log(s.names[name]) for name in pool.answer(s).names] for s in surfaces])
    weight = np.array([s.contact.peak - s.contact.floor for s in surfaces])
    mean = weight @ logs / weight.sum()
    # The odds of the first over the second lie between the plain mean's and 1.3 times that, but for kinds of one name.
    first = float(np.log(names[0] / names[1]))
    assert 0.8 * (mean[0] - mean[1]) <= first <= 1.3 * max(mean[0] - mean[1], 0) * 1.2 + 1e-6
