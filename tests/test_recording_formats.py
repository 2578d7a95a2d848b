"""The file formats: NPZ loses nothing, each format is read as it is written, and bad input is told in one line."""
# ruff: noqa: E501

from __future__ import annotations

import io
import os
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import varishold
from varishold import FormatError, InputError
from varishold.recording import Options, Pad, Recording, presses, read, read_grasp_table, write

TEKSCAN = """DATA_TYPE MOVIE
VERSION ASCII 5.20
SENSOR_TYPE 5051
ROWS 3
COLS 4
ROW_SPACING 1.27 mm
COL_SPACING 0.05 inch
NOISE_THRESHOLD 3
SECONDS_PER_FRAME 0.01
START_FRAME 1
END_FRAME 2
UNITS KPA
ASCII_DATA @@

Frame 1
B,0,0,1
0,2,3,0
0,0,0,B
Frame 2
B,0,0,1.5
0,2,3,0
0,0,0,B
@@
"""

XSENSOR = """Producer:,X3 PRO V7
Sensor:,PX100.16.16
Units:,mmHg
Rows:,3
Columns:,4
Frame:,1
Time:,10:59:59.500
0,1,2,3
4,5,6,"7,5"
8,9,10,11
Frame:,2
Time:,11:00:00.500
CoP:,1.5,2.5
12,13,14,15
16,17,18,19
20,21,22,23
"""


def same(a: Recording, b: Recording) -> None:
    assert (list(a.pads), a.unit, a.sensor) == (list(b.pads), b.unit, b.sensor)
    assert (a.time_s is None) == (b.time_s is None)
    if a.time_s is not None and b.time_s is not None:
        assert np.array_equal(a.time_s, b.time_s)
    for name, pad in a.pads.items():
        other = b.pads[name]
        assert pad.frames.dtype == other.frames.dtype
        assert np.array_equal(pad.frames, other.frames, equal_nan=pad.frames.dtype.kind == "f")
        assert pad.pitch_m == other.pitch_m
        for mine, its in ((pad.field, other.field), (pad.valid, other.valid)):
            assert (mine is None) == (its is None)
            assert mine is None or np.array_equal(mine, its)


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    n = draw(st.integers(1, 4))
    pads = {}
    for name in draw(st.lists(st.sampled_from(["pad", "left", "finger 2", "θ/1"]), min_size=1, unique=True)):
        shape = (draw(st.integers(1, 5)), draw(st.integers(1, 5)))
        dtype = draw(st.sampled_from(["u1", "<u2", ">u2", "i4", "f2", "<f4", "f8"]))
        if dtype.strip("<>")[0] == "f":
            elements = st.floats(0, 1000, width=16)
        else:
            elements = st.integers(0, 100)
        frames = draw(hnp.arrays(np.dtype(dtype), (n, *shape), elements=elements))
        mask = draw(hnp.arrays(np.bool_, shape))
        mask[0, 0] = True
        if frames.dtype.kind == "f":
            frames[:, ~mask] = np.nan
        masks = draw(st.sampled_from([{"valid": mask}, {"field": mask}, {"field": mask, "valid": mask}]))
        pitch = draw(st.none() | st.tuples(st.floats(1e-4, 1), st.floats(1e-4, 1)))
        pads[name] = Pad(frames, **masks, pitch_m=pitch)
    time = draw(st.none() | hnp.arrays(np.float64, n, elements=st.floats(-1e9, 1e9)))
    return Recording(pads, time, draw(st.sampled_from(["raw", "kPa", "N/cm²"])), draw(st.sampled_from(["", "S θ"])))


@given(recordings())
def test_writing_npz_loses_nothing_and_is_the_same_bytes_each_time(
    tmp_path_factory: pytest.TempPathFactory, recording: Recording
) -> None:
    folder = tmp_path_factory.mktemp("npz")
    write(recording, folder / "a.npz")
    again = read(folder / "a.npz")
    same(recording, again)
    write(again, folder / "b.npz")
    assert (folder / "a.npz").read_bytes() == (folder / "b.npz").read_bytes()


