"""Containers of messages made by hand: what stands in them comes out, in any cut, and what cannot be is told."""

from __future__ import annotations

import bz2
import io
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from varishold.errors import FormatError, InputError
from varishold.recording.formats.rosbag1 import Bag
from varishold.recording.mcap import PadFacts, TopicWriter, container, gather
from varishold.recording.mcap.alignment import Alignment, aligned
from varishold.recording.mcap.cdr import cdr_order, string_message, string_of, text_end
from varishold.recording.mcap.chunk import check_growth
from varishold.recording.mcap.clock import nanoseconds, seconds
from varishold.recording.mcap.container import MAGIC, Contents, attachments_of
from varishold.recording.mcap.gathering import empty_words, pad_names
from varishold.recording.mcap.numbers_message import numbers_head, numbers_layout, numbers_message
from varishold.recording.mcap.topics import MARKS, facts_of

STORE = get_typestore(Stores.ROS2_JAZZY)
MB = 1 << 20


# Bags of ROS 1


def record(head: dict[str, bytes], data: bytes) -> bytes:
    fields = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in head.items())
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def start(index: int = 0) -> bytes:
    return b"#ROSBAG V2.0\n" + record({"op": b"\x03", "index_pos": struct.pack("<Q", index)}, b" " * 9)


def connection(number: int, topic: str = "/skin", kind: str = "std_msgs/String") -> bytes:
    told = record({"type": kind.encode(), "message_definition": b"string data"}, b"")
    (length,) = struct.unpack_from("<I", told)
    head = {"op": b"\x07", "conn": struct.pack("<I", number), "topic": topic.encode()}
    return record(head, told[4 : 4 + length])


def message(number: int, seconds_: int, part: int, data: bytes) -> bytes:
    head = {"op": b"\x02", "conn": struct.pack("<I", number), "time": struct.pack("<II", seconds_, part)}
    return record(head, data)


def chunk(content: bytes, packing: str = "none", size: int | None = None) -> bytes:
    pack: dict[str, Callable[[bytes], bytes]] = {"none": bytes, "bz2": bz2.compress, "lz4": lz4.frame.compress}
    size = len(content) if size is None else size
    return record(
        {"op": b"\x05", "size": struct.pack("<I", size), "compression": packing.encode()}, pack[packing](content)
    )


def opened(content: bytes) -> Bag:
    return Bag("a.bag", io.BytesIO(content))


def refused(act: Any, told: str) -> None:
    with pytest.raises(FormatError) as error:
        act()
    assert str(error.value) == told


Told = list[tuple[int, int, int, bytes]]
MESSAGES = st.lists(
    st.tuples(
        st.sampled_from([0, 3, 65535]), st.integers(0, 2**32 - 1), st.integers(0, 10**9 - 1), st.binary(max_size=9)
    ),
    max_size=6,
)


@settings(max_examples=60)
@given(st.lists(st.tuples(MESSAGES, st.sampled_from(["none", "bz2", "lz4"])), max_size=4), st.booleans())
def test_messages_of_a_bag_come_out_as_they_stand(pieces: list[tuple[Told, str]], inside: bool) -> None:
    described = b"".join(connection(number, f"/{number}") for number in (0, 3, 65535))
    content = start() + (b"" if inside else described)
    places = []
    for k, (told, packing) in enumerate(pieces):
        places.append(len(content))
        within = b"".join(message(*each) for each in told)
        content += chunk((described if inside and k == 0 else b"") + within, packing)
        content += record({"op": b"\x04", "ver": b"\1\0\0\0"}, b"an index")
    bag = opened(content)
    batches = list(bag.batches())
    assert [batch.place for batch in batches] == places
    assert bag.early == ""
    for batch, (told, _) in zip(batches, pieces, strict=True):
        assert batch.heads["channel"].tolist() == [number for number, *_ in told]
        assert batch.heads["log_ns"].tolist() == [s * 10**9 + part for _, s, part, _ in told]
        assert batch.heads["sent_ns"].tolist() == batch.heads["log_ns"].tolist()
        assert [batch.content[a:b] for a, b in zip(batch.starts, batch.stops, strict=True)] == [d for *_, d in told]
    for k, place in enumerate(places):
        again = list(bag.batches(place))
        assert [batch.place for batch in again] == places[k:]
        assert [batch.content for batch in again] == [batch.content for batch in batches[k:]]
    if pieces or not inside:
        assert {n: (c.topic, c.type, c.encoding, c.schema, c.schema_encoding) for n, c in bag.channels.items()} == {
            n: (f"/{n}", "std_msgs/msg/String", "ros1", "string data", "ros1msg") for n in (0, 3, 65535)
        }


