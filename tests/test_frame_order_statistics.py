"""Medians and quantiles in pieces are numpy's, to the last bit; presses are the same however the totals come."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from varishold.frame import order_statistics
from varishold.frame.order_statistics import median_of, nearest_of, pieces_of, quantile_of
from varishold.recording import Pad, Recording, presses

NUMBERS = hnp.arrays(
    np.float64,
    st.integers(1, 40),
    elements=st.one_of(st.floats(-1e100, 1e100), st.integers(-3, 3).map(float), st.sampled_from([0.0, -0.0, 5e-324])),
)


@pytest.fixture(params=[1, 3, 7], scope="module")
def together(request: pytest.FixtureRequest) -> Iterator[int]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(order_statistics, "_TOGETHER", request.param)
        yield request.param


@given(NUMBERS, st.floats(0.0, 1.0))
def test_quantiles_and_medians_are_numpy_s(together: int, numbers: np.ndarray, share: float) -> None:
    assert max(len(piece) for piece in pieces_of(numbers)()) <= together
    assert quantile_of(pieces_of(numbers), share) == np.quantile(numbers, share)
    assert median_of(pieces_of(numbers)) == np.median(numbers)
    assert nearest_of(pieces_of(numbers), 0.5) == np.argmin(np.abs(numbers - 0.5))


@given(st.lists(st.lists(st.floats(-5, 5), max_size=6), max_size=8))
def test_pieces_may_be_empty(together: int, lists: list[list[float]]) -> None:
    found = median_of(lambda: (np.array(each) for each in lists))
    everything = [number for each in lists for number in each]
    assert found == np.median(everything) if everything else math.isnan(found)
    assert math.isnan(quantile_of(lambda: iter(()), 0.5))


@settings(max_examples=40)
@given(
    hnp.arrays(np.int64, st.integers(1, 60), elements=st.sampled_from([0, 0, 1, 2, 3, 5, 60, 90, 100])),
    st.sampled_from([0.0, 40.0, 300.0]),
    st.integers(1, 20),
)
def test_presses_are_the_same_by_pieces(force: np.ndarray, offset: float, together: int) -> None:
    frames = offset + force[:, None, None] * np.array([[1.0, 2.0], [0.5, 1.0]])
    recording = Recording({"a": Pad(frames), "b": Pad(frames[:, :1])})
    whole = presses(recording)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(order_statistics, "_TOGETHER", together)
        assert presses(recording) == whole
