"""The summary of a table against plain counting: its limits' edges, the most doubtful, sizes by step, days."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.corpus import summary
from varishold.corpus.run import Outcome
from varishold.corpus.summary import FileHealth, Sizes, Summary, summarize_names

Row = dict[str, Any]


def row_of(file: str, frame: int, pad: str, name: str, probability: float, **how: Any) -> Row:
    plain: Row = {"file": file, "frame": frame, "pad": pad, "name": name, "probability": probability}
    sizes = {"size_long_m": 0.02, "size_short_m": 0.01, "size_long_taxels": 10.0, "size_short_taxels": 5.0}
    return {**plain, "time_s": frame / 10, "contact": 0, "answer_set": [name, "plane"], **sizes, **how}


def told(folder: Path, rows: list[Row], at_a_time: int, health: dict[str, Any] | None = None) -> Summary:
    pq.write_table(pa.Table.from_pylist(rows), folder / "n.parquet")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(summary, "_ROWS", at_a_time)
        return summarize_names(folder / "n.parquet", Outcome(len(rows), 1, health or {}, {}, None))


@st.composite
def drawn(draw: st.DrawFn) -> list[Row]:
    """Draw rows in the order of a table, with probabilities that are often the same."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    rows = []
    for file in ("b.npz", "a.npz"):
        frames = np.sort(rng.integers(0, 900, draw(st.integers(1, 120))))
        for frame in frames.tolist():
            p = float(rng.choice([0.3, 0.5, 0.89, 0.9, 0.95, rng.uniform(0.1, 1.0)]))
            pad, name = str(rng.choice(["p", "q"])), str(rng.choice(["ridge", "cone", "plane"]))
            rows.append(row_of(file, frame, pad, name, p, contact=len(rows)))
    return rows


@settings(max_examples=40)
@given(drawn(), st.sampled_from([1, 7, 50, 1 << 16]))
def test_the_most_doubtful_are_those_of_a_plain_search(
    tmp_path_factory: pytest.TempPathFactory, rows: list[Row], at_a_time: int
) -> None:
    kept: list[Row] = []
    for begin in range(0, len(rows), at_a_time):
        here = rows[begin : begin + at_a_time]
        orders = {key: list(dict.fromkeys(row[key] for row in here)) for key in ("file", "pad")}
        best: dict[tuple[int, int, int], Row] = {}
        for row in here:
            place = orders["file"].index(row["file"]), orders["pad"].index(row["pad"]), row["frame"] // 64
            if row["probability"] < 0.9 and (place not in best or row["probability"] < best[place]["probability"]):
                best[place] = row
        found = [best[place] for place in sorted(best)]
        kept = sorted([*kept, *sorted(found, key=lambda row: row["probability"])], key=lambda row: row["probability"])
        kept = kept[:48]
    got = told(tmp_path_factory.mktemp("s"), rows, at_a_time)
    assert [one.contact for one in got.doubtful] == [row["contact"] for row in kept]
    for one, row in zip(got.doubtful, kept, strict=True):
        for key in ("file", "frame", "pad", "name", "probability", "time_s"):
            assert getattr(one, key) == row[key]
        assert (one.answer_set, one.size, one.metres) == ((row["name"], "plane"), (0.02, 0.01), True)


@settings(max_examples=40)
@given(drawn(), st.sampled_from([1, 7, 1 << 16]))
def test_names_are_counted_and_ordered_plainly(
    tmp_path_factory: pytest.TempPathFactory, rows: list[Row], at_a_time: int
) -> None:
    got = told(tmp_path_factory.mktemp("s"), rows, at_a_time)
    by_name: dict[str, list[Row]] = {}
    for row in rows:
        by_name.setdefault(row["name"], []).append(row)
    # The most frequent first, those as frequent by their names.
    assert [one.name for one in got.names] == sorted(by_name, key=lambda name: (-len(by_name[name]), name))
    for one in got.names:
        mine = by_name[one.name]
        assert one.n == len(mine)
        assert one.n_sure == sum(row["probability"] >= 0.9 for row in mine)
        assert one.n_files == len({row["file"] for row in mine})
        assert (one.metres.n, one.taxels.n) == (len(mine), 0)


def test_what_is_as_probable_as_the_limit_is_sure(tmp_path: Path) -> None:
    below = float(np.nextafter(0.9, 0))
    rows = [row_of("a", 0, "p", "cone", 0.9), row_of("a", 200, "p", "cone", below), row_of("a", 400, "p", "cone", 1.0)]
    health = {"n_frames": 5, "begin_s": None, "duration_s": None, "n_lacking": 0, "n_taxels": 1, "n_broken": 0}
    got = told(tmp_path, rows, 9, {"a": {**health, "faults": [], "notes": []}})
    assert (got.names[0].n_sure, got.files[0].n_doubtful, got.files[0].n_contacts) == (2, 1, 3)
    assert [one.probability for one in got.doubtful] == [below]


