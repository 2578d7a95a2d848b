"""Files made by hand: what is damaged, lies or is not read is refused in its own words; what is like it is read."""
# ruff: noqa: E501

from __future__ import annotations

import io
import json
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import lz4.block
import numcodecs
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from tests.test_recording_bound_laws import MAT5_FRAMES, mat5, refused, zarr_array
from tests.test_recording_lerobot import EPISODES, OF_PALM, PALM, data_set
from tests.test_recording_matlab import element, matrix
from tests.test_recording_tiff_laws import (
    COUNTS,
    LONG,
    OFFSETS,
    PACKING,
    SHORT,
    TOLD,
    entries,
    strips_of,
    tiff,
    written,
)

from varishold.errors import FormatError, InputError
from varishold.recording import Pad, Recording, Signals, read, write
from varishold.recording.formats import lerobot, lerobot_episodes, mat73, zarr_store
from varishold.recording.formats.blosc import from_blosc
from varishold.recording.formats.hdf5_file import Hdf5File
from varishold.recording.formats.lerobot_writing import _stats
from varishold.recording.formats.packings import from_gzip, from_lz4, from_sized_lz4, from_zlib, from_zstd
from varishold.recording.formats.tiff_lzw import unpacked
from varishold.recording.formats.zarr_arrays import ZarrGroups
from varishold.recording.formats.zarr_store import FolderStore, ZipStore

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)


# Zarr


def zarr_2(path: Path, piece: bytes, **more: Any) -> Path:
    """Write an array of version 2 in one piece."""
    path.mkdir(parents=True)
    said = {
        "zarr_format": 2,
        "shape": [5, 3, 4],
        "chunks": [5, 3, 4],
        "dtype": "<u2",
        "order": "C",
        "compressor": None,
        "filters": None,
        "fill_value": 0,
        **more,
    }
    (path / ".zarray").write_text(json.dumps(said))
    (path / "0.0.0").write_bytes(piece)
    return path


@pytest.mark.parametrize("width", [1, 2, 4, 8, 12])
def test_numbers_of_zarr_whose_bytes_stand_apart_are_put_together(tmp_path: Path, width: int) -> None:
    shuffled = numcodecs.Shuffle(width)
    piece = bytes(shuffled.encode(FRAMES))
    path = zarr_2(tmp_path / "a", piece, filters=[{"id": "shuffle", "elementsize": width}])
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)
    if width == 4:
        path = zarr_2(tmp_path / "b", piece, filters=[{"id": "shuffle"}])
        np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"filters": [{"id": "shuffle", "elementsize": 0}]}, "array: shuffles numbers of 0 bytes"),
        ({"filters": [{"id": "shuffle", "elementsize": 17}]}, "array: shuffles numbers of 17 bytes"),
        ({"filters": [{"id": "delta"}]}, "array: is packed by delta, which is not read here; copy it with zstd, gzip or blosc"),
        ({"filters": [{"id": "shuffle"}, {"id": "shuffle"}]}, "array: is packed by shuffle, which is not read here"),
        ({"order": "K"}, "array: order must be C or F, got 'K'"),
        ({"dimension_separator": "-"}, "array: has pieces of 3 sides in an array of 3"),
        ({"dtype": "<u0"}, "holds no array of frames"),
        ({"dtype": "<M8[s]"}, "holds no array of frames"),
    ],
)  # fmt: skip
def test_what_zarr_2_says_and_is_not_read_is_told(tmp_path: Path, more: dict[str, Any], told: str) -> None:
    refused(lambda: read(zarr_2(tmp_path / "a", FRAMES.tobytes(), **more)), told)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"storage_transformers": [{"name": "x"}]}, "array: is stored by transformers, which are not read"),
        ({"chunk_key_encoding": {"name": "odd"}}, "array: has pieces on a grid that is not regular, or names that are not known"),
        ({"chunk_key_encoding": {"name": "v2", "configuration": {"separator": "-"}}}, "array: has pieces of 3 sides in an array of 3"),
        ({"fill_value": [1]}, "what stands for nothing there must be a number, got '[1]'"),
        ({"codecs": [{"name": "bytes"}, {"name": "bytes"}]}, "array: is packed by bytes, which is not read here"),
        ({"codecs": [{"name": "gzip"}, {"name": "bytes"}]}, "array: is packed by gzip, which is not read here"),
        ({"codecs": [{"name": "crc32c"}, {"name": "bytes"}]}, "array: is packed by crc32c, which is not read here"),
        ({"codecs": [{"name": "bytes"}, {"name": "transpose", "configuration": {"order": [0, 1, 2]}}]}, "array: is packed by transpose"),
        ({"data_type": {"name": "fixed_length_utf32", "configuration": {"length_bytes": 3}}}, "holds no array of frames"),
        ({"data_type": {"name": "fixed_length_utf32", "configuration": {"length_bytes": 1 << 16}}}, "holds no array of frames"),
        ({"data_type": "float8"}, "holds no array of frames"),
    ],
)  # fmt: skip
def test_what_zarr_3_says_and_is_not_read_is_told(tmp_path: Path, more: dict[str, Any], told: str) -> None:
    path = zarr_array(
        tmp_path / "a", [5, 3, 4], [5, 3, 4], kind="uint16", **{k: v for k, v in more.items() if k != "data_type"}
    )
    if "data_type" in more:
        said = json.loads((path / "zarr.json").read_text())
        (path / "zarr.json").write_text(json.dumps(said | more))
    refused(lambda: read(path), told)


@pytest.mark.parametrize(
    ("keys", "name"),
    [
        ({"name": "default"}, "c/0/0/0"),
        ({"name": "default", "configuration": {"separator": "."}}, "c.0.0.0"),
        ({"name": "v2"}, "0.0.0"),
        ({"name": "v2", "configuration": {"separator": "/"}}, "0/0/0"),
        ({"name": "v2", "configuration": None}, "0.0.0"),
    ],
)
@pytest.mark.parametrize("endian", ["little", "big", None])
def test_pieces_of_zarr_3_are_where_their_names_say(
    tmp_path: Path, keys: dict[str, Any], name: str, endian: str | None
) -> None:
    codec = {"name": "bytes"} | ({"configuration": {"endian": endian}} if endian else {})
    path = zarr_array(tmp_path / "a", [5, 3, 4], [5, 3, 4], kind="uint16", chunk_key_encoding=keys, codecs=[codec])
    (path / name).parent.mkdir(parents=True, exist_ok=True)
    (path / name).write_bytes(FRAMES.astype(">u2" if endian == "big" else "<u2").tobytes())
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)


