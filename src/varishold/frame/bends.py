"""How presses bend over a pad, and what of it is the taxels' own: second differences of the logarithms of readings.

The logarithm of a reading is that of the pressure and that of the taxel's gain. Pressure is smooth nearly everywhere
and its form changes from press to press, gains stay. Pressure is rounded off, by how high in its contact a place
stands: what all places of one height share is form. It is an unknown of its own, and solved out, so that it says
nothing of the gains, however many presses there are; a slope or a bend of all gains alike is not told by presses.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Mask
from varishold.frame.noise import sigma_of_half

__all__ = ["Bends", "Stencil", "Weighed", "bends_of"]

Indices = NDArray[np.intp]

# Differences of one press share taxels, so that so many of them say as much as one.
_ALIKE = 4.5
# Classes of height.
_HEIGHTS = 8
# The logarithm of pressure scatters about what is shared by so much of what it does on the median, and by this at
# least; below it rounds of weighing run into false minima.
_OF_SCATTER, _LEAST_SCATTER = 0.5, 0.05


@dataclass(frozen=True)
class Stencil:
    """A difference that vanishes on a plane: where its taxels stand, as slices of a pad, and how each counts."""

    parts: tuple[tuple[slice, slice, float], ...]

    def of(self, values: Floats) -> Floats:
        """Return the differences of values of shape (..., rows, cols)."""
        rows, cols, sign = self.parts[0]
        found = sign * values[..., rows, cols]
        for rows, cols, sign in self.parts[1:]:
            found = found + sign * values[..., rows, cols]
        return found

    def squared(self, values: Floats) -> Floats:
        """Return the sums with the squares of how each counts."""
        return Stencil(tuple((rows, cols, sign**2) for rows, cols, sign in self.parts)).of(values)

    def mean(self, values: Floats) -> Floats:
        """Return the mean of the values of a difference's taxels."""
        return Stencil(tuple((rows, cols, 1 / len(self.parts)) for rows, cols, _ in self.parts)).of(values)

    def everywhere(self, where: Mask) -> Mask:
        """Return where all its taxels are some of these."""
        return self.squared(where.astype(np.float64)) >= sum(sign**2 for _, _, sign in self.parts)

    def onto(self, values: Floats, pad: Floats, *, squared: bool = False) -> None:
        """Add differences' values to the taxels of a pad that they are made of."""
        for rows, cols, sign in self.parts:
            pad[rows, cols] += (sign**2 if squared else sign) * values


_ALL = slice(None)
_LINE = ((slice(0, -2), 1.0), (slice(1, -1), -2.0), (slice(2, None), 1.0))
_PAIR = ((slice(0, -1), 1.0), (slice(1, None), -1.0))
_STENCILS = (
    Stencil(tuple((_ALL, cols, sign) for cols, sign in _LINE)),
    Stencil(tuple((rows, _ALL, sign) for rows, sign in _LINE)),
    Stencil(tuple((rows, cols, one * other) for rows, one in _PAIR for cols, other in _PAIR)),
)


@dataclass(frozen=True, eq=False)
class Bends:
    """Differences of presses' log readings by one stencil, where all its taxels take part in the press.

    Parameters
    ----------
    stencil : Stencil
    shape : (int, int)
        Of the stencil's places on the pad.
    values, variance : ndarray of shape (n,), float64
        Each difference, and what noise adds to its variance.
    place : ndarray of shape (n,), intp
        Where each is, as an index into the flattened places.
    rises : ndarray of shape (n_heights + 1,), intp
        Where each class of height begins, and the last one ends: classes of as many, by how high in its contact a
        difference stands.
    """

    stencil: Stencil
    shape: tuple[int, int]
    values: Floats
    variance: Floats
    place: Indices
    rises: Indices

    def weighed(self, gains: Floats, freedom: float) -> Weighed:
        """Return how much each place counts, where this much is known of the log gains, shape (rows, cols).

        Edges and tips are far outliers: what is left unexplained is taken to be Student's, of so many degrees of
        freedom.
        """
        left = self.values - self.stencil.of(gains).ravel()[self.place]
        for part in self._classes():
            left[part] -= np.median(left[part]) if left[part].size else 0.0
        scatter = sigma_of_half(left) if left.size else 0.0
        variance = _OF_SCATTER * scatter**2 + self.variance + _LEAST_SCATTER**2
        weight = (freedom + 1) / (freedom + left**2 / variance) / (_ALIKE * variance)
        weights, sums = self._at_places(weight), self._at_places(weight * self.values)
        return Weighed(self.stencil, weights, (sums - weights * _shared(weights, sums)).sum(axis=0))

    def _classes(self) -> list[slice]:
        """Return the differences of each class of height."""
        return [slice(begin, end) for begin, end in pairwise(self.rises.tolist())]

    def _at_places(self, values: Floats) -> Floats:
        """Return the sums at each place of each class of height, shape (n_heights, n_rows, n_cols)."""
        n_places = self.shape[0] * self.shape[1]
        sums = [np.bincount(self.place[part], values[part], n_places) for part in self._classes()]
        return np.array(sums, np.float64).reshape(-1, *self.shape)


