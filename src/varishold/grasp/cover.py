"""Minimum set cover: a short search for small answers, integer programming for the others."""

from __future__ import annotations

import math
from time import monotonic

import numpy as np
from numpy.typing import NDArray

__all__ = ["smallest_cover"]

#: Nodes of the search, a few microseconds each, before the integer program is called.
_NODES = 20_000
#: Above this many columns dominated ones are not looked for: the search itself would cost more.
_REDUCTION_COLUMNS = 3000


def smallest_cover(
    cover: NDArray[np.bool_], *, upper: int, lower: int, time_limit_s: float
) -> tuple[list[int] | None, int]:
    """Look for a cover of fewer than `upper` columns.

    Parameters
    ----------
    cover : ndarray of shape (n_elements, n_columns), bool
        Which columns contain which element; every element lies in some column.
    upper : int
        Size of a cover that is known.
    lower : int
        No cover is smaller.
    time_limit_s : float
        Seconds for the integer program, its relaxation included; 0 looks for nothing.

    Returns
    -------
    columns : list of int or None
        A smaller cover, if one was found.
    bound : int
        No cover is smaller; equal to the smallest known size where it is proved smallest.

    Examples
    --------
    >>> smallest_cover(np.array([[1, 0, 1], [0, 1, 1]], dtype=bool), upper=2, lower=1, time_limit_s=1.0)
    ([2], 1)
    """
    if time_limit_s <= 0:
        return None, lower
    columns = _undominated(cover)
    search = _Search(cover[:, columns])
    best: list[int] | None = None
    size = upper
    while size > lower:
        found = search.cover_of(size - 1)
        if search.nodes > _NODES:
            return _by_integer_program(cover[:, columns], columns, best, size, lower, time_limit_s)
        if found is None:
            return best, size
        best = [int(columns[k]) for k in found]
        size = len(found)
    return best, lower


class _Search:
    """Depth first: branch over the columns of the element that lies in fewest."""

    def __init__(self, cover: NDArray[np.bool_]) -> None:
        order = np.argsort(cover.sum(axis=1), kind="stable")
        rows = cover[order]
        # One whole number a column, bit e for element e, the hardest element first.
        packed = np.packbits(rows, axis=0, bitorder="little")
        self.sets = [int.from_bytes(packed[:, k].tobytes(), "little") for k in range(cover.shape[1])]
        self.columns_of = [np.flatnonzero(row).tolist() for row in rows]
        self.everything = (1 << len(rows)) - 1
        self.nodes = 0

    def cover_of(self, size: int) -> list[int] | None:
        """Return a cover of at most `size` columns, or None if there is none (or the nodes ran out)."""
        return self._cover(self.everything, size)

    def _cover(self, left: int, size: int) -> list[int] | None:
        if not left:
            return []
        self.nodes += 1
        if size == 0 or self.nodes > _NODES:
            return None
        hardest = (left & -left).bit_length() - 1
        candidates = self.columns_of[hardest]
        if size == 1:
            return next(([k] for k in candidates if not left & ~self.sets[k]), None)
        # Most of what is left first; together `size` columns must contain all of it.
        gains = sorted(((left & self.sets[k]).bit_count(), -k) for k in candidates)
        for _, negative in reversed(gains):
            rest = self._cover(left & ~self.sets[-negative], size - 1)
            if rest is not None:
                return [-negative, *rest]
        return None


def _undominated(cover: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Columns that no other column contains; of equal ones the first."""
    m = cover.shape[1]
    if m > _REDUCTION_COLUMNS:
        return np.arange(m, dtype=np.int64)
    x = cover.astype(np.float32)
    inside = (x.T @ (1 - x)) == 0
    equal = inside & inside.T
    earlier = np.tri(m, k=-1, dtype=np.bool_)
    dominated = (inside & ~equal) | (equal & earlier)
    return np.flatnonzero(~dominated.any(axis=1)).astype(np.int64)


def _by_integer_program(
    cover: NDArray[np.bool_],
    columns: NDArray[np.int64],
    best: list[int] | None,
    size: int,
    lower: int,
    time_limit_s: float,
) -> tuple[list[int] | None, int]:
    from scipy.optimize import Bounds, LinearConstraint, linprog, milp
    from scipy.sparse import csr_matrix

    m = cover.shape[1]
    table = csr_matrix(cover.astype(np.float64))
    # The relaxation alone is most often quick, and proves most of what the program would.
    begun = monotonic()
    relaxed = linprog(
        np.ones(m),
        A_ub=-cover.astype(np.float64),
        b_ub=-np.ones(len(cover)),
        bounds=(0, 1),
        method="highs-ds",
        options={"time_limit": time_limit_s},
    )
    left_s = time_limit_s - (monotonic() - begun)
    if relaxed.status == 0 and relaxed.fun is not None:
        lower = max(lower, math.ceil(relaxed.fun - 1e-6))
    if size <= lower:
        return best, size
    if left_s <= 0:
        return best, lower
    result = milp(
        np.ones(m),
        integrality=np.ones(m, dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=[
            LinearConstraint(table, 1, np.inf),
            LinearConstraint(np.ones((1, m)), lower, size),
        ],
        # Presolving a dense cover takes many times the time limit, which it does not heed.
        options={"time_limit": left_s, "mip_rel_gap": 0.0, "presolve": False},
    )
    bound = getattr(result, "mip_dual_bound", None)
    proved = math.ceil(bound - 1e-6) if bound is not None and np.isfinite(bound) else lower
    if result.x is not None and int((result.x > 0.5).sum()) < size:
        best = [int(columns[k]) for k in np.flatnonzero(result.x > 0.5)]
        size = len(best)
    return best, min(size, max(lower, proved))