@pytest.mark.parametrize("order", ["C", "F", [0, 1, 2], [2, 0, 1], [1, 2, 0]])
def test_axes_of_zarr_are_turned_back(tmp_path: Path, order: Any) -> None:
    axes = {"C": [0, 1, 2], "F": [2, 1, 0]}.get(str(order), order)
    codecs = [{"name": "transpose", "configuration": {"order": order}}, {"name": "bytes"}]
    path = zarr_array(tmp_path / "a", [5, 3, 4], [5, 3, 4], kind="uint16", codecs=codecs)
    (path / "c/0/0").mkdir(parents=True)
    (path / "c/0/0/0").write_bytes(np.ascontiguousarray(FRAMES.transpose(axes)).tobytes())
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)


def test_what_stands_in_hidden_folders_and_behind_links_is_no_part_of_a_data_set(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.mkdir()
    (path / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group"}')
    zarr_array(path / ".hidden", [5, 3, 4], [5, 3, 4])
    zarr_array(path / "pressure", [5, 3, 4], [5, 3, 4])
    (path / "link").symlink_to(path / "pressure")
    assert list(ZarrGroups(FolderStore(path)).datasets) == [("pressure",)]


def test_a_checksum_behind_a_piece_is_no_part_of_what_was_packed() -> None:
    from varishold.recording.formats.zarr_codecs import Pipeline

    packed: list[tuple[bytes, int]] = []

    def unpack(data: bytes, most: int) -> bytes:
        packed.append((data, most))
        return bytes(range(12))[:most]

    for within, behind in ((0, 0), (0, 4), (4, 0), (4, 4)):
        pipeline = Pipeline((2, 4), np.dtype("u1"), (0, 1), unpack, within, behind)
        assert pipeline.numbers(b"packed" + b"sums"[:behind]).tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]
        assert packed.pop() == (b"packed", 8 + within)
        plain = Pipeline((2, 4), np.dtype("u1"), (1, 0), None, within)
        assert plain.numbers(bytes(range(8)) + b"sums"[:within]).tolist() == [[0, 2, 4, 6], [1, 3, 5, 7]]
        with pytest.raises(ValueError, match=rf"^it unpacks to {9 + within} bytes, {8 + within} are announced$"):
            plain.numbers(bytes(9 + within))


def test_pieces_of_zarr_are_kept_as_far_as_they_are_small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who reads onward reads each piece once."""
    from varishold.recording.formats import zarr_arrays

    path = zarr_array(tmp_path / "a", [40], [10])
    (path / "c").mkdir()
    for k in range(4):
        (path / f"c/{k}").write_bytes(bytes([k]) * 10)
    asked: list[str] = []
    whole = FolderStore.read
    monkeypatch.setattr(FolderStore, "read", lambda self, key, most: asked.append(key) or whole(self, key, most))
    for kept, wanted in (
        (10, ["c/0", "c/1", "c/2", "c/3"]),
        (9, ["c/0", "c/0", "c/1", "c/1", "c/2", "c/2", "c/3", "c/3"]),
    ):
        monkeypatch.setattr(zarr_arrays, "_KEPT", kept)
        (held,) = ZarrGroups(FolderStore(path)).datasets.values()
        asked.clear()
        for first in range(0, 40, 5):
            assert held[first : first + 5].tolist() == [first // 10] * 5
        assert [key for key in asked if key != "zarr.json"] == wanted


@pytest.mark.parametrize("ends", [[2, 5], [2, 4], [3, 3, 5], [5, 2], [0, 5], []])
def test_episodes_of_zarr_end_with_the_frames_and_rise(tmp_path: Path, ends: list[int]) -> None:
    path = tmp_path / "a"
    path.mkdir()
    (path / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group"}')
    zarr_array(path / "pressure", [5, 3, 4], [5, 3, 4])
    last = zarr_array(path / "episode_ends", [len(ends)], [9], kind="int32")
    (last / "c").mkdir()
    (last / "c/0").write_bytes(np.array([*ends, *[0] * (9 - len(ends))], "<i4").tobytes())
    recording = read(path)
    if ends == [2, 5]:
        assert recording.press is not None
        assert recording.press.tolist() == [0, 0, 1, 1, 1]
        assert recording.notes[-1] == "each of 2 episodes is a press"
    else:
        assert recording.press is None
        assert recording.notes[-1] == "episode_ends does not end with the frames: passed over"


def archive(path: Path, members: dict[str, bytes], packing: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", packing) as made:
        for name, content in members.items():
            made.writestr(name, content)
    return path


def test_members_of_an_archive_are_found_under_their_groups(tmp_path: Path) -> None:
    names = ["a/b/c", "a/b/d/e", "a/f", "g", "h/i"]
    store = ZipStore(archive(tmp_path / "a.zip", {name: name.encode() * 3 for name in names} | {"empty/": b""}))
    assert list(store.groups("")) == ["a", "h"]
    assert list(store.groups("a")) == ["b"]
    assert list(store.groups("a/b")) == ["d"]
    assert list(store.groups("a/b/d")) == list(store.groups("g")) == list(store.groups("x")) == []
    assert [store.size(name) for name in (*names, "a")] == [15, 21, 9, 3, 9, None]
    assert store.read("a/f", 9) == b"a/fa/fa/f"
    refused(lambda: store.read("a/f", 8), f"{tmp_path / 'a.zip'}: a/f: is larger than 8 bytes; such a piece never is")
    with pytest.raises(InputError, match="a/x: there is no such member"):
        store.read("a/x", 8)
    store.close()
    store.close()


def test_archives_that_cannot_be_meant_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.zip"
    archive(path, {"x": b"1", "y": b"2"})
    path.write_bytes(path.read_bytes().replace(b"y", b"x"))
    refused(lambda: ZipStore(path), f"{path}: holds a name twice, and nobody can know which is meant")
    archive(path, {"x": b"1" * 99}, zipfile.ZIP_BZIP2)
    store = ZipStore(path)
    refused(lambda: store.read("x", 99), f"{path}: x: is packed by way 12, which is not read")
    store.close()
    monkeypatch.setattr(zarr_store, "_MOST_MEMBERS", 2)
    ZipStore(archive(path, dict.fromkeys("ab", b"1") | {"folder/": b""})).close()
    refused(lambda: ZipStore(archive(path, dict.fromkeys("abc", b"1"))), f"{path}: holds 3 members; at most 2 are read")
    archive(path, {"x": bytes(9000)}, zipfile.ZIP_DEFLATED)
    size = path.stat().st_size
    monkeypatch.setattr(zarr_store, "_LARGE", 0)
    for ratio, fits in ((-(-9000 // size), True), (8999 // size, False)):
        monkeypatch.setattr(zarr_store, "_BOMB_RATIO", ratio)
        if fits:
            ZipStore(path).close()
        else:
            refused(lambda: ZipStore(path), f"{path}: would unpack to 9000 bytes; nothing measured is so empty")
    monkeypatch.setattr(zarr_store, "_LARGE", 9000)
    ZipStore(path).close()


def test_a_folder_of_zarr_that_is_gone_is_told(tmp_path: Path) -> None:
    store = FolderStore(tmp_path)
    with pytest.raises(InputError, match=r"/x: cannot be read: no such file or directory"):
        list(store.groups("x"))
    (tmp_path / "p").write_bytes(b"abc")
    assert store.read("p", 3) == b"abc"
    refused(lambda: store.read("p", 2), f"{tmp_path / 'p'}: is larger than 2 bytes; such a piece never is")


# What packers packed

PACKED: dict[str, tuple[Callable[[bytes, int], bytes], Callable[[bytes], bytes]]] = {
    "zlib": (from_zlib, zlib.compress),
    "gzip": (from_gzip, lambda data: numcodecs.GZip().encode(data)),
    "zstd": (from_zstd, zstandard.compress),
    "lz4": (from_lz4, lambda data: lz4.block.compress(data, store_size=False)),
    "sized lz4": (from_sized_lz4, lz4.block.compress),
}


@pytest.mark.parametrize("name", PACKED)
@given(st.binary(max_size=40))
def test_no_more_is_unpacked_than_is_said(name: str, data: bytes) -> None:
    unpack, pack = PACKED[name]
    packed = bytes(pack(data))
    assert unpack(packed, len(data)) == data
    assert unpack(packed, len(data) + 5) == data
    if data:
        with pytest.raises(ValueError, match=r"does not unpack to|most|[Dd]ecompress|lz4"):
            unpack(packed, len(data) - 1)


def test_what_was_cut_off_does_not_unpack() -> None:
    data = bytes(range(200)) * 3
    for name in ("zlib", "gzip"):
        unpack, pack = PACKED[name]
        with pytest.raises(ValueError, match=r"^does not unpack to 600 bytes$"):
            unpack(pack(data)[:-9], 600)
    with pytest.raises(ValueError, match=r"^does not unpack to 599 bytes$"):
        from_zstd(zstandard.compress(data), 599)
    with pytest.raises(ValueError, match=r"^says 600 bytes; 599 are the most$"):
        from_sized_lz4(lz4.block.compress(data), 599)
    with pytest.raises(ValueError, match=r"\w"):
        from_zstd(b"hello", 9)


def blosc(block: int, *streams: bytes, flags: int = 1 << 5, width: int = 1, n: int = 8, **head: int) -> bytes:
    """Return a container of one block."""
    body = b"".join(struct.pack("<i", head.get("length", len(each))) + each for each in streams)
    size = 20 + len(body)
    return (
        struct.pack("<BBBBIIII", head.get("version", 2), 1, flags, width, n, block, head.get("packed", size), 20) + body
    )


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (blosc(8, b"12345678"), None),
        (blosc(8, b"12345678", version=1), None),
        (blosc(8, b"12345678", version=3), "Blosc of version 3 says 8 bytes in 32 of 32"),
        (blosc(8, b"12345678", version=0), "Blosc of version 0 says 8 bytes in 32 of 32"),
        (blosc(8, b"12345678", packed=33), "Blosc of version 2 says 8 bytes in 33 of 32"),
        (blosc(8, b"12345678", width=0), "Blosc of version 2 says 8 bytes in 32 of 32"),
        (blosc(8, b"12345678", n=9), "Blosc of version 2 says 9 bytes in 32 of 32"),
        (blosc(0, b"12345678"), "blocks of 0 bytes for 8"),
        (blosc(9, b"12345678"), "blocks of 9 bytes for 8"),
        (blosc(8, b"12345678", flags=0), "packed by blosclz within Blosc, which is not read"),
        (blosc(8, b"12345678", flags=2 << 5), "packed by snappy within Blosc, which is not read"),
        (blosc(8, b"12345678", flags=7 << 5), "packed by 7 within Blosc, which is not read"),
        (blosc(8, b"12345678", length=9), "a stream of 9 bytes goes beyond the end"),
        (blosc(8, b"12345678", length=-1), "a stream of -1 bytes goes beyond the end"),
        (blosc(8, zlib.compress(b"1234567"), flags=3 << 5), "a stream of 8 bytes holds 7"),
        (blosc(8, zlib.compress(b"12345678"), flags=3 << 5), None),
        (blosc(8, b"1234", b"5678", width=2), None),
    ],
)  # fmt: skip
def test_a_container_of_blosc_is_what_it_says(data: bytes, told: str | None) -> None:
    if told is None:
        assert from_blosc(data, 8) == b"12345678"
    else:
        with pytest.raises(ValueError, match=r"\w") as error:
            from_blosc(data, 8)
        assert str(error.value) == told


def test_what_blosc_leaves_as_it_is_comes_out() -> None:
    plain = struct.pack("<BBBBIII", 2, 1, 2 | 1 << 5, 1, 8, 8, 24) + b"12345678"
    assert from_blosc(plain + b"more", 8) == b"12345678"
    nothing = struct.pack("<BBBBIII", 2, 1, 1 << 5, 1, 0, 0, 16)
    assert from_blosc(nothing, 0) == b""


# TIFF and PNG


def test_heads_of_tiff_that_are_none_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    good = written(path, FRAMES[:2], rows=3).read_bytes()
    (first,) = struct.unpack_from("<I", good, 4)
    (many,) = struct.unpack_from("<H", good, first)
    after = first + 2 + many * 12

    def spoilt(at: int, form: str, value: int) -> bytes:
        made = bytearray(good)
        struct.pack_into(form, made, at, value)
        return bytes(made)

    for content, told in (
        (spoilt(4, "<I", 0), "it has no page"),
        (spoilt(first, "<H", 0), "a page has 0 entries"),
        (spoilt(first, "<H", 4097), "a page has 4097 entries"),
        (spoilt(after, "<I", first), f"its pages lead in a circle, or are more than {1 << 20}"),
    ):
        path.write_bytes(content)
        refused(lambda: read(path), f"{path}: is damaged or cut off: {told}")
    path.write_bytes(good[:after])
    refused(lambda: read(path), f"bytes {after} to {after + 4} are wanted of {after}")
    # The second page is not all there.
    path.write_bytes(spoilt(after, "<I", len(good)))
    assert read(path).notes == ("is cut off after page 0",)
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES[:1])
    path.write_bytes(b"II\x2c\0" + bytes(99))
    with pytest.raises(FormatError):
        read(path)


def test_a_stack_has_as_many_pages_as_it_says_images(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    strips = [strips_of(frame, 3, "<") for frame in FRAMES[:3]]
    for told, fits in ((3, True), (4, False), (2, True)):
        words = f"ImageJ=1\nimages={told}\nslices=9\n".encode()
        pages = [entries(frame, [24], 3) for frame in FRAMES[:3]]
        pages[0][TOLD] = (SHORT, list(words))
        content = tiff(pages, strips)
        # As letters, one byte each.
        at = content.index(struct.pack("<HHI", TOLD, SHORT, len(words)))
        (place,) = struct.unpack_from("<I", content, at + 8)
        made = bytearray(content)
        struct.pack_into("<HH", made, at, TOLD, 2)
        made[place : place + len(words)] = words
        path.write_bytes(made)
        if fits:
            assert read(path).n_frames == 3
        else:
            refused(
                lambda: read(path),
                f"{path}: says that it holds 4 images and has 3 pages of them; save it with a page an image",
            )


@pytest.mark.parametrize(("n_bytes", "fits"), [(48 + 1024, True), (48 + 1025, False)])
def test_a_strip_of_tiff_is_packed_into_twice_what_it_holds_at_most(tmp_path: Path, n_bytes: int, fits: bool) -> None:
    path = tmp_path / "a.tif"
    strip = zlib.compress(FRAMES[0].tobytes()).ljust(n_bytes, b"\0")
    path.write_bytes(tiff([entries(FRAMES[0], [n_bytes], 3) | {PACKING: (LONG, [8])}], [[strip]]))
    if fits:
        np.testing.assert_array_equal(read(path).pads["pad"].frames[0], FRAMES[0])
    else:
        refused(
            lambda: read(path), f"{path}: page 0: is damaged or cut off: a strip of 24 bytes is packed into {n_bytes}"
        )


def test_strips_of_tiff_that_hold_too_little_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    strip = zlib.compress(FRAMES[0].tobytes()[:-1])
    path.write_bytes(tiff([entries(FRAMES[0], [len(strip)], 3) | {PACKING: (LONG, [8])}], [[strip]]))
    refused(lambda: read(path), f"{path}: page 0: is damaged or cut off: a strip has 23 bytes of 24")
    page = entries(FRAMES[0], [8, 8], 1)
    path.write_bytes(tiff([page], [strips_of(FRAMES[0], 1, "<")[:2]]))
    refused(lambda: read(path), f"{path}: is damaged or cut off: page 0 has 2 strips of 1 rows for 3 rows")
    page = entries(FRAMES[0], [8, 8, 8], 1) | {COUNTS: (LONG, [8, 8])}
    path.write_bytes(tiff([page], [strips_of(FRAMES[0], 1, "<")]))
    refused(lambda: read(path), f"{path}: is damaged or cut off: page 0 has 3 strips of 1 rows for 3 rows")
    page = entries(FRAMES[0], [24], 3) | {OFFSETS: (LONG, [8, 8])}
    path.write_bytes(tiff([page], [strips_of(FRAMES[0], 3, "<")]))
    refused(lambda: read(path), "page 0 has 2 strips of 3 rows for 3 rows")


def test_pages_of_tiff_are_alike(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    for other, told in ((FRAMES[0, :2], "2 x 4 uint16"), (FRAMES[0].astype(np.float32), "3 x 4 float32")):
        frames = [FRAMES[0], other]
        pages = [entries(frame, [frame.nbytes], len(frame)) for frame in frames]
        path.write_bytes(tiff(pages, [strips_of(frame, len(frame), "<") for frame in frames]))
        refused(lambda: read(path), f"{path}: page 1 is {told}, page 0 3 x 4 uint16; all must be alike")


def lzw(*codes: int) -> bytes:
    bits = "".join(f"{code:09b}" for code in codes)
    return int(bits.ljust(-(-len(bits) // 8) * 8, "0"), 2).to_bytes(-(-len(bits) // 8), "big")


def test_codes_of_lzw_stand_for_what_came_before() -> None:
    assert unpacked(lzw(256, 1, 2, 258, 260, 3, 257), 99) == bytes([1, 2, 1, 2, 1, 2, 1, 3])
    assert unpacked(lzw(256, 1, 2, 257, 5), 99) == bytes([1, 2])
    assert unpacked(lzw(256, 1, 2, 256, 3, 257), 99) == bytes([1, 2, 3])
    assert unpacked(lzw(256, 1, 2, 3), 2) == bytes([1, 2])
    assert unpacked(lzw(256, 1, 2, 3)[:4], 99) == bytes([1, 2])
    for codes, told in (((256, 1, 259), 259), ((256, 258), 258), ((256, 1, 2, 260), 260)):
        with pytest.raises(ValueError, match=f"^code {told} stands for nothing yet$"):
            unpacked(lzw(*codes), 99)


@given(st.binary(max_size=600), st.integers(1, 4))
def test_what_pillow_packs_by_lzw_is_unpacked(data: bytes, most: int) -> None:
    values = np.frombuffer(data or b"x", np.uint8) % (1 << most)
    made = io.BytesIO()
    Image.fromarray(values[None]).save(made, "TIFF", compression="tiff_lzw")
    with Image.open(made) as image:
        tags = image.tag_v2
        (at,), (n_bytes,) = tags[273], tags[279]
    packed = made.getvalue()[at : at + n_bytes]
    assert unpacked(packed, values.size) == values.tobytes()
    assert unpacked(packed, values.size // 2) == values.tobytes()[: values.size // 2]


def png(path: Path, frame: np.ndarray) -> Path:
    Image.fromarray(frame).save(path, "PNG")
    return path


def test_a_png_is_what_its_head_says(tmp_path: Path) -> None:
    path = png(tmp_path / "a.png", FRAMES[0])
    good = path.read_bytes()
    for at, value, told in (
        (24, 4, "has colours, a palette or other bits than 8 or 16; depth pictures are grey"),
        (25, 2, "has colours, a palette or other bits than 8 or 16; depth pictures are grey"),
        (19, 0, "is 3 x 0; it may have 1 to 16777216 taxels"),
        (23, 0, "is 0 x 4; it may have 1 to 16777216 taxels"),
    ):
        made = bytearray(good)
        made[at] = value
        path.write_bytes(made)
        refused(lambda: read(path), f"{path}: {told}")
    for rows, cols, fits in ((4096, 4096, True), (1, (1 << 24) + 1, False)):
        path.write_bytes(good[:16] + struct.pack(">II", cols, rows) + good[24:])
        with pytest.raises(FormatError) as error:
            read(path)
        assert ("it may have 1 to" in str(error.value)) != fits
    # What is read is of the size that was announced.
    path.write_bytes(good[:16] + struct.pack(">II", 4, 2) + good[24:])
    with pytest.raises(FormatError, match=r"a\.png: is damaged or cut off"):
        read(path)


def test_pictures_in_a_folder_are_one_frame_each(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    for k in range(3):
        written(folder / f"{k}.tif", FRAMES[:2], rows=3)
    refused(lambda: read(folder), f"{folder / '0.tif'}: has 2 pages; in a folder each picture is a frame")
    for k in range(3):
        written(folder / f"{k}.tif", FRAMES[k : k + 1], rows=3)
    np.testing.assert_array_equal(read(folder).pads["pad"].frames, FRAMES[:3])
    written(folder / "1.tif", FRAMES[:2], rows=3)
    told = f"{folder / '1.tif'}: is 2 pages of 3 x 4 uint16, 0.tif 3 x 4 uint16; all pictures of a pad must be alike"
    refused(lambda: read(folder), told)
    png(folder / "1.tif", FRAMES[0].astype(np.uint8))
    told = f"{folder / '1.tif'}: is 3 x 4 uint8, 0.tif 3 x 4 uint16; all pictures of a pad must be alike"
    refused(lambda: read(folder), told)
    png(folder / "1.tif", FRAMES[0])
    assert read(folder, shape=(3, 4), pitch_m=0.1).pads["pad"].pitch_m == (0.1, 0.1)
    refused(lambda: read(folder, shape=(4, 3)), f"{folder}: has frames of 3 x 4, not 4 x 3; leave the shape out")


def test_only_the_last_of_several_pictures_may_be_cut_off(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    whole = png(folder / "0.png", FRAMES[0]).read_bytes()
    (folder / "0.png").write_bytes(whole[:-30])
    with pytest.raises(FormatError, match=r"0\.png: is damaged or cut off"):
        read(folder)
    (folder / "0.png").write_bytes(whole)
    (folder / "1.png").write_bytes(whole[:-30])
    recording = read(folder)
    assert recording.n_frames == 1
    assert recording.notes[0].startswith(f"the last pictures are left out: {folder / '1.png'}: is damaged or cut off")


@pytest.mark.parametrize(
    ("numbers", "told"),
    [
        ([1, 2, 3, 4], None),
        ([1, 3, 5, 7], None),
        ([1, 2, 4, 5], "the pictures' numbers jump from 2 to 4"),
        ([1, 2, 4, 5, 9, 10, 11, 12], "the pictures' numbers jump from 2 to 4 and 1 time more"),
    ],
)
def test_jumps_of_numbers_are_told(tmp_path: Path, numbers: list[int], told: str | None) -> None:
    folder = tmp_path / "p"
    folder.mkdir()
    for k in numbers:
        png(folder / f"depth_{k}.png", FRAMES[0] + k)
    recording = read(folder)
    assert recording.pads["pad"].frames[:, 0, 0].tolist() == numbers
    assert recording.notes == (() if told is None else (told,))


def test_pads_of_pictures_have_the_same_numbers(tmp_path: Path) -> None:
    for pad, numbers in (("left", (1, 2, 3)), ("right", (1, 3))):
        (tmp_path / "p" / pad).mkdir(parents=True)
        for k in numbers:
            png(tmp_path / "p" / pad / f"{k}.png", FRAMES[0] + k)
    refused(lambda: read(tmp_path / "p"), f"{tmp_path / 'p'}: left has 3 pictures, right 2; picture 2 has no other")
    (tmp_path / "p/left/3.png").rename(tmp_path / "p/left/7.png")
    png(tmp_path / "p/right/9.png", FRAMES[0])
    refused(lambda: read(tmp_path / "p"), "left has 3 pictures, right 3; picture 2 has no other")


# MATLAB


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (element(15, zlib.compress(element(5, bytes(8)))), "an element of kind 5 is packed where a variable should be"),
        (element(15, zlib.compress(matrix(6, (1, 1), "x", element(9, bytes(8))))[:-9]), "a packed variable ends early"),
        (matrix(6, (1, 1), "x", struct.pack("<II", 9, 9) + bytes(8)), "9 bytes are announced where 8 are left"),
        (matrix(6, (1, 1), "x", struct.pack("<I", 5 << 16 | 9) + bytes(9)), "5 bytes are announced where 9 are left"),
        (matrix(4, (1, 2), "x", element(7, b"abcd")), "an element of kind 7 stands where text should be"),
        (matrix(4, (1, 9), "x", element(16, b"abcd")), "(1, 9) characters are announced, 4 bytes are there"),
        (matrix(6, (4,), "x", element(9, bytes(32))), "an array of shape (4,) is announced"),
        (matrix(6, (-1, 2), "x", element(9, bytes(32))), "an array of shape (-1, 2) is announced"),
        (matrix(2, (1, 1), "x", element(5, struct.pack("<i", 3)) + element(1, b"abcd")), "a struct has 4 letters of names, 3 each"),
        (matrix(1, (1, 99), "x", element(14, b"")), "a cell of 99 entries is announced"),
    ],
)  # fmt: skip
def test_what_is_damaged_in_matlab_is_told(tmp_path: Path, content: bytes, told: str) -> None:
    path = mat5(tmp_path / "a.mat", content, MAT5_FRAMES)
    refused(lambda: read(path), f"{path}: is damaged or cut off: {told}")


def test_cells_of_matlab_hold_texts_or_are_passed_over(tmp_path: Path) -> None:
    def text(letters: str, rows: int = 1) -> bytes:
        return matrix(4, (rows, len(letters) // rows), "", element(16, letters.encode()))

    labels = matrix(1, (1, 3), "", text("cone") + element(14, b"") + text(""))
    width = element(5, struct.pack("<i", 8)) + element(1, b"label".ljust(8, b"\0"))
    presses = matrix(2, (1, 1), "presses", width + labels)
    press = matrix(12, (1, 5), "press", element(5, struct.pack("<5i", 0, 0, 1, 2, 2)))
    path = mat5(tmp_path / "a.mat", MAT5_FRAMES, press, presses, matrix(1, (1, 1), "two", text("abcd", rows=2)))
    recording = read(path)
    assert recording.presses.columns["label"].tolist() == ["cone", "", ""]
    assert recording.notes == ("passed over: two (a cell)",)


@pytest.mark.parametrize(("many", "told"), [(8, 8), (9, 8)])
def test_so_many_things_that_are_passed_over_are_named(tmp_path: Path, many: int, told: int) -> None:
    path = mat5(tmp_path / "a.mat", MAT5_FRAMES, *(matrix(17, (1, 1), f"f{k}", b"") for k in range(many)))
    assert read(path).notes == (f"passed over: {', '.join(f'f{k} (an object)' for k in range(told))}",)


def mat73_file(path: Path, fill: Callable[[Any], object]) -> Path:
    with h5py.File(path, "w", userblock_size=512) as file:
        file["pressure"] = FRAMES.T
        fill(file)
    with path.open("r+b") as binary:
        binary.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def labelled(file: Any, name: str, value: Any, **attributes: Any) -> None:
    file[name] = value
    for key, each in attributes.items():
        file[name].attrs[key] = each


def test_what_matlab_73_says_and_cannot_be_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.mat"
    mat73_file(path, lambda f: labelled(f, "time_s", np.zeros((1, 5)), varishold_type=np.bytes_("object")))
    refused(lambda: read(path), f"{path}: time_s: varishold_type must be a type of numbers or text, got 'object'")
    mat73_file(path, lambda f: labelled(f, "unit", np.zeros((3, 1)), MATLAB_class=np.bytes_("char")))
    refused(lambda: read(path), f"{path}: unit: must be characters, got float64 of (3, 1)")
    mat73_file(path, lambda f: labelled(f, "unit", np.zeros(3, np.uint16), MATLAB_class=np.bytes_("char")))
    refused(lambda: read(path), f"{path}: unit: must be characters, got uint16 of (3,)")

    def cell(file: Any) -> None:
        file["press"] = np.array([[0, 0, 1, 1, 1]], np.int32)
        file["presses/label"] = np.empty((1, 2), h5py.ref_dtype)
        file["#refs#/a"] = np.frombuffer("cone".encode("utf-16-le"), "<u2")[:, None]
        file["#refs#/b"] = np.zeros(2, np.uint64)
        file["#refs#/b"].attrs["MATLAB_empty"] = np.uint8(1)
        for k, name in enumerate("ab"):
            file["presses/label"][0, k] = file[f"#refs#/{name}"].ref
        file["presses/label"].attrs["MATLAB_class"] = np.bytes_("cell")

    mat73_file(path, cell)
    assert read(path).presses.columns["label"].tolist() == ["cone", ""]
    monkeypatch.setattr(mat73, "_MOST_CELLS", 2)
    assert read(path).presses.columns["label"].tolist() == ["cone", ""]
    monkeypatch.setattr(mat73, "_MOST_CELLS", 1)
    refused(lambda: read(path), f"{path}: presses/label: has 2 entries, 1 are the most")
    with h5py.File(path, "r+") as file:
        file["presses/label"][0, 1] = file["#refs#"].ref
    monkeypatch.setattr(mat73, "_MOST_CELLS", 2)
    refused(lambda: read(path), f"{path}: presses/label: an entry leads to no array")


def test_matlab_finds_its_own_words_in_what_is_written(tmp_path: Path) -> None:
    """As MATLAB's save -v7.3 says them."""
    mask = np.ones((3, 4), bool)
    mask[1, 1] = False
    recording = Recording(
        {"palm": Pad(FRAMES, valid=mask, pitch_m=(0.1, 0.2)), "tip": Pad(FRAMES.astype(np.float32))},
        np.arange(5.0),
        "kPa",
        press=np.full(5, -1),
        press_columns={"label": np.array([], "<U1"), "n": np.array([], np.int16)},
        signals={"shear": Signals(FRAMES[:, 0].astype(np.float16), tuple("abcd"), "N")},
    )
    write(recording, tmp_path / "a.mat")
    with h5py.File(tmp_path / "a.mat") as file:
        assert file.userblock_size == 512
        said = {}
        file.visititems(lambda name, item: said.update({name: dict(item.attrs)}))
        assert {name: attrs["MATLAB_class"].decode() for name, attrs in said.items()} == {
            "palm": "struct",
            "palm/pressure": "uint16",
            "palm/valid": "logical",
            "palm/pitch_m": "double",
            "tip": "struct",
            "tip/pressure": "single",
            "time_s": "double",
            "press": "int64",
            "presses": "struct",
            "presses/label": "char",
            "presses/n": "int16",
            "signals": "struct",
            "signals/shear": "single",
            "signal_units": "struct",
            "signal_units/shear": "char",
            "signal_names": "struct",
            "signal_names/shear": "char",
            "unit": "char",
        }
        decode = {name: int(attrs["MATLAB_int_decode"]) for name, attrs in said.items() if "MATLAB_int_decode" in attrs}
        assert decode == {
            "palm/valid": 1,
            "presses/label": 2,
            "signal_units/shear": 2,
            "signal_names/shear": 2,
            "unit": 2,
        }
        empty = {name: attrs["MATLAB_empty"] for name, attrs in said.items() if "MATLAB_empty" in attrs}
        assert empty == {"presses/label": 1, "presses/n": 1}
        assert file["presses/n"][:].tolist() == [0, 1]
        assert file["presses/label"][:].tolist() == [0, 0]
        assert file["time_s"].shape == (1, 5)
        assert file["palm/pitch_m"].shape == (1, 2)
        assert file["unit"].shape == (3, 1)
        assert file["palm/pressure"].shape == (4, 3, 5)
        assert {int(attrs["varishold_axes"]) for name, attrs in said.items() if name.endswith("pressure")} == {3}
    head = (tmp_path / "a.mat").read_bytes()[:512]
    assert head.startswith(b"MATLAB 7.3 MAT-file, Platform: varishold recording, HDF5 schema 1.00 .")
    assert head[116:] == bytes(8) + b"\x00\x02IM" + bytes(384)


def test_masks_of_matlab_may_be_bytes_and_texts_are_one(tmp_path: Path) -> None:
    mask = np.ones((3, 4), np.uint8)
    mask[2, 1] = 0
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"palm": {"pressure": FRAMES, "valid": mask, "field": np.ones((3, 4), np.uint8)}})
    recording = read(path)
    np.testing.assert_array_equal(recording.pads["palm"].usable, mask == 1)
    for key in ("valid", "field"):
        scipy.io.savemat(path, {"palm": {"pressure": FRAMES, key: mask + 1}})
        with pytest.raises(FormatError, match=key):
            read(path)
    scipy.io.savemat(path, {"pressure": FRAMES, "unit": 5})
    refused(lambda: read(path), f"{path}: unit must be one text, got int64 of shape (1, 1)")


