"""A classifier that can be followed with a pencil: a press is one number, a thing the mean of its numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator

from varishold.touch.course.presses import Press

__all__ = ["PlainLearner", "number_of", "press_of"]

Floats = np.ndarray[Any, np.dtype[np.float64]]


def press_of(number: float, place: str = "", **columns: float) -> Press:
    """Return a press of a number: two frames, the second of which holds it."""
    frames = np.array([np.zeros((2, 2)), np.full((2, 2), float(number))])
    return Press({"pad": frames}, {"pad": np.ones((2, 2), bool)}, columns=columns, place=place)


def number_of(press: Press) -> float:
    return float(press.pads["pad"][1, 0, 0])


class PlainLearner(BaseEstimator):  # type: ignore[misc]
    """Likelier the nearer; stranger the farther from the nearest.

    Parameters
    ----------
    sharp : float
    error : float
    """

    #: What every one of them learned from: numbers, things, groups and sharpness.
    learned: list[tuple[list[float], list[Any], list[Any] | None, float]] = []  # noqa: RUF012

    def __init__(self, sharp: float = 1.0, error: float = 0.2, shape: tuple[int, ...] | None = None) -> None:
        self.sharp, self.error, self.shape = sharp, error, shape

    def learned_from(self, presses: Sequence[Press]) -> NDArray[np.bool_]:
        """None of them: it keeps no press."""
        return np.zeros(len(presses), np.bool_)

    def fit(self, presses: Sequence[Press], y: Any, groups: Any = None) -> PlainLearner:
        """Learn the means."""
        numbers, things = np.array([number_of(press) for press in presses]), np.asarray(y)
        self.classes_ = np.unique(things)
        self.means_ = [float(numbers[things == thing].mean()) for thing in self.classes_]
        self.places_ = np.array([press.place for press in presses])
        self.chosen_ = {"sharp": 1.0 + len(things)}
        asked = None if groups is None else np.asarray(groups).tolist()
        PlainLearner.learned.append((numbers.tolist(), things.tolist(), asked, self.sharp))
        return self

    def judge(self, presses: Sequence[Press]) -> tuple[Floats, Floats]:
        """Return probabilities and p-values."""
        rows, p_values = [], []
        for press in presses:
            off = [abs(number_of(press) - mean) for mean in self.means_]
            weights = [math.exp(-self.sharp * one) for one in off]
            rows.append([weight / sum(weights) for weight in weights])
            p_values.append(math.exp(-min(off) * self.sharp))
        return np.array(rows), np.array(p_values)

    def predict_proba(self, presses: Sequence[Press]) -> Floats:
        """Return the probability of each thing."""
        return self.judge(presses)[0]

    def p_values(self, presses: Sequence[Press]) -> Floats:
        """Return the p-value of each press."""
        return self.judge(presses)[1]
