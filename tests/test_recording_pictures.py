"""Depth pictures: what OpenCV writes is read, its numbers untouched; order, sizes and damage of folders are told."""
# ruff: noqa: E501

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import FormatError, InputError
from varishold import open as open_recording
from varishold.cli.app import app
from varishold.recording import read
from varishold.recording.formats import is_folder
from varishold.sensor import find_sensor_file, read_sensor

Image = pytest.importorskip("PIL.Image")
FRAMES = (np.arange(5 * 6 * 8).reshape(5, 6, 8) * 97).astype(np.uint16)


def put(path: Path, frame: np.ndarray, *how: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), frame, how)


def folder_of(path: Path, frames: np.ndarray = FRAMES, ending: str = "png") -> Path:
    for k, frame in enumerate(frames):
        put(path / f"depth_{k + 7}.{ending}", frame)
    return path


def chunk(name: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def png(cols: int, rows: int, bits: int, kind: int, data: bytes) -> bytes:
    head = struct.pack(">IIBBBBB", cols, rows, bits, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


@settings(deadline=None)
@given(
    st.sampled_from([("png", "u1"), ("png", "u2"), ("tiff", "u1"), ("tiff", "u2"), ("tiff", "f4")]).flatmap(
        lambda kind: st.tuples(
            st.just(kind[0]),
            hnp.arrays(
                np.dtype(kind[1]),
                st.tuples(st.integers(2, 9), st.integers(2, 9)),
                elements=st.floats(0, 1e6, width=32) if kind[1] == "f4" else None,
            ),
        )
    )
)
def test_what_opencv_writes_is_read_number_by_number(
    tmp_path_factory: pytest.TempPathFactory, written: tuple[str, np.ndarray]
) -> None:
    ending, frame = written
    path = tmp_path_factory.mktemp("picture") / f"a.{ending}"
    put(path, frame)
    pad = read(path).pads["pad"]
    assert pad.frames.dtype == frame.dtype
    assert np.array_equal(pad.frames, frame[None])
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), pad.frames[0])


@pytest.mark.parametrize("dtype", ["u1", "u2", "i2", "i4", "f4", "f8"])
@pytest.mark.parametrize("predictor", [1, 2, 3])
@pytest.mark.parametrize("packing", [1, 5, 8, 32946])
def test_the_packings_of_tiff(tmp_path: Path, packing: int, predictor: int, dtype: str) -> None:
    frame = (np.arange(70 * 90).reshape(70, 90) % 251 * 7 % 127).astype(dtype)
    how = (
        cv2.IMWRITE_TIFF_COMPRESSION,
        packing,
        cv2.IMWRITE_TIFF_PREDICTOR,
        predictor,
        cv2.IMWRITE_TIFF_ROWSPERSTRIP,
        16,
    )
    try:
        put(tmp_path / "a.tif", frame, *how)
    except (cv2.error, AssertionError):
        pytest.skip("no such predictor for such numbers")
    assert np.array_equal(cv2.imread(str(tmp_path / "a.tif"), cv2.IMREAD_UNCHANGED), frame)
    assert np.array_equal(read(tmp_path / "a.tif").pads["pad"].frames, frame[None])


@settings(deadline=None, max_examples=60)
@given(
    hnp.arrays(np.uint16, st.tuples(st.integers(1, 90), st.integers(1, 90)), elements=st.integers(0, 700)),
    st.sampled_from(["tiff_lzw", "tiff_adobe_deflate", "raw"]),
    st.integers(1, 5),
)
def test_what_pillow_writes_is_read_number_by_number(
    tmp_path_factory: pytest.TempPathFactory, frame: np.ndarray, packing: str, more: int
) -> None:
    path = tmp_path_factory.mktemp("tiff") / "a.tif"
    frames = np.tile(frame, (1, more, more))
    Image.fromarray(frames[0]).save(path, compression=packing)
    assert np.array_equal(read(path).pads["pad"].frames, frames)


@pytest.mark.parametrize("order", ["<", ">"])
def test_both_byte_orders_of_tiff(tmp_path: Path, order: str) -> None:
    """A file written out by hand: a head, eight entries, the rows."""
    entries = [(256, 3, 8), (257, 3, 6), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 4, 200), (278, 3, 6)]
    entries.append((279, 4, FRAMES[1].nbytes))
    body = struct.pack(f"{order}H", len(entries))
    for tag, kind, value in entries:
        body += struct.pack(f"{order}HHI", tag, kind, 1) + struct.pack(f"{order}{'H2x' if kind == 3 else 'I'}", value)
    head = (b"II" if order == "<" else b"MM") + struct.pack(f"{order}HI", 42, 8)
    data = FRAMES[1].astype(f"{order}u2").tobytes()
    (tmp_path / "a.tif").write_bytes((head + body + bytes(4)).ljust(200, b"\0") + data)
    assert np.array_equal(read(tmp_path / "a.tif").pads["pad"].frames, FRAMES[1:2])


