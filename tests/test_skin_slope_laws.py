"""Slopes, limits and draws of the skin worked out another way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.skin import PressDraw, Skin, draw_press
from varishold.skin.pressing import contact_cells
from varishold.skin.reconstruction import _tilt, _without_tilt
from varishold.skin.transmission import transmission_of


@given(st.integers(0, 2**31), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
@settings(max_examples=40)
def test_a_tilt_is_the_slope_of_the_plane_of_least_squares(seed, along, down):
    rng = np.random.default_rng(seed)
    cells, _ = contact_cells((9, 12), (2e-3, 1e-3), 1)
    y, x = np.mgrid[:9, :12] * np.array([2e-3, 1e-3])[:, None, None]
    core = rng.random((9, 12)) < 0.5
    height = rng.normal(0, 1e-4, (9, 12)) + along * x + down * y
    plane = np.column_stack([x[core], y[core], np.ones(core.sum())])
    expected = np.linalg.lstsq(plane, height[core], rcond=None)[0][:2]
    tilt = _tilt(height, core, cells)
    assert tilt == pytest.approx(expected, rel=1e-6, abs=1e-9)
    # Without it the core leans nowhere, and its mean stays.
    flat = _without_tilt(height, core, tilt, cells)
    assert _tilt(flat, core, cells) == pytest.approx((0, 0), abs=1e-9)
    assert flat[core].mean() == pytest.approx(height[core].mean(), abs=1e-12)
    assert _tilt(np.full((9, 12), 2.0), core, cells) == pytest.approx((0, 0), abs=1e-9)


def test_along_a_line_no_plane_can_be_told():
    cells, _ = contact_cells((9, 12), (2e-3, 1e-3), 1)
    y, x = np.mgrid[:9, :12].astype(float)
    assert _tilt(x + y, x == y, cells) == (0.0, 0.0)


@pytest.mark.parametrize(("pitch", "fine"), [((1e-3, 1e-3), True), ((1.5e-3, 1e-3), False), ((1e-3, 1.5e-3), False)])
def test_cells_are_at_most_as_large_as_the_taxels_lie_deep(pitch, fine):
    skin = Skin("layer", 6e-3, 0.45, 1e-3)
    cells, _ = contact_cells((8, 8), pitch, 1)
    if fine:
        assert transmission_of(skin, cells, 1) is not None
        return
    with pytest.raises(InputError, match=r"cells of 0\.0015 m, depth 0\.001 m; use per_taxel=2 or more"):
        transmission_of(skin, cells, 1)


@pytest.mark.parametrize("seed", range(3))
def test_a_drawn_press_has_a_size_within_what_was_asked(seed):
    draw = PressDraw(Skin("layer", 6e-3, 0.45, 1e-3), shape=(16, 16), size_taxels=(5.0, 7.0))
    rng = np.random.default_rng(seed)
    drawn = draw_press(rng, draw, solid="cylinder")
    assert 5 * draw.pitch_m <= drawn.drawn.size_m[0] <= 7 * draw.pitch_m * 1.0001
