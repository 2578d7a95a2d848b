"""The zero that follows: its laws in small worlds, its log, and what it survives."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame import FollowingZero, Zeroing

SIGMA = 1.0


def blob(shape, row, col, peak=100.0, radius=1.5):
    y, x = np.mgrid[: shape[0], : shape[1]]
    return peak * np.exp(-((y - row) ** 2 + (x - col) ** 2) / (2 * radius**2))


class World:
    """A pad of noise over a rest, at a steady rate; `at` counts frames."""

    def __init__(self, shape=(12, 12), rate_hz=50.0, seed=0, **options):
        self.rng = np.random.default_rng(seed)
        self.rest = self.rng.uniform(50, 150, shape)
        self.share = self.rng.normal(1.0, 0.25, shape)
        self.zero = FollowingZero(shape, **options)
        self.shape, self.rate_hz, self.at, self.common = shape, rate_hz, 0, 0.0

    @property
    def time_s(self):
        return self.at / self.rate_hz

    def frame(self, press=0.0):
        return self.rest + self.share * self.common + press + self.rng.normal(0, SIGMA, self.shape)

    def run(self, seconds, press=0.0, drift_per_s=0.0):
        """Run on; return the mean of the last half second's zeroed frames."""
        n, last = round(seconds * self.rate_hz), []
        for k in range(n):
            self.common += drift_per_s / self.rate_hz
            zeroed = self.zero.update(self.time_s, self.frame(press))
            self.at += 1
            if k >= n - self.rate_hz / 2:
                last.append(zeroed)
        return np.mean(last, axis=0)


def test_it_begins_on_quiet_frames_and_says_so():
    world = World()
    assert world.zero.state == "starting"
    shown = world.run(3)
    assert np.abs(shown).max() < 2 * SIGMA
    (note,) = world.zero.log
    assert note.why == "start"
    assert note.taken
    assert note.reason == ""
    assert note.n_taxels == 144
    assert world.zero.state == "following"
    assert np.allclose(world.zero.noise, SIGMA, rtol=0.6)


@pytest.mark.parametrize("at", [1, 12, 37])
@pytest.mark.parametrize("off", [-4000.0, 4000.0, 1e7])
def test_a_glitch_at_the_start_is_no_rest(at, off):
    clean, world = World(), World()
    glitch = np.zeros(world.shape)
    glitch[5, 6] = off
    for _ in range(at):
        clean.run(1 / 50)
        world.run(1 / 50)
    clean.run(1 / 50)
    world.run(1 / 50, press=glitch)
    assert np.abs(world.run(1.5)).max() < 2 * SIGMA
    clean.run(1.5)
    assert np.allclose(world.zero.baseline, clean.zero.baseline, atol=0.5 * SIGMA, rtol=0)
    assert np.allclose(world.zero.noise, clean.zero.noise, rtol=0.3)


def test_what_changes_at_the_start_without_coming_back_is_no_glitch():
    world = World()
    world.run(0.3)
    world.rest[5, 6] += 200
    world.run(6)
    assert np.abs(world.run(0.5)).max() < 4 * SIGMA


def test_a_press_that_stands_at_the_start_is_said():
    world = World()
    world.rest = np.full(world.shape, 80.0)
    world.run(2, press=blob(world.shape, 5, 5))
    (note,) = world.zero.log
    assert note.taken
    assert "something may press on each of" in note.reason
    world.run(1)
    assert np.abs(world.run(2)).max() < 3 * SIGMA


def test_a_press_that_moves_at_the_start_is_said():
    world = World()
    for k in range(60):
        world.run(0.1, press=blob(world.shape, 3 + k % 6, 5))
    assert "something presses" in world.zero.log[0].reason


