"""One validator for each kind of input: the same words and limits wherever a frame comes in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.frame import as_pitch, fill_invalid, frame_noise, recording_noise
from varishold.frame.checks import as_floats, as_mask, as_numbers, as_valid
from varishold.levelset import outlines
from varishold.recording import Pad
from varishold.skin import Skin, press, reconstruct
from varishold.solids import Sphere
from varishold.touch import find_contacts

SKIN = Skin("layer", thickness_m=6e-3, poisson=0.45, sensing_depth_m=1e-3)
FRAME = np.add.outer(np.arange(6.0), np.arange(7.0))

TAKES_A_PITCH: dict[str, Callable[[Any], object]] = {
    "find_contacts": lambda pitch: find_contacts(FRAME, pitch=pitch),
    "outlines": lambda pitch: outlines(FRAME, 1.0, pitch_m=pitch),
    "Pad": lambda pitch: Pad(FRAME[None], pitch_m=pitch),
    "press": lambda pitch: press(Sphere(0.01), SKIN, depth=1e-3, shape=(8, 8), pitch_m=pitch),
    "reconstruct": lambda pitch: reconstruct(FRAME, SKIN, pitch=pitch),
}
TAKES_MASKS: dict[str, Callable[..., object]] = {
    "find_contacts": lambda **masks: find_contacts(FRAME, **masks),
    "Pad": lambda **masks: Pad(FRAME[None], **masks),
    "frame_noise": lambda **masks: frame_noise(FRAME, **masks),
    "recording_noise": lambda **masks: recording_noise(FRAME[None], **masks),
    "fill_invalid": lambda **masks: fill_invalid(FRAME, **{"valid": FRAME > 0, **masks}),
}


@pytest.mark.parametrize(
    "pitch",
    [
        0.0,
        -1e-3,
        1e-10,
        2e3,
        np.nan,
        np.inf,
        "wide",
        "1e-3",
        True,
        (1e-3, True),
        ["1e-3", True],
        1e-3j,
        (1e-3, 2e-3, 3e-3),
        [[1e-3]],
    ],
)
@pytest.mark.parametrize("name", TAKES_A_PITCH)
def test_every_pitch_has_the_same_limits(name: str, pitch: object) -> None:
    with pytest.raises(InputError, match=r"^pitch(_m)? must be one spacing in metres or .* from 1e-09 to 1000, got"):
        TAKES_A_PITCH[name](pitch)


def test_a_pitch_is_one_spacing_or_two() -> None:
    assert as_pitch(1e-3) == as_pitch([1e-3]) == as_pitch((1e-3, 1e-3)) == (1e-3, 1e-3)
    assert as_pitch(np.array([1e-9, 1e3])) == (1e-9, 1e3)


@pytest.mark.parametrize("mask", [np.ones((6, 7)), np.ones((6, 7), np.uint8), [[1] * 7] * 6, "all"])
@pytest.mark.parametrize("which", ["field", "valid"])
@pytest.mark.parametrize("name", TAKES_MASKS)
def test_a_mask_is_bool_or_refused(name: str, which: str, mask: object) -> None:
    with pytest.raises(InputError, match=f"^{which} must be True or False for each taxel, got .*; compare it first"):
        TAKES_MASKS[name](**{which: mask})


@pytest.mark.parametrize("which", ["field", "valid"])
@pytest.mark.parametrize("name", TAKES_MASKS)
def test_a_mask_has_the_shape_of_a_frame(name: str, which: str) -> None:
    with pytest.raises(InputError, match=rf"^{which} must have the shape of a frame, \(6, 7\), got \(7, 6\)"):
        TAKES_MASKS[name](**{which: np.ones((7, 6), bool)})


def test_a_masked_frame_means_its_mask() -> None:
    rng = np.random.default_rng(0)
    frame = np.where(rng.random((12, 13)) < 0.1, np.nan, FRAME.mean() + rng.normal(size=(12, 13)))
    works = np.isfinite(frame)
    masked = np.ma.masked_invalid(frame)
    assert frame_noise(masked) == frame_noise(frame, valid=works)
    np.testing.assert_array_equal(fill_invalid(masked, np.ones_like(works)), fill_invalid(frame, works))
    for one, other in zip(find_contacts(masked), find_contacts(frame, valid=works), strict=True):
        np.testing.assert_array_equal(one.profile.measures, other.profile.measures)
    frames = np.ma.stack([masked, 2 * masked])
    pad = Pad(frames)
    assert pad.valid is not None
    np.testing.assert_array_equal(pad.valid, works)
    assert recording_noise(frames) == recording_noise(np.asarray(frames), valid=works)


def test_a_mask_that_is_given_and_one_that_is_there_count_both() -> None:
    masked = np.ma.masked_equal(FRAME, 3.0)
    works = FRAME != 5.0
    np.testing.assert_array_equal(as_valid(masked, works, FRAME.shape), works & (FRAME != 3.0))
    assert as_valid(np.ma.array(FRAME), None, FRAME.shape).size == 0


def test_masks_that_cannot_be_meant_are_refused() -> None:
    frames = np.ma.array(np.stack([FRAME, FRAME]))
    frames[0, 2, 2] = np.ma.masked
    with pytest.raises(InputError, match="must mask the same taxels in every frame"):
        Pad(frames)
    with pytest.raises(InputError, match="a frame must not be masked here; fill what is masked first"):
        outlines(np.ma.masked_equal(FRAME, 3.0), 1.0)


@pytest.mark.parametrize(
    "values", [np.ones(3), np.ones((0, 3)), np.ones((3, 3), complex), [["a"]], [[1.0], [1.0, 2.0]], None]
)
def test_a_frame_is_real_numbers_in_rows_and_columns(values: object) -> None:
    with pytest.raises(InputError, match=r"^a frame must be numbers of shape \(rows, cols\), got"):
        as_numbers(values, 2, "a frame")


def test_numbers_keep_their_type_and_floats_their_place() -> None:
    assert as_numbers(np.ones((2, 2), np.uint16), 2, "a frame").dtype == np.uint16
    assert as_numbers(np.ones((2, 2), bool), 2, "a frame").dtype == np.uint8
    assert as_numbers(np.ones((2, 2), np.longdouble), 2, "a frame").dtype == np.float64
    assert as_floats(FRAME, 2, "a frame") is FRAME
    read_only = FRAME.copy()
    read_only.flags.writeable = False
    assert as_floats(read_only, 2, "a frame").flags.writeable
    assert as_mask(None, (2, 2), "field").size == 0
