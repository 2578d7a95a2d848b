"""Table 5's arithmetic, which needs no simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.hand import TABLE_5_OBJECTS
from varishold.hand.features import Features
from varishold.paper.table5 import OBJECT_NAMES, Table5, paper_percent
from varishold.paper.trials import classify


def table(right: int) -> Table5:
    correct = np.full((1, 2, 10), right)
    held = np.full((2, 10), 20)
    return Table5(("contact",), correct, held, held, 20, 0, "auto", 1.0)


def test_the_papers_row_is_in_the_order_of_our_objects() -> None:
    assert OBJECT_NAMES[5] == "S1"
    assert TABLE_5_OBJECTS[5] == ("square-pillar", 0.05)
    assert paper_percent().tolist() == [0, 90, 100, 100, 50, 25, 95, 100, 90, 100]


def of_rounds(right: list[int]) -> Table5:
    """Rounds of ten grasps of each object, of which so many are right."""
    correct = np.tile(np.array(right)[None, :, None], (1, 1, 10))
    return Table5(("contact",), correct, 0 * correct[0], 0 * correct[0], 10, 0, "auto", 1.0)


def test_the_interval_of_a_mean_is_students() -> None:
    mean, low, high = of_rounds([5, 6, 4]).mean("contact")
    assert mean == pytest.approx(50.0)
    assert high - mean == pytest.approx(mean - low)
    assert high - mean == pytest.approx(4.302653 * 10 / np.sqrt(3), rel=1e-5)
    assert np.isnan(of_rounds([7]).mean("contact")[1:]).all()


@given(st.lists(st.integers(0, 10), min_size=2, max_size=12))
def test_the_interval_of_a_mean_of_percentages_stays_within_them(right: list[int]) -> None:
    mean, low, high = of_rounds(right).mean("contact")
    assert 0 <= low <= mean + 1e-9
    assert mean - 1e-9 <= high <= 100


def test_objects_below_the_paper_are_marked() -> None:
    good, bad = table(20), table(10)
    assert (good.below_paper("contact") >= 0.05).all()
    below = bad.below_paper("contact") < 0.05
    assert below.tolist() == [p >= 90 for p in paper_percent()]
    assert "50*" in str(bad)
    assert "*" not in str(good).splitlines()[2]
    rows = list(bad.to_dicts())
    assert len(rows) == 11
    assert rows[-1]["percent"]["contact"] == pytest.approx(50.0)


@pytest.mark.parametrize("mode", ["auto", "paper", "robust", "vote"])
def test_switches_and_numbers_are_learned_together(mode: str) -> None:
    rng = np.random.default_rng(5)

    def grasps(round_: bool) -> list[Features]:
        return [
            Features(
                {"switch.a": bool(rng.random() < 0.5), "switch.b": round_},
                {"surface.range": float(rng.normal(0.1 if round_ else 1.0, 0.02))},
            )
            for _ in range(10)
        ]

    train = grasps(True) + grasps(False)
    names = ["cylinder"] * 10 + ["square-pillar"] * 10
    test = grasps(True) + grasps(False)
    assert (classify(train, names, test, mode=mode) == np.array(names)).all()
