"""How presses bend, against plain sums: differences, classes of height, and what is solved out of the equations."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.frame.bends import bends_of

Floats = NDArray[np.float64]
Taxel = tuple[int, int]
few = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)
ROWS, COLS, N = 4, 6, 5
#: The taxels of each place, and how they count.
PLACES: list[tuple[tuple[float, ...], list[tuple[Taxel, ...]]]] = [
    ((1.0, -2.0, 1.0), [((r, c), (r, c + 1), (r, c + 2)) for r in range(ROWS) for c in range(COLS - 2)]),
    ((1.0, -2.0, 1.0), [((r, c), (r + 1, c), (r + 2, c)) for r in range(ROWS - 2) for c in range(COLS)]),
    (
        (1.0, -1.0, -1.0, 1.0),
        [((r, c), (r, c + 1), (r + 1, c), (r + 1, c + 1)) for r in range(ROWS - 1) for c in range(COLS - 1)],
    ),
]


def felt(seed: int, n: int = N) -> tuple[Floats, NDArray[np.bool_], Floats, Floats]:
    rng = np.random.default_rng(seed)
    stress, inside = rng.uniform(0.5, 2.0, (n, ROWS, COLS)), rng.random((n, ROWS, COLS)) < 0.75
    return stress, inside, rng.uniform(0.01, 0.1, n), rng.normal(0.0, 0.2, (ROWS, COLS))


@few
@given(seeds)
def test_differences_are_those_of_logarithms_and_know_their_noise_and_height(seed: int) -> None:
    stress, inside, noise, _ = felt(seed)
    for bend, (signs, places) in zip(bends_of(stress, inside, noise), PLACES, strict=True):
        wanted = []
        for n in range(N):
            for place, taxels in enumerate(places):
                if all(inside[n, r, c] for r, c in taxels):
                    read = np.array([stress[n, r, c] for r, c in taxels])
                    height = np.log(read).mean() - np.log(stress[n][inside[n]].max())
                    variance = np.dot(np.square(signs), (noise[n] / read) ** 2)
                    wanted.append((height, place, np.dot(np.log(read), signs), variance))
        wanted.sort()
        assert bend.place.tolist() == [place for _, place, _, _ in wanted]
        np.testing.assert_allclose(bend.values, [value for _, _, value, _ in wanted], atol=1e-12)
        np.testing.assert_allclose(bend.variance, [variance for *_, variance in wanted])
        sizes = np.diff(bend.rises)
        assert sizes.sum() == len(wanted)
        assert np.ptp(sizes) <= 1


@few
@given(seeds, st.integers(1, 6), st.sampled_from([1.0, 2.0, 30.0]))
def test_what_each_height_shares_is_an_unknown_of_its_own_that_is_solved_out(seed: int, n: int, freedom: float) -> None:
    stress, inside, noise, gains = felt(seed, n)
    for bend, (signs, places) in zip(bends_of(stress, inside, noise), PLACES, strict=True):
        weighed, size = bend.weighed(gains, freedom), ROWS * COLS
        differences = np.zeros((len(places), size))
        for place, taxels in enumerate(places):
            differences[place, [r * COLS + c for r, c in taxels]] = signs
        classes = np.zeros((bend.values.size, len(bend.rises) - 1))
        left = bend.values - differences[bend.place] @ gains.ravel()
        for k, (begin, end) in enumerate(pairwise(bend.rises)):
            classes[begin:end, k] = 1.0
            left[begin:end] -= np.median(left[begin:end]) if end > begin else 0.0
        scatter = np.median(np.abs(left)) / 0.6744897501960817 if left.size else 0.0
        variance = 0.5 * scatter**2 + bend.variance + 0.05**2
        weight = (freedom + 1) / (freedom + left**2 / variance) / (4.5 * variance)
        # All unknowns together, the gains with a prior: those of the heights have none.
        told = np.concatenate([differences[bend.place], classes], axis=1)
        normal = told.T @ (weight[:, None] * told) + np.diag([25.0] * size + [0.0] * classes.shape[1])
        plain = (np.linalg.pinv(normal) @ (told.T @ (weight * bend.values)))[:size]
        right, diagonal, times = np.zeros((ROWS, COLS)), np.zeros((ROWS, COLS)), np.zeros((ROWS, COLS))
        weighed.add_right(right)
        weighed.add_diagonal(diagonal)
        weighed.add_times(gains, times)
        matrix = weighed.matrix((ROWS, COLS))
        np.testing.assert_allclose(
            np.linalg.solve(matrix + 25.0 * np.eye(size), right.ravel()), plain, rtol=1e-6, atol=1e-9
        )
        np.testing.assert_allclose(matrix @ gains.ravel(), times.ravel(), atol=1e-9)
        assert (diagonal.ravel() >= np.diag(matrix) - 1e-9).all()
        np.testing.assert_allclose(diagonal.ravel(), weight @ differences[bend.place] ** 2, atol=1e-9)


def test_a_bend_that_all_presses_share_says_nothing_of_the_gains() -> None:
    y, x = np.mgrid[:ROWS, :COLS] - 1.5
    presses = np.exp(-0.1 * (x**2 + y**2)) * np.linspace(1.0, 2.0, N)[:, None, None]
    for bend in bends_of(presses, np.ones(presses.shape, np.bool_), np.full(N, 0.01)):
        right = np.zeros((ROWS, COLS))
        bend.weighed(np.zeros((ROWS, COLS)), 1.0).add_right(right)
        np.testing.assert_allclose(right, 0.0, atol=1e-9)


@pytest.mark.parametrize("n", [0, 3])
def test_nothing_is_told_where_nothing_presses(n: int) -> None:
    for bend in bends_of(np.ones((n, ROWS, COLS)), np.zeros((n, ROWS, COLS), np.bool_), np.ones(n)):
        weighed, right = bend.weighed(np.zeros((ROWS, COLS)), 1.0), np.zeros((ROWS, COLS))
        weighed.add_right(right)
        assert not right.any()
        assert not weighed.matrix((ROWS, COLS)).any()
