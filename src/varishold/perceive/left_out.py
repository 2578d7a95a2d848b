"""Metrics without some of their examples, by which these are judged as a new touch will be."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.metric import Metric, fit_metric, shrinkage

__all__ = ["metrics_without"]

Floats = NDArray[np.float64]

# So few examples are left out each by itself, of more some together: what a metric takes then does not grow further,
# and a metric lacks a sixty-fourth of its examples at most.
_MOST_LOTS = 64


def metrics_without(
    metric: Metric,
    values: Floats,
    owner: NDArray[np.int64],
    log_size: Floats,
    *,
    learned_from: NDArray[np.bool_],
) -> Iterator[tuple[NDArray[np.int64], Metric]]:
    """Yield examples, all of them in turn, and the metric of the others.

    With as many numbers as examples a metric knows each of these so well that whatever is new seems odd beside them:
    how far numbers scatter, together and each by itself, is learned again without those that are judged. What is added
    to their scatter stays: it is more where there are fewer examples, and would bring everything nearer that is judged.

    Parameters
    ----------
    metric : Metric
        Of all that it was learned from.
    values : ndarray of shape (n, d)
        NaN where a number is unknown.
    owner : ndarray of shape (n,), int
        Which object each example is of.
    log_size : ndarray of shape (n,)
        Logarithm of each example's size; NaN where it is unknown.
    learned_from : ndarray of shape (n,), bool
        Which examples the metric was learned from; the others are judged by it as it is.

    Yields
    ------
    rows : ndarray of int
        In rising order.
    metric : Metric
    """
    rest = np.flatnonzero(~learned_from)
    if rest.size:
        yield rest, metric
    rows = np.flatnonzero(learned_from)
    if rows.size < 2:
        yield rows, metric
        return
    # Object by object, and of each by its numbers, so that every lot has some of all and no order of examples counts.
    by_numbers = rows[np.lexsort((*np.nan_to_num(values[rows]).T[::-1], owner[rows]))]
    added = shrinkage(len(metric.names), owner[rows], log_size[rows])
    lots = min(len(rows), _MOST_LOTS)
    for k in range(lots):
        out = np.sort(by_numbers[k::lots])
        kept = np.setdiff1d(rows, out, assume_unique=True)
        yield out, fit_metric(metric.names, values[kept], owner[kept], log_size[kept], shrink=added)