# HDF5


def test_a_piece_of_hdf5_that_is_not_packed_or_not_there_is_no_bomb(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    n = (1 << 20) + 8
    with h5py.File(path, "w") as file:
        held = file.create_dataset("x", (3 * n,), "u1", chunks=(n,), compression="gzip")
        held.id.write_direct_chunk((0,), bytes([5]) * n, 1)
    opened = Hdf5File(path)
    assert opened.datasets["x",][n - 2 : n + 2].tolist() == [5, 5, 0, 0]
    opened.close()


@pytest.mark.parametrize("how", [{"fletcher32": True}, {"shuffle": True}, {"scaleoffset": 0}, {"compression": "lzf"}])
def test_filters_that_the_library_brings_are_read(tmp_path: Path, how: dict[str, Any]) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("pressure", data=FRAMES, chunks=(2, 3, 4), **how)
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)


@pytest.mark.parametrize(
    ("numbers", "told"),
    [
        ((32001,), "filter 32001"),
        ((1, 305), "filter 305"),
        ((1, 1), "deflate twice"),
        ((2, 3), None),
    ],
)
def test_filters_that_are_not_read_are_told_by_name_or_number(
    tmp_path: Path, numbers: tuple[int, ...], told: str | None
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plan.set_chunk((2, 3, 4))
        for number in numbers:
            if number == 3:
                plan.set_fletcher32()
            else:
                plan.set_filter(number, h5py.h5z.FLAG_OPTIONAL, (2,) if number == 2 else (1,))
        space = h5py.h5s.create_simple((2, 3, 4))
        h5py.h5d.create(file.id, b"pressure", h5py.h5t.NATIVE_INT32, space, plan)
    if told is None:
        assert read(path).n_frames == 2
    else:
        refused(
            lambda: read(path),
            f"{path}: pressure: is packed with {told}, which is not read; repack it (h5repack -f GZIP=1)",
        )


def test_what_is_neither_numbers_nor_text_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["pressure"] = FRAMES
        file["press"] = np.zeros(5, int)
        file["presses/odd"] = np.zeros(1, "i4,f4")
    refused(lambda: read(path), f"{path}: presses/odd: holds neither numbers nor text")


def assert_packed(held: h5py.Dataset, chunks: tuple[int, ...] | None) -> None:
    """What stands in pieces is packed in the quickest way; what does not, is not."""
    assert held.chunks == chunks
    assert (held.compression, held.compression_opts, held.shuffle) == (
        ("gzip", 1, True) if chunks else (None, None, False)
    )


def test_pieces_of_hdf5_have_a_quarter_of_a_megabyte(tmp_path: Path) -> None:
    """And what is smaller than one stands as it is."""
    for n, cols, chunks in (
        (4095, 32, None),
        (4096, 32, (4096, 1, 32)),
        (9000, 32, (4096, 1, 32)),
        (3, 100_000, (1, 1, 100_000)),
        (2, 400_000, (1, 1, 400_000)),
    ):
        frames = np.arange(n * cols).reshape(n, 1, cols).astype(np.uint16)
        write(Recording({"pad": Pad(frames)}), tmp_path / "a.h5")
        with h5py.File(tmp_path / "a.h5") as file:
            assert_packed(file["pad/pressure"], chunks)
        np.testing.assert_array_equal(read(tmp_path / "a.h5").pads["pad"].frames, frames)


@pytest.mark.parametrize("behind", [0, 7])
def test_a_heap_of_texts_ends_where_it_says(tmp_path: Path, behind: int) -> None:
    """What stands behind it may be anything, as numbers that are all 0."""
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["pressure"] = FRAMES
        file.attrs["unit"] = "kPa"
    content = path.read_bytes()
    heap = content.index(b"GCOL\x01")
    (size,) = struct.unpack_from("<Q", content, heap + 8)
    for end in (heap + size, len(content)):
        # A second mark, of a heap that is nothing but its head, at the end of the file.
        path.write_bytes(content[:end] + bytes([behind]) * 64 + content[end + 64 :] + b"GCOL\x01\0\0\0" + bytes(8))
        opened = Hdf5File(path)
        assert opened.attributes()["unit"].item() == "kPa"
        opened.close()


# Data sets of LeRobot


def test_what_is_no_column_of_numbers_counts_nothing(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM)
    refused_by = {"timestamp": "one number", "episode_index": "one whole number", "task_index": "one whole number"}
    file = path / "data/chunk-000/file-000.parquet"
    table = pq.read_table(file)
    for name, words in refused_by.items():
        at = table.column_names.index(name)
        pq.write_table(table.set_column(at, name, pa.array([[1, 2]] * 9, pa.list_(pa.int64(), 2))), file)
        refused(lambda: read(path), f"{path}: column {name}: must be {words} a row")


def test_a_data_set_without_a_clock_ticks_by_its_rate(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM)
    file = path / "data/chunk-000/file-000.parquet"
    pq.write_table(pq.read_table(file).drop_columns(["timestamp"]), file)
    recording = read(path)
    assert recording.time_s is not None
    np.testing.assert_allclose(recording.time_s, np.arange(9) / 10)
    assert recording.press is not None
    assert recording.press.tolist() == EPISODES.tolist()
    pq.write_table(pq.read_table(file).drop_columns(["episode_index", "task_index"]), file)
    recording = read(path)
    assert recording.press is not None
    assert recording.press.tolist() == [0] * 9
    assert recording.presses.columns["label"].tolist() == ["push"]


def test_limits_of_data_sets_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM, cuts=(4,))
    for module, name, most, told in (
        (lerobot, "_MOST_FILES", 2, f"{path / 'data'}: holds 2 files; at most 1 are read"),
        (lerobot_episodes, "_MOST_EPISODES", 3, f"{path}: has more than 2 episodes"),
        (lerobot_episodes, "_MOST_TASKS", 2, "tasks.parquet: must hold task_index and the text of up to 1 tasks"),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(module, name, most)
            assert read(path).n_frames == 9
            patched.setattr(module, name, most - 1)
            refused(lambda: read(path), told)
    tasks = path / "meta/tasks.parquet"
    for columns in ({"task_index": [0, 1]}, {"text": ["a", "b"]}, {"task_index": [0, 1], "text": [1, 2]}):
        pq.write_table(pa.table(columns), tasks)
        refused(lambda: read(path), f"{tasks}: must hold task_index and the text of up to 65536 tasks")


def test_texts_of_tasks_may_be_eight_times_their_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = data_set(tmp_path / "set", PALM, OF_PALM)
    tasks = path / "meta/tasks.parquet"
    table = pa.table({"task_index": [0, 1, None], "text": pa.array(["a" * 40_000, "b", "c"])})
    signs = table.to_batches()[0].nbytes
    seen = set()
    monkeypatch.setattr(lerobot_episodes, "_MOST_SIGNS", 0)
    for more in range(960, 1010, 2):
        pq.write_table(table.replace_schema_metadata({"x": "y" * more}), tasks)
        size = tasks.stat().st_size
        if abs(8 * size - signs) > 100:
            continue
        seen.add(fits := signs <= 8 * size)
        if fits:
            assert read(path).presses.columns["label"].tolist() == ["a" * 4096, "b", "a" * 4096]
        else:
            refused(lambda: read(path), f"{tasks}: holds texts of {signs} bytes in a file of {size}")
    assert seen == {False, True}
    for most, fits in ((signs, True), (signs - 1, False)):
        pq.write_table(table, tasks)
        monkeypatch.setattr(lerobot_episodes, "_MOST_SIGNS", most)
        if fits:
            assert read(path).n_frames == 9
        else:
            refused(lambda: read(path), f"{tasks}: holds texts of {signs} bytes")


def test_windows_that_nobody_can_know_and_of_one_reading(tmp_path: Path) -> None:
    deep = pa.array(FRAMES.repeat(2, 0)[:9].reshape(9, 1, 3, 4).tolist(), pa.list_(pa.list_(pa.list_(pa.uint16()))))
    path = data_set(tmp_path / "a", {"tactile.one": deep}, {"tactile.one": ("uint16", [1, 3, 4], None)})
    np.testing.assert_array_equal(read(path).pads["one"].frames, FRAMES.repeat(2, 0)[:9])
    for names in (["channels", "rows", "cols"], ["time", "rows", "cols"]):
        path = data_set(tmp_path / names[0], {"tactile.one": deep}, {"tactile.one": ("uint16", [1, 3, 4], names)})
        if names[0] == "time":
            np.testing.assert_array_equal(read(path).pads["one"].frames, FRAMES.repeat(2, 0)[:9])
        else:
            refused(lambda: read(path), "holds no array of frames")  # noqa: B023


@given(st.lists(st.lists(st.integers(-50, 50), min_size=2, max_size=2), min_size=1, max_size=30))
def test_what_a_data_set_says_of_a_feature_is_so(rows: list[list[int]]) -> None:
    values = np.array(rows)
    said = _stats(values, [2])
    assert said["count"] == [len(rows)]
    for key, of in (("min", np.min), ("max", np.max), ("mean", np.mean), ("std", np.std)):
        np.testing.assert_allclose(said[key], of(values, axis=0), atol=1e-9)


def test_what_a_feature_is_called_and_shaped_stands_in_its_data_set(tmp_path: Path) -> None:
    shear = Signals(np.arange(10.0).reshape(5, 2), ("x", "y"))
    one = Signals(np.arange(5.0)[:, None], ("only",))
    recording = Recording(
        {"palm": Pad(FRAMES)},
        np.arange(5) / 100,
        press=np.array([0, 0, 1, 1, 1]),
        signals={"shear": shear, "one": one, "bare": Signals(np.ones((5, 3)))},
    )
    write(recording, tmp_path / "a.lerobot")
    info = json.loads((tmp_path / "a.lerobot/meta/info.json").read_text())
    told = {name: (each["dtype"], each["shape"], each["names"]) for name, each in info.pop("features").items()}
    assert told == {
        "observation.tactile.palm": ("uint16", [3, 4], ["rows", "cols"]),
        "varishold.time_s": ("float64", [1], None),
        "varishold.press": ("int64", [1], None),
        "observation.signals.shear": ("float64", [2], ["x", "y"]),
        "observation.signals.one": ("float64", [1], ["only"]),
        "observation.signals.bare": ("float64", [3], None),
        "timestamp": ("float32", [1], None),
        **{name: ("int64", [1], None) for name in ("frame_index", "episode_index", "index", "task_index")},
    }
    assert info == {
        "codebase_version": "v3.0",
        "robot_type": None,
        "total_episodes": 2,
        "total_frames": 5,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": 100,
        "splits": {"train": "0:2"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
    }
    episodes = pq.read_table(tmp_path / "a.lerobot/meta/episodes/chunk-000/file-000.parquet").to_pydict()
    assert episodes == {
        "episode_index": [0, 1],
        "tasks": [["touch"], ["touch"]],
        "length": [2, 3],
        "data/chunk_index": [0, 0],
        "data/file_index": [0, 0],
        "dataset_from_index": [0, 2],
        "dataset_to_index": [2, 5],
        "meta/episodes/chunk_index": [0, 0],
        "meta/episodes/file_index": [0, 0],
    }
    stats = json.loads((tmp_path / "a.lerobot/meta/stats.json").read_text())
    assert sorted(stats) == sorted(told)
    assert stats["index"] == {"min": [0], "max": [4], "mean": [2], "std": [np.sqrt(2)], "count": [5]}
    assert stats["observation.signals.shear"]["mean"] == [4, 5]
    with pytest.raises(InputError, match=r"no/a\.lerobot: cannot be written: no such file or directory"):
        write(recording, tmp_path / "no/a.lerobot")
