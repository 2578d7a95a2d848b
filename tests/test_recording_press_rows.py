"""Tables of one press a row: what a header says of pads, what stands beside them, and which headers are refused."""
# ruff: noqa: E501

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import FormatError, InputError, TactileClassifier
from varishold.learning import labelled_presses
from varishold.recording import GraspTable, Recording, iter_grasp_table, read


def told(path: Path, *lines: str, shape: tuple[int, int] | None = None) -> Recording:
    path.write_text("\n".join(lines) + "\n")
    return read(path, shape=shape)


HEADER = "label,thumb.0.0,thumb.0.1,palm.0.0,palm.1.0,palm.2.0,angle_rad.0,angle_rad.1,switch.a,session"


def test_pads_and_what_is_known_of_each_press(tmp_path: Path) -> None:
    recording = told(
        tmp_path / "a.csv",
        HEADER,
        "cone,1,2,3,4,5,0.5,0.25,1,1",
        '"a, b",6,7,8,9,10,0.125,,0,2',
    )
    assert {name: pad.frames.tolist() for name, pad in recording.pads.items()} == {
        "thumb": [[[1, 2]], [[6, 7]]],
        "palm": [[[3], [4], [5]], [[8], [9], [10]]],
    }
    assert recording.press is not None
    assert recording.press.tolist() == [0, 1]
    table = recording.presses
    assert list(table.frames) == [range(1), range(1, 2)]
    assert table.columns["label"].tolist() == ["cone", "a, b"]
    assert table.columns["session"].tolist() == [1, 2]
    assert table.columns["session"].dtype.kind == "i"
    assert table.columns["switch.a"].tolist() == [True, False]
    assert table.columns["angle_rad.0"].tolist() == [0.5, 0.125]
    assert np.isnan(table.columns["angle_rad.1"][1])
    assert recording.notes == (
        "pads by the names of their columns: thumb 1 x 2, palm 3 x 1",
        "each row is a press",
    )


@pytest.mark.parametrize(
    "above",
    ["# my rig", "#\n\n# thumb, palm, the first day\n", "# a,b,c,d,e,f,g,h,i,j", "sep=,\n# my rig", "# my rig\nsep=,"],
)
def test_lines_above_the_names_that_begin_with_a_hash_are_passed_over(tmp_path: Path, above: str) -> None:
    rows = ["cone,1,2,3,4,5,0.5,0.25,1,1", "cup,6,7,8,9,10,0.125,,0,2"]
    plain, below = told(tmp_path / "a.csv", HEADER, *rows), told(tmp_path / "b.csv", above, HEADER, *rows)
    assert below.notes == plain.notes
    for name, pad in plain.pads.items():
        assert np.array_equal(below.pads[name].frames, pad.frames)
    assert {name: list(map(str, column)) for name, column in below.press_columns.items()} == {
        name: list(map(str, column)) for name, column in plain.press_columns.items()
    }
    with pytest.raises(
        FormatError, match=f"line {above.count(chr(10)) + 3}, column 'thumb.0.0' must be a number, got 'x'"
    ):
        told(tmp_path / "c.csv", above, HEADER, rows[0].replace("1,2", "x,2", 1))


@settings(max_examples=40)
@given(
    rows=st.lists(st.integers(0, 99), min_size=1, max_size=8),
    comments=st.lists(st.tuples(st.integers(0, 8), st.sampled_from(["# a new glove", "#", " # 1,2", "#1,2,3,4,5"]))),
    block=st.integers(1, 60),
)
def test_lines_between_rows_that_begin_with_a_hash_are_passed_over(
    tmp_path_factory: pytest.TempPathFactory, rows: list[int], comments: list[tuple[int, str]], block: int
) -> None:
    path = tmp_path_factory.mktemp("rows") / "a.csv"
    written: list[tuple[int | None, str]] = [(row, f"cup {row},{row},{row + 1},{row / 4}") for row in rows]
    for place, text in comments:
        written.insert(place, (None, text))
    path.write_text("label,p.0.0,p.0.1,force_n.z\n" + "".join(f"{line}\n" for _, line in written))
    at = [line for line, (row, _) in enumerate(written, start=2) if row is not None]
    recording = read(path)
    assert recording.pads["p"].frames.tolist() == [[[row, row + 1]] for row in rows]
    assert recording.press_columns["label"].tolist() == [f"cup {row}" for row in rows]
    parts = list(iter_grasp_table(path, block=block))
    for table in (GraspTable.joined(parts), GraspTable.joined([GraspTable.joined(parts), *parts])):
        assert [table.where(k) for k in range(len(rows))] == [f"{path}: line {line}" for line in at]
        assert table.cells["force_n.z"].tolist()[: len(rows)] == [row / 4 for row in rows]


