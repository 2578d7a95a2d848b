"""Presses as they are learned from: what each kind of input becomes, what its rest is, and what another day changes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import Pad, Recording
from varishold.errors import InputError
from varishold.frame import fill_invalid
from varishold.touch.course.presses import (
    Press,
    _resting,
    as_presses,
    cut_presses,
    drifted,
    flat_presses,
    is_flat,
    values_of,
)


def bump(rows: int, cols: int, seed: int = 0) -> np.ndarray:
    y, x = np.mgrid[:rows, :cols]
    middle = np.random.default_rng(seed).uniform(0.3, 0.7, 2)
    return np.exp(-((x - middle[0] * cols) ** 2 + (y - middle[1] * rows) ** 2) / 6)


def rising(rows: int = 6, cols: int = 7, steps: tuple[float, ...] = (0, 0, 1, 3, 4, 2)) -> np.ndarray:
    return np.multiply.outer(steps, bump(rows, cols))


# What comes in


def test_frames_of_every_shape_become_presses() -> None:
    one = rising()
    time = 0.1 * np.arange(6)
    plain, timed, two_pads, single = as_presses([one, (one, time), np.stack([one, 2 * one], axis=1), one[4]])
    assert plain.shapes == {"pad_0": (6, 7)}
    np.testing.assert_allclose(plain.pads["pad_0"], one, atol=1e-12)
    assert plain.time_s is None
    assert timed.time_s is not None
    np.testing.assert_array_equal(timed.time_s, time)
    assert two_pads.shapes == {"pad_0": (6, 7), "pad_1": (6, 7)}
    np.testing.assert_allclose(two_pads.pads["pad_1"], 2 * one, atol=1e-12)
    assert single.pads["pad_0"].shape == (1, 6, 7)
    assert [press.place for press in as_presses(np.stack([one, one]))] == ["press 0", "press 1"]
    assert all(field.all() for field in two_pads.fields.values())
    assert as_presses([plain])[0] is plain
    assert as_presses([]) == []
    assert as_presses(np.ones((2, 3, 4)).astype(np.uint8))[0].pads["pad_0"].dtype == np.float64


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("frames.npz", "presses must be a sequence of recordings or frames, got str"),
        (3, "presses must be a sequence of recordings or frames, got int"),
        ([np.array([["a"]])], "press 0: frames must be numbers in one array"),
        ([np.ones((2, 2)), np.full((2, 2), np.inf)], "press 1: pressure must be finite or, where a taxel is dead, NaN"),
        ([(np.ones((2, 3, 3)), [1.0, 0.5])], "press 0: time_s must not run backward within a press"),
    ],
)
def test_what_is_no_press_is_told_by_its_number(given: Any, says: str) -> None:
    with pytest.raises(InputError) as caught:
        as_presses(given)
    assert says in str(caught.value)
    with pytest.raises(InputError, match="presses must be a sequence"):
        as_presses(Recording({"pad": Pad(rising())}))


def test_a_taxel_that_is_nan_in_any_frame_is_filled_from_its_neighbours_in_all() -> None:
    one = rising()
    one[2, 3, 3] = np.nan
    (press,) = as_presses([one])
    works = np.ones((6, 7), bool)
    works[3, 3] = False
    for made, frame in zip(press.pads["pad_0"], rising(), strict=True):
        np.testing.assert_allclose(made, fill_invalid(frame, works), atol=1e-9)
    # Of several pads the one without a working taxel is left out; its fellow stays.
    both = np.stack([one, np.full_like(one, np.nan)], axis=1)
    (press,) = as_presses([both])
    assert list(press.pads) == ["pad_0"]
    np.testing.assert_allclose(press.pads["pad_0"][4, 2], rising()[4, 2], atol=1e-9)


def test_a_recording_is_one_press_with_its_field_its_time_and_its_numbers() -> None:
    field = np.ones((6, 7), bool)
    field[0, :2] = False
    pad = Pad(np.where(field, rising() + 0.25, 0.0), field=field)
    columns = {
        "angle_rad.thumb": np.array([0.3]),
        "switch.a": np.array([True]),
        "force_n.total": np.array([4]),
        "angle_rad.word": np.array(["x"]),
        "label": np.array(["cup"]),
        "other": np.array([2.0]),
    }
    named = Recording({"palm": pad}, 0.5 * np.arange(6), press=np.zeros(6, int), press_columns=columns)
    (press,) = as_presses([named])
    assert dict(press.columns) == {"angle_rad.thumb": 0.3, "switch.a": 1.0, "force_n.total": 4.0}
    np.testing.assert_array_equal(press.fields["palm"], field)
    assert (press.pads["palm"][:, ~field] == 0).all()
    np.testing.assert_allclose(press.pads["palm"][:, field], rising()[:, field], atol=1e-9)
    assert press.time_s is not None
    assert press.time_s[-1] == 2.5
    assert press.place == "press 0"
    # Of two presses in it no number is this one's.
    twice = {"angle_rad.thumb": np.array([0.3, 0.4])}
    two = Recording({"palm": pad}, press=np.array([0, 0, 0, 1, 1, 1]), press_columns=twice)
    assert dict(as_presses([two])[0].columns) == {}
    with pytest.raises(InputError, match="smaller readings mean more pressure here; give a sensor file"):
        as_presses([Recording({"palm": Pad(rising(), polarity="down")})])


# Cut out of a recording


def long_recording() -> np.ndarray:
    force = np.zeros(60)
    force[20:25], force[45:52] = (2, 5, 6, 5, 2), (3, 6, 8, 8, 8, 6, 3)
    return np.multiply.outer(force, np.full((5, 6), 0.2) + bump(5, 6)) + 0.0


def test_presses_found_by_their_load_take_eight_frames_of_rest_before_them() -> None:
    recording = Recording({"pad": Pad(long_recording())}, 0.01 * np.arange(60))
    first, second = cut_presses(recording)
    assert (len(first.pads["pad"]), len(second.pads["pad"])) == (8 + 5, 8 + 7)
    assert first.time_s is not None
    np.testing.assert_allclose(first.time_s, 0.01 * np.arange(12, 25))
    assert second.place == "the recording, press 1"
    assert dict(first.columns) == {}
    # Where the one before ended later, from there on; at the start from the first frame on.
    near = Recording({"pad": Pad(long_recording()[16:])})
    near = Recording({"pad": Pad(np.concatenate([near.pads["pad"].frames[:12], near.pads["pad"].frames[26:]]))})
    first, second = cut_presses(near)
    assert (len(first.pads["pad"]), len(second.pads["pad"])) == (4 + 5, 3 + 3 + 7)


def test_named_presses_are_cut_as_they_are_named_with_their_numbers() -> None:
    columns = {
        "force_n.total": np.array([1.0, np.nan]),
        "switch.a": np.array([1, 0]),
        "label": np.array(["a", "b"]),
        "angle_rad.x": np.array(["?", "!"]),
    }
    press = np.full(60, -1)
    press[18:26], press[40:53] = 1, 0
    recording = Recording({"pad": Pad(long_recording())}, source="grasps.npz", press=press, press_columns=columns)
    first, second = cut_presses(recording)
    # In the order of their numbers: the later one is number 0.
    assert (len(first.pads["pad"]), len(second.pads["pad"])) == (13, 8)
    assert (first.columns["force_n.total"], first.columns["switch.a"]) == (1.0, 1.0)
    assert math.isnan(second.columns["force_n.total"])
    assert set(first.columns) == {"force_n.total", "switch.a"}
    assert first.place == "grasps.npz, press 0"
    np.testing.assert_array_equal(
        values_of([first, second], ["switch.a", "force_n.total", "none"]), [[1, 1, np.nan], [0, np.nan, np.nan]]
    )
    assert values_of([], ["a", "b"]).shape == (0, 2)
    assert values_of([first, second], []).shape == (2, 0)
    backward = Recording(
        {"pad": Pad(long_recording())}, np.r_[np.arange(45.0), 0.0, np.arange(46.0, 60)], press=press, source="g.npz"
    )
    with pytest.raises(InputError, match=r"g\.npz: press 0: time_s must not run backward"):
        cut_presses(backward)
    with pytest.raises(InputError, match="the recording: no press found: the total never rises above its noise"):
        cut_presses(Recording({"pad": Pad(np.zeros((30, 4, 4)))}))


# Flat frames


def test_a_table_of_flat_frames_is_told_from_presses() -> None:
    press = flat_presses(np.ones((1, 4)))[0]
    assert is_flat(np.ones((3, 4)))
    assert is_flat([[1.0, 2.0], [3.0, 4.0]])
    assert is_flat((np.ones(3), np.ones(3)))
    assert not is_flat(np.ones((2, 3, 4)))
    assert not is_flat([])
    assert not is_flat([np.ones((2, 2))])
    assert not is_flat([press])
    assert not is_flat([(np.ones((2, 2, 2)), [0.0, 1.0])])
    assert not is_flat([Recording({"pad": Pad(rising())})])
    assert not is_flat(Recording({"pad": Pad(rising())}))


def test_flat_frames_are_laid_on_a_grid() -> None:
    frames = np.stack([bump(3, 8, k).ravel() for k in range(4)]) * 10
    for shape, pads, grid in (
        (None, 1, (4, 6)),
        ((3, 8), 1, (3, 8)),
        ((2, 3, 4), 2, (3, 4)),
    ):
        made = flat_presses(frames, shape)
        assert [press.place for press in made] == [f"press {k}" for k in range(4)]
        assert all(press.shapes == {f"pad_{p}": grid for p in range(pads)} for press in made)
        assert all(press.time_s is None and press.pads["pad_0"].shape[0] == 1 for press in made)
    (given,) = flat_presses(frames[:1], (3, 8))
    np.testing.assert_allclose(given.pads["pad_0"][0], frames[0].reshape(3, 8), atol=1e-12)
    a, b = flat_presses(frames[:1], (2, 3, 4))[0].pads.values()
    np.testing.assert_allclose(np.concatenate([a.ravel(), b.ravel()]), frames[0], atol=1e-12)
    for wrong in ((5, 5), (24,), (1, 2, 3, 4)):
        with pytest.raises(InputError, match=rf"needs {math.prod(wrong)} values a press, got 24"):
            flat_presses(frames, wrong)


# The rest


@given(st.integers(0, 2**31), st.integers(1, 14))
@settings(max_examples=30)
def test_a_press_that_starts_unloaded_is_zero_at_its_own_rest(seed: int, still: int) -> None:
    """Its first frames, at most eight, that hold a twentieth at most of what comes."""
    rng = np.random.default_rng(seed)
    offset = rng.normal(0, 3, (6, 7))
    offset -= np.median(offset)
    rise = np.maximum(offset, 0).sum()
    load = np.r_[np.zeros(still), 40.0, 90.0, 60.0] * rise
    frames = load[:, None, None] * bump(6, 7) / bump(6, 7).sum() + offset
    frames += rng.normal(0, 0.01, frames.shape)
    (press,) = as_presses([frames])
    rest = frames[: min(still, 8)].mean(axis=0)
    np.testing.assert_allclose(press.pads["pad_0"], frames - rest, atol=1e-9)


@pytest.mark.parametrize(("share", "rests"), [(0.045, True), (0.05, False)])
def test_a_start_that_bears_more_than_a_twentieth_of_what_comes_is_no_rest(share: float, rests: bool) -> None:
    """Of one form at two loads: the first holds share / (1 - share) of the change."""
    spot = np.zeros((8, 8))
    spot[2:5, 2:5] = 1.0
    frames = np.multiply.outer([share, 1.0, 0.5], spot)
    (press,) = as_presses([frames])
    np.testing.assert_allclose(press.pads["pad_0"], frames - (frames[0] if rests else 0.0), atol=1e-9)


@given(st.integers(0, 2**31))
@settings(max_examples=30)
def test_how_many_frames_rest_is_told_by_what_they_hold_of_the_change(seed: int) -> None:
    rng = np.random.default_rng(seed)
    readings = np.outer(np.r_[np.zeros(rng.integers(1, 4)), np.sort(rng.uniform(0, 1, 6))], rng.uniform(0, 1, 30))
    readings += rng.choice([0.0, 0.05, 0.3]) * rng.normal(0, 1, 30) + rng.choice([0.01, 0.2]) * rng.normal(
        0, 1, readings.shape
    )
    first, strongest = readings[0], max(readings, key=lambda row: row.sum())
    change = strongest - first
    whole = sum(change**2)
    fallen = sum(value**2 for value in change if value < 0)
    uneven = first - np.median(first)
    chance = 3 * np.sqrt(np.mean(uneven**2) / whole)
    told = 0
    if fallen <= 0.2 * whole and uneven @ change <= min(max(0.05, chance), 0.5) * whole:
        while told < min(8, len(readings)) and (readings[told] - first) @ change <= 0.05 * whole:
            told += 1
    assert _resting(readings) == told
    assert _resting(np.ones((3, 5))) == 0


def test_pads_rest_together() -> None:
    """One pad is pressed first: the other's rest lasts no longer than its own."""
    spot = np.zeros((6, 6))
    spot[2:4, 2:4] = 5.0
    early, late = np.multiply.outer([0, 1, 1, 1], spot) + 0.5, np.multiply.outer([0.02, 0.06, 0.9, 1], spot) + 0.25
    (press,) = as_presses([np.stack([early, late], axis=1)])
    np.testing.assert_allclose(press.pads["pad_0"], early - early[0], atol=1e-12)
    np.testing.assert_allclose(press.pads["pad_1"], late - late[0], atol=1e-12)