def test_a_bag_that_breaks_off_is_read_as_far_as_it_is_whole() -> None:
    whole = start() + connection(0)
    cuts = []
    for k in range(3):
        cuts.append(len(whole))
        whole += chunk(message(0, k, 0, b"data"))
    for size in range(len(start()), len(whole)):
        bag = opened(whole[:size])
        n_whole = sum(size >= cut for cut in [*cuts[1:], len(whole)])
        assert len(list(bag.batches())) == n_whole
        clean = size in (len(start()), *cuts)
        at = max([0, *(cut for cut in cuts if cut <= size)]) or len(start())
        early = (
            "the bag has no index, as when its writer is killed: all is read that stands whole before byte "
            f"{at} of {size}"
        )
        assert bag.early == ("" if clean else early)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (connection(1 << 16), "a connection has the number 65536"),
        (connection(0, kind="a b"), "'a b' is no name of a message's type; it must be as sensor_msgs/msg/Image"),
        (chunk(message(0, 0, 0, b"")), "a message is of connection 0, which was not described before"),
        (chunk(b"abcd", size=5), "5 bytes are announced in a chunk, 4 are there"),
        (chunk(b"abcd", "bz2", size=3), "3 bytes are announced in a chunk, 4 are there"),
        (chunk(b"abcd", "lz4", size=3), "3 bytes are announced in a chunk, 4 are there"),
        (chunk(message(0, 0, 0, b"data")[:-1]), "4 bytes are announced where 3 of a chunk are left"),
        (struct.pack("<I", 9), "9 bytes are wanted where 0 are left"),
        (record({"op": b"\x04"}, b"data")[:-1], "4 bytes are announced where 3 are left"),
        (struct.pack("<I", MB + 1), "a record's head of 1048577 bytes is announced"),
        (struct.pack("<II", 8, 5) + b"op=\x05" + bytes(4), "a field of 5 bytes stands in a head of 8"),
        (struct.pack("<II", 8, 4) + b"op_\x05" + bytes(4), "a field of 4 bytes stands in a head of 8"),
        (record({}, b""), "'op'"),
        (
            record({"op": b"\x05", "size": bytes(4), "compression": b"brotli" * 4}, b""),
            f"a chunk is packed with {('brotli' * 4)[:20]!r}; known are bz2 and lz4",
        ),
    ],
)  # fmt: skip
def test_what_is_damaged_in_a_bag_with_its_index_is_told(content: bytes, told: str) -> None:
    whole = start(99) + content
    refused(
        lambda: list(opened(whole).batches()),
        f"a.bag: is damaged at byte {len(start())} of {len(whole)}: {told}",
    )


def test_a_head_of_a_bag_may_have_a_megabyte() -> None:
    bag = opened(start(99) + record({"op": b"\x04", "x": b"y" * (MB - 8 - 6)}, b"data") + connection(3))
    assert list(bag.batches()) == []
    assert list(bag.channels) == [3]


def test_a_record_of_a_bag_has_so_many_bytes_and_no_more(tmp_path: Path) -> None:
    size = (1 << 28) + 1
    head = start(99) + record({"op": b"\x07"}, b"")[:-4] + struct.pack("<I", size)
    with (tmp_path / "a.bag").open("w+b") as file:
        file.write(head)
        file.truncate(len(head) + size)
        told = f"a.bag: is damaged at byte {len(start())} of {len(head) + size}: a record of {size} bytes is announced"
        refused(lambda: list(Bag("a.bag", file).batches()), told)


@pytest.mark.parametrize(("many", "fits"), [(16, True), (17, False)])
def test_a_bag_unpacks_to_so_much_in_all(many: int, fits: bool) -> None:
    """256 MiB, where it is small."""
    one = chunk(record({"op": b"\x04"}, bytes(16 * MB - 16)), "bz2")
    bag = opened(start(99) + one * many)
    if fits:
        assert [len(batch.heads) for batch in bag.batches()] == [0] * 16
        # What was read before does not count.
        assert len(list(bag.batches())) == 16
    else:
        refused(
            lambda: list(bag.batches()), f"a.bag: would unpack to {17 * 16 * MB} bytes; nothing measured is so empty"
        )


