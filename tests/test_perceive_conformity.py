"""How usual a conformity is: by the object's own examples, those of its size most."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.perceive.conformity import Calibration


def drawn(n: int, seed: int, slope: float = 4.0) -> tuple[np.ndarray, np.ndarray]:
    """Return logarithms of sizes, and conformities that rise with them."""
    rng = np.random.default_rng(seed)
    log_size = rng.uniform(np.log(0.04), np.log(0.125), n)
    return log_size, slope * log_size + rng.normal(size=n)


@pytest.mark.parametrize("seed", range(3))
def test_small_things_and_large_ones_are_refused_as_often_as_is_stated(seed: int) -> None:
    log_size, scores = drawn(300, seed)
    told = Calibration(scores, log_size)
    new_size, new = drawn(4000, seed + 100)
    p = np.array([np.exp(-told.surprisal(s, at)) for s, at in zip(new, new_size, strict=True)])
    # Where sizes do not count, what is refused is small.
    plain = np.exp(-told.surprisal(new))
    small = new_size < np.log(0.06)
    for error in (0.05, 0.1):
        assert (p <= error).mean() == pytest.approx(error, abs=0.035)
        # At the ends of the range of sizes what is near lies all on one side.
        assert (p[small] <= error).mean() < 2.5 * (p[~small] <= error).mean() + 0.02
        assert (plain[small] <= error).mean() > 4 * (plain[~small] <= error).mean()


def test_a_large_stranger_is_not_excused_by_small_things() -> None:
    log_size, scores = drawn(300, 5)
    told, large = Calibration(scores, log_size), float(np.log(0.12))
    # Four of the scatter below what is usual for its size, and yet as small things conform.
    strange = 4.0 * large - 4.0
    assert np.exp(-told.surprisal(strange)) > 0.03
    assert np.exp(-told.surprisal(strange, large)) < 0.01


def test_where_conformity_does_not_depend_on_size_nothing_changes_much() -> None:
    log_size, scores = drawn(400, 6, slope=0.0)
    told = Calibration(scores, log_size)
    for score in np.linspace(-1.5, 2.0, 9):
        assert told.surprisal(score, float(np.log(0.07))) == pytest.approx(told.surprisal(score), abs=0.4)


def test_without_sizes_or_with_few_examples_all_examples_count_alike() -> None:
    log_size, scores = drawn(39, 7)
    unsized = np.where(np.arange(300) == 8, np.nan, drawn(300, 8)[0])
    for told in (Calibration(scores), Calibration(scores, log_size), Calibration(drawn(300, 8)[1], unsized)):
        assert told.surprisal(-20.0, -2.8) == told.surprisal(-20.0)
        np.testing.assert_array_equal(told.of_examples(sized=True), told.of_examples())


def test_a_size_beyond_all_examples_counts_as_the_nearest_and_untouched_examples_say_nothing() -> None:
    log_size, scores = drawn(120, 9)
    holed = np.where(np.arange(120) % 3 == 0, np.nan, scores)
    told = Calibration(holed, log_size)
    assert told.surprisal(-20.0, -9.0) == told.surprisal(-20.0, float(log_size.min()))
    assert np.isnan(told.of_examples(sized=True)).tolist() == np.isnan(holed).tolist()
    same = Calibration(scores[np.arange(120) % 3 > 0], log_size[np.arange(120) % 3 > 0])
    for at in (-3.0, -2.4):
        assert told.surprisal(-22.0, at) == pytest.approx(same.surprisal(-22.0, at))