def test_npz_of_the_contract(tmp_path: Path) -> None:
    path = tmp_path / "hand.npz"
    np.savez(
        path,
        **{"pressure.thumb": np.ones((2, 3, 4)), "pressure.palm": np.ones((2, 5, 5), "u1")},
        **{"pitch_m.palm": [0.002, 0.003], "pitch_m": 0.001, "time_s": [0, 0.1], "unit": "pascal", "sensor": "S"},
    )
    recording = varishold.read(path)
    assert list(recording.pads) == ["thumb", "palm"]
    assert recording.pads["thumb"].pitch_m == (0.001, 0.001)
    assert recording.pads["palm"].pitch_m == (0.002, 0.003)
    assert (recording.unit, recording.sensor, recording.source) == ("pascal", "S", str(path))
    assert read(path, pitch_m=0.005).pads["palm"].pitch_m == (0.005, 0.005)


FRAMES = np.arange(24).reshape(2, 3, 4)


@pytest.mark.parametrize(
    ("text", "shape", "time"),
    [
        ("0,1,2,3\n4,5,6,7\n8,9,10,11\n\n12,13,14,15\n16,17,18,19\n20,21,22,23\n", None, None),
        ("\n\n0 1  2 3\n4 5 6 7\n8 9 10 11\n\n\n\n12 13 14 15\n16 17 18 19\n20 21 22 23\n\n\n", None, None),
        ("0;1;2;3;\r\n4;5;6;7;\r\n8;9;10;11;\r\n\r\n12;13;14;15;\r\n16;17;18;19;\r\n20;21;22;23;", None, None),
        ("\n".join(",".join(map(str, row)) for row in FRAMES.reshape(2, 12)), (3, 4), None),
        ("\n".join("\t".join(map(str, row)) for row in FRAMES.reshape(2, 12)), (3, 4), None),
        ("\n".join(",".join(map(str, row)) for row in FRAMES.reshape(6, 4)), (3, 4), None),
        ("# comment\n" + "\n".join(f"{t}," + ",".join(map(str, f)) for t, f in zip((0, 1), FRAMES.reshape(2, 12), strict=True)), (3, 4), (0, 1)),
        ("time_ms;" + ";".join(f"t{k}" for k in range(12)) + "\n" + "\n".join(f"{t};" + ";".join(map(str, f)) for t, f in zip(("0,5", "1,5"), FRAMES.reshape(2, 12), strict=True)), (3, 4), (0.0005, 0.0015)),
        ("," + ",".join(map(str, range(12))) + "\n" + "\n".join(f"{t}," + ",".join(map(str, f)) for t, f in zip((0, 1), FRAMES.reshape(2, 12), strict=True)), (3, 4), None),
        ("t,a,b,c,d\n.5,0,1,2,3\n.5,4,5,6,7\n.5,8,9,10,11\n\n1,12,13,14,15\n1,16,17,18,19\n1,20,21,22,23\n", None, (0.5, 1)),
        ("\ufeff0,1,2,3\n4,5,6,7\n8,9,10,11\n\n12,13,14,15\n16,17,18,19\n20,21,22,23\n", (3, 4), None),
    ],
)  # fmt: skip
def test_plain_csv(tmp_path: Path, text: str, shape: tuple[int, int] | None, time: tuple[float, ...] | None) -> None:
    path = tmp_path / "frames.csv"
    path.write_bytes(text.encode())
    recording = read(path, shape=shape)
    assert recording.pads["pad"].frames.tolist() == FRAMES.tolist()
    assert recording.time_s is None if time is None else recording.time_s.tolist() == pytest.approx(list(time))


@given(
    hnp.arrays(np.float64, st.tuples(st.integers(2, 4), st.integers(1, 5), st.integers(2, 5)), elements=st.floats(0, 1e6)),
    st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), (" ", ".")]),
    st.booleans(),
)  # fmt: skip
def test_csv_gives_back_the_very_numbers(
    tmp_path_factory: pytest.TempPathFactory, frames: np.ndarray, marks: tuple[str, str], blank: bool
) -> None:
    path = tmp_path_factory.mktemp("csv") / "frames.csv"
    mark, decimal = marks
    n, rows, cols = frames.shape
    lines = frames.reshape(n * rows if blank else n, -1)
    texts = [mark.join(repr(float(v)).replace(".", decimal) for v in line) for line in lines]
    if blank:
        texts = ["\n".join(texts[k * rows : (k + 1) * rows]) + "\n" for k in range(n)]
    path.write_text("\n".join(texts))
    assert np.array_equal(read(path, shape=None if blank else (rows, cols)).pads["pad"].frames, frames)


