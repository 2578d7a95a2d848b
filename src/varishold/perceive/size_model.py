"""What the numbers of a touch that tell size say of an object's size."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

__all__ = ["SizeModel", "fit_size_model"]

Floats = NDArray[np.float64]

#: Degrees of freedom of Student's t: a grip that is fitted wrongly must not decide alone.
FREEDOM = 3.0

# How strongly slopes are drawn to that of a fitted size which grows with the size; beside few examples as by one more,
# whose size is another by a third.
_RIDGE, _RIDGE_OF_FEW = 1e-3, 0.1
_ROUNDS = 12
# Farther off, in parts of the scale, all sizes are alike: nobody's hand holds that.
_MOST_OFF = 1e6
# A line is not trusted better than this, in the logarithm of the size; that of one example no better than the second.
_LEAST_SCALE, _SCALE_OF_ONE = 0.004, 0.1
# How far off a line examples lie is kept as so many quantiles, where there are so many examples; each is then spread by
# this part of the scale about the line.
_QUANTILES, _ENOUGH, _SPREAD = 32, 40, 0.6


@dataclass(frozen=True, eq=False)
class SizeModel:
    """For each object a line from the logarithms of fitted sizes to that of its size, and how far off it is.

    A box is at times fitted with its long side for the short one: where it is off, it is off by that, and not anyhow.

    Parameters
    ----------
    names : tuple of str
        Of the numbers: logarithms of sizes in metres.
    line : ndarray of shape (n_objects, m + 1)
        Slopes and offset; NaN for objects without known sizes.
    scale : ndarray of shape (n_objects,)
        How far off it an example lies: the scale of Student's t about it, or a larger one than about each of `off`.
    off : ndarray of shape (n_objects, n_quantiles)
        How far the size is from the line, in quantiles that are as likely; zeros where that is Student's t alone.
    """

    names: tuple[str, ...]
    line: Floats
    scale: Floats
    off: Floats

    def log_likelihood(self, values: Floats, log_sizes: Floats) -> Floats:
        """Log-likelihood of a touch under each object and size.

        Parameters
        ----------
        values : ndarray of shape (m,)
        log_sizes : ndarray of shape (n_sizes,)

        Returns
        -------
        ndarray of shape (n_objects, n_sizes)
            Zeros where a number is not known.
        """
        at, scale = self._said(values)
        away = (log_sizes[None, None, :] - at[:, :, None]) / scale[:, None, None]
        of_each = (1 + np.clip(away, -_MOST_OFF, _MOST_OFF) ** 2 / FREEDOM) ** (-0.5 * (FREEDOM + 1))
        return _told(of_each, scale)

    def log_likelihood_of_steps(self, values: Floats, log_sizes: Floats) -> Floats:
        """As `log_likelihood`, on the mean over steps that are as wide as they are apart, with the sizes as middles.

        Steps may be wider than what a touch tells. By their middles alone a name would be likelier or not by where
        between two of them the size lies.
        """
        at, scale = self._said(values)
        away = (log_sizes[None, None, :] - at[:, :, None]) / scale[:, None, None]
        wide = (np.gradient(log_sizes) / scale[:, None])[:, None, :] / np.sqrt(FREEDOM)
        middle = np.clip(away, -_MOST_OFF, _MOST_OFF) / np.sqrt(FREEDOM)
        # The integral of (1 + u^2)^-2, Student's t of three degrees of freedom, from low to high, as of the difference
        # of its values at both, which far off are as good as one.
        low, high = middle - wide / 2, middle + wide / 2
        between = np.arctan2(wide, 1 + low * high)
        between += wide * (1 - low * high) / ((1 + low**2) * (1 + high**2))
        return _told(between / (2 * wide), scale)

    def _said(self, values: Floats) -> tuple[Floats, Floats]:
        """Return about which sizes likelihoods of a touch lie, shape (n_objects, n_quantiles), and how wide."""
        # Summed line by line, so that one object more changes no bit of the others'.
        expected = (self.line[:, :-1] * values).sum(axis=1) + self.line[:, -1]
        scale = np.where(self.off.any(axis=1), np.maximum(_SPREAD * self.scale, _LEAST_SCALE), self.scale)
        return expected[:, None] + self.off, scale

    def with_object(self, values: Floats, log_size: Floats) -> Self:
        """Return a model of one object more, from its examples."""
        line, scale, off = _fit(values, log_size)
        return replace(
            self,
            line=np.vstack([self.line, line]),
            scale=np.append(self.scale, scale),
            off=np.vstack([self.off, off]),
        )

    def only(self, index: list[int]) -> Self:
        """Return a model of some of the objects."""
        return replace(self, line=self.line[index], scale=self.scale[index], off=self.off[index])


def _told(of_each: Floats, scale: Floats) -> Floats:
    """Return the log-likelihood of each object's sizes from that about each quantile; zeros where nothing is known."""
    out = np.log(of_each.mean(axis=1)) - np.log(scale)[:, None]
    return np.where(np.isfinite(out), out, 0.0)


