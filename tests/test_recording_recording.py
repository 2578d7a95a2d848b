"""Pads and recordings: what they accept, what they refuse and in which words, and what they remark."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import varishold.recording
from varishold import InputError
from varishold.recording import Pad, Recording, frame_of, peak_frame, presses, select_frames, write


def noise(n: int = 20, shape: tuple[int, int] = (8, 8), seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 1, (n, *shape))


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.int64, np.float16, np.float32, np.float64, ">f4", ">u2"])
def test_types_are_kept_and_frames_are_given_as_float64(dtype: str) -> None:
    pad = Pad(np.arange(24).reshape(2, 3, 4).astype(dtype))
    assert pad.frames.dtype == np.dtype(dtype)
    frame = frame_of(pad, 1)
    assert frame.dtype == np.float64
    assert frame.flags.c_contiguous
    assert frame.flags.writeable
    assert frame.tolist() == np.arange(12, 24).reshape(3, 4).tolist()


def test_a_pad_does_not_copy_and_cannot_be_written_through() -> None:
    frames = np.arange(24.0).reshape(2, 3, 4)
    pad = Pad(frames)
    assert np.shares_memory(pad.frames, frames)
    with pytest.raises(ValueError, match="read-only"):
        pad.frames[0, 0, 0] = 1


def test_nan_is_fine_where_nothing_is_to_be_believed() -> None:
    frames = noise()
    frames[:, 0, 1] = np.nan
    frames[3, 2, 2] = np.inf
    usable = np.ones((8, 8), bool)
    usable[0, 1] = usable[2, 2] = False
    assert not Pad(frames, valid=usable).usable[0, 1]
    assert np.isfinite(Pad(frames, field=usable).totals()).all()
    frames[12, 0, 3] = np.nan
    with pytest.raises(
        InputError,
        match=r"pressure must be finite, got nan at \(row, col\) = \(0, 3\) of frame 12; mark dead taxels in valid",
    ):
        Pad(frames, valid=usable)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Pad(np.zeros((3, 4))), r"shape \(n_frames, rows, cols\), got float64 of shape \(3, 4\)"),
        (lambda: Pad(np.zeros((0, 4, 4))), "at least one frame, got none"),
        (lambda: Pad(np.zeros((2, 0, 4))), r"numbers of shape .* got float64 of shape \(2, 0, 4\)"),
        (lambda: Pad(np.zeros((2, 4, 4), complex)), "must be numbers .* got complex128"),
        (lambda: Pad(np.zeros((2, 4, 4), object)), "must be numbers .* got object"),
        (lambda: Pad(np.zeros((2, 4, 4), "U3")), "must be numbers .* got <U3"),
        (lambda: Pad(np.zeros((2, 4, 4)), valid=np.ones((4, 3), bool)), r"valid must have .* \(4, 4\), got \(4, 3\)"),
        (lambda: Pad(np.zeros((2, 4, 4)), field=np.full((4, 4), 2)), "field must be True or False"),
        (lambda: Pad(np.zeros((2, 4, 4)), valid=np.zeros((4, 4), bool)), "no taxel of 4 x 4 is both in field and"),
        (
            lambda: Pad(np.zeros((2, 4, 4)), pitch_m=(0.0, 1.0)),
            r"pitch_m must be one spacing in metres or .*, got \(0.0, 1.0\)",
        ),
        (lambda: Pad(np.zeros((2, 4, 4)), pitch_m=-0.004), "pitch_m must be one spacing in metres or .*, got -0.004"),  # type: ignore[arg-type]
        (lambda: Pad(np.zeros((2, 4, 4)), pitch_m=(1.0, 1.0, 1.0)), r"got \(1.0, 1.0, 1.0\)"),  # type: ignore[arg-type]
        (lambda: Pad(np.zeros((2, 4, 4)), pitch_m="wide"), "pitch_m must be one spacing in metres or .*, got 'wide'"),  # type: ignore[arg-type]
        (lambda: Pad(-abs(noise()) * 100), r"mostly negative \(1280 values below 0, 0 above.*negate the values"),
        (
            lambda: Pad(np.full((2, 2, 2), 1e200)),
            r"within 1e\+100, got 1e\+200 at \(row, col\) = \(0, 0\) of frame 0; is the file damaged",
        ),
        (lambda: Recording({}), "at least one pad"),
        (lambda: Recording({"": Pad(noise())}), "name must be printable text, got ''"),
        (lambda: Recording({"a": Pad(noise(3)), "b": Pad(noise(4))}), "got 3 of 'a' and 4 of 'b'"),
        (lambda: Recording({"a": Pad(noise(3))}, np.zeros(4)), r"shape \(3,\), got float64 of shape \(4,\)"),
        (
            lambda: Recording({"a": Pad(noise(3))}, np.array([0, np.nan, 1])),
            "time_s must be finite, got nan at frame 1",
        ),
        (
            lambda: Recording({"a": Pad(noise(3))}, signals={"shear": np.zeros((3, 2))}),  # type: ignore[dict-item]
            r"signals 'shear' must be a Signals, as Signals\(values\) makes them, got ndarray",
        ),
        (lambda: frame_of(Pad(noise(3)), 3), "no frame 3: frames are numbered 0 to 2"),
        (lambda: frame_of(Pad(noise(3)), -1), "no frame -1"),
    ],
)
def test_what_is_no_recording(make: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()  # type: ignore[operator]


@given(hnp.array_shapes(min_dims=3, max_dims=3, min_side=3, max_side=12), st.integers(0, 10**6))
def test_noise_alone_is_never_of_wrong_polarity(shape: tuple[int, int, int], seed: int) -> None:
    if np.prod(shape) >= 100:
        Pad(np.random.default_rng(seed).normal(0, 1, shape))


@pytest.mark.parametrize("shape", [(1, 16, 16), (30, 8, 8), (5, 1, 30)])
def test_pressing_downward_is_wrong_polarity_and_a_drifted_zero_is_not(shape: tuple[int, int, int]) -> None:
    frames = np.random.default_rng(0).normal(-0.5, 1, shape)
    frames[..., : shape[2] // 3] += 100
    Pad(frames)
    with pytest.raises(InputError, match="larger must mean more pressure"):
        Pad(-frames)


def test_remarks_tell_stuck_dead_saturated_and_constant() -> None:
    frames = np.rint(noise(20) * 5 + 100).astype(np.uint8)
    frames[:, 1, 2] = 7
    frames[:, 3, 4] = 0
    frames[5, 6, 6] = 255
    assert Pad(frames).remarks == (
        "taxel (1, 2) never changes its value: stuck; mark it in valid",
        "taxel (3, 4) is always 0 while nearly all others are not: dead or never touched",
        "taxel (6, 6) reaches full scale, 255: saturated",
    )
    assert Pad(np.full((3, 2, 2), 4)).remarks == ("nothing changes: every value of every frame is 4",)
    flat = np.zeros((1, 9, 9))
    flat[0, 2:5, 2:5] = 1
    assert "each of 9 taxels ((2, 2), (2, 3), (2, 4), (3, 2) and 5 more)" in Pad(flat).remarks[0]
    assert Pad(noise()).remarks == ()
    assert Recording({"palm": Pad(noise(3))}, np.array([1.0, 0.0, 2.0])).remarks == ("time goes back at frame 1",)


@pytest.mark.parametrize(
    ("unit", "pascals"), [("Pa", 1), ("pascal", 1), ("kPa", 1e3), ("N/cm²", 1e4), ("PSI", 6894.757), ("raw", None)]
)
def test_units_of_pressure_are_known(unit: str, pascals: float | None) -> None:
    known = Recording({"pad": Pad(noise(2))}, unit=unit).pascals_per_unit
    assert known is None if pascals is None else known == pytest.approx(pascals)


def test_a_million_frames_are_handled() -> None:
    frames = np.zeros((1_000_000, 16, 16), np.uint8)
    frames[500_000:500_100, 4:9, 4:9] = 50
    recording = Recording({"pad": Pad(frames)})
    assert peak_frame(recording) == 500_000
    assert presses(recording) == [range(500_000, 500_100)]


@given(st.lists(st.tuples(st.integers(4, 20), st.integers(3, 20)), min_size=1, max_size=5), st.booleans())
def test_presses_are_found_under_noise_and_offset(parts: list[tuple[int, int]], offset: bool) -> None:
    force = np.concatenate([np.r_[np.zeros(rest), np.full(loaded, 60.0)] for rest, loaded in parts] + [np.zeros(30)])
    frames = np.random.default_rng(0).normal(200.0 * offset, 1, (force.size, 12, 12))
    frames[:, 3:9, 3:9] += force[:, None, None]
    expected, at = [], 0
    for rest, loaded in parts:
        expected.append(range(at + rest, at + rest + loaded))
        at += rest + loaded
    recording = Recording({"pad": Pad(frames)})
    assert presses(recording) == expected
    assert select_frames(recording, "press") == expected


def test_a_press_does_not_end_for_a_moment_of_noise() -> None:
    force = np.array([0.0, 0, 0, 0, 100, 100, 4, 100, 6, 0.4, 0, 0, 0, 0])
    frames = np.zeros((force.size, 4, 4))
    frames[:, 1:3, 1:3] = force[:, None, None]
    assert presses(Recording({"pad": Pad(frames)})) == [range(4, 9)]


def test_a_recording_that_is_loaded_from_end_to_end_is_one_press() -> None:
    frames = np.abs(noise(10, (12, 12))) * 0.01
    frames[:, 3:9, 3:9] += 1
    assert presses(Recording({"pad": Pad(frames)})) == [range(10)]


def test_frames_are_chosen_as_a_person_says() -> None:
    recording = Recording({"a": Pad(np.arange(12.0).reshape(3, 2, 2)), "b": Pad(np.zeros((3, 1, 1)))})
    assert select_frames(recording, "peak") == [range(2, 3)]
    assert select_frames(recording, "all") == [range(1), range(1, 2), range(2, 3)]
    assert select_frames(recording, " 1 ") == select_frames(recording, 1) == [range(1, 2)]


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ("3", "no frame 3: frames are numbered 0 to 2"),
        (-1, "must be 'peak', 'all', 'press' or a frame's number from 0, got -1"),
        ("best", "got 'best'"),
        ("1.5", "got '1.5'"),
        ("²", "got '²'"),
        ("9" * 5000, "no frame 9"),
        ("press", "no press found"),
    ],
)
def test_frames_that_cannot_be_chosen(frames: str | int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        select_frames(Recording({"pad": Pad(np.zeros((3, 2, 2)))}), frames)


def test_blocks_hold_what_the_whole_holds(tmp_path: Path) -> None:
    frames = np.arange(7 * 12).reshape(7, 3, 4)
    whole = Recording({"a": Pad(frames, pitch_m=1e-3), "b": Pad(frames * 2)}, time_s=np.arange(7.0), unit="kPa")
    write(whole, tmp_path / "a.npz")
    opened = varishold.recording.open(tmp_path / "a.npz")
    blocks = list(opened.blocks(3))
    assert [block.n_frames for block in blocks] == [3, 3, 1]
    assert np.array_equal(np.concatenate([block.pads["b"].frames for block in blocks]), frames * 2)
    assert np.array_equal(np.concatenate([block.time_s for block in blocks]), np.arange(7.0))
    assert (blocks[0].unit, blocks[0].pads["a"].pitch_m) == ("kPa", (1e-3, 1e-3))
    np.save(tmp_path / "a.npy", frames)
    block = varishold.recording.open(tmp_path / "a.npy").frames[2:4]
    mapped = block.pads["pad"].frames
    while not isinstance(mapped, np.memmap):
        assert mapped.base is not None, "the block was copied into memory"
        mapped = mapped.base
    for wrong in (slice(7, 9), slice(0, 4, 2), 3):
        with pytest.raises(InputError, match="frames"):
            opened.frames[wrong]
