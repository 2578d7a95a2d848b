"""The paper's experiments of section 3: each table as scanned, as restored, and as computed here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np

from varishold.errors import InputError
from varishold.grasp import SignTable, minimal_table, reduced_table, smallest_hyperplanes, smallest_sets
from varishold.grasp.hyperplanes import align
from varishold.paper.beside import PaperTable
from varishold.paper.tables import (
    printed_hyperplanes,
    printed_minimal_table,
    printed_reduced_table,
    printed_sign_table,
    scanned_signs,
    scanned_text,
)

__all__ = ["TABLES", "lost_columns", "paper_table"]


def table1(seed: int) -> PaperTable:
    """Table 1: b from the coefficients by b = (n+ - n-) / 4, and where the printed rows cannot be right."""
    header = ["", "n+", "n-", "b printed", "b computed", "b restored", "fires as printed"]
    lines, rows, notes = [header], [], []
    for plane in printed_hyperplanes():
        a = np.array(plane.coefficients)
        plus, minus = int((a > 0).sum()), int((a < 0).sum())
        computed = (plus - minus) / 4
        fires = float(a[a > 0].sum()) > plane.b
        restored, note = _restored_b(plane.name, plane.b, computed, plus, minus)
        notes.append(note)
        lines.append(
            [
                plane.name,
                str(plus),
                str(minus),
                f"{plane.b:g}",
                f"{computed:g}",
                f"{restored:g}",
                "yes" if fires else "never",
            ]
        )
        rows.append(
            {
                "table": 1,
                "hyperplane": plane.name,
                "coefficients": list(plane.coefficients),
                "b_printed": plane.b,
                "b_computed": computed,
                "b_restored": restored,
                "can_fire_as_printed": fires,
            }
        )
    notes.append("every row has an odd number of non-zero coefficients (9, 9, 7): no grasp can tie")
    return PaperTable(
        1,
        "A coefficient of the hyperplane equations",
        scanned_text(1),
        None,
        align(lines),
        (
            "for a bisector (eq. [22]) a = (v_i - v_j) / 2 and b = (|v_i|^2 - |v_j|^2) / 4 = (n+ - n-) / 4, "
            "with n+ coefficients +0.5 and n- coefficients -0.5",
            *notes,
        ),
        all(row["b_printed"] == row["b_computed"] for row in rows),
        tuple(rows),
    )


def _restored_b(name: str, printed: float, computed: float, plus: int, minus: int) -> tuple[float, str]:
    if printed == computed:
        return printed, f"{name}: b = {printed:g} as printed"
    never = f"as printed it could never fire: no sum of its coefficients passes {printed:g}"
    if -printed == computed:
        return computed, f"{name}: b is {computed:g}, its minus sign is lost; {never}"
    if -printed == computed + 0.5:
        return -printed, (
            f"{name}: the printed coefficients give {computed:g}; the printed digits need b = {-printed:g} with its "
            f"minus sign lost, and one of the {minus} coefficients -0.5 really +0.5 (n+ = {plus + 1}, "
            f"n- = {minus - 1}); which one cannot be known; {never}"
        )
    return computed, f"{name}: b printed {printed:g}, computed {computed:g}"


def lost_columns() -> list[tuple[int, tuple[int, int]]]:
    """Places (from one) and signs (I, III) of the column that Table 2 lost, such that Tables 3 and 4 hold.

    A column is tried at every place with every pair of signs; it fits if every grasp of class 1 then has
    s_I = 1 and s_III = 0 and no grasp of class 2 has, as Table 4 says, and the rows v1, v2, v4 and v6 are
    those of Table 3.
    """
    patterns, signs = scanned_signs()
    reduced = printed_reduced_table()
    fits = []
    for place in range(len(patterns)):
        for first, third in product((0, 1), repeat=2):
            full = np.insert(signs, place, np.array([first, 0, third], dtype=np.bool_), axis=0)
            cylinder = full[:, 0] & ~full[:, 2]
            rows = full[np.array(reduced.grasps) - 1][:, [0, 2]]
            if (cylinder == (np.array(patterns) == 1)).all() and (rows == reduced.signs).all():
                fits.append((place + 1, (first, third)))
    return fits


def table2(seed: int) -> PaperTable:
    """Table 2: the restored sign table, and what it says about the hyperplanes."""
    table = printed_sign_table()
    fits = lost_columns()
    places = sorted({place for place, _ in fits})
    signs = sorted({s for _, s in fits})
    sets = smallest_sets(table.signs, table.codes, size=2) or []
    _, selection = smallest_hyperplanes(table)
    named = [" and ".join(table.hyperplanes[k] for k in chosen) for chosen in sets]
    restored_of_scan = np.insert(scanned_signs()[1], places[0] - 1, [True, False, False], axis=0)
    _, scanned = scanned_signs()
    return PaperTable(
        2,
        "Sign table",
        scanned_text(2),
        str(table),
        f"smallest separating sets of hyperplanes: {'; '.join(named)} ({selection})",
        (
            f"the scan has 20 patterns and {len(scanned)} columns of signs: one column is lost",
            f"tried at every place with every pair of signs in I and III, it fits Tables 3 and 4 only at "
            f"v{places[0]} to v{places[-1]}, with signs {', '.join(map(str, signs))}: all these columns are equal in "
            "I and III, so that the restoration is the same wherever it is put back",
            "its sign in II cannot be recovered; nothing depends on it (0 here, like its neighbours)",
        ),
        bool((restored_of_scan == table.signs).all()) and named == ["I and III"],
        tuple(
            {
                "table": 2,
                "v": v,
                "pattern": label,
                **{name: int(s) for name, s in zip(table.hyperplanes, row, strict=True)},
                "restored": places[0] <= v <= places[-1],
            }
            for v, label, row in zip(table.grasps, table.labels, table.signs, strict=True)
        ),
    )


def _chosen() -> SignTable:
    return smallest_hyperplanes(printed_sign_table())[0]


def table3(seed: int) -> PaperTable:
    """Table 3 from Table 2: the smallest separating set, equal rows merged."""
    ours, printed = reduced_table(_chosen()), printed_reduced_table()
    return PaperTable(
        3,
        "Reduced sign table",
        scanned_text(3),
        None,
        _upright(ours),
        (
            f"{' and '.join(ours.hyperplanes)} are the only two hyperplanes that separate the classes, and no one does",
            "grasps with equal signs are one row, under the first one's number",
        ),
        str(ours) == str(printed),
        tuple(
            {
                "table": 3,
                "v": v,
                "pattern": label,
                **{name: int(s) for name, s in zip(ours.hyperplanes, row, strict=True)},
            }
            for v, label, row in zip(ours.grasps, ours.labels, ours.signs, strict=True)
        ),
    )


def table4(seed: int) -> PaperTable:
    """Table 4 from Table 3: two-level minimization, and the circuit of Fig. 5."""
    ours, printed = minimal_table(_chosen()), printed_minimal_table()
    return PaperTable(
        4,
        "Reduced sign table",
        scanned_text(4),
        None,
        f"{ours}\n\ncylinder (pattern 1) = {ours.formula(1)}\nsquare pillar (pattern 2) = {ours.formula(2)}",
        (
            "row v4 of Table 3 is covered once v1's sign in I does not matter",
            "the circuit of Fig. 5 is one AND gate with one inverted input",
        ),
        ours == printed and ours.formula(1) == "s_I AND NOT s_III",
        tuple(
            {
                "table": 4,
                "v": v,
                "pattern": label,
                **{name: "*" if s is None else s for name, s in zip(ours.hyperplanes, cube, strict=True)},
            }
            for v, label, cube in zip(ours.grasps, ours.labels, ours.cubes, strict=True)
        ),
    )


def _upright(table: SignTable) -> str:
    rows = [["", "pattern", *table.hyperplanes]]
    for v, label, signs in zip(table.grasps, table.labels, table.signs, strict=True):
        rows.append([f"v{v}", str(label), *(str(int(s)) for s in signs)])
    return align(rows)


def table5(seed: int) -> PaperTable:
    """Table 5: the ten objects classified, in simulation (extra ``sim``)."""
    from varishold.paper.table5 import as_paper_table, table_5

    return as_paper_table(table_5(seed=seed))


TABLES: Mapping[int, Callable[[int], PaperTable]] = {1: table1, 2: table2, 3: table3, 4: table4, 5: table5}


def paper_table(number: int, *, seed: int = 0) -> PaperTable:
    """Return one of the paper's tables beside ours.

    Parameters
    ----------
    number : int
        1 to 5.
    seed : int
        Of the simulated grasps of Table 5; the others draw nothing.

    Raises
    ------
    InputError
        If there is no such table.
    MissingExtraError
        For Table 5, where the simulated hand is not installed.

    Examples
    --------
    >>> paper_table(4).agrees
    True
    """
    if number not in TABLES:
        known = ", ".join(str(n) for n in TABLES)
        raise InputError(f"the paper's tables are {known}; got {number}")
    return TABLES[number](seed)
