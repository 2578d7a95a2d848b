"""What a file may hold at most: just so much is read, one more is refused and told."""

from __future__ import annotations

import json
import math
import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st
from tests.test_recording_matlab import HEAD as HEAD_MAT5
from tests.test_recording_matlab import element, matrix

from varishold import FormatError
from varishold.recording import read
from varishold.recording.formats.hdf5_file import WIDTH, Hdf5File
from varishold.recording.formats.parquet_column import ParquetColumn, opened_parquet
from varishold.recording.formats.zarr_arrays import ZarrGroups
from varishold.recording.formats.zarr_store import FolderStore

FRAMES = np.arange(5 * 3 * 4, dtype=np.uint16).reshape(5, 3, 4)
MB = 1 << 20


def refused(act: Any, *words: str) -> None:
    """Assert that something is refused in one line with some words in it."""
    with pytest.raises(FormatError) as error:
        act()
    assert "\n" not in str(error.value)
    for each in words:
        assert each in str(error.value), str(error.value)


def lengthened(path: Path, n_bytes: int) -> None:
    """Make a file longer by a hole."""
    with path.open("r+b") as file:
        file.truncate(n_bytes)


# HDF5


@pytest.mark.parametrize(("depth", "fits"), [(7, True), (8, False)])
def test_hdf5_is_looked_into_eight_groups_deep(tmp_path: Path, depth: int, fits: bool) -> None:
    """Counted with the dataset in the last."""
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["/".join("g" * depth) + "/pressure"] = FRAMES
    if fits:
        assert list(read(path).pads) == ["/".join("g" * depth)]
    else:
        refused(lambda: read(path), f"{path}: holds groups within more than 8 others, or too many")


