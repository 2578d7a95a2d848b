"""A table of names in short: every count is that of the rows, however many are in memory at a time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.corpus import summary
from varishold.corpus.run import Outcome
from varishold.corpus.summary import FileHealth, Sizes, Summary, summarize_names

FILES, NAMES = ("a.npz", "b.npz"), ("cone", "ridge", "unknown")


def rows_of(seed: int, n: int) -> list[dict[str, Any]]:
    """Return drawn rows in the order of a table; those of b.npz have no pitch."""
    rng = np.random.default_rng(seed)
    rows = []
    for k in range(n):
        file, metres = FILES[k >= n // 2], k < n // 2
        long = float(10 ** rng.uniform(-3, -1))
        rows.append(
            {
                "file": file,
                "frame": 30 * k,
                "time_s": None if k % 3 else k / 10,
                "pad": "pad",
                "contact": k % 2,
                "name": NAMES[rng.integers(3)],
                "probability": float(rng.uniform(0.2, 1.0)),
                "answer_set": ["cone", "ridge"],
                "size_long_m": long if metres else None,
                "size_short_m": long / 2 if metres else None,
                "size_long_taxels": 500 * long,
                "size_short_taxels": 250 * long,
            }
        )
    return rows


def health(begin_s: float | None = None, **how: Any) -> dict[str, Any]:
    plain = {"n_frames": 100, "duration_s": 2.0, "n_lacking": 3, "n_taxels": 64, "n_broken": 1}
    return {**plain, "begin_s": begin_s, "faults": ["odd"], "notes": ["read"], **how}


def told(folder: Path, rows: list[dict[str, Any]], at_a_time: int = 1 << 16) -> Summary:
    pq.write_table(pa.Table.from_pylist(rows), folder / "names.parquet")
    known = {"a.npz": health(0.0), "b.npz": health(1.8e9), "empty.npz": health()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(summary, "_ROWS", at_a_time)
        return summarize_names(
            folder / "names.parquet", Outcome(len(rows), 300, known, {"bad.npz": "bad.npz: is bad"}, None)
        )


@given(st.integers(0, 100), st.integers(2, 60), st.integers(1, 70))
def test_counts_are_those_of_the_rows(
    tmp_path_factory: pytest.TempPathFactory, seed: int, n: int, at_a_time: int
) -> None:
    rows = rows_of(seed, n)
    found = told(tmp_path_factory.mktemp("s"), rows, at_a_time)
    assert {name.name: name.n for name in found.names} == Counter(row["name"] for row in rows)
    assert [name.n for name in found.names] == sorted((name.n for name in found.names), reverse=True)
    assert found.n_contacts == n
    for name in found.names:
        mine = [row for row in rows if row["name"] == name.name]
        assert name.n_sure == sum(row["probability"] >= 0.9 for row in mine)
        assert name.n_files == len({row["file"] for row in mine})
        assert name.metres.n == sum(row["size_long_m"] is not None for row in mine)
        assert name.taxels.n == name.n - name.metres.n
    by_file = {file.file: (file.n_contacts, file.n_doubtful) for file in found.files}
    for file in FILES:
        mine = [row for row in rows if row["file"] == file]
        assert by_file[file] == (len(mine), sum(row["probability"] < 0.9 for row in mine))
    assert by_file["empty.npz"] == by_file["bad.npz"] == (0, 0)


@given(st.integers(0, 100), st.integers(2, 300))
def test_the_most_doubtful_come_first_one_of_neighbours(
    tmp_path_factory: pytest.TempPathFactory, seed: int, n: int
) -> None:
    rows = rows_of(seed, n)
    places: dict[tuple[str, int], float] = {}
    for row in rows:
        place = row["file"], row["frame"] // 64
        places[place] = min(places.get(place, 1.0), row["probability"])
    expected = sorted(p for p in places.values() if p < 0.9)[:48]
    found = told(tmp_path_factory.mktemp("s"), rows)
    assert [one.probability for one in found.doubtful] == expected
    for one in found.doubtful:
        (row,) = [row for row in rows if row["probability"] == one.probability]
        assert (one.file, one.frame, one.contact, one.name) == (row["file"], row["frame"], row["contact"], row["name"])
        assert one.time_s == row["time_s"]
        assert one.metres == (row["size_long_m"] is not None)
        assert one.size[0] == row["size_long_m" if one.metres else "size_long_taxels"] == 2 * one.size[1]
    # Of rows that come some at a time, too, none is more doubtful than the last that is kept.
    parted = told(tmp_path_factory.mktemp("s"), rows, 50)
    assert [one.probability for one in parted.doubtful][:1] == expected[:1]
    assert [one.probability for one in parted.doubtful] == sorted(one.probability for one in parted.doubtful)


@given(st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=200), st.floats(0.01, 0.99))
def test_a_quantile_is_known_to_a_step(sizes: list[float], share: float) -> None:
    found = Sizes(1e-5, summary._steps(np.array(sizes), 1e-5)).quantile(share)
    assert any(abs(np.log10(found / size)) <= 0.5001 / 20 for size in sizes)
    below = np.mean(np.array(sizes) < found * 10**-0.026)
    above = np.mean(np.array(sizes) > found * 10**0.026)
    assert below <= share + 1e-9
    assert above <= 1 - share + 1e-9


def test_sizes_beyond_all_steps_are_counted_at_the_ends() -> None:
    counts = summary._steps(np.array([1e-9, 50.0, 0.0, -1.0]), 1e-5)
    assert (counts[0], counts[-1], counts.sum()) == (1, 1, 2)
    assert np.isnan(Sizes(1e-5, np.zeros(9, np.int64)).quantile(0.5))


def test_health_is_told_by_file_and_day(tmp_path: Path) -> None:
    files = told(tmp_path, rows_of(0, 4)).files
    assert [file.file for file in files] == ["a.npz", "b.npz", "empty.npz", "bad.npz"]
    assert [file.day for file in files] == ["", "2027-01-15", "", ""]
    assert files[1] == FileHealth("b.npz", "2027-01-15", 100, 2, files[1].n_doubtful, 64, 1, 3, 2.0, ("odd", "read"))
    assert [file.failure for file in files] == ["", "", "", "bad.npz: is bad"]