@pytest.mark.parametrize("ramp_s", [0.1, 0.3])
@pytest.mark.parametrize("begin_s", [0.2, 0.5, 0.9])
def test_a_press_that_rises_slowly_while_the_zero_is_taken_is_none_of_it(begin_s, ramp_s):
    world, press = World(rate_hz=100.0), blob((12, 12), 5, 5)
    world.run(begin_s)
    for k in range(round(100 * ramp_s)):
        world.run(0.01, press * k / (100 * ramp_s))
    shown = world.run(1.5, press)
    assert world.zero.pressed[5, 5]
    assert abs(shown[5, 5] / 100 - 1) < 0.1
    assert np.abs(world.run(1.0)).max() < 3 * SIGMA


@pytest.mark.parametrize("lasts_s", [0.3, 2.5])
def test_what_presses_from_the_start_is_no_zero_once_it_lets_go(lasts_s):
    world, press = World(rate_hz=100.0), blob((12, 12), 5, 5)
    world.run(lasts_s, press)
    world.run(0.12)
    assert np.abs(world.zero.baseline - world.rest).max() < 4 * SIGMA
    shown = world.run(0.4, press)
    assert world.zero.pressed[5, 5]
    assert abs(shown[5, 5] / 100 - 1) < 0.1


def test_presses_from_the_start_on_count_from_the_lowest_that_was_seen():
    world = World(rate_hz=100.0)
    places = [(3, 3), (8, 8), (3, 8), (8, 3)] * 3
    for k, (row, col) in enumerate(places):
        shown = world.run(0.25, blob(world.shape, row, col))
        if k:
            assert world.zero.pressed[row, col]
            assert abs(shown[row, col] / 100 - 1) < 0.15
        world.run(0.15)
    assert np.abs(world.zero.baseline - world.rest).max() < 4 * SIGMA


@pytest.mark.parametrize("drift_per_s", [0.4, -0.4])
def test_a_pressed_taxel_follows_what_the_free_ones_do_by_its_own_share(drift_per_s):
    world = World(rate_hz=30.0)
    world.run(90, drift_per_s=drift_per_s)
    assert np.abs(world.zero.share - world.share / world.share.mean()).max() < 0.2
    press = blob(world.shape, 5, 6)
    first = world.run(2, press, drift_per_s)
    last = world.run(60, press, drift_per_s)
    assert abs(last.sum() / first.sum() - 1) < 0.05
    assert abs(first[5, 6] / 100 - 1) < 0.05
    assert world.zero.pressed[5, 6]
    assert not world.zero.free[3, 6]
    assert abs(world.zero.drift - world.common * world.share.mean()) < 1.0
    assert np.abs(world.run(3, drift_per_s=drift_per_s)).max() < 3 * SIGMA
    assert not world.zero.pressed.any()


def test_what_creeps_back_is_no_press():
    world = World()
    press = blob(world.shape, 5, 6)
    world.run(3)
    world.run(3, press)
    world.run(0.2, 0.12 * press)
    assert not world.zero.pressed.any()
    assert np.abs(world.run(1, 0.12 * press)).max() < 3 * SIGMA


def test_a_light_press_beside_a_heavy_one_that_ends_stays():
    world = World(shape=(12, 24))
    heavy, light = blob(world.shape, 5, 4, 1000), blob(world.shape, 5, 18, 60)
    world.run(3)
    before = world.run(1, heavy + light)
    after = world.run(5, light)
    assert world.zero.pressed[5, 18]
    assert not world.zero.pressed[5, 4]
    assert abs(after[5, 18] - before[5, 18]) < SIGMA


def test_a_plane_over_the_whole_pad_is_held():
    world = World()
    world.run(3)
    world.run(30, press=60.0)
    assert world.zero.state == "holding"
    assert abs(world.run(1, press=60.0).mean() - 60) < SIGMA
    world.run(1)
    assert world.zero.state == "following"
    assert np.abs(world.run(1)).max() < 2 * SIGMA


def test_a_zero_on_request_is_taken_and_logged():
    world = World()
    world.run(3)
    assert world.zero.ask(world.time_s) is None
    assert world.zero.state == "zeroing"
    world.run(1)
    note = world.zero.log[-1]
    assert (note.why, note.taken, note.n_taxels) == ("asked", True, 144)
    assert note.n_frames >= 25
    assert note.largest_change < 3 * SIGMA
    assert json.loads(json.dumps(note.to_dict()))["why"] == "asked"


