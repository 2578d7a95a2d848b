"""Sign tables: on which side of every hyperplane each grasp lies, and the same with fewer rows and columns."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.circuit import minimize
from varishold.errors import require
from varishold.grasp.hyperplanes import align
from varishold.grasp.separating import Selection, separating_set

__all__ = ["MinimalTable", "SignTable", "minimal_table", "reduced_table", "smallest_hyperplanes"]

#: Where class names side by side take more characters, a grasp is printed a line, not a column as in the paper.
_PRINTED_WIDTH = 80


@dataclass(frozen=True, eq=False)
class SignTable:
    """Position signs of grasps (rows) on hyperplanes (columns), as Tables 2 and 3.

    Parameters
    ----------
    signs : ndarray of shape (n_grasps, n_hyperplanes), bool
        s of eqs. [24]-[25].
    labels : tuple
        Class of each grasp.
    hyperplanes : tuple of str
        Names of the columns.
    grasps : tuple of int
        Numbers of the rows: the j of v_j.

    Examples
    --------
    >>> table = SignTable(np.array([[0, 1], [1, 0]], dtype=bool), (2, 1), ("I", "III"), (1, 2))
    >>> print(table)
             v1  v2
    pattern   2   1
    I         0   1
    III       1   0
    """

    signs: NDArray[np.bool_]
    labels: tuple[Hashable, ...]
    hyperplanes: tuple[str, ...]
    grasps: tuple[int, ...]

    def __post_init__(self) -> None:
        require(
            self.signs.shape == (len(self.labels), len(self.hyperplanes)) and len(self.grasps) == len(self.labels),
            f"a sign table of {counted(len(self.labels), 'grasp')} and "
            f"{counted(len(self.hyperplanes), 'hyperplane')} needs signs "
            f"of that shape and as many grasp numbers, got {self.signs.shape} and {len(self.grasps)}",
        )

    @property
    def codes(self) -> NDArray[np.int64]:
        """Class of each row as an index into the classes in order of appearance."""
        seen: dict[Hashable, int] = {}
        return np.array([seen.setdefault(label, len(seen)) for label in self.labels], dtype=np.int64)

    def columns(self, names: Sequence[str]) -> SignTable:
        """Return the table of the named hyperplanes only."""
        at = [self.hyperplanes.index(name) for name in names]
        return SignTable(self.signs[:, at], self.labels, tuple(names), self.grasps)

    def __str__(self) -> str:
        names = [f"v{j}" for j in self.grasps]
        cells = np.where(self.signs, "1", "0").tolist()
        if sum(map(len, map(str, self.labels))) > _PRINTED_WIDTH:
            rows = [["", "pattern", *self.hyperplanes]]
            rows += [[v, str(c), *row] for v, c, row in zip(names, self.labels, cells, strict=True)]
            return align(rows)
        rows = [["", *names], ["pattern", *(str(label) for label in self.labels)]]
        rows += [[name, *(row[k] for row in cells)] for k, name in enumerate(self.hyperplanes)]
        return align(rows)


@dataclass(frozen=True)
class MinimalTable:
    """Rows with don't-cares, as Table 4: each class as an OR of ANDs over the signs.

    Parameters
    ----------
    cubes : tuple of tuple of (int or None)
        For every row the sign that each hyperplane must have; None (printed ``*``) where it does not matter.
    labels : tuple
        Class of each row.
    hyperplanes : tuple of str
        Names of the columns.
    grasps : tuple of int
        The grasp after which each row is numbered.
    """

    cubes: tuple[tuple[int | None, ...], ...]
    labels: tuple[Hashable, ...]
    hyperplanes: tuple[str, ...]
    grasps: tuple[int, ...]

    def terms(self, label: Hashable) -> list[tuple[tuple[int, int], ...]]:
        """Product terms of a class: tuples of (hyperplane index, wanted sign)."""
        return [
            tuple((k, wanted) for k, wanted in enumerate(cube) if wanted is not None)
            for cube, own in zip(self.cubes, self.labels, strict=True)
            if own == label
        ]

    def formula(self, label: Hashable) -> str:
        """The circuit of a class in words, like ``s_I AND NOT s_III``."""
        products = []
        for term in self.terms(label):
            literals = [f"{'' if wanted else 'NOT '}s_{self.hyperplanes[k]}" for k, wanted in term]
            products.append(" AND ".join(literals) or "always")
        return " OR ".join(f"({p})" if len(products) > 1 and " AND " in p else p for p in products) or "never"

    def __str__(self) -> str:
        rows = [["", "pattern", *self.hyperplanes]]
        for v, label, cube in zip(self.grasps, self.labels, self.cubes, strict=True):
            rows.append([f"v{v}", str(label), *("*" if s is None else str(s) for s in cube)])
        return align(rows)


def smallest_hyperplanes(table: SignTable, *, time_limit_s: float = 10.0) -> tuple[SignTable, Selection]:
    """Keep the fewest hyperplanes that separate the classes; also say what is proved about their number."""
    selection = separating_set(table.signs, table.codes, time_limit_s=time_limit_s)
    return table.columns([table.hyperplanes[k] for k in selection.columns]), selection


def reduced_table(table: SignTable) -> SignTable:
    """Merge rows with equal signs, each kept under its first grasp's number (Table 2 to Table 3).

    Raises
    ------
    InputError
        Where grasps of different classes have equal signs.

    Examples
    --------
    >>> table = SignTable(np.array([[1], [0], [1]], dtype=bool), ("a", "b", "a"), ("I",), (1, 2, 3))
    >>> print(reduced_table(table))
             v1  v2
    pattern   a   b
    I         1   0
    """
    first: dict[bytes, int] = {}
    for row, signs in enumerate(table.signs):
        earlier = first.setdefault(signs.tobytes(), row)
        require(
            table.labels[earlier] == table.labels[row],
            f"grasps v{table.grasps[earlier]} ({table.labels[earlier]}) and v{table.grasps[row]} "
            f"({table.labels[row]}) have equal signs on all of {', '.join(table.hyperplanes)}",
        )
    rows = sorted(first.values())
    return SignTable(
        table.signs[rows],
        tuple(table.labels[k] for k in rows),
        table.hyperplanes,
        tuple(table.grasps[k] for k in rows),
    )


def minimal_table(table: SignTable) -> MinimalTable:
    """Minimize every class to an OR of ANDs, signs that never occurred being free (Table 3 to Table 4).

    Rows are numbered as in the paper: going down the reduced table, the first row that no earlier row of
    the result covers gives its number to the term that covers most of what is left.
    """
    reduced = reduced_table(table)
    labels = list(dict.fromkeys(reduced.labels))
    cubes: list[tuple[tuple[int | None, ...], Hashable, int]] = []
    for label in labels:
        own = np.array([other == label for other in reduced.labels])
        cover = [
            _cube(term, len(reduced.hyperplanes)) for term in minimize(reduced.signs[own], reduced.signs[~own]).terms
        ]
        left = dict(zip(np.flatnonzero(own).tolist(), reduced.signs[own].tolist(), strict=True))
        while left and cover:
            row = min(left)
            fitting = [cube for cube in cover if _covers(cube, left[row])] or cover
            cube = max(fitting, key=lambda c: (sum(_covers(c, s) for s in left.values()), _free_first(c)))
            cubes.append((cube, label, reduced.grasps[row]))
            cover.remove(cube)
            left = {k: signs for k, signs in left.items() if not _covers(cube, signs)}
    cubes.sort(key=lambda item: item[2])
    return MinimalTable(
        tuple(cube for cube, _, _ in cubes),
        tuple(label for _, label, _ in cubes),
        reduced.hyperplanes,
        tuple(v for _, _, v in cubes),
    )


def _cube(term: Sequence[tuple[int, int]], width: int) -> tuple[int | None, ...]:
    wanted = dict(term)
    return tuple(wanted.get(k) for k in range(width))


def _covers(cube: tuple[int | None, ...], signs: Sequence[bool]) -> bool:
    return all(wanted is None or wanted == int(sign) for wanted, sign in zip(cube, signs, strict=True))


def _free_first(cube: tuple[int | None, ...]) -> tuple[bool, ...]:
    """Sort key that prefers don't-cares in the earlier hyperplanes, as the paper raises them."""
    return tuple(wanted is None for wanted in cube)