@pytest.mark.parametrize(
    ("packed", "size", "fits"),
    [(0, 16 * MB, True), (0, 16 * MB + 1, False), (MB, 300 * MB, True), (MB, 300 * MB + 1, False)],
)
def test_a_chunk_unpacks_to_so_much(packed: int, size: int, fits: bool) -> None:
    if fits:
        check_growth(packed, size)
    else:
        with pytest.raises(ValueError, match=f"{packed} bytes would unpack to {size}; nothing measured is so empty"):
            check_growth(packed, size)


# MCAP


def mcap_file(*, chunked: bool = False, messages: int = 7, crc: bool = True, ended: bool = True, **more: Any) -> bytes:
    made = io.BytesIO()
    writer = Writer(made, compression=CompressionType.NONE, use_chunking=chunked, enable_data_crcs=crc, **more)
    writer.start("p", "l")
    writer.add_attachment(0, 0, "sensor.toml", "text/plain", b"span = 5\n")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channel = writer.register_channel("/words", "cdr", schema, {"a": "b"})
    for k in range(messages):
        writer.add_message(channel, k, string_message(f"word {k}"), k + 5, k % 3)
    if ended:
        writer.add_metadata("told", {"x": "y"})
        writer.finish()  # type: ignore[no-untyped-call]
    return made.getvalue()


def contents(data: bytes) -> Contents:
    return Contents("a.mcap", io.BytesIO(data))


def words(batch: Any) -> list[str]:
    return [string_of(batch.content[a:b]) for a, b in zip(batch.starts, batch.stops, strict=True)]