def test_tekscan(tmp_path: Path) -> None:
    for name, text in (("a.asf", TEKSCAN), ("b.csv", TEKSCAN.replace("\n", "\r\n"))):
        path = tmp_path / name
        path.write_bytes(text.encode())
        recording = read(path)
        pad = recording.pads["pad"]
        assert pad.field is not None
        assert (~pad.field).nonzero()[0].tolist() == [0, 2]
        assert pad.frames[1].tolist() == [[0, 0, 0, 1.5], [0, 2, 3, 0], [0, 0, 0, 0]]
        assert pad.pitch_m == pytest.approx((1.27e-3, 1.27e-3))
        assert recording.time_s is not None
        assert recording.time_s.tolist() == pytest.approx([0, 0.01])
        assert recording.pascals_per_unit == 1000
        assert recording.sensor == "5051"


@pytest.mark.parametrize("mark", [";", "\t"])
def test_tekscan_where_a_comma_is_the_decimal_sign(mark: str, tmp_path: Path) -> None:
    header, at, data = TEKSCAN.partition("ASCII_DATA @@")
    path = tmp_path / "a.csv"
    path.write_text(header.replace(".", ",") + at + data.replace(",", mark).replace(".", ","))
    (tmp_path / "b.csv").write_text(TEKSCAN)
    recording, plain = read(path), read(tmp_path / "b.csv")
    np.testing.assert_array_equal(recording.pads["pad"].frames, plain.pads["pad"].frames)
    assert recording.pads["pad"].pitch_m == plain.pads["pad"].pitch_m
    np.testing.assert_array_equal(recording.time_s, plain.time_s)


def test_tekscan_counts_stay_integers_and_lost_frames_are_noted(tmp_path: Path) -> None:
    path = tmp_path / "a.asf"
    path.write_text(TEKSCAN.replace("1.5", "2").replace("KPA", "RAW").replace("END_FRAME 2", "END_FRAME 5"))
    recording = read(path)
    assert recording.pads["pad"].frames.dtype == np.int32
    assert recording.unit == "raw"
    assert recording.notes == ("2 frames are there, START_FRAME and END_FRAME promise 5",)


def test_xsensor(tmp_path: Path) -> None:
    for text in (XSENSOR, XSENSOR.replace(",", ";").replace("7;5", "7,5"), XSENSOR.replace("11\n", "11,,\n\n,,,\n")):
        path = tmp_path / "x.csv"
        path.write_text(text)
        recording = read(path)
        expected = FRAMES.astype(float)
        expected[0, 1, 3] = 7.5
        assert recording.pads["pad"].frames.tolist() == expected.tolist()
        assert recording.time_s is not None
        assert recording.time_s.tolist() == [0, 1]
        assert (recording.unit, recording.sensor) == ("mmHg", "PX100.16.16")


@pytest.mark.parametrize(
    ("array", "shape", "expected"),
    [
        (FRAMES, None, FRAMES),
        (FRAMES.reshape(2, 12), (3, 4), FRAMES),
        (FRAMES[0], None, FRAMES[:1]),
        (FRAMES[0], (3, 4), FRAMES[:1]),
        (np.stack([FRAMES * 0, FRAMES * -1, FRAMES], -1), None, FRAMES),
        (np.stack([FRAMES * 0, FRAMES * -1, FRAMES], -1).reshape(2, 12, 3), (3, 4), FRAMES),
        (np.asfortranarray(FRAMES), None, FRAMES),
        (FRAMES > 5, None, FRAMES > 5),
    ],
)
def test_npy(tmp_path: Path, array: np.ndarray, shape: tuple[int, int] | None, expected: np.ndarray) -> None:
    np.save(tmp_path / "a.npy", array)
    assert np.array_equal(read(tmp_path / "a.npy", shape=shape).pads["pad"].frames, expected)


