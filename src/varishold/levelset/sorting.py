"""Sorting by falling value, stable: equal values keep their order."""

from __future__ import annotations

import numpy as np

from varishold.files.compiling import njit

__all__ = ["sort_falling"]


@njit(cache=True, nogil=True, error_model="numpy")
def sort_falling(value, order):  # type: ignore[no-untyped-def]
    """Sort `order` so that value[order] falls; stable (bottom-up merge sort over short sorted runs)."""
    n = order.size
    run = 16
    for start in range(0, n, run):
        for i in range(start + 1, min(start + run, n)):
            item = order[i]
            key = value[item]
            j = i
            while j > start and value[order[j - 1]] < key:
                order[j] = order[j - 1]
                j -= 1
            order[j] = item
    other = np.empty(n, np.int64)
    while run < n:
        for start in range(0, n, 2 * run):
            middle, stop = min(start + run, n), min(start + 2 * run, n)
            i, j = start, middle
            for k in range(start, stop):
                if i < middle and (j >= stop or value[order[i]] >= value[order[j]]):
                    other[k] = order[i]
                    i += 1
                else:
                    other[k] = order[j]
                    j += 1
        for k in range(n):
            order[k] = other[k]
        run *= 2
