"""How much is looked at, kept, written and named at a time: each number where it begins to matter, and where it ends."""
# ruff: noqa: E501

from __future__ import annotations

import copy
import json
import math
import pickle
import sqlite3
import struct
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_recording_bound_laws import MAT5_FRAMES, lengthened, mat5, refused, zarr_array
from tests.test_recording_refusal_laws import assert_packed, labelled, mat73_file
from tests.test_recording_rosbags import bag2
from tests.test_recording_tiff_laws import SHORT, entries, strips_of, tiff

from varishold import open as open_recording
from varishold.errors import FormatError, InputError
from varishold.recording import Pad, Recording, Signals, read, write
from varishold.recording import formats as registry
from varishold.recording.formats import FORMATS, Format, format_of, lerobot_writing
from varishold.recording.formats import mat5 as mat5_format
from varishold.recording.formats.format import Options
from varishold.recording.formats.lerobot_writing import _stats
from varishold.recording.formats.matlab_arrays import place_of
from varishold.recording.formats.packings import from_zstd
from varishold.recording.formats.rosbag2 import Database
from varishold.recording.formats.taxel_columns import pads_of, taxel_columns
from varishold.recording.formats.zarr_arrays import ZarrGroups
from varishold.recording.formats.zarr_store import FolderStore, ZipStore
from varishold.recording.grasp_csv import iter_grasp_table, read_grasp_table, write_grasp_table
from varishold.recording.grasp_table import GraspTable
from varishold.recording.inspection import faults_of, summarize
from varishold.recording.mcap import PadFacts, TopicWriter, gather
from varishold.recording.mcap.coding import MessageCoder
from varishold.recording.mcap.container import opened_mcap
from varishold.recording.mcap.image_message import image_pixels
from varishold.recording.mcap.topics import SCHEMAS
from varishold.recording.stored import Stored, StoredPad
from varishold.sensor import Sensor

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)
MB = 1 << 20


# Which format it is


@pytest.mark.parametrize(("at", "known"), [(65536 - 7, "zarr-zip"), (65536 - 6, "npz")])
def test_a_format_is_known_by_the_first_64_kilobytes(tmp_path: Path, at: int, known: str) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"PK\x03\x04".ljust(at, b"x") + b".zgroup" + bytes(99))
    assert format_of(path) is FORMATS[known]


@pytest.mark.parametrize(("size", "by"), [(64 * MB, "read"), (64 * MB + 1, "open")])
def test_what_is_larger_than_64_megabytes_is_read_in_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int, by: str
) -> None:
    asked: list[str] = []
    stored = Stored({"pad": StoredPad(FRAMES)})

    def opened(*_: object) -> Stored:
        asked.append("open")
        return stored

    def whole(*_: object) -> Recording:
        asked.append("read")
        return stored.whole()

    path = tmp_path / "a"
    path.touch()
    lengthened(path, size)
    for folder in (False, True):
        known = Format("x", (), lambda *_: True, whole, open=opened, folder=folder)
        monkeypatch.setattr(registry, "format_of", lambda _: known)  # noqa: B023
        asked.clear()
        assert read(path).n_frames == 5
        assert asked == ["read" if folder else by]


@pytest.mark.parametrize(
    ("head", "told"),
    [
        (b"\0\0\0\x18ftypisom", "is a video, "),
        (b"RIFF....", "is a video, "),
        (b"BZh9", "is compressed with bzip2"),
        (b" \n", "is empty"),
    ],
)
def test_what_only_wraps_recordings_is_told(tmp_path: Path, head: bytes, told: str) -> None:
    path = tmp_path / "a"
    path.write_bytes(head)
    refused(lambda: read(path), f"{path}: {told}")
    if b"ftyp" in head:
        path.write_bytes(b"1,2\n" + b"ftyp"[:3] + head[8:])
        assert format_of(path) is FORMATS["csv"]


def test_shapes_have_two_sides_of_one_at_least(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(6)[:, None])
    assert read(tmp_path / "a.npy", shape=(1, 1)).n_frames == 6
    for shape, told in (
        ((0, 1), "at least 1 x 1, got 0 x 1"),
        ((1, 0), "at least 1 x 1, got 1 x 0"),
        ((1, 2, 3), "(rows, columns), got (1, 2, 3)"),
    ):
        with pytest.raises(InputError) as error:
            read(tmp_path / "a.npy", shape=shape)  # type: ignore[arg-type]
        assert str(error.value) == f"shape must be {told}"


# Zarr