def test_a_zero_is_refused_while_something_presses():
    world = World()
    press = blob(world.shape, 5, 6)
    world.run(3)
    before = world.run(1, press)
    refused = world.zero.ask(world.time_s)
    assert isinstance(refused, Zeroing)
    assert not refused.taken
    assert world.zero.log[-1] is refused
    assert refused.reason.startswith("something presses on each of")
    assert abs(world.run(1, press).sum() / before.sum() - 1) < 0.03
    assert world.zero.ask(world.time_s, anyway=True) is None
    world.run(1, press)
    assert world.zero.log[-1].taken
    assert np.abs(world.run(0.6, press)).max() < 2 * SIGMA


def test_a_zero_is_refused_if_something_begins_to_press_meanwhile():
    world = World()
    world.run(3)
    world.zero.ask(world.time_s)
    world.run(0.2)
    world.run(1, press=blob(world.shape, 5, 6, 60))
    assert not world.zero.log[-1].taken
    assert "something presses" in world.zero.log[-1].reason


@pytest.mark.parametrize("jump_s", [5.0, 40.0, 4000.0, -1e6])
def test_pauses_and_jumps_of_the_clock_are_survived(jump_s):
    world = World()
    world.run(60, drift_per_s=0.4)
    world.at += round(jump_s * world.rate_hz)
    world.common += 30
    shown = world.run(3)
    assert np.abs(shown).max() < 3 * SIGMA
    assert not world.zero.pressed.any()
    assert ("pause" in [note.why for note in world.zero.log]) == (jump_s > 60)


@pytest.mark.parametrize("jump_s", [5.0, 4000.0])
def test_a_press_is_kept_through_a_pause(jump_s):
    world = World()
    press = blob(world.shape, 5, 6)
    world.run(60, drift_per_s=0.4)
    before = world.run(2, press)
    world.at += round(jump_s * world.rate_hz)
    world.common += 10
    assert abs(world.run(3, press)[5, 6] - before[5, 6]) < 5


def test_readings_that_are_no_numbers_count_as_the_last_ones():
    world = World()
    world.run(3)
    for bad in (np.nan, np.inf, -np.inf, 1e300):
        frame = world.frame()
        frame[2, 3] = bad
        assert np.abs(world.zero.update(world.time_s, frame)).max() < 6 * SIGMA
        world.at += 1
    assert world.zero.n_not_finite == 4
    assert np.abs(world.run(1)).max() < 2 * SIGMA


def test_an_impulse_presses_nothing_for_long():
    world = World()
    world.run(3)
    impulse = np.zeros(world.shape)
    impulse[4, 4] = 500
    world.zero.update(world.time_s, world.frame(impulse))
    world.at += 1
    assert np.abs(world.run(2)).max() < 2 * SIGMA
    assert not world.zero.pressed.any()


@pytest.mark.parametrize("impulse", [900.0, -900.0])
def test_an_impulse_on_a_press_does_not_end_it(impulse):
    world = World()
    press = blob(world.shape, 5, 6)
    world.run(3)
    before = world.run(1, press)
    world.zero.update(world.time_s, world.frame(press + impulse * (press > 99)))
    world.at += 1
    assert abs(world.run(2, press).sum() / before.sum() - 1) < 0.03


def test_a_light_press_after_a_heavy_one_in_the_same_place_is_felt():
    world = World()
    press = blob(world.shape, 5, 6)
    world.run(3)
    world.run(1, 10 * press)
    world.run(3)
    shown = world.run(2, 0.5 * press)
    assert world.zero.pressed[5, 6]
    assert abs(shown[5, 6] - 50) < 3


def test_noise_does_not_move_the_common_drift():
    # What is cut off on one side alone would.
    world = World(shape=(8, 8), rate_hz=100.0)
    world.run(2)
    begun = world.zero.drift
    world.run(60)
    assert abs(world.zero.drift - begun) < 0.3


