"""Parts and the table of them, read back by plain means: types, encodings, row groups, names, and what is not there."""

from __future__ import annotations

import dataclasses
import json
import os
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.corpus import AskMeasure, AskTouch, joining
from varishold.corpus.columns import FILE, Column, Kind, schema_of
from varishold.corpus.joining import TOLD, Joining, join_parts
from varishold.corpus.part import need_parquet, read_part, write_part
from varishold.corpus.touch_columns import SAID
from varishold.errors import FormatError, InputError, MissingExtraError
from varishold.levelset import measure
from varishold.recording import Pad, Recording

COLUMNS = (
    Column("n", "whole", "a"),
    Column("x", "number", "b"),
    Column("is", "truth", "f"),
    Column("word", "text", "c"),
    Column("words", "texts", "d"),
    Column("all", "shares", "e"),
)
SHARES = [{"name": "cone", "probability": 0.5}]


def rows_of(n: int, begin: int = 0) -> dict[str, Any]:
    numbers = range(begin, begin + n)
    return {
        "x": np.array([np.nan if k % 3 == 0 else k / 7 for k in numbers]),
        "n": [None if k % 5 == 0 else k for k in numbers],
        "is": [(None, True, False)[k % 3] for k in numbers],
        "word": [None if k % 4 == 0 else f"w{k % 2}" for k in numbers],
        "words": [["a"] * (k % 3) for k in numbers],
        "all": [SHARES if k % 2 else [] for k in numbers],
    }


def told(rows: dict[str, Any]) -> dict[str, list[Any]]:
    """Return rows as a table tells them: nothing, not a NaN."""
    plain = {name: list(rows[name]) for name in ("n", "x", "is", "word", "words", "all")}
    plain["x"] = [None if np.isnan(value) else float(value) for value in plain["x"]]
    return plain


def parts(folder: Path, sizes: Sequence[int]) -> list[Path]:
    paths, begin = [], 0
    for k, size in enumerate(sizes):
        paths.append(folder / f"part{k}.parquet")
        write_part(paths[-1], rows_of(size, begin), COLUMNS)
        begin += size
    return paths


def test_a_part_comes_back_as_it_was_in_the_order_of_its_columns(tmp_path: Path) -> None:
    rows = rows_of(30)
    write_part(tmp_path / "a.parquet", rows, COLUMNS)
    back = read_part(tmp_path / "a.parquet", COLUMNS)
    assert back.to_pydict() == told(rows)
    assert list(back.to_pydict()) == [column.name for column in COLUMNS]
    assert back.schema.equals(schema_of(COLUMNS))


def test_columns_are_of_the_types_that_they_name() -> None:
    assert [column.kind for column in COLUMNS] == ["whole", "number", "truth", "text", "texts", "shares"]
    assert {column.kind for column in COLUMNS} == set(get_args(Kind))
    types = {
        "string": "string",
        "int64": "int64",
        "double": "double",
        "boolean": "bool",
        "list of string": "list<element: string>",
        "list of (name string, probability double)": "list<element: struct<name: string, probability: double>>",
    }
    for column, field in zip(COLUMNS, schema_of(COLUMNS), strict=True):
        assert field.name == column.name
        assert str(field.type) == types[column.said_as]


def test_what_stands_again_and_again_is_written_once_and_all_pages_are_checked(tmp_path: Path) -> None:
    (path,) = parts(tmp_path, [600])
    join_parts(tmp_path / "t.parquet", [("a.npz", path)], COLUMNS, title="touch")
    for file, more in ((path, []), (tmp_path / "t.parquet", ["file"])):
        group = pq.ParquetFile(file).metadata.row_group(0)
        held = {group.column(k).path_in_schema: group.column(k) for k in range(group.num_columns)}
        assert {column.compression for column in held.values()} == {"ZSTD"}
        repeated = {name for name, column in held.items() if "RLE_DICTIONARY" in column.encodings}
        assert repeated == {*more, "n", "word", "words.list.element", "all.list.element.name"}
        # The types are those of Parquet; nothing of pyarrow's own stands beside.
        assert b"ARROW:schema" not in (pq.ParquetFile(file).metadata.metadata or {})


def test_damage_within_a_page_shows(tmp_path: Path) -> None:
    (path,) = parts(tmp_path, [400])
    whole = path.read_bytes()
    end = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    found = 0
    for at in range(4, end, 97):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
        try:
            back = read_part(path, COLUMNS)
        except FormatError as error:
            found += str(error).startswith(f"{path}: ")
        else:
            assert back.to_pydict() == told(rows_of(400))
    assert found > 3


def test_a_part_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.parquet"):
        read_part(tmp_path / "none.parquet", COLUMNS)
    (path,) = parts(tmp_path, [3])
    with pytest.raises(FormatError, match=r"part0\.parquet"):
        read_part(path, COLUMNS[:2])
    with pytest.raises(InputError):
        write_part(tmp_path / "no" / "a.parquet", rows_of(1), COLUMNS)


def test_without_parquet_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    assert need_parquet() is None
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    with pytest.raises(MissingExtraError, match="files"):
        need_parquet()


