"""Laws of a rest that drifts: told where it goes on all the time, and never where something presses."""

from __future__ import annotations

import numpy as np
import pytest

from varishold import Pad, Recording
from varishold.frame.slow_drift import slow_drift

USABLE = np.ones((8, 8), np.bool_)


def presses(n: int = 800, seed: int = 0) -> np.ndarray:
    """A ball that is pressed again and again, with pauses."""
    rng = np.random.default_rng(seed)
    rows, cols = np.mgrid[:8, :8] - 3.5
    ball = np.clip(1 - (rows**2 + cols**2) / 6, 0, None)
    load = np.where(np.arange(n) % 80 > 50, 100.0, 0.0)
    return load[:, None, None] * ball + rng.normal(0, 1, (n, 8, 8))


@pytest.mark.parametrize("drift", [-60.0, -30.0, 30.0, 60.0])
def test_a_rest_that_drifts_is_told_with_how_far(drift: float) -> None:
    frames = presses() + drift * np.linspace(0, 1, 800)[:, None, None]
    found = slow_drift(frames, USABLE)
    assert found is not None
    # From the lowest frame of the first quarter to that of the last one.
    assert found[0] == pytest.approx(0.75 * drift, abs=abs(0.1 * drift) + 1)
    remarks = Recording({"palm": Pad(frames + 100)}).remarks
    assert any(remark.startswith("pad palm: the rest drifts by ") for remark in remarks)
    assert slow_drift(frames * 3.0 + 7.0, USABLE) == pytest.approx((3 * found[0], found[1]))


@pytest.mark.parametrize("seed", range(5))
def test_presses_that_come_and_go_are_no_drift(seed: int) -> None:
    assert slow_drift(presses(seed=seed), USABLE) is None
    assert slow_drift(presses(n=31, seed=seed), USABLE) is None


@pytest.mark.parametrize("first", [0, 100, 300, 500])
def test_a_press_of_the_whole_pad_that_lasts_is_no_drift(first: int) -> None:
    load = np.clip((np.arange(800) - first) / 50, 0, 1)[:, None, None]
    noise = np.random.default_rng(0).normal(0, 1, (800, 8, 8))
    assert slow_drift(100 * load + noise, USABLE) is None
    assert slow_drift(np.full((800, 8, 8), 5.0), USABLE) is None


def test_taxels_that_are_none_say_nothing() -> None:
    frames = presses()
    frames[:, 0] += np.linspace(0, 1000, 800)[:, None]
    usable = USABLE.copy()
    usable[0] = False
    assert slow_drift(frames, usable) is None
