"""How surprising the true classes of held-out presses were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.trust import class_weights

__all__ = ["mean_loss"]

Floats = NDArray[np.float64]


def mean_loss(said: Floats, truth: NDArray[np.intp]) -> float:
    """Return the log loss in nats, where a class counts as the root of how often it was pressed.

    Parameters
    ----------
    said : ndarray of shape (n, n_classes), float64
        Log-probabilities.
    truth : ndarray of shape (n,), int
        The class of each.
    """
    return float(-said[np.arange(len(truth)), truth] @ class_weights(truth)) / len(truth)
