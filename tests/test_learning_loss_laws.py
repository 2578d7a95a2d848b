"""Laws of the loss of held-out presses."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.learning.loss import mean_loss


@pytest.mark.parametrize("n_classes", [2, 3, 7])
def test_guessing_loses_the_logarithm_of_the_number_of_classes(n_classes: int) -> None:
    truth = np.arange(20) % n_classes
    said = np.full((20, n_classes), -np.log(n_classes))
    assert mean_loss(said, truth) == pytest.approx(np.log(n_classes))


def test_a_class_counts_as_the_root_of_how_often_it_was_pressed() -> None:
    truth = np.array([0] * 16 + [1] * 4)
    said = np.log(np.where(truth[:, None] == 1, [[0.8, 0.2]], [[1.0, 1e-300]]))
    # Counted alike the loss would be a fifth of that of the second class; it is 2 of 4 + 2.
    assert mean_loss(said, truth) == pytest.approx(-np.log(0.2) * 2 / 6)