def test_64_megabytes_of_the_pieces_read_last_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = zarr_array(tmp_path / "a", [2, 48 * MB], [2, 16 * MB])
    (path / "c/0").mkdir(parents=True)
    for k in range(3):
        (path / f"c/0/{k}").touch()
        lengthened(path / f"c/0/{k}", 32 * MB)
    asked: list[str] = []
    whole = FolderStore.read
    monkeypatch.setattr(FolderStore, "read", lambda self, key, most: asked.append(key) or whole(self, key, most))
    (held,) = ZarrGroups(FolderStore(path)).datasets.values()
    asked.clear()
    for first in (0, 1):
        assert held[first : first + 1].shape == (1, 48 * MB)
    assert asked == ["c/0/0", "c/0/1", "c/0/2", "c/0/2"]


@pytest.mark.parametrize("spare", [0, 1])
def test_an_array_of_zarr_says_16_megabytes_of_itself(tmp_path: Path, spare: int) -> None:
    path = zarr_array(tmp_path / "a", [5, 3, 4], [5, 3, 4])
    text = (path / "zarr.json").read_text()
    (path / "zarr.json").write_text(text.ljust(16 * MB + spare))
    groups = ZarrGroups(FolderStore(path))
    if spare:
        refused(lambda: groups.datasets, f"{path / 'zarr.json'}: is larger than {16 * MB} bytes; such a piece never is")
    else:
        assert groups.datasets["array",].shape == (5, 3, 4)


@pytest.mark.parametrize(
    ("n_bytes", "in_file", "fits"),
    [(256 * MB, 0, True), (256 * MB + 1, 0, False), (300, MB, True), (300, MB - 1, False)],
)
def test_an_archive_of_zarr_unpacks_to_so_much(tmp_path: Path, n_bytes: int, in_file: int, fits: bool) -> None:
    """What its list says is counted, before anything is unpacked."""
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("x", bytes(max(0, in_file - 1000)))
        if in_file:
            made.comment = b"c" * (in_file - made.fp.tell() - 47 - 22)
    content = bytearray(path.read_bytes())
    if in_file:
        assert len(content) == in_file
        n_bytes *= MB
    struct.pack_into("<I", content, content.rindex(b"PK\x01\x02") + 24, n_bytes)
    path.write_bytes(content)
    if fits:
        ZipStore(path).close()
    else:
        refused(lambda: ZipStore(path), f"{path}: would unpack to {n_bytes} bytes; nothing measured is so empty")


# MATLAB


@pytest.mark.parametrize(("many", "fits"), [(4094, True), (4095, False)])
def test_so_many_variables_of_matlab_are_read(tmp_path: Path, many: int, fits: bool) -> None:
    """With the frames, and with looking for one more."""
    from tests.test_recording_matlab import matrix

    path = mat5(tmp_path / "a.mat", MAT5_FRAMES, matrix(17, (1, 1), "f", b"") * many)
    if fits:
        assert read(path).n_frames == 5
    else:
        refused(lambda: read(path), f"{path}: holds more than 4096 variables")


@pytest.mark.parametrize(
    ("size", "most"), [(0, 256 * MB), (MB, 300 * MB), (MB + 1, 300 * MB + 300), (16 * MB, 1 << 32)]
)
def test_a_file_of_matlab_unpacks_to_so_much(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int, most: int
) -> None:
    from tests.test_recording_matlab import element

    asked: list[int] = []

    class Unpacker:
        unconsumed_tail, eof = b"more", False

        def decompress(self, body: bytes, length: int) -> bytes:
            asked.append(length)
            return b"abc"

    path = mat5(tmp_path / "a.mat", element(15, b"packed"))
    if size:
        lengthened(path, size)
    monkeypatch.setattr(mat5_format.zlib, "decompressobj", Unpacker)
    refused(
        lambda: read(path), f"{path}: would unpack {path.stat().st_size} bytes to more than 3; nothing measured is so"
    )
    assert asked == [most]


@pytest.mark.parametrize(("many", "fits"), [(1 << 16, True), ((1 << 16) + 1, False)])
def test_a_cell_of_matlab_73_has_so_many_entries(tmp_path: Path, many: int, fits: bool) -> None:
    def fill(file: Any) -> None:
        labelled(file, "presses/label", np.empty((1, many), h5py.ref_dtype), MATLAB_class=np.bytes_("cell"))
        file["press"] = np.zeros((1, 5), np.int32)

    path = mat73_file(tmp_path / "a.mat", fill)
    with pytest.raises(FormatError) as error:
        read(path)
    # Of those that are few enough each is looked at.
    assert (f"presses/label: has {many} entries, 65536 are the most" in str(error.value)) != fits