def test_tapping_in_one_place_is_felt_and_teaches_no_noise():
    world = World()
    press, felt = blob(world.shape, 5, 6), []
    world.run(3)
    for _ in range(200):
        for k in range(10):
            # A twelfth of each tap stays for a while.
            zeroed = world.zero.update(world.time_s, world.frame(press * (1.0 if k < 5 else 0.08)))
            world.at += 1
            felt += [zeroed[5, 6]] * (k < 5)
    assert abs(np.median(felt) - 96) < 6
    assert world.zero.noise[5, 6] < 2 * SIGMA
    assert np.abs(world.run(8)).max() < 2 * SIGMA


def test_a_noise_that_grows_all_over_and_ends_is_learned_at_once():
    world = World()
    world.run(10)
    wrong = 0
    for loud in (10.0, 0.0):
        for k in range(1000):
            world.zero.update(world.time_s, world.frame(world.rng.normal(0, loud, world.shape)))
            world.at += 1
            wrong += k > 200 and bool(world.zero.pressed.any())
        assert abs(np.median(world.zero.noise) / np.hypot(loud, SIGMA) - 1) < 0.5
    assert wrong == 0


def test_a_noise_that_grows_on_a_part_of_the_pad_presses_nothing_for_long():
    noise, zero, pressed = np.random.default_rng(0), FollowingZero((16, 16)), []
    for k in range(3000):
        loud = np.ones((16, 16))
        loud[:8, :8] += 4.0 * (k > 1000)
        zero.update(k / 50, 100 + loud * noise.normal(0, 1, (16, 16)))
        pressed.append(zero.is_pressed)
    assert not any(pressed[1300:])
    assert 3.5 < zero.noise[:8, :8].mean() < 5.5
    assert zero.noise[8:, 8:].mean() < 1.2


def test_noise_that_a_filter_hides_from_frame_to_frame_is_seen():
    world = World(rate_hz=100.0)
    noise, wrong = np.zeros(world.shape), 0
    for k in range(3000):
        noise = 0.97 * noise + world.rng.normal(0, SIGMA, world.shape)
        world.zero.update(world.time_s, world.rest + noise)
        world.at += 1
        wrong += k > 300 and bool(world.zero.pressed.any())
    assert wrong == 0


def test_a_pad_pressed_all_over_while_it_drifts_is_free_after_it():
    world = World(shape=(4, 4))
    world.run(60, drift_per_s=0.2)
    world.run(120, press=100.0, drift_per_s=0.2)
    assert world.zero.state == "holding"
    world.run(2, drift_per_s=0.2)
    assert not world.zero.pressed.any()
    assert np.abs(world.run(1, drift_per_s=0.2)).max() < 3 * SIGMA


def test_masked_taxels_show_nothing_and_count_for_nothing():
    valid, field = np.ones((12, 12), bool), np.ones((12, 12), bool)
    valid[3, 4], field[:, -1] = False, False
    world = World(valid=valid, field=field)
    world.rest[3, 4] = 1e9
    shown = world.run(4, press=np.where(valid, 0, np.nan))
    assert np.all(shown[~(valid & field)] == 0)
    assert world.zero.n_not_finite == 0
    assert world.zero.log[0].n_taxels == (valid & field).sum()


@settings(max_examples=15, deadline=None)
@given(
    st.sampled_from([(1, 1), (1, 2), (1, 16), (16, 1), (2, 2), (3, 4), (4, 4), (6, 4), (5, 40)]),
    st.sampled_from([7.0, 30.0, 300.0]),
    st.integers(0, 2**16),
)
def test_any_shape_and_rate_begins_follows_and_feels(shape, rate_hz, seed):
    world = World(shape=shape, rate_hz=rate_hz, seed=seed)
    assert np.abs(world.run(5, drift_per_s=0.3)).max() < 5 * SIGMA
    row, col = shape[0] // 2, shape[1] // 2
    press = blob(shape, row, col, peak=200, radius=0.9)
    shown = world.run(2, press)
    assert world.zero.pressed[row, col]
    assert abs(shown[row, col] - 200) < 10
    world.run(2)
    assert not world.zero.pressed.any()