@dataclass(frozen=True, eq=False)
class Weighed:
    """Weighed equations for the log gains, of one stencil.

    Parameters
    ----------
    stencil : Stencil
    weight : ndarray of shape (n_heights, n_rows, n_cols), float64
        Of all presses together, in each class of height.
    value : ndarray of shape (n_rows, n_cols), float64
        The weighed differences, less what each class of height shares.
    """

    stencil: Stencil
    weight: Floats
    value: Floats

    def add_times(self, gains: Floats, made: Floats) -> None:
        """Add the normal equations' left side at these log gains to a pad's, shape (rows, cols)."""
        bends = self.stencil.of(gains)
        self.stencil.onto((self.weight * (bends - _shared(self.weight, self.weight * bends))).sum(axis=0), made)

    def add_right(self, made: Floats) -> None:
        """Add their right side to a pad's."""
        self.stencil.onto(self.value, made)

    def add_diagonal(self, made: Floats) -> None:
        """Add the diagonal of their matrix to a pad's, without what is solved out."""
        self.stencil.onto(self.weight.sum(axis=0), made, squared=True)

    def matrix(self, shape: tuple[int, int]) -> Floats:
        """Return their matrix, shape (n_taxels, n_taxels), for a pad of this shape."""
        number = np.arange(shape[0] * shape[1]).reshape(shape)
        taxels = [(number[rows, cols].ravel(), sign) for rows, cols, sign in self.stencil.parts]
        weight = self.weight.reshape(len(self.weight), -1)
        made, shared = np.zeros((number.size, number.size)), np.zeros((len(weight), number.size))
        for one, sign in taxels:
            shared[:, one] += sign * weight
            for other, its in taxels:
                made[one, other] += sign * its * weight.sum(axis=0)
        made -= shared.T @ (shared / np.maximum(weight.sum(axis=1, keepdims=True), 1e-300))
        return made


def _shared(weight: Floats, sums: Floats) -> Floats:
    """Return the weighed mean of each class of height, shape (n_heights, 1, 1), from weighed sums of places."""
    total, value = (each.sum(axis=(1, 2), keepdims=True) for each in (weight, sums))
    mean: Floats = value / np.maximum(total, 1e-300)
    return mean


def bends_of(presses: Floats, inside: Mask, noise: Floats) -> list[Bends]:
    """Return how presses bend, by each stencil.

    Parameters
    ----------
    presses : ndarray of shape (n_presses, rows, cols), float64
        Readings above rest.
    inside : ndarray of shape (n_presses, rows, cols), bool
        Where each presses; readings there are positive.
    noise : ndarray of shape (n_presses,), float64
        Standard deviation of the noise of each.
    """
    read = np.where(inside, presses, 1.0)
    logs, variance = np.log(read), (noise[:, None, None] / read) ** 2
    # What presses nowhere has no place.
    peaks = np.where(inside, logs, -np.inf).max(axis=(1, 2), keepdims=True)
    below = logs - np.where(np.isfinite(peaks), peaks, 0.0)
    found = []
    for stencil in _STENCILS:
        seen = stencil.everywhere(inside)
        order = np.argsort(stencil.mean(below)[seen], kind="stable")
        _, rows, cols = np.nonzero(seen)
        found.append(
            Bends(
                stencil,
                (seen.shape[1], seen.shape[2]),
                stencil.of(logs)[seen][order],
                stencil.squared(variance)[seen][order],
                (rows * seen.shape[2] + cols)[order],
                np.linspace(0, order.size, _HEIGHTS + 1).astype(np.intp),
            )
        )
    return found