@pytest.mark.parametrize("crc", [False, True])
@pytest.mark.parametrize("many", [1, 4, 5, 8, 9])
def test_messages_outside_of_chunks_are_given_some_together(
    monkeypatch: pytest.MonkeyPatch, many: int, crc: bool
) -> None:
    monkeypatch.setattr(container, "_TOGETHER", 4)
    opened = contents(mcap_file(messages=many, crc=crc))
    batches = list(opened.batches())
    assert [word for batch in batches for word in words(batch)] == [f"word {k}" for k in range(many)]
    assert [len(batch.heads) for batch in batches] == [4] * (many // 4) + ([many % 4] if many % 4 else [])
    assert [n for batch in batches for n in batch.heads["log_ns"].tolist()] == [*range(many)]
    assert [n for batch in batches for n in batch.heads["sent_ns"].tolist()] == [*range(5, many + 5)]
    assert [n for batch in batches for n in batch.heads["sequence"].tolist()] == [k % 3 for k in range(many)]
    assert (opened.early, opened.metadata) == ("", [("told", {"x": "y"})])
    assert opened.attachments == {"sensor.toml": b"span = 5\n"}
    (channel,) = opened.channels.values()
    assert (channel.topic, channel.type, channel.encoding) == ("/words", "std_msgs/msg/String", "cdr")
    assert (channel.schema, channel.schema_encoding, channel.metadata) == ("string data\n", "ros2msg", {"a": "b"})
    for k, batch in enumerate(batches):
        again = list(opened.batches(batch.place))
        assert [words(each) for each in again] == [words(each) for each in batches[k:]]
        assert [each.place for each in again] == [each.place for each in batches[k:]]


def test_four_thousand_messages_stand_together() -> None:
    assert [len(batch.heads) for batch in contents(mcap_file(messages=4097)).batches()] == [4096, 1]


def test_of_messages_outside_of_chunks_too_all_are_kept_that_are_whole() -> None:
    whole = mcap_file(ended=False)
    opened = contents(whole)
    assert [words(batch) for batch in opened.batches()] == [[f"word {k}" for k in range(7)]]
    ends = [whole.index(f"word {k}".encode()) + 7 for k in range(7)]
    for size in range(ends[0] - 1, len(whole) + 1):
        opened = contents(whole[:size])
        found = [word for batch in opened.batches() for word in words(batch)]
        assert found == [f"word {k}" for k in range(7) if ends[k] <= size]
        at = max([end for end in ends if end <= size], default=whole.index(b"word 0") - 8 - 22 - 9)
        assert opened.early == (
            "the file has no end, as when its writer is killed: all is read that stands whole before byte "
            f"{at} of {size}"
        )


@pytest.mark.parametrize("ended", [False, True])
def test_messages_of_what_was_never_described_are_damage(ended: bool) -> None:
    whole = mcap_file(crc=False, ended=ended)
    first = whole.index(b"word 0") - 8 - 22 - 9
    # The last of seven is of another channel.
    last = whole.index(b"word 6") - 8 - 22
    spoilt = whole[:last] + b"\x07\0" + whole[last + 2 :]
    opened = contents(spoilt)
    if ended:
        told = "a message is of channel 7, which was not described before"
        refused(lambda: list(opened.batches()), f"a.mcap: is damaged at byte {first} of {len(spoilt)}: {told}")
    else:
        assert list(opened.batches()) == []
        assert f"stands whole before byte {first} of" in opened.early


def test_what_a_file_brings_beside_its_messages_is_under_its_checksum_in_any_blocks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What nobody asks for too, as an index of messages, or a large file within."""
    whole = mcap_file(chunked=True, chunk_size=20)
    large = mcap_file()
    for block in (1, 7, 16, 1 << 20):
        monkeypatch.setattr(container, "_BLOCK", block)
        assert sum(len(batch.heads) for batch in contents(whole).batches()) == 7
    for most in (0, 20, 1 << 26):
        monkeypatch.setattr(container, "_ATTACHED", most)
        opened = contents(large)
        assert sum(len(batch.heads) for batch in opened.batches()) == 7
        assert list(opened.attachments) == ([] if most < 50 else ["sensor.toml"])
    spoilt = bytearray(large)
    spoilt[large.index(b"/words")] ^= 1
    at = large.rindex(struct.pack("<BQ", 15, 4))
    refused(
        lambda: list(contents(bytes(spoilt)).batches()),
        f"a.mcap: is damaged at byte {at} of {len(large)}: the checksum of all before is not that of its bytes",
    )
    # From a place on, and of a file that tells none, nothing is compared.
    opened = contents(bytes(spoilt))
    first = next(iter(opened.batches()))
    assert len(list(opened.batches(first.place))) == 1
    assert len(list(contents(mcap_file(crc=False).replace(b"/words", b"/worms")).batches())) == 1


def attachment(name: str, data_size: int, *, crc: bool = False) -> tuple[bytes, bytes]:
    """Return what stands before and behind the bytes of a file in a file."""
    head = struct.pack("<QQ", 0, 0) + struct.pack("<I", len(name)) + name.encode() + struct.pack("<I", 0)
    head += struct.pack("<Q", data_size)
    return struct.pack("<BQ", 9, len(head) + data_size + 4) + head, bytes(4)


@pytest.mark.parametrize(("length", "kept"), [(1 << 26, True), ((1 << 26) + 1, False)])
def test_a_file_within_has_64_megabytes_at_most(tmp_path: Path, length: int, kept: bool) -> None:
    size = length - len(attachment("x", 0)[0]) + 9 - 4
    before, behind = attachment("x", size)
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        file.write(MAGIC + before)
        file.seek(size, 1)
        file.write(behind + struct.pack("<BQI", 15, 4, 0) + struct.pack("<BQQQI", 2, 20, 0, 0, 0) + MAGIC)
    held = attachments_of(path)
    assert {name: len(data) for name, data in held.items()} == ({"x": size} if kept else {})


def test_the_bytes_of_a_file_within_are_those_of_its_checksum() -> None:
    whole = mcap_file(crc=False)
    at = whole.index(b"span = 5\n")
    spoilt = whole[:at] + b"spin" + whole[at + 4 :]
    first = whole.index(struct.pack("<B", 9), 8)
    refused(
        lambda: list(contents(spoilt).batches()),
        f"a.mcap: is damaged at byte {first} of {len(whole)}: the checksum of the file 'sensor.toml' in it is not that "
        "of its bytes",
    )
    # 0 tells none.
    silent = spoilt[: at + 9] + bytes(4) + spoilt[at + 13 :]
    opened = contents(silent)
    list(opened.batches())
    assert opened.attachments == {"sensor.toml": b"spin = 5\n"}


def end(*, crc: int = 0, summary: int = 0, length: int = 4, footer: int = 20) -> bytes:
    return struct.pack("<BQI", 15, length, crc) + struct.pack("<BQQQI", 2, footer, summary, 0, 0) + MAGIC


BROKEN = b"\0" + bytes(8)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (MAGIC + end(crc=5), "a.mcap: is damaged at byte 8 of 58: the checksum of all before is not that of its bytes"),
        (MAGIC + end(crc=zlib.crc32(MAGIC)), ""),
        (MAGIC + end(), ""),
        # What is told of a summary leads nowhere, so that no checksum is known.
        (MAGIC + end(crc=5, summary=9), ""),
        (MAGIC + end(crc=5, summary=20), ""),
        (MAGIC + end(crc=5, summary=21), "a.mcap: is damaged at byte 8 of 58: the checksum"),
        (MAGIC + end(crc=5, summary=22), ""),
        (MAGIC + BROKEN + end(footer=21), "no end"),
        (MAGIC + BROKEN + end()[:-1], "no end"),
        (MAGIC + BROKEN + end()[:-8] + b"\x89MCAP1\r\n", "no end"),
        (b"\x89MCAP1\r\n" + end(), "a.mcap: is damaged at byte 0 of 58: it does not begin like MCAP"),
        (MAGIC + BROKEN + end(), "a.mcap: is damaged at byte 8 of 67: a record of kind 0 and 0 bytes begins where"),
        (MAGIC + b"x" + struct.pack("<Q", 51) + end(), "a.mcap: is damaged at byte 8 of 67: a record of kind 120 and"),
        (MAGIC + struct.pack("<BQ", 200, 9) + bytes(9) + end(), ""),
    ],
)  # fmt: skip
def test_the_end_of_a_file_is_what_it_must_be(data: bytes, told: str) -> None:
    opened = contents(data)
    if told == "no end":
        assert list(opened.batches()) == []
        assert opened.early
    elif told:
        with pytest.raises(FormatError) as error:
            list(opened.batches())
        assert str(error.value).startswith(told)
    else:
        assert list(opened.batches()) == []
        assert opened.early == ""


@pytest.mark.parametrize(("many", "fits"), [(16, True), (17, False)])
def test_a_file_unpacks_to_so_much_in_all(many: int, fits: bool) -> None:
    content = b"\x80" + struct.pack("<Q", 16 * MB - 9) + bytes(16 * MB - 9)
    data = zstandard.compress(content)
    body = (
        struct.pack("<QQQI", 0, 0, len(content), 0)
        + struct.pack("<I", 4)
        + b"zstd"
        + struct.pack("<Q", len(data))
        + data
    )
    opened = contents(MAGIC + (struct.pack("<BQ", 6, len(body)) + body) * many + end())
    if fits:
        assert len(list(opened.batches())) == 16
        assert len(list(opened.batches())) == 16
    else:
        refused(
            lambda: list(opened.batches()),
            f"a.mcap: would unpack to more than {17 * 16 * MB} bytes; nothing measured is so empty",
        )


# What messages hold


def test_rosbags_finds_the_axes_of_signals() -> None:
    for shape, labels in (((3,), ["signal"]), ((3, 2), ["taxel", "axis"]), ((2, 3, 4), ["row", "column", "axis"])):
        for kind, dtype in (("Float32", "<f4"), ("Float64", "<f8"), ("Int64", "<i8"), ("UInt64", "<u8")):
            values = np.arange(np.prod(shape)).reshape(shape).astype(dtype)
            coded = numbers_message(numbers_head(shape), values)
            told = STORE.deserialize_cdr(coded, f"std_msgs/msg/{kind}MultiArray")
            assert [(dim.label, dim.size) for dim in told.layout.dim] == list(zip(labels, shape, strict=True))
            assert [dim.stride for dim in told.layout.dim] == [int(np.prod(shape[k:])) for k in range(len(shape))]
            assert told.layout.data_offset == 0
            np.testing.assert_array_equal(told.data, values.ravel())
            assert bytes(STORE.serialize_cdr(told, f"std_msgs/msg/{kind}MultiArray"))[: len(coded)] == coded


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("sizes", [(), (5,), (2, 3)])
@pytest.mark.parametrize("label", ["", "a", "ab", "abc", "abcd"])
def test_arrays_of_others_are_laid_out_in_either_order_of_bytes(
    order: str, kind: str, sizes: tuple[int, ...], label: str
) -> None:
    n = int(np.prod(sizes)) if sizes else 4
    dtype = np.dtype(f"{order}{kind}")
    values = np.arange(n).astype(dtype)

    def made(n_told: int, offset: int, data: bytes) -> bytes:
        head = struct.pack(f"{order}I", len(sizes))
        for size in sizes:
            head += bytes(-len(head) % 4) + struct.pack(f"{order}I", len(label) + 1) + label.encode() + b"\0"
            head += bytes(-len(head) % 4) + struct.pack(f"{order}II", size, 1)
        head += struct.pack(f"{order}II", offset, n_told)
        return (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + head + bytes(-len(head) % dtype.itemsize) + data

    whole = made(n, 0, values.tobytes())
    layout = numbers_layout(whole, dtype)
    assert layout.shape == (sizes or (n,))
    assert layout.dtype == dtype
    np.testing.assert_array_equal(np.frombuffer(whole[len(layout.head) :], layout.dtype), values)
    shown = " x ".join(map(str, sizes))
    for n_told, offset, data in ((n, 1, values), (n + 1, 0, values), (n, 0, values[:-1])):
        with pytest.raises(ValueError, match="its layout says") as error:
            numbers_layout(made(n_told, offset, data.tobytes()), dtype)
        assert str(error.value) == (
            f"its layout says {shown or n_told} numbers from {offset} on, {n_told} are announced, {data.nbytes} bytes "
            "are there"
        )
    for short in range(4, len(layout.head) - 8):
        with pytest.raises(ValueError, match=r"end before its numbers begin|a text of"):
            numbers_layout(whole[:short], dtype)


def test_texts_of_messages_end_where_they_say() -> None:
    for text in ("", "a", "abc θ"):
        assert string_of(string_message(text)) == text
        large = b"\0\0\0\0" + struct.pack(">I", len(text.encode()) + 1) + text.encode() + b"\0"
        assert string_of(large) == text
    assert text_end(b"\2\0\0\0ab", 0, "<") == 6
    with pytest.raises(ValueError, match=r"^a text of 3 bytes is announced, 2 are there$"):
        text_end(b"\3\0\0\0ab", 0, "<")
    with pytest.raises(ValueError, match=r"^its 7 bytes hold no text$"):
        string_of(b"\0\1\0\0abc")
    with pytest.raises(ValueError, match=r"^begins with 00 02 00 00, which is no plain CDR$"):
        cdr_order(b"\0\2\0\0\1")


@given(st.floats(-(2**31), 2**31))
def test_a_time_and_its_nanoseconds_differ_by_half_of_one(time_s: float) -> None:
    whole, part = divmod(nanoseconds(time_s), 10**9)
    assert abs((whole - np.floor(time_s)) + (part / 1e9 - (time_s - np.floor(time_s)))) < 1e-9
    assert seconds(np.array([nanoseconds(time_s)]))[0] == pytest.approx(time_s, abs=1e-9)


# What is said of pads


TIMES = st.dictionaries(
    st.sampled_from(["palm", "tip", "wrist"]), st.lists(st.integers(0, 30), min_size=1, max_size=8), min_size=1
)


@settings(max_examples=300)
@given(TIMES, st.booleans(), st.data())
def test_frames_are_aligned_alike_at_once_and_some_at_a_time(
    drawn: dict[str, list[int]], alike: bool, data: st.DataObject
) -> None:
    """Where a clock was set back, too."""
    if alike:
        drawn = {name: next(iter(drawn.values())) for name in drawn}
    times = {name: np.array(each) for name, each in drawn.items()}
    leaders = data.draw(st.lists(st.sampled_from(sorted(times)), min_size=1, unique=True))
    refusal = ""
    try:
        shown, remarks = aligned(times, leaders)
    except InputError as error:
        refusal = str(error)
    if refusal:
        with pytest.raises(InputError, match=f"^{re.escape(refusal)}$"):
            Alignment({name: each.copy() for name, each in times.items()}, leaders)
        return
    alignment = Alignment({name: each.copy() for name, each in times.items()}, leaders)
    n = len(next(iter(shown.values())))
    assert (alignment.n_frames, alignment.remarks) == (n, remarks)
    assert alignment.leading == max(leaders, key=lambda name: len(times[name]))
    assert alignment.begun == len(times[alignment.leading]) - n
    first = data.draw(st.integers(0, n))
    last = data.draw(st.integers(first, n))
    for name, each in shown.items():
        assert alignment.shown(name, first, last).tolist() == each[first:last].tolist()


def test_a_frame_shows_what_came_at_its_very_time() -> None:
    shown, remarks = aligned({"a": np.array([0, 10, 20, 30]), "b": np.array([10, 30])})
    assert {name: each.tolist() for name, each in shown.items()} == {"a": [1, 2, 3], "b": [0, 0, 1]}
    assert remarks == (
        "pad b was read 2 times, pad a 4 times: each frame shows its newest reading",
        "1 frame is left out, which came before every pad was read",
    )
    with pytest.raises(InputError, match=r"^pad 'b' is first read after the last reading of pad 'a'$"):
        aligned({"a": np.array([0, 10]), "b": np.array([11])})


def test_pads_of_others_are_called_by_themselves_or_by_their_topic() -> None:
    names = pad_names([("/a", ""), ("/b/c/", "tip"), ("/d", "tip"), ("/e", "palm"), ("/", ""), ("/f", "shear.pad")])
    assert list(names.values()) == ["a", "b/c/tip", "d/tip", "palm", "pad", "shear.f"]


def test_it_is_said_why_there_is_no_reading() -> None:
    assert empty_words({}, {}, "") == "holds no message"
    assert empty_words({}, {}, "it breaks off") == "holds no reading: it breaks off"
    passed = {f"/{k}": "t" for k in range(9)}
    told = empty_words(passed, dict.fromkeys(passed, "why"), "")
    assert told == "holds no topic with frames: " + "; ".join(f"/{k} (t): why" for k in range(8))


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ({"kind": "sound"}, "p: kind must be pressure or signals, got 'sound'"),
        ({"polarity": "left"}, "p: polarity must be up or down, got 'left'"),
        ({"field": "[[1, 0], [1]]"}, "p: field must be numbers, equally many in each row, got '[[1, 0], [1]]'"),
        ({"valid": "[]"}, "p: valid must be numbers, equally many in each row, got '[]'"),
        ({"positions_m": '"far"'}, "p: positions_m must be numbers, equally many in each row, got 'far'"),
    ],
)
def test_what_cannot_be_meant_of_a_pad_is_told(entry: dict[str, str], told: str) -> None:
    refused(lambda: facts_of(entry, where="p"), told)


def test_what_is_said_of_a_pad_comes_back() -> None:
    mask = np.array([[True, False], [True, True]])
    facts = PadFacts("a", "signals", "N", "S", "down", (0.1, 0.2), mask, ~mask, None, ("x", "y"))
    again = facts_of(facts.record(), where="")
    assert again.record() == facts.record()
    assert again.field is not None
    assert again.field.dtype == bool
    bare = facts_of({}, where="")
    assert bare.record() == PadFacts("").record()
    assert (bare.names, facts_of({"names": "5"}, where="").names) == ((), ())
    placed = PadFacts("b", positions_m=np.array([[0.1, 0.2], [0.3, 0.4]]))
    np.testing.assert_array_equal(facts_of(placed.record(), where="").positions_m, placed.positions_m)


def test_a_message_that_is_none_is_told_with_its_topic_and_time(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    for spoilt, told in (
        ({"x": np.ones((2, 3))}, "has 2 x 3 pixels, those before have 2 x 2"),
        ({"s": np.ones(4)}, "has numbers of shape (4,), those before have (3,)"),
    ):
        with path.open("wb") as file:
            writer = TopicWriter(file)
            writer.describe(PadFacts("s", kind="signals"))
            writer.reading({"x": np.ones((2, 2)), "s": np.ones(3)}, log_ns=5)
            writer.reading(spoilt, log_ns=1_500_000_000)
            writer.finish()
        (name,) = spoilt
        refused(lambda: gather(path), f"{path}: topic /{name}: message of 1.500000 s: {told}")
    for text in ("5", '["a"]', "no"):
        with path.open("wb") as file:
            writer = TopicWriter(file)
            writer.reading({"x": np.ones((2, 2))}, log_ns=5)
            writer._message(MARKS, "std_msgs/msg/String", {}, string_message(text), 2_000_000_000, 0, 0)
            writer.finish()
        with pytest.raises(FormatError) as error:
            gather(path)
        assert str(error.value).startswith(f"{path}: topic {MARKS}: message of 2.000000 s: ")
