"""The paper's Tables 1 to 4 from its own data, and the command that prints them."""

from __future__ import annotations

import json
import sys
from itertools import product

import numpy as np
import pytest

from varishold.cli import main
from varishold.errors import InputError
from varishold.grasp import minimal_table, reduced_table, smallest_hyperplanes, smallest_sets
from varishold.paper import (
    lost_columns,
    paper_table,
    printed_accuracies,
    printed_hyperplanes,
    printed_minimal_table,
    printed_reduced_table,
    printed_sign_table,
    scanned_signs,
    scanned_text,
)


def test_hyperplanes_i_and_iii_are_the_only_smallest_set() -> None:
    table = printed_sign_table()
    chosen, selection = smallest_hyperplanes(table)
    assert chosen.hyperplanes == ("I", "III")
    assert selection.gap == 0
    assert smallest_sets(table.signs, table.codes, size=1) == []
    assert smallest_sets(table.signs, table.codes, size=2) == [(0, 2)]


def test_table_3_follows_from_table_2() -> None:
    ours, printed = reduced_table(printed_sign_table().columns(["I", "III"])), printed_reduced_table()
    assert ours.grasps == printed.grasps == (1, 2, 4, 6)
    assert ours.labels == printed.labels
    np.testing.assert_array_equal(ours.signs, printed.signs)


def test_table_4_follows_from_table_3() -> None:
    assert minimal_table(printed_reduced_table()) == printed_minimal_table()


def test_the_circuit_is_s_i_and_not_s_iii() -> None:
    table = minimal_table(printed_sign_table().columns(["I", "III"]))
    assert table.formula(1) == "s_I AND NOT s_III"


def test_table_1_bias_by_formula_and_the_misprints() -> None:
    planes = {plane.name: plane for plane in printed_hyperplanes()}
    formula = {name: sum(plane.coefficients) / 2 for name, plane in planes.items()}
    assert formula == {"I": 0.25, "II": -1.75, "III": -1.25}
    assert [sum(c != 0 for c in plane.coefficients) for plane in planes.values()] == [9, 9, 7]
    reach = {name: sum(c for c in plane.coefficients if c > 0) for name, plane in planes.items()}
    assert [reach[name] > planes[name].b for name in ("I", "II", "III")] == [True, False, False]
    restored = [row["b_restored"] for row in paper_table(1).rows]
    assert restored == [0.25, -1.75, -0.75]


def test_the_lost_column_stands_among_v7_to_v11() -> None:
    assert lost_columns() == [(place, (1, 0)) for place in range(7, 12)]
    patterns, signs = scanned_signs()
    assert len(patterns) == 20
    assert signs.shape == (19, 3)
    for place in range(6, 11):
        full = np.insert(signs, place, [True, False, False], axis=0)
        np.testing.assert_array_equal(full, printed_sign_table().signs)


def test_table_5_reads_sizes_as_diameters_and_breadths() -> None:
    columns = {a.name: a for a in printed_accuracies()}
    assert columns["C3"].size_m == pytest.approx(0.09)
    assert columns["S3"].size_m == pytest.approx(0.07)
    assert [columns[f"C{k}"].correct_percent for k in range(1, 6)] == [0, 90, 100, 100, 50]


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_every_table_shows_the_scan_and_ours(number: int) -> None:
    table = paper_table(number)
    text = str(table)
    assert scanned_text(number) in text
    assert table.ours in text
    assert all(note in text for note in table.notes)
    assert table.agrees == (number != 1)


def test_an_unknown_table_is_an_input_error() -> None:
    with pytest.raises(InputError, match=r"the paper's tables are 1, 2, 3, 4.*got 6"):
        paper_table(6)


def test_the_command_prints_tables_and_json_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["varishold", "paper", "table", *words])
        status = 0
        try:
            main()
        except SystemExit as leaving:
            status = int(leaving.code or 0)
        return (status, *capsys.readouterr())

    status, shown, _ = run("4")
    assert status == 0
    assert "s_I AND NOT s_III" in shown
    lines = [json.loads(line) for line in run("3", "--json")[1].splitlines()]
    assert [(row["v"], row["pattern"], row["I"], row["III"]) for row in lines] == [
        (1, 2, 0, 1),
        (2, 1, 1, 0),
        (4, 2, 1, 1),
        (6, 2, 0, 0),
    ]
    status, _, message = run("9")
    assert status == 1
    assert message.count("\n") == 1
    assert "Traceback" not in message


def test_the_minimal_table_answers_every_sign_vector_of_the_reduced_one() -> None:
    table = printed_minimal_table()
    for signs in product((0, 1), repeat=2):
        holding = {
            label
            for label in (1, 2)
            if any(all(signs[k] == wanted for k, wanted in term) for term in table.terms(label))
        }
        assert holding == {1 if signs == (1, 0) else 2}