@pytest.mark.parametrize(("n", "chunks"), [(511, None), (512, (16, 16, 512)), (1100, (16, 16, 512))])
def test_pieces_of_matlab_have_a_quarter_of_a_megabyte(tmp_path: Path, n: int, chunks: Any) -> None:
    frames = np.arange(n * 256).reshape(n, 16, 16).astype(np.uint16)
    write(Recording({"pad": Pad(frames)}), tmp_path / "a.mat")
    with h5py.File(tmp_path / "a.mat") as file:
        assert_packed(file["pressure"], chunks)
    np.testing.assert_array_equal(read(tmp_path / "a.mat").pads["pad"].frames, frames)


def test_names_of_matlab_have_63_letters_at_most() -> None:
    taken: set[tuple[str, ...]] = set()
    long = "a" * 80
    assert place_of(f"pressure.{long}", taken) == ("a" * 61, "pressure")
    assert place_of(f"pressure.{long}b", taken) == (f"{'a' * 58}_2", "pressure")
    assert place_of(f"pressure.{long}c", taken) == (f"{'a' * 58}_3", "pressure")
    assert place_of(f"signals.{long}", taken) == ("signals", "a" * 61)
    assert place_of(f"signals.{long}b", taken) == ("signals", f"{'a' * 58}_2")
    assert place_of("pressure.1 x", taken) == ("x1_x", "pressure")
    assert place_of("pressure.", taken) == ("pressure",)
    assert place_of("pressure.signals", taken) == ("signals_2", "pressure")
    assert place_of("unit.signals.a", taken) == ("signal_units", "a")
    assert place_of("names.signals.a", taken) == ("signal_names", "a")
    assert place_of("mark.frame", taken) == ("marks", "frame")


# Bags of ROS 2


def test_messages_of_a_database_are_given_a_thousand_at_a_time(tmp_path: Path) -> None:
    (path,) = bag2(tmp_path / "bag").glob("*.db3")
    with sqlite3.connect(path) as base:
        base.execute("DELETE FROM messages")
        rows = [(1, -5 if k == 0 else k, struct.pack("<I", k) * (k % 3)) for k in range(1025)]
        base.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
        base.executemany(
            "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles, type_description_hash) VALUES (?, 'a/B', 'cdr', '', '')",
            [(f"/{k}",) for k in range(4096)],
        )
    base.close()
    database = Database(path)
    try:
        batches = list(database.batches())
        assert [len(batch.heads) for batch in batches] == [1024, 1]
        contents = [batch.content[a:b] for batch in batches for a, b in zip(batch.starts, batch.stops, strict=True)]
        assert contents == [data for *_, data in rows]
        times = [n for batch in batches for n in batch.heads["log_ns"].tolist()]
        assert times == [max(0, stamp) for _, stamp, _ in rows]
        again = list(database.batches(batches[1].place))
        assert [batch.content for batch in again] == [batches[1].content]
        # Of more topics nobody hears.
        assert len(database.channels) == 4096
        assert database._base.getlimit(sqlite3.SQLITE_LIMIT_LENGTH) == 256 * MB
    finally:
        database.close()
        database.close()


@pytest.mark.parametrize("spare", [0, 1])
def test_what_a_bag_says_of_itself_has_16_megabytes(tmp_path: Path, spare: int) -> None:
    folder = bag2(tmp_path / "bag")
    said = folder / "metadata.yaml"
    said.write_bytes(said.read_bytes().ljust(16 * MB + spare))
    if spare:
        with pytest.raises(InputError, match=r"metadata\.yaml"):
            read(folder)
    else:
        assert read(folder).n_frames == 40


def test_a_folder_of_databases_needs_no_words_of_its_own(tmp_path: Path) -> None:
    folder = bag2(tmp_path / "bag")
    (folder / "metadata.yaml").unlink()
    assert read(folder).n_frames == 40
    (folder / "more.db3.zstd").write_bytes(b"x")
    refused(lambda: read(folder), f"{folder / 'more.db3.zstd'}: is compressed with zstd; unpack it first (unzstd)")
    (folder / "more.db3.zstd").rename(folder / "more.mcap")
    with pytest.raises(InputError, match="is a folder"):
        read(folder)


# Pictures


