"""Scatter, sizes and ranges that are learned from few examples, from unknown numbers and at their limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.perceive import Belief, Evidence, Library, NameEvidence
from varishold.perceive.library import LOG_SIZES
from varishold.perceive.metric import fit_metric
from varishold.perceive.name_evidence import names_in_words
from varishold.perceive.size_model import fit_size_model

# The metric


def scatter(values: np.ndarray, log_size: np.ndarray) -> float:
    """Scatter of the first number of one object's examples."""
    owner = np.zeros(len(values), np.int64)
    return float(fit_metric(("a",), values[:, None], owner, log_size, shrink=0.0).covariance[0, 0])


@pytest.mark.parametrize(("n", "told"), [(4, False), (8, False), (9, True), (20, True)])
def test_what_changes_with_size_is_told_from_scatter_by_more_than_eight_examples(n: int, told: bool) -> None:
    log_size = np.linspace(-3.0, -2.0, n)
    # Divided by n less one for the mean.
    assert scatter(4 * log_size, log_size) == pytest.approx(0.0 if told else n / (n - 1), abs=1e-9)


@pytest.mark.parametrize(("spread", "told"), [(0.0, False), (0.045, False), (0.055, True)])
def test_sizes_that_are_nearly_one_do_not_tell_what_changes_with_size(spread: float, told: bool) -> None:
    log_size = np.linspace(-3.0, -3.0 + spread, 12)
    values = np.linspace(0, 1, 12)
    assert scatter(values, log_size) == pytest.approx(0.0 if told else 12 / 11, abs=1e-6)


def test_a_size_that_is_unknown_leaves_its_object_as_if_none_was_known() -> None:
    rng = np.random.default_rng(0)
    owner, log_size = np.repeat([0, 1], 12), np.tile(np.linspace(-3, -2, 12), 2)
    values = rng.normal(0, 0.1, (24, 2)) + np.outer(log_size, [3, -2])
    part = log_size.copy()
    part[3] = np.nan
    none = np.where(owner == 0, np.nan, log_size)
    metrics = [fit_metric(("a", "b"), values, owner, sizes) for sizes in (part, none, log_size)]
    np.testing.assert_allclose(metrics[0].covariance, metrics[1].covariance)
    assert metrics[2].covariance[0, 0] < metrics[0].covariance[0, 0]
    every = np.full(24, np.nan)
    np.testing.assert_array_equal(
        fit_metric(("a", "b"), values, owner, every).covariance, fit_metric(("a", "b"), values, owner).covariance
    )


def test_a_number_that_is_unknown_counts_as_the_mean_of_all() -> None:
    owner = np.array([0, 0, 0, 1, 1, 1])
    a, b = np.array([1.0, 2.0, np.nan, 6.0, 8.0, 7.0]), np.array([0.0, 1.0, 1.0, 0.0, 0.0, 1.0])
    metric = fit_metric(("a", "b"), np.column_stack([a, b]), owner, shrink=0.0)
    assert metric.shift[0] == pytest.approx(4.8)
    assert metric.scale[0] == pytest.approx(np.nanstd(a))
    filled = (np.nan_to_num(a, nan=4.8) - 4.8) / np.nanstd(a)
    within = sum(np.var(filled[owner == k]) * 3 for k in (0, 1)) / 4
    assert metric.covariance[0, 0] == pytest.approx(within)


def test_a_number_that_one_example_alone_knows_is_its_mean() -> None:
    values = np.column_stack([[np.nan, 3.0, np.nan], [1.0, 2.0, 6.0], [np.nan] * 3])
    metric = fit_metric(("a", "b", "c"), values, np.zeros(3, np.int64))
    assert metric.shift.tolist() == [3.0, 3.0, 0.0]
    assert metric.scale.tolist() == [1.0, pytest.approx(np.std([1, 2, 6])), 1.0]


