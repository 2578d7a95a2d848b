"""Taxels that read too much or too little: told by many presses all over the pad, and evened out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from varishold.frame.fault import Floats, Mask
from varishold.frame.press_places import press_places
from varishold.frame.spread import spread_over

__all__ = ["taxel_gains"]

# Presses below which a taxel's own gain cannot be told from the form of what presses.
_FEWEST_PRESSES = 12
# Lines of a pad that are told; of more taxels than so many presses are too few, and no more readings are looked at.
_FEWEST_LINES, _MOST_TAXELS, _MOST_VALUES = 4, 1 << 14, 1 << 19
# Two halves of the presses agree on this share of what either finds, gains spread by so much, in so many taxels.
_AGREEMENT, _LEAST, _FEWEST_TAXELS = 0.6, 0.04, 16
# Gains scatter about one by so much before anything is known; the logarithm of pressure about a plane by at least so
# much of what it does on the median, and by this.
_USUAL, _OF_SCATTER, _LEAST_SCATTER = 0.1, 0.5, 0.05
# Edges and tips are far outliers: degrees of freedom of the residuals' distribution, rounds of weighing.
_FREEDOM, _ROUNDS = 2.0, 6
# Differences of one press share taxels, so that so many of them say as much as one.
_ALIKE = 4.5
# Steps of a solution at most, and how much of the right-hand side may be left.
_STEPS, _LEFT = 60, 1e-3
_OF_MEDIAN = 1.4826


@dataclass(frozen=True)
class _Stencil:
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
        return _Stencil(tuple((rows, cols, sign**2) for rows, cols, sign in self.parts)).of(values)

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
    _Stencil(tuple((_ALL, cols, sign) for cols, sign in _LINE)),
    _Stencil(tuple((rows, _ALL, sign) for rows, sign in _LINE)),
    _Stencil(tuple((rows, cols, one * other) for rows, one in _PAIR for cols, other in _PAIR)),
)


@dataclass(frozen=True, eq=False)
class _Bends:
    """Differences of presses' log readings at one stencil's places, what noise adds to their variance, and where all
    taxels of a place take part in the press; each of shape (n_presses, ...)."""

    values: Floats
    variance: Floats
    seen: Mask

    def weighed(self, known: Floats) -> tuple[Floats, Floats]:
        """Return the weight of each place's differences, and their weighed sum, where this much is known of gains."""
        if not self.seen.any():
            return np.zeros(known.shape), np.zeros(known.shape)
        left = self.values - known
        # Pressure is rounded off on the mean: what all places share is form, no gain.
        middle = float(np.median(left[self.seen]))
        left -= middle
        scatter = _OF_MEDIAN * float(np.median(np.abs(left[self.seen])))
        variance = _OF_SCATTER * scatter**2 + self.variance + _LEAST_SCATTER**2
        weight = (_FREEDOM + 1) / (_FREEDOM + left**2 / variance) / (_ALIKE * variance)
        weight[~self.seen] = 0.0
        return weight.sum(axis=0), (weight * (self.values - middle)).sum(axis=0)


def taxel_gains(loads: Sequence[Floats], usable: Mask, sigma: float) -> Floats | None:
    """Return how much more or less each taxel reads; None where that is not certain.

    The logarithm of a reading is that of the pressure and of the taxel's gain. Pressure is smooth nearly everywhere,
    and lies elsewhere each time; gains stay. Second differences of the logarithms, weighed so that edges and tips count
    for little, are solved for the gains, with a prior that they scatter about 1. Taxels that are seldom pressed stay
    near 1.

    Parameters
    ----------
    loads : sequence of ndarray of shape (rows, cols), float64
        The strongest frame of each press, zero at rest.
    usable : ndarray of shape (rows, cols), bool
    sigma : float
        Standard deviation of the noise.

    Returns
    -------
    ndarray of shape (rows, cols), float64, or None
        About 1.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> y, x = np.mgrid[:12, :12]
    >>> reads = np.exp(rng.normal(0, 0.1, (12, 12)))
    >>> at = rng.uniform(0, 12, (60, 2))
    >>> balls = [np.maximum(36 - (y - row) ** 2 - (x - col) ** 2, 0.0) ** 0.5 for row, col in at]
    >>> found = taxel_gains([reads * ball for ball in balls], np.ones((12, 12), bool), 0.01)
    >>> bool(np.std(np.log(reads / found)) < 0.5 * np.std(np.log(reads)))
    True
    >>> taxel_gains(balls, np.ones((12, 12), bool), 0.01) is None
    True
    """
    if len(loads) < _FEWEST_PRESSES or min(usable.shape) < _FEWEST_LINES or usable.size > _MOST_TAXELS:
        return None
    some = spread_over(len(loads), max(_MOST_VALUES // usable.size, _FEWEST_PRESSES))
    told = press_places([loads[k] for k in some], usable, sigma)
    if told is None:
        return None
    presses, inside = told
    one, other = (_gains(presses[k::2], inside[k::2], sigma, _USUAL) for k in (0, 1))
    both = inside[::2].any(axis=0) & inside[1::2].any(axis=0)
    if np.count_nonzero(both) < _FEWEST_TAXELS:
        return None
    alike, each = float(np.mean((one * other)[both])), float(np.mean((one**2 + other**2)[both]) / 2)
    if alike < max(_AGREEMENT * each, _LEAST**2):
        return None
    logs = _gains(presses, inside, sigma, alike**0.5)
    return np.asarray(np.exp(logs - np.median(logs[both])))


def _gains(presses: Floats, inside: Mask, sigma: float, spread: float) -> Floats:
    """Return the log gains, of such a spread, that explain second differences best."""
    read = np.where(inside, presses, 1.0)
    logs, variance = np.log(read), (sigma / read) ** 2
    bends = [_Bends(each.of(logs), each.squared(variance), each.everywhere(inside)) for each in _STENCILS]
    gains = np.zeros(presses.shape[1:])
    for _ in range(_ROUNDS):
        weights, right = [], np.zeros(gains.shape)
        for stencil, bend in zip(_STENCILS, bends, strict=True):
            weight, value = bend.weighed(stencil.of(gains))
            weights.append(weight)
            stencil.onto(value, right)
        gains = _solved(weights, right, spread**-2, gains)
    return gains


def _solved(weights: list[Floats], right: Floats, prior: float, begin: Floats) -> Floats:
    """Return the gains that solve the weighed equations, by conjugate gradients scaled by the diagonal."""

    def times(gains: Floats) -> Floats:
        made = prior * gains
        for weight, stencil in zip(weights, _STENCILS, strict=True):
            stencil.onto(weight * stencil.of(gains), made)
        return made

    diagonal = np.full(right.shape, prior)
    for weight, stencil in zip(weights, _STENCILS, strict=True):
        stencil.onto(weight, diagonal, squared=True)
    gains, left = begin, right - times(begin)
    way = scaled = left / diagonal
    size, enough = float((left * scaled).sum()), _LEFT**2 * float((right**2 / diagonal).sum())
    for _ in range(_STEPS):
        if size <= enough:
            break
        turned = times(way)
        step = size / float((way * turned).sum())
        gains, left = gains + step * way, left - step * turned
        scaled = left / diagonal
        before, size = size, float((left * scaled).sum())
        way = scaled + size / before * way
    return gains
