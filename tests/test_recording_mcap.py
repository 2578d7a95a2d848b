"""MCAP: a recording comes back as it was, other readers see the same, and what is cut off or damaged is told."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

pytest.importorskip("mcap", reason="MCAP needs the extra live")
pytest.importorskip("rosbags", reason="files of others need the extra live")

from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from varishold.errors import FormatError, InputError
from varishold.recording import Pad, Recording, Signals, read, write
from varishold.recording.mcap import PadFacts, TopicWriter, gather, gathering
from varishold.recording.mcap.clock import nanoseconds, seconds
from varishold.recording.mcap.image_message import image_pixels
from varishold.recording.mcap.topics import MARKS, SCHEMAS, topic_of

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = ["u1", "i1", "<u2", ">u2", "i2", "<u4", ">i4", "u8", "i8", "f2", "<f4", ">f4", "f8"]


def same(a: Recording, b: Recording) -> None:
    """Assert that two recordings say the same in the same types, wherever they come from."""
    assert (list(a.pads), a.unit, a.sensor) == (list(b.pads), b.unit, b.sensor)
    for name, pad in a.pads.items():
        other = b.pads[name]
        assert pad.frames.dtype == other.frames.dtype
        np.testing.assert_array_equal(pad.frames, other.frames)
        assert (pad.pitch_m, pad.polarity) == (other.pitch_m, other.polarity)
        for key in ("field", "valid", "positions_m"):
            assert_same(getattr(pad, key), getattr(other, key))
    assert_same(a.time_s, b.time_s)
    assert_same(a.press, b.press)
    assert list(a.press_columns) == list(b.press_columns)
    for name, column in a.press_columns.items():
        assert_same(column, b.press_columns[name])
    assert a.marks == b.marks
    assert set(a.signals) == set(b.signals)
    for name, signals in a.signals.items():
        assert (signals.names, signals.unit) == (b.signals[name].names, b.signals[name].unit)
        assert_same(signals.values, b.signals[name].values)


def assert_same(a: Any, b: Any) -> None:
    assert (a is None) == (b is None)
    if a is not None:
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)


def pad_of(draw: st.DrawFn, n: int) -> Pad:
    shape = (draw(st.integers(1, 4)), draw(st.integers(1, 4)))
    dtype = np.dtype(draw(st.sampled_from(TYPES)))
    if dtype.kind == "f":
        elements = st.floats(0, 60_000, width=8 * dtype.itemsize)  # type: ignore[arg-type]
    else:
        elements = st.integers(0, np.iinfo(dtype).max) | st.integers(0, 100)
    frames = draw(hnp.arrays(dtype, (n, *shape), elements=elements))
    if draw(st.booleans()):
        return Pad(frames[:, :1], positions_m=draw(hnp.arrays(np.float64, (shape[1], 2), elements=st.floats(-1, 1))))
    mask = draw(hnp.arrays(np.bool_, shape))
    mask[0, 0] = True
    if dtype.kind == "f":
        frames[:, ~mask] = np.nan
    masks = draw(st.sampled_from([{"valid": mask}, {"field": mask}, {"field": mask, "valid": mask}]))
    pitch = draw(st.none() | st.tuples(st.floats(1e-4, 1), st.floats(1e-4, 1)))
    return Pad(frames, **masks, pitch_m=pitch, polarity=draw(st.sampled_from(["up", "down"])))


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    n = draw(st.integers(1, 5))
    names = st.sampled_from(["pad", "left", "finger 2", "θ/1", "varishold/press", "pads/varishold/press"])
    pads = {name: pad_of(draw, n) for name in draw(st.lists(names, min_size=1, max_size=3, unique=True))}
    times = st.floats(-1e9, 1e9) | st.floats(allow_nan=False, allow_infinity=False) | st.integers(0, 99)
    time = draw(st.none() | hnp.arrays(np.float64, n, elements=times.map(float)))
    press, columns = None, {}
    if draw(st.booleans()):
        press = draw(st.sampled_from([np.zeros(n, int), np.arange(n)[::-1] - 1, np.repeat(7, n), np.full(n, -1)]))
        rows = max(int(press.max()) + 1, 0) + draw(st.integers(0, 2))
        for name, kind in {"label": "<U3", "angle_rad.x": "f8", "n": "i2", "on": "?", "f": ">f4", "big": "u8"}.items():
            if draw(st.booleans()):
                columns[name] = draw(hnp.arrays(np.dtype(kind), rows))
    unit, sensor = draw(st.sampled_from(["raw", "kPa", "N/cm²"])), draw(st.sampled_from(["", "S θ", "two\nlines"]))
    marks = draw(st.lists(st.tuples(st.integers(0, n - 1), st.sampled_from(["cone", "", "θ"])), max_size=3).map(sorted))
    signals = draw(st.just({}) | signals_of(n))
    return Recording(pads, time, unit, sensor, press=press, press_columns=columns, signals=signals, marks=tuple(marks))


@st.composite
def signals_of(draw: st.DrawFn, n: int) -> dict[str, Signals]:
    width, dtype = draw(st.integers(1, 3)), draw(st.sampled_from(TYPES))
    names = draw(st.sampled_from([(), ("Bx", "By", "θ")[:width]]))
    return {
        "shear.palm": Signals(draw(hnp.arrays(np.dtype(dtype), (n, width))), names, draw(st.sampled_from(["raw", "N"])))
    }


@settings(deadline=None)
@given(recordings())
def test_npz_keeps_all_but_polarity(tmp_path_factory: pytest.TempPathFactory, recording: Recording) -> None:
    pads = {name: replace(pad, polarity="up") for name, pad in recording.pads.items()}
    upright = replace(recording, pads=pads)
    path = tmp_path_factory.mktemp("npz") / "a.npz"
    write(upright, path)
    same(upright, read(path))


@settings(deadline=None)
@given(recordings())
def test_a_recording_comes_back_exactly(tmp_path_factory: pytest.TempPathFactory, recording: Recording) -> None:
    folder = tmp_path_factory.mktemp("mcap")
    write(recording, folder / "a.mcap")
    again = read(folder / "a.mcap")
    same(recording, again)
    assert again.notes == ()
    write(again, folder / "b.mcap")
    assert (folder / "a.mcap").read_bytes() == (folder / "b.mcap").read_bytes()


def of_numbers(values: Any, dtype: str) -> np.ndarray:
    return np.array([values], dtype)


@pytest.mark.parametrize(
    ("values", "dtype", "encoding"),
    [
        ([0, 255], "u1", "mono8"),
        ([0, 65535], "u2", "16UC1"),
        ([0, 65535], ">u2", "16UC1"),
        ([-128, 127], "i1", "32FC1"),
        ([-32768, 32767], "i2", "32FC1"),
        ([1.5, 65504], "f2", "32FC1"),
        ([1e-30, 3e38], "f4", "32FC1"),
        ([0.5, np.nan], "f8", "32FC1"),
        ([0.1, 1], "f8", "64FC1"),
        ([1e300, 1], "f8", "64FC1"),
        ([-(2**24), 2**24], "i4", "32FC1"),
        ([0, 2**31 - 1], "i4", "64FC1"),
        ([0, 2**32 - 1], "u4", "64FC1"),
        ([0, 2**53], "i8", "64FC1"),
        ([-(2**63), 2**63 - 1], "i8", "8UC8"),
        ([0, 2**64 - 1], "u8", "8UC8"),
    ],
)
def test_each_type_is_written_as_viewers_draw_it_where_that_loses_nothing(
    tmp_path: Path, values: list[float], dtype: str, encoding: str
) -> None:
    frame = of_numbers(values, dtype)
    assert image_pixels(frame)[0] == encoding
    file = tmp_path / "a.mcap"
    with file.open("wb") as opened:
        writer = TopicWriter(opened)
        writer.reading({"pad": frame}, log_ns=0)
        writer.finish()
    got = gather(file).pads["pad"].values
    assert got.dtype == frame.dtype
    np.testing.assert_array_equal(got[0], frame)


@given(st.floats(-(2.0**31), 2.0**31 - 1))
def test_times_are_held_to_half_a_nanosecond_and_exactly_where_floats_are_coarser(time_s: float) -> None:
    ns = nanoseconds(time_s)
    assert abs(ns - int(time_s) * 10**9 - (time_s - int(time_s)) * 1e9) <= 0.5 + 1e-6
    back = float(seconds(np.array([ns]))[0])
    assert abs(back - time_s) <= 0.5e-9
    if abs(time_s) > 1e7:
        assert back == time_s
    assert nanoseconds(back) == ns


@given(st.integers(0, 10**7), st.sampled_from([1, 100, 1000, 10**6]))
def test_times_of_ticks_come_back_exactly(ticks: int, rate: int) -> None:
    assert seconds(np.array([nanoseconds(ticks / rate)]))[0] == ticks / rate


@given(st.lists(st.sampled_from(["a", "varishold/press", "pads/varishold/press", "pads/a", "θ", "a/b"]), unique=True))
def test_no_two_pads_have_one_topic(names: list[str]) -> None:
    topics = [topic_of(name) for name in names]
    assert len(set(topics)) == len(names)
    assert not any(topic.startswith("/varishold/") for topic in topics)


RNG = np.random.default_rng(5)
FRAMES = RNG.integers(0, 4000, (7, 3, 4)).astype(np.uint16)
HAND = Recording(
    {"palm": Pad(FRAMES, pitch_m=(0.002, 0.003)), "tip": Pad(FRAMES[:, :2, :2].astype(np.float32) / 3)},
    time_s=12.5 + np.arange(7) / 100,
    unit="kPa",
    sensor="hand",
    press=np.array([-1, 0, 0, -1, 1, 1, 1]),
    press_columns={"label": np.array(["cone", "ball"])},
)


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    write(HAND, tmp_path / "hand.mcap")
    return tmp_path / "hand.mcap"


def test_the_reference_reader_finds_the_same(hand: Path) -> None:
    with hand.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert reader.get_header().profile == "ros2"
        assert {channel.topic for channel in summary.channels.values()} == {"/palm", "/tip", "/varishold/press"}
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        found = list(reader.iter_messages(topics=["/palm"]))
        metadata = {
            told.metadata["pad"]: told.metadata for told in reader.iter_metadata() if told.name == "varishold.pad"
        }
    assert metadata["palm"] == {
        "pad": "palm",
        "topic": "/palm",
        "kind": "pressure",
        "unit": "kPa",
        "sensor": "hand",
        "polarity": "up",
        "pitch_m": "[0.002, 0.003]",
    }
    for k, (schema, channel, message) in enumerate(found):
        assert schema is not None
        assert (schema.name, channel.message_encoding) == ("sensor_msgs/msg/Image", "cdr")
        assert message.data.endswith(FRAMES[k].tobytes())
        assert message.log_time == nanoseconds(HAND.time_s[k])  # type: ignore[index]


def test_rosbags_reads_the_same_images(hand: Path) -> None:
    with AnyReader([hand]) as reader:
        seen: dict[str, list[Any]] = {}
        for connection, _, data in reader.messages():
            seen.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    for k, message in enumerate(seen["/palm"]):
        assert (message.header.frame_id, message.encoding, message.is_bigendian) == ("palm", "16UC1", 0)
        assert (message.height, message.width, message.step) == (3, 4, 8)
        assert message.header.stamp.sec == 12
        assert message.header.stamp.nanosec == 500_000_000 + k * 10_000_000
        np.testing.assert_array_equal(message.data.view("<u2").reshape(3, 4), FRAMES[k])
    for k, message in enumerate(seen["/tip"]):
        assert message.encoding == "32FC1"
        np.testing.assert_array_equal(message.data.view("<f4").reshape(2, 2), HAND.pads["tip"].frames[k])
    assert '"label": "cone"' in seen["/varishold/press"][0].data


@pytest.mark.parametrize("kind", SCHEMAS)
def test_message_types_are_those_of_ros(kind: str) -> None:
    theirs, _ = STORE.generate_msgdef(kind, ros_version=2)
    assert [line for line in SCHEMAS[kind].splitlines() if line] == [line for line in theirs.splitlines() if line]


def bag(path: Path, topic: str, kind: str, messages: list[Any], stamps_ns: list[int]) -> Path:
    """Write a bag as rosbags does; return its MCAP file."""
    with BagWriter(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection(topic, kind, typestore=STORE)
        for stamp_ns, message in zip(stamps_ns, messages, strict=True):
            writer.write(connection, stamp_ns, STORE.serialize_cdr(message, kind))
    return next(path.glob("*.mcap"))


def image(stamp_ns: int, frame: np.ndarray, encoding: str, *, step: int = 0, large_first: bool = False) -> Any:
    rows, cols = frame.shape
    data = np.ascontiguousarray(frame).view(np.uint8).reshape(rows, -1)
    step = step or data.shape[1]
    padded = np.full((rows, step), 170, np.uint8)
    padded[:, : data.shape[1]] = data
    t = STORE.types
    stamp = t["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 10**9))
    header = t["std_msgs/msg/Header"](stamp, "a frame")
    return t["sensor_msgs/msg/Image"](header, rows, cols, encoding, int(large_first), step, padded.ravel())


@pytest.mark.parametrize(
    ("encoding", "dtype", "step", "large_first"),
    [
        ("mono8", "u1", 0, False),
        ("8UC1", "u1", 16, False),
        ("mono16", "<u2", 0, False),
        ("16UC1", ">u2", 0, True),
        ("16SC1", "<i2", 12, False),
        ("32SC1", ">i4", 0, True),
        ("32FC1", "<f4", 32, False),
        ("64FC1", ">f8", 0, True),
        ("32FC", "<f4", 0, False),
    ],
)
def test_images_of_others(tmp_path: Path, encoding: str, dtype: str, step: int, large_first: bool) -> None:
    frames = (FRAMES % 100).astype(dtype)
    stamps = [10**15 + k * 5_000_000 for k in range(len(frames))]
    messages = [
        image(stamp, frame, encoding, step=step, large_first=large_first)
        for stamp, frame in zip(stamps, frames, strict=True)
    ]
    recording = read(bag(tmp_path / "bag", "/left/skin", "sensor_msgs/msg/Image", messages, stamps))
    assert list(recording.pads) == ["left/skin"]
    np.testing.assert_array_equal(recording.pads["left/skin"].frames, frames)
    assert recording.time_s is not None
    np.testing.assert_array_equal(recording.time_s, np.array(stamps) / 1e9)
    assert recording.unit == "raw"


def test_colour_pictures_are_no_frames(tmp_path: Path) -> None:
    frame = np.zeros((2, 6), np.uint8)
    message = image(0, frame, "rgb8")
    message.width = 2
    path = bag(tmp_path / "bag", "/camera", "sensor_msgs/msg/Image", [message], [1_500_000_000])
    with pytest.raises(FormatError, match=r"frames: /camera \(sensor_msgs/msg/Image\): its encoding 'rgb8'"):
        read(path)


def multi_array(values: np.ndarray, dims: tuple[int, ...]) -> Any:
    t = STORE.types
    dim = t["std_msgs/msg/MultiArrayDimension"]
    sized = [dim("", size, int(np.prod(dims[k:]))) for k, size in enumerate(dims)]
    return t["std_msgs/msg/Float32MultiArray"](t["std_msgs/msg/MultiArrayLayout"](sized, 0), values.astype(np.float32))


def test_arrays_of_others_by_their_layout_or_by_the_shape_that_is_said(tmp_path: Path) -> None:
    frames = FRAMES.astype(np.float32) / 7
    stamps = [10**18 + k * 10**7 for k in range(len(frames))]
    for name, dims in (("laid", (3, 4)), ("plain", ())):
        messages = [multi_array(frame.ravel(), dims) for frame in frames]
        path = bag(tmp_path / name, "/skin", "std_msgs/msg/Float32MultiArray", messages, stamps)
        got = read(path, shape=None if dims else (3, 4))
        np.testing.assert_array_equal(got.pads["skin"].frames, frames)
        assert got.time_s is not None
        np.testing.assert_array_equal(got.time_s, np.array(stamps) / 1e9)
        assert got.notes == ("time is that of the machine that recorded, for the sensor sends none",)


TACTILE = """std_msgs/Header header
sensor_msgs/ChannelFloat32[] sensors
"""


def test_messages_of_any_package_are_understood_by_their_shape(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(TACTILE, "tactile_msgs/msg/TactileState"))
    t = store.types
    channel = t["sensor_msgs/msg/ChannelFloat32"]
    with BagWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        skin = writer.add_connection("/hand", "tactile_msgs/msg/TactileState", typestore=store)
        for k in range(5):
            header = t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](100, k * 10**7), "")
            parts = [
                channel("tip", FRAMES[k, 0].astype(np.float32)),
                channel("palm", FRAMES[k].ravel() / np.float32(2)),
            ]
            message = t["tactile_msgs/msg/TactileState"](header, parts)
            writer.write(skin, 10**18 + k, store.serialize_cdr(message, "tactile_msgs/msg/TactileState"))
    path = next((tmp_path / "bag").glob("*.mcap"))
    got = gather(path)
    assert list(got.pads) == ["tip", "palm"]
    np.testing.assert_array_equal(got.pads["tip"].values, FRAMES[:5, 0])
    np.testing.assert_array_equal(got.pads["palm"].values, FRAMES[:5].reshape(5, -1) / np.float32(2))
    assert got.pads["palm"].stamp_ns.tolist() == [100 * 10**9 + k * 10**7 for k in range(5)]
    recording = read(path)
    assert recording.time_s is not None
    np.testing.assert_array_equal(recording.time_s, [100 + k / 100 for k in range(5)])


def test_topics_of_json_and_pads_that_share_a_name(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        left, right, words = (writer.register_channel(name, "json", 0) for name in ("/left", "/right", "/words"))
        for k in range(3):
            for channel in (left, right):
                told = {"sensors": [{"name": "tip", "values": [[k, channel], [2, 3]]}]}
                writer.add_message(channel, k, json.dumps(told).encode(), k)
        writer.add_message(words, 3, b'{"said": "hello"}', 3)
        writer.finish()  # type: ignore[no-untyped-call]
    got = read(path)
    assert list(got.pads) == ["left/tip", "right/tip"]
    assert got.pads["right/tip"].frames[:, 0].tolist() == [[k, right] for k in range(3)]
    assert "passed over: /words (json)" in got.notes


def test_a_topic_of_others_that_changes_its_shape_is_passed_over(tmp_path: Path) -> None:
    messages = [multi_array(np.ones(n), ()) for n in (4, 4, 5)]
    path = bag(tmp_path / "bag", "/cloud", "std_msgs/msg/Float32MultiArray", messages, [1, 2, 3])
    with pytest.raises(FormatError, match=r"/cloud \(std_msgs/msg/Float32MultiArray\): pad pad has shape \(5,\)"):
        read(path)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_any_packing(tmp_path: Path, hand: Path, compression: CompressionType, chunked: bool) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=300, compression=compression, use_chunking=chunked, index_types=IndexType.NONE)
        writer.start()
        ids: dict[int, int] = {}
        with hand.open("rb") as source:
            reader = make_reader(source)
            for told in reader.iter_metadata():
                writer.add_metadata(told.name, told.metadata)
            for schema, channel, message in reader.iter_messages():
                assert schema is not None
                if channel.id not in ids:
                    number = writer.register_schema(schema.name, schema.encoding, schema.data)
                    ids[channel.id] = writer.register_channel(channel.topic, "cdr", number, channel.metadata)
                writer.add_message(
                    ids[channel.id], message.log_time, message.data, message.publish_time, message.sequence
                )
        writer.finish()  # type: ignore[no-untyped-call]
    same(HAND, read(path))


def stream(chunks: int = 3, readings: int = 2) -> bytes:
    """What a recorder has written of some chunks, without an end."""
    made = io.BytesIO()
    writer = TopicWriter(made)
    writer.describe(PadFacts("palm", pitch_m=(0.001, 0.001)))
    for k in range(chunks * readings):
        writer.reading({"palm": np.full((2, 2), k, np.uint8)}, log_ns=k * 10**7, device_ns=k * 10**7, sequence=k)
        if k % readings == readings - 1:
            writer.flush()
    return made.getvalue()


def test_cut_at_every_byte_all_whole_chunks_are_kept_and_it_is_said(tmp_path: Path) -> None:
    content = stream()
    path = tmp_path / "cut.mcap"
    counts, told = [], []
    for size in range(len(content) + 1):
        path.write_bytes(content[:size])
        try:
            got = gather(path)
        except InputError as error:
            told.append(str(error))
            counts.append(0)
            continue
        counts.append(len(got.pads["palm"].values))
        np.testing.assert_array_equal(got.pads["palm"].values[:, 1, 1], np.arange(counts[-1]))
        assert "has no end" in got.early
    assert all(str(path) in each and "\n" not in each for each in told)
    assert counts == sorted(counts)
    assert sorted(set(counts)) == [0, 2, 4, 6]
    assert counts[-1] == 6
    assert "has no end" in read(path).remarks[0]


def test_bytes_that_never_reached_the_disk_are_zeros_and_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "zeros.mcap"
    path.write_bytes(stream()[: len(stream(chunks=2)) + 100] + bytes(4000))
    assert read(path).n_frames == 4


def test_no_flipped_bit_is_read_as_something_else(tmp_path: Path) -> None:
    path = tmp_path / "flipped.mcap"
    write(Recording({"palm": Pad(FRAMES[:3, :1, :1], pitch_m=0.002)}), path)
    content = path.read_bytes()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    # What stands before the data's end is under a checksum.
    (chunk,) = summary.chunk_indexes
    covered = chunk.chunk_start_offset + chunk.chunk_length + chunk.message_index_length
    whole, told = gather(path), []
    for at in range(len(content)):
        spoilt = bytearray(content)
        spoilt[at] ^= 1 << (at % 8)
        path.write_bytes(spoilt)
        try:
            got = gather(path)
        except FormatError as error:
            told.append(at)
            assert str(error).startswith(f"{path}: is damaged at byte ")  # noqa: PT017
        else:
            assert got.pads["palm"].facts.record() == whole.pads["palm"].facts.record()
            np.testing.assert_array_equal(got.pads["palm"].values, whole.pads["palm"].values)
    assert set(range(8, covered)) <= set(told)


def packed(content: bytes, *, size: int | None = None, compression: str = "zstd", crc: int = 0) -> bytes:
    """A file of one chunk."""
    import zstandard

    data = zstandard.compress(content) if compression == "zstd" else content
    size = len(content) if size is None else size
    body = struct.pack("<QQQI", 0, 0, size, crc) + struct.pack("<I", len(compression)) + compression.encode()
    body += struct.pack("<Q", len(data)) + data
    end = struct.pack("<BQI", 15, 4, 0) + struct.pack("<BQQQI", 2, 20, 0, 0, 0)
    return b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body + end + b"\x89MCAP0\r\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (packed(bytes(1 << 25)), "would unpack to 33554432; nothing measured is so empty"),
        (packed(b"", size=1 << 60), "nothing measured is so empty"),
        (packed(bytes(100), size=99), "99 bytes are announced"),
        (packed(bytes(100), size=101, compression=""), "101 bytes are announced, 100 there"),
        (packed(bytes(100), compression="gzip"), "packed with 'gzip'"),
        (packed(bytes(100), crc=7), "its checksum is not that of its bytes"),
        (packed(b"\x05" + struct.pack("<Q", 22) + bytes(22)), "of channel 0, which was not described"),
        (packed(b"\x05" + struct.pack("<Q", 99) + bytes(22)), "a record of kind 5 and 99 bytes stands at byte 9 of 31"),
        (packed(b"\x04" + struct.pack("<Q", 20) + b"\x01\0\x07\0" + bytes(16)), "channel 1 is of schema 7"),
        (packed(b""), "holds no message"),
        (b"\x89MCAP0\r\n", "holds no reading: the file has no end"),
    ],
)
def test_what_is_damaged_is_told_with_its_place(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bad.mcap"
    path.write_bytes(content)
    with pytest.raises(FormatError) as told:
        read(path)
    assert str(told.value).startswith(f"{path}: ")
    assert message in str(told.value)


def test_many_chunks_cannot_unpack_to_more_than_anything_measured(tmp_path: Path) -> None:
    one = packed(b"\x80" + struct.pack("<Q", (1 << 24) - 9) + bytes((1 << 24) - 9))
    chunk = one[8 : -(13 + 29 + 8)]
    path = tmp_path / "bombs.mcap"
    path.write_bytes(one[:8] + chunk * 40 + one[-(13 + 29 + 8) :])
    with pytest.raises(FormatError, match="would unpack to more than"):
        read(path)


def test_pads_with_times_of_their_own_show_their_newest_reading(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(10):
            if k >= 2 and k % 3 == 2:
                writer.reading({"slow": np.full((1, 1), k, np.uint8)}, log_ns=k * 10**9 - 1)
            writer.reading({"fast": np.full((2, 2), k, np.uint8)}, log_ns=k * 10**9)
        writer.finish()
    got = read(path)
    assert got.pads["fast"].frames[:, 0, 0].tolist() == list(range(2, 10))
    assert got.pads["slow"].frames[:, 0, 0].tolist() == [2, 2, 2, 5, 5, 5, 8, 8]
    assert got.time_s is not None
    np.testing.assert_array_equal(got.time_s, np.arange(2, 10))
    assert got.notes == (
        "pad slow was read 3 times, pad fast 10 times: each frame shows its newest reading",
        "2 frames are left out, which came before every pad was read",
        "time is that of the machine that recorded, for the sensor sends none",
    )


def test_pads_that_never_overlap_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(4):
            writer.reading({"first": np.zeros((1, 2), np.uint8)}, log_ns=k)
        writer.reading({"late": np.zeros((1, 2), np.uint8)}, log_ns=9)
        writer.finish()
    with pytest.raises(FormatError, match="pad 'late' is first read after the last reading of pad 'first'"):
        read(path)


def test_taxels_without_a_number_are_left_out_and_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for k in range(3):
            writer.reading({"pad": np.array([[1.0, np.nan if k == 1 else 2.0, 3.0]])}, log_ns=k)
        writer.finish()
    got = read(path)
    assert got.pads["pad"].usable.tolist() == [[True, False, True]]
    assert "1 taxel is left out" in got.notes[-1]


def test_words_beside_the_readings_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = TopicWriter(file)
        writer.reading({"pad": np.ones((2, 2))}, log_ns=5)
        writer.tell(MARKS, {"label": "cone θ", "noise": float("nan"), "where": np.arange(2)}, log_ns=7)
        writer.attach("sensor.toml", b"span = 5\n")
        writer.finish()
    assert read(path).marks == ()
    held = gather(path)
    assert [(note.topic, note.log_ns, note.told) for note in held.notes] == [
        (MARKS, 7, {"label": "cone θ", "noise": "nan", "where": [0, 1]})
    ]
    assert held.attachments == {"sensor.toml": b"span = 5\n"}


def test_a_file_with_nothing_to_feel_names_what_it_holds(tmp_path: Path) -> None:
    messages = [STORE.types["std_msgs/msg/String"]("hello")]
    path = bag(tmp_path / "bag", "/chatter", "std_msgs/msg/String", messages, [1])
    with pytest.raises(FormatError, match=r"no topic with frames: /chatter \(std_msgs/msg/String\): .* not understood"):
        read(path)


def test_what_is_passed_over_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    with BagWriter(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        skin = writer.add_connection("/skin", "sensor_msgs/msg/Image", typestore=STORE)
        chatter = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=STORE)
        message = image(5, FRAMES[0], "16UC1")
        writer.write(skin, 5, STORE.serialize_cdr(message, "sensor_msgs/msg/Image"))
        words = STORE.types["std_msgs/msg/String"]("x")
        writer.write(chatter, 6, STORE.serialize_cdr(words, "std_msgs/msg/String"))
    got = read(next(folder.glob("*.mcap")))
    assert got.notes == ("passed over: /chatter (std_msgs/msg/String)",)


def test_a_shape_that_contradicts_the_file(hand: Path) -> None:
    with pytest.raises(FormatError, match="has frames of 3 x 4, not 5 x 5"):
        read(hand, shape=(5, 5))
    assert read(hand, pitch_m=0.01).pads["tip"].pitch_m == (0.01, 0.01)


def test_signals_beside_pads_are_theirs_and_alone_they_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"

    def written(names: tuple[str, ...]) -> Path:
        with path.open("wb") as file:
            writer = TopicWriter(file)
            writer.describe(PadFacts("shear.palm", kind="signals", unit="N", names=("x", "y")))
            for k in range(9):
                # Signals come three times as often.
                pads = {"palm": np.full((2, 2), k, np.uint8)} if k % 3 == 0 else {}
                pads |= {"shear.palm": np.array([-100.0, k])}
                writer.reading({name: pads[name] for name in names if name in pads}, log_ns=k, device_ns=k)
            writer.finish()
        return path

    got = read(written(("palm", "shear.palm")))
    assert (list(got.pads), list(got.signals)) == (["palm"], ["shear.palm"])
    shear = got.signals["shear.palm"]
    assert (shear.names, shear.unit, shear.values.tolist()) == (("x", "y"), "N", [[-100, 0], [-100, 3], [-100, 6]])
    assert got.time_s is not None
    assert got.time_s.tolist() == [0, 3e-9, 6e-9]
    with pytest.raises(FormatError, match=r"holds signals only \(shear\.palm\), and what touches is felt by pressure"):
        read(written(("shear.palm",)))


def test_signals_keep_their_types_and_times(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    signals = {"f": np.float32([1.5, -2]), "d": np.array([0.1, 1e300]), "n": np.array([2**62 + 1]), "u": np.uint8([9])}
    signals |= {"shear": np.arange(12, dtype=np.int16).reshape(2, 3, 2), "triples": np.ones((4, 3))}
    with path.open("wb") as file:
        writer = TopicWriter(file)
        for name in signals:
            writer.describe(PadFacts(name, kind="signals", names=tuple("abc")))
        for k in range(3):
            writer.reading(signals, log_ns=100 + k, device_ns=50 + k, sequence=2**32 + k)
        writer.finish()
    held = gather(path)
    for name, values in signals.items():
        series = held.pads[name]
        assert (series.facts.kind, series.facts.names) == ("signals", ("a", "b", "c"))
        assert series.values.dtype == values.dtype
        np.testing.assert_array_equal(series.values, np.array([values] * 3))
        assert series.stamp_ns.tolist() == [50, 51, 52]
        assert series.sequence is not None
        assert series.sequence.tolist() == [0, 1, 2]
    with AnyReader([path]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            assert message.data.tolist() == signals[connection.topic[1:]].ravel().tolist()


def test_more_than_is_read_at_once_is_told(hand: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gathering, "LARGEST_BYTES", 100)
    with pytest.raises(FormatError, match="holds more than 100 bytes of values, which are not read at once; varishold"):
        read(hand)