@pytest.mark.parametrize(("n", "n_objects"), [(1, 1), (2, 1), (2, 2), (6, 2), (6, 6)])
def test_few_examples_of_many_numbers_are_trusted_less(n: int, n_objects: int) -> None:
    """Added is .2, and .2 a number over the examples that are left when each object's mean is known; one at least."""
    values = np.zeros((n, 3))
    metric = fit_metric(("a", "b", "c"), values, np.arange(n) % n_objects)
    free = max(n - n_objects, 1)
    np.testing.assert_allclose(metric.covariance, 0.2 * (1 + 3 / free) * np.eye(3))


@pytest.mark.parametrize("shape", [(0, 2), (3, 1), (3, 3), (2,)])
def test_a_metrics_examples_have_as_many_numbers_as_it_has_names(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match=r"a metric of 2 numbers needs examples of shape \(n, 2\), n >= 1"):
        fit_metric(("a", "b"), np.zeros(shape), np.zeros(shape[0], np.int64))


# Sizes


def test_a_size_is_told_only_where_every_fitted_size_is_known() -> None:
    rng = np.random.default_rng(1)
    log_size = rng.uniform(-3.2, -2.2, 40)
    fitted = np.column_stack([log_size + rng.normal(0, 0.02, 40), 0.5 * log_size + rng.normal(0, 0.02, 40)])
    model = fit_size_model(("size.a", "size.b"), fitted, log_size, np.arange(40) % 2)
    grid = np.linspace(-4, -1, 7)
    for k in range(2):
        middle = model.line[k, 0] * -2.5 + model.line[k, 1] * -1.2 + model.line[k, 2]
        off = (grid - middle) / model.scale[k]
        expected = -2 * np.log(1 + off**2 / 3) - np.log(model.scale[k])
        np.testing.assert_allclose(model.log_likelihood(np.array([-2.5, -1.2]), grid)[k], expected)
    for lacking in ([np.nan, -1.2], [-2.5, np.nan], [np.nan, np.nan]):
        np.testing.assert_array_equal(model.log_likelihood(np.array(lacking), grid), np.zeros((2, 7)))


def test_a_million_scales_off_all_sizes_are_alike() -> None:
    model = fit_size_model(("size.a",), np.array([[-3.0], [-2.0]]), np.array([-3.0, -2.0]), np.zeros(2, np.int64))
    least = -2 * np.log1p(1e12 / 3) - np.log(model.scale[0])
    for absurd in (1e9, -1e9, 1e200):
        told = model.log_likelihood(np.array([absurd]), np.array([-3.0, -2.0]))
        np.testing.assert_allclose(told, least)
    near = model.log_likelihood(np.array([0.9e6 * model.scale[0]]), np.array([-3.0, -2.0]))
    assert (near > least + 0.1).all()


def test_steps_of_size_are_told_by_the_mean_over_each() -> None:
    rng = np.random.default_rng(7)
    log_size = rng.uniform(-3.2, -2.2, 160)
    # One object is told to .4 %, as with the quantiles of what it is off, and the other to a tenth.
    fitted = log_size + rng.normal(0, np.where(np.arange(160) % 2, 0.1, 0.001))
    model = fit_size_model(("size.a",), fitted[:, None], log_size, np.arange(160) % 2)
    for model_of_one in (model, replace(model, off=np.zeros_like(model.off))):
        for step in (0.003, 0.025, 0.2):
            grid = -4 + step * np.arange(9)
            parts = (grid[:, None] + step * ((np.arange(2000) + 0.5) / 2000 - 0.5)).ravel()
            for value in (-4.0, -3.9, -3.99, -2.0, 40.0):
                fine = np.exp(model_of_one.log_likelihood(np.array([value]), parts)).reshape(2, 9, 2000)
                told = model_of_one.log_likelihood_of_steps(np.array([value]), grid)
                np.testing.assert_allclose(told, np.log(fine.mean(axis=2)), atol=1e-3)
    assert not model.log_likelihood_of_steps(np.array([np.nan]), grid).any()
    for absurd in (1e9, -1e9, 1e200):
        alike = model.log_likelihood_of_steps(np.array([absurd]), np.array([-3.0, -2.9, -2.8]))
        assert np.isfinite(alike).all()
        np.testing.assert_allclose(np.ptp(alike, axis=1), 0, atol=1e-9)