def test_a_page_of_tiff_has_so_many_entries_and_strips(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    page = entries(FRAMES[0], [24], 3)
    more = {1000 + k: (SHORT, [k]) for k in range(4096 - len(page) - 1)}
    path.write_bytes(tiff([page | more], [strips_of(FRAMES[0], 3, "<")]))
    np.testing.assert_array_equal(read(path).pads["pad"].frames[0], FRAMES[0])
    tall = (np.arange((1 << 16) + 1) % 251).astype(np.uint8)[:, None]
    for rows, fits in ((1 << 16, True), ((1 << 16) + 1, False)):
        frame = tall[:rows]
        page = entries(frame, [1] * rows, 1)
        path.write_bytes(tiff([page], [strips_of(frame, 1, "<")]))
        if fits:
            np.testing.assert_array_equal(read(path).pads["pad"].frames[0], frame)
        else:
            refused(lambda: read(path), f"page 0 has 0 strips of 1 rows for {rows} rows")


@pytest.mark.parametrize(("exponent", "fits"), [(17, True), (18, False)])
def test_zstd_may_look_back_128_megabytes(exponent: int, fits: bool) -> None:
    data = b"hello"
    packed = b"\x28\xb5\x2f\xfd\0" + bytes([exponent << 3]) + struct.pack("<I", len(data) << 3 | 1)[:3] + data
    if fits:
        assert from_zstd(packed, 5) == data
    else:
        with pytest.raises(ValueError, match=r"memory|window|large"):
            from_zstd(packed, 5)


# MCAP


@pytest.mark.parametrize("dtype", ["i4", "u4", "i8", "u8", ">i4"])
@pytest.mark.parametrize("bits", [24, 53])
@pytest.mark.parametrize("over", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
def test_whole_numbers_are_floats_as_far_as_those_hold_them(dtype: str, bits: int, over: int, sign: int) -> None:
    value = sign * ((1 << bits) + over)
    kind = np.dtype(dtype)
    if not np.iinfo(kind).min <= value <= np.iinfo(kind).max:
        return
    encoding, pixels = image_pixels(np.array([[0, value]], kind))
    expected = {(24, 0): "32FC1", (24, 1): "64FC1", (53, 0): "64FC1", (53, 1): "8UC8"}[bits, over]
    assert encoding == expected
    coded = {"32FC1": "<f4", "64FC1": "<f8"}.get(expected, kind.newbyteorder("<"))
    assert np.frombuffer(pixels, coded).tolist() == [0, value]


def test_floats_are_written_in_the_fewest_bytes_that_hold_them() -> None:
    for dtype, values, expected in (
        ("f8", [[0.5, math.nan]], "32FC1"),
        ("f8", [[0.1, 0.5]], "64FC1"),
        ("f8", [[1e300, 0.5]], "64FC1"),
        ("f4", [[0.1, 0.5]], "32FC1"),
        ("f2", [[0.1, 0.5]], "32FC1"),
        ("u1", [[1, 2]], "mono8"),
        ("u2", [[1, 2]], "16UC1"),
        ("i2", [[-1, 2]], "32FC1"),
    ):
        assert image_pixels(np.array(values, dtype))[0] == expected


@pytest.mark.parametrize(
    ("stamp_ns", "sec", "nanosec"),
    [
        (0, 0, 0),
        (-1, -1, 999_999_999),
        (2**31 * 10**9 - 1, 2**31 - 1, 999_999_999),
        (2**31 * 10**9, 2**31 - 1, 999_999_999),
        (-(2**31) * 10**9, -(2**31), 0),
        (-(2**31) * 10**9 - 1, -(2**31), 0),
    ],
)
def test_a_stamp_holds_so_many_seconds(stamp_ns: int, sec: int, nanosec: int) -> None:
    from tests.test_recording_mcap import STORE

    coder = MessageCoder()
    for values in (np.ones((2, 3)), np.ones(4)):
        kind, message = coder.coded(PadFacts("a frame"), values, stamp_ns)
        told = STORE.deserialize_cdr(message, kind)
        assert (told.header.stamp.sec, told.header.stamp.nanosec) == (sec, nanosec)
        assert (told.header.frame_id, told.height, told.width) == (
            "a frame",
            *(values.shape if values.ndim > 1 else (1, 4)),
        )
        assert (told.step, told.is_bigendian, told.encoding) == (told.width * 4, 0, "32FC1")


@pytest.mark.parametrize(
    ("log_ns", "device_ns", "logged", "sent"),
    [
        (5, None, 5, 5),
        (5, 7, 5, 7),
        (-1, -1, 0, 0),
        (5, -1, 5, 5),
        (2**63 - 1, 2**63 - 1, 2**63 - 1, 2**63 - 1),
        (2**63, 2**63, 2**63 - 1, 2**63 - 1),
        (5, 2**63, 5, 5),
        (5, 0, 5, 0),
    ],
)
def test_times_of_messages_have_63_bits(
    tmp_path: Path, log_ns: int, device_ns: int | None, logged: int, sent: int
) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = TopicWriter(file)
        writer.describe(PadFacts("s", kind="signals"))
        writer.reading({"s": np.ones(2)}, log_ns=log_ns, device_ns=device_ns, sequence=2**32 + 3)
        writer.reading({"s": np.ones(2)}, log_ns=log_ns, device_ns=device_ns)
        writer.finish()
    with opened_mcap(tmp_path / "a.mcap") as contents:
        (batch,) = contents.batches()
        assert batch.heads["log_ns"].tolist() == [logged] * 2
        assert batch.heads["sent_ns"].tolist() == [sent] * 2
        # Readings that tell no number are counted.
        assert batch.heads["sequence"].tolist() == [3, 1]
        stamps = [channel.metadata for channel in contents.channels.values()]
        stamp = "host" if device_ns is None else "device"
        assert stamps == [{"stamp": stamp, "counted": "yes", "type": "<f8"}, {"stamp": stamp, "type": "<f8"}]


def test_what_has_no_time_ticks_a_hundred_times_a_second(tmp_path: Path) -> None:
    write(Recording({"x": Pad(FRAMES)}), tmp_path / "a.mcap")
    series = gather(tmp_path / "a.mcap").pads["x"]
    assert series.log_ns.tolist() == [k * 10**7 for k in range(5)]
    assert (series.stamp, read(tmp_path / "a.mcap").time_s) == ("none", None)


def test_types_in_types_are_parted_by_a_line_of_eighty() -> None:
    for text in SCHEMAS.values():
        lines = [line for line in text.splitlines() if line.startswith("=")]
        assert set(lines) <= {"=" * 80}
        assert len(lines) == text.count("MSG: ")


# What a person is told


def test_a_gap_is_longer_than_one_and_a_half_intervals() -> None:
    def gaps(*steps: float) -> Any:
        time_s = np.concatenate([[0.0], np.cumsum([1.0] * 60 + list(steps))])
        return summarize(Recording({"pad": Pad(np.ones((len(time_s), 1, 2)))}, time_s)).time

    assert gaps(1.5).n_gaps == 0
    assert gaps(1.5625).gaps == ((61, 1.5625),)
    assert gaps(1.5625).n_lacking == 1
    many = gaps(*(2.0 + k for k in range(25)))
    assert (many.n_gaps, many.n_lacking, len(many.gaps)) == (25, sum(range(1, 26)), 20)
    assert many.gaps[0] == (85, 26.0)
    assert many.gaps[-1] == (66, 7.0)
    even = gaps(*(3.0 for _ in range(3)))
    assert even.gaps == ((61, 3.0), (62, 3.0), (63, 3.0))
    one = summarize(Recording({"pad": Pad(np.ones((1, 1, 2)))}, np.array([3.0]))).time
    assert (one.rate_hz, one.jitter_s, one.begin_s, one.duration_s, one.n_lacking) == (None, None, 3.0, 0.0, 0)


def test_faults_are_told_in_their_number() -> None:
    def told(*time_s: float) -> tuple[str, ...]:
        rng = np.random.default_rng(0)
        return faults_of(Recording({"pad": Pad(rng.random((len(time_s), 2, 2)))}, np.array(time_s)))

    assert told(0, 1, 2, 3) == ()
    assert told(0, 1, 2, 2, 2, 3) == ("time stands still 2 times, first at frame 3",)
    assert told(0, 1, 2, 1, 0, 1, 2) == ("time goes back 2 times, first at frame 3",)
    assert told(0, 1, 2, 4, 5, 6) == ("about one frame lacking in one gap, the longest of 2 s before frame 3",)
    assert told(0, 1, 2, 4, 5, 8) == ("about 3 frames lacking in 2 gaps, the longest of 3 s before frame 5",)


def test_a_summary_says_all_of_a_recording() -> None:
    rng = np.random.default_rng(0)
    frames = rng.integers(1, 99, (9, 3, 4))
    field = np.ones((3, 4), bool)
    field[0, 0] = False
    valid = field.copy()
    valid[2, 2] = False
    frames[:, 1, 1] = 7
    pad = Pad(frames, field=field, valid=valid, pitch_m=0.1)
    recording = Recording(
        {"pad": pad},
        unit="kPa",
        sensor="S",
        source="f",
        notes=("n",),
        press=np.full(9, -1),
        press_columns={"a": np.zeros(2)},
    )
    found = summarize(recording)
    assert (found.source, found.unit, found.sensor, found.n_frames) == ("f", "kPa", "S", 9)
    assert (found.n_presses, found.press_columns, found.notes) == (0, ("a",), ("n",))
    (one,) = found.pads
    # Marked as broken, or showing that it is.
    assert (one.n_taxels, one.n_broken, one.on_grid) == (11, 2, True)
    works = valid.copy()
    works[1, 1] = False
    assert (one.low, one.high) == (frames[:, works].min(), frames[:, works].max())
    assert found.to_dict()["pads"][0]["n_broken"] == 2
    assert summarize(Recording({"pad": pad})).n_presses is None
    assert summarize(Recording({"pad": pad}, press=np.arange(9) // 3)).n_presses == 3


# Blocks


@given(st.integers(1, 9), st.integers(1, 12))
def test_blocks_of_any_size_joined_are_the_whole(n: int, size: int) -> None:
    recording = Recording(
        {"pad": Pad(np.arange(n * 4).reshape(n, 2, 2))},
        np.arange(n) / 2,
        press=np.arange(n) // 2,
        signals={"s": Signals(np.arange(n)[:, None])},
    )
    from varishold.recording.blocks import Blocks

    opened = Blocks(recording)
    blocks = list(opened.blocks(size))
    assert [block.n_frames for block in blocks] == [size] * (n // size) + ([n % size] if n % size else [])
    np.testing.assert_array_equal(np.concatenate([b.pads["pad"].frames for b in blocks]), recording.pads["pad"].frames)
    np.testing.assert_array_equal(np.concatenate([b.signals["s"].values for b in blocks])[:, 0], np.arange(n))
    assert len(opened.frames) == n
    assert [opened.frame_at(k / 4) for k in range(2 * n + 1)] == [min(n, -(-k // 2)) for k in range(2 * n + 1)]
    for wanted, told in (
        (slice(2, 2), "there are no frames 2 to 2"),
        (slice(n, None), f"there are no frames {n} to {n}"),
    ):
        if n > 2:
            with pytest.raises(InputError) as error:
                opened.frames[wanted]
            assert str(error.value) == f"{told}: they are numbered 0 to {n - 1}"
    with pytest.raises(InputError, match=r"^n_frames must be a whole number from 1, got 0$"):
        next(opened.blocks(0))
    for wrong in (1.5, None, True):
        with pytest.raises(InputError, match=r"^n_frames must be a whole number from 1, got"):
            next(opened.blocks(wrong))
    for time_s in ("x", np.nan, None, 1j):
        with pytest.raises(InputError, match=r"^time_s must be a number of seconds, got"):
            opened.frame_at(time_s)
    with pytest.raises(InputError, match=r"^frames are taken as frames\[a:b\], got"):
        opened.frames[::2]


def test_a_block_has_4096_frames_where_nobody_says_how_many(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((4097, 1, 2), np.uint8))
    with open_recording(tmp_path / "a.npy") as opened:
        assert [block.n_frames for block in opened.blocks()] == [4096, 1]
        with pytest.raises(InputError, match="a recording without times has no frame at a time"):
            opened.frame_at(0)


@pytest.mark.parametrize(("n_bytes", "mapped"), [(128 * MB, False), (128 * MB + 1, True)])
def test_what_takes_more_than_128_megabytes_is_mapped(
    monkeypatch: pytest.MonkeyPatch, n_bytes: int, mapped: bool
) -> None:
    class Far:
        shape, dtype = (n_bytes, 1, 1), np.dtype(np.uint8)

        def __getitem__(self, wanted: slice) -> np.ndarray:
            raise AssertionError

    stored = Stored({"pad": StoredPad(Far())})
    asked = []
    monkeypatch.setattr(Stored, "_mapped", lambda self: asked.append("mapped") or self)
    monkeypatch.setattr(Stored, "part", lambda self, first, last: (first, last))
    assert stored.whole() == (0, n_bytes)
    assert asked == (["mapped"] if mapped else [])


def test_parquet_is_written_in_groups_of_4096_rows(tmp_path: Path) -> None:
    recording = Recording({"pad": Pad(np.arange(4097 * 2, dtype=np.uint16).reshape(4097, 1, 2))})
    write(recording, tmp_path / "a.parquet")
    told = pq.ParquetFile(tmp_path / "a.parquet").metadata
    assert [told.row_group(k).num_rows for k in range(told.num_row_groups)] == [4096, 1]
    np.testing.assert_array_equal(read(tmp_path / "a.parquet").pads["pad"].frames, recording.pads["pad"].frames)


@given(st.integers(1, 30), st.integers(1, 9))
def test_what_is_said_of_a_feature_does_not_depend_on_how_many_rows_are_looked_at(n: int, group: int) -> None:
    values = np.arange(n * 2).reshape(n, 2) ** 2
    whole = _stats(values, [2])
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(lerobot_writing, "GROUP", group)
        parts = _stats(values, [2])
    for name, each in whole.items():
        np.testing.assert_allclose(parts[name], each, atol=1e-6)
    np.testing.assert_allclose(whole["std"], values.std(axis=0), atol=1e-6)


def test_episodes_of_any_length_come_back_from_files_of_a_data_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lerobot_writing, "GROUP", 4)
    press = np.repeat(np.arange(4), [1, 4, 5, 9])
    recording = Recording({"pad": Pad(np.arange(19 * 6).reshape(19, 2, 3))}, np.arange(19) / 10, press=press)
    write(recording, tmp_path / "a.lerobot")
    again = read(tmp_path / "a.lerobot")
    np.testing.assert_array_equal(again.pads["pad"].frames, recording.pads["pad"].frames)
    table = pq.read_table(tmp_path / "a.lerobot/data/chunk-000/file-000.parquet")
    assert table["index"].to_pylist() == [*range(19)]
    assert table["frame_index"].to_pylist() == [k for many in (1, 4, 5, 9) for k in range(many)]
    assert table["episode_index"].to_pylist() == press.tolist()
    np.testing.assert_allclose(table["timestamp"].to_pylist(), np.array(table["frame_index"].to_pylist()) / 10)


# Tables


def test_numbered_columns_are_taxels_from_four_on() -> None:
    def told(*names: str) -> list[tuple[str, tuple[int, ...]]]:
        return [(group.name, group.sides) for group in taxel_columns(names)]

    assert told("p.0.0", "p.0.1", "x") == [("p", (1, 2))]
    assert told("p_1", "p_2") == [("p", (2,))]
    assert told("p_2", "p_3") == told("p_0") == told("switch_1", "switch_2") == []
    assert told("p[0][0]", "p[0][1]") == [("p", (1, 2))]
    assert told("p_0_1", "p_0_2", "p_0_3") == [("p_0", (3,))]
    for n, words in (
        (
            4,
            "columns p_1 to p_4 (4) may be pads; say the shape of a pad, (rows, columns), or call them NAME.ROW.COLUMN",
        ),
        (3, "no columns are taxels; call them NAME.ROW.COLUMN, from 0 or from 1 on"),
    ):
        refused(lambda: pads_of(Path("f"), [f"p_{k + 1}" for k in range(n)], Options()), f"f: line 1: {words}")  # noqa: B023
    names = ["p.0.0", "p.0.1", "p.1.0", "q.1.1", "q.1.2"]
    refused(
        lambda: pads_of(Path("f"), names, Options()),
        "f: line 1: columns p.0.0 to p.1.0 are the pad p, but that of taxel 1.1 is missing",
    )
    refused(
        lambda: pads_of(Path("f"), [f"p_{k}" for k in range(6)], Options((2, 2))),
        "f: line 1: no 4 columns are a pad of 2 x 2; there are p_0 to p_5 (6)",
    )
    five = [f"{pad}_{k}" for pad in "abcde" for k in range(4)]
    refused(
        lambda: pads_of(Path("f"), five, Options()),
        "columns a_0 to a_3 (4), b_0 to b_3 (4), c_0 to c_3 (4), d_0 to d_3 (4) may",
    )
    found = pads_of(Path("f"), five, Options((2, 2)))
    assert [(group.name, shape) for group, shape in found] == [(pad, (2, 2)) for pad in "abcde"]


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.integers(-99, 99), st.sampled_from(["", "a", "=b", "'=c", "d;e", 'f"g', "ü"]), st.booleans()),
        min_size=1,
        max_size=12,
    ),
    st.integers(1, 60),
)
def test_a_table_is_the_same_in_blocks_of_any_bytes(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[int, str, bool]], block: int
) -> None:
    path = tmp_path_factory.mktemp("table") / "a.csv"
    table = GraspTable(
        {
            "force_n.x": np.array([n / 4 for n, *_ in rows]),
            "object": np.array([text for _, text, _ in rows]),
            "switch.a": np.array([on for *_, on in rows]),
        }
    )
    write_grasp_table(table, path)
    parts = list(iter_grasp_table(path, block=block))
    again = GraspTable.joined(parts)
    line = 2
    for part in parts:
        assert part.first_line == line
        line += len(part)
    for whole in (again, read_grasp_table(path)):
        assert whole.columns == table.columns
        for name in table.columns:
            assert whole.cells[name].tolist() == table.cells[name].tolist()
    assert [again.where(k) for k in range(len(rows))] == [f"{path}: line {k + 2}" for k in range(len(rows))]


def test_joined_rows_know_their_file_and_line() -> None:
    one = GraspTable({"a": np.arange(2.0)}, "one", 5)
    two = GraspTable({"a": np.arange(3.0)}, "two", 2)
    both = GraspTable.joined([one, two])
    assert [both.where(k) for k in range(6)] == [
        "one: line 5",
        "one: line 6",
        "two: line 2",
        "two: line 3",
        "two: line 4",
        "one and 1 more: line 10",
    ]
    assert both.source == "one and 1 more"
    assert GraspTable.joined([one]) is one
    with pytest.raises(InputError, match=r"^two: there is no column 'b', which one has$"):
        GraspTable.joined([GraspTable({"a": np.arange(2.0), "b": np.arange(2.0)}, "one"), two])
    with pytest.raises(InputError, match=r"^three: column 'a' is text, and numbers in one$"):
        GraspTable.joined([one, GraspTable({"a": np.array(["x"])}, "three")])
    with pytest.raises(InputError, match=r"^one: line 5, column 'a' must be a number, got 'x'$"):
        GraspTable({"a": np.array(["x", "y"])}, "one", 5).numbers("a")
    assert np.isnan(GraspTable({"a": np.array([math.nan])}).numbers("a", unknown=True)).all()


def test_json_says_what_zarr_2_calls_nothing(tmp_path: Path) -> None:
    """Zarr 2 writes numbers that JSON has not."""
    for fill, expected in (("NaN", math.nan), ("Infinity", math.inf), ("-Infinity", -math.inf), ("null", 0.0)):
        path = tmp_path / fill.strip("-")
        path.mkdir(exist_ok=True)
        said = {
            "zarr_format": 2,
            "shape": [2],
            "chunks": [2],
            "dtype": "<f4",
            "order": "C",
            "compressor": None,
            "filters": None,
        }
        text = json.dumps(said)[:-1] + f', "fill_value" : {fill}}}'
        (path / ".zarray").write_text(text)
        (held,) = ZarrGroups(FolderStore(path)).datasets.values()
        np.testing.assert_array_equal(held[:], np.full(2, expected, np.float32))


def test_recordings_sensors_and_tables_are_pickled_and_copied() -> None:
    """So that they go to other processes: a press that is learned from is a recording."""
    frames = np.random.default_rng(0).normal(5, 1, (6, 3, 4))
    recording = Recording(
        {"palm": Pad(frames, pitch_m=2e-3)},
        time_s=np.arange(6) / 50,
        unit="kPa",
        press=np.array([0, 0, 0, 1, 1, 1]),
        press_columns={"label": np.array(["cup", "can"])},
        signals={"shear": Signals(np.zeros((6, 2)), names=("x", "y"))},
    )
    sensor = Sensor(rest=20.0, span=200.0, saturation=0.9, gains=np.full((3, 4), 1.1), calibration={"kind": "even"})
    table = GraspTable({"object": np.array(["cone", "cube"]), "switch.v1": np.array([True, False])})
    for other in (pickle.loads(pickle.dumps(recording)), copy.deepcopy(recording)):
        np.testing.assert_array_equal(other.pads["palm"].frames, frames)
        assert (other.unit, other.pads["palm"].pitch_m) == ("kPa", (2e-3, 2e-3))
        assert other.presses.frames == recording.presses.frames
        assert list(other.presses.columns["label"]) == ["cup", "can"]
        assert other.signals["shear"].names == ("x", "y")
    again = pickle.loads(pickle.dumps(sensor))
    np.testing.assert_allclose(again.undo(frames[0]).frame, sensor.undo(frames[0]).frame)
    assert (again.saturation, dict(again.calibration)) == (0.9, {"kind": "even"})
    assert pickle.loads(pickle.dumps(table)).labels("object").tolist() == ["cone", "cube"]
    assert len(pickle.loads(pickle.dumps(recording.presses))) == 2
