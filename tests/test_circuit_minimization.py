"""Two-level minimization: right on every pattern, minimal against brute force, the same for the same sets."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.circuit import minimization, minimize
from varishold.errors import InputError

tables = st.integers(1, 4).flatmap(
    lambda k: st.lists(st.sampled_from((0, 1, None)), min_size=2**k, max_size=2**k).map(lambda t: (k, t))
)


def _split(k: int, table: list[int | None]) -> tuple[np.ndarray, np.ndarray]:
    patterns = np.array(list(itertools.product((0, 1), repeat=k)), np.uint8)
    values = np.array([-1 if t is None else t for t in table])
    return patterns[values == 1], patterns[values == 0]


def _fewest_terms(k: int, on: np.ndarray, off: np.ndarray) -> tuple[int, int]:
    """Return (terms, literals) of the best cover by trying all products, with none of the method's ideas."""
    cubes = []
    for cube in itertools.product((0, 1, None), repeat=k):
        held = [i for i, value in enumerate(cube) if value is not None]
        wanted = [value for value in cube if value is not None]
        if not (off[:, held] == wanted).all(axis=1).any():
            mask = sum(1 << j for j, hit in enumerate((on[:, held] == wanted).all(axis=1)) if hit)
            cubes.append((mask, len(held)))
    best = {0: (0, 0)}
    changed = True
    while changed:
        changed = False
        for mask, (terms, literals) in list(best.items()):
            for more, length in cubes:
                candidate = (terms + 1, literals + length)
                if candidate < best.get(mask | more, (len(on) + 1, 0)):
                    best[mask | more] = candidate
                    changed = True
    return best[(1 << len(on)) - 1]


@given(tables)
def test_true_on_and_false_off(case: tuple[int, list[int | None]]) -> None:
    on, off = _split(*case)
    for exact in (None, True, False):
        cover = minimize(on, off, exact=exact)
        assert cover(on).all()
        assert not cover(off).any()


@settings(max_examples=60)
@given(tables.filter(lambda case: case[0] <= 3))
def test_no_smaller_sum_exists(case: tuple[int, list[int | None]]) -> None:
    on, off = _split(*case)
    cover = minimize(on, off)
    assert cover.proved
    if len(on):
        assert (len(cover.terms), sum(map(len, cover.terms))) == _fewest_terms(case[0], on, off)


@given(tables, st.randoms(use_true_random=False))
def test_order_and_repetition_do_not_matter(case, random) -> None:
    on, off = _split(*case)
    shuffled = [random.sample(rows.tolist() * 2, 2 * len(rows)) for rows in (on, off)]
    again = minimize(*(np.array(rows).reshape(-1, case[0]) for rows in shuffled))
    assert again == minimize(on, off)


def test_the_circuit_of_the_paper() -> None:
    cover = minimize([[1, 0]], [[0, 1], [1, 1], [0, 0]])
    assert cover.terms == (((0, 1), (1, 0)),)
    assert cover.proved


def test_one_free_pattern_shortens_the_term() -> None:
    assert minimize([[1, 0]], [[0, 1], [0, 0]]).terms == (((0, 1),),)


def test_parity_needs_every_pattern() -> None:
    patterns = np.array(list(itertools.product((0, 1), repeat=4)))
    odd = patterns.sum(axis=1) % 2 == 1
    cover = minimize(patterns[odd], patterns[~odd])
    assert len(cover.terms) == 8
    assert all(len(term) == 4 for term in cover.terms)


def test_constants() -> None:
    assert minimize([], [[0, 1]]).terms == ()
    assert minimize([[0, 1]], []).terms == ((),)


def test_many_variables_take_the_greedy_way_and_stay_right() -> None:
    rng = np.random.default_rng(3)
    centre = rng.integers(0, 2, (2, 200))
    on, off = (c ^ (rng.random((60, 200)) < 0.2) for c in centre)
    cover = minimize(on, off)
    assert not cover.proved
    assert cover(on).all()
    assert not cover(off).any()
    assert len(cover.terms) <= 6
    assert minimize(on, off) == cover


@pytest.mark.parametrize(
    ("on", "off", "message"),
    [
        ([[0, 1]], [[0, 1]], r"no pattern in common, got \[0, 1\] in both"),
        ([[0, 2]], [[0, 1]], "on must hold 0 and 1 only"),
        ([[0, 1]], [[0, np.nan]], "off must hold 0 and 1 only"),
        ([[0, 1]], [[0]], "same number of variables, got 2 and 1"),
        ([0, 1], [[0]], r"on must have shape \(n_patterns, n_variables\), got \(2,\)"),
    ],
)
def test_bad_sets_are_named(on, off, message: str) -> None:
    with pytest.raises(InputError, match=message):
        minimize(on, off)


def test_without_variables_a_function_that_is_ever_on_is_always_on() -> None:
    assert minimize(np.zeros((3, 0), np.uint8), np.zeros((0, 0), np.uint8)).terms == ((),)
    assert minimize(np.zeros((0, 0), np.uint8), np.zeros((2, 0), np.uint8)).terms == ()
    assert minimize(np.zeros((0, 3)), [[0, 1, 1]]).terms == ()
    assert minimize(np.zeros((2, 3)), np.zeros((0, 3))).terms == ((),)


@pytest.mark.parametrize("seed", range(30))
def test_a_cover_found_without_a_solver_costs_the_least(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    table = rng.random((8, 7)) < 0.4
    table[rng.integers(8, size=7), np.arange(7)] = True
    costs = rng.integers(1, 6, 8).tolist()
    found, proved = minimization._searched_cover(table, costs)
    covers = [c for n in range(1, 9) for c in itertools.combinations(range(8), n) if table[list(c)].any(axis=0).all()]
    assert proved
    assert found is not None
    assert table[found].any(axis=0).all()
    assert sum(costs[k] for k in found) == min(sum(costs[k] for k in c) for c in covers)
    monkeypatch.setattr(minimization, "_MOST_NODES", 2)
    assert minimization._searched_cover(np.eye(7, dtype=np.bool_), [1] * 7) == (None, False)
    monkeypatch.setattr(minimization, "_MOST_NODES", 8)
    assert sorted(minimization._searched_cover(np.eye(7, dtype=np.bool_), [1] * 7)[0] or []) == list(range(7))
