"""What the zero that follows and the health of taxels are made of, beside plain sums or a course that is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.frame import FollowingZero, TaxelHealth, floor
from varishold.frame.common_drift import CommonDrift
from varishold.frame.following_baseline import FollowingBaseline
from varishold.frame.frame_clock import FrameClock
from varishold.frame.press_return import PressReturn
from varishold.frame.quiet_window import QuietWindow, standing_patch
from varishold.frame.readings import Readings, as_shape
from varishold.frame.running_noise import RunningNoise
from varishold.touch import find_contacts

SHAPE = (4, 5)
ALL = np.ones(SHAPE, np.bool_)

# The drift that all share.


@given(st.integers(0, 2**32 - 1))
def test_the_offset_is_that_of_weighted_least_squares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    drift = CommonDrift(ALL)
    drift.share = rng.uniform(0.2, 2, SHAPE)
    weights, zeroed = rng.uniform(0, 3, SHAPE) * (rng.random(SHAPE) < 0.7), rng.normal(0, 5, SHAPE)
    if weights.any():
        root = np.sqrt(weights).ravel()
        (expected,), *_ = np.linalg.lstsq((root * drift.share.ravel())[:, None], root * zeroed.ravel(), rcond=None)
        assert drift.offset(zeroed, weights) == pytest.approx(expected)
    assert drift.offset(zeroed, np.zeros(SHAPE)) == 0.0


def drifted(share: np.ndarray, seconds: float, *, pace: float = 0.5, free: np.ndarray = ALL) -> CommonDrift:
    """Return what is learned of taxels whose baselines go up by their shares, at ten steps a second."""
    drift = CommonDrift(ALL)
    for k in range(round(10 * seconds) + 1):
        if k:
            drift.level += pace / 10
        drift.learn(0.1 if k else 0.0, 100 + share * drift.level, free)
    return drift


@pytest.mark.parametrize("pace", [0.5, -0.5])
def test_shares_are_learned_from_what_the_taxels_do(pace: float) -> None:
    true = np.random.default_rng(0).uniform(0.5, 1.5, SHAPE)
    true /= true.mean()
    drift = drifted(true, 120, pace=pace)
    assert drift.share == pytest.approx(true, abs=0.02)
    assert drift.share.mean() == pytest.approx(1.0)
    # It fades in as slowly as it fades.
    assert drift.pace == pytest.approx(0.5 * (1 - math.exp(-120 / 150)), rel=0.02)


def test_nothing_is_learned_before_five_seconds_nor_where_nothing_drifts() -> None:
    true = np.linspace(0.5, 1.5, 20).reshape(SHAPE)
    for drift in (drifted(true, 4.9), drifted(true, 60, pace=0.0)):
        assert (drift.share == 1).all()
        assert drift.pace == 0
    assert not (drifted(true, 5.2).share == 1).all()


@pytest.mark.parametrize(("n", "learns"), [(2, False), (3, True), (8, True)])
def test_who_is_not_free_learns_nothing_and_few_tell_nothing(n: int, learns: bool) -> None:
    true = np.linspace(0.5, 1.5, 20).reshape(SHAPE)
    free = np.arange(20).reshape(SHAPE) < n
    drift = drifted(true, 100, free=free)
    assert (drift.share[~free] == 1).all()
    assert (not (drift.share[free] == 1).all()) == learns
    # The mean of those who learn stays, or it would run away from the others.
    assert drift.share[free].mean() == pytest.approx(1.0)
    if learns:
        assert drift.share[free] == pytest.approx(true[free] / true[free].mean(), abs=0.05)


def test_a_taxel_that_creeps_is_hardly_believed_and_none_runs_away() -> None:
    rng = np.random.default_rng(1)
    true = np.ones(SHAPE) + rng.normal(0, 0.02, SHAPE)
    true[0, 0] = 40.0
    once = drifted(true, 5.2)
    # Three times as far as the others scatter, no more.
    others = once.share.ravel()[1:]
    assert once.share[0, 0] - np.median(others) < 5 * 3 * others.std()
    long = drifted(true, 900)
    assert long.share.max() <= 4.0 * 1.05


def test_a_block_that_is_begun_anew_forgets_what_the_baseline_did() -> None:
    drift = CommonDrift(ALL)
    drift.learn(0.0, np.zeros(SHAPE), ALL)
    drift.level += 3.0
    drift.learn(4.0, np.linspace(0, 6, 20).reshape(SHAPE), ALL)
    drift.start_block(np.full(SHAPE, 9.0))
    drift.level += 1.0
    drift.learn(4.0, np.full(SHAPE, 10.0), ALL)
    assert (drift.share == 1).all()
    drift.learn(1.1, np.full(SHAPE, 10.0), ALL)
    assert drift.share == pytest.approx(np.ones(SHAPE))
    assert drift.pace > 0


# How taxels come back.


def pressed_for(
    held_s: float, tau_s: float, *, peak: float = 1000.0, after_s: float = 60.0, presses: int = 1
) -> PressReturn:
    """Follow presses of one taxel that leaves a tenth of its peak, which fades; its noise is 1."""
    back, values, at = PressReturn(SHAPE), np.zeros(SHAPE), 0.0
    for _ in range(presses):
        for k in range(round((2 + held_s + after_s) * 50)):
            since_s = k / 50 - 2
            values = np.zeros(SHAPE)
            touched = 0 <= since_s < held_s
            if touched:
                values[1, 2] = peak
            elif since_s >= held_s:
                values[1, 2] = 0.1 * peak * math.exp(-(since_s - held_s) / tau_s)
            back.add(at, 0.02, 50 + values, np.ones(SHAPE), touched=touched)
            at += 0.02
    return back


@pytest.mark.parametrize("tau_s", [0.3, 2.0, 8.0])
def test_what_stays_and_for_how_long_is_read_after_a_press(tau_s: float) -> None:
    back = pressed_for(3.0, tau_s)
    assert back.stays_share[1, 2] == pytest.approx(0.1 * math.exp(-0.5 / tau_s), abs=0.01)
    assert back.return_s[1, 2] == pytest.approx(tau_s * math.log(2), abs=0.08)
    known = np.isfinite(back.stays_share)
    assert known.sum() == np.isfinite(back.return_s).sum() == 1
    assert back.resting


def test_what_comes_back_at_once_counts_too() -> None:
    """A taxel that was slow once and is quick from then on is slow no more."""
    back, at = PressReturn(SHAPE), 0.0
    for tau_s in (20.0, *[0.1] * 9):
        for k in range(3500):
            since_s = k / 50 - 2
            values = np.zeros(SHAPE)
            touched = 0 <= since_s < 3
            values[1, 2] = 1000.0 * touched + (500 * math.exp(-(since_s - 3) / tau_s) if since_s >= 3 else 0.0)
            back.add(at, 0.02, 50 + values, np.ones(SHAPE), touched=touched)
            at += 0.02
    assert back.stays_share[1, 2] < 0.05


def test_what_never_comes_back_is_waited_for_half_a_minute() -> None:
    back = pressed_for(3.0, 1e9, after_s=29.0)
    assert not back.resting
    assert math.isnan(back.return_s[1, 2])
    back = pressed_for(3.0, 1e9, after_s=32.0)
    assert back.return_s[1, 2] == pytest.approx(30.0, abs=0.1)
    assert back.resting


@pytest.mark.parametrize(("held_s", "peak"), [(61.0, 1000.0), (3.0, 15.0)])
def test_of_long_and_of_light_presses_nothing_is_told(held_s: float, peak: float) -> None:
    back = pressed_for(held_s, 1.0, peak=peak)
    assert np.isnan(back.stays_share).all()
    assert np.isnan(back.return_s).all()
    assert back.resting


def test_later_presses_count_three_tenths_each() -> None:
    first, both = pressed_for(3.0, 2.0), PressReturn(SHAPE)
    at = 0.0
    for tau_s in (2.0, 8.0):
        for k in range(3000):
            since_s = k / 50 - 2
            values = np.zeros(SHAPE)
            touched = 0 <= since_s < 3
            values[1, 2] = 1000.0 * touched + (100 * math.exp(-(since_s - 3) / tau_s) if since_s >= 3 else 0.0)
            both.add(at, 0.02, 50 + values, np.ones(SHAPE), touched=touched)
            at += 0.02
    later = pressed_for(3.0, 8.0)
    for name in ("stays_share", "return_s"):
        before, after = getattr(first, name)[1, 2], getattr(later, name)[1, 2]
        assert getattr(both, name)[1, 2] == pytest.approx(before + 0.3 * (after - before), rel=0.03)


def test_a_rest_follows_in_three_seconds_while_nothing_presses() -> None:
    back, noise = PressReturn(SHAPE), np.ones(SHAPE)
    assert back.resting
    for k in range(1000):
        back.add(k / 50, 0.02, np.full(SHAPE, 20.0 * (k > 0)), noise, touched=False)
    # The rest has come up to 20: a press is told by what it shows above.
    for k in range(1000, 1100):
        back.add(k / 50, 0.02, np.full(SHAPE, 120.0), noise, touched=True)
        assert not back.resting
    for k in range(1100, 1200):
        back.add(k / 50, 0.02, np.full(SHAPE, 40.0), noise, touched=False)
    assert back.stays_share == pytest.approx(np.full(SHAPE, 0.2), abs=0.01)


# The noise.


def test_noise_is_first_the_mean_of_what_changes_and_then_follows() -> None:
    rng = np.random.default_rng(0)
    noise, frames = RunningNoise(ALL), rng.normal(0, [[1.0]] * 4, (17, *SHAPE))
    assert not noise.known
    for k, frame in enumerate(frames):
        assert noise.add(0.1, frame)
        assert noise.known == (k >= 16)
    expected = np.abs(np.diff(frames, axis=0)).mean(axis=0) / math.sqrt(2) * math.sqrt(math.pi / 2)
    assert noise.sigma == pytest.approx(expected)
    assert noise.median == pytest.approx(np.median(expected))
    assert noise.floored == pytest.approx(np.maximum(expected, np.median(expected)))
    for _ in range(3000):
        noise.add(0.1, rng.normal(0, 3.0, SHAPE))
    assert noise.sigma == pytest.approx(np.full(SHAPE, 3.0), rel=0.35)
    assert noise.median == pytest.approx(3.0, rel=0.1)


def test_frames_that_are_too_close_are_not_compared() -> None:
    noise = RunningNoise(ALL, least=0.5)
    assert noise.add(0.0, np.zeros(SHAPE))
    assert [noise.add(0.03, np.full(SHAPE, 9.0 * k)) for k in range(8)] == [k % 4 == 3 for k in range(8)]
    assert (noise.floored >= 0.5).all()
    noise.forget_frame()
    before = noise.sigma
    assert noise.add(0.2, np.full(SHAPE, 1e6))
    assert noise.sigma is before


def test_what_presses_teaches_no_noise_and_a_noise_that_is_another_is_measured_anew() -> None:
    rng, noise = np.random.default_rng(0), RunningNoise(ALL)
    noise.set(np.ones(SHAPE))
    free = np.ones(SHAPE, np.bool_)
    free[0] = False
    for _ in range(300):
        zeroed = rng.normal(0, 1, SHAPE)
        zeroed[0] += 500
        noise.add(0.1, zeroed, zeroed, free)
    assert (noise.sigma[0] == 1).all()
    assert noise.sigma[1:] == pytest.approx(np.ones((3, 5)), rel=0.4)
    # Ten times as strong: no press goes below zero all over.
    looks = 0
    while noise.known:
        zeroed = rng.normal(0, 10, SHAPE)
        noise.add(0.1, zeroed, zeroed, ALL)
        looks += 1
    assert looks <= 12
    for _ in range(40):
        zeroed = rng.normal(0, 10, SHAPE)
        noise.add(0.1, zeroed, zeroed, ALL)
    assert noise.median == pytest.approx(10, rel=0.3)
    # A tenth of it: measured anew as well.
    for _ in range(60):
        zeroed = rng.normal(0, 0.5, SHAPE)
        noise.add(0.1, zeroed, zeroed, ALL)
    assert noise.median == pytest.approx(0.5, rel=0.3)


@given(st.integers(0, 2**32 - 1), st.integers(2, 40))
@settings(max_examples=50)
def test_a_window_sums_up_its_frames(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    frames = rng.normal(0, 1, (n, *SHAPE)) + 20 * rng.random((n, 1, 1))
    window = QuietWindow(ALL, 0.49)
    full = [window.add(0.05, frame) for frame in frames]
    assert full == [k >= 10 for k in range(n)]
    assert window.n_frames == n
    assert window.mean == pytest.approx(frames.mean(axis=0))
    # What all do together is no noise about the mean.
    alone = frames - np.median(frames, axis=(1, 2), keepdims=True)
    changes = np.abs(np.diff(frames, axis=0)).sum(axis=0) / (n - 1) * math.sqrt(math.pi) / 2
    assert window.sigma == pytest.approx(np.maximum(changes, alone.std(axis=0, ddof=1)))


@pytest.mark.parametrize(("height", "taxels", "moves"), [(30, 4, True), (5, 4, False), (30, 1, False), (-30, 4, True)])
def test_a_patch_that_moves_is_seen_in_a_window(height: float, taxels: int, moves: bool) -> None:
    rng, window = np.random.default_rng(0), QuietWindow(np.ones((8, 8), np.bool_), 1.0)
    for k in range(40):
        frame = rng.normal(0, 1, (8, 8))
        if k >= 30:
            frame[2:4, 2:4].ravel()[:taxels] += height
            frame.ravel()[[18, 19, 26, 27][:taxels]] += height
        window.add(0.05, frame)
    moved = window.moved(0.0)
    assert bool(moved.any()) == moves
    if moves:
        assert sorted(np.flatnonzero(moved).tolist()) == [18, 19, 26, 27]


@pytest.mark.parametrize(("up", "down", "rises"), [(50, 0, True), (5, 0, False), (50, -50, False), (0, -50, False)])
def test_a_patch_that_rises_over_a_window_is_seen_at_once(up: float, down: float, rises: bool) -> None:
    rng, window = np.random.default_rng(0), QuietWindow(np.ones((8, 8), np.bool_), 1.0)
    told = []
    for _ in range(20):
        frame = rng.normal(0, 1, (8, 8)) + 100
        new = frame.copy()
        new[1:3, 1:3] += up
        new[5:7, 5:7] += down
        told.append(bool(window.rises(new + 7, 0.0).any()))
        window.add(0.02, frame)
    # Eight frames and a tenth of a second must have come before.
    assert told == [rises and k >= 8 for k in range(20)]


def test_a_patch_that_stands_off_the_plane_is_seen() -> None:
    rows, cols = np.mgrid[:8, :8]
    plane = 3.0 * rows - 2.0 * cols + np.random.default_rng(0).normal(0, 1, (8, 8))
    usable = np.ones((8, 8), np.bool_)
    assert not standing_patch(plane, usable, 1.0).any()
    press = plane.copy()
    press[2:4, 2:5] += 40
    assert np.argwhere(standing_patch(press, usable, 1.0)).tolist() == [[r, c] for r in (2, 3) for c in (2, 3, 4)]
    assert not standing_patch(press, usable, 40.0).any()
    few = np.zeros((8, 8), np.bool_)
    few[0, :3] = True
    assert not standing_patch(press, few, 1.0).any()


# The clock and the readings.


@given(st.lists(st.one_of(st.floats(0, 0.1), st.sampled_from([0.0, -1.0, 1.9, 2.1, 30.0, 1e5])), max_size=60))
@settings(max_examples=150)
def test_pauses_and_jumps_are_not_counted(steps: list[float]) -> None:
    clock, usual, now, at = FrameClock(), None, 0.0, 50.0
    assert clock.add(at) == 0.0
    for step in steps:
        before, at = at, at + step
        step = at - before
        paused = step < 0 or (usual is not None and step > max(2.0, 8 * usual))
        assert clock.add(at) == (0.0 if paused else step)
        assert clock.paused_s == (step if paused else None)
        if not paused:
            usual = step if usual is None else usual + 0.05 * (step - usual)
            now += step
        assert clock.now_s == pytest.approx(now)


@given(st.lists(st.lists(st.sampled_from([1.0, 7.0, math.nan, math.inf, -math.inf, 1e300]), min_size=4, max_size=4)))
def test_what_is_no_number_counts_as_the_last_that_was(frames: list[list[float]]) -> None:
    usable = np.array([[True, True], [True, False]])
    readings, last, wrong = Readings(usable), [0.0] * 4, 0
    for k, frame in enumerate(frames):
        given_frame = np.reshape(frame, (2, 2))
        values = readings.take(given_frame)
        is_wrong = [not abs(value) < 1e100 for value in frame]
        last = [before if bad else value for before, value, bad in zip(last, frame, is_wrong, strict=True)]
        assert values.ravel().tolist() == last
        wrong += sum(is_wrong[:3])
        assert (readings.n_frames, readings.n_not_finite) == (k + 1, wrong)
        assert (readings.wrong is None) == (not any(is_wrong))
        if readings.wrong is not None:
            assert readings.wrong.ravel().tolist() == is_wrong


def test_the_least_noise_is_roundings_or_a_millionth() -> None:
    whole, real = Readings(ALL), Readings(ALL)
    whole.take(np.full(SHAPE, 300, np.uint16))
    real.take(np.full(SHAPE, -300.0))
    assert whole.least_noise == pytest.approx(1 / math.sqrt(12), rel=0.05)
    assert real.least_noise == pytest.approx(3e-4)
    real.take(np.full(SHAPE, 1e9))
    assert real.least_noise == pytest.approx(3e-4)


@pytest.mark.parametrize("shape", [(0, 3), (3, -1), (3,), (1, 2, 3), (2.0, 3), "ab"])
def test_what_is_no_shape_is_refused(shape: object) -> None:
    with pytest.raises(InputError, match=r"two whole numbers from 1"):
        as_shape(shape)  # type: ignore[arg-type]
    assert as_shape((np.int64(2), 1)) == (2, 1)  # type: ignore[arg-type]


# The baseline that follows.


def steps(off: float | np.ndarray, seconds: float, *, noise: float = 1.0, step_s: float = 0.02) -> np.ndarray:
    """Return how much of what each taxel is off has been followed after so long."""
    baseline = FollowingBaseline(np.ones((8, 8), np.bool_))
    baseline.set_noise(np.full((8, 8), noise))
    baseline.noise.add = lambda *_: False  # type: ignore[method-assign, assignment]
    rest = np.full((8, 8), 100.0)
    baseline.set(rest)
    for k in range(1, round(seconds / step_s) + 1):
        frame = rest + off
        baseline.follow(k * step_s, step_s, frame, frame - baseline.values)
    return baseline.values - rest


@pytest.mark.parametrize("seconds", [0.1, 0.2, 0.6])
def test_what_all_are_off_is_followed_in_a_fifth_of_a_second(seconds: float) -> None:
    assert steps(1.5, seconds) == pytest.approx(np.full((8, 8), 1.5 * (1 - math.exp(-seconds / 0.2))), rel=0.03)


def test_what_one_taxel_is_off_is_followed_in_two_seconds_and_faster_where_it_sank() -> None:
    one = np.zeros((8, 8))
    one[2, 2], one[5, 5] = 2.0, -2.0
    followed = steps(one, 1.0)
    assert followed[2, 2] == pytest.approx(2 * (1 - math.exp(-0.5)), rel=0.05)
    assert followed[5, 5] == pytest.approx(-2 * (1 - math.exp(-0.5)), rel=0.05)
    one[2, 2], one[5, 5] = 0.0, -50.0
    followed = steps(one, 0.5)
    # What has sunk far below the noise has nobody pressed.
    assert followed[5, 5] < -50 * 0.85
    assert abs(followed[2, 2]) < 1.0


def test_an_impulse_hardly_moves_a_baseline() -> None:
    one = np.zeros((8, 8))
    one[2, 2] = -500.0
    assert abs(steps(one, 0.02)[2, 2]) < 0.5


@pytest.mark.parametrize(("height", "taxels", "presses"), [(6, 4, False), (9, 4, True), (9, 2, False), (40, 1, True)])
def test_a_press_begins_where_it_stands_clear(height: float, taxels: int, presses: bool) -> None:
    """Three neighbours above eight standard deviations, or one taxel four times as high."""
    rng, zero = np.random.default_rng(0), FollowingZero((10, 10))
    for k in range(300):
        frame = 100 + rng.normal(0, 1, (10, 10)) * (k < 200)
        if k >= 200:
            frame.ravel()[[44, 45, 54, 55][:taxels]] += height * float(np.median(zero.noise))
        zeroed = zero.update(k / 100, frame)
        if k == 210:
            assert bool(zero.pressed.any()) == presses
            assert zeroed[4, 4] > 0.5 * height
            # Two taxels around it are held as well.
            assert zero.free[4, 4] != presses
            assert zero.free[2, 4] != presses
            assert zero.free[0, 9]


def test_the_health_looks_ten_times_a_second_however_many_frames_come() -> None:
    """A taxel that is saturated in so many frames of so many is told by that share at any rate."""
    told = []
    for rate_hz in (20.0, 200.0, 1000.0):
        rng, health = np.random.default_rng(0), TaxelHealth(SHAPE, full_scale=1000.0)
        for k in range(round(20 * rate_hz)):
            frame = 300 + rng.normal(0, 2, SHAPE)
            if (k / rate_hz) % 1.0 >= 0.7:
                frame[1, 1] = 1000.0
            health.update(k / rate_hz, frame)
        report = health.report()
        assert [(bad.row, bad.col) for bad in report.bad if bad.word == "saturated"] == [(1, 1)]
        told.append(report.saturated_share * 20)
        assert report.n_frames == round(20 * rate_hz)
        assert report.watched_s == pytest.approx(20, abs=0.1)
    assert told == pytest.approx([0.3] * 3, abs=0.06)


def test_the_drift_of_a_minute_is_told_once_a_minute_was_seen() -> None:
    """Ten seconds go by before it is measured."""
    rng, health, told = np.random.default_rng(0), TaxelHealth(SHAPE), []
    for k in range(30 * 80):
        health.update(k / 30, 300 + 5 * k / 30 / 60 + rng.normal(0, 0.1, SHAPE))
        told.append(health.report().drift_per_min if k % 30 == 0 else None)
    first = next(k for k in range(0, len(told), 30) if told[k] is not None)
    assert 65 <= first / 30 <= 76
    assert told[first] == pytest.approx(5, abs=0.3)


def test_what_is_explained_of_the_floor_is_what_is_computed() -> None:
    rows, cols = np.mgrid[:16, :16]
    heap = 100 * np.exp(-((rows - 7) ** 2 + (cols - 8) ** 2) / 12)
    (contact,) = find_contacts(heap)
    assert contact.floor == pytest.approx(floor.FLOOR_OF_PEAK * contact.peak)
    (contact,) = find_contacts(heap, sigma=1e-3)
    assert contact.floor == pytest.approx(floor.LEAST_OF_PEAK * contact.peak)
    (contact,) = find_contacts(heap, sigma=1.5)
    assert contact.floor == pytest.approx(floor.FLOOR_SIGMAS * 1.5)
    # Unevenness lifts it so far and no farther.
    uneven = heap + np.random.default_rng(0).normal(0, 6, (16, 16))
    highest = max(find_contacts(uneven), key=lambda found: found.peak)
    assert highest.floor == pytest.approx(floor.MOST_OF_PEAK * highest.peak)
