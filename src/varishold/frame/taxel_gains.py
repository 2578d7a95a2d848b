"""Taxels that read too much or too little: told by many presses all over the pad, and evened out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from varishold.frame.bends import Weighed, bends_of
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
# Gains scatter about one by so much before anything is known.
_USUAL = 0.1
# Edges and tips are far outliers: degrees of freedom of the residuals' distribution, rounds of weighing.
_FREEDOM, _ROUNDS = 2.0, 6
# Steps of a solution at most, and how much of the right-hand side may be left.
_STEPS, _LEFT = 60, 1e-3


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
    bends = bends_of(presses, inside, np.full(len(presses), sigma))
    gains = np.zeros(presses.shape[1:])
    for _ in range(_ROUNDS):
        gains = _solved([each.weighed(gains, _FREEDOM) for each in bends], spread**-2, gains)
    return gains


def _solved(equations: list[Weighed], prior: float, begin: Floats) -> Floats:
    """Return the gains that solve the weighed equations, by conjugate gradients scaled by the diagonal."""

    def times(gains: Floats) -> Floats:
        made = prior * gains
        for each in equations:
            each.add_times(gains, made)
        return made

    right, diagonal = np.zeros(begin.shape), np.full(begin.shape, prior)
    for each in equations:
        each.add_right(right)
        each.add_diagonal(diagonal)
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