def test_so_many_objects_of_hdf5_are_looked_at(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    space, kind = h5py.h5s.create(h5py.h5s.SCALAR), h5py.h5t.NATIVE_UINT8
    with h5py.File(path, "w", libver="latest") as file:
        for k in range(16384):
            h5py.h5d.create(file.id, b"%d" % k, kind, space)
    opened = Hdf5File(path)
    assert len(opened.datasets) == 16384
    opened.close()
    with h5py.File(path, "r+", libver="latest") as file:
        h5py.h5d.create(file.id, b"more", kind, space)
    opened = Hdf5File(path)
    refused(lambda: opened.datasets, "or too many")
    opened.close()


#: Bytes that are said to be there, those in the file, and whether that can be.
so_many_bytes = pytest.mark.parametrize(
    ("n_bytes", "in_file", "fits"),
    [
        (256 * MB, 0, True),
        (256 * MB + 1, 0, False),
        (300 * MB, MB, True),
        (300 * MB + 1, MB, False),
        (300 * MB + 299, MB + 1, True),
    ],
)


@so_many_bytes
def test_hdf5_may_say_so_many_bytes_or_so_many_times_its_own(
    tmp_path: Path, n_bytes: int, in_file: int, fits: bool
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("pressure", (n_bytes,), "u1", chunks=(MB,))
    if in_file:
        lengthened(path, in_file)
    opened = Hdf5File(path)
    try:
        held = opened.datasets["pressure",]
        if fits:
            held.check()
            assert held[n_bytes - 3 :].tolist() == [0, 0, 0]
        else:
            told = f"pressure: holds {n_bytes} bytes in a file of {path.stat().st_size}; nothing is so empty"
            refused(held.check, told)
            refused(lambda: held[:1], told)
    finally:
        opened.close()


@pytest.mark.parametrize(("n_bytes", "fits"), [(64 * MB, True), (64 * MB + 1, False)])
def test_what_is_no_column_and_packed_pieces_of_hdf5_have_so_many_bytes(
    tmp_path: Path, n_bytes: int, fits: bool
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("small", (n_bytes,), "u1", chunks=(MB,))
        file.create_dataset("packed", (n_bytes,), "u1", chunks=(n_bytes,), compression="gzip")
    opened = Hdf5File(path)
    try:
        small, packed = opened.datasets["small",], opened.datasets["packed",]
        if fits:
            assert small.small().shape == (n_bytes,)
            packed.check()
        else:
            refused(small.small, f"small: has {n_bytes} entries; so many are frames only")
            told = f"packed: is packed in pieces of {n_bytes} bytes; {64 * MB} are the most (h5repack -l CHUNK=)"
            refused(packed.check, told)
    finally:
        opened.close()


@pytest.mark.parametrize("chunk", [1000, 5000, 5050])
@pytest.mark.parametrize("spare", [0, 1])
def test_a_piece_of_hdf5_is_hardly_packed_into_more_than_it_holds(tmp_path: Path, chunk: int, spare: int) -> None:
    """By a fiftieth and a kilobyte, at most."""
    path = tmp_path / "a.h5"
    size = chunk + chunk // 50 + 1024 + spare
    with h5py.File(path, "w") as file:
        held = file.create_dataset("pressure", (2 * chunk,), "u1", chunks=(chunk,), compression="gzip")
        held.id.write_direct_chunk((0,), zlib.compress(bytes(chunk)))
        held.id.write_direct_chunk((chunk,), zlib.compress(bytes(chunk)).ljust(size, b"\0"))
    opened = Hdf5File(path)
    try:
        if spare:
            told = f"pressure: is damaged: a piece of {chunk} bytes is packed into {size}"
            refused(opened.datasets["pressure",].check, told)
        else:
            assert opened.datasets["pressure",].read(slice(0, 3)).tolist() == [0, 0, 0]
    finally:
        opened.close()


@pytest.mark.parametrize("chunk", [MB, MB + 8])
def test_pieces_of_hdf5_above_a_megabyte_are_unpacked_beforehand(tmp_path: Path, chunk: int) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        held = file.create_dataset("pressure", (3 * chunk,), "u1", chunks=(chunk,), compression="gzip")
        for k, more in enumerate((0, 1, 0)):
            held.id.write_direct_chunk((k * chunk,), zlib.compress(bytes([7]) * (chunk + more)))
    opened = Hdf5File(path)
    try:
        held = opened.datasets["pressure",]
        for wanted in (slice(0, chunk), slice(3, 5), slice(2 * chunk, 3 * chunk), slice(3 * chunk - 1, None)):
            assert set(held[wanted].tolist()[:3]) == {7}
        for wanted in (slice(chunk, chunk + 1), slice(chunk - 1, chunk + 1), slice(2 * chunk - 1, 2 * chunk)):
            if chunk > MB:
                refused(lambda: held[wanted], f"pressure: a piece of {chunk} bytes would unpack to more")  # noqa: B023
    finally:
        opened.close()


@pytest.mark.parametrize(("width", "kept"), [(0, 3), (1, 1), (3, 3), (9, 9), (1 << 16, 1 << 16), ((1 << 16) + 1, 3)])
def test_a_text_of_hdf5_is_as_wide_as_it_says(tmp_path: Path, width: int, kept: int) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("label", data=np.array([b"abc", b"de"]))
        file["label"].attrs[WIDTH] = width
    opened = Hdf5File(path)
    try:
        assert opened.datasets["label",].small().dtype == np.dtype(f"U{kept}")
    finally:
        opened.close()


def test_what_hdf5_says_of_nothing_it_holds_is_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["g/a"], file["g/n"], file["one"] = FRAMES, 5, np.float32(2)
        file["g/soft"], file["g/other"] = h5py.SoftLink("/one"), h5py.ExternalLink("b.h5", "/x")
        file.attrs["n"], file.attrs["b"], file.attrs["pair"] = 3, True, np.zeros(2, "i4,f4")
        file["g"].attrs["text"] = "ü"
    opened = Hdf5File(path)
    try:
        assert list(opened.datasets) == [("g", "a"), ("g", "n"), ("one",)]
        assert sorted(opened.passed) == ["the link g/other", "the link g/soft"]
        assert [each.is_numbers for each in opened.datasets.values()] == [True, False, False]
        assert {name: value.item() for name, value in opened.attributes().items()} == {"n": 3, "b": True}
        assert opened.attributes("g")["text"].item() == "ü"
        assert opened.datasets["g", "n"].read().item() == 5
        assert opened.datasets["g", "a"].place == f"{path}: g/a"
        np.testing.assert_array_equal(
            opened.datasets["g", "a"].read(slice(1, 4), slice(None), slice(2, None)), FRAMES[1:4, :, 2:]
        )
    finally:
        opened.close()
        opened.close()


@pytest.mark.parametrize("where", [0, 512, 1024, 2048, 4096, 8192, 16384, 32768])
def test_hdf5_may_stand_behind_the_head_of_something_else(tmp_path: Path, where: int) -> None:
    path = tmp_path / "a"
    with h5py.File(path, "w", userblock_size=where) as file:
        file["pressure"] = FRAMES
    np.testing.assert_array_equal(read(path).pads["pad"].frames, FRAMES)


# Zarr


def zarr_array(path: Path, shape: list[int], pieces: list[int], *, kind: str = "uint8", **more: Any) -> Path:
    """Write what an array says of itself, and none of its pieces."""
    path.mkdir(parents=True)
    said = {
        "zarr_format": 3,
        "node_type": "array",
        "shape": shape,
        "data_type": kind,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": pieces}},
        "chunk_key_encoding": {"name": "default"},
        "codecs": [{"name": "bytes"}],
        "fill_value": 0,
        **more,
    }
    (path / "zarr.json").write_text(json.dumps(said))
    return path


@pytest.mark.parametrize(("depth", "fits"), [(8, True), (9, False)])
def test_zarr_is_looked_into_eight_groups_deep(tmp_path: Path, depth: int, fits: bool) -> None:
    path = tmp_path / "a"
    for k in range(depth):
        here = path.joinpath(*"g" * k)
        here.mkdir(parents=True, exist_ok=True)
        (here / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group"}')
    zarr_array(path.joinpath(*"g" * depth), [5, 3, 4], [5, 3, 4])
    groups = ZarrGroups(FolderStore(path))
    if fits:
        assert list(groups.datasets) == [tuple("g" * depth)]
    else:
        refused(lambda: groups.datasets, f"{path}: holds groups within more than 8 others, or too many")


@pytest.mark.parametrize(("many", "fits"), [(16384, True), (16385, False)])
def test_so_many_objects_of_zarr_are_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, many: int, fits: bool
) -> None:
    """Beside the group in which they are."""
    (tmp_path / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group"}')
    store = FolderStore(tmp_path)
    monkeypatch.setattr(store, "groups", lambda key: iter([] if key else map(str, range(many))))
    groups = ZarrGroups(store)
    if fits:
        assert groups.datasets == {}
    else:
        refused(lambda: groups.datasets, "or too many")


@so_many_bytes
def test_zarr_may_say_so_many_bytes_or_so_many_times_those_of_its_pieces(
    tmp_path: Path, n_bytes: int, in_file: int, fits: bool
) -> None:
    path = zarr_array(tmp_path / "a", [n_bytes], [4 * MB])
    if in_file:
        (path / "c").mkdir()
        (path / "c/1").touch()
        lengthened(path / "c/1", in_file)
    (held,) = ZarrGroups(FolderStore(path)).datasets.values()
    assert held.missing == math.ceil(n_bytes / (4 * MB)) - (in_file > 0)
    if fits:
        held.check()
    else:
        refused(held.check, f"array: holds {n_bytes} bytes in {in_file}; nothing is so empty")


@pytest.mark.parametrize(("n_bytes", "fits"), [(64 * MB, True), (64 * MB + 1, False)])
def test_what_is_no_column_and_pieces_of_zarr_have_so_many_bytes(tmp_path: Path, n_bytes: int, fits: bool) -> None:
    (held,) = ZarrGroups(FolderStore(zarr_array(tmp_path / "a", [n_bytes], [32 * MB]))).datasets.values()
    large = ZarrGroups(FolderStore(zarr_array(tmp_path / "b", [n_bytes], [n_bytes])))
    if fits:
        assert held.small().shape == (n_bytes,)
        assert large.datasets["array",].shape == (n_bytes,)
    else:
        refused(held.small, f"array: has {n_bytes} entries; so many are frames only")
        refused(lambda: large.datasets, f"array: stands in pieces of {n_bytes} bytes; {64 * MB} are the most")


@pytest.mark.parametrize(("many", "fits"), [(1 << 22, True), ((1 << 22) + 1, False)])
def test_an_array_of_zarr_has_so_many_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, many: int, fits: bool
) -> None:
    """Those on a side without any entry count as one."""
    monkeypatch.setattr(FolderStore, "size", lambda self, key: (self._path / key).stat().st_size if "." in key else 1)
    (held,) = ZarrGroups(FolderStore(zarr_array(tmp_path / "a", [many, 0], [1, 1]))).datasets.values()
    if fits:
        held.check()
    else:
        refused(held.check, f"array: stands in {many} pieces; at most {1 << 22} are read")


@pytest.mark.parametrize(
    ("shape", "fits"),
    [([1] * 8, True), ([1] * 9, False), ([(1 << 48) - 1], True), ([1 << 48], False), ([0], True), ([-1], False)],
)
def test_an_array_of_zarr_has_so_many_sides_of_such_lengths(tmp_path: Path, shape: list[int], fits: bool) -> None:
    groups = ZarrGroups(FolderStore(zarr_array(tmp_path / "a", shape, [1] * len(shape))))
    if fits:
        assert groups.datasets["array",].shape == tuple(shape)
    elif len(shape) > 1:
        refused(lambda: groups.datasets, "array: is damaged or cut off: it has 9 axes")
    else:
        refused(lambda: groups.datasets, f"sides must be whole numbers from 0 on, got {shape}")


@pytest.mark.parametrize("spare", [0, 1])
def test_a_piece_of_zarr_is_packed_into_twice_what_it_holds_at_most(tmp_path: Path, spare: int) -> None:
    """And four kilobytes."""
    path = zarr_array(tmp_path / "a", [100], [100])
    (path / "c").mkdir()
    (path / "c/0").write_bytes(bytes(200 + 4096 + spare))
    (held,) = ZarrGroups(FolderStore(path)).datasets.values()
    if spare:
        refused(lambda: held[:], f"{path / 'c/0'}: is larger than 4296 bytes; such a piece never is")
    else:
        refused(lambda: held[:], f"{path / 'c/0'}: is damaged or cut off: it unpacks to 4296 bytes, 100 are announced")


@given(
    st.sampled_from(["uint8", "int16", "uint32", "int64", "float32", "float64", "bool"]),
    st.sampled_from([None, 0, 1, 3, True, "NaN", "Infinity", "-Infinity", "0x3", 2.0, 0.5]),
)
def test_what_stands_where_no_piece_is_is_a_number_of_its_kind(
    tmp_path_factory: pytest.TempPathFactory, kind: str, fill: Any
) -> None:
    path = zarr_array(tmp_path_factory.mktemp("zarr") / "a", [2], [2], kind=kind, fill_value=fill)
    groups = ZarrGroups(FolderStore(path))
    whole = np.dtype(kind).kind != "f"
    if whole and (fill in ("NaN", "Infinity", "-Infinity", 0.5) or (kind == "bool" and fill in (3, 2.0))):
        refused(lambda: groups.datasets, "array: is damaged or cut off: what stands for nothing there is", kind)
        return
    if kind == "bool" and fill == "0x3":
        return
    expected: Any = {None: 0, "NaN": np.nan, "Infinity": np.inf, "-Infinity": -np.inf}.get(fill, fill)
    dtype = np.dtype(kind)
    if fill == "0x3":
        expected = np.array(3, f"u{dtype.itemsize}").view(dtype)
    np.testing.assert_array_equal(groups.datasets["array",][:], np.array([expected] * 2, dtype))


# MATLAB 5 to 7


def mat5(path: Path, *elements: bytes) -> Path:
    path.write_bytes(HEAD_MAT5 + b"".join(elements))
    return path


def struct_of(width: int, names: list[str]) -> bytes:
    letters = b"".join(name.encode().ljust(width, b"\0") for name in names)
    numbers = matrix(6, (1, 1), "", element(9, struct.pack("<d", 5)))
    return element(5, struct.pack("<i", width)) + element(1, letters) + numbers * len(names)


@pytest.mark.parametrize(
    ("width", "names", "fits"),
    [
        (1, ["a"], True),
        (256, ["a", "b"], True),
        (257, ["a", "b"], False),
        (0, [], False),
        (32, ["abc", "d"] * 2048, True),
        (32, ["a"] * 4097, False),
    ],
)
def test_a_struct_of_matlab_has_so_many_fields_of_such_names(
    tmp_path: Path, width: int, names: list[str], fits: bool
) -> None:
    path = mat5(tmp_path / "a.mat", matrix(2, (1, 1), "s", struct_of(width, names)), MAT5_FRAMES)
    if fits:
        assert read(path).n_frames == 5
    else:
        refused(lambda: read(path), f"a struct has {width * len(names)} letters of names, {width} each")


MAT5_FRAMES = matrix(11, (5, 3, 4), "pressure", element(4, np.asfortranarray(FRAMES).tobytes("F")))


@pytest.mark.parametrize(("many", "fits"), [(1 << 20, True), ((1 << 20) + 1, False)])
def test_a_cell_of_matlab_has_so_many_entries(tmp_path: Path, many: int, fits: bool) -> None:
    """The first of which is no text, so that nobody looks at the others."""
    number = matrix(6, (1, 1), "", element(9, bytes(8)))
    path = mat5(tmp_path / "a.mat", matrix(1, (1, many), "c", number + bytes(many)), MAT5_FRAMES)
    if fits:
        assert read(path).notes == ("passed over: c (a cell)",)
    else:
        refused(lambda: read(path), f"a cell of {many} entries is announced")


def test_every_kind_of_element_of_matlab_is_that_of_numpy(tmp_path: Path) -> None:
    kinds = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
    classes = {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
    values = np.arange(12).reshape(1, 3, 4)
    for kind, stored in kinds.items():
        for number, meant in classes.items():
            held = matrix(number, (1, 3, 4), "pressure", element(kind, values.astype(stored).tobytes("F")))
            frames = read(mat5(tmp_path / "a.mat", held)).pads["pad"].frames
            assert frames.dtype == np.dtype(meant)
            np.testing.assert_array_equal(frames, values)
    for kind in (0, 8, 10, 11, 14, 18):
        held = matrix(6, (1, 3, 4), "pressure", element(kind, bytes(96)))
        path = mat5(tmp_path / "a.mat", held)
        refused(lambda: read(path), f"an element of kind {kind} stands where numbers should be")  # noqa: B023


@pytest.mark.parametrize("order", "<>")
def test_matlab_of_either_order_of_bytes(tmp_path: Path, order: str) -> None:
    """With text of one, two and four bytes a letter, and what is short within the tag."""

    def part(kind: int, data: bytes) -> bytes:
        if len(data) <= 4:
            return struct.pack(f"{order}I", len(data) << 16 | kind) + data.ljust(4, b"\0")
        return struct.pack(f"{order}II", kind, len(data)) + data + bytes(-len(data) % 8)

    def whole(kind: int, shape: tuple[int, ...], name: str, rest: bytes, flags: int = 0) -> bytes:
        told = part(6, struct.pack(f"{order}II", kind | flags, 0))
        return part(14, told + part(5, struct.pack(f"{order}{len(shape)}i", *shape)) + part(1, name.encode()) + rest)

    head = b"MATLAB 5.0 MAT-file".ljust(124) + (b"\x00\x01IM" if order == "<" else b"\x01\x00MI")
    coding = "le" if order == "<" else "be"
    values = np.asfortranarray(FRAMES.astype(f"{order}u2"))
    mask = np.ones((3, 4), np.uint8)
    mask[1, 2] = 0
    text = {17: "utf-16", 4: "utf-16", 18: "utf-32"}
    for kind, length in ((16, 4), (2, 4), (1, 4), *((each, 4) for each in text)):
        letters = "kPäé" if kind == 16 else "kPaé"
        coded = letters.encode(f"{text[kind]}-{coding}" if kind in text else "utf-8" if kind == 16 else "latin-1")
        path = tmp_path / "a.mat"
        path.write_bytes(
            head
            + whole(11, (5, 3, 4), "pressure", part(4, values.tobytes("F")))
            + whole(9, (3, 4), "valid", part(2, mask.tobytes("F")), flags=0x0200)
            + whole(4, (1, length), "unit", part(kind, coded))
            + whole(6, (2, 2), "wave", part(9, bytes(32)) * 2, flags=0x0800)
            + whole(5, (2, 2), "thin", part(9, bytes(32)))
            + whole(2, (1, 2), "many", part(5, struct.pack(f"{order}i", 4)) + part(1, b""))
            + whole(3, (1, 1), "thing", b"")
        )
        recording = read(path)
        np.testing.assert_array_equal(recording.pads["pad"].frames, FRAMES)
        np.testing.assert_array_equal(recording.pads["pad"].valid, mask != 0)
        assert recording.unit == letters
        passed = "wave (complex), thin (a sparse matrix), many (an array of structs), thing (an object)"
        assert recording.notes == (f"passed over: {passed}",)


def test_texts_of_matlab_in_rows_and_in_cells(tmp_path: Path) -> None:
    labels = np.array(["cone", "a", ""], object)
    contents = {"pressure": FRAMES, "press": np.array([0, 0, 1, 1, 2], np.int32)}
    for packed in (False, True):
        scipy.io.savemat(tmp_path / "a.mat", contents | {"presses": {"label": labels}}, do_compression=packed)
        assert read(tmp_path / "a.mat").presses.columns["label"].tolist() == ["cone", "a", ""]
        rows = np.array(["cone", "a", "bb"])
        scipy.io.savemat(tmp_path / "a.mat", contents | {"presses": {"label": rows}}, do_compression=packed)
        assert read(tmp_path / "a.mat").presses.columns["label"].tolist() == ["cone", "a", "bb"]
        mixed = np.array(["cone", 5, "b"], object)
        scipy.io.savemat(tmp_path / "a.mat", contents | {"mixed": mixed}, do_compression=packed)
        assert read(tmp_path / "a.mat").notes == ("passed over: mixed (a cell)",)


# Parquet


def parquet(path: Path, **columns: Any) -> Path:
    pq.write_table(pa.table(columns), path)
    return path


@contextmanager
def column(path: Path, name: str = "x", n_bytes: int | None = None) -> Iterator[ParquetColumn]:
    file, binary = opened_parquet(path)
    with binary:
        yield ParquetColumn(str(path), file, name, os.path.getsize(path) if n_bytes is None else n_bytes)


@pytest.mark.parametrize(
    ("n_bytes", "in_file", "fits"),
    [
        (256 * MB, 0, True),
        (256 * MB + 1, 0, False),
        (300 * MB, MB, True),
        (300 * MB + 1, MB, False),
    ],
)
def test_parquet_may_say_so_many_bytes_or_so_many_times_its_own(
    tmp_path: Path, n_bytes: int, in_file: int, fits: bool
) -> None:
    with column(parquet(tmp_path / "a.parquet", x=np.arange(4, dtype=np.uint8)), n_bytes=in_file) as held:
        held.shape = (n_bytes,)
        if fits:
            held.check()
        else:
            refused(held.check, f"column x: holds {n_bytes} bytes in a file of {in_file}; nothing is so empty")


@pytest.mark.parametrize("fixed", [False, True])
@pytest.mark.parametrize(("depth", "width"), [(1, 2), (2, 4), (3, 8), (4, None)])
def test_lists_in_lists_of_parquet_are_looked_into_three_deep(
    tmp_path: Path, fixed: bool, depth: int, width: int | None
) -> None:
    kind: pa.DataType = pa.int16()
    values: Any = 5
    for _ in range(depth):
        kind, values = pa.list_(kind, 2) if fixed else pa.list_(kind), [values] * 2
    with column(parquet(tmp_path / "a.parquet", x=pa.array([values] * 3, kind))) as held:
        assert held.width == width
        if width is not None:
            assert held.shape == (3, *[2] * depth)
            np.testing.assert_array_equal(held[:], np.full((3, *[2] * depth), 5))


@pytest.mark.parametrize(("width", "fits"), [(1 << 24, True), ((1 << 24) + 1, False)])
def test_a_list_of_parquet_has_so_many_numbers(tmp_path: Path, width: int, fits: bool) -> None:
    flat = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(width, np.uint8)), width)
    with column(parquet(tmp_path / "a.parquet", x=flat)) as held:
        assert held.width == (width if fits else None)


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8", "?"])
def test_numbers_of_parquet_are_those_of_numpy(tmp_path: Path, dtype: str) -> None:
    values = np.array([0, 1, 1, 0, 1], dtype)
    others = {"t": pa.array(list("abcde")), "e": pa.array([[]] * 5, pa.list_(pa.int8()))}
    with column(parquet(tmp_path / "a.parquet", x=values, **others)) as held:
        assert held.dtype == np.dtype("u1" if dtype == "?" else dtype)
        np.testing.assert_array_equal(held[:], values)
        assert held[1:3].dtype == held.dtype
    for name in others:
        with column(tmp_path / "a.parquet", name) as held:
            assert held.width is None


def test_what_parquet_lacks_is_told_with_its_rows(tmp_path: Path) -> None:
    lists = [[k, k + 1] for k in range(5000)]
    for at, other, told in (
        (4095, [1], "has lists of 2 and of 1 from row 0 on"),
        (4096, [1, 2, 3], "has lists of 2 and of 3 from row 4096 on"),
        (4999, None, "says nothing in rows 4096 to 4999"),
        (0, [None, 1], "lacks numbers in rows 0 to 4095"),
    ):
        spoilt = [*lists[:at], other, *lists[at + 1 :]]
        path = parquet(tmp_path / "a.parquet", x=pa.array(spoilt, pa.list_(pa.int32())))
        with column(path) as held:
            refused(lambda: held[:], f"{path}: column x: {told}")
    with column(parquet(tmp_path / "a.parquet", x=pa.array([1.5, None], pa.float32()))) as held:
        np.testing.assert_array_equal(held[:], np.array([1.5, np.nan], np.float32))


@given(st.integers(1, 9000), st.lists(st.tuples(st.integers(0, 9000), st.integers(0, 5000)), max_size=6), st.data())
def test_rows_of_parquet_are_the_same_in_any_order_and_size_of_groups(
    tmp_path_factory: pytest.TempPathFactory, n: int, wanted: list[tuple[int, int]], data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("parquet") / "a.parquet"
    values = np.arange(2 * n, dtype=np.int32).reshape(n, 2)
    rows = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), 2)
    size = data.draw(st.sampled_from([7000, 4096, 1000, 1] if n < 500 else [7000, 4096, 1000]))
    pq.write_table(pa.table({"x": rows}), path, row_group_size=size)
    with column(path) as held:
        for first, many in wanted:
            np.testing.assert_array_equal(held[first : first + many], values[first : first + many])
