"""The one noise estimate: laws first, then known noise, then what a sensor hides."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import InputError
from varishold.frame import frame_noise, recording_noise
from varishold.solids import SOLIDS, draw_contact, ideal_frame

# The first call compiles.
frames = hnp.arrays(
    np.float64,
    st.tuples(st.integers(1, 20), st.integers(1, 20)),
    elements=st.floats(-1e3, 1e3, width=32),
)


def noisy_contact(seed: int, n: int = 16, noise: float = 0.02) -> np.ndarray:
    rng = np.random.default_rng(seed)
    drawn = draw_contact(
        rng, list(SOLIDS)[seed % len(SOLIDS)], field_m=(n * 1e-3,) * 2, size_m=(n * 0.4e-3, n * 0.75e-3)
    )
    frame = ideal_frame(drawn.solid, (n, n), 1e-3, depth_m=drawn.depth_m, pose=drawn.pose)
    return frame / frame.max() + rng.normal(0, noise, (n, n))


@given(frames, st.integers(-8, 8))
def test_noise_scales_with_the_frame(frame: np.ndarray, power: int) -> None:
    scale = 2.0**power
    assert frame_noise(frame * scale) == pytest.approx(frame_noise(frame) * scale, rel=1e-12)


@given(frames)
def test_noise_is_the_same_for_a_turned_and_a_mirrored_frame(frame: np.ndarray) -> None:
    sigma = frame_noise(frame)
    assert np.isfinite(sigma)
    assert sigma >= 0
    assert frame_noise(np.rot90(frame)) == pytest.approx(sigma, rel=2e-3, abs=1e-12)
    assert frame_noise(frame[::-1]) == pytest.approx(sigma, rel=2e-3, abs=1e-12)


@given(hnp.array_shapes(min_dims=2, max_dims=2, max_side=30), st.floats(-1e6, 1e6))
def test_a_constant_frame_has_no_noise(shape: tuple[int, int], value: float) -> None:
    assert frame_noise(np.full(shape, value)) == 0


@given(frames, st.data())
def test_unusable_taxels_do_not_matter(frame: np.ndarray, data: st.DataObject) -> None:
    usable = data.draw(hnp.arrays(np.bool_, frame.shape))
    other = np.where(usable, frame, 1e9)
    assert frame_noise(frame, valid=usable) == frame_noise(other, field=usable)
    assert frame_noise(np.where(usable, frame, np.nan)) == frame_noise(frame, valid=usable)


@pytest.mark.parametrize("noise", [0.02, 0.005])
def test_known_noise_under_random_contacts_of_every_solid(noise: float) -> None:
    ratio = [frame_noise(noisy_contact(seed, noise=noise)) / noise for seed in range(280)]
    assert 0.95 < np.median(ratio) < 1.12
    assert np.quantile(ratio, 0.05) > 0.8
    assert np.quantile(ratio, 0.95) < 1.5
    assert max(ratio) < 2.2


@pytest.mark.parametrize("shape", [(1, 200), (200, 1), (2, 100), (13, 6), (41, 72)])
def test_known_noise_on_pads_of_other_shapes(shape: tuple[int, int]) -> None:
    ratio = [frame_noise(np.random.default_rng(s).normal(100, 3, shape)) / 3 for s in range(40)]
    assert np.median(ratio) == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("shape", [(1, 300), (16, 16), (40, 40)])
def test_noise_clipped_at_zero_is_restored(shape: tuple[int, int]) -> None:
    ratio = [frame_noise(np.maximum(np.random.default_rng(s).normal(0, 3, shape), 0)) / 3 for s in range(40)]
    assert np.median(ratio) == pytest.approx(1, abs=0.1)


def test_a_sensor_that_hides_its_noise_is_judged_inside_the_contact_or_not_at_all() -> None:
    frame = noisy_contact(5, n=32, noise=0.01)
    shown = np.where(frame > 0.1, frame, 0)
    assert frame_noise(shown) == pytest.approx(0.01, rel=0.3)
    small = np.zeros((13, 6))
    small[4:9, 1:5] = np.random.default_rng(0).uniform(100, 1000, (5, 4))
    assert frame_noise(small) == 0


def test_integers_have_at_least_their_rounding_error() -> None:
    frame = np.zeros((16, 16), np.uint16)
    frame[4:9, 4:9] = 300
    assert frame_noise(frame) == pytest.approx(12**-0.5)
    assert frame_noise(frame.astype(float)) == 0
    rounded = np.rint(np.random.default_rng(0).normal(50, 4, (32, 32))).astype(np.int16)
    assert frame_noise(rounded) == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("dtype", [np.uint8, np.float64])
def test_no_usable_taxel_no_noise(dtype: type) -> None:
    assert frame_noise(np.ones((6, 6), dtype), valid=np.zeros((6, 6), bool)) == 0
    with pytest.raises(InputError, match=r"got .* of shape \(0, 6\)"):
        frame_noise(np.ones((0, 6), dtype))


def test_a_pad_too_small_to_tell_noise_from_form_says_nothing() -> None:
    assert frame_noise(np.random.default_rng(0).normal(size=(4, 4))) == 0


def test_recordings_with_unloaded_frames_use_time() -> None:
    rng = np.random.default_rng(0)
    # Noise that is the same along each row hides from differences in space.
    quiet = np.repeat(rng.normal(0, 2, (60, 16, 1)), 16, axis=2)
    assert frame_noise(quiet[0]) == pytest.approx(0, abs=1e-12)
    assert recording_noise(quiet) == pytest.approx(2, rel=0.25)
    pressed = rng.normal(0, 2, (200, 16, 16))
    pressed[80:, 3:12, 2:14] += 100
    assert recording_noise(pressed) == pytest.approx(2, rel=0.05)


def test_recordings_without_unloaded_frames_use_single_frames() -> None:
    rng = np.random.default_rng(0)
    always = np.stack([noisy_contact(seed) for seed in range(28)])
    assert recording_noise(always) == pytest.approx(0.02, rel=0.2)
    hidden = np.zeros((50, 32, 32))
    hidden[::2, 4:28, 4:28] = 50 + rng.normal(0, 1, (25, 24, 24))
    assert recording_noise(hidden) == pytest.approx(1, rel=0.1)


@pytest.mark.parametrize("n_frames", [0, 1, 2, 5, 300])
def test_constant_and_short_recordings(n_frames: int) -> None:
    assert recording_noise(np.ones((n_frames, 8, 8), np.uint8)) == 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: frame_noise(np.zeros(5)), r"\(rows, cols\), got float64 of shape \(5,\)"),
        (lambda: frame_noise(np.zeros((5, 5), complex)), "got complex128 of shape"),
        (
            lambda: frame_noise(np.zeros((5, 5)), valid=np.ones((4, 5), bool)),
            r"valid must have the shape of a frame, \(5, 5\), got \(4, 5\)",
        ),
        (lambda: recording_noise(np.zeros((5, 5))), r"\(n_frames, rows, cols\), got float64 of shape"),
        (
            lambda: recording_noise(np.zeros((3, 5, 5)), np.ones((4, 5), bool)),
            r"field must have the shape of a frame, \(5, 5\), got \(4, 5\)",
        ),
    ],
)
def test_what_is_no_frame(call: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()  # type: ignore[operator]
