"""Zarr: what its library writes in either version is read number by number; bad folders are told in one line."""
# ruff: noqa: E501

from __future__ import annotations

import json
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import FormatError
from varishold import open as open_recording
from varishold.recording import read
from varishold.recording.formats import is_folder
from varishold.recording.formats.blosc import from_blosc

zarr = pytest.importorskip("zarr")
numcodecs = pytest.importorskip("numcodecs")

FRAMES = np.arange(50 * 4 * 5).reshape(50, 4, 5).astype(np.uint16)
PACKERS: dict[int, dict[str, Any]] = {
    2: {
        "none": None,
        "zlib": numcodecs.Zlib(),
        "gzip": numcodecs.GZip(),
        "zstd": numcodecs.Zstd(),
        "lz4": numcodecs.LZ4(),
        **{f"blosc {name}": numcodecs.Blosc(cname=name) for name in ("lz4", "lz4hc", "zlib", "zstd")},
        **{f"blosc shuffle {k}": numcodecs.Blosc(shuffle=k, blocksize=256) for k in range(3)},
    },
    3: {
        "none": None,
        "gzip": zarr.codecs.GzipCodec(),
        "zstd": zarr.codecs.ZstdCodec(checksum=True),
        "blosc": zarr.codecs.BloscCodec(typesize=2),
        "blosc bits": zarr.codecs.BloscCodec(cname="zstd", shuffle="bitshuffle"),
        "zstd and checksum": (zarr.codecs.ZstdCodec(), zarr.codecs.Crc32cCodec()),
        "checksum and zstd": (zarr.codecs.Crc32cCodec(), zarr.codecs.ZstdCodec()),
        "checksum": zarr.codecs.Crc32cCodec(),
    },
}


@pytest.fixture(autouse=True)
def _quiet() -> Any:
    with warnings.catch_warnings():
        # Of types that version 3 has not settled.
        warnings.simplefilter("ignore")
        yield


def group(path: Path, version: int = 3) -> Any:
    return zarr.open_group(str(path), mode="w", zarr_format=version)


def array(where: Any, name: str, values: np.ndarray, **how: Any) -> Any:
    made = where.create_array(name, shape=values.shape, dtype=values.dtype, **how)
    made[...] = values
    return made


@pytest.mark.parametrize(("version", "packer"), [(v, name) for v, each in PACKERS.items() for name in each])
def test_every_packer(tmp_path: Path, version: int, packer: str) -> None:
    root = group(tmp_path / "a.zarr", version)
    array(root, "pressure", FRAMES, chunks=(16, 3, 5), compressors=PACKERS[version][packer])
    assert is_folder(tmp_path / "a.zarr")
    pad = read(tmp_path / "a.zarr").pads["pad"]
    assert pad.frames.dtype == np.uint16
    assert np.array_equal(pad.frames, FRAMES)


@settings(deadline=None, max_examples=80)
@given(
    st.sampled_from(["|u1", "<u2", ">u2", "<i4", ">i8", "<f2", ">f4", "<f8", "?"]).flatmap(
        lambda kind: hnp.arrays(
            np.dtype(kind),
            hnp.array_shapes(min_dims=3, max_dims=3, max_side=7),
            elements=None if kind in ("|u1", "<u2", ">u2", "?") else st.integers(0, 99).map(np.dtype(kind).type),
        )
    ),
    st.tuples(st.integers(1, 7), st.integers(1, 7), st.integers(1, 7)),
    st.sampled_from([2, 3]),
    st.sampled_from(["C", "F"]),
    st.data(),
)
def test_what_zarr_writes_is_read_number_by_number(
    tmp_path_factory: pytest.TempPathFactory,
    values: np.ndarray,
    pieces: tuple[int, int, int],
    version: int,
    order: str,
    data: st.DataObject,
) -> None:
    path = tmp_path_factory.mktemp("zarr") / "a.zarr"
    how: dict[str, Any] = {"order": order} if version == 2 else {}
    if version == 3 and order == "F":
        how = {"filters": [zarr.codecs.TransposeCodec(order=data.draw(st.permutations(range(3))))]}
    if version == 2:
        separator = data.draw(st.sampled_from([".", "/"]))
        how["chunk_key_encoding"] = {"name": "v2", "configuration": {"separator": separator}}
    pieces = tuple(min(a, b) for a, b in zip(pieces, values.shape, strict=True))  # type: ignore[assignment]
    if version == 3 and data.draw(st.booleans()):
        how["shards"] = tuple(side * data.draw(st.integers(1, 3)) for side in pieces)
    array(group(path, version), "pressure", values, chunks=pieces, **how)
    pad = read(path).pads["pad"]
    assert np.array_equal(pad.frames, values)
    assert pad.frames.dtype == (np.uint8 if values.dtype == bool else values.dtype.newbyteorder("="))
    first = data.draw(st.integers(0, len(values) - 1))
    with open_recording(path) as opened:
        assert np.array_equal(opened.frames[first:].pads["pad"].frames, values[first:])
        assert np.array_equal(opened.frames[: first + 1].pads["pad"].frames, values[: first + 1])