def test_pages_are_frames(tmp_path: Path) -> None:
    assert cv2.imwritemulti(str(tmp_path / "a.tiff"), list(FRAMES))
    assert np.array_equal(read(tmp_path / "a.tiff").pads["pad"].frames, FRAMES)
    with open_recording(tmp_path / "a.tiff") as opened:
        for first, last in ((3, 5), (0, 2), (1, 4), (4, 5)):
            assert np.array_equal(opened.frames[first:last].pads["pad"].frames, FRAMES[first:last])
    whole = (tmp_path / "a.tiff").read_bytes()
    for length in range(len(whole) - 1, len(whole) // 2, -37):
        (tmp_path / "cut.tiff").write_bytes(whole[:length])
        recording = read(tmp_path / "cut.tiff")
        assert 1 <= recording.n_frames < 5
        assert np.array_equal(recording.pads["pad"].frames, FRAMES[: recording.n_frames])
        assert recording.notes == (f"is cut off after page {recording.n_frames - 1}",)
    assert cv2.imwritemulti(str(tmp_path / "b.tiff"), [*FRAMES, FRAMES[0, :3].copy()])
    with pytest.raises(FormatError, match="page 5 is 3 x 8 uint16, page 0 6 x 8 uint16; all must be alike"):
        read(tmp_path / "b.tiff")


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "press")
    (folder / ".DS_Store").write_bytes(b"\0")
    assert is_folder(folder)
    recording = read(folder, pitch_m=1e-4)
    assert np.array_equal(recording.pads["pad"].frames, FRAMES)
    assert recording.pads["pad"].pitch_m == (1e-4, 1e-4)
    assert recording.time_s is None
    assert recording.notes == ()
    with open_recording(folder) as opened:
        assert [block.n_frames for block in opened.blocks(2)] == [2, 2, 1]
        assert np.array_equal(opened.frames[3:4].pads["pad"].frames, FRAMES[3:4])
    (folder / "depth_9.png").unlink()
    assert read(folder).notes == ("the pictures' numbers jump from 8 to 10",)


def test_pictures_of_two_cameras_in_one_folder_are_asked_about(tmp_path: Path) -> None:
    for name in ("left_0", "left_1", "right_0", "right_1"):
        Image.fromarray(np.full((4, 5), 7, np.uint16)).save(tmp_path / f"{name}.png")
    note, *_ = read(tmp_path).notes
    assert note.startswith("pictures are called left_#, right_#, and are taken for one pad")
    for name in ("right_0", "right_1"):
        (tmp_path / f"{name}.png").unlink()
    assert read(tmp_path).notes == ()


