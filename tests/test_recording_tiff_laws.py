"""TIFF by a writer of our own, entry by entry: what is left out, each limit, each kind of number, both widths."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import FormatError
from varishold.recording import read

WIDTH, LENGTH, BITS, PACKING, PHOTOMETRIC, FILL, TOLD = 256, 257, 258, 259, 262, 266, 270
OFFSETS, TURN, SAMPLES, ROWS, COUNTS, PREDICTOR, TILES, KIND = 273, 274, 277, 278, 279, 317, 322, 339
SHORT, LONG, LONG8 = 3, 4, 16
FORMS = {SHORT: "H", LONG: "I", LONG8: "Q"}


def tiff(
    pages: list[dict[int, tuple[int, list[int]]]],
    strips: list[list[bytes]],
    *,
    order: str = "<",
    wide: bool = False,
) -> bytes:
    """Return a file: of each page the entries as (kind, numbers), its strips behind the head; places are filled in."""
    place, many = ("Q", "Q") if wide else ("I", "H")
    head = (b"II" if order == "<" else b"MM") + struct.pack(f"{order}H", 43 if wide else 42)
    head += struct.pack(f"{order}HH", 8, 0) if wide else b""
    body, begun = b"", len(head) + struct.calcsize(place)
    firsts: list[list[int]] = []
    for own in strips:
        firsts.append([])
        for strip in own:
            firsts[-1].append(begun + len(body))
            body += strip
    tables: list[bytes] = []
    at = begun + len(body)
    room = 8 if wide else 4
    for page, own in zip(pages, firsts, strict=True):
        entries = {**page}
        if OFFSETS not in entries:
            entries[OFFSETS] = (LONG8 if wide else LONG, own)
        size = struct.calcsize(f"{order}{many}") + len(entries) * (12 + 8 * wide) + struct.calcsize(f"{order}{place}")
        table, beyond = struct.pack(f"{order}{many}", len(entries)), b""
        for tag, (kind, numbers) in sorted(entries.items()):
            packed = struct.pack(f"{order}{len(numbers)}{FORMS[kind]}", *numbers)
            if len(packed) > room:
                value = struct.pack(f"{order}{place}", at + size + len(beyond))
                beyond += packed
            else:
                value = packed.ljust(room, b"\0")
            table += struct.pack(f"{order}HH{place}", tag, kind, len(numbers)) + value
        last = page is pages[-1]
        table += struct.pack(f"{order}{place}", 0 if last else at + size + len(beyond))
        tables.append(table + beyond)
        at += size + len(beyond)
    return head + struct.pack(f"{order}{place}", begun + len(body)) + body + b"".join(tables)


def entries(frame: np.ndarray, counts: list[int], rows: int) -> dict[int, tuple[int, list[int]]]:
    kind = {"u": 1, "i": 2, "f": 3}[frame.dtype.kind]
    said = {
        WIDTH: frame.shape[1],
        LENGTH: frame.shape[0],
        BITS: 8 * frame.dtype.itemsize,
        PACKING: 1,
        PHOTOMETRIC: 1,
        FILL: 1,
        TURN: 1,
        SAMPLES: 1,
        ROWS: rows,
        PREDICTOR: 1,
        KIND: kind,
    }
    return {tag: (LONG, [value]) for tag, value in said.items()} | {COUNTS: (LONG, counts)}


def strips_of(frame: np.ndarray, rows: int, order: str) -> list[bytes]:
    told = frame.astype(frame.dtype.newbyteorder(order))
    return [told[at : at + rows].tobytes() for at in range(0, len(frame), rows)]


def written(
    path: Path,
    frames: np.ndarray,
    *,
    rows: int,
    order: str = "<",
    wide: bool = False,
    without: tuple[int, ...] = (),
) -> Path:
    strips = [strips_of(frame, rows, order) for frame in frames]
    pages = []
    for frame, own in zip(frames, strips, strict=True):
        page = entries(frame, [len(strip) for strip in own], rows)
        pages.append({tag: value for tag, value in page.items() if tag not in without})
    path.write_bytes(tiff(pages, strips, order=order, wide=wide))
    return path


@settings(max_examples=60)
@given(
    shape=st.tuples(st.integers(1, 3), st.integers(1, 6), st.integers(1, 5)),
    dtype=st.sampled_from(["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"]),
    rows=st.integers(1, 9),
    order=st.sampled_from("<>"),
    wide=st.booleans(),
    left=st.sets(st.sampled_from([PACKING, FILL, TURN, SAMPLES, PREDICTOR])).map(sorted),
    seed=st.integers(0, 2**32 - 1),
)
def test_what_is_left_out_says_the_usual_and_numbers_stay(
    tmp_path_factory: pytest.TempPathFactory,
    shape: tuple[int, int, int],
    dtype: str,
    rows: int,
    order: str,
    wide: bool,
    left: list[int],
    seed: int,
) -> None:
    frames = np.random.default_rng(seed).integers(0, 100, shape).astype(dtype)
    whole = rows >= shape[1]
    # A page in one strip need not say how many rows that has, and unsigned numbers not that they are.
    without = (*left, *([ROWS] if whole else []), *([KIND] if dtype[0] == "u" else []))
    path = tmp_path_factory.mktemp("tiff") / "a.tif"
    recording = read(written(path, frames, rows=rows, order=order, wide=wide, without=without))
    np.testing.assert_array_equal(recording.pads["pad"].frames, frames)


def test_a_page_without_bits_is_black_and_white_and_refused(tmp_path: Path) -> None:
    frames = np.zeros((1, 2, 8), np.uint8)
    with pytest.raises(FormatError, match="has 1 bits of kind 1 a pixel"):
        read(written(tmp_path / "a.tif", frames, rows=2, without=(BITS,)))


@pytest.mark.parametrize("tag", [WIDTH, LENGTH, PHOTOMETRIC, COUNTS])
def test_what_a_page_must_say_is_asked_for(tmp_path: Path, tag: int) -> None:
    frames = np.ones((1, 3, 4), np.uint16)
    with pytest.raises(FormatError, match=r"a\.tif"):
        read(written(tmp_path / "a.tif", frames, rows=3, without=(tag,)))


@pytest.mark.parametrize(
    ("tag", "value", "words"),
    [
        (FILL, 2, "bits reversed"),
        (TURN, 2, "turned"),
        (SAMPLES, 2, "has colours"),
        (PHOTOMETRIC, 0, "black for the largest number"),
        (PHOTOMETRIC, 2, "has colours"),
        (PACKING, 2, "packed in way 2 with predictor 1"),
        (BITS, 24, "has 24 bits of kind 1"),
        (KIND, 4, "has 16 bits of kind 4"),
        (TILES, 16, "stands in tiles"),
        (WIDTH, 0, "is 3 x 0; it may have 1 to"),
    ],
)
def test_what_is_not_read_is_said(tmp_path: Path, tag: int, value: int, words: str) -> None:
    frame = np.ones((3, 4), np.uint16)
    strips = strips_of(frame, 3, "<")
    page = entries(frame, [len(strips[0])], 3) | {tag: (LONG, [value])}
    (tmp_path / "a.tif").write_bytes(tiff([page], [strips]))
    with pytest.raises(FormatError, match=words):
        read(tmp_path / "a.tif")


@pytest.mark.parametrize(("predictor", "dtype"), [(1, "u2"), (2, "u2"), (2, "i4"), (2, "f4"), (3, "f4"), (3, "f8")])
@pytest.mark.parametrize("packing", [8, 32946])
def test_what_was_taken_of_neighbours_is_put_back(tmp_path: Path, predictor: int, dtype: str, packing: int) -> None:
    frame = np.random.default_rng(3).integers(0, 3000, (4, 5)).astype(dtype)
    if predictor == 2:
        bits = frame.view(f"u{frame.dtype.itemsize}")
        data = np.diff(bits, axis=1, prepend=bits.dtype.type(0)).tobytes()
    elif predictor == 3:
        bytes_of = frame.astype(frame.dtype.newbyteorder(">")).view(np.uint8).reshape(4, 5, -1)
        planes = bytes_of.transpose(0, 2, 1).reshape(4, -1)
        data = np.diff(planes, axis=1, prepend=np.uint8(0)).tobytes()
    else:
        data = frame.tobytes()
    strips = [zlib.compress(data)]
    page = entries(frame, [len(strips[0])], 4)
    page |= {PACKING: (LONG, [packing]), PREDICTOR: (LONG, [predictor])}
    (tmp_path / "a.tif").write_bytes(tiff([page], [strips]))
    np.testing.assert_array_equal(read(tmp_path / "a.tif").pads["pad"].frames[0], frame)
