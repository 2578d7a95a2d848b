"""Scores: what a set of answers was worth, from probabilities and the truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.evaluation.figures import Figure, mean_figure, overstated_figure, share_figure
from varishold.trust import share_interval

__all__ = ["Answers", "Bin", "Scores", "calibration_error", "refusal_curve", "reliability", "score"]

Floats = NDArray[np.float64]

#: An answer is called sure above this probability.
SURE = 0.9
_BINS = 10
# A truth that was given no probability at all costs no more than this.
_LEAST = 1e-12
_CURVE_POINTS = 20


@dataclass(frozen=True, eq=False)
class Answers:
    """What was said of presses of known things.

    Parameters
    ----------
    probabilities : ndarray of shape (n, n_classes), float64
    truth : ndarray of shape (n,), int
        The class of each.
    refused : ndarray of shape (n,), bool
        Whether it was said to be none of the classes.
    groups : ndarray of shape (n,), optional
    """

    probabilities: Floats
    truth: NDArray[np.intp]
    refused: NDArray[np.bool_]
    groups: NDArray[Any] | None

    @property
    def right(self) -> NDArray[np.bool_]:
        """Which answers are right, refused or not."""
        return np.asarray(self.probabilities.argmax(axis=1) == self.truth)

    @property
    def top(self) -> Floats:
        """The probability of each answer."""
        return np.asarray(self.probabilities.max(axis=1))


@dataclass(frozen=True)
class Bin:
    """Answers of about one probability: how many, their mean probability, the share right and its interval."""

    n: int
    probability: float
    right: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Scores:
    """What answers were worth.

    Parameters
    ----------
    right : Figure
        Share of right answers.
    macro_recall : float
        Mean over the classes of the share of right answers.
    log_loss : Figure
        Nats.
    calibration_error : float
        Mean distance of stated probability and share right over ten bins.
    overstated : Figure
        Mean stated probability less the share right.
    sure, sure_right : Figure or None
        Share of answers with p > .9, and the share of right ones among these.
    refused : Figure
        Share of presses of known things that are refused as none of these.
    kept_right : Figure or None
        Share of right answers among those not refused.
    confusion : ndarray of shape (n_classes, n_classes), int
        Rows are the truth, columns what was said.
    reliability : tuple of Bin
    refusals : tuple of (float, float)
        Share of presses refused, the least sure ones, and share of errors among the rest.
    """

    right: Figure
    macro_recall: float
    log_loss: Figure
    calibration_error: float
    overstated: Figure
    sure: Figure
    sure_right: Figure | None
    refused: Figure
    kept_right: Figure | None
    confusion: NDArray[np.intp]
    reliability: tuple[Bin, ...]
    refusals: tuple[tuple[float, float], ...]


def score(answers: Answers) -> Scores:
    """Return what answers were worth; there must be at least one."""
    truth, groups, right, top = answers.truth, answers.groups, answers.right, answers.top
    n_classes = answers.probabilities.shape[1]
    given = np.maximum(answers.probabilities[np.arange(len(truth)), truth], _LEAST)
    confusion = np.zeros((n_classes, n_classes), dtype=np.intp)
    np.add.at(confusion, (truth, answers.probabilities.argmax(axis=1)), 1)
    counts = confusion.sum(axis=1)
    sure = top > SURE

    def among(rows: NDArray[np.bool_]) -> Figure | None:
        return share_figure(right[rows], None if groups is None else groups[rows]) if rows.any() else None

    return Scores(
        right=share_figure(right, groups),
        macro_recall=float((np.diag(confusion)[counts > 0] / counts[counts > 0]).mean()),
        log_loss=mean_figure(-np.log(given), groups),
        calibration_error=calibration_error(top, right),
        overstated=overstated_figure(top, right, groups),
        sure=share_figure(sure, groups),
        sure_right=among(sure),
        refused=share_figure(answers.refused, groups),
        kept_right=among(~answers.refused),
        confusion=confusion,
        reliability=reliability(top, right),
        refusals=refusal_curve(top, right),
    )


def calibration_error(top: Floats, right: NDArray[np.bool_]) -> float:
    """Return the mean distance of stated probability and share right, over ten bins of equal width.

    References
    ----------
    M. Naeini, G. Cooper and M. Hauskrecht, "Obtaining well calibrated probabilities using Bayesian binning", 2015.

    Examples
    --------
    >>> round(calibration_error(np.array([0.95, 0.85]), np.array([True, False])), 6)
    0.45
    """
    apart = [one.n * abs(one.probability - one.right) for one in reliability(top, right)]
    return float(sum(apart) / max(len(top), 1))


def reliability(top: Floats, right: NDArray[np.bool_]) -> tuple[Bin, ...]:
    """Return the ten bins of stated probability that hold any answer."""
    place = np.minimum((top * _BINS).astype(int), _BINS - 1)
    found = []
    for k in np.unique(place):
        inside = place == k
        hits, n = int(right[inside].sum()), int(inside.sum())
        found.append(Bin(n, float(top[inside].mean()), hits / n, *share_interval(hits, n)))
    return tuple(found)


def refusal_curve(top: Floats, right: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Return how many errors are left where the least sure answers are refused.

    Answers of equal probability are refused in the order in which they stand.

    Examples
    --------
    >>> curve = refusal_curve(np.array([0.9, 0.5]), np.array([True, False]))
    >>> curve[0], curve[-1]
    ((0.0, 0.5), (0.5, 0.0))
    """
    order = np.argsort(-top, kind="stable")
    errors = np.cumsum(~right[order])
    n = len(top)
    kept = np.unique(np.ceil(n * np.arange(1, _CURVE_POINTS + 1) / _CURVE_POINTS).astype(int))[::-1]
    return tuple((1 - int(k) / n, float(errors[k - 1] / k)) for k in kept)
