"""Parquet: nothing is lost, pyarrow reads what is written, other people's columns are understood, bad ones are told."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import assume, given, settings
from tests.test_recording_hdf5 import writable
from tests.test_recording_mcap import recordings, same

from varishold import FormatError, InputError
from varishold import open as open_recording
from varishold.recording import Pad, Recording, Signals, read, write

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


@settings(deadline=None)
@given(recordings())
def test_writing_parquet_loses_nothing_and_is_the_same_bytes_each_time(
    tmp_path_factory: pytest.TempPathFactory, recording: Recording
) -> None:
    assume(writable(recording))
    folder = tmp_path_factory.mktemp("parquet")
    write(recording, folder / "a.parquet")
    again = read(folder / "a.parquet")
    same(recording, again)
    assert again.notes == ()
    write(again, folder / "b.parquet")
    assert (folder / "a.parquet").read_bytes() == (folder / "b.parquet").read_bytes()


def test_pyarrow_finds_the_columns_of_the_table(tmp_path: Path) -> None:
    pads = {"palm": Pad(FRAMES), "tip": Pad(FRAMES / 7)}
    signals = {"shear": Signals(np.ones((5, 2), np.float32))}
    write(Recording(pads, np.arange(5) / 7, press=np.arange(5) - 1, signals=signals), tmp_path / "a.parquet")
    table = pq.read_table(tmp_path / "a.parquet")
    assert table.column_names == [
        "observation.tactile.palm",
        "observation.tactile.tip",
        "timestamp",
        "press",
        "observation.signals.shear",
    ]
    assert table.schema.field(0).type == pa.list_(pa.uint16(), 12)
    assert table["observation.tactile.palm"].to_pylist() == FRAMES.reshape(5, 12).tolist()
    assert table["timestamp"].to_pylist() == (np.arange(5) / 7).tolist()
    assert table["press"].to_pylist() == [-1, 0, 1, 2, 3]


@pytest.mark.parametrize("kind", ["fixed", "list", "nested", "nested fixed"])
@pytest.mark.parametrize("group", [2, 1000])
def test_as_robots_have_it(tmp_path: Path, kind: str, group: int) -> None:
    rows = FRAMES.astype(np.float32)
    types = {
        "fixed": pa.list_(pa.float32(), 12),
        "list": pa.list_(pa.float32()),
        "nested": pa.list_(pa.list_(pa.float32())),
        "nested fixed": pa.list_(pa.list_(pa.float32(), 4), 3),
    }
    values = (rows if "nested" in kind else rows.reshape(5, 12)).tolist()
    columns = {
        "observation.tactile.left": pa.array(values, types[kind]),
        "observation.state": pa.array([[0.5] * 7] * 5, pa.list_(pa.float32(), 7)),
        "timestamp": pa.array(np.arange(5) / 30, pa.float32()),
        "task": pa.array(["a"] * 5),
    }
    pq.write_table(pa.table(columns), tmp_path / "a.parquet", row_group_size=group)
    recording = read(tmp_path / "a.parquet", shape=(3, 4))
    assert recording.pads["pad"].frames.dtype == np.float32
    assert recording.pads["pad"].frames.tolist() == FRAMES.tolist()
    assert recording.time_s is not None
    assert recording.time_s.tolist() == pytest.approx((np.arange(5) / 30).tolist(), rel=1e-6)
    assert recording.notes == (
        "taken for frames, by shape and name: observation.tactile.left",
        "taken for times in seconds: timestamp",
    )
    with open_recording(tmp_path / "a.parquet", shape=(3, 4)) as opened:
        for first, last in ((3, 5), (0, 1), (1, 4), (4, 5), (2, 3), (0, 5)):
            assert opened.frames[first:last].pads["pad"].frames.tolist() == FRAMES[first:last].tolist()


def test_blocks_are_what_read_gives(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 4000, (10_000, 6, 7)).astype(np.uint16)
    write(Recording({"pad": Pad(frames)}, time_s=np.arange(10_000) / 100), tmp_path / "a.parquet")
    with open_recording(tmp_path / "a.parquet") as opened:
        assert opened.frame_at(50.005) == 5001
        for size in (999, 4096, 20_000):
            joined = np.concatenate([block.pads["pad"].frames for block in opened.blocks(size)])
            assert (joined == frames).all()


def columns_of(kind: str) -> dict[str, Any]:
    fixed = pa.list_(pa.float32(), 12)
    rows = FRAMES.astype(np.float32).reshape(5, 12).tolist()
    return {
        "changing": {"tactile": pa.array([*rows[:3], [1.0] * 11], pa.list_(pa.float32()))},
        "missing row": {"tactile": pa.array([*rows[:3], None], fixed)},
        "missing number": {"tactile": pa.array([[*range(11), None]], pa.list_(pa.int32(), 12))},
        "text": {"tactile": pa.array(["a", "b"])},
        "structs": {"tactile": pa.array([{"a": 1}])},
        "none": {"tactile": pa.array([], fixed)},
        "no list": {"x": pa.array([1.0, 2.0])},
    }[kind]


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("changing", "column tactile: has lists of 12 and of 11 from row 0 on"),
        # Older versions of pyarrow do not say which row.
        ("missing row", "column tactile: (says nothing in rows 0 to 3|is damaged or cut off: Expected all lists)"),
        ("missing number", "column tactile: lacks numbers in rows 0 to 0"),
        ("text", "holds no array of frames .* it holds no numbers"),
        ("structs", "holds no array of frames"),
        ("none", "holds no array of frames|needs at least one frame"),
        ("no list", r"holds no array of frames .* it holds x \(2,\)"),
    ],
)
def test_bad_columns_are_told_in_one_line(tmp_path: Path, kind: str, message: str) -> None:
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table(columns_of(kind)), path)
    with pytest.raises(InputError, match=message) as told:
        read(path, shape=(3, 4))
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)


def test_dates_are_told_and_a_first_row_without_a_list_is(tmp_path: Path) -> None:
    frames = np.arange(36.0).reshape(3, 3, 4).tolist()
    stamps = pa.array([10, 20, 30], pa.timestamp("ms"))
    pq.write_table(pa.table({"tactile": frames, "timestamp": stamps}), tmp_path / "a.parquet")
    recording = read(tmp_path / "a.parquet")
    assert recording.time_s is None
    assert "no time is read: timestamp (timestamp[ms]): write seconds, as timestamp" in recording.notes
    pq.write_table(pa.table({"tactile": frames, "when": stamps, "time": [0.0, 1.0, 2.0]}), tmp_path / "b.parquet")
    assert not any("no time" in note for note in read(tmp_path / "b.parquet").notes)
    pq.write_table(pa.table({"tactile": [None, *frames[1:]]}), tmp_path / "c.parquet")
    with pytest.raises(FormatError, match="column tactile: says nothing in rows 0 to 2"):
        read(tmp_path / "c.parquet")


def test_what_holds_nothing_is_no_recording(tmp_path: Path) -> None:
    """A column of one value packs without bounds."""
    rows = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(1 << 20, np.float32)), 1024)
    with pq.ParquetWriter(tmp_path / "a.parquet", pa.schema({"tactile": rows.type}), compression="zstd") as writer:
        for _ in range(100):
            writer.write_table(pa.table({"tactile": rows}))
    with pytest.raises(FormatError, match=r"tactile: holds 419430400 bytes in a file of \d+; nothing is so empty"):
        read(tmp_path / "a.parquet", shape=(32, 32))


def test_cut_off_and_no_parquet(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    write(Recording({"pad": Pad(FRAMES)}), path)
    whole = path.read_bytes()
    for length in (9, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"a.parquet: .*is damaged or cut off"):
            read(path)
    path.write_bytes(b"hello")
    with pytest.raises(FormatError, match="does not start like Parquet"):
        read(path)


@pytest.mark.parametrize("place", range(4, 17))
def test_the_size_that_the_head_of_a_page_announces_costs_nothing(tmp_path: Path, place: int) -> None:
    path = tmp_path / "a.parquet"
    write(Recording({"pad": Pad(np.arange(60.0).reshape(3, 4, 5))}), path)
    spoilt = bytearray(path.read_bytes())
    spoilt[place : place + 5] = b"\xff" * 5
    path.write_bytes(spoilt)
    begun = time.process_time()
    with pytest.raises(FormatError):
        read(path)
    assert time.process_time() - begun < 1


SPOILED = """
import sys
from varishold import VarisholdError
from varishold.recording import read

content = open(sys.argv[1], "rb").read()
foot = len(content) - 8 - int.from_bytes(content[-8:-4], "little")
for at in range(foot, len(content) - 8):
    if content[at] == 2:
        open(sys.argv[1], "wb").write(content[:at] + bytes(1) + content[at + 1 :])
        try:
            read(sys.argv[1])
        except VarisholdError:
            pass
print("alive")
"""


def test_a_foot_that_contradicts_itself_does_not_end_the_process(tmp_path: Path) -> None:
    """pyarrow gives up altogether where the counts of a column are not of the schema's depth, if it is asked for it."""
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"pressure": pa.array(FRAMES.tolist(), pa.list_(pa.list_(pa.float32())))}), path)
    done = subprocess.run([sys.executable, "-c", SPOILED, str(path)], capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("alive\n", 0), done.stderr
