"""Laws of files that can be read in two ways, one of them wrong: the reader refuses, or says which way it took."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold import Pad, Recording, read
from varishold.errors import FormatError, InputError
from varishold.recording import write
from varishold.recording.conversion import convert
from varishold.recording.inspection import faults_of, summarize
from varishold.recording.messages import read_message


def csv(path: Path, rows: np.ndarray, header: str = "") -> Path:
    lines = [",".join(f"{value:g}" for value in row) for row in rows]
    path.write_text("\n".join([header] * bool(header) + lines) + "\n")
    return path


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.booleans(), st.integers(60, 100))
def test_a_column_behind_the_taxels_is_not_read_as_the_time_before_them(
    tmp_path_factory: pytest.TempPathFactory, seed: int, titled: bool, n: int
) -> None:
    rng = np.random.default_rng(seed)
    rows = np.column_stack([rng.normal(0, 1, (n, 12)), np.full(n, 23.5)])
    header = ",".join([*(f"t{k}" for k in range(12)), "temperature"]) if titled else ""
    with pytest.raises(FormatError, match="is no time; leave out the column that is no taxel"):
        read(csv(tmp_path_factory.mktemp("odd") / "a.csv", rows, header), shape=(3, 4))


def test_a_corner_that_is_never_pressed_is_no_time(tmp_path: Path) -> None:
    rows = np.column_stack([np.zeros(9), np.ones((9, 12))])
    with pytest.raises(FormatError, match="never changes"):
        read(csv(tmp_path / "a.csv", rows), shape=(3, 4))
    assert read(csv(tmp_path / "b.csv", rows, "time_s," + ",".join("abcdefghijkl")), shape=(3, 4)).time_s is not None


@pytest.mark.parametrize("header", ["", "zeit" + ",t" * 12, "time_ms" + ",t" * 12, "frame" + ",t" * 12])
def test_a_first_column_that_runs_is_the_time_or_the_number(tmp_path: Path, header: str) -> None:
    rows = np.column_stack([np.arange(9) / 4, np.random.default_rng(0).normal(0, 1, (9, 12))])
    recording = read(csv(tmp_path / "a.csv", rows, header), shape=(3, 4))
    assert recording.pads["pad"].frames.shape == (9, 3, 4)
    assert (recording.time_s is None) == header.startswith("frame")
    rows[5, 0] = 0.0
    if not header.startswith("zeit"):
        assert read(csv(tmp_path / "b.csv", rows, header), shape=(3, 4)).n_frames == 9


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("n_ahead", [0, 1])
def test_a_line_that_counts_the_columns_of_a_data_frame_is_no_frame(tmp_path: Path, first: int, n_ahead: int) -> None:
    rows = np.random.default_rng(0).normal(0, 1, (3, 20 + n_ahead))
    rows[:, :n_ahead] = [[0], [1], [2]]
    header = ",".join(map(str, range(first, first + 20 + n_ahead)))
    recording = read(csv(tmp_path / "a.csv", rows, header), shape=(4, 5))
    assert recording.n_frames == 3
    assert recording.notes == (f"line 1 counts its columns, {first} to {first + 19 + n_ahead}: taken for a header",)


def test_a_frame_that_counts_is_one_where_it_may_be(tmp_path: Path) -> None:
    ramp = np.arange(16.0)
    assert read(csv(tmp_path / "a.csv", ramp[None]), shape=(4, 4)).n_frames == 1
    assert read(csv(tmp_path / "b.csv", np.stack([ramp, ramp]), "time" + ",t" * 15), shape=(3, 5)).n_frames == 2
    assert read(csv(tmp_path / "c.csv", np.stack([ramp[:4], ramp[4:8]])), shape=(2, 2)).n_frames == 2
    assert read(csv(tmp_path / "d.csv", np.stack([2 * ramp, ramp])), shape=(4, 4)).n_frames == 2


@pytest.mark.parametrize("name", ["r{}c{}", "row{}_col{}", "{}_{}", "p({}; {})", "T R{} C{}", "{}x{}"])
def test_columns_that_are_not_called_row_by_row_are_told(tmp_path: Path, name: str) -> None:
    rows = np.random.default_rng(0).normal(0, 1, (3, 12))
    called = [name.format(row, col) for row in range(3) for col in range(4)]
    assert read(csv(tmp_path / "a.csv", rows, ",".join(called)), shape=(3, 4)).n_frames == 3
    by_column = [called[4 * row + col] for col in range(4) for row in range(3)]
    with pytest.raises(FormatError, match=r"not in the order of their numbers: .* call them NAME\.ROW\.COLUMN"):
        read(csv(tmp_path / "b.csv", rows, "time_s," + ",".join(by_column[:11])), shape=(1, 11))


@pytest.mark.parametrize("name", ["c{}r{}", "x{}y{}", "T_col{}_row{}"])
def test_names_may_tell_the_column_first(tmp_path: Path, name: str) -> None:
    rows = np.random.default_rng(0).normal(0, 1, (3, 12))
    by_row = ",".join(name.format(col, row) for row in range(3) for col in range(4))
    assert read(csv(tmp_path / "a.csv", rows, by_row), shape=(3, 4)).n_frames == 3
    by_column = ",".join(name.format(col, row) for col in range(4) for row in range(3))
    with pytest.raises(FormatError, match="not in the order of their numbers"):
        read(csv(tmp_path / "b.csv", rows, by_column), shape=(3, 4))


def test_columns_that_were_sorted_as_text_are_told(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).normal(0, 1, (3, 12))
    header = ",".join(sorted(f"t{k}" for k in range(12)))
    with pytest.raises(FormatError, match="'t2' stands behind 't11'"):
        read(csv(tmp_path / "a.csv", rows, header), shape=(3, 4))
    assert read(csv(tmp_path / "b.csv", rows, ",".join("t" * 12)), shape=(3, 4)).n_frames == 3


@pytest.mark.parametrize("name", ["r{}c{}", "R {} C {}", "row{}_col{}", "c{1}r{0}", "({} {})"])
def test_titles_of_a_pad_that_lies_across_the_shape_are_told(tmp_path: Path, name: str) -> None:
    rows = np.random.default_rng(0).normal(0, 1, (3, 12))
    header = ",".join(name.format(row, col) for row in range(1, 4) for col in range(1, 5))
    assert read(csv(tmp_path / "a.csv", rows, header), shape=(3, 4)).n_frames == 3
    with pytest.raises(FormatError, match=r"are those of 3 x 4 taxels, not of 4 x 3; say the shape 3x4"):
        read(csv(tmp_path / "b.csv", rows, header), shape=(4, 3))
    # What the numbers of other shapes count nobody knows: two fingers of six taxels, one above the other.
    assert read(csv(tmp_path / "c.csv", rows, header), shape=(6, 2)).n_frames == 3


@pytest.mark.parametrize("ahead", ["frame,time_ms", "time_ms,frame", ",time_ms", "nr,t [ms]", "Unnamed: 0,Time (ms)"])
def test_a_number_and_a_time_may_both_stand_before_the_taxels(tmp_path: Path, ahead: str) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (5, 12)).round(3)
    counts, time = np.arange(5.0) + 3, np.arange(5.0) * 20
    swapped = ahead.startswith("time")
    table = np.column_stack([time, counts, frames] if swapped else [counts, time, frames])
    recording = read(csv(tmp_path / "a.csv", table, ahead + ",t" * 12), shape=(3, 4))
    np.testing.assert_allclose(recording.pads["pad"].frames.reshape(5, 12), frames)
    assert recording.time_s is not None
    np.testing.assert_allclose(recording.time_s, time / 1000)


@pytest.mark.parametrize("ahead", ["frame,index", "time_s,t_ms", "frame,what", "what,time_s"])
def test_two_columns_before_the_taxels_that_are_no_number_and_time_are_refused(tmp_path: Path, ahead: str) -> None:
    table = np.random.default_rng(0).normal(0, 1, (5, 14))
    with pytest.raises(FormatError, match="or one more with the time ahead, for this shape; got 14"):
        read(csv(tmp_path / "a.csv", table, ahead + ",t" * 12), shape=(3, 4))


def blocks(path: Path, frames: np.ndarray) -> Path:
    path.write_text("\n\n".join("\n".join(",".join(f"{v:g}" for v in row) for row in frame) for frame in frames) + "\n")
    return path


def test_a_time_at_every_row_of_a_frame_is_no_taxel(tmp_path: Path) -> None:
    frames = np.random.default_rng(0).integers(0, 9, (5, 3, 4))
    time = np.arange(5) * 0.25
    timed = np.concatenate([np.broadcast_to(time[:, None, None], (5, 3, 1)), frames], axis=2)
    with pytest.raises(FormatError, match="if it is a time, say the shape 3x4; if it is taxels, 3x5") as told:
        read(blocks(tmp_path / "a.csv", timed))
    assert told.value.parameter == "shape"
    recording = read(tmp_path / "a.csv", shape=(3, 4))
    np.testing.assert_array_equal(recording.pads["pad"].frames, frames)
    assert recording.time_s is not None
    assert recording.time_s.tolist() == time.tolist()
    np.testing.assert_array_equal(read(tmp_path / "a.csv", shape=(3, 5)).pads["pad"].frames, timed)
    # It falls once, it stands once, it is not the same all down: it is a taxel.
    for frame, row, value in ((2, slice(None), 0.0), (2, slice(None), 0.25), (2, 0, 0.6)):
        other = timed.copy()
        other[frame, row, 0] = value
        assert read(blocks(tmp_path / "b.csv", other)).pads["pad"].shape == (3, 5)


@pytest.mark.parametrize("first", [0, 1])
def test_numbers_of_the_rows_of_a_frame_are_no_taxels(tmp_path: Path, first: int) -> None:
    frames = np.random.default_rng(0).integers(0, 9, (5, 3, 4))
    counted = np.concatenate([np.broadcast_to(np.arange(first, first + 3)[:, None], (5, 3, 1)), frames], axis=2)
    with pytest.raises(FormatError, match=f"numbers the rows of each frame, {first} to {first + 2}: leave it out"):
        read(blocks(tmp_path / "a.csv", counted))
    np.testing.assert_array_equal(read(tmp_path / "a.csv", shape=(3, 5)).pads["pad"].frames, counted)
    counted[4, 2, 0] = 9
    assert read(blocks(tmp_path / "b.csv", counted)).pads["pad"].shape == (3, 5)


@pytest.mark.parametrize(("title", "told"), [("", True), ("what", True), ("time_s", False), ("frame", False)])
def test_a_first_column_that_counts_is_told_where_nothing_calls_it_a_time(
    tmp_path: Path, title: str, told: bool
) -> None:
    rows = np.column_stack([np.arange(4) + 7, np.random.default_rng(0).integers(0, 9, (4, 12))])
    recording = read(csv(tmp_path / "a.csv", rows, title and title + ",t" * 12), shape=(3, 4))
    assert recording.notes == (
        "the first column counts 7 to 10: taken for seconds; if these are numbers of frames, call it frame",
    ) * told  # fmt: skip
    rows[3, 0] = 11
    assert read(csv(tmp_path / "b.csv", rows, title and title + ",t" * 12), shape=(3, 4)).notes == (
        "the first column, 'what', is taken for a time in seconds",
    ) * (title == "what")  # fmt: skip


@pytest.mark.parametrize(
    ("titles", "told"),
    [("", True), ("time", True), ("frame,time", True), ("time_s", False), ("t/ms", False), ("frame,t_ms", False)],
)
def test_whole_numbers_far_apart_are_told_to_be_taken_for_seconds(tmp_path: Path, titles: str, told: bool) -> None:
    """As a controller's ``millis()`` are."""
    ahead = [np.arange(9)] * titles.count(",") + [np.arange(9) * 20 + 1203]
    rows = np.column_stack([*ahead, np.random.default_rng(0).integers(0, 9, (9, 12))]).astype(float)
    recording = read(csv(tmp_path / "a.csv", rows, titles and titles + ",p" * 12), shape=(3, 4))
    assert recording.notes == (
        "times are whole numbers 20 apart, taken for seconds; if they are milliseconds, call them time_ms",
    ) * told  # fmt: skip
    rows[4, len(ahead) - 1] += 0.5
    assert not read(csv(tmp_path / "b.csv", rows, titles and titles + ",p" * 12), shape=(3, 4)).notes