def test_where_a_size_lies_between_two_that_are_told_apart_says_nothing_of_the_name() -> None:
    """Of a ball sizes are told to a fifth of a step and better, of a cone to no step."""
    rng = np.random.default_rng(8)
    sizes = np.exp(rng.uniform(np.log(0.05), np.log(0.11), (2, 200)))
    told = np.log(sizes) + rng.normal(size=(2, 200)) * [[0.001], [0.06]]
    rows = [[[Evidence("grasp", {"a": rng.normal(), "size.a": value})] for value in of] for of in told]
    of = Library.from_examples(
        dict(zip(("ball", "cone"), rows, strict=True)), sizes_m={"ball": sizes[0], "cone": sizes[1]}
    )
    between = np.log(0.07) + (LOG_SIZES[1] - LOG_SIZES[0]) * np.linspace(0, 1, 21)
    beliefs = [Belief.before(of).after(Evidence("grasp", {"a": 0.0, "size.a": value})) for value in between]
    odds = [belief.probability["ball"] / belief.probability["cone"] for belief in beliefs]
    assert np.ptp(np.log(odds)) < 0.05
    middle, low, high = np.array([belief.size("ball") for belief in beliefs], dtype=float).T
    assert (low < np.exp(between)).all()
    assert (np.exp(between) < high).all()
    assert np.abs(np.log(middle) - between).max() < 0.015
    assert np.log(high / low).max() < 0.06


def test_an_object_without_sizes_is_left_out_of_what_sizes_say() -> None:
    fitted = np.linspace(-3, -2, 10)[:, None]
    owner = np.repeat([0, 1], 5)
    model = fit_size_model(("size.a",), fitted, np.where(owner == 0, np.nan, fitted[:, 0]), owner)
    assert np.isnan(model.line[0]).all()
    assert model.line.shape == (2, 2)
    assert np.isnan(model.scale[0])
    # A line through points that lie on it is trusted to .004, and a ridge of a thousandth is all that bends it.
    assert model.scale[1] == 0.004
    np.testing.assert_allclose(model.line[1], [1.0, 0.0], atol=1e-9)
    told = model.log_likelihood(np.array([-2.5]), np.array([-2.5, -2.4]))
    assert not told[0].any()
    assert told[1, 0] > told[1, 1]


# Answers of others


def test_an_answer_is_kept_as_it_was_given_in_numbers_of_its_own() -> None:
    given, prior = {"ball": 0.75, "box": 0.25}, {"ball": 0.5, "box": 0.5}
    answer = NameEvidence("camera", given, prior)
    given["ball"], prior["box"] = 0.0, 0.0
    assert (answer.probability, answer.prior) == ({"ball": 0.75, "box": 0.25}, {"ball": 0.5, "box": 0.5})
    whole = NameEvidence("camera", {"ball": 1, "box": 0})
    assert [type(p) for p in whole.probability.values()] == [float, float]
    assert whole.prior == {"ball": 0.5, "box": 0.5}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"prior": [0.5, 0.5]}, "prior of 'camera' must be numbers by name, got list"),
        ({"prior": {"ball": 0.5, "box": 0.6}}, "prior of 'camera' must be from 0 to 1 and sum to 1, got"),
        ({"prior": {"ball": 0.5, "egg": 0.5}}, "prior of 'camera' must be above 0 for each of ball, box, got it for"),
        ({"source": 3}, "who says a name must have a name, got 3"),
        ({"source": ""}, "who says a name must have a name, got ''"),
    ],
)
def test_what_is_wrong_with_an_answer_is_told_by_its_name(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        NameEvidence(**{"source": "camera", "probability": {"ball": 0.5, "box": 0.5}, **arguments})


def test_the_names_of_one_who_knows_few_are_all_listed() -> None:
    assert [names_in_words("abcde"[:n]) for n in range(6)] == [
        "",
        "a",
        "a, b",
        "a, b, c",
        "a, b, c, d",
        "a, b, c, d and 1 more",
    ]