def test_a_subfolder_is_a_pad_and_pads_have_the_same_pictures(tmp_path: Path) -> None:
    for pad, frames in (("thumb", FRAMES), ("index", FRAMES[:, :3] // 300)):
        folder_of(tmp_path / "hand" / pad, frames)
    recording = read(tmp_path / "hand")
    assert list(recording.pads) == ["index", "thumb"]
    assert np.array_equal(recording.pads["thumb"].frames, FRAMES)
    assert recording.pads["index"].shape == (3, 8)
    (tmp_path / "hand" / "thumb" / "depth_9.png").unlink()
    with pytest.raises(FormatError, match="hand: index has 5 pictures, thumb 4; picture 9 has no other"):
        read(tmp_path / "hand")


def test_a_last_picture_that_is_cut_off_is_left_out_of_every_pad(tmp_path: Path) -> None:
    for pad in ("a", "b"):
        folder_of(tmp_path / "hand" / pad)
    cut = tmp_path / "hand" / "b" / "depth_11.png"
    cut.write_bytes(cut.read_bytes()[:60])
    recording = read(tmp_path / "hand")
    assert {pad.n_frames for pad in recording.pads.values()} == {4}
    assert recording.notes[0].startswith(f"the last pictures are left out: {cut}: is damaged or cut off")
    middle = tmp_path / "hand" / "b" / "depth_9.png"
    middle.write_bytes(middle.read_bytes()[:60])
    with pytest.raises(FormatError, match=r"depth_9.png: is damaged or cut off"):
        read(tmp_path / "hand")


def test_pictures_of_another_size_or_type_are_told(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "a")
    put(folder / "depth_9.png", FRAMES[0, :4])
    with pytest.raises(FormatError, match=r"depth_9.png: is 4 x 8 uint16, depth_7.png 6 x 8 uint16; all pictures"):
        read(folder)
    put(folder / "depth_9.png", FRAMES[0].astype(np.uint8))
    with pytest.raises(FormatError, match=r"is 6 x 8 uint8, depth_7\.png 6 x 8 uint16"):
        read(folder)


def test_a_folder_with_anything_else_is_none(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "a")
    for left_behind in ("Thumbs.db", "desktop.ini", ".DS_Store"):
        (folder / left_behind).write_bytes(b"what a file browser leaves")
    assert is_folder(folder)
    assert read(folder).n_frames == read(folder_of(tmp_path / "b")).n_frames
    (folder / "result.npz").write_bytes(b"")
    assert not is_folder(folder)
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        read(folder)
    assert not is_folder(tmp_path)


def _huge(path: Path) -> None:
    path.write_bytes(png(60_000, 60_000, 16, 0, bytes(100)))


def _interlaced_short(path: Path) -> None:
    path.write_bytes(png(8, 6, 16, 0, bytes(10)))


BAD: dict[str, tuple[str, Any, str]] = {
    "colours": ("a.png", lambda p: put(p, np.zeros((4, 4, 3), np.uint8)), "has colours, a palette or other bits than 8 or 16; depth pictures are grey"),
    "opacity": ("a.png", lambda p: put(p, np.zeros((4, 4, 4), np.uint16)), "has colours"),
    "one bit": ("a.png", lambda p: p.write_bytes(png(8, 4, 1, 0, bytes(8))), "other bits than 8 or 16"),
    "palette": ("a.png", lambda p: p.write_bytes(png(8, 4, 8, 3, bytes(36))), "a palette"),
    "colours in tiff": ("a.tif", lambda p: put(p, np.zeros((4, 4, 3), np.uint16)), "page 0: has colours, or black for the largest number; depth pictures are grey"),
    "jpeg in tiff": ("a.tif", lambda p: Image.fromarray(np.zeros((16, 16), np.uint8)).save(p, compression="jpeg"), "is packed in way 7 with predictor 1, which is not read"),
    "predictor of floats": ("a.tif", lambda p: (put(p, FRAMES[0], cv2.IMWRITE_TIFF_PREDICTOR, 2), p.write_bytes(p.read_bytes().replace(struct.pack("<HHII", 317, 3, 1, 2), struct.pack("<HHII", 317, 3, 1, 3)))), "is packed in way 5 with predictor 3, which is not read"),
    "huge": ("a.png", _huge, "is 60000 x 60000; it may have 1 to 16777216 taxels"),
    "too few rows": ("a.png", _interlaced_short, "is damaged or cut off"),
    "head only": ("a.png", lambda p: p.write_bytes(b"\x89PNG\r\n\x1a\n"), "is damaged or cut off"),
    "cut": ("a.png", lambda p: (put(p, FRAMES[0]), p.write_bytes(p.read_bytes()[:-30])), "is damaged or cut off"),
    "checksum": ("a.png", lambda p: (put(p, FRAMES[0]), p.write_bytes(p.read_bytes().replace(b"IDAT", b"IDAT\xff"))), "is damaged"),
    "cut tiff": ("a.tif", lambda p: (put(p, FRAMES[0], cv2.IMWRITE_TIFF_COMPRESSION, 1), p.write_bytes(p.read_bytes()[:40])), "is damaged"),
    "pdf": ("a.pdf", lambda p: p.write_bytes(b"%PDF-1.4\n%\xe2\xe3\n1 0 obj\n"), "is a PDF, which is no known format"),
    "jpeg": ("a.jpg", lambda p: put(p, np.zeros((4, 4), np.uint8)), "is a JPEG picture, whose packing spoils depth"),
    "video": ("a.mp4", lambda p: p.write_bytes(b"\0\0\0\x20ftypisom" + bytes(99)), "is a video, whose 8 bits and packing spoil depth"),
    "matroska": ("a.mkv", lambda p: p.write_bytes(b"\x1a\x45\xdf\xa3" + bytes(99)), "is a video"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_pictures_are_told_in_one_line(tmp_path: Path, case: str) -> None:
    name, make, message = BAD[case]
    make(tmp_path / name)
    with pytest.raises(FormatError, match=message) as error:
        read(tmp_path / name)
    assert str(error.value).startswith(f"{tmp_path / name}: ")
    assert "\n" not in str(error.value)


def test_a_sensor_file_says_scale_and_zero(tmp_path: Path) -> None:
    """A ball pressed .4 mm deep into a gel, as numbers of a micrometre that fall from 30,000."""
    y, x = np.mgrid[-20:21, -20:21] * 1e-4
    height = np.maximum(4e-4 - (x**2 + y**2) / (2 * 4e-3), 0)
    put(tmp_path / "gel" / "0001.png", np.rint(30_000 - height * 1e6).astype(np.uint16))
    put(tmp_path / "gel" / "0002.png", np.rint(30_000 - height * 1e6).astype(np.uint16))
    said = (Path(__file__).parents[1] / "docs" / "formats.md").read_text().split("```toml\n")[1]
    (tmp_path / "gel" / "sensor.toml").write_text(said.split("```")[0])
    found = find_sensor_file(tmp_path / "gel")
    assert found == tmp_path / "gel" / "sensor.toml"
    sensor = read_sensor(found)
    recording = read(tmp_path / "gel", polarity="down")
    assert np.allclose(sensor.undo(recording.pads["pad"].frames[0].astype(float)).frame, height, atol=6e-7)
    done = CliRunner().invoke(app, ["touch", str(tmp_path / "gel"), "--json"])
    assert done.exit_code == 0, done.output
    (line,) = done.stdout.splitlines()
    answer = json.loads(line)
    assert answer["name"] == "sphere"
    assert answer["depth_m"] == pytest.approx(4e-4, rel=0.05)
    assert answer["radius_m"] == pytest.approx(4e-3, rel=0.1)