@pytest.mark.parametrize("wrong", ["0,b,3,4", "7,a,3,4", "0,a,x,4"])
def test_what_is_wrong_below_a_comment_is_told_with_its_line(tmp_path: Path, wrong: str) -> None:
    with pytest.raises(FormatError, match="line 5, column"):
        told(tmp_path / "a.csv", "press,label,p.0.0,p.0.1", "# first", "0,a,1,2", "# again", wrong)


def test_a_row_may_begin_with_a_hash(tmp_path: Path) -> None:
    recording = told(tmp_path / "a.csv", "label,p.0.0,p.0.1", "#1,1,2", "# no row", '"#2, blue",3,4')
    assert recording.press_columns["label"].tolist() == ["#1", "#2, blue"]


@pytest.mark.parametrize("name", ["#", "#id", "# nr"])
def test_a_first_name_may_begin_with_a_hash(tmp_path: Path, name: str) -> None:
    header = f"{name},label,pad.0.0,pad.0.1"
    recording = told(tmp_path / "a.csv", "# my rig", header, "7,cup,1,2", "8,can,3,4")
    assert recording.pads["pad"].frames.tolist() == [[[1, 2]], [[3, 4]]]
    # What counts rows is passed over.
    assert set(recording.press_columns) == {"label", name} - {"#"}


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("form", ["{}_{}_{}", "{}.{}.{}", "{}[{}][{}]", "{}_{}.{}"])
def test_how_a_place_is_written(tmp_path: Path, form: str, first: int) -> None:
    names = [form.format("f 2", r + first, c + first) for r in range(2) for c in range(3)]
    order = [3, 0, 5, 1, 4, 2]
    recording = told(
        tmp_path / "a.csv",
        ";".join(["object", *(names[k] for k in order)]),
        ";".join(["x", *map(str, order)]),
    )
    assert recording.pads["f 2"].frames.tolist() == [[[0, 1, 2], [3, 4, 5]]]


@pytest.mark.parametrize("form", ["{}_{}", "{}.{}", "{}[{}]"])
@pytest.mark.parametrize("pad", ["thumb", "finger_2", "tip 1"])
def test_taxels_in_rows_want_a_shape_and_joints_beside_them_stay_columns(tmp_path: Path, form: str, pad: str) -> None:
    names = [form.format(pad, k) for k in range(6)]
    lines = [
        ",".join(["label", *names, *(f"joint_{k}" for k in range(5))]),
        ",".join(["cone", *"012345", *"98765"]),
    ]
    recording = told(tmp_path / "a.csv", *lines, shape=(2, 3))
    assert {name: each.frames.tolist() for name, each in recording.pads.items()} == {pad: [[[0, 1, 2], [3, 4, 5]]]}
    assert recording.presses.columns["joint_4"].tolist() == [5]
    with pytest.raises(FormatError, match=r"line 1: columns .* may be pads; say the shape of a pad") as error:
        told(tmp_path / "a.csv", *lines)
    assert error.value.parameter == "shape"


def test_rows_of_which_only_the_time_is_known_are_frames(tmp_path: Path) -> None:
    recording = told(
        tmp_path / "a.csv", "frame,time_ms,a.0.0,a.0.1,b.0.0,b.0.1", "0,0,1,2,3,4", "1,20,4,5.5,6,7", "2,40,4,5.5,6,7"
    )
    assert recording.press is None
    assert recording.time_s is not None
    assert recording.time_s.tolist() == [0, 0.02, 0.04]
    assert recording.pads["a"].frames[1].tolist() == [[4, 5.5]]
    assert recording.pads["b"].frames.dtype == np.int32


def test_a_column_may_say_which_press_a_row_belongs_to(tmp_path: Path) -> None:
    lines = ("press,label,p.0.0,p.0.1", "-1,,0,0", "0,a,1,2", "0,a,3,4", "2,b,5,6")
    recording = told(tmp_path / "a.csv", *lines)
    assert list(recording.presses.frames) == [range(1, 3), range(3, 4)]
    assert recording.presses.columns["label"].tolist() == ["a", "b"]
    with pytest.raises(FormatError, match="line 4, column 'label': is c, where press 0 has a; a press has one"):
        told(tmp_path / "a.csv", *lines[:3], "0,c,3,4")
    for wrong, got in (("0.5", "0.5"), ("2", "2"), ("-2", "-2"), ("p7", "p7")):
        words = f"line 3, column 'press' must be a whole number from 0 to 1, -1 for none; got '{got}'"
        with pytest.raises(FormatError, match=words):
            told(tmp_path / "a.csv", *lines[:2], f"{wrong},c,3,4")