@settings(max_examples=25)
@given(st.lists(st.integers(0, 9), max_size=7), st.integers(1, 12))
def test_a_table_is_its_parts_in_order_in_even_row_groups(
    tmp_path_factory: pytest.TempPathFactory, sizes: list[int], most: int
) -> None:
    folder = tmp_path_factory.mktemp("t")
    paths = parts(folder, sizes)
    total = sum(sizes)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(joining, "_ROWS", most)
        named = [(f"r{k // 2}.npz", path) for k, path in enumerate(paths)]
        assert join_parts(folder / "t.parquet", named, COLUMNS, title="measure") == total
    table = pq.ParquetFile(folder / "t.parquet")
    groups = [table.metadata.row_group(k).num_rows for k in range(table.metadata.num_row_groups)]
    assert groups == [most] * (total // most) + [total % most] * (total % most > 0)
    assert json.loads(table.metadata.metadata[TOLD.encode()]) == {"command": "measure"}
    got = table.read().to_pydict()
    assert got.pop("file") == [f"r{k // 2}.npz" for k, size in enumerate(sizes) for _ in range(size)]
    assert got == told(rows_of(total))
    assert table.schema_arrow.names[0] == FILE.name


def test_a_name_that_is_no_text_stands_as_its_codes(tmp_path: Path) -> None:
    (path,) = parts(tmp_path, [1])
    join_parts(tmp_path / "t.parquet", [("\udcff µ.npz", path)], COLUMNS, title="touch")
    assert pq.read_table(tmp_path / "t.parquet")["file"].to_pylist() == ["\\udcff µ.npz"]


def test_a_damaged_part_goes_and_the_table_stays(tmp_path: Path) -> None:
    good, bad = parts(tmp_path, [3, 3])
    bad.write_bytes(bad.read_bytes()[:-9])
    (tmp_path / "t.parquet").write_bytes(b"before")
    with pytest.raises(FormatError, match=r"part1\.parquet: .*; it was removed: run again, and it is made anew"):
        join_parts(tmp_path / "t.parquet", [("a", good), ("b", bad)], COLUMNS, title="touch")
    assert (good.exists(), bad.exists(), (tmp_path / "t.parquet").read_bytes()) == (True, False, b"before")


def test_parts_that_come_by_and_by_make_the_same_table(tmp_path: Path) -> None:
    paths = parts(tmp_path, [4, 0, 7])
    join_parts(tmp_path / "a.parquet", [("r", path) for path in paths], COLUMNS, title="touch")
    threads = threading.active_count()
    with Joining(tmp_path / "b.parquet", COLUMNS, title="touch") as made:
        for path in paths:
            made.add("r", path)
        assert made.end() == 11
        assert (tmp_path / "b.parquet").read_bytes() == (tmp_path / "a.parquet").read_bytes()
    assert threading.active_count() == threads


@pytest.mark.parametrize("n", [0, 1, 3])
def test_a_joining_that_is_given_up_leaves_nothing(tmp_path: Path, n: int) -> None:
    paths = parts(tmp_path, [2, 2, 2])
    before = sorted(os.listdir(tmp_path))
    threads = threading.active_count()
    with Joining(tmp_path / "t.parquet", COLUMNS, title="touch") as made:
        for path in paths[:n]:
            made.add("r", path)
    assert sorted(os.listdir(tmp_path)) == before
    assert threading.active_count() == threads


def test_a_part_that_is_lost_is_told_at_the_end(tmp_path: Path) -> None:
    with Joining(tmp_path / "t.parquet", COLUMNS, title="touch") as made:
        made.add("r", tmp_path / "gone.parquet")
        with pytest.raises(InputError, match=r"gone\.parquet"):
            made.end()
    assert os.listdir(tmp_path) == []


# Columns


def test_every_measure_has_its_column_with_its_unit() -> None:
    y, x = np.mgrid[-6:7, -6:7]
    cone = np.maximum(5.0 - np.hypot(x, y), 0.0)
    found = measure(Recording({"p": Pad(cone[None], pitch_m=2e-3)}, np.zeros(1)))
    found |= measure(Recording({"p": Pad(cone[None])}, np.zeros(1)))
    names = [column.name for column in AskMeasure().columns]
    assert len(set(names)) == len(names)
    assert set(found) == set(names)
    kinds = {column.name: column.kind for column in AskMeasure().columns}
    for name, cells in found.items():
        kind = "text" if cells.dtype.kind in "UO" else "whole" if cells.dtype.kind in "iu" else "number"
        assert kinds[name] == kind, name
    for column in AskMeasure().columns:
        if column.name.endswith("_taxels") and kinds[column.name] == "number":
            assert column.meaning.endswith(", in taxels")
    assert AskMeasure().title == "measure"
    assert [AskMeasure().levels, AskMeasure().floor] == [32, None]


def test_a_cell_is_what_stands_at_its_place_of_the_answer() -> None:
    """Every number of an answer is told from every other: none stands in another's column."""
    told: dict[str, Any] = {}
    for said in SAID:
        if said.path:
            told.setdefault(said.key, [[f"{said.key} {i} {k}" for k in range(2)] for i in range(2)])
        elif said.column.kind == "shares":
            told[said.key] = {"cone": 0.25, "ridge": 0.125}
        else:
            told[said.key] = said.key
    for said in SAID:
        found = said.of(told)
        if said.path:
            expected = told[said.key]
            for place in said.path:
                expected = expected[place]
            assert found == expected
            ends = {"low": 0, "high": 1, "x": 0, "y": 1, "long": 0, "short": 1}
            words = [word for word in said.column.name.split("_") if word in ends]
            assert list(said.path) == [ends[word] for word in words]
        elif said.column.kind == "shares":
            assert found == [{"name": "cone", "probability": 0.25}, {"name": "ridge", "probability": 0.125}]
        else:
            assert found == said.key == said.column.name
        if said.path:
            assert said.of({**told, said.key: None}) is None
    assert AskTouch().columns == tuple(said.column for said in SAID)
    assert AskTouch().title == "touch"
    assert dataclasses.astuple(AskTouch()) == ("all", 32, None, False)
    assert pa.types.is_list(schema_of(AskTouch().columns).field("alternatives").type)