@pytest.mark.parametrize(("frames", "shown"), [((0, 63), 1), ((63, 64), 2), ((64, 127), 1), ((0, 128), 2)])
def test_of_neighbouring_frames_one_is_shown(tmp_path: Path, frames: tuple[int, int], shown: int) -> None:
    rows = [row_of("a", frame, "p", "cone", 0.5) for frame in frames]
    assert len(told(tmp_path, rows, 9).doubtful) == shown
    # Pads and recordings are no neighbours.
    apart = [row_of("a", 3, "p", "cone", 0.5), row_of("a", 3, "q", "cone", 0.5), row_of("b", 3, "p", "cone", 0.5)]
    assert len(told(tmp_path, apart, 9).doubtful) == 3


@given(
    st.lists(st.one_of(st.none(), st.floats(1e-6, 20.0)), min_size=1, max_size=40),
    st.sampled_from([1, 5, 1 << 16]),
)
@settings(max_examples=40)
def test_sizes_are_in_metres_where_these_are_known_and_each_in_its_step(
    tmp_path_factory: pytest.TempPathFactory, sizes: list[float | None], at_a_time: int
) -> None:
    rows = [
        row_of("a", 0, "p", "cone", 1.0, size_long_m=size, size_short_m=size, size_long_taxels=1.0 + k)
        for k, size in enumerate(sizes)
    ]
    rows.append(row_of("a", 0, "p", "plane", 1.0))
    found = {one.name: one for one in told(tmp_path_factory.mktemp("s"), rows, at_a_time).names}
    cone = found["cone"]
    assert (cone.metres.least, cone.taxels.least) == (1e-5, 0.1)
    metres, taxels = np.zeros(120, int), np.zeros(120, int)
    for k, size in enumerate(sizes):
        # Twenty steps a decade, six decades, and what lies beyond counts at the ends.
        value, least, counts = (1.0 + k, 0.1, taxels) if size is None else (size, 1e-5, metres)
        counts[min(max(math.floor(20 * math.log10(value / least)), 0), 119)] += 1
    assert cone.metres.counts.tolist() == metres.tolist()
    assert cone.taxels.counts.tolist() == taxels.tolist()


def test_a_size_of_taxels_is_shown_where_no_other_is_known(tmp_path: Path) -> None:
    rows = [row_of("a", 0, "p", "cone", 0.5, size_long_m=None, size_short_m=None), row_of("a", 99, "p", "cone", 0.6)]
    got = told(tmp_path, rows, 9)
    assert [(one.size, one.metres) for one in got.doubtful] == [((10.0, 5.0), False), ((0.02, 0.01), True)]


@pytest.mark.parametrize(
    ("counts", "share", "step"),
    [([1, 0, 0, 1], 0.5, 0), ([1, 0, 0, 1], 0.51, 3), ([1, 0, 0, 1], 1.0, 3), ([0, 4, 0, 0], 0.0, 0), ([2, 2], 0.5, 0)],
)
def test_a_quantile_is_the_middle_of_its_step(counts: list[int], share: float, step: int) -> None:
    sizes = Sizes(1e-3, np.array(counts))
    assert sizes.n == sum(counts)
    assert math.isclose(sizes.quantile(share), 1e-3 * 10 ** ((step + 0.5) / 20))
    # A share that is a little beyond all, by rounding, is that of the last.
    assert math.isclose(sizes.quantile(1.01), 1e-3 * 10 ** ((len(counts) - 0.5) / 20))


@pytest.mark.parametrize(
    ("begin_s", "day"),
    [
        (None, ""), (0.0, ""), (946684799.9, ""), (946684800.0, "2000-01-01"), (1795305600.0, "2026-11-22"),
        (1795305599.0, "2026-11-21"), (4102444800.0, "2100-01-01"), (4102444801.0, ""), (math.inf, ""),
    ],
)  # fmt: skip
def test_a_day_is_of_the_calendar_where_the_clock_is(begin_s: float | None, day: str) -> None:
    assert summary._day(begin_s) == day


def test_a_recording_s_health_is_told_beside_its_contacts(tmp_path: Path) -> None:
    rows = [row_of("a", 0, "p", "cone", 0.5), row_of("a", 1, "p", "cone", 0.95)]
    health = {"n_frames": 7, "begin_s": 1e9, "duration_s": 2.5, "n_lacking": 4, "n_taxels": 60, "n_broken": 3}
    path = tmp_path / "n.parquet"
    pq.write_table(pa.Table.from_pylist(rows), path)
    known = {name: {**health, "faults": ["odd"], "notes": ["read"]} for name in ("a", "b")}
    found = summarize_names(path, Outcome(2, 14, known, {"c": "c: is bad"}, None))
    says, day = ("odd", "read"), "2001-09-09"
    assert found.files == (
        FileHealth("a", day, 7, 2, 1, 60, 3, 4, 2.5, says),
        FileHealth("b", day, 7, 0, 0, 60, 3, 4, 2.5, says),
        FileHealth("c", "", 0, 0, 0, 0, 0, 0, None, (), "c: is bad"),
    )
    assert found.n_contacts == 2