def test_what_npy_leaves_open_is_noted(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", FRAMES[0])
    assert "if each row is a frame, give shape (rows, cols)" in read(tmp_path / "a.npy").notes[0]
    np.save(tmp_path / "b.npy", FRAMES[..., :3])
    assert "x, y, z of 3 taxels" in read(tmp_path / "b.npy").notes[0]


def test_npy_taxels_that_are_no_numbers_are_broken(tmp_path: Path) -> None:
    frames = FRAMES.astype(np.float32)
    frames[:, 0, 1] = np.nan
    np.save(tmp_path / "a.npy", frames)
    recording = read(tmp_path / "a.npy")
    works = np.ones(frames.shape[1:], np.bool_)
    works[0, 1] = False
    assert np.array_equal(recording.pads["pad"].usable, works)
    assert recording.notes[-1] == "1 taxel is no number in the first frame and the last: taken as broken"
    frames[0, 1, 1] = np.nan
    np.save(tmp_path / "a.npy", frames)
    with pytest.raises(FormatError, match=r"got nan at \(row, col\) = \(1, 1\) of frame 0"):
        read(tmp_path / "a.npy")


def test_npy_is_mapped_and_not_loaded(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", FRAMES)
    base = read(tmp_path / "a.npy").pads["pad"].frames
    while isinstance(base, np.ndarray) and not isinstance(base, np.memmap):
        base = base.base
    assert isinstance(base, np.memmap)


def test_content_decides_and_not_the_name(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(FRAMES)}), tmp_path / "a.csv")
    assert np.array_equal(read(tmp_path / "a.csv").pads["pad"].frames, FRAMES)


def _npz(path: Path, **arrays: object) -> None:
    np.savez(path, **arrays)  # type: ignore[arg-type]


class _Evil:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.system, ("touch evil",)


def _pickled_npz(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive, archive.open("pressure.npy", "w") as member:
        np.lib.format.write_array(member, np.array([[[_Evil()]]]), allow_pickle=True)  # type: ignore[arg-type]


def _bomb(path: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "|u1", "fortran_order": False, "shape": (1, 1, 10**12)})  # type: ignore[arg-type]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("pressure.npy", header.getvalue() + bytes(1 << 20))


