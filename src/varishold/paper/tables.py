"""The paper's tables as data: as the scan has them, and restored where the scan or the paper errs."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from varishold.grasp import MinimalTable, SignTable

__all__ = [
    "Accuracy",
    "PrintedHyperplane",
    "printed_accuracies",
    "printed_hyperplanes",
    "printed_minimal_table",
    "printed_reduced_table",
    "printed_sign_table",
    "scanned_signs",
    "scanned_text",
]


@dataclass(frozen=True)
class PrintedHyperplane:
    """A row of Table 1 as printed: a1 ... a22 and b of eq. [23]."""

    name: str
    coefficients: tuple[float, ...]
    b: float


@dataclass(frozen=True)
class Accuracy:
    """A column of Table 5: an object, its diameter or breadth in metres, and its correct answers in per cent.

    The table says radius where the text says that C3's 90 mm is the diameter.
    """

    name: str
    shape: str
    size_m: float
    correct_percent: float


def scanned_text(number: int) -> str:
    """Table `number` (1 to 5) as the scan gives it, misreadings and all."""
    text = (resources.files("varishold.paper") / "data" / f"table{number}_scanned.txt").read_text("utf-8")
    rows = [[cell.strip().replace(" ", "") for cell in line.split("\t")] for line in text.splitlines()]
    width = max(len(row) for row in rows)
    filled = [row + [""] * (width - len(row)) for row in rows]
    widths = [max(len(row[k]) for row in filled) for k in range(width)]
    return "\n".join(" ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in filled)


def printed_hyperplanes() -> tuple[PrintedHyperplane, ...]:
    """Table 1 as printed."""
    return tuple(
        PrintedHyperplane(row["hyperplane"], tuple(float(row[f"a{k}"]) for k in range(1, 23)), float(row["b"]))
        for row in _rows("table1_hyperplanes.csv")
    )


def scanned_signs() -> tuple[tuple[int, ...], NDArray[np.bool_]]:
    """Table 2 of the scan: 20 pattern numbers, but signs of 19 grasps only, shape (19, 3)."""
    text = (resources.files("varishold.paper") / "data" / "table2_scanned.txt").read_text("utf-8")
    lines = [line.split("\t") for line in text.splitlines()]
    patterns = tuple(int(cell) for cell in lines[1][1:])
    return patterns, np.array([[cell == "1" for cell in line[2:]] for line in lines[2:]]).T


def printed_sign_table() -> SignTable:
    """Table 2, restored to 20 grasps."""
    rows = _rows("table2_signs.csv")
    return _sign_table(rows, ("I", "II", "III"))


def printed_reduced_table() -> SignTable:
    """Table 3."""
    return _sign_table(_rows("table3_reduced.csv"), ("I", "III"))


def printed_minimal_table() -> MinimalTable:
    """Table 4."""
    rows = _rows("table4_minimal.csv")
    names = ("I", "III")
    return MinimalTable(
        tuple(tuple(None if row[name] == "*" else int(row[name]) for name in names) for row in rows),
        tuple(int(row["pattern"]) for row in rows),
        names,
        tuple(int(row["v"]) for row in rows),
    )


def printed_accuracies() -> tuple[Accuracy, ...]:
    """Table 5."""
    return tuple(
        Accuracy(row["object"], row["shape"], float(row["size_mm"]) / 1000, float(row["correct_percent"]))
        for row in _rows("table5_accuracy.csv")
    )


def _sign_table(rows: list[dict[str, str]], names: tuple[str, ...]) -> SignTable:
    return SignTable(
        np.array([[row[name] == "1" for name in names] for row in rows]),
        tuple(int(row["pattern"]) for row in rows),
        names,
        tuple(int(row["v"]) for row in rows),
    )


def _rows(name: str) -> list[dict[str, str]]:
    text = (resources.files("varishold.paper") / "data" / name).read_text("utf-8")
    return list(csv.DictReader(text.splitlines()))