def fit_size_model(names: tuple[str, ...], values: Floats, log_size: Floats, owner: NDArray[np.int64]) -> SizeModel:
    """Fit a line for each object, by ridge regression with the weights of Student's t."""
    fits = [_fit(values[owner == k], log_size[owner == k]) for k in range(int(owner.max()) + 1)]
    line, scale, off = (np.array(part) for part in zip(*fits, strict=True))
    return SizeModel(names, line, scale, off)


def _fit(values: Floats, log_size: Floats) -> tuple[Floats, float, Floats]:
    known = np.isfinite(values).all(axis=1) & np.isfinite(log_size)
    m, n = values.shape[1], int(known.sum())
    if n == 0:
        return np.full(m + 1, np.nan), np.nan, np.zeros(_QUANTILES)
    x, y = values[known], log_size[known]
    if n < _ENOUGH:
        line, _ = _line(x, y, _RIDGE_OF_FEW)
        return line, _scale_of_few(x, y), np.zeros(_QUANTILES)
    line, off = _line(x, y, _RIDGE)
    return line, _scale(off), np.quantile(off, (np.arange(_QUANTILES) + 0.5) / _QUANTILES)


def _line(x: Floats, y: Floats, ridge: float) -> tuple[Floats, Floats]:
    """Return slopes and offset of a line, shape (m + 1,), and how far examples are off it, shape (n,)."""
    m, weight = x.shape[1], np.ones(len(y))
    for _ in range(_ROUNDS):
        total = weight.sum()
        middle_x, middle_y = weight @ x / total, float(weight @ y / total)
        # About the weighted mean, so that where y begins does not matter for the slope.
        dx = x - middle_x
        # One size alone: a fitted size is the size, times a factor.
        slope = np.linalg.solve(
            (dx.T * weight) @ dx + ridge * np.eye(m), (dx.T * weight) @ y + ridge * np.full(m, 1 / m)
        )
        line = np.append(slope, middle_y - middle_x @ slope)
        off = y - x @ slope - line[-1]
        weight = (FREEDOM + 1) / (FREEDOM + (off / _scale(off)) ** 2)
    return line, off


def _scale(off: Floats) -> float:
    return max(_LEAST_SCALE, 1.2 * float(np.median(np.abs(off))) * (1 + 2 / len(off)))


def _scale_of_few(x: Floats, y: Floats) -> float:
    """Return the scale of a line by how far each example is off the line of the others, which bends to none of it."""
    if len(y) == 1:
        return _SCALE_OF_ONE
    off = np.empty(len(y))
    for k in range(len(y)):
        others = np.arange(len(y)) != k
        line, _ = _line(x[others], y[others], _RIDGE_OF_FEW)
        off[k] = y[k] - x[k] @ line[:-1] - line[-1]
    return _scale(off)