def _wide_bomb(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("pressure.npy", bytes(1 << 20))
    data = bytearray(path.read_bytes())
    for mark, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        at = data.index(mark) + offset
        data[at : at + 4] = (0xFFFFFFF0).to_bytes(4, "little")
    path.write_bytes(data)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("other.npy", bytes(1 << 10))


def _truncated(path: Path) -> None:
    _npz(path, pressure=np.random.default_rng(0).normal(size=(9, 9, 9)))
    path.write_bytes(path.read_bytes()[:-400])


def _cut_member(path: Path) -> None:
    whole = io.BytesIO()
    np.save(whole, FRAMES)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("pressure.npy", whole.getvalue()[:-9])


BAD = {
    "empty": ("a.npz", b"", "a.npz: is empty"),
    "blank": ("a.csv", b" \n \n", "is empty"),
    "text named npz": ("a.npz", b"hello", r"does not start like NumPy archive \(NPZ\); is it damaged"),
    "text named npy": ("a.npy", b"hello", r"does not start like NumPy array \(NPY\)"),
    "gzip": ("a.csv.gz", b"\x1f\x8b\x08" + b"x" * 9, "is compressed with gzip; unpack it first"),
    "pickle": ("a.pkl", pickle.dumps([1]), "looks like a pickle, which is never loaded"),
    "hdf5": ("a.mat", b"\x89HDF\r\n\x1a\n", "is damaged or cut off"),
    "picture": ("a.png", b"\x89PNG\r\n", "is damaged or cut off: unpack requires"),
    "binary": ("a.bin", b"\x01\x02\x00\x03" * 9, "is of no known format; known are"),
    "end not written": ("a.csv", b"0,1,2\n3,4,5\n" + b"\0" * 99, "is text to line 2, then NUL bytes"),
    "no zip": ("a.npz", b"PK\x03\x04" + b"x" * 99, "is damaged or cut off"),
    "truncated": ("a.npz", _truncated, "is damaged or cut off"),
    "cut member": ("a.npz", _cut_member, r"'pressure': is cut off: 192 bytes of \(2, 3, 4\) int64 announced, 183 there"),
    "pickled": ("a.npz", _pickled_npz, "array 'pressure': holds pickled objects, which are never loaded"),
    "bomb": ("a.npz", _bomb, "array 'pressure': is cut off: 1000000000000 bytes"),
    "wide bomb": ("a.npz", _wide_bomb, r"would unpack to \d+ bytes; at most 4294967296 are read"),
    "no pressure": ("a.npz", lambda p: _npz(p, force=FRAMES), "must hold an array 'pressure' or 'pressure.NAME', holds force"),
    "flat": ("a.npz", lambda p: _npz(p, pressure=FRAMES[0]), r"pressure must have shape \(n, rows, cols\), got \(3, 4\); say the shape of a frame"),
    "complex": ("a.npz", lambda p: _npz(p, pressure=FRAMES * 1j), "pressure: pressure must be numbers of shape .*, got complex"),
    "strings": ("a.npz", lambda p: _npz(p, pressure=FRAMES.astype(str)), "must be numbers of shape .*, got <U"),
    "no frames": ("a.npz", lambda p: _npz(p, pressure=FRAMES[:0]), "at least one frame, got none"),
    "both": ("a.npz", lambda p: _npz(p, **{"pressure": FRAMES, "pressure.a": FRAMES}), "holds both 'pressure' and 'pressure.a'"),
    "uneven pads": ("a.npz", lambda p: _npz(p, **{"pressure.a": FRAMES, "pressure.b": FRAMES[:1]}), "equally many frames, got 2 of 'a' and 1 of 'b'"),
    "mask": ("a.npz", lambda p: _npz(p, pressure=FRAMES, valid=np.ones((2, 2), bool)), r"valid must have the shape of a frame, \(3, 4\), got \(2, 2\)"),
    "pitch": ("a.npz", lambda p: _npz(p, pressure=FRAMES, pitch_m=0.0), "pitch_m must be one spacing in metres"),
    "pitch text": ("a.npz", lambda p: _npz(p, pressure=FRAMES, pitch_m="wide"), "pitch_m must be one spacing in metres"),
    "time": ("a.npz", lambda p: _npz(p, pressure=FRAMES, time_s=[1.0]), r"time_s must be one number a frame, shape \(2,\)"),
    "unit": ("a.npz", lambda p: _npz(p, pressure=FRAMES, unit=3), "unit must be one text"),
    "nan": ("a.npz", lambda p: _npz(p, pressure=FRAMES / np.array([1, 0, 1, 1.0]).clip(0) * np.where(FRAMES == 5, np.nan, 1)), "must be finite"),
    "negative": ("a.npz", lambda p: _npz(p, pressure=-FRAMES), "pressure is mostly negative"),
    "npy objects": ("a.npy", lambda p: np.save(p, np.array([[[None]]]), allow_pickle=True), "holds pickled objects"),
    "npy cut": ("a.npy", lambda p: (np.save(p, FRAMES), p.write_bytes(p.read_bytes()[:-8])), "is cut off: 192 bytes"),
    "npy 1-d": ("a.npy", lambda p: np.save(p, FRAMES.ravel()), r"must have shape .*; got \(24,\)"),
    "csv no shape": ("a.csv", b"1,2,3,4\n5,6,7,8\n", "2 lines of 4 numbers and no blank line between frames: say the shape of a frame"),
    "csv text": ("a.csv", b"1,2\n3,x\n\n5,6\n7,8\n", "line 2, column 2 must be a number, got 'x'"),
    "csv underscore": ("a.csv", b"1,2\n3,4_0\n\n5,6\n7,8\n", "line 2, column 2 must be a number, got '4_0'"),
    "csv first line": ("a.csv", b"x,2\n3,4\n\n5,6\n7,8\n", "line 1, column 1 must be a number, got 'x'"),
    "csv nan": ("a.csv", b"1,2\n3,nan\n\n5,6\n7,8\n", "line 2, column 2 must be finite, got 'nan'"),
    "csv gap": ("a.csv", b"1,2,3\n3,,4\n\n5,6,7\n7,8,9\n", "line 2, column 2 must be a number, got ''"),
    "csv ragged": ("a.csv", b"1,2\n3,4\n\n5,6\n7\n", "line 5 must have 2 numbers like line 1, got 1"),
    "csv uneven": ("a.csv", b"1,2\n3,4\n\n5,6\n", r"frame 1 \(line 4\) has 1 row where frame 0 has 2"),
    "csv prose": ("a.csv", b"once upon a time\nthere was\n", "line 2, column 1 must be a number, got 'there'"),
    "csv header only": ("a.csv", b"a,b,c\n", "there is no line of numbers"),
    "csv one title": ("a.csv", b"time\n1\n2\n\n3\n4\n", "holds no taxels beside the column 'time'"),
    "tekscan no data": ("a.asf", TEKSCAN[: TEKSCAN.index("ASCII_DATA")].encode(), "is cut off: there is no line ASCII_DATA"),
    "tekscan no frame": ("a.asf", TEKSCAN[: TEKSCAN.index("Frame 1")].encode(), "holds no frame after its line ASCII_DATA"),
    "tekscan cut": ("a.asf", TEKSCAN[:-11].encode(), r"frame 2 \(line 19\) has 2 rows, ROWS says 3"),
    "tekscan rows": ("a.asf", TEKSCAN.replace("ROWS 3", "ROWS three").encode(), "ROWS must be a whole number from 1 to 10000, got 'three'"),
    "tekscan cols": ("a.asf", TEKSCAN.replace("COLS 4", "COLS 5").encode(), "rows hold 4 cells, COLS says 5"),
    "tekscan text": ("a.asf", TEKSCAN.replace("1.5", "Q").encode(), "line 20, column 4 must be a number, got 'Q'"),
    "tekscan B": ("a.asf", TEKSCAN.replace("1.5", "B").encode(), r"frame 2 \(line 19\) differs from the first in where B stands, at \(row, col\) = \(0, 3\)"),
    "tekscan spacing": ("a.asf", TEKSCAN.replace("1.27 mm", "1.27 ell").encode(), "ROW_SPACING must be a positive length"),
    "tekscan period": ("a.asf", TEKSCAN.replace("FRAME 0.01", "FRAME -1").encode(), "SECONDS_PER_FRAME must be a positive number"),
    "tekscan all B": ("a.asf", b"ROWS 1\nCOLS 2\nASCII_DATA\nFrame 1\nB,B\n", "no taxel of 1 x 2 is both in field and valid"),
    "xsensor rows": ("x.csv", XSENSOR.replace("Rows:,3", "Rows:,4").encode(), r"frame 0 \(line 8\) has 3 rows, Rows says 4"),
    "xsensor columns": ("x.csv", XSENSOR.replace("Columns:,4", "Columns:,x").encode(), "Columns must be a whole number from 1 to 10000, got 'x'"),
    "xsensor width": ("x.csv", XSENSOR.replace("Columns:,4", "Columns:,5").encode(), "line 8 holds 4 numbers, Columns says 5"),
    "xsensor text": ("x.csv", XSENSOR.replace("12,", "N/A,").encode(), "line 14, column 1 must be a number, got 'N/A'"),
    "xsensor quote": ("x.csv", XSENSOR.replace('5"', "5").encode(), "line 9: unexpected end of data; a cell must close its quotes"),
    "xsensor no rows": ("x.csv", XSENSOR[: XSENSOR.index("0,1,2")].encode(), "holds no rows of numbers"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_told_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    name, content, message = BAD[case]
    path = tmp_path / name
    monkeypatch.chdir(tmp_path)
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        with np.errstate(all="ignore"):
            content(path)  # type: ignore[operator]
    with pytest.raises(FormatError, match=message) as raised:
        read(path)
    assert str(raised.value).startswith(f"{path}: ")
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "evil").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shape": (0, 3)}, "shape must be at least 1 x 1, got 0 x 3"),
        ({"shape": (3,)}, "shape must be"),
        ({"shape": (4, 4)}, r"a line must hold 16 numbers, or one more with the time ahead.*got 12"),
        ({"shape": (3, 4), "pitch_m": 0}, "pitch_m must be one spacing in metres"),
    ],
)
def test_bad_options(tmp_path: Path, arguments: dict[str, object], message: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(map(str, row)) for row in FRAMES.reshape(2, 12)))
    with pytest.raises(InputError, match=message):
        read(path, **arguments)  # type: ignore[arg-type]


