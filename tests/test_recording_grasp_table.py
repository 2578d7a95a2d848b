"""Grasp tables: what is written comes back, chunks make the whole, and a bad cell is named."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold import FormatError, InputError
from varishold.files import encoding_notes
from varishold.recording import GraspTable, iter_grasp_table, read_grasp_table, write_grasp_table

TEXT = """object,size_m,seed,step,held,switch.v1,switch.v2,angle_rad.j1,force_n.tip
cylinder,0.03,1,0,1,1,0,0.25,1.5
"square, pillar",,2,0,0,0,1,-0.5,
"""

words = st.text(st.characters(codec="utf-8", exclude_characters="\0\r\n"), min_size=1, max_size=8).map(str.strip)
numbers = st.floats(allow_infinity=False, allow_nan=True)


@st.composite
def tables(draw: st.DrawFn) -> GraspTable:
    n = draw(st.integers(1, 12))
    several = lambda each: draw(st.lists(each, min_size=n, max_size=n))  # noqa: E731
    return GraspTable(
        {
            "object": np.array(several(words), dtype=np.str_),
            "size_m": np.array(several(numbers), dtype=np.float64),
            "switch.a": np.array(several(st.booleans()), dtype=np.bool_),
            "switch.b": np.array(several(st.booleans()), dtype=np.bool_),
            "angle_rad.j": np.array(several(numbers), dtype=np.float64),
        }
    )


def same(a: GraspTable, b: GraspTable) -> bool:
    return a.columns == b.columns and all(
        a.cells[name].dtype.kind == b.cells[name].dtype.kind
        and np.array_equal(a.cells[name], b.cells[name], equal_nan=a.cells[name].dtype.kind == "f")
        for name in a.columns
    )


@given(tables(), st.integers(1, 200))
def test_writing_loses_nothing_and_chunks_make_the_whole(
    tmp_path_factory: pytest.TempPathFactory, table: GraspTable, block: int
) -> None:
    path = tmp_path_factory.mktemp("t") / "t.csv"
    write_grasp_table(table, path)
    assert same(read_grasp_table(path), table)
    chunks = list(iter_grasp_table(path, block=block))
    assert sum(map(len, chunks)) == len(table)
    for name in table.columns:
        assert np.array_equal(
            np.concatenate([c.cells[name] for c in chunks]),
            table.cells[name],
            equal_nan=table.cells[name].dtype.kind == "f",
        )


def test_columns_are_read_by_what_their_names_promise(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(TEXT)
    table = read_grasp_table(path)
    assert len(table) == 2
    assert table.labels("object").tolist() == ["cylinder", "square, pillar"]
    assert table.matrix("switch.*").tolist() == [[True, False], [False, True]]
    assert table.cells["held"].tolist() == [True, False]
    assert table.matrix(["switch.*", "angle_rad.*"]).tolist() == [[1, 0, 0.25], [0, 1, -0.5]]
    assert np.isnan(table.cells["size_m"][1])
    assert np.isnan(table.cells["force_n.tip"][1])


def test_only_chosen_columns_are_read(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(TEXT.replace("0.25", "broken"))
    assert read_grasp_table(path, columns="switch.*", label="seed").columns == (
        "seed",
        "switch.v1",
        "switch.v2",
    )
    assert read_grasp_table(path, columns="switch.*", label="seed").labels("seed").tolist() == ["1", "2"]


def test_any_table_of_numbers_with_a_label_will_do(tmp_path: Path) -> None:
    path = tmp_path / "iris.csv"
    path.write_bytes("\ufeffwidth;kind;id\r\n1.5;a;1\r\n2;b;2\r\n\r\n".encode())
    table = read_grasp_table(path)
    assert {name: column.dtype.kind for name, column in table.cells.items()} == {
        "width": "f",
        "kind": "U",
        "id": "f",
    }
    assert read_grasp_table(path, label="id").labels("id").tolist() == ["1", "2"]
    assert table.labels("id").tolist() == ["1", "2"]


@pytest.mark.parametrize("ahead", ["\n \n", "sep=;\n", '"sep=;"\r\n', "\nsep=;\n\n", "# a; b\n", "sep=;\n#\n"])
def test_a_header_may_stand_behind_blank_lines_and_the_word_of_a_separator(tmp_path: Path, ahead: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(f"{ahead}object;a\nx;1\ny;0\n")
    for block in (1, 1 << 22):
        table = GraspTable.joined(list(iter_grasp_table(path, block=block)))
        assert table.columns == ("object", "a")
        assert table.where(1) == f"{path}: line {ahead.count(chr(10)) + 3}", ahead


def test_what_is_no_utf8_is_read_as_cp1252_and_told(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    text = "object,größe\nBär,1\nBör,2\n€,3\n"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252"):
        path.write_bytes(text.encode(encoding))
        for block in (1, 1 << 22):
            table = GraspTable.joined(list(iter_grasp_table(path, block=block)))
            assert table.columns == ("object", "größe")
            assert table.labels("object").tolist() == ["Bär", "Bör", "€"]
        notes = encoding_notes(path)
        assert (encoding == "cp1252") == any("line 1 is no UTF-8 text (byte 0xf6): read as cp1252" in n for n in notes)
    for content, message in (
        (b"object,a\nx,1\n\x81,2\n", "line 3 is no UTF-8 and no cp1252 text: byte 0x81; save it as UTF-8"),
        ("object,a\nx,1\n".encode("utf-16")[:-1], "is no UTF-16 text"),
        ("object,a\nx,1\n".encode("utf-32")[:-1], "is no UTF-32 text"),
    ):
        path.write_bytes(content)
        with pytest.raises(FormatError, match=message):
            read_grasp_table(path)


def test_truth_may_be_told_in_words(tmp_path: Path) -> None:
    path = tmp_path / "bools.csv"
    path.write_text("kind,a,b,said\nx,True,false,true\ny,False,,perhaps\n")
    table = read_grasp_table(path)
    assert {name: column.dtype.kind for name, column in table.cells.items()} == {
        "kind": "U",
        "a": "b",
        "b": "f",
        "said": "U",
    }
    assert table.numbers("a").tolist() == [True, False]
    path.write_text("kind,a\nx,1\nkind,a\ny,0\n")
    with pytest.raises(InputError, match="line 3, column 'a' must be a number, got 'a'"):
        read_grasp_table(path).numbers("a")


def test_a_long_table_is_read_in_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    row = "cube,0.03,1,0,1,1,0,0.25,1.5\n"
    with path.open("w") as file:
        file.write(TEXT.splitlines()[0] + "\n")
        for _ in range(30):
            file.write(row * 10_000)
    tracemalloc.start()
    n = sum(len(chunk) for chunk in iter_grasp_table(path, block=1 << 18))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert n == 300_000
    assert peak < 16e6


def test_a_first_column_without_a_name_is_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(",object,switch.a\n0,x,1\n1,y,0\n")
    (table,) = iter_grasp_table(path)
    assert table.columns == ("object", "switch.a")
    assert table.cells["switch.a"].tolist() == [True, False]
    (table,) = iter_grasp_table(path, columns="*")
    assert table.columns == ("object", "switch.a")
    with pytest.raises(InputError, match="there is no column ''"):
        next(iter_grasp_table(path, label=""))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "t.csv: is empty; a grasp table starts with a line of column names"),
        ("\n\n", "is empty"),
        ("object,switch.a\n", "has a line of column names but no rows"),
        ("object,,b\n1,2,3\n", "line 1: column 2 has no name"),
        ("a,b,a\n1,2,3\n", "line 1: column 'a' stands there twice"),
        ("object,switch.a\nx,1\ny,2\n", "line 3, column 'switch.a' must be 0 or 1, got '2'"),
        ("object,switch.a\nx,1\ny,nan\n", "line 3, column 'switch.a' must be 0 or 1, got 'nan'"),
        ("object,held\nx,1\ny,\n", "line 3, column 'held' must be 0 or 1, got ''"),
        ("object,size_m\nx,1\ny,big\n", "line 3, column 'size_m' must be a number, got 'big'"),
        ("object,size_m\nx,1\ny,1_0\n", "line 3, column 'size_m' must be a number, got '1_0'"),
        ("object,size_m\nx,inf\n", "line 2, column 'size_m' must be finite, got 'inf'"),
        ("object,size_m\nx,1\ny\n", "line 3 must have 2 cells like line 1, got 1"),
        ("object,size_m\nx,1,2\n", "line 2 must have 2 cells like line 1, got 3"),
        ("object,size_m\nx,1\n\ny,2\n", "line 3 is blank, and rows follow"),
        ('object,size_m\n"x,1\n', "line 2: unexpected end of data; a cell must close its quotes"),
        ("object\0,a\n1,2\n", "is no text: a NUL byte"),
        ("0,1,0\n1,0,1\n", "line 1 holds numbers; a grasp table starts with a line of column names"),
        ("\n\n0,1\n1,0\n", "line 3 holds numbers"),
        ("sep=;\nobject;a\nx;1;2\n", "line 3 must have 2 cells like line 2, got 3"),
        (
            'object,a\n"b\nc",1\n',
            "line 2: unexpected end of data; a cell must close its quotes, and hold no line break",
        ),
    ],
)
def test_what_is_no_grasp_table(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text)
    for block in (1, 7, 1 << 22):
        with pytest.raises(FormatError, match=message):
            list(iter_grasp_table(path, block=block))


def test_an_empty_switch_is_unknown(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("object,switch.a,switch.b\nx,1,true\ny,,0\n")
    for block in (1, 1 << 22):
        table = GraspTable.joined(list(iter_grasp_table(path, block=block)))
        np.testing.assert_array_equal(table.numbers("switch.a", unknown=True), [1.0, np.nan])
        assert table.numbers("switch.b").tolist() == [True, False]
        with pytest.raises(InputError, match=r"t\.csv: line 3, column 'switch.a' is empty; fill it or leave"):
            table.numbers("switch.a")
    write_grasp_table(table, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == "object,switch.a,switch.b\nx,1,1\ny,,0\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"label": "name"}, "no column 'name'; its columns are object, size_m"),
        ({"columns": "switches.*"}, "no column matches 'switches.\\*'; its columns are object"),
    ],
)
def test_columns_that_are_not_there(tmp_path: Path, arguments: dict[str, str], message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(TEXT)
    with pytest.raises(InputError, match=message):
        read_grasp_table(path, **arguments)


def test_what_a_table_cannot_give(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(TEXT + ",0.1,3,0,1,1,1,0,0\n")
    table = read_grasp_table(path)
    with pytest.raises(InputError, match=r"line 3, column 'force_n.tip' is empty"):
        table.matrix("force_n.*")
    with pytest.raises(InputError, match="line 2, column 'object' must be a number, got 'cylinder'"):
        table.matrix("*")
    with pytest.raises(InputError, match="line 4, column 'object' is empty; every row needs a label"):
        table.labels("object")
    with pytest.raises(InputError, match="no column 'shape'"):
        table.labels("shape")
    with pytest.raises(InputError, match="of one length"):
        GraspTable({"a": np.zeros(2), "b": np.zeros(3)})
    with pytest.raises(InputError, match="numbers must be finite, got inf in 'size_m'"):
        write_grasp_table(GraspTable({"size_m": np.array([np.inf])}), tmp_path / "w.csv")
    with pytest.raises(InputError, match="cannot hold a line break"):
        write_grasp_table(GraspTable({"object": np.array(["a\nb"])}), tmp_path / "w.csv")


@given(st.binary(max_size=400) | st.text(alphabet='ab01,;\t"\n\r .-e', max_size=80).map(str.encode))
def test_any_bytes_are_a_table_or_an_error_in_one_line(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.mktemp("t") / "t.csv"
    path.write_bytes(data)
    try:
        table = read_grasp_table(path)
    except InputError as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert len(table) > 0


def test_tables_are_joined_and_a_row_knows_its_file(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("object,switch.a,turn\ncone,1,2\ncube,0,3\n")
    (tmp_path / "b.csv").write_text("switch.a,object,turn\n1,cone,\n")
    table = GraspTable.joined([read_grasp_table(tmp_path / name) for name in ("a.csv", "b.csv")])
    assert table.labels("object").tolist() == ["cone", "cube", "cone"]
    assert table.matrix("switch.*").tolist() == [[True], [False], [True]]
    assert [table.where(row) for row in range(3)] == [
        f"{tmp_path}/{at}" for at in ("a.csv: line 2", "a.csv: line 3", "b.csv: line 2")
    ]
    with pytest.raises(InputError, match=r"b\.csv: line 2, column 'turn' is empty"):
        table.numbers("turn")


@pytest.mark.parametrize(
    ("second", "told"),
    [
        ("object,switch.a\ncone,1\n", r"b\.csv: there is no column 'turn', which .*a\.csv has"),
        ("object,switch.a,turn,more\ncone,1,1,1\n", r"a\.csv: there is no column 'more', which .*b\.csv has"),
        ("object,switch.a,turn\ncone,1,left\n", r"b\.csv: column 'turn' is text, and numbers in .*a\.csv"),
    ],
)
def test_tables_that_do_not_fit_are_not_joined(tmp_path: Path, second: str, told: str) -> None:
    (tmp_path / "a.csv").write_text("object,switch.a,turn\ncone,1,2\n")
    (tmp_path / "b.csv").write_text(second)
    both = [read_grasp_table(tmp_path / name) for name in ("a.csv", "b.csv")]
    for tables in (both, both[::-1]):
        with pytest.raises(InputError, match=told) as refused:
            GraspTable.joined(tables)
        # What one lacks may be left out of what is read.
        assert refused.value.parameter == ("columns" if "there is no" in told else None)
