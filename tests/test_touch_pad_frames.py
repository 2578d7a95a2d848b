"""What a whole recording tells of each of its frames: the rest, the noise in time, broken and saturated taxels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.frame import frame_noise, timed_noise
from varishold.frame.floor import noise_reach
from varishold.kernel import bind
from varishold.recording import Pad, Recording
from varishold.touch import find_contacts, recognize, recognize_recording
from varishold.touch.pad_frames import PadFrames, pad_frames
from varishold.touch.scale import as_learned

default_floor = bind("vh_default_floor", "dd", "d")
timed_floor = bind("vh_timed_floor", "dd", "d")

Y, X = np.mgrid[-8:8, -8:8] + 0.5
CONE = np.maximum(6.0 - np.hypot(X, Y), 0.0)
FORCE = np.r_[np.zeros(12), np.linspace(1, 10, 6), np.full(12, 10.0), np.zeros(6)]


def pressed(rest: np.ndarray | float = 0.0, noise: float = 0.3, seed: int = 0, force: np.ndarray = FORCE) -> np.ndarray:
    frames = rest + force[:, None, None] * CONE
    return frames + np.random.default_rng(seed).normal(0, noise, frames.shape)


def seen(frames: np.ndarray, **options: np.ndarray) -> PadFrames:
    return pad_frames(Recording({"pad": Pad(frames, **options)}))["pad"]


def test_a_recording_that_starts_unloaded_is_zeroed_taxel_by_taxel() -> None:
    rest = np.random.default_rng(1).uniform(-2, 6, CONE.shape)
    frames = seen(pressed(rest))
    assert frames.rest is not None
    assert np.abs(frames.rest - rest).max() < 0.5
    assert frames.notes == ("zeroed on frames 0 to 11, before the first touch",)
    np.testing.assert_allclose(frames.frame(20), 10 * CONE, atol=2.0)


@pytest.mark.parametrize("rest", [50.0, 0.3 * X, 20 + 0.5 * Y])
def test_an_offset_and_a_slope_are_rests(rest: np.ndarray | float) -> None:
    assert seen(pressed(rest)).rest is not None


@pytest.mark.parametrize("pause", [4, 5, 7])
def test_a_rest_is_read_from_all_pauses_where_each_is_short(pause: int) -> None:
    rest = np.random.default_rng(1).uniform(10, 30, CONE.shape)
    held = np.r_[np.linspace(1, 10, 6), np.full(12, 10.0), np.linspace(10, 1, 6)]
    frames = seen(pressed(rest, force=np.r_[held[10:], np.tile(np.r_[np.zeros(pause), held], 5)]))
    assert frames.rest is not None
    assert np.abs(frames.rest - rest).max() < 1.0
    assert frames.notes[0].startswith("zeroed on ")
    assert frames.notes[0].endswith(" frames between touches")


@pytest.mark.parametrize("noise", [0.1, 0.2, 0.25, 0.5])
def test_quiet_counts_on_an_even_offset_are_zeroed_and_nothing_lies_there(noise: float) -> None:
    force = np.r_[np.zeros(10), np.tile(np.r_[np.linspace(1, 25, 6), np.full(8, 25.0), np.zeros(8)], 4)]
    counts = np.rint(pressed(12.0, noise=noise, force=force)).clip(0, 255).astype(np.uint8)
    frames = seen(counts)
    assert frames.lies is None
    assert frames.rest is not None
    assert np.abs(frames.rest - 12.0).max() < 1.5


@pytest.mark.parametrize("seed", range(3))
def test_whole_counts_on_an_offset_are_zeroed_and_idle_frames_hold_no_contact(seed: int) -> None:
    # Medians of counts are uneven by half a count: that is no thing that lies on the pad.
    force = np.r_[np.zeros(200), np.full(10, 12.0), np.zeros(30)]
    counts = np.rint(pressed(20.0, noise=2.0, seed=seed, force=force)).clip(0, 255).astype(np.uint8)
    recording = Recording({"pad": Pad(counts)})
    assert pad_frames(recording)["pad"].notes == ("zeroed on frames 0 to 199, before the first touch",)
    frames = [answer.frame for answer in recognize_recording(recording, frames="all")]
    assert frames == list(range(200, 210))


BLOCK = 25.0 * ((X < -4) & (Y < -4))
TWICE = np.r_[np.zeros(16), FORCE[12:], np.zeros(10), FORCE[12:], np.zeros(6)]


@pytest.mark.parametrize("offset", [0.0, 40.0])
def test_what_lies_there_all_the_time_is_no_part_of_a_press(offset: float) -> None:
    recording = Recording({"pad": Pad(pressed(BLOCK + offset, force=TWICE))})
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == ["cone", "cone"]
    assert all("what lies there from the first frame to the last" in answer.frame_notes[-1] for answer in answers)
    # One frame shows what is there.
    assert len(list(recognize_recording(recording, frames="peak"))) == 2


BENT = 0.6 * ((X - X.mean()) ** 2) - 20.0
ROWS = np.broadcast_to(np.random.default_rng(4).normal(0.0, 4.0, (CONE.shape[0], 1)), CONE.shape)


@pytest.mark.parametrize(
    "rest", [BENT, -BENT, BENT + 60.0, ROWS + 30.0], ids=["bent", "hollow", "on an offset", "rows"]
)
def test_a_rest_with_a_form_of_its_own_is_no_part_of_presses(rest: np.ndarray) -> None:
    # Some presses cover all of what rests high, others leave most of it: what is the same through most presses rests.
    recording = Recording({"pad": Pad(pressed(rest, force=np.r_[TWICE, TWICE]))})
    answers = list(recognize_recording(recording, frames="press"))
    assert [answer.surface.name for answer in answers] == ["cone"] * 4
    assert len({answer.frame for answer in answers}) == 4


def test_a_press_over_everything_hides_no_rest_from_others() -> None:
    frames = pressed(BLOCK, force=np.r_[TWICE, TWICE])
    frames[20:25] += 90.0
    recording = Recording({"pad": Pad(frames)})
    assert pad_frames(recording)["pad"].lies is not None


def test_what_is_held_and_squeezed_or_put_down_and_left_is_felt_as_a_whole() -> None:
    held = Recording({"pad": Pad(pressed(2.0 * CONE, force=TWICE))})
    assert pad_frames(held)["pad"].lies is None
    peaks = [answer.surface.contact.peak for answer in recognize_recording(held, frames="press")]
    assert max(peaks) > 11.5 * CONE.max()
    put = pressed(force=TWICE)
    put[30:] += BLOCK
    taken = pressed(BLOCK, force=TWICE)
    taken[30:] -= BLOCK
    assert all(seen(frames).lies is None for frames in (put, taken, pressed(BLOCK)[:20]))


def test_what_is_zero_already_or_touched_from_the_start_is_left_alone() -> None:
    assert seen(pressed()).rest is None
    assert seen(pressed(force=FORCE[14:])).rest is None
    lying = seen(pressed(0.5 * CONE))
    assert lying.rest is None
    assert lying.notes == ()


def test_noise_is_told_from_unevenness_by_time_alone() -> None:
    uneven = np.random.default_rng(2).normal(0, 4, CONE.shape)
    frames = pressed(uneven)
    assert frame_noise(frames[0]) == pytest.approx(4, rel=0.3)
    assert timed_noise(frames) == pytest.approx(0.3, rel=0.2)
    assert seen(frames).sigma == timed_noise(frames)
    assert timed_noise(frames[:5]) is None
    assert timed_noise(np.repeat(frames[:1], 20, axis=0)) is None


def test_a_hold_tells_the_noise_where_nothing_is_ever_unloaded() -> None:
    held = pressed(force=np.r_[np.linspace(5, 10, 5), np.full(20, 10.0)], noise=0.5)
    assert timed_noise(held) == pytest.approx(0.5, rel=0.25)


def test_dead_and_stuck_taxels_are_not_believed() -> None:
    frames = pressed(3.0)
    frames[:, 7, 8], frames[:, 3, 3] = 0.0, 9.5
    found = seen(frames)
    assert found.valid is not None
    assert np.argwhere(~found.valid).tolist() == [[3, 3], [7, 8]]
    assert found.notes[0] == "each of 2 taxels ((3, 3), (7, 8)) is dead or stuck: filled from its neighbours"
    assert seen(pressed(3.0)).valid is None


def test_taxels_that_rest_at_a_count_are_not_stuck_where_many_do() -> None:
    quiet = np.round(pressed(5.0, noise=0.0)).astype(np.uint8)
    assert seen(quiet).valid is None


def test_saturated_taxels_are_known_by_the_full_scale_that_the_recording_reaches() -> None:
    frames = np.clip(np.round(6 * pressed()), 0, 255).astype(np.uint8)
    found = seen(frames)
    assert found.full_scale == 255
    full = found.saturated(20)
    assert full is not None
    np.testing.assert_array_equal(full, frames[20] == 255)
    assert found.saturated(0) is None


def test_a_single_frame_is_told_to_be_one() -> None:
    found = seen(pressed()[20:21])
    assert found.notes == ("a single frame: noise and the taxels' unevenness cannot be told apart",)
    assert found.sigma is None


def test_the_floor_is_as_low_as_what_is_known_of_the_noise_allows() -> None:
    assert default_floor(0.001, 1.0) == 0.05
    assert default_floor(0.02, 1.0) == 0.08
    assert default_floor(0.5, 1.0) == 0.1
    assert timed_floor(0.001, 1.0) == 0.02
    assert timed_floor(0.02, 1.0) == 0.08
    assert timed_floor(0.5, 1.0) == 2.0
    frame = 10 * CONE
    assert find_contacts(frame)[0].floor == pytest.approx(0.05 * frame.max())
    assert find_contacts(frame, sigma=0.1)[0].floor == pytest.approx(0.02 * frame.max())
    assert find_contacts(frame, sigma=1.0)[0].floor == pytest.approx(4.0)


@pytest.mark.parametrize("shape", [(16, 16), (32, 32), (120, 160)])
def test_noise_alone_is_no_contact(shape: tuple[int, int]) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (60, *shape))
    assert sum(len(find_contacts(frame)) > 0 for frame in frames) <= 4
    assert sum(frame.max() > noise_reach(1.0, frame.size) for frame in frames) <= 3


@pytest.mark.parametrize("side", [16, 32, 128])
def test_noise_does_not_break_a_bump_into_contacts(side: int) -> None:
    y, x = np.mgrid[0:side, 0:side] - side / 2 + 0.5
    r = np.hypot(x, y) / (0.4 * side)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        for form in (np.maximum(1 - r, 0), np.maximum(1 - r**2, 0), (r < 0.9) * 1.0):
            assert len(find_contacts(form + rng.normal(0, 0.01, form.shape))) == 1


def test_two_faint_touches_beside_a_strong_one_stay_contacts() -> None:
    y, x = np.mgrid[0:48, 0:48]
    frame = np.maximum(1 - np.hypot(x - 24, y - 24) / 8, 0)
    for cy, cx in ((8, 8), (40, 38)):
        frame = np.maximum(frame, 0.2 * np.maximum(1 - np.hypot(x - cx, y - cy) / 5, 0))
    noisy = frame + np.random.default_rng(0).normal(0, 0.01, frame.shape)
    assert len(find_contacts(noisy)) == 3


def test_a_large_contact_is_looked_at_on_its_own_scale() -> None:
    y, x = np.mgrid[0:240, 0:320]
    frame = np.maximum(1 - np.hypot(x - 150, y - 120) / 100, 0)
    frame += np.random.default_rng(0).normal(0, 0.01, frame.shape)
    contact = find_contacts(frame, pitch=1e-4)[0]
    coarse = as_learned(contact)
    assert max(coarse.mask.shape) <= 33
    assert coarse.pitch == pytest.approx((7e-4, 7e-4))
    assert coarse.profile.area[-1] == pytest.approx(contact.profile.area[-1], rel=0.05)
    surface = recognize(contact)
    assert surface.name == "cone"
    assert surface.contact is contact
    small = find_contacts(CONE)[0]
    assert as_learned(small) is small


def test_gaps_of_the_field_stay_gaps_on_the_coarse_scale() -> None:
    frame = np.ones((100, 100))
    frame[:20, :20] = np.nan
    coarse = as_learned(find_contacts(frame, floor=0.5)[0])
    assert not coarse.field[:5, :5].any()
    assert coarse.field[5:, 5:].all()
    assert coarse.profile.area[-1] == pytest.approx(25**2 - 5**2)


def test_an_answer_says_what_was_done_to_its_frame() -> None:
    frames = 20 + pressed()
    frames[:, 7, 8] = 9.5
    (answer,) = recognize_recording(Recording({"pad": Pad(frames)}))
    told = answer.to_dict()["frame_notes"]
    assert told[:2] == [
        "taxel (7, 8) is dead or stuck: filled from its neighbours",
        "zeroed on frames 0 to 11, before the first touch",
    ]
    assert answer.surface.contact.state.repaired == 1
    assert answer.surface.contact.peak == pytest.approx(10 * CONE.max(), rel=0.1)
    (alone,) = recognize_recording(Recording({"pad": Pad(frames[20:21])}))
    assert "a single frame" in alone.to_dict()["frame_notes"][0]


def test_saturated_taxels_are_counted_in_the_contact_and_told() -> None:
    frames = np.clip(np.round(6 * pressed()), 0, 255).astype(np.uint8)
    (answer,) = recognize_recording(Recording({"pad": Pad(frames)}))
    n = int(np.count_nonzero(frames[answer.frame] == 255))
    assert answer.surface.contact.state.saturated == n > 1
    assert f"{n} taxels saturated: at least what is shown" in answer.frame_notes


def test_a_depth_map_with_an_offset_is_no_plane() -> None:
    y, x = np.mgrid[0:120, 0:160]
    ball = np.maximum(1 - ((x - 80) ** 2 + (y - 60) ** 2) / 40**2, 0) + 2.0
    ball += np.random.default_rng(0).normal(0, 0.01, ball.shape)
    (answer,) = recognize_recording(Recording({"pad": Pad(ball[None])}))
    assert answer.surface.name == "sphere"
    assert "a sloping, curved or offset rest taken off" in answer.frame_notes


def test_a_fainter_floor_does_not_change_what_a_contact_is() -> None:
    frame = 10 * CONE + np.random.default_rng(0).normal(0, 0.2, CONE.shape)
    usual, fine = find_contacts(frame)[0], find_contacts(frame, sigma=0.2)[0]
    assert fine.floor < usual.floor
    assert as_learned(usual) is usual
    np.testing.assert_allclose(recognize(fine).kind_probability, recognize(usual).kind_probability, atol=1e-6)


@given(
    st.sampled_from([(4, 6), (5, 5), (8, 8), (12, 12)]),
    st.sampled_from([(1013.0, 3.0, 80.0, 0.25), (30_000.0, 600.0, 4500.0, 12.0), (500.0, 8.0, 300.0, 2.0)]),
    st.integers(0, 10_000),
)
def test_taxels_that_rest_far_from_zero_are_zeroed_on_quiet_frames(
    shape: tuple[int, int], sensor: tuple[float, float, float, float], seed: int
) -> None:
    """Neither is the unevenness of a rest noise, nor a level rest of a small pad a press."""
    offset, uneven, height, noise = sensor
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: shape[0], : shape[1]]
    ball = np.maximum(1 - ((x - shape[1] / 2) ** 2 + (y - shape[0] / 2) ** 2) / (shape[0] / 3) ** 2, 0)
    force = np.r_[np.zeros(8), np.sin(np.linspace(0.3, 2.8, 12))][:, None, None]
    rest = offset + np.clip(rng.normal(0, uneven, shape), -2 * uneven, 2 * uneven)
    frames = seen(rest + height * force * ball + rng.normal(0, noise, (20, *shape)))
    assert frames.rest is not None
    np.testing.assert_allclose(frames.rest, rest, atol=4 * noise)


@given(st.integers(0, 10_000), st.floats(0.1, 0.9))
def test_taxels_that_hardly_flicker_are_not_dead_in_a_short_recording(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    counts = np.clip(np.rint(pressed(force=FORCE[:18], noise=0.0) + rng.normal(0, noise, (18, 16, 16))), 0, 255)
    assert seen(counts.astype(np.uint8)).valid is None


@pytest.mark.parametrize("seed", range(3))
def test_dead_taxels_among_flickering_ones_are_found_in_a_long_recording(seed: int) -> None:
    rng = np.random.default_rng(seed)
    counts = np.clip(np.rint(rng.normal(0, 0.7, (300, 16, 16))), 0, 255).astype(np.uint8)
    counts[:, [3, 9], [4, 12]] = 0
    valid = seen(counts).valid
    assert valid is not None
    assert np.argwhere(~valid).tolist() == [[3, 4], [9, 12]]


@pytest.mark.parametrize("begins", [13, 18, 25])
def test_a_recording_that_begins_loaded_is_zeroed_where_nothing_presses(begins: int) -> None:
    rest = np.random.default_rng(1).uniform(-2, 6, CONE.shape)
    twice = np.r_[FORCE, np.zeros(20), FORCE]
    once = seen(pressed(rest, force=np.r_[FORCE, np.zeros(20)])[begins:])
    between = seen(pressed(rest, force=twice)[begins:])
    for frames in (once, between):
        assert frames.rest is not None
        assert np.abs(frames.rest - rest).max() < 0.6
    assert once.notes[0].endswith("after the last touch")
    assert between.notes[0].endswith("between touches")


def test_what_stays_pressed_from_the_first_frame_to_the_last_is_no_rest() -> None:
    force = np.r_[np.full(10, 3.0), np.full(12, 10.0), np.full(12, 3.0), np.full(12, 10.0)]
    assert seen(pressed(5.0, force=force)[12:]).rest is None


@pytest.mark.parametrize("kind", [np.int64, np.float64])
def test_where_zeros_hide_the_noise_rounding_does_not_lift_the_floor(kind: type) -> None:
    y, x = np.mgrid[-8:9, -8:9]
    ball = np.maximum(1.0 - (x * x + y * y) / 36.0, 0.0)
    course = np.concatenate([np.zeros(12), *[[0.3, 0.6, 1.0, 1.0, 0.7, 0.0, 0.0, 0.0, 0.0]] * 6])
    noise = np.random.default_rng(0).normal(0.0, 0.02, (len(course), 17, 17))
    counts = np.maximum(np.rint(10.0 * (course[:, None, None] * ball + noise)), 0.0).astype(kind)
    recording = Recording({"pad": Pad(counts)})
    assert pad_frames(recording)["pad"].sigma is None
    assert {answer.surface.name for answer in recognize_recording(recording, frames="press")} == {"sphere"}