def test_a_press_that_starts_loaded_loses_the_plane_that_its_strongest_frame_shows() -> None:
    row, col = np.indices((12, 14))
    plane = 3.0 + 0.2 * col - 0.1 * row
    spot = 40 * np.exp(-((col - 7) ** 2 + (row - 6) ** 2) / 4)
    spot[spot < 0.5] = 0
    frames = np.multiply.outer([0.7, 1.0, 0.9], spot) + plane
    (press,) = as_presses([frames])
    np.testing.assert_allclose(press.pads["pad_0"], frames - plane, atol=1e-6)
    # Beyond the field nothing is taken off, and what lies flat stays to the last bit.
    field = np.ones((12, 14), bool)
    field[:, :2] = False
    pad = Pad(np.where(field, frames, 0.0), field=field)
    (press,) = as_presses([Recording({"pad": pad})])
    assert (press.pads["pad"][:, ~field] == 0).all()
    np.testing.assert_allclose(press.pads["pad"][:, field], (frames - plane)[:, field], atol=1e-6)
    bare = np.multiply.outer([0.7, 1.0, 0.9], spot)
    np.testing.assert_array_equal(as_presses([bare])[0].pads["pad_0"], bare)


# Another day


def test_another_day_changes_gains_load_and_place_as_far_as_it_is_told_to() -> None:
    (press,) = as_presses([(rising(9, 11), 0.1 * np.arange(6))])
    frames = press.pads["pad_0"]
    assert drifted(press, 0.0, (1,)).pads["pad_0"] == pytest.approx(frames)
    one = drifted(press, 0.2, (3, 4))
    np.testing.assert_array_equal(one.pads["pad_0"], drifted(press, 0.2, (3, 4)).pads["pad_0"])
    assert not np.array_equal(one.pads["pad_0"], drifted(press, 0.2, (3, 5)).pads["pad_0"])
    gain = one.pads["pad_0"][3] / frames[3]
    np.testing.assert_allclose(one.pads["pad_0"][4], gain * frames[4])
    # Gains are lognormal; the load lies between so much less and half as much more.
    many = np.concatenate([np.log(drifted(press, 0.2, (k,)).pads["pad_0"][3] / frames[3]).ravel() for k in range(40)])
    assert many.std() == pytest.approx(0.2, rel=0.05)
    assert abs(many.mean()) < 0.02
    loads = [float((drifted(press, 0.0, (k,), lighter=0.4).pads["pad_0"][3] / frames[3])[0, 0]) for k in range(300)]
    assert (min(loads), max(loads)) == pytest.approx((0.6, 1.2), abs=0.02)
    assert np.mean(loads) == pytest.approx(0.9, abs=0.05)
    assert one.time_s is press.time_s
    assert one.place == press.place
    # As fast again or as slow, up to that, evenly in logarithm; whoever has no times keeps none.
    assert press.time_s is not None
    paced = [drifted(press, 0.2, (3, k), pace=1.5).time_s for k in range(200)]
    slower = [np.unique(np.round(time_s[1:] / press.time_s[1:], 9)) for time_s in paced if time_s is not None]
    assert all(of.size == 1 for of in slower)
    logs = np.log(np.concatenate(slower)) / np.log(1.5)
    assert (logs.min(), logs.max()) == pytest.approx((-1, 1), abs=0.05)
    assert np.mean(logs) == pytest.approx(0, abs=0.1)
    assert drifted(replace(press, time_s=None), 0.2, (3,), pace=1.5).time_s is None
    np.testing.assert_array_equal(drifted(press, 0.2, (3, 4), pace=1.5).pads["pad_0"], one.pads["pad_0"])


def test_another_day_may_lie_some_taxels_elsewhere_where_a_pad_has_no_gaps() -> None:
    spot = np.zeros((2, 9, 11))
    spot[1] = np.arange(1, 100).reshape(9, 11)
    field = np.ones((9, 11), bool)
    press = Press({"pad": spot}, {"pad": field})
    seen = set()
    for k in range(200):
        moved = drifted(press, 0.0, (k,), elsewhere=2).pads["pad"][1]
        for rows in range(-2, 3):
            for cols in range(-2, 3):
                told = np.zeros((9, 11))
                down, right = max(rows, 0), max(cols, 0)
                part = spot[1][max(-rows, 0) : 9 - down, max(-cols, 0) : 11 - right]
                told[down : down + part.shape[0], right : right + part.shape[1]] = part
                if np.allclose(told, moved):
                    seen.add((rows, cols))
    assert seen == {(rows, cols) for rows in range(-2, 3) for cols in range(-2, 3)}
    field = field.copy()
    field[0, 0] = False
    gaps = Press({"pad": spot}, {"pad": field})
    assert all(np.allclose(drifted(gaps, 0.0, (k,), elsewhere=2).pads["pad"], spot) for k in range(9))
