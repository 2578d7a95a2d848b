"""What examples are judged by: the metric of all others, whatever their order."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.perceive.left_out import metrics_without
from varishold.perceive.metric import Metric, fit_metric, shrinkage

NAMES = ("a", "b", "c")


def drawn(n: int, objects: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(n)
    owner = rng.integers(objects, size=n)
    values = rng.standard_t(3, size=(n, 3)) * (1.0, 1e3, 1e-3) + owner[:, None]
    values[rng.random(values.shape) < 0.1] = np.nan
    return values, owner, rng.uniform(-3.5, -2.0, n)


def told(values: np.ndarray, owner: np.ndarray, log_size: np.ndarray, learned: np.ndarray) -> dict[int, Metric]:
    """The metric by which each example is judged."""
    whole = fit_metric(NAMES, values[learned], owner[learned], log_size[learned])
    by: dict[int, Metric] = {}
    for rows, metric in metrics_without(whole, values, owner, log_size, learned_from=learned):
        assert (np.diff(rows) > 0).all()
        for row in rows.tolist():
            assert row not in by
            by[row] = metric
    assert sorted(by) == list(range(len(values)))
    assert all(by[row] is whole for row in np.flatnonzero(~learned).tolist() if learned.sum() > 1)
    return by


@pytest.mark.parametrize("n", [2, 3, 12, 40, 64])
def test_up_to_sixty_four_examples_are_judged_each_by_the_metric_of_all_others(n: int) -> None:
    values, owner, log_size = drawn(n)
    every = np.ones(n, bool)
    added = shrinkage(3, owner, log_size)
    assert fit_metric(NAMES, values, owner, log_size).covariance.diagonal().min() >= added
    for row, metric in told(values, owner, log_size, every).items():
        rest = np.arange(n) != row
        plain = fit_metric(NAMES, values[rest], owner[rest], log_size[rest], shrink=added)
        np.testing.assert_array_equal(metric.shift, plain.shift)
        np.testing.assert_array_equal(metric.scale, plain.scale)
        np.testing.assert_array_equal(metric.covariance, plain.covariance)


@pytest.mark.parametrize("n", [65, 300, 1000])
def test_of_more_examples_a_sixty_fourth_of_all_and_of_each_object_is_left_out_at_once(n: int) -> None:
    values, owner, log_size = drawn(n)
    metrics = told(values, owner, log_size, np.ones(n, bool))
    lots: dict[int, list[int]] = {}
    for row, metric in metrics.items():
        lots.setdefault(id(metric), []).append(row)
    assert len(lots) == 64
    for rows in lots.values():
        assert len(rows) <= -(-n // 64)
        for k in range(3):
            assert (owner[rows] == k).sum() <= -(-(owner == k).sum() // 64)


@pytest.mark.parametrize("n", [12, 200])
def test_the_order_of_examples_changes_nothing(n: int) -> None:
    values, owner, log_size = drawn(n)
    order = np.random.default_rng(1).permutation(n)
    one = told(values, owner, log_size, np.ones(n, bool))
    other = told(values[order], owner[order], log_size[order], np.ones(n, bool))
    for new, old in enumerate(order.tolist()):
        np.testing.assert_allclose(other[new].covariance, one[old].covariance, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(other[new].scale, one[old].scale)


@pytest.mark.parametrize("learned", [1, 2, 9])
def test_what_the_metric_was_not_learned_from_is_judged_by_it_as_it_is(learned: int) -> None:
    values, owner, log_size = drawn(12)
    told(values, owner, log_size, np.arange(12) >= 12 - learned)