def test_a_first_column_without_a_name_numbers_the_rows(tmp_path: Path) -> None:
    """As ``DataFrame.to_csv`` writes it; of a column elsewhere nobody knows what it is."""
    recording = told(tmp_path / "a.csv", f",{HEADER}", f"0,{ROW}", f"1,{ROW}")
    plain = told(tmp_path / "b.csv", HEADER, ROW, ROW)
    assert recording.press_columns.keys() == plain.press_columns.keys()
    for name, pad in plain.pads.items():
        np.testing.assert_array_equal(recording.pads[name].frames, pad.frames)
    assert told(tmp_path / "c.csv", ",p.0.0,p.0.1", "0,1,2", "1,3,4").press is None


@pytest.mark.parametrize(
    "header",
    [
        "time_s,p_0,p_1,p_2,p_3,p_4,p_5",
        "p_0,p_1,p_2,p_3,p_4,p_5",
        "0.0,0.1,0.2,1.0,1.1,1.2",
        "a,b,c,d,e,f",
    ],
)
def test_frames_of_one_pad_stay_plain_csv(tmp_path: Path, header: str) -> None:
    n = header.count(",") + 1
    recording = told(tmp_path / "a.csv", header, ",".join(map(str, range(n))), shape=(2, 3))
    assert list(recording.pads) == ["pad"]
    assert recording.press is None


@settings(deadline=None)
@given(
    st.integers(1, 3).flatmap(
        lambda n: st.dictionaries(
            st.sampled_from(["thumb", "finger_2", "θ", "a b"]),
            hnp.arrays(
                np.float64,
                st.tuples(st.just(n), st.integers(2, 4), st.integers(2, 4)),
                elements=st.floats(0, 1e6, width=32),
            ),
            min_size=1,
        )
    ),
    st.lists(st.text("abc,;\"' é", max_size=5), min_size=3, max_size=3),
    st.sampled_from(",;\t"),
)
def test_every_number_and_label_comes_back(
    tmp_path_factory: pytest.TempPathFactory, pads: dict[str, np.ndarray], labels: list[str], mark: str
) -> None:
    path = tmp_path_factory.mktemp("rows") / "a.csv"
    labels = [f"x{label}x" for label in labels]
    n = len(next(iter(pads.values())))
    with path.open("w", newline="") as file:
        writer = csv.writer(file, delimiter=mark)
        names = [f"{pad}.{r}.{c}" for pad, frames in pads.items() for r, c in np.ndindex(*frames.shape[1:])]
        writer.writerow(["label", *names])
        for k in range(n):
            writer.writerow([labels[k], *(v for frames in pads.values() for v in frames[k].ravel().tolist())])
    recording = read(path)
    assert list(recording.pads) == list(pads)
    for pad, frames in pads.items():
        assert np.array_equal(recording.pads[pad].frames, frames)
    assert recording.presses.columns["label"].tolist() == labels[:n]


ROW = "cone,1,2,3,4,5,0.5,0.25,1,1"


@pytest.mark.parametrize(
    ("lines", "shape", "message"),
    [
        ([HEADER.replace("palm.1.0", "palm.1.1"), ROW], None, "that of taxel 0.1 is missing"),
        (["l,p.0.0,p.0.1,p.1.1,p.2.0,p.2.1", "a,1,2,3,4,5"], None, "columns p.0.0 to p.2.1 are the pad p, but that of taxel 1.0 is missing"),
        (["l,p_0,p_1,p_2,p_3,p_5", "a,1,2,3,4,5"], (2, 3), "columns p_0 to p_5 are the pad p, but that of taxel 4 is missing"),
        (["l,p_0,p_1,p_2,p_3,p_4", "a,1,2,3,4,5"], (2, 3), r"no 6 columns are a pad of 2 x 3; there are p_0 to p_4 \(5\)"),
        (["l,p_0,p_1", "a,1,2"], None, "line 1: no columns are taxels; call them NAME.ROW.COLUMN"),
        (["l,p_0,p_1", "a,1,2"], (2, 3), "line 1: no columns are taxels; call them NAME.ROW.COLUMN"),
        ([HEADER, ROW], (2, 3), "has frames of 1 x 2, not 2 x 3; leave the shape out"),
        ([HEADER, ROW.replace("2,3", "x,3")], None, "line 2, column 'thumb.0.1' must be a number, got 'x'"),
        ([HEADER, ROW, ROW.replace("2,3", ",3")], None, "line 3, column 'thumb.0.1' must be a number, got nothing"),
        ([HEADER, ROW, ROW.replace("2,3", "inf,3")], None, "line 3, column 'thumb.0.1' must be finite, got 'inf'"),
        ([HEADER, ROW, ROW[:-2]], None, "line 3 must have 10 cells like line 1, got 9"),
        ([HEADER, ROW.replace(",1,1", ",7,1")], None, "line 2, column 'switch.a' must be 0 or 1, got '7'"),
        ([HEADER.replace("session", "label"), ROW], None, "line 1: column 'label' stands there twice"),
        ([HEADER.replace("session", ""), ROW], None, "line 1: column 10 has no name"),
        ([HEADER], None, "has a line of column names but no rows"),
        ([HEADER, ROW, "", ROW], None, "line 3 is blank, and rows follow; remove it"),
    ],
)  # fmt: skip
def test_bad_tables_are_told_in_one_line(
    tmp_path: Path, lines: list[str], shape: tuple[int, int] | None, message: str
) -> None:
    with pytest.raises(FormatError, match=message) as error:
        told(tmp_path / "a.csv", *lines, shape=shape)
    assert str(error.value).startswith(f"{tmp_path / 'a.csv'}: ")
    assert "\n" not in str(error.value)


