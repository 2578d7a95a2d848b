"""Laws of bisectors, sign tables and smallest separating sets."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from varishold.circuit import Hyperplane
from varishold.errors import InputError
from varishold.grasp import (
    Hyperplanes,
    SignTable,
    bisectors,
    minimal_table,
    reduced_table,
    separating_set,
    smallest_hyperplanes,
    smallest_sets,
    training_grasps,
)
from varishold.grasp.likelihood import hamming
from varishold.grasp.separating import equal_columns, greedy_cover

Patterns = NDArray[np.bool_]
two_patterns = arrays(np.bool_, (2, 9)).filter(lambda p: bool((p[0] != p[1]).any()))


@given(two_patterns, arrays(np.bool_, (5, 9)))
def test_a_bisector_is_nearer_to_its_first_pattern(pair: Patterns, X: Patterns) -> None:
    plane = bisectors(pair[:1], pair[1:], orient=False)
    distance = hamming(X, pair)
    np.testing.assert_array_equal(plane.signs(X)[:, 0], distance[:, 0] < distance[:, 1])


@given(two_patterns, arrays(np.bool_, (5, 9)))
def test_an_oriented_bisector_does_not_depend_on_which_pattern_comes_first(pair: Patterns, X: Patterns) -> None:
    one, other = bisectors(pair[:1], pair[1:]), bisectors(pair[1:], pair[:1])
    np.testing.assert_array_equal(one.weights, other.weights)
    larger = max(pair.tolist())
    nearer = hamming(X, np.array([larger])) < hamming(X, np.array([min(pair.tolist())]))
    np.testing.assert_array_equal(one.signs(X), nearer)


@given(two_patterns)
def test_a_tie_gives_zero_for_either_orientation(pair: Patterns) -> None:
    differ = np.flatnonzero(pair[0] != pair[1])
    if len(differ) % 2:
        return
    middle = pair[0].copy()
    middle[differ[::2]] ^= True
    for first, second in ((0, 1), (1, 0)):
        plane = bisectors(pair[first : first + 1], pair[second : second + 1], orient=False)
        assert not plane.signs(middle[None])[0, 0]


@given(two_patterns)
def test_the_coefficients_are_the_equation_22(pair: Patterns) -> None:
    plane = bisectors(pair[:1], pair[1:], orient=False)
    v, w = pair.astype(float)
    np.testing.assert_allclose(plane.coefficients[0, :-1], (v - w) / 2)
    assert plane.coefficients[0, -1] == (v @ v - w @ w) / 4
    assert Hyperplane.between(pair[0].astype(int), pair[1].astype(int)).bias == plane.biases[0]


def test_equal_patterns_have_no_bisector() -> None:
    same = np.ones((1, 3), dtype=bool)
    with pytest.raises(InputError, match="pair 0 holds two equal patterns"):
        bisectors(same, same)


def test_hyperplanes_check_their_parts() -> None:
    with pytest.raises(InputError, match="weights must be -1, 0 or 1"):
        Hyperplanes(np.array([[2, 0]], dtype=np.int8))
    with pytest.raises(InputError, match="1 hyperplane needs as many names and pairs, got 2"):
        Hyperplanes(np.array([[1, 0]], dtype=np.int8), names=("I", "II"))


sign_tables = st.integers(0, 2**32 - 1).map(
    lambda seed: (
        np.random.default_rng(seed).random((7, 6)) < 0.5,
        np.random.default_rng(seed + 1).integers(0, 3, 7),
    )
)


@given(sign_tables)
def test_the_separating_set_is_a_smallest_one(table: tuple[Patterns, NDArray[np.int64]]) -> None:
    signs, labels = table
    apart = [signs[i] != signs[j] for i, j in combinations(range(len(labels)), 2) if labels[i] != labels[j]]
    if not all(column.any() for column in apart):
        with pytest.raises(InputError, match="have equal signs on every hyperplane"):
            separating_set(signs, labels)
        return
    found = separating_set(signs, labels)
    brute = next(
        size
        for size in range(signs.shape[1] + 1)
        if any(all(c[list(s)].any() for c in apart) for s in combinations(range(signs.shape[1]), size))
    )
    assert len(found.columns) == found.lower_bound == brute
    assert all(column[list(found.columns)].any() for column in apart)
    assert found.columns in (smallest_sets(signs, labels, size=brute) or [()])
    greedy = greedy_cover(signs, labels)
    assert len(greedy) >= brute
    assert all(column[greedy].any() for column in apart)


@given(sign_tables, st.integers(0, 5))
def test_kept_columns_stay(table: tuple[Patterns, NDArray[np.int64]], kept: int) -> None:
    signs, labels = table
    try:
        found = separating_set(signs, labels, keep=(kept,))
    except InputError:
        return
    assert kept in found.columns
    assert found.lower_bound <= len(found.columns)


@given(arrays(np.bool_, (4, 6)))
def test_equal_and_complementary_columns_are_one_group(signs: Patterns) -> None:
    groups = equal_columns(signs)
    assert sorted(k for group in groups for k in group) == list(range(6))
    for group in groups:
        for k in group:
            same = (signs[:, k] == signs[:, group[0]]).all()
            opposite = (signs[:, k] != signs[:, group[0]]).all()
            assert same or opposite


@given(sign_tables)
def test_reduced_and_minimal_tables_answer_like_the_sign_table(
    table: tuple[Patterns, NDArray[np.int64]],
) -> None:
    signs, labels = table
    full = SignTable(signs, tuple(labels.tolist()), tuple("ABCDEF"), tuple(range(1, 8)))
    try:
        chosen, selection = smallest_hyperplanes(full)
    except InputError:
        return
    assert len(chosen.hyperplanes) == len(selection.columns)
    reduced = reduced_table(chosen)
    assert len({row.tobytes() for row in reduced.signs}) == len(reduced.grasps)
    minimal = minimal_table(chosen)
    assert len(set(minimal.grasps)) == len(minimal.grasps)
    for row, label in zip(chosen.signs, chosen.labels, strict=True):
        for other in set(chosen.labels):
            true = any(all(row[k] == wanted for k, wanted in term) for term in minimal.terms(other))
            assert true == (other == label)


def test_rows_of_two_classes_with_equal_signs_are_named() -> None:
    table = SignTable(np.ones((2, 1), dtype=bool), ("a", "b"), ("I",), (1, 2))
    with pytest.raises(InputError, match=r"grasps v1 \(a\) and v2 \(b\) have equal signs on all of I"):
        reduced_table(table)


def test_a_sign_table_checks_its_shape() -> None:
    with pytest.raises(InputError, match=r"2 grasps and 1 hyperplane needs signs of that shape"):
        SignTable(np.ones((2, 2), dtype=bool), ("a", "b"), ("I",), (1, 2))


@given(arrays(np.bool_, (8, 3)), st.lists(st.sampled_from("abc"), min_size=8, max_size=8), st.randoms())
def test_training_grasps_do_not_depend_on_the_order_of_rows(X: Patterns, y: list[str], random: object) -> None:
    order = list(range(8))
    random.shuffle(order)  # type: ignore[attr-defined]
    one, other = training_grasps(X, y), training_grasps(X[order], [y[k] for k in order])
    np.testing.assert_array_equal(one.patterns, other.patterns)
    np.testing.assert_array_equal(one.labels, other.labels)
    np.testing.assert_array_equal(one.weights, other.weights)
    assert one.classes == other.classes


def test_contradictory_grasps_are_settled_by_majority_and_reported() -> None:
    X = np.array([[1, 0], [1, 0], [1, 0], [0, 1], [0, 0], [0, 0]], dtype=bool)
    grasps = training_grasps(X, ["a", "b", "a", "b", "a", "b"])
    assert grasps.contradictions == ((1, 2, 3), (5, 6))
    assert grasps.patterns.astype(int).tolist() == [[0, 1], [1, 0]]
    assert [grasps.classes[k] for k in grasps.labels] == ["b", "a"]
    assert grasps.weights.tolist() == [1, 2]
    assert grasps.numbers.tolist() == [4, 1]