@given(st.floats(0.01, 1000))
@settings(max_examples=10, deadline=None)
def test_the_unit_changes_nothing(scale):
    worlds = [World(seed=3) for _ in range(2)]
    press = blob((12, 12), 5, 6)
    for k in range(250):
        frame = worlds[0].frame(press * (k > 150))
        a = worlds[0].zero.update(k / 50, frame)
        b = worlds[1].zero.update(k / 50, scale * frame)
        assert np.allclose(scale * a, b, rtol=1e-6, atol=1e-6 * scale)


def test_whole_numbers_are_taken():
    zero = FollowingZero((4, 4))
    for k in range(100):
        shown = zero.update(k / 50, np.full((4, 4), 7, np.uint8))
    assert shown.dtype == np.float64
    assert np.all(shown == 0)
    assert np.allclose(zero.noise, 12**-0.5)
    zero.update(2.0, np.full((4, 4), 12, np.uint8))
    assert zero.pressed.all()


def test_what_is_given_is_neither_kept_nor_changed():
    world = World()
    world.run(2)
    frame = world.frame()
    kept = frame.copy()
    shown = world.zero.update(world.time_s, frame)
    assert np.array_equal(frame, kept)
    again = shown.copy()
    frame[:] = 1e6
    world.at += 1
    world.run(0.1)
    assert np.array_equal(shown, again)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FollowingZero((3,)), r"shape must be \(rows, cols\), two whole numbers from 1, got \(3,\)"),
        (lambda: FollowingZero((0, 3)), "two whole numbers from 1"),
        (lambda: FollowingZero((3, 3), field=np.ones((2, 2), bool)), "field must have the shape"),
        (lambda: FollowingZero((3, 3), least_noise=-1), "least_noise must be finite and not negative"),
        (lambda: FollowingZero((3, 3)).update(0, np.ones((3, 4))), r"shape of the pad, \(3, 3\), got \(3, 4\)"),
        (lambda: FollowingZero((3, 3)).update(0, [["a"]]), "a frame must be numbers"),
        (lambda: FollowingZero((3, 3)).update(float("nan"), np.ones((3, 3))), "time_s must be finite, got nan"),
    ],
)
def test_what_it_says_of_bad_input(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("quiet_s", [0.2, 0.5, 0.9])
def test_a_press_that_begins_early_is_felt_and_its_rest_is_what_came_before(quiet_s):
    world = World()
    world.run(quiet_s)
    for _ in range(20):
        zeroed = world.run(0.1, press=blob(world.shape, 5, 5))
    assert world.zero.log[0].reason == ""
    assert world.zero.log[0].time_s < quiet_s + 0.1
    assert np.abs(zeroed - blob(world.shape, 5, 5)).max() < 6
    assert world.zero.pressed[5, 5]


def test_a_press_that_ends_early_is_no_rest():
    world = World()
    world.run(0.5, press=blob(world.shape, 5, 5))
    for _ in range(25):
        zeroed = world.run(0.1)
    assert np.abs(zeroed).max() < 6
    assert world.zero.log[-1].taken
    assert not world.zero.pressed.any()


def test_a_zero_that_does_not_follow_is_taken_at_the_start_and_on_request():
    world = World(follows=False)
    world.run(2)
    assert world.zero.state == "holding"
    assert abs(world.run(20, press=-30.0).mean() + 30) < SIGMA
    world.zero.ask(world.time_s)
    world.run(1, press=-30.0)
    assert abs(world.run(1, press=-30.0).mean()) < SIGMA


def test_tiny_first_readings_without_noise_are_survived():
    zero = FollowingZero((2, 3))
    for k in range(120):
        zeroed = zero.update(k / 50, np.full((2, 3), 1e-260 if k < 2 else 5.0))
    assert np.isfinite(zeroed).all()
