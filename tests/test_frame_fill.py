"""Broken taxels are filled harmonically from their neighbours."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold import InputError
from varishold.frame import fill_invalid

# The first call compiles.
shapes = hnp.array_shapes(min_dims=2, max_dims=2, max_side=12)


@given(shapes, st.data())
def test_filled_values_stay_within_the_range_of_the_others(shape: tuple[int, int], data: st.DataObject) -> None:
    frame = data.draw(hnp.arrays(np.float64, shape, elements=st.floats(-100, 100)))
    valid = data.draw(hnp.arrays(np.bool_, shape))
    if not valid.any():
        return
    filled = fill_invalid(np.where(valid, frame, np.nan), valid)
    assert np.array_equal(filled[valid], frame[valid])
    low, high = frame[valid].min(), frame[valid].max()
    assert np.all(filled >= low)
    assert np.all(filled <= high)


@given(st.floats(-5, 5), st.floats(-5, 5), hnp.arrays(np.bool_, (6, 7)))
def test_a_hole_inside_a_slope_is_filled_with_the_slope(a: float, b: float, inner: np.ndarray) -> None:
    row, col = np.mgrid[:8, :9]
    slope = a * row + b * col
    valid = np.ones((8, 9), bool)
    valid[1:-1, 1:-1] = inner
    assert np.allclose(fill_invalid(slope, valid), slope, atol=1e-5)


def test_what_lies_outside_the_field_is_neither_read_nor_written() -> None:
    frame = np.array([[1.0, np.nan, 3.0], [7.0, np.nan, 9.0]])
    field = np.array([[True, True, True], [True, False, True]])
    filled = fill_invalid(frame, np.isfinite(frame), field)
    assert filled[0, 1] == pytest.approx(2)
    assert np.isnan(filled[1, 1])


def test_an_island_without_a_working_taxel_feels_nothing() -> None:
    frame = np.array([[5.0, 1.0, 0.0, np.nan]])
    field = np.array([[True, True, False, True]])
    assert fill_invalid(frame, np.isfinite(frame), field)[0, 3] == 1


def test_a_large_hole_is_filled_promptly_and_exactly() -> None:
    row, col = np.mgrid[:240, :320]
    saddle = (row - 100.0) ** 2 - (col - 120.0) ** 2
    valid = np.ones(saddle.shape, bool)
    valid[50:150, 60:180] = False
    assert np.allclose(fill_invalid(saddle, valid), saddle, atol=1e-2)


@pytest.mark.parametrize(
    ("frame", "valid", "field", "message"),
    [
        (np.zeros(3), np.ones(3, bool), None, r"\(rows, cols\), got float64 of shape \(3,\)"),
        (np.zeros((2, 2)), np.ones((2, 3), bool), None, r"valid must .* \(2, 2\), got \(2, 3\)"),
        (np.zeros((2, 2)), np.ones((2, 2), bool), np.ones(2, bool), r"field must .* \(2, 2\), got \(2,\)"),
        (np.zeros((2, 2)), np.zeros((2, 2), bool), None, "all 4 taxels are broken: nothing to fill from"),
    ],
)
def test_what_cannot_be_filled(frame: np.ndarray, valid: np.ndarray, field: np.ndarray | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        fill_invalid(frame, valid, field)
