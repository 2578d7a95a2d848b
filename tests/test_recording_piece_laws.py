"""Sizes in messages, in pieces of files and in blocks: each at its edge."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.recording import GraspTable, Pad, Recording, read, write
from varishold.recording import pad as pad_module
from varishold.recording.formats import mat73
from varishold.recording.mcap.image_message import image_layout
from varishold.recording.mcap.numbers_message import numbers_head, numbers_layout, numbers_message


def padded(content: bytes, unit: int = 4) -> bytes:
    """Fill up, counted from behind the four bytes that tell the order."""
    return content + bytes(-(len(content) - 4) % unit)


def image(rows: int, cols: int, encoding: str, step: int, data: bytes, *, said: int | None = None) -> bytes:
    """Return a message as ROS 2 sends it, lowest byte first."""
    message = b"\0\1\0\0" + struct.pack("<iI", 5, 6) + struct.pack("<I", 4) + b"pad\0"
    message = padded(message) + struct.pack("<II", rows, cols)
    message += struct.pack("<I", len(encoding) + 1) + encoding.encode() + b"\0" + b"\0"
    message = padded(message) + struct.pack("<II", step, len(data) if said is None else said)
    return message + data


SIZES = {"mono8": 1, "mono16": 2, "16UC1": 2, "32FC1": 4, "8UC3": 3, "16UC3": 6, "64FC1": 8}


@pytest.mark.parametrize("encoding", SIZES)
@pytest.mark.parametrize("spare", [-1, 0, 1, 5])
def test_a_row_of_an_image_has_room_for_its_pixels_and_may_have_more(encoding: str, spare: int) -> None:
    rows, cols = 3, 5
    step = cols * SIZES[encoding] + spare
    message = image(rows, cols, encoding, step, bytes(rows * step))
    if spare < 0:
        with pytest.raises(ValueError, match=rf"3 x 5 pixels of {encoding} in rows of {step} bytes need"):
            image_layout(message)
        return
    layout = image_layout(message)
    assert (layout.rows, layout.cols, layout.step, layout.size) == (rows, cols, step, len(message))
    assert layout.channels * layout.dtype.itemsize == SIZES[encoding]
    assert message[layout.start :] == bytes(rows * step)
    assert layout.fits(message)
    assert not layout.fits(message + b"\0")
    assert not layout.fits(message[:-1])
    other = image(rows, cols + 1, encoding, step + SIZES[encoding], bytes(rows * (step + SIZES[encoding])))
    assert not layout.fits(other)


@pytest.mark.parametrize(("rows", "cols", "said"), [(0, 5, None), (3, 0, None), (3, 5, 14), (3, 5, 16)])
def test_an_image_that_contradicts_itself_is_none(rows: int, cols: int, said: int | None) -> None:
    with pytest.raises(ValueError, match="are announced"):
        image_layout(image(rows, cols, "mono8", 5, bytes(15), said=said))


@given(
    st.lists(st.integers(1, 4), min_size=1, max_size=3).map(tuple), st.sampled_from(["u1", "<i2", "<u4", "<f4", "<f8"])
)
def test_numbers_fit_the_layout_of_their_like_and_of_nothing_longer_or_shorter(
    shape: tuple[int, ...], kind: str
) -> None:
    dtype = np.dtype(kind)
    values = np.arange(math.prod(shape)).astype(dtype).reshape(shape)
    message = numbers_message(numbers_head(shape), values)
    layout = numbers_layout(message, dtype)
    assert layout.shape == shape
    np.testing.assert_array_equal(np.frombuffer(message[len(layout.head) :], dtype).reshape(shape), values)
    assert layout.fits(message)
    assert layout.fits(message[: len(layout.head)] + bytes(values.nbytes))
    assert not layout.fits(message + b"\0")
    assert not layout.fits(message[:-1])
    assert not layout.fits(message[: len(layout.head)])
    # One number more, of which the head says nothing.
    with pytest.raises(ValueError, match="numbers from 0 on"):
        numbers_layout(message + bytes(dtype.itemsize), dtype)


@pytest.mark.parametrize(("side", "n"), [(8, 900), (64, 40), (300, 5)])
def test_frames_in_matlab_stand_in_pieces_of_some_kilobytes(tmp_path: Path, side: int, n: int) -> None:
    frames = np.random.default_rng(0).integers(0, 9, (n, side, side)).astype(np.uint16)
    write(Recording({"pad": Pad(frames)}), tmp_path / "a.mat")
    with h5py.File(tmp_path / "a.mat") as file:
        found = []
        file.visititems(
            lambda _, item: found.append(item) if isinstance(item, h5py.Dataset) and item.ndim == 3 else None
        )
        (held,) = found
        if frames.nbytes >= mat73._CHUNK:
            # The last axis is the frame's.
            assert held.chunks is not None
            assert held.chunks[:2] == (side, side)
            assert held.chunks[2] == max(1, min(n, mat73._CHUNK // (2 * side * side)))
            assert held.chunks[2] == 1 or held.chunks[2] * 2 * side * side <= mat73._CHUNK
        else:
            assert held.chunks is None
    np.testing.assert_array_equal(read(tmp_path / "a.mat").pads["pad"].frames, frames)


@pytest.mark.parametrize("length", range(20))
def test_a_label_of_any_length_comes_back_from_hdf5(tmp_path: Path, length: int) -> None:
    """Texts stand one behind the other in a heap, each filled up to eight bytes."""
    labels = np.array(["x" * length + "y", "ü" * length + "b", "c"])
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["pressure"] = np.arange(3 * 4.0).reshape(3, 2, 2)
        file["press"] = np.arange(3)
        file.create_dataset("press.label", data=labels.astype(object), dtype=h5py.string_dtype())
    assert read(tmp_path / "a.h5").presses.columns["label"].tolist() == labels.tolist()


@pytest.mark.parametrize(("most", "at_once"), [(1, 1), (95, 1), (96, 1), (192, 2), (191, 1), (10**6, 7)])
def test_a_pad_is_looked_through_in_blocks_of_so_many_bytes(
    monkeypatch: pytest.MonkeyPatch, most: int, at_once: int
) -> None:
    """Counted as numbers of eight bytes, whatever they are."""
    monkeypatch.setattr(pad_module, "_BLOCK", most)
    frames = np.arange(7 * 12, dtype=np.uint8).reshape(7, 3, 4)
    blocks = list(pad_module._blocks(frames))
    assert [len(block) for _, block in blocks] == [at_once] * (7 // at_once) + ([7 % at_once] if 7 % at_once else [])
    assert [first for first, _ in blocks] == list(range(0, 7, at_once))
    np.testing.assert_array_equal(np.concatenate([block for _, block in blocks]), frames)


def test_a_table_without_columns_has_no_rows() -> None:
    assert len(GraspTable({})) == 0
    assert len(GraspTable({"a": np.arange(3)})) == 3