def sharded(path: Path, location: str = "end", **more: Any) -> Any:
    """Write frames in shards of 32 of them, pieces of 8, one of which nobody wrote; return the array."""
    codec = zarr.codecs.ShardingCodec(
        chunk_shape=(8, 4, 5),
        codecs=[zarr.codecs.BytesCodec(), zarr.codecs.ZstdCodec()],
        index_codecs=[zarr.codecs.BytesCodec(), zarr.codecs.Crc32cCodec()],
        index_location=location,
    )
    made = group(path).create_array(
        "pressure",
        shape=FRAMES.shape,
        dtype=FRAMES.dtype,
        chunks=(32, 4, 5),
        serializer=codec,
        compressors=None,
        **more,
    )
    made[:8], made[16:] = FRAMES[:8], FRAMES[16:]
    return made


@pytest.mark.parametrize("location", ["start", "end"])
@pytest.mark.parametrize("packed", [False, True])
def test_shards_are_read_where_their_index_says(tmp_path: Path, location: str, packed: bool) -> None:
    sharded(tmp_path / "a.zarr", location, fill_value=7)
    path = tmp_path / "a.zarr"
    if packed:
        path = tmp_path / "b.zarr.zip"
        with zipfile.ZipFile(path, "w") as archive:
            for file in sorted((tmp_path / "a.zarr").rglob("*")):
                if file.is_file():
                    archive.write(file, str(file.relative_to(tmp_path / "a.zarr")))
    recording = read(path)
    wanted = FRAMES.copy()
    wanted[8:16] = 7
    assert np.array_equal(recording.pads["pad"].frames, wanted)
    # Frames beyond the last, of the last shard, are no pieces of the array.
    assert recording.notes == ("pieces are missing and read as what stands for nothing there: pressure (1)",)
    with open_recording(path) as opened:
        assert np.array_equal(opened.frames[15:18].pads["pad"].frames, wanted[15:18])


