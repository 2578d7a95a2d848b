"""Hyperplanes between grasps: strict majority votes over the switches in which two grasps differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError, require

__all__ = ["Hyperplanes", "align", "bisectors", "distinct", "roman"]

#: Sums of at most this many unit weights are exact in float32, in which the products are taken.
_EXACT_SUM = 1 << 24
#: Weights multiplied at a time, so that memory stays bounded whatever the number of hyperplanes.
_BLOCK_WEIGHTS = 1 << 25


@dataclass(frozen=True, eq=False)
class Hyperplanes:
    """Bisectors between binary patterns, in the paper's coefficients doubled so that they are integers.

    For the bisector of v_i and v_j (eq. [22]) row h of `weights` is v_i - v_j. A pattern v lies on its
    positive side, s = 1, iff ``weights @ v > weights.sum() / 2``, strictly: iff more than half of the
    switches with non-zero weight read as in v_i. A tie gives s = 0 (eq. [25]).

    Parameters
    ----------
    weights : ndarray of shape (n_hyperplanes, n_switches), int8
        +1, 0 or -1; no row is all zeros.
    names : tuple of str, optional
        One name a hyperplane; Roman numerals as in the paper if left out.
    pairs : ndarray of shape (n_hyperplanes, 2), int64, optional
        Numbers (from one) of the grasps between which each lies, the one on its positive side first;
        -1 where unknown.

    Examples
    --------
    >>> h = Hyperplanes(np.array([[1, 0, -1]], dtype=np.int8))
    >>> h.signs(np.array([[1, 0, 0], [0, 1, 0], [0, 1, 1]], dtype=bool)).ravel().astype(int)
    array([1, 0, 0])
    >>> print(h)
        a1  a2    a3  b
    I  0.5   0  -0.5  0
    """

    weights: NDArray[np.int8]
    names: tuple[str, ...] = ()
    pairs: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

    def __post_init__(self) -> None:
        table = self.weights.ndim == 2 and self.weights.shape[1] < _EXACT_SUM
        require(table, f"hyperplane weights must be a table (hyperplanes, switches), got {self.weights.shape}")
        require(((self.weights >= -1) & (self.weights <= 1)).all(), "hyperplane weights must be -1, 0 or 1")
        if not self.names:
            object.__setattr__(self, "names", tuple(roman(k + 1) for k in range(len(self.weights))))
        if not len(self.pairs):
            object.__setattr__(self, "pairs", np.full((len(self.weights), 2), -1, dtype=np.int64))
        require(
            len(self.names) == len(self.weights) and self.pairs.shape == (len(self.weights), 2),
            f"{counted(len(self.weights), 'hyperplane needs', 'hyperplanes need')} as many names and pairs, "
            f"got {len(self.names)} and {self.pairs.shape}",
        )

    def __len__(self) -> int:
        return len(self.weights)

    @property
    def n_switches(self) -> int:
        """How many switches a pattern has."""
        return int(self.weights.shape[1])

    @property
    def biases(self) -> NDArray[np.int64]:
        """Integer biases, shape (n_hyperplanes,): s = 1 iff ``weights @ v > bias``."""
        return np.asarray(self.weights.sum(axis=1, dtype=np.int64) // 2, dtype=np.int64)

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """The paper's coefficients a and b (eq. [23]), shape (n_hyperplanes, n_switches + 1): b = (n+ - n-) / 4."""
        a = self.weights / 2.0
        return np.column_stack([a, a.sum(axis=1) / 2.0])

    def excess(self, patterns: NDArray[np.bool_]) -> NDArray[np.int32]:
        """How far ``weights @ v`` lies above the bias, shape (n_patterns, n_hyperplanes); s = 1 iff it is positive."""
        patterns = patterns.astype(np.float32)
        out = np.empty((len(patterns), len(self)), dtype=np.int32)
        step = max(1, _BLOCK_WEIGHTS // max(self.n_switches, 1))
        for start in range(0, len(self), step):
            block = slice(start, start + step)
            out[:, block] = patterns @ self.weights[block].astype(np.float32).T
        return out - self.biases.astype(np.int32)

    def signs(self, patterns: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Position signs s (eq. [24]-[25]) of every pattern, shape (n_patterns, n_hyperplanes)."""
        return np.asarray(self.excess(patterns) > 0, dtype=np.bool_)

    def take(self, chosen: Sequence[int] | NDArray[np.int64]) -> Hyperplanes:
        """Return the chosen hyperplanes, renumbered from I."""
        at = np.asarray(chosen, dtype=np.int64)
        return Hyperplanes(self.weights[at], pairs=self.pairs[at])

    def __str__(self) -> str:
        header = ["", *(f"a{k + 1}" for k in range(self.n_switches)), "b"]
        rows = [[name, *(f"{c:g}" for c in row)] for name, row in zip(self.names, self.coefficients, strict=True)]
        return align([header, *rows])


def bisectors(
    first: NDArray[np.bool_],
    second: NDArray[np.bool_],
    *,
    pairs: NDArray[np.int64] | None = None,
    within: NDArray[np.bool_] | None = None,
    orient: bool = True,
) -> Hyperplanes:
    """Bisectors of the pairs (first[k], second[k]), eq. [22].

    Parameters
    ----------
    first, second : ndarray of shape (n, n_switches), bool
        The two patterns of every pair; they must differ.
    pairs : ndarray of shape (n, 2), int, optional
        Numbers of the two grasps.
    within : ndarray of shape (n, n_switches), bool, optional
        Switches that may vote; the others are left out of the bisector.
    orient : bool, default True
        True: the positive side is that of the lexicographically larger pattern, so that a tie (s = 0)
        falls to the same side whichever of the two is called first. False: that of `first`.

    Examples
    --------
    >>> print(bisectors(np.array([[0, 1, 1]], dtype=bool), np.array([[1, 0, 1]], dtype=bool)))
        a1    a2  a3  b
    I  0.5  -0.5   0  0
    """
    weights = first.astype(np.int8) - second.astype(np.int8)
    if within is not None:
        weights = weights * within
    empty = ~weights.any(axis=1)
    if empty.any():
        raise InputError(f"pair {int(empty.argmax())} holds two equal patterns, which no hyperplane separates")
    numbers = np.full((len(weights), 2), -1, dtype=np.int64) if pairs is None else pairs
    if orient:
        # The first switch in which they differ is on in the lexicographically larger of the two.
        turned = weights[np.arange(len(weights)), (weights != 0).argmax(axis=1)] < 0
        weights = np.where(turned[:, None], -weights, weights)
        numbers = np.where(turned[:, None], numbers[:, ::-1], numbers)
    return Hyperplanes(weights.astype(np.int8), pairs=numbers)


def distinct(*sets: Hyperplanes) -> Hyperplanes:
    """Join sets of hyperplanes, each different one once, in order of appearance."""
    weights = np.concatenate([h.weights for h in sets])
    pairs = np.concatenate([h.pairs for h in sets])
    first: dict[bytes, int] = {}
    for k, row in enumerate(weights):
        first.setdefault(row.tobytes(), k)
    at = np.array(list(first.values()), dtype=np.int64)
    return Hyperplanes(weights[at], pairs=pairs[at])


@cache
def roman(number: int) -> str:
    """Roman numeral of a positive number; plain digits from 4000 on.

    Examples
    --------
    >>> [roman(n) for n in (1, 4, 9, 14, 40, 1971)]
    ['I', 'IV', 'IX', 'XIV', 'XL', 'MCMLXXI']
    """
    if number >= 4000:
        return str(number)
    numerals = ((1000, "M"), (900, "CM"), (500, "D"), (400, "CD"), (100, "C"), (90, "XC"), (50, "L"))
    text = ""
    for value, numeral in (*numerals, (40, "XL"), (10, "X"), (9, "IX"), (5, "V"), (4, "IV"), (1, "I")):
        text += numeral * (number // value)
        number %= value
    return text


def align(rows: list[list[str]]) -> str:
    """Lay out rows of cells in right-aligned columns, the first left-aligned."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True))]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)