def test_a_shape_that_contradicts_the_file(tmp_path: Path) -> None:
    write(Recording({"pad": Pad(FRAMES)}), tmp_path / "a.npz")
    (tmp_path / "a.asf").write_text(TEKSCAN)
    np.save(tmp_path / "a.npy", FRAMES)
    for name in ("a.npz", "a.asf", "a.npy"):
        with pytest.raises(FormatError, match="has frames of 3 x 4, not 4 x 3; leave the shape out"):
            read(tmp_path / name, shape=(4, 3))


def test_what_cannot_be_opened(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        read(tmp_path / "absent.npz")
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        read(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="is a pipe; save what comes out"):
        read(tmp_path / "pipe")
    with pytest.raises(InputError, match="is no file name"):
        read("nul\0byte")
    with pytest.raises(InputError, match="file name too long"):
        read("x" * 5000)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("1")
    (tmp_path / "a.csv").chmod(0)
    with pytest.raises(InputError, match="permission denied"):
        read(tmp_path / "a.csv")


def test_pads_of_one_row_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("1,2,3\n\n4,5,6\n")
    assert read(tmp_path / "a.csv").pads["pad"].shape == (1, 3)


def _real(name: str) -> Path:
    folder = Path(os.environ.get("VARISHOLD_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not (folder / name).is_file():
        pytest.skip(f"{name} is not there; set VARISHOLD_DATA to the folder that holds it")
    return folder / name


@pytest.mark.real_data
def test_weiss_grasps() -> None:
    recording = read(_real("weiss_dsa36.npz"))
    assert list(recording.pads) == ["finger0", "finger1"]
    pad = recording.pads["finger0"]
    assert (pad.frames.dtype, pad.frames.shape, pad.pitch_m) == (np.uint16, (46861, 13, 6), (0.0034, 0.0034))
    assert pad.field is not None
    assert np.count_nonzero(~pad.field) == 10
    assert recording.unit == "raw"
    assert 0.95 * 856 < len(presses(recording)) < 1.05 * 856


@pytest.mark.real_data
def test_capcontact_fingers() -> None:
    pad = read(_real("capcontact_fingers.npz")).pads["pad"]
    assert (pad.frames.dtype, pad.frames.shape, pad.pitch_m) == (np.int16, (1200, 41, 72), (0.00479, 0.00479))


def _seeds() -> list[bytes]:
    npz, npy, weiss = io.BytesIO(), io.BytesIO(), io.BytesIO()
    np.savez(npz, pressure=FRAMES.astype("u1"), time_s=[0.0, 1.0], pitch_m=0.01, unit="Pa", valid=np.ones((3, 4), bool))
    np.save(npy, FRAMES.astype("u1"))
    np.savez_compressed(
        weiss, frames=np.ones((2, 2, 3, 2), "u2"), texel_mask=np.ones((2, 3, 2), bool), time_ms=[0, 1], start=[0, 2]
    )
    csv = b"t,a,b\n0.5,1,2\n0.5,3,4\n\n1,5,6\n1,7,8\n"
    return [
        npz.getvalue(),
        npy.getvalue(),
        weiss.getvalue(),
        csv,
        csv.replace(b",", b";"),
        TEKSCAN.encode(),
        XSENSOR.encode(),
    ]


SEEDS = _seeds()


@st.composite
def mutated(draw: st.DrawFn) -> bytes:
    data = bytearray(draw(st.sampled_from(SEEDS)))
    for _ in range(draw(st.integers(1, 6))):
        if not data:
            break
        at = draw(st.integers(0, len(data) - 1))
        kind = draw(st.sampled_from(["flip", "cut", "insert", "drop", "copy"]))
        if kind == "flip":
            data[at] = draw(st.integers(0, 255))
        elif kind == "cut":
            del data[at:]
        elif kind == "insert":
            data[at:at] = draw(st.binary(max_size=8) | st.sampled_from([b",", b"\n", b"\n\n", b"nan", b"-1e999", b"B"]))
        elif kind == "drop":
            del data[at : at + draw(st.integers(1, 30))]
        else:
            data[at:at] = data[at : at + draw(st.integers(1, 60))]
    return bytes(data)


@given(
    mutated() | st.binary(max_size=200) | st.text("0123456789.,;-\t \n#eB", max_size=120).map(str.encode),
    st.sampled_from([None, (3, 4), (1, 1), (2, 2)]),
)
@settings(deadline=2000, max_examples=600)
def test_any_bytes_are_a_recording_or_an_error_in_one_line(
    tmp_path_factory: pytest.TempPathFactory, data: bytes, shape: tuple[int, int] | None
) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "a.dat"
    path.write_bytes(data)
    try:
        recording = read(path, shape=shape)
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert all(np.isfinite(pad.totals()).all() for pad in recording.pads.values())


def test_the_examples_of_the_documentation_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (Path(__file__).parents[1] / "docs" / "formats.md").read_text()
    blocks = [block.split("```")[0] for block in text.split("```")[1::2]]
    python = [block.removeprefix("python\n") for block in blocks if block.startswith("python")]
    plain = [block for block in blocks if not block.startswith(("python", "toml"))]
    monkeypatch.chdir(tmp_path)

    exec(python[0], {"thumb_frames": FRAMES, "palm_frames": FRAMES, "seconds": [0.0, 0.1]})
    assert list(read("hand.npz").pads) == ["thumb", "palm"]
    for name, shape, block in (("line.csv", (2, 3), plain[0]), ("rows.csv", None, plain[1])):
        Path(name).write_text(block.lstrip("\n"))
        assert read(name, shape=shape).pads["pad"].frames.tolist() == [[[0, 0, 1], [0, 4, 2]], [[0, 1, 3], [0, 9, 4]]]
    Path("presses.csv").write_text(plain[2].lstrip("\n"))
    assert {name: pad.shape for name, pad in read("presses.csv").pads.items()} == {"thumb": (2, 2), "palm": (1, 2)}
    Path("grasps.csv").write_text(plain[3].lstrip("\n"))
    assert read_grasp_table("grasps.csv").matrix("switch.*").tolist() == [[True, False], [True, True]]

    added: dict[str, Any] = {}
    exec(python[1], added)
    Path("a.xy16").write_bytes(b"XY16" + bytes(range(256)) * 2)
    assert added["FORMAT"].recognizes(Path("a.xy16"), b"XY16")
    assert added["FORMAT"].read(Path("a.xy16"), Options()).pads["pad"].frames.shape == (2, 16, 16)
    Path("a.xy16").write_bytes(b"XY16abc")
    with pytest.raises(FormatError, match="holds 3 bytes"):
        added["FORMAT"].read(Path("a.xy16"), Options())


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
@pytest.mark.parametrize(
    "content", [TEKSCAN, XSENSOR, "label,p.0.0,p.0.1\ncup,1,2\ncan,3,4\n", "1,2\n3,4\n\n5,6\n7,8\n"]
)
def test_every_table_may_be_text_with_a_mark(tmp_path: Path, content: str, encoding: str) -> None:
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    (tmp_path / "b.csv").write_text(content, encoding=encoding)
    plain, marked = read(tmp_path / "a.csv"), read(tmp_path / "b.csv")
    assert plain.pads.keys() == marked.pads.keys()
    for name, pad in plain.pads.items():
        np.testing.assert_array_equal(pad.frames, marked.pads[name].frames)
    assert [c.tolist() for c in plain.press_columns.values()] == [c.tolist() for c in marked.press_columns.values()]