@settings(deadline=None)
@given(
    hnp.arrays(np.uint8, st.integers(0, 3000), elements=st.integers(0, 9)),
    st.sampled_from(["lz4", "lz4hc", "zlib", "zstd"]),
    st.sampled_from([0, 1, 2]),
    st.sampled_from([0, 64, 1000]),
    st.sampled_from([1, 2, 4, 8, 12]),
)
def test_blosc_as_its_library_packs(values: np.ndarray, name: str, shuffle: int, block: int, width: int) -> None:
    data = values[: len(values) // width * width].view(f"V{width}" if width > 1 else "u1")
    packed = bytes(numcodecs.Blosc(cname=name, shuffle=shuffle, blocksize=block).encode(np.ascontiguousarray(data)))
    assert from_blosc(packed, data.nbytes) == data.tobytes()
    if data.nbytes:
        with pytest.raises(ValueError, match="says"):
            from_blosc(packed, data.nbytes - 1)


@pytest.mark.parametrize("version", [2, 3])
def test_a_group_is_a_pad_and_attributes_say_what_is_known(tmp_path: Path, version: int) -> None:
    root = group(tmp_path / "a.zarr", version)
    palm = array(root, "hand/palm/pressure", FRAMES, chunks=(16, 4, 5))
    palm.attrs.update(
        {"pitch_m": [0.001, 0.002], "unit": "kPa", "who": {"a": None}, "odd": [[1], [2, 3]], "big": 10**30}
    )
    array(root, "hand/palm/valid", np.arange(20).reshape(4, 5) != 3)
    array(root, "tip/pressure", FRAMES[:, :2].astype(np.float32))
    root["tip"].attrs["polarity"] = "down"
    array(root, "time_s", np.arange(50) / 100)
    array(root, "press", np.arange(50) // 25)
    array(root, "presses/label", np.array(["cône", "cube"]))
    array(root, "signals/shear", np.ones((50, 2)))
    array(root, "more", np.ones(3))
    recording = read(tmp_path / "a.zarr")
    assert list(recording.pads) == ["hand/palm", "tip"]
    assert recording.pads["hand/palm"].pitch_m == (0.001, 0.002)
    assert recording.pads["hand/palm"].valid is not None
    assert recording.pads["tip"].polarity == "down"
    assert recording.unit == "kPa"
    assert recording.presses.columns["label"].tolist() == ["cône", "cube"]
    assert recording.signals["shear"].values.shape == (50, 2)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == (np.arange(50) / 100).tolist()
    assert recording.notes == ("passed over, for it is no part of a recording: more",)


def test_data_sets_for_learning(tmp_path: Path) -> None:
    """Arrays under ``data``, ends of episodes under ``meta``, in an archive."""
    store = zarr.storage.ZipStore(str(tmp_path / "set.zarr.zip"), mode="w")
    root = zarr.open_group(store, mode="w", zarr_format=2)
    array(root, "data/tactile_left", FRAMES, chunks=(7, 4, 5))
    array(root, "data/pose", np.ones((50, 6)))
    array(root, "meta/episode_ends", np.array([20, 50]))
    store.close()
    recording = read(tmp_path / "set.zarr.zip")
    assert np.array_equal(recording.pads["pad"].frames, FRAMES)
    assert list(recording.presses.frames) == [range(20), range(20, 50)]
    assert recording.notes == (
        "taken for frames, by shape and name: data/tactile_left",
        "each of 2 episodes is a press",
    )


@pytest.mark.parametrize("version", [2, 3])
def test_an_array_alone(tmp_path: Path, version: int) -> None:
    made = zarr.create_array(str(tmp_path / "a.zarr"), data=FRAMES, chunks=(16, 4, 5), zarr_format=version)
    made.attrs["unit"] = "kPa"
    recording = read(tmp_path / "a.zarr")
    assert np.array_equal(recording.pads["pad"].frames, FRAMES)
    assert recording.unit == "kPa"
    assert recording.notes == ("taken for frames, by shape and name: array",)


def test_pieces_that_nobody_wrote_are_told(tmp_path: Path) -> None:
    made = array(group(tmp_path / "a.zarr"), "pressure", FRAMES + 1, chunks=(10, 4, 5), fill_value=7)
    (tmp_path / "a.zarr/pressure/c/2/0/0").unlink()
    recording = read(tmp_path / "a.zarr")
    assert np.array_equal(recording.pads["pad"].frames, made[:])
    assert (recording.pads["pad"].frames[20:30] == 7).all()
    assert recording.notes == ("pieces are missing and read as what stands for nothing there: pressure (1)",)


def test_what_no_recording_holds_is_passed_over(tmp_path: Path) -> None:
    root = group(tmp_path / "a.zarr", 2)
    array(root, "pressure", FRAMES)
    array(root, "when", np.zeros(3, "M8[s]"))
    array(root, "pairs", np.zeros(3, [("a", "i4"), ("b", "f8")]))
    array(root, "wave", np.zeros(3, complex))
    root.create_array("names", shape=(2,), dtype=str)[:] = ["a", "b"]
    assert read(tmp_path / "a.zarr").notes == ("passed over: names, pairs, wave, when",)


def said(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def spoil(path: Path) -> None:
        file = path / "pressure/zarr.json"
        info = json.loads(file.read_text())
        change(info)
        file.write_text(json.dumps(info))

    return spoil


def piece(change: Callable[[bytes], bytes]) -> Callable[[Path], object]:
    def spoil(path: Path) -> None:
        file = path / "pressure/c/1/0/0"
        file.write_bytes(change(file.read_bytes()))

    return spoil


def _pipeline(info: dict[str, Any], *names: str) -> None:
    info["codecs"] = [{"name": name, "configuration": {}} for name in names]


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "not json": (lambda p: (p / "pressure/zarr.json").write_text("{"), "pressure/zarr.json: is not complete JSON"),
    "no object": (lambda p: (p / "pressure/zarr.json").write_text("[]"), "pressure/zarr.json: must be an object, got list"),
    "version": (said(lambda i: i.update(zarr_format=4)), "pressure: is of version 4; 2 and 3 are read"),
    "no type": (said(lambda i: i.pop("data_type")), "pressure: is damaged or cut off: 'data_type'"),
    "negative": (said(lambda i: i.update(shape=[-5, 4, 5])), r"pressure: is damaged or cut off: sides must be whole numbers from 0 on, got \[-5, 4, 5\]"),
    "empty pieces": (said(lambda i: i["chunk_grid"]["configuration"].update(chunk_shape=[0, 4, 5])), "sides must be whole numbers from 1 on"),
    "other sides": (said(lambda i: i["chunk_grid"]["configuration"].update(chunk_shape=[4, 5])), "has pieces of 2 sides in an array of 3"),
    "large pieces": (said(lambda i: i["chunk_grid"]["configuration"].update(chunk_shape=[10**7, 4, 5])), "stands in pieces of 400000000 bytes; 67108864 are the most"),
    "bomb": (said(lambda i: i.update(shape=[10**9, 4, 5])), r"pressure: stands in 62500000 pieces|holds 40000000000 bytes in \d+; nothing is so empty"),
    "grid": (said(lambda i: i["chunk_grid"].update(name="odd")), "on a grid that is not regular"),
    "packer": (said(lambda i: _pipeline(i, "bytes", "pickle")), "pressure: is packed by pickle, which is not read here; copy it with zstd, gzip or blosc"),
    "packed twice": (said(lambda i: _pipeline(i, "bytes", "zstd", "gzip")), "is packed by gzip, which is not read"),
    "no bytes": (said(lambda i: _pipeline(i)), "is packed by nothing that makes bytes of numbers"),
    "turned": (said(lambda i: i["codecs"].insert(0, {"name": "transpose", "configuration": {"order": [0, 0, 1]}})), "turns axes by .* which is no order of 3"),
    "cut piece": (piece(lambda b: b[:-9]), "pressure/c/1/0/0: is damaged or cut off"),
    "empty piece": (piece(lambda b: b""), "pressure/c/1/0/0: is damaged or cut off: it unpacks to 0 bytes, 640 are announced"),
    "no piece": (piece(lambda b: b"hello" * 9), "pressure/c/1/0/0: is damaged or cut off"),
    "large piece": (piece(lambda b: b * 900), "pressure/c/1/0/0: is larger than 5376 bytes; such a piece never is"),
    "other length": (said(lambda i: i["chunk_grid"]["configuration"].update(chunk_shape=[17, 4, 5])), r"c/0/0/0: is damaged or cut off: it unpacks to 640 bytes, 680 are announced"),
    "fill": (said(lambda i: i.update(fill_value="NaN")), "what stands for nothing there is NaN, which is no uint16"),
    "fill text": (said(lambda i: i.update(fill_value="none")), "what stands for nothing there must be a number, got 'none'"),
    "fill beyond": (said(lambda i: i.update(fill_value=70_000)), "what stands for nothing there is 70000, which is no uint16"),
    "many frames of nothing": (said(lambda i: i.update(shape=[1 << 40, 4, 0])), r"stands in \d+ pieces; at most"),
    "no frames": (said(lambda i: i.update(shape=[0, 4, 5])), "needs at least one frame"),
    "no arrays": (lambda p: (p / "pressure/zarr.json").unlink(), "holds no array of frames"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_data_sets_are_told_in_one_line(tmp_path: Path, case: str) -> None:
    path = tmp_path / "a.zarr"
    array(group(path), "pressure", FRAMES, chunks=(16, 4, 5))
    spoil, message = BAD[case]
    spoil(path)
    with pytest.raises(FormatError, match=message) as error:
        read(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def shard(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    return said(lambda info: change(info["codecs"][0]["configuration"]))


def index(*entries: int) -> Callable[[Path], object]:
    """Overwrite the first entries of the last index."""

    def spoil(path: Path) -> None:
        file = path / "pressure/c/0/0/0"
        content = bytearray(file.read_bytes())
        content[-68 : -68 + 8 * len(entries)] = np.array(entries, "<u8").tobytes()
        file.write_bytes(content)

    return spoil


BAD_SHARDS: dict[str, tuple[Callable[[Path], object], str]] = {
    "sides": (shard(lambda c: c.update(chunk_shape=[5, 4, 5])), r"has shards of \[32, 4, 5\] that \[5, 4, 5\] do not fill"),
    "fewer sides": (shard(lambda c: c.update(chunk_shape=[8, 4])), "that \\[8, 4\\] do not fill"),
    "no side": (shard(lambda c: c.update(chunk_shape=[0, 4, 5])), "sides must be whole numbers from 1 on"),
    "within shards": (shard(lambda c: c["codecs"].insert(0, {"name": "sharding_indexed"})), "has shards within shards"),
    "packed again": (said(lambda i: i["codecs"].append({"name": "zstd"})), "packs its shards again"),
    "packed index": (shard(lambda c: c["index_codecs"].append({"name": "zstd"})), "has shards whose index is packed"),
    "index somewhere": (shard(lambda c: c.update(index_location="middle")), "or stands at 'middle'"),
    "many": (said(lambda i: (i["chunk_grid"]["configuration"].update(chunk_shape=[8 << 23, 4, 5]))), "has shards of 8388608 pieces"),
    "no room": (lambda p: (p / "pressure/c/0/0/0").write_bytes(b"?" * 67), "a shard of 67 bytes has no room for its index of 68"),
    "beyond": (index(0, 10**6), "its index says places beyond its"),
    "far beyond": (index(2**64 - 2, 5), "its index says places beyond its"),
    "half nothing": (index(2**64 - 1, 5), "its index says places beyond its"),
    "twice": (index(0, 300, 0, 300, 0, 300, 0, 300), "its index says more than its .* bytes, some of them twice"),
    "short piece": (index(0, 3), "piece 0, 0, 0: is damaged or cut off"),
    "empty piece": (index(5, 0), "piece 0, 0, 0: is damaged or cut off"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD_SHARDS)
def test_bad_shards_are_told_in_one_line(tmp_path: Path, case: str) -> None:
    sharded(tmp_path / "a.zarr")
    spoil, message = BAD_SHARDS[case]
    spoil(tmp_path / "a.zarr")
    with pytest.raises(FormatError, match=message) as error:
        read(tmp_path / "a.zarr")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("packer", [numcodecs.BZ2(), numcodecs.LZMA(), numcodecs.Blosc(cname="blosclz")])
def test_other_packers_are_refused_by_name(tmp_path: Path, packer: Any) -> None:
    array(group(tmp_path / "a.zarr", 2), "pressure", FRAMES, compressors=packer)
    with pytest.raises(FormatError, match=r"packed by (bz2|lzma|blosclz).*not read"):
        read(tmp_path / "a.zarr")


def test_an_archive_that_lacks_pieces_is_read_where_it_is_whole(tmp_path: Path) -> None:
    """A name that is damaged in its list alone looks like a piece that nobody wrote."""
    path = tmp_path / "a.zarr.zip"
    store = zarr.storage.ZipStore(str(path), mode="w")
    array(zarr.open_group(store, mode="w"), "pressure", FRAMES, chunks=(10, 4, 5))
    store.close()
    content = path.read_bytes()
    at = content.rfind(b"pressure/c/3/0/0")
    path.write_bytes(content[:at] + b"prassure/c/3/0/0" + content[at + 16 :])
    with pytest.raises(FormatError, match=r"a\.zarr\.zip: is damaged"):
        read(path)
    path.write_bytes(content.replace(b"pressure/c/3/0/0", b"prassure/c/3/0/0"))
    assert "pieces are missing and read as what stands for nothing there: pressure (1)" in read(path).notes


def test_an_archive_is_whole_where_nobody_looks_too(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr.zip"
    store = zarr.storage.ZipStore(str(path), mode="w")
    array(zarr.open_group(store, mode="w"), "pressure", FRAMES)
    store.close()
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("notes.txt", "who pressed what")
    assert read(path).n_frames == len(FRAMES)
    path.write_bytes(path.read_bytes().replace(b"who pressed what", b"who pressed whet"))
    with pytest.raises(FormatError, match=r"a\.zarr\.zip: is damaged: the member 'notes\.txt'"):
        read(path)


def test_archives_that_are_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr.zip"
    store = zarr.storage.ZipStore(str(path), mode="w")
    array(zarr.open_group(store, mode="w"), "pressure", FRAMES)
    store.close()
    whole = path.read_bytes()
    for length in (100, len(whole) // 2, len(whole) - 5):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"a\.zarr\.zip: .*is damaged or cut off"):
            read(path)
