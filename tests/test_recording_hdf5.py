"""HDF5: nothing is lost, other people's files are read as h5py writes them, hostile ones are refused in a line."""

from __future__ import annotations

import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import assume, given, settings
from tests.test_recording_mcap import recordings, same

from varishold import FormatError, MissingExtraError
from varishold import open as open_recording
from varishold.recording import Pad, Recording, Signals, read, write

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


def writable(recording: Recording) -> bool:
    """Tell whether no text holds half a character, which no file can."""
    texts = [column for column in recording.press_columns.values() if column.dtype.kind == "U"]
    return all(each.encode("utf-8", "replace").decode() == each for text in texts for each in text.tolist())


@settings(deadline=None)
@given(recordings())
def test_writing_hdf5_loses_nothing_and_is_the_same_bytes_each_time(
    tmp_path_factory: pytest.TempPathFactory, recording: Recording
) -> None:
    assume(writable(recording))
    folder = tmp_path_factory.mktemp("h5")
    write(recording, folder / "a.h5")
    again = read(folder / "a.h5")
    same(recording, again)
    assert again.notes == ()
    write(again, folder / "b.h5")
    assert (folder / "a.h5").read_bytes() == (folder / "b.h5").read_bytes()


def test_names_that_are_no_paths_come_back(tmp_path: Path) -> None:
    pads = {name: Pad(FRAMES + k) for k, name in enumerate((".", "..", "a/b", "signals", "%2F", "press"))}
    signals = {"a/b.c": Signals(np.ones((5, 2)), ("x/y", "ü"), "°C"), "plain": Signals(np.arange(5)[:, None])}
    write(Recording(pads, signals=signals), tmp_path / "a.h5")
    again = read(tmp_path / "a.h5")
    assert {name: int(pad.frames[0, 0, 0]) for name, pad in again.pads.items()} == dict(
        zip(pads, range(6), strict=True)
    )
    assert {name: (each.names, each.unit) for name, each in again.signals.items()} == {
        "a/b.c": (("x/y", "ü"), "°C"),
        "plain": ((), "raw"),
    }


