"""Laws of ranges, and of answers that promise nothing outside of what was learned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from varishold.trust import held_out_beyond, learn_ranges, least_error, widened

NUMBERS = st.one_of(st.integers(-3, 3).map(float), st.just(np.nan), st.floats(-1e300, 1e300))
tables = st.tuples(st.integers(1, 8), st.integers(1, 3)).flatmap(lambda shape: arrays(float, shape, elements=NUMBERS))


@given(tables)
def test_what_was_learned_lies_within_its_range(values: np.ndarray) -> None:
    ranges = learn_ranges(values)
    assert not ranges.beyond(values).any()
    assert not ranges.beyond(np.full_like(values, np.nan)).any()
    wide = ranges.beyond(np.full_like(values, np.inf))
    assert not wide.any(), "what is no number is unknown"


@given(tables, st.floats(0.0, 1e6))
def test_a_number_is_beyond_by_so_many_of_its_ranges(values: np.ndarray, parts: float) -> None:
    ranges = learn_ranges(values)
    seen = np.isfinite(ranges.high)
    with np.errstate(over="ignore"):
        span = np.where(seen, ranges.high, 0.0) - np.where(seen, ranges.low, 0.0)
    plain = np.isfinite(span) & (span > 1e-3 * (1 + np.abs(ranges.high))) & (span < 1e200)
    for end, way in ((ranges.high, 1.0), (ranges.low, -1.0)):
        found = ranges.beyond(np.where(plain, end + way * parts * np.where(plain, span, 0.0), np.nan)[None])[0]
        np.testing.assert_allclose(found[plain], parts, rtol=1e-6, atol=1e-6)
    constant = np.flatnonzero(ranges.high == ranges.low)
    other = np.where(ranges.high == 1, 2.0, 1.0)
    assert (ranges.beyond(other[None])[0][constant] == 1).all()
    # Of a number that was never seen nothing is known.
    never = np.isnan(values).all(axis=0)
    assert not ranges.beyond(np.zeros((1, values.shape[1])))[0][never].any()


@given(tables, st.integers(0, 2**32 - 1), st.booleans())
def test_held_out_is_beyond_the_range_of_the_others(values: np.ndarray, seed: int, grouped: bool) -> None:
    groups = np.random.default_rng(seed).integers(0, 3, len(values)) if grouped else np.arange(len(values))
    found = held_out_beyond(values, groups if grouped else None)
    for k in range(len(values)):
        others = values[groups != groups[k]]
        np.testing.assert_array_equal(found[k], learn_ranges(others).beyond(values[k : k + 1])[0])


def test_an_error_is_as_small_as_known_things_allow() -> None:
    assert least_error(0.05, 19) == 0.05
    assert least_error(0.05, 4) == 0.2
    # Where nothing is known nothing can be refused: every p-value is 1.
    assert least_error(0.05, 0) == 0.5


shares = st.integers(1, 6).flatmap(
    lambda k: arrays(float, (4, k), elements=st.floats(1e-6, 1)).map(lambda p: p / p.sum(axis=1, keepdims=True))
)
p_values = arrays(float, 4, elements=st.floats(1e-4, 1))


@given(shares, p_values, st.floats(1e-3, 0.5))
def test_nothing_outside_of_what_was_learned_is_promised(plain: np.ndarray, p: np.ndarray, error: float) -> None:
    found = widened(plain, p, error)
    inside = p > error
    np.testing.assert_array_equal(found[inside], plain[inside])
    assert (found[~inside] <= 0.9).all()
    assert (found >= 0).all()
    if plain.shape[1] > 1:
        np.testing.assert_allclose(found.sum(axis=1), 1)
        # The order stays, but for rounding.
        by_given = np.take_along_axis(found, np.argsort(plain, axis=1), axis=1)
        assert (np.diff(by_given, axis=1) >= -1e-12).all()


@given(shares, st.floats(1e-3, 0.5))
def test_the_stranger_the_less_is_promised(plain: np.ndarray, error: float) -> None:
    p = np.array([1.0, 1.0, 0.5, 0.1]) * error
    same = np.tile(plain[:1], (4, 1))
    top = widened(same, p, error).max(axis=1)
    assert (np.diff(top) <= 1e-12).all()
    assert top[3] == pytest.approx(1 / max(plain.shape[1], 2), abs=0.01)
