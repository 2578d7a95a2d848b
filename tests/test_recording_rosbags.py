"""Bags of ROS 1 and 2: what rosbags writes is read, in every packing; damaged and hostile ones are told in one line."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tests.test_recording_mcap import image

from varishold import FormatError, InputError
from varishold.cli.app import app
from varishold.recording import read

STORE1, STORE2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_JAZZY)
FRAMES = np.random.default_rng(0).integers(0, 4000, (40, 3, 4)).astype(np.uint16)
IMAGE = "sensor_msgs/msg/Image"


def image1(k: int, frame: np.ndarray, encoding: str = "16UC1") -> Any:
    t = STORE1.types
    header = t["std_msgs/msg/Header"](k, t["builtin_interfaces/msg/Time"](5, k * 10**7), "a frame")
    return t[IMAGE](header, *frame.shape, encoding, 0, frame.shape[1] * frame.itemsize, frame.view(np.uint8).ravel())


def bag1(path: Path, packing: Any = None, *, closed: bool = True) -> Path:
    writer = Writer1(path)
    if packing is not None:
        writer.set_compression(packing)
    writer.open()
    skin = writer.add_connection("/skin", IMAGE, typestore=STORE1)
    text = writer.add_connection("/text", "std_msgs/msg/String", typestore=STORE1)
    for k, frame in enumerate(FRAMES):
        writer.write(skin, 10**18 + k * 10**7, STORE1.serialize_ros1(image1(k, frame), IMAGE))
        message = STORE1.types["std_msgs/msg/String"]("hello")
        writer.write(text, 10**18 + k * 10**7, STORE1.serialize_ros1(message, "std_msgs/msg/String"))
    writer.close()
    if not closed:
        content = bytearray(path.read_bytes())
        at = content.index(b"index_pos=") + len(b"index_pos=")
        content[at : at + 8] = bytes(8)
        path.write_bytes(content)
    return path


@pytest.mark.parametrize("packing", [None, Writer1.CompressionFormat.BZ2, Writer1.CompressionFormat.LZ4])
def test_a_bag_of_ros_1(tmp_path: Path, packing: Any) -> None:
    recording = read(bag1(tmp_path / "a.bag", packing))
    assert list(recording.pads) == ["skin"]
    assert recording.pads["skin"].frames.dtype == np.uint16
    assert (recording.pads["skin"].frames == FRAMES).all()
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [5 + k / 100 for k in range(40)]
    assert recording.notes == ("passed over: /text (std_msgs/msg/String)",)


def tactile(store: Any, k: int, *, ros1: bool) -> Any:
    t = store.types
    stamp = t["builtin_interfaces/msg/Time"](5, k * 10**7)
    header = t["std_msgs/msg/Header"](*([k] if ros1 else []), stamp, "")
    channel = t["sensor_msgs/msg/ChannelFloat32"]("palm", FRAMES[k].ravel().astype(np.float32))
    return t["tactile_msgs/msg/TactileState"](header, [channel])


def test_messages_of_any_type_are_understood_by_their_shape(tmp_path: Path) -> None:
    text = "std_msgs/Header header\nsensor_msgs/ChannelFloat32[] sensors\n"
    kind = "tactile_msgs/msg/TactileState"
    for store in (STORE1, STORE2):
        if kind not in store.types:
            store.register(get_types_from_msg(text, kind))
    with Writer1(tmp_path / "a.bag") as writer:
        skin = writer.add_connection("/hand", kind, typestore=STORE1)
        for k in range(9):
            writer.write(skin, 10**18 + k, STORE1.serialize_ros1(tactile(STORE1, k, ros1=True), kind))
    with Writer2(tmp_path / "b", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        hand = bag.add_connection("/hand", kind, typestore=STORE2)
        for k in range(9):
            bag.write(hand, 10**18 + k, STORE2.serialize_cdr(tactile(STORE2, k, ros1=False), kind))
    for path in (tmp_path / "a.bag", tmp_path / "b"):
        recording = read(path, shape=(3, 4))
        assert list(recording.pads) == ["palm"]
        assert recording.pads["palm"].frames.tolist() == FRAMES[:9].tolist()
        assert recording.time_s is not None
        assert recording.time_s.tolist() == pytest.approx([5 + k / 100 for k in range(9)])


def bag2(path: Path, plugin: StoragePlugin = StoragePlugin.SQLITE3, version: int = 9) -> Path:
    with Writer2(path, version=version, storage_plugin=plugin) as writer:
        skin = writer.add_connection("/skin", IMAGE, typestore=STORE2)
        for k, frame in enumerate(FRAMES):
            writer.write(skin, 10**18 + k * 10**7, STORE2.serialize_cdr(image(k * 10**7 + 5, frame, "16UC1"), IMAGE))
    return path


@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize("version", [8, 9])
def test_a_bag_of_ros_2_as_folder_and_as_file(tmp_path: Path, plugin: StoragePlugin, version: int) -> None:
    folder = bag2(tmp_path / "bag", plugin, version)
    inside = next(path for path in folder.iterdir() if path.suffix in (".db3", ".mcap"))
    for path in (folder, inside):
        recording = read(path)
        assert (recording.pads["skin"].frames == FRAMES).all()
        assert recording.source == str(path)
    done = CliRunner().invoke(app, ["info", str(folder), "--json"])
    assert done.exit_code == 0, done.output


def test_the_files_of_a_bag_follow_one_another(tmp_path: Path) -> None:
    folder = bag2(tmp_path / "bag")
    (first,) = folder.glob("*.db3")
    for number in (2, 10):
        shutil.copy(first, folder / f"bag_{number}.db3")
    with sqlite3.connect(folder / "bag_10.db3") as base:
        base.execute("DELETE FROM messages WHERE id > 5")
    base.close()
    assert (read(folder).pads["skin"].frames == np.concatenate([FRAMES, FRAMES, FRAMES[:5]])).all()


def test_packed_bags_of_ros_2_are_told(tmp_path: Path) -> None:
    for mode, message in ((CompressionMode.FILE, "unpack it first"), (CompressionMode.MESSAGE, "packed one by one")):
        with Writer2(tmp_path / mode.name, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
            pass
        writer = Writer2(tmp_path / f"{mode.name}2", version=9, storage_plugin=StoragePlugin.SQLITE3)
        writer.set_compression(mode, CompressionFormat.ZSTD)
        writer.open()
        skin = writer.add_connection("/skin", IMAGE, typestore=STORE2)
        writer.write(skin, 10**18, STORE2.serialize_cdr(image(5, FRAMES[0], "16UC1"), IMAGE))
        writer.close()
        with pytest.raises(FormatError, match=message):
            read(tmp_path / f"{mode.name}2")


def test_a_bag_without_its_index_is_read_as_far_as_it_is_whole(tmp_path: Path) -> None:
    path = bag1(tmp_path / "a.bag", closed=False)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 3 // 4])
    with pytest.raises(FormatError, match="holds no reading: the bag has no index"):
        read(path)
    path.unlink()
    bag1(path, closed=False)
    path.write_bytes(path.read_bytes()[:-40])
    recording = read(path)
    assert (recording.pads["skin"].frames == FRAMES).all()
    assert any("the bag has no index, as when its writer is killed" in note for note in recording.notes)
    path.unlink()
    bag1(path)
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(FormatError, match=r"is damaged at byte \d+ of \d+"):
        read(path)


def record(head: dict[str, bytes], data: bytes) -> bytes:
    fields = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in head.items())
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


START = b"#ROSBAG V2.0\n" + record({"op": b"\x03", "index_pos": struct.pack("<Q", 99)}, b" " * 9)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"#ROSBAG V1.2\n", "is a bag of another version than 2.0; rosbag fix makes one of it"),
        (START, "holds no message"),
        (START + struct.pack("<I", 1 << 30), "a record's head of 1073741824 bytes is announced"),
        (START + record({"op": b"\x05"}, b""), "is damaged at byte"),
        (
            START + record({"op": b"\x05", "size": b"\xff\xff\xff\x7f", "compression": b"bz2"}, b"x"),
            "1 byte would unpack to 2147483647; nothing measured is so empty",
        ),
        (
            START + record({"op": b"\x05", "size": bytes(4), "compression": b"xz"}, b""),
            "a chunk is packed with 'xz'; known are bz2 and lz4",
        ),
        (
            START
            + record(
                {"op": b"\x05", "size": struct.pack("<I", 36), "compression": b"none"},
                record({"op": b"\x02", "conn": bytes(4)}, b"")[:36].ljust(36, b"\0"),
            ),
            "is damaged at byte",
        ),
    ],
)
def test_hostile_bags_of_ros_1(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message) as told:
        read(path)
    assert str(told.value).startswith(str(path))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("DROP TABLE topics", "is a database without the tables topics and messages, and so no bag"),
        (
            "ALTER TABLE messages RENAME TO m; CREATE VIEW messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL "
            "SELECT x FROM c) SELECT x AS id, 1 AS topic_id, x AS timestamp, x AS data FROM c",
            "is a database without the tables topics and messages",
        ),
        ("UPDATE messages SET data = 'text' WHERE id = 3", "is damaged: a message of topic 1 at [0-9]+ ns is str"),
        ("UPDATE messages SET timestamp = 'then' WHERE id = 3", "a message of topic 1 at then ns is bytes"),
        ("UPDATE messages SET topic_id = 7 WHERE id = 3", "a message of topic 7"),
        ("UPDATE messages SET data = x'00010000' WHERE id = 3", "holds no topic with frames: /skin"),
        ("DELETE FROM messages", "holds no message"),
        ("UPDATE topics SET type = 'x'", "holds no topic with frames: /skin"),
    ],
)
def test_hostile_bags_of_ros_2(tmp_path: Path, change: str, message: str) -> None:
    folder = bag2(tmp_path / "bag")
    (path,) = folder.glob("*.db3")
    base = sqlite3.connect(path)
    base.executescript(change)
    base.commit()
    base.close()
    with pytest.raises(FormatError, match=message) as told:
        read(path)
    assert str(told.value).startswith(str(path))


def test_other_folders_and_cut_off_databases(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        read(tmp_path / "empty")
    (path,) = bag2(tmp_path / "bag").glob("*.db3")
    whole = path.read_bytes()
    for length in (50, 4096, len(whole) // 2):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"is damaged or cut off|is a database without the tables"):
            read(path)