@pytest.mark.parametrize(("separator", "mark"), [(";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ",")])
def test_a_mark_between_thousands_is_no_decimal_sign(tmp_path: Path, separator: str, mark: str) -> None:
    def saved(name: str, texts: list[list[str]]) -> Path:
        (tmp_path / name).write_text("\n".join(separator.join(row) for row in texts).replace(".", mark) + "\n")
        return tmp_path / name

    counts = np.array([[998, 0, 1002, 12], [1040, 3, 997, 12], [999, 7, 1000, 12]])
    parted = [[f"{count:,}".replace(",", ".") for count in row] for row in counts.tolist()]
    with pytest.raises(FormatError, match="column 1 has numbers with a mark before just three digits, and others with"):
        read(saved("a.csv", parted), shape=(2, 2))
    # Fractions: as many digits everywhere, a column of them, other digits too, a number that nothing parts.
    for name, change in {"b": [f"{k / 1000:.3f}" for k in (1998, 3000, 5125)], "c": ["1.25", "998", "1.002"],
                         "d": ["0.250", "998", "1.002"], "e": ["1234", "998", "1.002"]}.items():  # fmt: skip
        texts = [[cell, "0", "2", "12"] for cell in change]
        assert read(saved(f"{name}.csv", texts), shape=(2, 2)).pads["pad"].frames[:, 0, 0].tolist() == [
            float(cell) for cell in change
        ]


def test_a_mark_between_thousands_of_xsensor_is_told_once_with_its_file(tmp_path: Path) -> None:
    head = "Rows:,1\nColumns:,2\n"
    (tmp_path / "a.csv").write_text(f'{head}"1,024",3\n{head}998,"1,003"\n')
    with pytest.raises(
        FormatError, match=r"^(?!.*a\.csv.*a\.csv).*a\.csv: column 1 has numbers with a mark before just"
    ):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_may_stand_in_quotes(tmp_path: Path, separator: str) -> None:
    for name, quote in (("a", ""), ("b", '"')):
        lines = ["0,5 1,25 2 3", "4,5 5 6,125 7"]
        text = "\n".join(separator.join(f"{quote}{cell}{quote}" for cell in line.split()) for line in lines)
        (tmp_path / f"{name}.csv").write_text(text + "\n")
        frames = read(tmp_path / f"{name}.csv", shape=(2, 2)).pads["pad"].frames
        assert frames.reshape(2, 4).tolist() == [[0.5, 1.25, 2, 3], [4.5, 5, 6.125, 7]]


def test_a_comma_between_thousands_within_quotes_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('1,2,3,4\n5,"1,006",7,8\n')
    with pytest.raises(FormatError, match="must have 4 numbers like line 1, got 5; write numbers without commas in th"):
        read(tmp_path / "a.csv", shape=(2, 2))


@pytest.mark.parametrize("axis", [1, 2])
def test_sums_and_numbers_beside_the_taxels_are_none(tmp_path: Path, axis: int) -> None:
    frames = np.random.default_rng(0).integers(0, 9, (5, 4, 4))
    what = {1: "row", 2: "column"}[axis]
    total = np.concatenate([frames, frames.sum(axis=axis, keepdims=True)], axis=axis)
    shape = (total.shape[1], total.shape[2])
    with pytest.raises(FormatError, match=f"the last {what} is the sum of the others: leave it out"):
        read(blocks(tmp_path / "a.csv", total))
    np.testing.assert_array_equal(read(tmp_path / "a.csv", shape=shape).pads["pad"].frames, total)
    # What presses two lines of taxels alike, and nothing else, is no sum.
    bar = np.zeros((5, 5, 5), int)
    bar[2:, :, -2:] = bar[2:, -2:] = 7
    assert read(blocks(tmp_path / "bar.csv", bar)).pads["pad"].shape == (5, 5)
    total[2, -1, -1] += 1
    assert read(blocks(tmp_path / "b.csv", total)).pads["pad"].shape == shape
    head = np.arange(4).reshape((1, 1, 4) if axis == 1 else (1, 4, 1))
    numbered = np.concatenate([np.repeat(head, 5, axis=0), frames], axis=axis)
    with pytest.raises(
        FormatError, match=f"the first {what} numbers the {({'row': 'columns', 'column': 'rows'})[what]}"
    ):
        read(blocks(tmp_path / "c.csv", numbered))


@pytest.mark.parametrize(
    "stamp", ["2024-03-31T24:59:59.9", "31.03.2024 00:59", "3/31/24", "00:59:59.9", '"2024-03-31 00:59"', "2024-02-30"]
)
def test_a_date_is_told_what_to_be(tmp_path: Path, stamp: str) -> None:
    (tmp_path / "a.csv").write_text(f"time,a,b\n{stamp},1,2\n")
    with pytest.raises(FormatError, match=r"line 2, column 1 .*; a date or a time of day: write seconds, or leave"):
        read(tmp_path / "a.csv", shape=(1, 2))


def test_a_table_of_presses_whose_taxels_are_not_called_so_is_told_what_to_call_them(tmp_path: Path) -> None:
    for name, header, row in (("a", "label,r0c0,r0c1", "cup,1,2"), ("b", "r0c0,r0c1,label", "1,2,cup")):
        (tmp_path / f"{name}.csv").write_text(f"{header}\n{row}\n")
        with pytest.raises(
            FormatError, match=r"got 'cup'; where each row is a press, call .* NAME\.ROW\.COLUMN in line 1$"
        ):
            read(tmp_path / f"{name}.csv", shape=(1, 2))
    (tmp_path / "c.csv").write_text("1,2\n3,cup\n")
    with pytest.raises(FormatError, match=r"got 'cup'$"):
        read(tmp_path / "c.csv", shape=(1, 2))


@pytest.mark.parametrize("words", ["time_ms,a,b", "ms,kPa,kPa", "Date: today", "End"])
def test_a_line_of_words_among_numbers_is_told_to_be_left_out(tmp_path: Path, words: str) -> None:
    for name, lines in (("a", ["time_ms,a,b", words, "0,1,2"]), ("b", ["time_ms,a,b", "0,1,2", words, "20,1,2"])):
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
        told = "no number stands in this line: leave it out$" if name == "a" or "," in words else "must have 3 numbers"
        with pytest.raises(FormatError, match=told):
            read(tmp_path / f"{name}.csv", shape=(1, 2))


@pytest.mark.parametrize("end", ["\r\r\n", "\n\n", "\r\n\r\n"])
@pytest.mark.parametrize("ahead", ["", "time_ms"])
def test_ends_of_line_that_were_written_twice_part_no_frames(tmp_path: Path, end: str, ahead: str) -> None:
    """As Python's csv writes them on Windows to a file that was opened without ``newline=""``."""
    frames = np.random.default_rng(0).integers(0, 9, (5, 12))
    table = np.column_stack([np.arange(5) * 20, frames]) if ahead else frames
    lines = [ahead + ",t" * 12] * bool(ahead) + [",".join(map(str, row)) for row in table]
    (tmp_path / "a.csv").write_bytes((end.join(lines) + end).encode())
    recording = read(tmp_path / "a.csv", shape=(3, 4))
    np.testing.assert_array_equal(recording.pads["pad"].frames.reshape(5, 12), frames)
    if ahead:
        assert recording.time_s is not None
        np.testing.assert_allclose(recording.time_s, np.arange(5) * 0.02)
    with pytest.raises(FormatError, match=r"frame 0 .* has 1 row where the given shape has 4"):
        read(tmp_path / "a.csv", shape=(4, 4))


def test_a_line_that_was_cut_off_behind_a_separator_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t0,t1,t2\n1,2,3\n4,5,6\n7,8,")
    recording = read(tmp_path / "a.csv", shape=(1, 3))
    assert recording.n_frames == 2
    assert recording.notes == ("line 4 is cut off in the middle, and left out: it has 2 of 3 numbers",)
    # A last taxel that never says a number is a broken one, also in a last line without an end.
    (tmp_path / "b.csv").write_text("t0,t1,t2\n1,2,\n4,5,\n7,8,")
    recording = read(tmp_path / "b.csv", shape=(1, 3))
    assert recording.n_frames == 3
    assert recording.notes == ("1 taxel is never a number: taken as broken",)


@pytest.mark.parametrize("shape", [(16, 16, 17), (16, 16, 12), (4, 4, 5), (12, 16, 120)])
def test_frames_that_may_be_the_last_axis_are_told(tmp_path: Path, shape: tuple[int, int, int]) -> None:
    frames = np.random.default_rng(0).normal(0, 1, shape)
    n, rows, cols = shape
    np.save(tmp_path / "a.npy", frames)
    (note,) = read(tmp_path / "a.npy").notes
    assert f"read as {n} frames of {rows} x {cols}" in note
    assert f"{cols} frames of {n} x {rows}" in note
    if cols > rows:
        np.save(tmp_path / "b.npy", np.moveaxis(frames, -1, 0))
        assert read(tmp_path / "b.npy").notes == ()


@pytest.mark.parametrize("shape", [(16, 16, 120), (4, 4, 8), (8, 8, 1000)])
def test_frames_that_are_hardly_the_first_axis_are_refused_until_their_shape_is_said(
    tmp_path: Path, shape: tuple[int, int, int]
) -> None:
    array = np.random.default_rng(0).normal(0, 1, shape)
    n, rows, cols = shape
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(
        FormatError, match=rf"may be {n} frames of {rows} x {cols} taxels, or {cols} frames of {n}"
    ) as told:
        read(tmp_path / "a.npy")
    assert f"the shape of a frame, {rows}x{cols} or {n}x{rows}" in str(told.value)
    assert told.value.parameter == "shape"
    first = read(tmp_path / "a.npy", shape=(rows, cols))
    np.testing.assert_array_equal(first.pads["pad"].frames, array)
    assert first.notes == ()
    last = read(tmp_path / "a.npy", shape=(n, rows))
    np.testing.assert_array_equal(last.pads["pad"].frames, np.moveaxis(array, -1, 0))
    assert last.notes == (f"read as {cols} frames of {n} x {rows}: time is the last axis",)


def as_npz(path: Path, **arrays: np.ndarray) -> Path:
    np.savez(path.with_suffix(".npz"), **arrays)
    return path.with_suffix(".npz")


def as_mat(path: Path, **arrays: np.ndarray) -> Path:
    scipy_io = pytest.importorskip("scipy.io")
    scipy_io.savemat(path.with_suffix(".mat"), arrays)
    return path.with_suffix(".mat")


def as_hdf5(path: Path, **arrays: np.ndarray) -> Path:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        for name, array in arrays.items():
            file[name] = array
    return path.with_suffix(".h5")


@pytest.mark.parametrize("written", [as_npz, as_mat, as_hdf5])
def test_time_may_be_the_last_axis_in_other_peoples_archives(tmp_path: Path, written: Any) -> None:
    array = np.random.default_rng(0).normal(0, 1, (16, 16, 120))
    path = written(tmp_path / "a", pressure=array)
    if written is as_npz:
        # Its order is said: frames come first.
        (note,) = read(path).notes
        assert note.startswith("read as 16 frames of 16 x 120 taxels; if these are 120 frames of 16 x 16")
    else:
        with pytest.raises(FormatError, match="may be 16 frames of 16 x 120 taxels, or 120 frames of 16 x 16"):
            read(path)
    last = read(path, shape=(16, 16))
    np.testing.assert_array_equal(last.pads["pad"].frames, np.moveaxis(array, -1, 0))
    if written is not as_mat:
        assert last.notes == ("read as 120 frames of 16 x 16: time is the last axis",)
    np.testing.assert_array_equal(read(path, shape=(16, 120)).pads["pad"].frames, array)
    (note,) = read(written(tmp_path / "b", pressure=array[:12])).notes
    assert note.startswith("read as 12 frames of 16 x 120 taxels; if these are 120 frames of 12 x 16")
    with pytest.raises(FormatError, match=r"has frames of 16 x 120, not 5 x 5"):
        read(path, shape=(5, 5))


@pytest.mark.parametrize("written", [as_npz, as_mat, as_hdf5])
def test_what_stands_beside_frames_tells_that_they_are_first(tmp_path: Path, written: Any) -> None:
    array = np.random.default_rng(0).normal(0, 1, (16, 16, 40))
    beside = written(tmp_path / "a", pressure=array, time_s=np.arange(16.0))
    assert read(beside).pads["pad"].shape == (16, 40)


@pytest.mark.parametrize("end", [".npz", ".mat", ".h5"])
def test_a_recording_with_as_many_frames_as_rows_comes_back(tmp_path: Path, end: str) -> None:
    recording = Recording({"pad": Pad(np.random.default_rng(0).normal(0, 1, (16, 16, 40)))})
    write(recording, tmp_path / f"a{end}")
    back = read(tmp_path / f"a{end}")
    assert (back.pads["pad"].shape, back.notes) == ((16, 40), ())


def test_a_recording_that_looks_as_if_time_were_last_is_converted(tmp_path: Path) -> None:
    recording = Recording({"pad": Pad(np.random.default_rng(0).normal(0, 1, (5, 5, 20)))})
    assert convert(recording, tmp_path / "a.npy") == ()
    np.testing.assert_array_equal(
        read(tmp_path / "a.npy", shape=(5, 20)).pads["pad"].frames, recording.pads["pad"].frames
    )


def test_a_pitch_in_millimetres_is_asked_about() -> None:
    frames = np.random.default_rng(0).normal(0, 1, (5, 4, 4))
    remarks = Recording({"palm": Pad(frames, pitch_m=(4.0, 4.0))}).remarks
    assert remarks == ("pad palm: taxels are 4 m apart: is the pitch in millimetres?",)
    assert Recording({"palm": Pad(frames, pitch_m=(0.05, 0.004))}).remarks == ()


def lines(path: Path, cells: list[list[str]], end: str = "\n") -> Path:
    path.write_text("\n".join(",".join(row) for row in cells) + end)
    return path


@pytest.mark.parametrize("gap", ["", "nan", "NaN", "NA", "null", '""'])
def test_taxels_that_never_say_a_number_are_taken_as_broken(tmp_path: Path, gap: str) -> None:
    rows = np.random.default_rng(0).integers(0, 9, (20, 12))
    cells = [[str(value) if k not in (3, 7) else gap for k, value in enumerate(row)] for row in rows]
    recording = read(lines(tmp_path / "a.csv", cells), shape=(3, 4))
    pad = recording.pads["pad"]
    assert pad.valid is not None
    np.testing.assert_array_equal(np.flatnonzero(~pad.valid.ravel()), [3, 7])
    assert recording.notes == ("2 taxels are never a number: taken as broken",)
    np.testing.assert_array_equal(pad.frames[:, pad.valid], rows.reshape(20, 3, 4)[:, pad.valid])
    cells[5][0] = gap
    with pytest.raises(FormatError, match=r"frame 5 has no number for the taxel at \(row, col\) = \(0, 0\)"):
        read(lines(tmp_path / "b.csv", cells), shape=(3, 4))
    cells = [[gap, *row[1:]] for row in cells]
    assert read(lines(tmp_path / "b.csv", cells), shape=(3, 4)).n_frames == 20
    titled = [["time_s", *map(str, range(12))], *([str(k), *row[:11], gap] for k, row in enumerate(cells))]
    last = read(lines(tmp_path / "d.csv", titled), shape=(3, 4))
    np.testing.assert_array_equal(last.time_s, np.arange(20.0))
    assert last.pads["pad"].valid is not None
    assert not last.pads["pad"].valid[2, 3]
    with pytest.raises(FormatError, match=r"column 1 must be|got 11"):
        read(lines(tmp_path / "c.csv", [[gap] * 12] * 3), shape=(3, 4))


def test_a_last_line_that_was_cut_off_is_left_out_and_told(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).integers(100, 999, (20, 12))
    whole = lines(tmp_path / "a.csv", rows.astype(str).tolist(), end="").read_text()
    for cut in (2, 6, 25, 40):
        (tmp_path / "b.csv").write_text(whole[:-cut])
        left = whole[:-cut].rsplit("\n", 1)[1].count(",") + 1
        recording = read(tmp_path / "b.csv", shape=(3, 4))
        if left == 12:
            assert recording.n_frames == 20
            continue
        assert recording.n_frames == 19
        assert recording.notes == (f"line 20 is cut off in the middle, and left out: it has {left} of 12 numbers",)
        np.testing.assert_array_equal(recording.pads["pad"].frames, rows[:19].reshape(-1, 3, 4))
        # A line that ends is no line that was cut off.
        for encoding in ("utf-8", "utf-16", "utf-32"):
            (tmp_path / "b.csv").write_text(whole[:-cut] + "\n", encoding=encoding)
            with pytest.raises(FormatError, match="line 20 must have 12 numbers like line 1"):
                read(tmp_path / "b.csv", shape=(3, 4))


def test_numbers_in_quotes_are_numbers_unless_a_comma_stands_in_them(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text('"time_s","a","b"\n"0.0","1","2.5"\n0.1,"3",4\n')
    recording = read(path, shape=(1, 2))
    assert recording.pads["pad"].frames.tolist() == [[[1.0, 2.5]], [[3.0, 4.0]]]
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0.0, 0.1]
    path.write_text('"0,5","1,2"\n"3,1","4,2"\n')
    with pytest.raises(FormatError, match="line 1, column 1 must be a number"):
        read(path, shape=(1, 2))


def test_what_is_no_row_of_numbers_is_told_with_a_way_out(tmp_path: Path) -> None:
    (tmp_path / "a.jsonl").write_text('{"pressure": [[1, 2], [3, 4]]}\n' * 5)
    (tmp_path / "b.csv").write_text("time,data\n" + '0.1,"[1, 2, 3, 4]"\n' * 5)
    np.savetxt(tmp_path / "c.csv", np.random.default_rng(0).normal(0, 1, (9, 49)), delimiter=",")
    for name, told in (
        ("a.jsonl", r"line 1 is JSON.*varishold record stdin: -o FILE.mcap < a\.jsonl"),
        ("b.csv", r"got '\"\[1'; a list in one cell: write a column for each of its numbers"),
        ("c.csv", r"got 49; three for each of 16 taxels, as x, y, z\? keep the one that is normal to the pad"),
    ):
        with pytest.raises(FormatError, match=told):
            read(tmp_path / name, shape=(4, 4))


@pytest.mark.parametrize(
    ("name", "value", "time_s"),
    [
        ("time_s", 2.5, 2.5), ("t_ms", 2500, 2.5), ("timestamp_us", 2.5e6, 2.5), ("time_ns", 2.5e9, 2.5),
        ("timestamp", 1.7e9, 1.7e9), ("t", 1.7e12, 1.7e9), ("time", 1.7e15, 1.7e9), ("timestamp", 1.7e18, 1.7e9),
        ("t", 2.5, None), ("timestamp", 2500, None), ("time", -1.7e9, None), ("time", 5e10, None),
    ],
)  # fmt: skip
@pytest.mark.parametrize("field", [None, "values", "other"])
def test_a_message_tells_its_time_by_a_name_with_its_unit_or_a_date(
    name: str, value: float, time_s: float | None, field: str | None
) -> None:
    message = {"other" if field == "other" else "values": [1.0, 2.0, 3.0, 4.0], name: value}
    said = read_message(message, shape=(2, 2), field=field)
    assert said.time_s == (None if time_s is None else pytest.approx(time_s))


@pytest.mark.parametrize(
    ("begin", "step", "words"),
    [
        (1.7e12, 10.0, "time begins at 1.7e+12 s: is it in milliseconds?"),
        (1.7e15, 1e4, "time begins at 1.7e+15 s: is it in microseconds?"),
        (1.7e18, 1e7, "time begins at 1.7e+18 s: is it in nanoseconds?"),
        (0.0, 1e7, "frames are 1e+07 s apart: is the time in seconds?"),
        (1.7e9, 0.01, None),
        (0.0, 60.0, None),
    ],
)
def test_a_time_that_is_hardly_in_seconds_is_asked_about(begin: float, step: float, words: str | None) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (5, 4, 4))
    recording = Recording({"pad": Pad(frames)}, time_s=begin + step * np.arange(5))
    assert recording.remarks == ((words,) if words else ())
    assert faults_of(recording) == recording.remarks


def test_a_long_pause_is_no_unit() -> None:
    frames = np.random.default_rng(0).normal(0, 1, (5, 4, 4))
    assert Recording({"pad": Pad(frames)}, time_s=np.array([0.0, 0.1, 0.2, 0.3, 9e4])).remarks == ()


def test_a_press_has_a_number_or_none() -> None:
    frames = np.random.default_rng(0).normal(0, 1, (4, 4, 4))
    with pytest.raises(InputError, match="press must be 0 or more, or -1 for none, got -7 at frame 2"):
        Recording({"pad": Pad(frames)}, press=np.array([-1, 0, -7, 1]))
    with pytest.raises(InputError, match=r"got 18446744073709551609 at frame 0"):
        Recording({"pad": Pad(frames)}, press=np.full(4, 2**64 - 7, np.uint64))
    with pytest.raises(
        InputError, match=r"press must be at most 9007199254740992, .* got 18446744073709551615 at frame 1"
    ):
        Recording({"pad": Pad(frames)}, press=np.array([0, 2**64 - 1, 1, 1], np.uint64))
    recording = Recording({"pad": Pad(frames)}, press=np.array([-1, 10**12, 10**12, -1]))
    assert summarize(recording).n_presses == len(recording.presses) == 1


@pytest.mark.parametrize(
    ("what", "given", "says"),
    [
        ("time_s", [0.0, [1.0, 2.0], 3.0], r"time_s must be one number a frame, shape \(3,\), got rows of different"),
        ("press", [[0], [1, 2], 3], r"press must be one whole number a frame, shape \(3,\), got rows of different"),
        ("time_s", np.ma.array([0.0, 1.0, 2.0], mask=[0, 0, 1]), "time_s must be .*, got some that are masked"),
        ("press", np.ma.array([0, 1, 2], mask=[0, 0, 1]), "press must be .*, got some that are masked"),
    ],
)
def test_what_is_beside_frames_is_one_row_and_known(what: str, given: object, says: str) -> None:
    frames = np.random.default_rng(0).normal(0, 1, (3, 4, 4))
    with pytest.raises(InputError, match=says):
        Recording({"pad": Pad(frames)}, **{what: given})  # type: ignore[arg-type]
    with pytest.raises(
        InputError, match=r"press.label must be one text or number a press, 3 of them, got rows of diff"
    ):
        Recording({"pad": Pad(frames)}, press=np.arange(3), press_columns={"label": [["a"], "b", "c"]})  # type: ignore[dict-item]
    with pytest.raises(InputError, match=r"positions_m must be finite .* got rows of different lengths"):
        Pad(frames[:, :1], positions_m=[[0, 0], [1], [0, 1], [1, 1]])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "members",
    [
        {"[Content_Types].xml": "<Types/>", "xl/workbook.xml": "<workbook/>"},
        {"docProps/app.xml": "<Properties/>", "xl/worksheets/sheet1.xml": "<worksheet/>"},
        {"mimetype": "application/vnd.oasis.opendocument.spreadsheet", "content.xml": "<content/>"},
        None,
    ],
)
def test_a_workbook_is_told_to_be_one(tmp_path: Path, members: dict[str, str] | None) -> None:
    if members is None:
        (tmp_path / "a.xls").write_bytes(bytes.fromhex("d0cf11e0a1b11ae1") + bytes(600))
    else:
        with zipfile.ZipFile(tmp_path / "a.xls", "w") as archive:
            for name, text in members.items():
                archive.writestr(name, text)
    with pytest.raises(FormatError, match=r"a\.xls: is a workbook, which is no known format; save its sheet as CSV$"):
        read(tmp_path / "a.xls")


def test_a_pitch_in_millimetres_is_told_to_be_passed_over(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", pressure=np.arange(48).reshape(3, 4, 4), pitch_mm=2.0, unit="raw")
    recording = read(tmp_path / "a.npz")
    assert recording.notes == ("passed over, for it is no part of a recording: pitch_mm",)
    assert recording.pads["pad"].pitch_m is None
