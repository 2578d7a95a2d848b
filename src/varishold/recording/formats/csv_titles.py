"""What the first line of plain CSV says of the columns below it: that it only counts them, or that they stand apart."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError

__all__ = ["check_order", "only_counts"]

_NUMBER = re.compile(r"\d+")
# What stands before the first of two numbers where it is the column's.
_COLUMN_FIRST = re.compile(r"(?:^|[\W_])(c|col|column|x)[\W_]*$", re.IGNORECASE)
# A pad of fewer taxels may well read 0, 1, 2, 3.
_FEWEST_COUNTED = 16


def only_counts(row: NDArray[Any]) -> bool:
    """Tell whether a row is 0, 1, 2 ... or 1, 2, 3 ...: what stands above a table whose columns have no names."""
    return row.size >= _FEWEST_COUNTED and row[0] in (0, 1) and bool((np.diff(row) == 1).all())


def check_order(path: Path, titles: Sequence[str]) -> None:
    """Refuse taxels whose titles number them in another order than row by row.

    Parameters
    ----------
    path : Path
        The file, for messages.
    titles : sequence of str
        Of the columns that are taxels, in the order of the file.

    Raises
    ------
    FormatError
        If all are called alike but for a number, or a row and a column, and these do not rise.
    """
    if not titles:
        return
    alike = {_NUMBER.sub("#", title) for title in titles}
    places = [tuple(map(int, _NUMBER.findall(title))) for title in titles]
    if len(alike) != 1 or len(places[0]) not in (1, 2) or len(set(places)) < len(places):
        return
    if len(places[0]) == 2 and _COLUMN_FIRST.search(_NUMBER.split(titles[0])[0]):
        places = [(row, col) for col, row in places]
    wrong = next((k for k in range(1, len(places)) if places[k] < places[k - 1]), None)
    if wrong is not None:
        raise FormatError(
            f"{path}: columns are not in the order of their numbers: {titles[wrong][:40]!r} stands behind "
            f"{titles[wrong - 1][:40]!r}; call them NAME.ROW.COLUMN, which may stand in any order, or leave the header "
            "out where they do stand row by row"
        )
