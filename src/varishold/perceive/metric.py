"""How far apart two touches are: differences weighed by how much they vary among touches of the same object.

Every number is standardized over all examples; differences are then whitened by the covariance within objects (after
what changes evenly with size is taken out), shrunk toward the diagonal. A number that is missing is left out of
both, so that a dead pad or a hand without coordinates makes an answer less sure and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require

__all__ = ["Metric", "fit_metric", "shrinkage"]

Floats = NDArray[np.float64]

# Standardized numbers are cut here, so that no single one decides.
_CLIP = 6.0

# A hand lacks the same numbers touch after touch; so many choices of numbers are kept.
_MOST_PARTS = 4

# A number that changes by no more of itself is constant, but for rounding.
_CONSTANT = 1e-14

# What is added to the within-object covariance of standardized numbers.
_SHRINK = 0.2

# So few examples of an object, or sizes so near each other in logarithm, do not tell what changes with size.
_FEW, _ONE_SIZE = 8, 0.05


@dataclass(frozen=True, eq=False)
class Metric:
    """A whitening of named numbers.

    Parameters
    ----------
    names : tuple of str
        Of the numbers.
    shift, scale : ndarray of shape (d,)
        What standardizes them.
    covariance : ndarray of shape (d, d)
        Of standardized numbers within objects, shrunk.
    """

    names: tuple[str, ...]
    shift: Floats
    scale: Floats
    covariance: Floats

    def standardized(self, values: Floats) -> Floats:
        """Return values (n, d) in standard units, cut at six of them; NaN stays."""
        return np.clip((values - self.shift) / self.scale, -_CLIP, _CLIP)

    @cached_property
    def whitening(self) -> Floats:
        """Matrix (d, d) whose product with a row of standard units is white within objects."""
        lower = np.linalg.cholesky(self.covariance)
        return np.linalg.solve(lower, np.eye(len(lower))).T

    def mapped(self, map_: Floats) -> Self:
        """Return the metric whose whitening is this one's and then a map (d, d), which must be invertible.

        :meta private:
        """
        back = np.linalg.inv(self.whitening @ map_)
        covariance = back.T @ back
        return replace(self, covariance=(covariance + covariance.T) / 2)

    def of(self, known: NDArray[np.bool_]) -> Self:
        """Return the metric of the known numbers alone; of the last few choices it is made once.

        :meta private:
        """
        if known.all():
            return self
        key = known.tobytes()
        if key not in self._parts:
            if len(self._parts) >= _MOST_PARTS:
                self._parts.clear()
            self._parts[key] = self._part(known)
        return self._parts[key]

    @cached_property
    def _parts(self) -> dict[bytes, Self]:
        return {}

    def _part(self, known: NDArray[np.bool_]) -> Self:
        names = tuple(name for name, kept in zip(self.names, known, strict=True) if kept)
        return replace(
            self,
            names=names,
            shift=self.shift[known],
            scale=self.scale[known],
            covariance=self.covariance[np.ix_(known, known)],
        )


def fit_metric(
    names: tuple[str, ...],
    values: Floats,
    owner: NDArray[np.int64],
    log_size: Floats | None = None,
    *,
    shrink: float | None = None,
) -> Metric:
    """Learn a metric from examples.

    Parameters
    ----------
    names : tuple of str
    values : ndarray of shape (n, d)
        NaN where a number is unknown; it counts as the mean of all.
    owner : ndarray of shape (n,), int
        Which object each example is of.
    log_size : ndarray of shape (n,), optional
        Logarithm of each example's size: what changes evenly with it within an object is no scatter, where the object
        has more than eight examples and all of their sizes are known. NaN: unknown.
    shrink : float, optional
        Share of the total variance that is added to every number's own. Default: `shrinkage` of these examples.

    Raises
    ------
    InputError
        If there is no example.
    """
    fits = values.ndim == 2 and values.shape[1] == len(names) and len(values) > 0
    require(fits, f"a metric of {len(names)} numbers needs examples of shape (n, {len(names)}), n >= 1")
    known = np.isfinite(values)
    count = np.maximum(known.sum(axis=0), 1)
    # In parts of each number's largest, which may be that of a picofarad or of a count of 64 bits.
    largest = np.where(known, np.abs(values), 0.0).max(axis=0)
    unit = np.where(largest > 0, largest, 1.0)
    parts = np.where(known, values, 0.0) / unit
    mean = parts.sum(axis=0) / count
    spread = np.sqrt(np.where(known, (parts - mean) ** 2, 0.0).sum(axis=0) / count)
    shift, scale = mean * unit, np.where(spread > _CONSTANT, spread * unit, 1.0)
    metric = Metric(names, shift, scale, np.eye(len(names)))
    rest, free = _within(metric, values, owner, log_size)
    covariance = rest.T @ rest / free
    added = shrinkage(len(names), owner, log_size) if shrink is None else shrink
    return Metric(names, shift, scale, covariance + added * np.eye(len(names)))


def shrinkage(numbers: int, owner: NDArray[np.int64], log_size: Floats | None = None) -> float:
    """Return the share of the total variance that is added to each of so many numbers' own.

    Few examples of many numbers make directions look narrow that are not.

    Parameters
    ----------
    numbers : int
    owner : ndarray of shape (n,), int
        Which object each example is of.
    log_size : ndarray of shape (n,), optional
        As for `fit_metric`.
    """
    told = sum(_basis(owner == k, log_size).shape[1] for k in np.unique(owner))
    return float(_SHRINK * (1 + numbers / max(len(owner) - told, 1)))


def _within(metric: Metric, values: Floats, owner: NDArray[np.int64], log_size: Floats | None) -> tuple[Floats, int]:
    """Return the rests of examples in their object, and how many of them are free."""
    units = np.nan_to_num(metric.standardized(values), nan=0.0, posinf=0.0, neginf=0.0)
    rest, free = np.zeros_like(units), len(units)
    for k in np.unique(owner):
        rows = owner == k
        basis = _basis(rows, log_size)
        rest[rows] = units[rows] - basis @ np.linalg.lstsq(basis, units[rows], rcond=None)[0]
        free -= basis.shape[1]
    return rest, max(free, 1)


def _basis(rows: NDArray[np.bool_], log_size: Floats | None) -> Floats:
    """Return what an object's numbers are told by: their mean, or a curve over its examples' sizes."""
    n = int(rows.sum())
    # Of sizes of which one is NaN the range is NaN too.
    if log_size is not None and n > _FEW and np.ptp(log_size[rows]) > _ONE_SIZE:
        return np.asarray(np.vander(log_size[rows], 3))
    return np.ones((n, 1))
