"""Laws of the solids, their ideal frames and random contacts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.solids import SOLIDS, Chance, Cone, Pose, Sphere, Torus, draw_contact, ideal_frame, solid_of_size


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_of_a_size_has_its_top_and_nothing_below_its_base(name: str) -> None:
    solid = solid_of_size(name, 0.02)
    x, y = np.meshgrid(np.linspace(-0.03, 0.03, 121), np.linspace(-0.03, 0.03, 121))
    height = solid.height(x, y)
    assert height.shape == x.shape
    assert height.min() >= 0
    assert height.max() == pytest.approx(solid.top_m, rel=0.02)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_frame_turns_with_its_solid(name: str) -> None:
    solid = solid_of_size(name, 8.0)
    pose = Pose(1.0, -2.0, 0.4)
    turned = Pose(2.0, 1.0, 0.4 + np.pi / 2)
    frame = ideal_frame(solid, (17, 17), 1.0, pose=pose)
    # A quarter turn from +x toward +y: the point (x, y) goes to (-y, x).
    np.testing.assert_allclose(ideal_frame(solid, (17, 17), 1.0, pose=turned), np.rot90(frame, -1), atol=0.35)


@given(st.floats(0.1, 1.0), st.floats(-3, 3), st.floats(-3, 3))
def test_scaling_lengths_scales_an_ideal_frame(depth: float, x: float, y: float) -> None:
    cone = Cone(10.0, 4.0)
    one = ideal_frame(cone, (12, 12), 1.0, depth_m=4.0 * depth, pose=Pose(x, y))
    mm = ideal_frame(Cone(0.01, 0.004), (12, 12), 0.001, depth_m=0.004 * depth, pose=Pose(x / 1e3, y / 1e3))
    np.testing.assert_allclose(mm * 1e3, one, atol=1e-9)


def test_the_volume_of_a_hemisphere() -> None:
    frame = ideal_frame(Sphere(20.0), (24, 24), 1.0)
    assert frame.sum() == pytest.approx(2 / 3 * np.pi * 10**3, rel=1e-3)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_drawn_contact_is_reproducible_and_lies_in_its_field(name: str) -> None:
    for seed in range(20):
        draws = [draw_contact(np.random.default_rng(seed), name, field_m=(32, 32), size_m=(8, 24)) for _ in range(2)]
        assert draws[0] == draws[1]
        drawn = draws[0]
        frame = ideal_frame(drawn.solid, (32, 32), 1.0, depth_m=drawn.depth_m, pose=drawn.pose, per_taxel=4)
        assert frame.max() > 0
        if np.isfinite(drawn.size_m[0]) and name != "lying-cylinder":
            wide = ideal_frame(drawn.solid, (64, 64), 1.0, depth_m=drawn.depth_m, pose=drawn.pose, per_taxel=4)
            assert wide.sum() == pytest.approx(frame.sum(), rel=1e-6)


def test_bad_solids_say_what_is_wrong() -> None:
    with pytest.raises(InputError, match="diameter_m of a cone must be positive and finite, got -1"):
        Cone(-1.0, 1.0)
    with pytest.raises(InputError, match="unknown solid 'teapot'; known are cylinder"):
        solid_of_size("teapot", 0.1)
    with pytest.raises(InputError, match="depth_m must lie in"):
        ideal_frame(Cone(4.0, 2.0), (8, 8), 1.0, depth_m=3.0)
    with pytest.raises(InputError, match="unknown solid 'teapot'"):
        draw_contact(np.random.default_rng(0), "teapot", field_m=(1, 1), size_m=(1, 1))
    with pytest.raises(InputError, match="a torus cannot be drawn at random"):
        Torus.drawn(Chance(np.random.default_rng(0), (1, 1), 0.1, 2.0, 0.1, 0.5, 0.0))


def test_a_frustums_true_size_is_its_tops_and_the_others_are_long_before_short() -> None:
    for name in SOLIDS:
        drawn = draw_contact(np.random.default_rng(3), name, field_m=(32, 32), size_m=(8, 24))
        if name == "cone-frustum":
            assert drawn.true_size_m == (drawn.solid.top_diameter_m,) * 2
        elif name == "pyramid-frustum":
            assert drawn.true_size_m == (drawn.solid.top_breadth_m,) * 2
        else:
            assert drawn.true_size_m == (max(drawn.size_m), min(drawn.size_m))
