"""Laws of presses: what is taken for their rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.solids import Cone, Sphere, SquarePillar, ideal_frame
from varishold.touch.course.presses import as_presses

SHAPE = (20, 24)
SOLIDS = (Cone(8.0, 4.0), Sphere(9.0), SquarePillar(6.0, 4.0))


def rising(solid: int, n_rest: int) -> np.ndarray:
    """Return a press of height 100 that starts after so many frames at rest."""
    frame = ideal_frame(SOLIDS[solid], SHAPE, 1.0)
    ramp = np.concatenate([np.zeros(n_rest), np.linspace(0.2, 1.0, 6), [0.5, 0.0]])
    return 100 * ramp[:, None, None] * frame / frame.max()


@given(seed=st.integers(0, 999), solid=st.integers(0, 2), n_rest=st.integers(1, 7), uneven=st.floats(0.0, 10.0))
def test_however_unevenly_taxels_rest_nothing_changes(seed: int, solid: int, n_rest: int, uneven: float) -> None:
    plain = rising(solid, n_rest)
    rest = np.random.default_rng(seed).normal(0, uneven, SHAPE)
    (press,) = as_presses([plain + rest])
    np.testing.assert_allclose(press.pads["pad_0"], plain, atol=1e-9)


@pytest.mark.parametrize("solid", range(3))
@pytest.mark.parametrize("share", [0.15, 0.5, 1.0])
def test_a_press_that_begins_loaded_loses_nothing_of_its_first_frame(solid: int, share: float) -> None:
    frame = 100 * ideal_frame(SOLIDS[solid], SHAPE, 1.0)
    ramp = np.linspace(share, 1.0, 6)
    (press,) = as_presses([ramp[:, None, None] * frame])
    np.testing.assert_allclose(press.pads["pad_0"], ramp[:, None, None] * frame)


def test_a_press_of_one_frame_has_no_rest() -> None:
    frame = 100 * ideal_frame(SOLIDS[0], SHAPE, 1.0)
    (press,) = as_presses([frame])
    np.testing.assert_allclose(press.pads["pad_0"][0], frame)


def test_noise_at_rest_is_rest() -> None:
    plain = rising(0, 6)
    noise = np.random.default_rng(3).normal(0, 1.0, plain.shape)
    (press,) = as_presses([plain + noise])
    assert abs(press.pads["pad_0"][:6].mean(axis=0)).max() < 1e-9


def test_what_is_held_all_the_time_is_not_its_own_rest() -> None:
    frame = 100 * ideal_frame(SOLIDS[2], SHAPE, 1.0)
    held = frame + np.random.default_rng(5).normal(0, 1.0, (8, *SHAPE))
    (press,) = as_presses([held])
    assert press.pads["pad_0"].max() > 0.9 * frame.max()
