"""Quick and slow readers agree, and plain files are read by the quick one; formats as their makers write them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import FormatError, InputError
from varishold.recording import GraspTable, Pad, read, read_grasp_table, read_height_map
from varishold.recording import grasp_csv as tables
from varishold.recording.formats.numbers import Rows, Separator, as_number, separator_of

NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=32) | st.integers(-(2**33), 2**33)
MARKS = {",": Separator(","), ";": Separator(";"), ";c": Separator(";", True), "\t": Separator("\t"), "": Separator("")}


def lines_of(rows: list[list[Any]], separator: Separator) -> list[str]:
    texts = [(separator.mark or "  ").join(str(cell) for cell in row) for row in rows]
    return [text.replace(".", ",") if separator.decimal_comma else text for text in texts]


def rows_of(lines: list[str], separator: Separator, *, slowly: bool = False, **options: Any) -> Rows:
    rows = Rows(Path("it"), separator, **options)
    if slowly:
        rows._quickly = lambda lines: None  # type: ignore[method-assign]
    else:
        rows._slowly = None  # type: ignore[method-assign, assignment]
    half = len(lines) // 2
    rows.add(lines[:half], list(range(1, half + 1)))
    rows.add(lines[half:], list(range(half + 1, len(lines) + 1)))
    return rows


@given(
    st.integers(1, 5).flatmap(lambda n: st.lists(st.lists(NUMBERS, min_size=n, max_size=n), min_size=1, max_size=150)),
    st.sampled_from(list(MARKS)),
)
def test_rows_of_numbers_are_read_at_once_and_as_one_by_one(rows: list[list[Any]], mark: str) -> None:
    separator = MARKS[mark]
    lines = lines_of(rows, separator)
    quick, slow = rows_of(lines, separator), rows_of(lines, separator, slowly=True)
    assert (quick.n, quick.width) == np.array(rows).shape
    values = quick.values()
    np.testing.assert_array_equal(values, slow.values())
    np.testing.assert_array_equal(values, np.array(rows, dtype=np.float64))
    whole = all(isinstance(cell, int) for row in rows for cell in row)
    fits = all(abs(cell) < 2**31 for row in rows for cell in row)
    assert (values.dtype == np.int32) == (whole and fits)


@given(st.lists(st.sampled_from(["1", "2.5", "", "B", "-3e4"]), min_size=6, max_size=60), st.sampled_from([",", "\t"]))
def test_blanks_become_nan_both_ways(cells: list[str], mark: str) -> None:
    cells = cells[: len(cells) // 3 * 3]
    if mark == "\t":
        cells[2::3] = ["1" if cell == "" else cell for cell in cells[2::3]]
    # A comma at a line's end is no cell.
    lines = [mark.join(cells[k : k + 3]) + mark.strip() for k in range(0, len(cells), 3)]
    quick = rows_of(lines, Separator(mark), blanks=("", "B"))
    slow = rows_of(lines, Separator(mark), slowly=True, blanks=("", "B"))
    expected = [
        [np.nan if cell in ("", "B") else float(cell) for cell in cells[k : k + 3]] for k in range(0, len(cells), 3)
    ]
    np.testing.assert_array_equal(quick.values(), expected)
    np.testing.assert_array_equal(slow.values(), expected)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("1,2", "line 3 must have 3 numbers like line 1, got 2"),
        ("1,2,3,4", "line 3 must have 3 numbers like line 1, got 4"),
        ("1,x,3", "line 3, column 2 must be a number, got 'x'"),
        ("1,2,1_0", "line 3, column 3 must be a number, got '1_0'"),
        ("inf,2,3", "line 3, column 1 must be finite, got 'inf'"),
        ("1,nan,3", "line 3, column 2 must be finite, got 'nan'"),
        ("1,,3", "line 3, column 2 must be a number, got ''"),
    ],
)
def test_what_is_no_row_is_told_with_its_place(line: str, says: str) -> None:
    rows = Rows(Path("it"), Separator(","))
    rows.add(["1,2,3", "4,5,6"], [1, 2])
    rows.add([], [])
    with pytest.raises(FormatError, match=says):
        rows.add([line], [3])


def test_what_separates_is_told_from_all_lines() -> None:
    for text, expected in (
        ("1 2", Separator("")),
        ("1,2", Separator(",")),
        ("1.5,2", Separator(",")),
        ("1;2", Separator(";")),
        ("1,5;2", Separator(";", True)),
        ("1,5;2.5", Separator(";")),
        ("1\t2,5", Separator("\t", True)),
        ("1\t2;3", Separator(";")),
    ):
        assert separator_of([text]) == expected
        assert separator_of(["", *text]) == expected
    assert Separator("\t").plain(" \t1\t2\t ") == "\t1\t2"
    assert Separator("").plain("\t1 2\t") == "1 2"
    assert Separator(";", True).plain(" 1,5;2; ") == "1.5;2"
    assert Separator(",").cells("a, b ,c") == Separator("").cells(" a  b c") == ["a", "b", "c"]
    assert [as_number(cell) for cell in ("1", "1_0", "x", "")] == [1.0, None, None, None]


# Tables of grasps


def table_of(seed: int, n: int) -> GraspTable:
    rng = np.random.default_rng(seed)
    odd = np.array(["sphere", 'a "box"', "=1+1", "'quoted", "x;y,z", " ", "-3"])
    return GraspTable(
        {
            "object": odd[rng.integers(len(odd), size=n)],
            "size_m": np.where(rng.random(n) < 0.2, np.nan, rng.random(n)),
            "switch.a": rng.random(n) < 0.5,
            "switch.b": rng.random(n) < 0.5,
            "angle_rad.c": rng.normal(size=n),
            "free": rng.integers(9, size=n).astype(float),
        }
    )


def same(one: GraspTable, other: GraspTable) -> None:
    assert one.columns == other.columns
    for name, column in one.cells.items():
        assert column.dtype.kind == other.cells[name].dtype.kind, name
        np.testing.assert_array_equal(column, other.cells[name], err_msg=name)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("seed", range(3))
def test_tables_are_read_at_once_and_as_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int, separator: str
) -> None:
    rng = np.random.default_rng(seed)
    lines = [separator.join(["object", "size_m", "switch.a", "angle_rad.c", "free", "word"])]
    for _ in range(30):
        cells = [rng.choice(["ball", "'=box", ""]), rng.choice(["", "0.5", "nan"]), rng.choice(["0", "1"])]
        cells += [f"{rng.normal():.17g}", rng.choice(["1", "", "2e3"]), rng.choice(["a", "3", ""])]
        lines.append(separator.join(cells))
    path = tmp_path / "it.csv"
    path.write_text("\n".join(lines) + "\n")
    with monkeypatch.context() as only:
        only.setattr(tables, "_parse_slowly", None)
        quick = read_grasp_table(path)
        some = read_grasp_table(path, columns=["angle*", "free"], label="word")
    monkeypatch.setattr(tables, "_fast_numbers", lambda *_: None)
    same(quick, read_grasp_table(path))
    same(some, read_grasp_table(path, columns=["angle*", "free"], label="word"))
    assert quick.cells["object"][0] in ("ball", "=box", "")
    assert {name: column.dtype.kind for name, column in quick.cells.items()} == {
        "object": "U",
        "size_m": "f",
        "switch.a": "b",
        "angle_rad.c": "f",
        "free": "f",
        "word": "U",
    }
    assert some.columns == ("angle_rad.c", "free", "word")


@pytest.mark.parametrize("block", [7, 64, 1 << 22])
def test_a_written_table_comes_back_in_blocks_of_any_size(tmp_path: Path, block: int) -> None:
    table = table_of(1, 40)
    tables.write_grasp_table(table, tmp_path / "it.csv")
    parts = list(tables.iter_grasp_table(tmp_path / "it.csv", block=block))
    assert (len(parts) > 1) == (block < 1000)
    for name, column in table.cells.items():
        whole = np.concatenate([part.cells[name] for part in parts])
        stripped = np.char.strip(column) if column.dtype.kind == "U" else column
        np.testing.assert_array_equal(whole, stripped, err_msg=name)
    # No cell of the file begins like a formula.
    for line in (tmp_path / "it.csv").read_text().splitlines()[1:]:
        assert not line.strip('"').startswith("=")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("object,switch.a\nball,1\n\nbox,0\n", "line 3 is blank, and rows follow"),
        ("object,switch.a\nball,1,2\n", "line 2 must have 2 cells like line 1, got 3"),
        ("object,switch.a\nball,1\nball\n", "line 3 must have 2 cells like line 1, got 1"),
        ("object,switch.a\nball,2\n", "line 2, column 'switch.a' must be 0 or 1, got '2'"),
        ("object,size_m\nball,1\nball,x\n", "line 3, column 'size_m' must be a number, got 'x'"),
        ("object,size_m\nball,inf\n", "line 2, column 'size_m' must be finite, got 'inf'"),
        ("object,size_m\nball,1_0\n", "line 2, column 'size_m' must be a number"),
        ('object,size_m\n"ball,1\n', "line 2: .*a cell must close its quotes"),
        ("object,object\nball,1\n", "column 'object' stands there twice"),
        ("object,,a\nball,1,2\n", "line 1: column 2 has no name"),
        ("object,a\n", "has a line of column names but no rows"),
        ("\n\n", "is empty; a grasp table starts with"),
    ],
)
@pytest.mark.parametrize("block", [8, 1 << 22])
def test_what_is_no_table_is_told_with_its_place(tmp_path: Path, text: str, says: str, block: int) -> None:
    path = tmp_path / "it.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match=says):
        list(tables.iter_grasp_table(path, block=block))


def test_truth_may_be_written_in_words(tmp_path: Path) -> None:
    path = tmp_path / "it.csv"
    path.write_text('object;switch.a;free\n\'ball;True;1\n"a;b";false;\nx;1;3\ny;0;4\n\n\n')
    table = read_grasp_table(path)
    assert table.cells["switch.a"].tolist() == [True, False, True, False]
    assert table.cells["object"].tolist() == ["'ball", "a;b", "x", "y"]
    np.testing.assert_array_equal(table.cells["free"], [1, np.nan, 3, 4])


def test_one_column_alone_may_hold_nothing_that_is_no_row(tmp_path: Path) -> None:
    path = tmp_path / "it.csv"
    path.write_text("size_m\n1\n2\n")
    assert read_grasp_table(path).cells["size_m"].tolist() == [1.0, 2.0]


# Formats


def test_weiss_arrays_are_two_fingers(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frames = rng.integers(0, 4000, (5, 2, 13, 6), dtype=np.uint16)
    mask = rng.random((2, 13, 6)) < 0.9
    good = {
        "frames": frames,
        "texel_mask": mask.astype(np.uint8),
        "time_ms": np.array([0, 4, 8, 0, 4]),
        "start": [0, 3],
    }
    path = tmp_path / "it.npz"
    np.savez_compressed(path, **good)
    recording = read(path)
    assert recording.sensor == "Weiss DSA"
    np.testing.assert_allclose(recording.time_s, [0, 4e-3, 8e-3, 0, 4e-3])
    for k in (0, 1):
        pad = recording.pads[f"finger{k}"]
        np.testing.assert_array_equal(pad.frames, frames[:, k])
        np.testing.assert_array_equal(pad.field, mask[k])
        assert pad.pitch_m == (3.4e-3, 3.4e-3)
    assert read(path, pitch_m=1e-3).pads["finger1"].pitch_m == (1e-3, 1e-3)
    for name, wrong, says in (
        ("frames", frames[:, 0], "frames must have shape"),
        ("texel_mask", mask[:1], "frames must have shape"),
        ("time_ms", np.array(["a"] * 5), "time_ms must be numbers"),
        ("time_ms", np.arange(4), "time"),
    ):
        np.savez(path, **(good | {name: wrong}))
        with pytest.raises(FormatError, match=says):
            read(path)
    np.savez(path, **good)
    with pytest.raises(FormatError, match="13"):
        read(path, shape=(6, 13))


def test_capacitance_is_a_frame_of_a_screen(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(-3, 900, (4, 5, 7)).astype(np.int16)
    path = tmp_path / "it.npz"
    np.savez(path, capacitance=frames)
    recording = read(path)
    np.testing.assert_array_equal(recording.pads["pad"].frames, frames)
    assert recording.pads["pad"].pitch_m == (4.79e-3, 4.79e-3)
    assert recording.sensor == "mutual-capacitance touch screen"
    np.savez(path, capacitance=frames, pitch_mm=[4.0, 5.0])
    assert read(path).pads["pad"].pitch_m == pytest.approx((4e-3, 5e-3))
    assert read(path, pitch_m=1e-3).pads["pad"].pitch_m == (1e-3, 1e-3)
    with pytest.raises(FormatError, match="5 x 7"):
        read(path, shape=(7, 5))
    for wrong in ({"pitch_mm": "x"}, {"pitch_mm": [1.0, 2, 3]}, {"capacitance": frames[None, None]}):
        np.savez(path, **({"capacitance": frames} | wrong))
        with pytest.raises(FormatError, match=r"it\.npz"):
            read(path)


def npy(tmp_path: Path, array: np.ndarray) -> Path:
    np.save(tmp_path / "it.npy", array)
    return tmp_path / "it.npy"


@pytest.mark.parametrize(
    ("had", "shape", "expected", "note"),
    [
        ((2, 3, 4, 3), None, (2, 3, 4), "component 2 of 3"),
        ((2, 3, 4, 1), None, (2, 3, 4), ""),
        ((2, 12, 3), (3, 4), (2, 3, 4), "component 2 of 3"),
        ((2, 12, 3), (12, 3), (2, 12, 3), ""),
        ((2, 3, 4), None, (2, 3, 4), ""),
        ((2, 3, 4), (3, 4), (2, 3, 4), ""),
        ((2, 12, 3), None, (2, 12, 3), "read as 12 x 3 taxels; if the last axis"),
        ((3, 4), (3, 4), (1, 3, 4), ""),
        ((5, 12), (3, 4), (5, 3, 4), ""),
        ((3, 4), None, (1, 3, 4), "read as one frame of 3 x 4"),
        ((12, 12), (12, 12), (1, 12, 12), ""),
    ],
)
def test_an_array_of_any_order_is_frames(
    tmp_path: Path, had: tuple[int, ...], shape: tuple[int, int] | None, expected: tuple[int, ...], note: str
) -> None:
    array = np.arange(float(np.prod(had))).reshape(had)
    recording = read(npy(tmp_path, array), shape=shape)
    frames = recording.pads["pad"].frames
    assert frames.shape == expected
    assert bool(recording.notes) == bool(note)
    assert note in " ".join(recording.notes)
    taken = array[..., 2] if "component" in note else array
    np.testing.assert_array_equal(frames.ravel(), taken.ravel())


@pytest.mark.parametrize(("had", "shape"), [((2, 3, 4, 2), None), ((4,), None), ((5, 13), (3, 4)), ((2, 3, 4), (4, 3))])
def test_an_array_that_is_no_frames_is_refused(
    tmp_path: Path, had: tuple[int, ...], shape: tuple[int, int] | None
) -> None:
    with pytest.raises(FormatError):
        read(npy(tmp_path, np.zeros(had)), shape=shape)


def test_height_maps_are_rows_of_numbers(tmp_path: Path) -> None:
    heights = np.arange(6.0).reshape(2, 3) / 7
    for separator in (",", ";", "\t", " "):
        np.savetxt(tmp_path / "it.txt", heights, delimiter=separator)
        np.testing.assert_array_equal(read_height_map(tmp_path / "it.txt"), heights)
    np.testing.assert_array_equal(
        read_height_map(npy(tmp_path, heights.astype(np.float32))), heights.astype(np.float32)
    )
    assert read_height_map(npy(tmp_path, np.eye(2, dtype=int))).dtype == np.float64
    for wrong, says in (
        (np.ones((1, 2)), "2 x 2 points or more, got shape"),
        (np.ones((2, 1)), "2 x 2 points or more"),
        (np.ones((2, 2, 2)), "2 x 2 points or more"),
        (np.full((2, 2), "a"), "must be real numbers"),
        (np.ones((2, 2), complex), "must be real numbers"),
    ):
        with pytest.raises(FormatError, match=says):
            read_height_map(npy(tmp_path, wrong))


@pytest.mark.parametrize("title", ["", "time_s,a,b,c\n", "t,a,b,c\n", "time_ms,a,b,c\n", "frame,a,b,c\n"])
def test_a_time_ahead_is_told_by_its_title_or_the_shape(tmp_path: Path, title: str) -> None:
    frames = np.arange(1.0, 25).reshape(4, 2, 3)
    time = np.array([0.5, 1.0, 1.5, 2.0])
    unit = 1e3 if "ms" in title else 1.0
    rows = [[unit * t, *row] for t, frame in zip(time, frames, strict=True) for row in frame]
    text = io.StringIO()
    np.savetxt(text, rows, delimiter=",", fmt="%.6g")
    lines = text.getvalue().splitlines()
    blocks = "\n\n".join("\n".join(lines[2 * k : 2 * k + 2]) for k in range(4))
    path = tmp_path / "it.csv"
    for body in (blocks, "\n".join(lines)):
        path.write_text(title + body + "\n")
        got = read(path, shape=(2, 3))
        np.testing.assert_array_equal(got.pads["pad"].frames, frames)
        if "frame" in title:
            assert got.time_s is None
        else:
            np.testing.assert_allclose(got.time_s, time)
    if title:
        path.write_text(title + blocks + "\n")
        np.testing.assert_array_equal(read(path).pads["pad"].frames, frames)


# Tekscan


def tekscan(frames: list[str], **header: str) -> str:
    told = {"ROWS": "2", "COLS": "3", "ROW_SPACING": "1.27 mm", "COL_SPACING": "2.54 mm", "UNITS": "RAW"} | header
    lines = [f"{key} {value}" for key, value in told.items()]
    return (
        "\n".join(["DATA_TYPE MOVIE", *lines, "ASCII_DATA @@", ""])
        + "\n"
        + "\n\n".join(f"Frame {k}\n{frame}" for k, frame in enumerate(frames, 1))
    )


def test_counts_are_whole_and_taxels_that_are_no_taxels_lie_outside(tmp_path: Path) -> None:
    path = tmp_path / "it.asf"
    for start, end, note in (
        ("1", "2", ""),
        ("5", "6", ""),
        ("1", "4", "2 frames are there, START_FRAME and END_FRAME promise 4"),
    ):
        path.write_text(tekscan(["B,1,2\n3,4,5\n", "B,0,0\n7,8,9\n"], START_FRAME=start, END_FRAME=end))
        recording = read(path)
        pad = recording.pads["pad"]
        assert pad.frames.dtype == np.int32
        np.testing.assert_array_equal(pad.frames, [[[0, 1, 2], [3, 4, 5]], [[0, 0, 0], [7, 8, 9]]])
        np.testing.assert_array_equal(pad.field, [[False, True, True], [True, True, True]])
        assert pad.pitch_m == pytest.approx((1.27e-3, 2.54e-3))
        assert [each for each in recording.notes if "frames are there" in each] == ([note] if note else [])
    path.write_text(tekscan(["1,1,2\n3,4,5.5\n"]))
    assert read(path).pads["pad"].frames.dtype == np.float64
    path.write_text(tekscan(["1,1,2\n3,4,3000000000\n"]))
    assert read(path).pads["pad"].frames.max() == 3_000_000_000
    for wrong in ("0", "10001", "1.5", "-1", "x"):
        path.write_text(tekscan(["1,2,3\n4,5,6\n"], ROWS=wrong))
        with pytest.raises(FormatError, match="ROWS must be a whole number from 1 to 10000"):
            read(path)


# Taxels on no grid


def test_positions_belong_to_a_row_of_taxels() -> None:
    places = np.array([[0, 0], [1e-3, 0], [0, 1e-3]])
    pad = Pad(np.ones((2, 1, 3)), positions_m=places.tolist())  # type: ignore[arg-type]
    assert isinstance(pad.positions_m, np.ndarray)
    np.testing.assert_array_equal(pad.positions_m, places)
    for frames, wrong in (
        (np.ones((2, 1, 3)), places[:2]),
        (np.ones((2, 1, 3)), places * np.nan),
        (np.ones((2, 1, 3)), places.T[:1]),
        (np.ones((2, 1, 3)), [["a", "b"]] * 3),
        (np.ones((2, 3, 3)), places),
    ):
        with pytest.raises(InputError, match=r"positions_m must be finite \(x, y\) of each of 3 taxels in one row"):
            Pad(frames, positions_m=wrong)  # type: ignore[arg-type]


def test_masks_of_taxels_on_no_grid_may_be_one_row(tmp_path: Path) -> None:
    places, mask = np.array([[0, 0], [1e-3, 0], [0, 1e-3]]), np.array([True, True, False])
    frames = np.array([[[1, 2, 0]], [[3, 4, 0]]])
    for shape in ((3,), (1, 3)):
        np.savez(
            tmp_path / "it.npz",
            pressure=frames,
            positions_m=places,
            valid=mask.reshape(shape),
            field=mask.reshape(shape),
        )
        pad = read(tmp_path / "it.npz").pads["pad"]
        np.testing.assert_array_equal(pad.valid, mask[None])
        np.testing.assert_array_equal(pad.field, mask[None])
    np.savez(tmp_path / "it.npz", pressure=frames, valid=mask)
    with pytest.raises(FormatError, match="valid"):
        read(tmp_path / "it.npz")
