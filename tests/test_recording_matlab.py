"""MATLAB: what scipy and mat73 write and read is what is read and written here; objects are never looked into."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import h5py
import mat73
import numpy as np
import pytest
import scipy.io
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from tests.test_recording_hdf5 import writable
from tests.test_recording_mcap import recordings, same

from varishold import FormatError
from varishold import open as open_recording
from varishold.recording import Pad, Recording, Signals, read, write

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


@settings(deadline=None)
@given(recordings())
def test_writing_matlab_loses_nothing_and_is_the_same_bytes_each_time(
    tmp_path_factory: pytest.TempPathFactory, recording: Recording
) -> None:
    assume(writable(recording))
    folder = tmp_path_factory.mktemp("mat")
    write(recording, folder / "a.mat")
    again = read(folder / "a.mat")
    same(recording, again)
    assert again.notes == ()
    write(again, folder / "b.mat")
    assert (folder / "a.mat").read_bytes() == (folder / "b.mat").read_bytes()


def test_mat73_reads_what_was_written(tmp_path: Path) -> None:
    mask = np.ones((3, 4), bool)
    mask[1, 2] = False
    pads = {"palm": Pad(FRAMES, valid=mask, pitch_m=(0.002, 0.003)), "finger 2": Pad(FRAMES / 7)}
    recording = Recording(
        pads,
        np.arange(5) / 7,
        "kPa",
        press=np.array([-1, 0, 0, 1, 1]),
        press_columns={"label": np.array(["cone", "ball"])},
        signals={"shear": Signals(np.ones((5, 2)), ("x", "y"))},
    )
    write(recording, tmp_path / "a.mat")
    held = mat73.loadmat(tmp_path / "a.mat")
    assert held["palm"]["pressure"].dtype == np.uint16
    assert (held["palm"]["pressure"] == FRAMES).all()
    assert (held["finger_2"]["pressure"] == FRAMES / 7).all()
    assert held["palm"]["valid"].dtype == bool
    assert (held["palm"]["valid"] == mask).all()
    assert held["palm"]["pitch_m"].tolist() == [0.002, 0.003]
    assert held["time_s"].tolist() == (np.arange(5) / 7).tolist()
    assert held["unit"] == "kPa"
    assert (held["signals"]["shear"] == 1).all()


def test_large_frames_are_in_pieces_and_taken_in_blocks(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 4000, (3000, 16, 16)).astype(np.uint16)
    write(Recording({"pad": Pad(frames)}, time_s=np.arange(3000) / 100), tmp_path / "a.mat")
    assert (mat73.loadmat(tmp_path / "a.mat")["pressure"] == frames).all()
    with open_recording(tmp_path / "a.mat") as opened:
        assert (np.concatenate([block.pads["pad"].frames for block in opened.blocks(777)]) == frames).all()
        assert opened.frame_at(9.995) == 1000


CONTENTS: dict[str, Any] = {
    "pressure": FRAMES.astype(float),
    "time_s": np.arange(5.0),
    "press": np.array([-1, 0, 0, 1, 1], np.int64),
    "presses": {"label": np.array(["cone", "ball ü"], object)},
    "pitch_m": 0.004,
    "unit": "kPa",
    "sensor": "S",
    "nothing": np.zeros((0, 3)),
}


@pytest.mark.parametrize("packed", [False, True])
def test_what_scipy_writes(tmp_path: Path, packed: bool) -> None:
    scipy.io.savemat(tmp_path / "a.mat", CONTENTS, do_compression=packed)
    recording = read(tmp_path / "a.mat")
    pad = recording.pads["pad"]
    assert pad.frames.tolist() == FRAMES.tolist()
    assert (pad.pitch_m, recording.unit, recording.sensor) == ((0.004, 0.004), "kPa", "S")
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 1, 2, 3, 4]
    assert recording.presses.columns["label"].tolist() == ["cone", "ball ü"]
    assert recording.notes == ("passed over, for it is no part of a recording: nothing",)


@settings(deadline=None)
@given(
    hnp.arrays(
        st.sampled_from([np.dtype(f"{k}{n}") for k in "iu" for n in (1, 2, 4, 8)] + [np.dtype("f4"), np.dtype("f8")]),
        st.tuples(st.integers(2, 4), st.integers(2, 4), st.integers(2, 4)),
        elements=st.integers(0, 100),
    ),
    st.booleans(),
)
def test_every_type_as_scipy_writes_it(
    tmp_path_factory: pytest.TempPathFactory, frames: np.ndarray, packed: bool
) -> None:
    path = tmp_path_factory.mktemp("mat") / "a.mat"
    scipy.io.savemat(path, {"palm": {"pressure": frames}, "tip": {"pressure": frames}}, do_compression=packed)
    recording = read(path)
    assert list(recording.pads) == ["palm", "tip"]
    for pad in recording.pads.values():
        assert pad.frames.dtype == frames.dtype
        assert (pad.frames == frames).all()


def test_frames_on_the_last_axis_are_told_by_time_or_shape(tmp_path: Path) -> None:
    last = np.moveaxis(FRAMES, 0, -1)
    scipy.io.savemat(tmp_path / "a.mat", {"pressure": last, "time_s": np.arange(5.0)})
    assert read(tmp_path / "a.mat").pads["pad"].frames.tolist() == FRAMES.tolist()
    scipy.io.savemat(tmp_path / "b.mat", {"tactile": last})
    assert read(tmp_path / "b.mat", shape=(3, 4)).pads["pad"].frames.tolist() == FRAMES.tolist()
    with h5py.File(tmp_path / "c.mat", "w", userblock_size=512) as file:
        file["pressure"], file["time_s"] = last.T, np.arange(5.0)[None]
        file["pressure"].attrs["MATLAB_class"] = np.bytes_("uint16")
    with open(tmp_path / "c.mat", "r+b") as binary:
        binary.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    assert read(tmp_path / "c.mat").pads["pad"].frames.tolist() == FRAMES.tolist()


@pytest.mark.parametrize("clock", ["t", "time", "Timestamps"])
def test_any_vector_that_is_called_a_time_tells_the_last_axis(tmp_path: Path, clock: str) -> None:
    frames, time = np.arange(60.0).reshape(5, 3, 4), np.arange(5.0) / 10
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"tactile": np.moveaxis(frames, 0, -1), clock: time})
    recording = read(path)
    np.testing.assert_array_equal(recording.pads["pad"].frames, frames)
    assert recording.time_s is not None
    np.testing.assert_array_equal(recording.time_s, time)
    scipy.io.savemat(path, {"pressure": np.moveaxis(frames, 0, -1), clock: time})
    np.testing.assert_array_equal(read(path).pads["pad"].frames, frames)
    # Where as many times are there as of the first axis, or only one, nothing is turned.
    scipy.io.savemat(path, {"tactile": frames, clock: time})
    np.testing.assert_array_equal(read(path).pads["pad"].frames, frames)
    scipy.io.savemat(path, {"tactile": frames[:, :, :1], clock: 3.0})
    assert read(path).pads["pad"].shape == (3, 1)


def test_cells_of_text_in_matlab_73(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        file["pressure"] = FRAMES.T
        file["press"] = np.array([[0, 0, 1, 1, 1]], float)
        file["presses/label"] = np.empty((1, 2), h5py.ref_dtype)
        for k, text in enumerate(("cone", "ball")):
            file[f"#refs#/{k}"] = np.frombuffer(text.encode("utf-16-le"), "<u2")[:, None]
            file["presses/label"][0, k] = file[f"#refs#/{k}"].ref
        file["presses/label"].attrs["MATLAB_class"] = np.bytes_("cell")
        file["function"] = np.zeros(3)
        file["function"].attrs["MATLAB_class"] = np.bytes_("function_handle")
    with open(tmp_path / "a.mat", "r+b") as binary:
        binary.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    with pytest.raises(FormatError, match="press must be one whole number a frame"):
        read(tmp_path / "a.mat")
    with h5py.File(tmp_path / "a.mat", "r+") as file:
        del file["press"]
        file["press"] = np.array([[0, 0, 1, 1, 1]], np.int32)
    recording = read(tmp_path / "a.mat")
    assert recording.presses.columns["label"].tolist() == ["cone", "ball"]
    assert recording.notes == ("passed over: function (function_handle)",)


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def matrix(kind: int, shape: tuple[int, ...], name: str, rest: bytes) -> bytes:
    head = element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack(f"<{len(shape)}i", *shape))
    return element(14, head + element(1, name.encode()) + rest)


HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def nested(depth: int) -> bytes:
    made = matrix(6, (1, 1), "", element(9, bytes(8)))
    for _ in range(depth):
        made = matrix(1, (1, 1), "", made)
    return made


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (HEAD, "holds no array of frames"),
        (HEAD[:100], "its head does not say the order of its bytes"),
        (HEAD + struct.pack("<II", 14, 1 << 31), "an element of kind 14 and 2147483648 bytes begins where 0 are left"),
        (HEAD + element(3, bytes(8)), "an element of kind 3"),
        (HEAD + matrix(6, (1 << 30, 1 << 30), "pressure", element(9, bytes(8))), "an array of shape .* is announced"),
        (HEAD + matrix(6, (2, 3, 4), "pressure", element(9, bytes(8))), "cannot reshape|is damaged"),
        (HEAD + matrix(3, (1, 1), "pressure", element(1, b"x")), "holds no array of frames"),
        (HEAD + matrix(17, (1, 1), "pressure", element(1, b"x")), "holds no array of frames"),
        (HEAD + matrix(16, (1, 1), "pressure", nested(2)), "holds no array of frames"),
        (HEAD + matrix(1, (1, 1), "pressure", nested(5000)), "holds no array of frames"),
        (HEAD + matrix(1, (1 << 20, 1 << 9), "pressure", nested(1)), "a cell of 536870912 entries is announced"),
        (HEAD + matrix(6, (2, 3), "pressure", element(9, bytes(48))), r"must have shape \(n, rows, cols\)"),
    ],
)
def test_hostile_files_are_refused_in_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.mat"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message) as told:
        read(path)
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)


def test_bombs_are_refused(tmp_path: Path) -> None:
    # Zeros that are packed once and stand there forty times, which no dictionary joins.
    packer = zlib.compressobj(9)
    head = packer.compress(b"") + packer.flush(zlib.Z_FULL_FLUSH)
    once = packer.compress(bytes(1 << 24)) + packer.flush(zlib.Z_FULL_FLUSH)
    end = b"\x03\x00" + struct.pack(">HH", (40 << 24) % 65521, 1)
    packed = head + 40 * once + end
    unpacker = zlib.decompressobj()
    assert not any(unpacker.decompress(packed, 1 << 24))
    (tmp_path / "a.mat").write_bytes(HEAD + struct.pack("<II", 15, len(packed)) + packed)
    with pytest.raises(FormatError, match=r"would unpack .* nothing measured is so empty"):
        read(tmp_path / "a.mat")
