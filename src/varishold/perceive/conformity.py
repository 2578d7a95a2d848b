"""How usual it is that a touch of an object conforms no better: its own examples say it, those of its size most."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.trust import conformal_p_value

__all__ = ["Calibration"]

Floats = NDArray[np.float64]

# Examples whose sizes are that near, in logarithm, say what is usual at a size; only where there are so many examples.
_NEAR, _LEAST = 0.2, 40


@dataclass(frozen=True, eq=False)
class Calibration:
    """The conformity of an object's own examples, which that of a new touch is ranked among.

    Small things conform worse than large ones: fewer taxels feel them. Where sizes are known, what is ranked is by how
    much a touch conforms better or worse than is usual at its size. A small thing is then refused no more often than a
    large one, and a large stranger is not excused by what small things do.

    Parameters
    ----------
    scores : ndarray of shape (n_examples,)
        What each of its own examples reaches, in the library's order; NaN where the touch was not made.
    log_size : ndarray of shape (n_examples,), optional
        Logarithm of the examples' sizes.
    """

    scores: Floats
    log_size: Floats | None = None

    def surprisal(self, scores: ArrayLike, log_size: float | None = None) -> Floats:
        """Return minus the logarithm of the conformal p-value of touches with these conformities, at a size."""
        of = np.asarray(scores, dtype=np.float64)
        return _surprisal(of, self.scores) if log_size is None else _surprisal(of - self._usual_at(log_size), self._off)

    def of_examples(self, *, sized: bool = False) -> Floats:
        """Return the surprisal of each of its examples, at its own size or at any; NaN where the touch was not made."""
        return self._at_own_size if sized else self._at_any_size

    @cached_property
    def _at_any_size(self) -> Floats:
        return _among_themselves(self.scores)

    @cached_property
    def _at_own_size(self) -> Floats:
        return _among_themselves(self._off)

    @cached_property
    def _sized(self) -> Floats | None:
        """The logarithms of sizes, where they say what is usual at each."""
        do = self.log_size is not None and np.isfinite(self.log_size).all()
        return self.log_size if do and np.isfinite(self.scores).sum() >= _LEAST else None

    @cached_property
    def _off(self) -> Floats:
        """By how much each example conforms better than the others usually do at its size."""
        if self._sized is None:
            return self.scores
        weight = _nearness(self._sized, self._sized)
        np.fill_diagonal(weight, 0.0)
        return self.scores - _mean(weight, self.scores)

    def _usual_at(self, log_size: float) -> float:
        if self._sized is None:
            return 0.0
        inside = np.clip(log_size, self._sized.min(), self._sized.max())
        return float(_mean(_nearness(np.array([inside]), self._sized), self.scores)[0])


def _among_themselves(scores: Floats) -> Floats:
    return np.where(np.isfinite(scores), _surprisal(scores, scores), np.nan)


def _surprisal(scores: Floats, known: Floats) -> Floats:
    return np.asarray(-np.log(conformal_p_value(-scores, -known[np.isfinite(known)])))


def _nearness(at: Floats, log_size: Floats) -> Floats:
    out: Floats = np.exp(-0.5 * ((at[:, None] - log_size) / _NEAR) ** 2)
    return out


def _mean(weight: Floats, scores: Floats) -> Floats:
    """Weighted mean of the scores that are known; where none is near, of all."""
    made = np.isfinite(scores)
    weight = weight[:, made] + 1e-12
    out: Floats = weight @ scores[made] / weight.sum(axis=1)
    return out