def test_h5py_finds_what_was_written_where_the_table_says(tmp_path: Path) -> None:
    mask = np.ones((3, 4), bool)
    mask[1, 2] = False
    pads = {"palm": Pad(FRAMES, valid=mask, pitch_m=(0.002, 0.003)), "tip": Pad(-1.0 - FRAMES, polarity="down")}
    write(Recording(pads, time_s=np.arange(5) / 7, unit="kPa", sensor="mat θ"), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        assert (file["palm/pressure"][:] == FRAMES).all()
        assert file["palm/pressure"].dtype == np.uint16
        assert (file["palm/valid"][:] == mask).all()
        assert file["palm"].attrs["pitch_m"].tolist() == [0.002, 0.003]
        assert file["tip"].attrs["polarity"] == b"down"
        assert file["time_s"][:].tolist() == (np.arange(5) / 7).tolist()
        assert (file.attrs["unit"].decode(), file.attrs["sensor"].decode()) == ("kPa", "mat θ")


def test_as_anybody_writes_it_with_h5py(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        pad = file.create_dataset("hand/palm/pressure", data=FRAMES.astype(">i4"), chunks=(2, 3, 4), compression="lzf")
        pad.attrs["pitch_m"], pad.attrs["unit"] = 0.004, "kPa"
        file["time_s"] = np.arange(5.0)
        file["press"] = [-1, 0, 0, 1, 1]
        file["presses/label"] = ["cone", "ball ü"]
        file["nothing"] = h5py.Empty("f4")
        file.attrs["sensor"] = "S"
    recording = read(tmp_path / "a.h5")
    palm = recording.pads["hand/palm"]
    assert palm.frames.dtype == np.dtype(">i4")
    assert (palm.frames == FRAMES).all()
    assert (palm.pitch_m, recording.unit, recording.sensor) == ((0.004, 0.004), "kPa", "S")
    assert recording.presses.columns["label"].tolist() == ["cone", "ball ü"]
    assert recording.notes == ("passed over, for it is no part of a recording: nothing",)


def test_frames_under_other_names_are_found_and_told(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["observations/tactile_left"], file["observations/tactile_right"] = FRAMES, FRAMES + 1
        file["observations/image"] = np.zeros((5, 8, 8), np.uint8)
        file["observations/timestamp"] = np.arange(5) / 10
    recording = read(tmp_path / "a.h5")
    assert list(recording.pads) == ["observations/tactile_left", "observations/tactile_right"]
    assert recording.time_s is not None
    assert recording.notes == (
        "taken for frames, by shape and name: observations/tactile_left, observations/tactile_right",
        "taken for times in seconds: observations/timestamp",
    )
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x"] = FRAMES.reshape(5, 12)
    assert read(tmp_path / "b.h5", shape=(3, 4)).pads["pad"].frames.tolist() == FRAMES.tolist()
    with pytest.raises(FormatError, match=r"b.h5: holds no array of frames .* it holds x \(5, 12\)"):
        read(tmp_path / "b.h5")


def test_blocks_are_what_read_gives(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frames = rng.integers(0, 4000, (70_00, 6, 7)).astype(np.uint16)
    whole = Recording({"palm": Pad(frames), "tip": Pad(frames[:, :2])}, time_s=np.arange(7000) / 100)
    write(whole, tmp_path / "a.h5")
    with open_recording(tmp_path / "a.h5") as opened:
        assert (opened.n_frames, opened.frame_at(12.345)) == (7000, 1235)
        for size in (1, 999, 4096):
            blocks = list(opened.blocks(size))[:9]
            joined = np.concatenate([block.pads["palm"].frames for block in blocks])
            assert (joined == frames[: len(joined)]).all()
        part = opened.frames[6998:7003]
        assert part.time_s is not None
        assert part.time_s.tolist() == [69.98, 69.99]
        same(opened.whole, read(tmp_path / "a.h5"))


def hostile(kind: str, path: Path) -> None:
    with h5py.File(path, "w") as file:
        if kind == "external link":
            file["pressure"] = h5py.ExternalLink("/etc/passwd", "/")
        elif kind == "soft link":
            file["pressure"] = h5py.SoftLink("/x")
        elif kind == "external values":
            file.create_dataset("pressure", (2, 3, 4), "u1", external=[("/etc/passwd", 0, 24)])
        elif kind == "virtual":
            layout = h5py.VirtualLayout((2, 3, 4), "u1")
            layout[:] = h5py.VirtualSource("other.h5", "x", (2, 3, 4))
            file.create_virtual_dataset("pressure", layout)
        elif kind == "empty":
            file.create_dataset("pressure", (1 << 30, 16, 16), "f8", chunks=(1, 16, 16))
        elif kind == "bomb":
            held = file.create_dataset("pressure", (512, 64, 64), "u1", chunks=(512, 64, 64), compression="gzip")
            held.id.write_direct_chunk((0, 0, 0), zlib.compress(bytes(1 << 30), 1)[: 2 << 20])
        elif kind == "objects":
            file.create_dataset("pressure", data=np.array(["a", "b"], object), dtype=h5py.string_dtype())
        elif kind == "compound":
            file["pressure"] = np.zeros((2, 3, 4), [("x", "f4"), ("y", "f4")])
        elif kind == "deep":
            file["/".join("g" * 40) + "/pressure"] = FRAMES
        elif kind == "within itself":
            file["g/x"] = 1
            file["g/g"] = file["g"]
        elif kind == "filter":
            file.create_dataset("pressure", (2, 3, 4), "u1", chunks=(2, 3, 4), scaleoffset=0)
            plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            plan.set_chunk((2, 3, 4))
            plan.set_filter(32001, h5py.h5z.FLAG_OPTIONAL, (0,))
            space = h5py.h5s.create_simple((2, 3, 4))
            h5py.h5d.create(file.id, b"other", h5py.h5t.NATIVE_INT32, space, plan)
            del file["pressure"]
            file["pressure"] = file["other"]
            del file["other"]
        elif kind == "lengths":
            file["a/pressure"], file["b/pressure"] = FRAMES, FRAMES[:3]
        elif kind == "unit":
            file["pressure"] = FRAMES
            file.attrs["unit"] = 5
        elif kind == "dimensions":
            file["pressure"] = np.zeros((2, 3, 4, 5))


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("external link", "holds no array of frames .* it holds no numbers"),
        ("soft link", "holds no array of frames"),
        ("external values", "pressure: its values stand in another file, which is not opened; copy them into it"),
        ("virtual", "pressure: its values stand in another file"),
        ("empty", "pressure: holds 2199023255552 bytes in a file of [0-9]+; nothing is so empty"),
        ("bomb", "pressure: a piece of 2097152 bytes would unpack to more"),
        ("objects", "pressure must be numbers|must have shape|must be numbers"),
        ("compound", "pressure must be numbers"),
        ("deep", "holds groups within more than 8 others"),
        ("within itself", "holds no array of frames"),
        ("filter", r"pressure: is packed with .*, which is not read; repack it \(h5repack -f GZIP=1\)"),
        ("lengths", "pads must have equally many frames, got 5 of 'a' and 3 of 'b'"),
        ("unit", "unit must be one text, got int64"),
        ("dimensions", r"must be numbers of shape \(n_frames, rows, cols\), got shape \(2, 3, 4, 5\)"),
    ],
)
def test_hostile_files_are_refused_in_one_line(tmp_path: Path, kind: str, message: str) -> None:
    path = tmp_path / "a.h5"
    hostile(kind, path)
    with pytest.raises(FormatError, match=message) as told:
        read(path)
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)


def test_a_heap_of_texts_that_never_ends_is_refused(tmp_path: Path) -> None:
    """libhdf5 2.0 goes through it forever."""
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["pressure"] = FRAMES
        file.attrs["unit"] = "kPa"
    content = bytearray(path.read_bytes())
    heap = content.index(b"GCOL")
    # The entry of free space at its end, which has number 0, gets no length.
    entry = heap + 16
    while content[entry : entry + 2] != b"\0\0":
        length = int.from_bytes(content[entry + 8 : entry + 16], "little")
        entry += 16 + length + -length % 8
    content[entry + 8 : entry + 16] = bytes(8)
    path.write_bytes(content)
    with pytest.raises(FormatError, match=r"is damaged: the heap of texts at byte [0-9]+ never ends"):
        read(path)


def test_cut_off_and_no_hdf5(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    write(Recording({"pad": Pad(FRAMES)}), path)
    whole = path.read_bytes()
    for length in (9, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"a.h5: .*is damaged or cut off"):
            read(path)
    path.write_bytes(b"hello")
    with pytest.raises(FormatError, match="does not start like HDF5; is it damaged, or something else"):
        read(path)


def test_what_is_missing_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.h5"
    write(Recording({"pad": Pad(FRAMES)}), path)
    import sys

    monkeypatch.setitem(sys.modules, "h5py", None)
    monkeypatch.delitem(sys.modules, "varishold.recording.formats.hdf5_file", raising=False)
    for act in (lambda: read(path), lambda: write(Recording({"pad": Pad(FRAMES)}), path)):
        with pytest.raises(MissingExtraError, match=r"needs h5py, .* run: pip install -e '.\[files\]'"):
            act()


def test_names_of_no_presses_are_still_text(tmp_path: Path) -> None:
    write(
        Recording({"pad": Pad(FRAMES[:1])}, press=np.array([-1]), press_columns={"label": np.empty(0, "U3")}),
        tmp_path / "a.h5",
    )
    assert read(tmp_path / "a.h5").press_columns["label"].dtype.kind == "U"