def test_such_a_table_is_learned_from(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    names = [f"p.{r}.{c}" for r, c in np.ndindex(6, 6)]
    forms = {"bar": np.abs(np.arange(6) - 2.5)[:, None] + np.zeros(6) < 1, "dot": np.hypot(*np.ogrid[-3:3, -3:3]) < 2}
    rows = [
        ",".join([name, *map(str, (rng.integers(0, 3, (6, 6)) + 50 * forms[name]).ravel())])
        for name in ["bar", "dot"] * 8
    ]
    recording = told(tmp_path / "a.csv", ",".join(["label", *names]), *rows)
    known = labelled_presses([recording], label="label")
    model = TactileClassifier(folds=2).fit(known.presses, known.labels)
    assert (model.predict(known.presses) == known.labels).mean() == 1


@pytest.mark.parametrize("ahead", ["", "sep=,\n"])
def test_names_of_another_encoding_stay_apart(tmp_path: Path, ahead: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(f"{ahead}p.0.0,p.0.1,größe\n1,2,Bär\n3,4,Bör\n".encode("cp1252"))
    found = read(path)
    assert found.press_columns["größe"].tolist() == ["Bär", "Bör"]
    assert any("is no UTF-8 text (byte 0xf6): read as cp1252" in note for note in found.remarks)
    path.write_bytes(f"{ahead}t,größe 1,größe 2\n0,1,2\n1,3,4\n".encode("cp1252"))
    assert any("read as cp1252" in note for note in read(path, shape=(1, 2)).notes)


def test_a_wrong_option_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"{HEADER}\n{ROW}\n")
    with pytest.raises(InputError, match="pitch_m must be"):
        read(tmp_path / "a.csv", pitch_m=-1)


@settings(max_examples=60)
@given(
    rows=st.lists(
        st.tuples(st.integers(-1, 2), st.sampled_from(["", "1.5", "2.5"]), st.sampled_from(["a", "b"])),
        min_size=3,
        max_size=9,
    )
)
def test_a_press_is_known_as_in_its_first_row_and_the_first_row_that_says_another_is_told(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[int, str, str]]
) -> None:
    """By a plain loop. A number that is missing twice is the same; missing once it is another."""
    # A press stands in one piece.
    rows = sorted(rows, key=lambda row: row[0])
    assume(rows[-1][0] >= 0)
    path = tmp_path_factory.mktemp("rows") / "a.csv"
    lines = [f"{press},{load},{label},{k},{k + 1}" for k, (press, load, label) in enumerate(rows)]
    known: dict[int, tuple[str, str]] = {}
    wrong: dict[str, int] = {}
    for line, (press, *said) in enumerate(rows, start=2):
        if press >= 0:
            first = known.setdefault(press, (said[0], said[1]))
            for name, own, other in zip(("force_n.z", "label"), said, first, strict=True):
                if own != other:
                    wrong.setdefault(name, line)
    if wrong:
        name = next(name for name in ("force_n.z", "label") if name in wrong)
        with pytest.raises(FormatError, match=rf"line {wrong[name]}, column '{name}': is .*; a press has one"):
            told(path, "press,force_n.z,label,p.0.0,p.0.1", *lines)
        return
    columns = told(path, "press,force_n.z,label,p.0.0,p.0.1", *lines).press_columns
    for press, (load, label) in known.items():
        assert str(columns["label"][press]) == label
        number = float(columns["force_n.z"][press])
        assert np.isnan(number) if load == "" else number == float(load)
