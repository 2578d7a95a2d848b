"""The paper's data as its files hold them, tables as they are printed, and experiments that are made again."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Any

import numpy as np
import pytest
from scipy import stats
from tests.test_paper_laws import known_grasps

from varishold.errors import InputError
from varishold.hand import TABLE_5_OBJECTS
from varishold.hand.features import FEATURE_GROUPS, Features
from varishold.paper import (
    paper_table,
    printed_accuracies,
    printed_hyperplanes,
    printed_minimal_table,
    printed_reduced_table,
    printed_sign_table,
    scanned_signs,
    scanned_text,
    table5,
)
from varishold.paper.beside import PaperTable
from varishold.paper.experiments import TABLES
from varishold.paper.finger_length import finger_length_sweep
from varishold.paper.table5 import OBJECT_NAMES, PAPER_GRASPS, Table5, paper_percent
from varishold.paper.table5 import table_5 as made_table
from varishold.paper.trials import classify

__all__ = ["known_grasps"]

DATA = resources.files("varishold.paper") / "data"


def rows_of(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader((DATA / name).read_text("utf-8").splitlines()))


def test_data_are_those_of_the_files() -> None:
    for row, plane in zip(rows_of("table1_hyperplanes.csv"), printed_hyperplanes(), strict=True):
        assert (row["hyperplane"], float(row["b"])) == (plane.name, plane.b)
        assert [float(row[f"a{k}"]) for k in range(1, 23)] == list(plane.coefficients)
    for file, table, names in (
        ("table2_signs.csv", printed_sign_table(), ("I", "II", "III")),
        ("table3_reduced.csv", printed_reduced_table(), ("I", "III")),
    ):
        rows = rows_of(file)
        assert table.hyperplanes == names
        assert table.signs.tolist() == [[row[name] == "1" for name in names] for row in rows]
        assert table.labels == tuple(int(row["pattern"]) for row in rows)
        assert table.grasps == tuple(int(row["v"]) for row in rows)
    minimal = printed_minimal_table()
    words = {None: "*", 0: "0", 1: "1"}
    assert [[words[s] for s in cube] for cube in minimal.cubes] == [
        [row["I"], row["III"]] for row in rows_of("table4_minimal.csv")
    ]
    assert [(row["v"], row["pattern"]) for row in rows_of("table4_minimal.csv")] == [
        (str(v), str(label)) for v, label in zip(minimal.grasps, minimal.labels, strict=True)
    ]
    for row, column in zip(rows_of("table5_accuracy.csv"), printed_accuracies(), strict=True):
        assert (row["object"], row["shape"]) == (column.name, column.shape)
        assert float(row["size_mm"]) == pytest.approx(1000 * column.size_m)
        assert float(row["correct_percent"]) == column.correct_percent
    assert OBJECT_NAMES == tuple(f"{kind}{k}" for kind in "CS" for k in range(1, 6))
    for name, (solid, size_m) in zip(OBJECT_NAMES, TABLE_5_OBJECTS, strict=True):
        (column,) = (column for column in printed_accuracies() if column.name == name)
        assert column.size_m == pytest.approx(size_m)
        assert solid.startswith({"C": "cylinder", "S": "square"}[name[0]])


@pytest.mark.parametrize("number", TABLES)
def test_a_scan_is_printed_in_columns(number: int) -> None:
    cells = [line.split("\t") for line in (DATA / f"table{number}_scanned.txt").read_text("utf-8").splitlines()]
    lines = scanned_text(number).splitlines()
    assert len(lines) == len(cells)
    n = max(map(len, cells))
    widths = [max(len(row[k].replace(" ", "")) if k < len(row) else 0 for row in cells) for k in range(n)]
    ends = np.cumsum(widths) + np.arange(n)
    for row, line in zip(cells, lines, strict=True):
        assert line == line.rstrip()
        for cell, end, width in zip(row, ends, widths, strict=False):
            assert line[end - width : end].strip() == cell.replace(" ", "")
            if cell.strip():
                assert line[:end].endswith(cell.replace(" ", "")[-1])


def test_scanned_signs_are_the_lines_of_the_scan() -> None:
    lines = [line.split("\t") for line in (DATA / "table2_scanned.txt").read_text("utf-8").splitlines()]
    patterns, signs = scanned_signs()
    assert list(patterns) == [int(cell) for cell in lines[1][1:]]
    for k, line in enumerate(lines[2:]):
        assert signs[:, k].tolist() == [cell == "1" for cell in line[2:]]


def test_tables_are_one_to_five() -> None:
    for number in (0, 6, -1):
        with pytest.raises(InputError, match=f"the paper's tables are 1, 2, 3, 4, 5; got {number}"):
            paper_table(number)
    assert list(TABLES) == [1, 2, 3, 4, 5]


# Table 5


@pytest.mark.usefixtures("known_grasps")
def test_usual_experiments_are_made_of_two_repetitions(known_grasps: list[dict[str, Any]]) -> None:
    usual = made_table()
    assert usual.correct.shape == (len(FEATURE_GROUPS), 2, 10)
    assert usual.groups == tuple(FEATURE_GROUPS)
    (swept,) = finger_length_sweep((1.0,)).tables
    assert (swept.correct.shape[1], swept.seed, swept.mode) == (2, 0, "auto")


@pytest.mark.parametrize(("seed", "repetitions"), [(0, 1), (0, 3), (7, 2)])
def test_grasps_of_a_seed_are_those_that_they_always_were(seed: int, repetitions: int) -> None:
    """Published figures are made again: each grasp keeps its seed, and none of two experiments is one."""
    jobs, places = table5._jobs(3, repetitions, seed)
    assert len(jobs) == len(places) == repetitions * (10 * 3 + 2 * 10)
    trained = [TABLE_5_OBJECTS.index(of) for of in (("cylinder", 0.09), TABLE_5_OBJECTS[7])]
    at = 0
    for r in range(repetitions):
        for k in range(10):
            for training, n in [(False, n) for n in range(3)] + [(True, n) for n in range(10 if k in trained else 0)]:
                block = 20_000 * seed + 20 * r + 2 * k + training
                assert places[at] == (r, k, training)
                assert (jobs[at].name, jobs[at].size_m) == TABLE_5_OBJECTS[k]
                assert jobs[at].seed == 10**9 + 10**4 * block + n
                at += 1
    seeds = {job.seed for job in jobs}
    assert len(seeds) == len(jobs)
    assert not seeds & {job.seed for job in table5._jobs(3, repetitions, seed + 1)[0]}


def table_of(correct: np.ndarray, grasps: int) -> Table5:
    held = np.full(correct.shape[1:], grasps)
    return Table5(("contact", "surface")[: len(correct)], correct, held, held // 2, grasps, 3, "vote", 1.25)


def test_an_object_is_below_the_paper_by_fishers_exact_test() -> None:
    rng = np.random.default_rng(0)
    ours = table_of(rng.integers(0, 31, (1, 2, 10)), 30)
    right, p = ours.correct[0].sum(axis=0), ours.below_paper("contact")
    for k in range(10):
        theirs = round(paper_percent()[k] / 100 * PAPER_GRASPS)
        # At most so many of ours among all right answers, drawn without order.
        wanted = stats.hypergeom(60 + PAPER_GRASPS, right[k] + theirs, 60).cdf(right[k])
        assert p[k] == pytest.approx(wanted)
    text = str(ours).splitlines()
    stars = [cell.endswith("*") for cell in text[2].split()[1:11]]
    assert stars == (p < 0.05).tolist()
    assert text[-1].endswith("mode vote, finger scale 1.25, seed 3; * significantly below the paper")
    assert list(ours.to_dicts())[10]["held_percent"] == 100
    assert list(ours.to_dicts())[10]["first_attempt_percent"] == 50


def test_means_stay_between_nothing_and_all() -> None:
    for right in (0, 20):
        correct = np.full((1, 3, 10), right)
        correct[0, 0, 0] = 10
        mean, low, high = table_of(correct, 20).mean("contact")
        assert 0 <= low <= mean <= high <= 100
        assert (low == 0) == (right == 0)
        assert (high == 100) == (right == 20)


def test_the_lines_of_a_table_stand_in_columns() -> None:
    rng = np.random.default_rng(1)
    ours = table_of(rng.integers(0, 21, (2, 2, 10)), 20)
    lines = str(ours).splitlines()[:-1]
    header = lines[0]
    ends = [header.index(name) + len(name) for name in OBJECT_NAMES]
    for line in lines[1:]:
        for end in ends:
            assert line[end - 1] != " "
            assert line[end : end + 2].strip() == ""
    assert lines[1].startswith("paper  ")


def test_numbers_are_cut_before_they_are_learned() -> None:
    rng = np.random.default_rng(2)

    def felt(n: int, on: list[bool]) -> list[Features]:
        return [
            Features({"switch.a": True}, {"angle.b": float(rng.uniform(0, 1) + 2 * high), "angle.c": 0.5})
            for high in on[:n]
        ]

    on = [bool(k % 2) for k in range(20)]
    names = ["box" if high else "ball" for high in on]
    assert classify(felt(20, on), names, felt(20, on), mode="paper").tolist() == names
    # Switches alone know nothing here; with them as numbers' only company the first class is as good as any.
    switches = [Features({"switch.a": high, "switch.b": True}, {}) for high in on]
    assert classify(switches, names, switches, mode="paper").tolist() == names


@pytest.mark.parametrize("restored", [None, "the sign table"])
def test_a_table_is_printed_as_scanned_as_restored_and_as_computed(restored: str | None) -> None:
    table = PaperTable(2, "Sign table", "s c a n", restored, "ours", ("one", "two"), restored is None, ())
    blocks = ["Table 2. Sign table", "As scanned:\ns c a n"]
    blocks += [] if restored is None else ["Restored:\nthe sign table"]
    blocks += [f"Computed here ({'agrees' if restored is None else 'differs'}):\nours", "- one\n- two"]
    assert str(table) == "\n\n".join(blocks)


def test_each_repetition_learns_from_its_own_grasps(
    known_grasps: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def classify_spied(train: Any, labels: Any, test: Any, *, mode: str) -> np.ndarray:
        asked.append((len(train), sorted(set(labels)), len(test), mode))
        return np.array(["cylinder"] * len(test))

    monkeypatch.setattr(table5, "classify", classify_spied)
    made = made_table(grasps=4, repetitions=3, groups=("contact", "contact+coordinates"), mode="robust")
    names = sorted({TABLE_5_OBJECTS[2][0], TABLE_5_OBJECTS[7][0]})
    assert asked == [(20, names, 40, "robust")] * 6
    held = made.held * np.array([name == "cylinder" for name, _ in TABLE_5_OBJECTS])
    np.testing.assert_array_equal(made.correct, [held, held])
