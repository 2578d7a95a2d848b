"""Laws of what touch makes of sections: poses, apexes, the next threshold, shares that add up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.solids import Cone, Cylinder, Pose, Ridge, Solid, Sphere, SquarePillar, ideal_frame
from varishold.touch import contact_pose, find_contacts, next_threshold, recognize
from varishold.touch.exponent import apex_exponent

few = settings(max_examples=15)


def hill(x: float, y: float, yaw: float, long: float, short: float, shape: tuple[int, int] = (33, 41)) -> np.ndarray:
    rows, cols = shape
    v, u = np.mgrid[:rows, :cols]
    dx, dy = u - (cols - 1) / 2 - x, v - (rows - 1) / 2 - y
    a, b = dx * np.cos(yaw) + dy * np.sin(yaw), dy * np.cos(yaw) - dx * np.sin(yaw)
    return np.exp(-((a / long) ** 2 + (b / short) ** 2) / 2)


@few
@given(st.floats(-4, 4), st.floats(-3, 3), st.floats(-1.5, 1.5))
def test_a_pose_is_that_of_the_squared_height(x: float, y: float, yaw: float) -> None:
    (contact,) = find_contacts(hill(x, y, yaw, 4.0, 2.5), 64, floor=1e-3)
    pose = contact_pose(contact)
    assert pose.position == pytest.approx((x, y), abs=0.02)
    # The square of a normal distribution is one of half its variance.
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(pose.covariance, turn @ np.diag([8.0, 3.125]) @ turn.T, atol=0.35)
    assert pose.aspect == pytest.approx(4 / 2.5, rel=0.04)
    off = (pose.orientation - yaw + np.pi / 2) % np.pi - np.pi / 2
    assert abs(off) < 0.03
    assert -np.pi / 2 <= pose.orientation < np.pi / 2


def test_uneven_thresholds_give_the_pose_of_even_ones() -> None:
    frame = hill(1.0, -2.0, 0.4, 4.0, 2.0) + 0.6 * hill(6.0, 2.0, 0.0, 2.0, 2.0)
    even = contact_pose(find_contacts(frame, 60, floor=0.01)[0])
    top = float(frame.max())
    uneven = contact_pose(
        find_contacts(frame, 0.01 + (top - 0.01) * (np.arange(60) / 60 + 1 / 120) ** 2, floor=0.01)[0]
    )
    assert uneven.position == pytest.approx(even.position, abs=0.05)
    np.testing.assert_allclose(uneven.covariance, even.covariance, rtol=0.05, atol=0.05)


def test_the_mean_area_of_a_cone_by_heights() -> None:
    # A = pi r^2 (1 - h)^2, weighed by h from 0 to 1: a sixth of the base, were the tip felt.
    frame = ideal_frame(Cone(24.0, 12.0), (33, 33), 1.0)
    (contact,) = find_contacts(frame, 80, floor=1e-3)
    pose = contact_pose(contact)
    # Up to the highest taxel, which averages the tip away.
    p = contact.peak / 12
    assert pose.mean_area == pytest.approx(np.pi * 144 * (1 - 4 * p / 3 + p**2 / 2), rel=0.02)
    half = contact_pose(find_contacts(frame, 80, floor=1e-3, pitch=0.5)[0])
    assert half.mean_area == pytest.approx(pose.mean_area / 4)
    np.testing.assert_allclose(half.covariance, pose.covariance / 4)


def test_one_section_or_none() -> None:
    frame = hill(0, 0, 0, 3, 3)
    (contact,) = find_contacts(frame, [0.5], floor=0.1)
    assert contact_pose(contact).position == pytest.approx((0, 0), abs=1e-9)
    (none,) = find_contacts(frame, [2.0], floor=0.1)
    with pytest.raises(InputError, match="no section of the contact"):
        contact_pose(none)


@pytest.mark.parametrize("k", [0.0, 0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("scale", [1.0, 50.0])
def test_the_exponent_of_a_power_is_found(k: float, scale: float) -> None:
    theta = scale * np.linspace(0.99, 0.01, 60)
    found = apex_exponent(theta, 300 * (1 - theta / scale) ** k + 1e-12, peak=scale, floor=0.0)
    assert found == pytest.approx(k, abs=0.05)
    # Areas and taxels in another unit, and a tip that the taxels average away.
    again = apex_exponent(theta, 3e-4 * (1 - theta / scale) ** k, peak=scale, floor=0.0, taxel_area=1e-6)
    assert again == pytest.approx(k, abs=0.05)
    blunt = apex_exponent(theta, 300 * (1.07 - theta / scale) ** k, peak=scale, floor=0.0)
    assert blunt == pytest.approx(k, abs=0.1)


def test_the_exponent_needs_four_sections_of_four_taxels_that_lie_clear_of_the_floor() -> None:
    theta = np.array([0.8, 0.6, 0.4, 0.2])
    assert apex_exponent(theta, np.array([4.0, 8, 12, 16]), peak=1.0, floor=0.0) == pytest.approx(1, abs=0.02)
    assert apex_exponent(theta, np.array([3.9, 8, 12, 16]), peak=1.0, floor=0.0) is None
    low = np.array([0.8, 0.6, 0.4, 0.14])
    assert apex_exponent(low, np.array([4.0, 8, 12, 17]), peak=1.0, floor=0.0) is None
    assert apex_exponent(np.array([1.0, 0.6, 0.4, 0.2]), np.array([4.0, 8, 12, 16]), peak=1.0, floor=0.0) is None


SOLIDS = (Sphere(14.0), Cylinder(14.0, 5.0), Cone(18.0, 8.0), SquarePillar(12.0, 4.0), Ridge(20.0, 10.0, 5.0))


@pytest.mark.parametrize("solid", SOLIDS, ids=lambda solid: solid.name)
def test_shares_add_up_and_lead_to_the_name(solid: Solid) -> None:
    frame = ideal_frame(solid, (32, 32), 1.0, pose=Pose(1.0, -0.5, 0.3))
    (contact,) = find_contacts(frame)
    surface = recognize(contact)
    assert surface.kind_probability.sum() == pytest.approx(1)
    assert (surface.kind_probability >= 0).all()
    assert 0 < surface.probability <= 1 + 1e-12
    # The next threshold is the middle of the widest gap that matters: never one that was cut.
    cuts = np.linspace(contact.floor, contact.peak, 12)[1:-1]
    chosen = next_threshold(surface, cuts)
    edges = np.r_[contact.floor, cuts, contact.peak]
    middles = (edges[1:] + edges[:-1]) / 2
    assert np.abs(middles - chosen).min() < 1e-9
    first = next_threshold(surface, [])
    assert first == pytest.approx((contact.floor + contact.peak) / 2)
    # What lies outside of the contact cuts nothing.
    assert next_threshold(surface, [contact.peak + 1, contact.floor - 1, contact.floor, contact.peak]) == first
    near = contact.peak - 0.05 * (contact.peak - contact.floor)
    assert next_threshold(surface, [near]) < near


def test_a_small_pyramid_shows_which_way_its_sides_run() -> None:
    """One section of it is nearly round; all from half height down are not."""
    y, x = np.mgrid[:16, :16] - 7.5
    off = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        turn, half = rng.uniform(0, np.pi), rng.uniform(4.0, 6.0)
        u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        frame = np.maximum(1 - np.maximum(np.abs(u), np.abs(v)) / half, 0) + rng.normal(0, 0.02, x.shape)
        surface = recognize(find_contacts(frame)[0])
        if surface.name == "pyramid":
            assert surface.orientation is not None
            off.append(abs((surface.orientation - turn + np.pi / 4) % (np.pi / 2) - np.pi / 4))
    assert len(off) > 30
    assert np.mean(np.array(off) > 0.15) < 0.1
