"""The hand's parts that need no simulation: proportions, layouts, switches, chance, coordinates, objects."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.hand import (
    LAYOUTS,
    OBJECTS,
    PAPER_22,
    TABLE_5_OBJECTS,
    HandDesign,
    HandSetting,
    PadSetting,
    Randomization,
    SwitchSetting,
)
from varishold.hand.coordinates import phalanges
from varishold.hand.objects import graspable
from varishold.hand.switches import switched
from varishold.skin import Skin


def test_the_papers_layout_has_12_finger_3_thumb_and_7_palm_switches() -> None:
    parts = [switch.part.split(".")[0] for switch in PAPER_22.switches]
    assert sum(part in {finger.name for finger in HandDesign().fingers} for part in parts) == 12
    assert parts.count("thumb") == 3
    assert parts.count("palm") == 7
    assert len(set(PAPER_22.names)) == 22
    assert LAYOUTS[PAPER_22.name] is PAPER_22


def test_every_phalanx_switch_names_a_phalanx() -> None:
    for layout in LAYOUTS.values():
        assert all(switch.part == "palm" or switch.part in HandDesign().joints for switch in layout.switches)


@given(
    force=st.lists(st.floats(0, 5), min_size=1, max_size=30),
    on=st.floats(0.1, 2),
    fraction=st.floats(0.1, 1.0),
)
def test_a_switch_closes_above_its_threshold_and_opens_below_the_lower_one(
    force: list[float], on: float, fraction: float
) -> None:
    closed = np.zeros(1, dtype=bool)
    for f in force:
        before = bool(closed[0])
        closed = switched(np.array([f]), closed, np.array([on]), np.array([fraction * on]))
        assert bool(closed[0]) == (f >= on or (before and f >= fraction * on))


@given(seed=st.integers(0, 2**31), search=st.booleans())
def test_circumstances_stay_within_their_ranges(seed: int, search: bool) -> None:
    ranges = Randomization()
    drawn = ranges.draw(np.random.default_rng(seed), n_switches=22, search=search)
    for name in ("friction", "torque", "density", "softness", "threshold"):
        largest = getattr(ranges, name)
        assert 1 / largest - 1e-12 <= getattr(drawn, name) <= largest + 1e-12
    assert len(drawn.switch_spread) == 22
    assert abs(drawn.sideways_m) <= (ranges.search_m if search else ranges.sideways_m)
    assert abs(drawn.yaw_rad) <= (ranges.search_rad if search else ranges.yaw_rad)


def test_still_physics_varies_the_place_alone() -> None:
    a, b = (Randomization().draw(np.random.default_rng(s), n_switches=3, still=True) for s in (1, 2))
    assert a.friction == b.friction == 1.0
    assert a.switch_spread == (1.0, 1.0, 1.0)
    assert a.yaw_rad != b.yaw_rad


def test_searching_covers_30_mm_and_20_degrees() -> None:
    assert Randomization().search_m == 0.030
    assert np.rad2deg(Randomization().search_rad) == pytest.approx(20)


@given(st.lists(st.floats(-0.6, 1.4), min_size=15, max_size=15))
def test_phalanges_form_chains_and_normals_stand_square(angles: list[float]) -> None:
    design = HandDesign()
    place = phalanges(np.array(angles), design)
    assert np.allclose((place.along * place.inward).sum(axis=1), 0)
    ends = place.start_m + place.length_m[:, None] * place.along
    for digit in range(5):
        for k in (0, 1):
            assert np.allclose(ends[3 * digit + k], place.start_m[3 * digit + k + 1])


def test_fingers_and_thumb_close_toward_each_other() -> None:
    straight = phalanges(np.zeros(15), HandDesign())
    assert np.allclose(straight.inward[:12, 1], -1)
    assert np.allclose(straight.inward[12:, 1], 1)


@given(st.floats(0.5, 2.0))
def test_finger_scale_scales_every_digit(scale: float) -> None:
    for digit in HandDesign().digits:
        usual = HandDesign().lengths_m(digit)
        assert np.allclose(HandDesign().scaled(scale).lengths_m(digit), scale * usual)


@pytest.mark.parametrize("name", OBJECTS)
def test_every_object_has_a_surface_that_rays_meet(name: str) -> None:
    solid = graspable(name, 0.08)
    above = np.array([[0.0, 0.0, 1.0], [5.0, 0.0, 1.0]])
    hits = np.min([part.hits(above, np.array([0.0, 0.0, -1.0])) for part in solid.body()], axis=0)
    top = 2 * solid.top_m if name == "sphere" else solid.top_m
    assert hits[0] == pytest.approx(1.0 - top, abs=1e-9)
    assert np.isinf(hits[1])


@pytest.mark.parametrize("name", ["cylinder", "square-pillar", "hexagonal-prism", "triangular-prism", "box"])
def test_the_body_has_the_size_it_is_called_by(name: str) -> None:
    # From where the palm stands: half of the breadth, which a box has along y; a triangle stands nearer.
    solid = graspable(name, 0.08)
    start = np.array([[0.0, -1.0, 0.05]]) if name == "box" else np.array([[-1.0, 0.0, 0.05]])
    ahead = np.array([0.0, 1.0, 0.0]) if name == "box" else np.array([1.0, 0.0, 0.0])
    (hit,) = np.min([part.hits(start, ahead) for part in solid.body()], axis=0)
    assert 1.0 - hit == pytest.approx(0.08 / 3 if name == "triangular-prism" else 0.04, abs=1e-6)


def test_table_5_has_the_papers_ten_objects() -> None:
    assert [round(1e3 * size) for name, size in TABLE_5_OBJECTS if name == "cylinder"] == [70, 80, 90, 100, 110]
    assert [round(1e3 * size) for name, size in TABLE_5_OBJECTS if name == "square-pillar"] == [50, 60, 70, 80, 90]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: graspable("cylinder", 0.3), r"size of the cylinder must lie in \[0.035, 0.125\] m .* got 0.3 m"),
        (lambda: graspable("cylinder", 0.01), r"size of the cylinder must lie .* got 0.01 m"),
        (lambda: graspable("cylinder", float("nan")), "size of the cylinder must lie .* got nan m"),
        (lambda: graspable("banana", 0.05), "unknown object 'banana'; the hand can grip cylinder, square-pillar"),
        (lambda: HandDesign(finger_scale=9.0), r"finger_scale must lie in \[0.5, 2\], got 9.0"),
        (lambda: HandDesign(friction=-1.0), r"friction of a hand must be positive and finite, got \[-1.0\]"),
        (lambda: Randomization(friction=0.5), "friction of a randomization must be at least 1, got 0.5"),
        (lambda: Randomization(search_m=-0.1), "search_m of a randomization must be at least 0, got -0.1"),
        (lambda: SwitchSetting(on_n=0.0), "on_n of a switch must be positive and finite, got 0.0"),
        (lambda: SwitchSetting(off_fraction=1.5), r"off_fraction of a switch must lie in \(0, 1\], got 1.5"),
        (lambda: PadSetting(skin=Skin("half-space")), "the pads' skin needs youngs_modulus_pa"),
        (lambda: PadSetting(least_n=0.0), "least_n of the pads must be positive and finite, got 0.0"),
        (lambda: HandSetting(most_attempts=0), "most_attempts must be at least 1, got 0"),
    ],
)
def test_bad_input_is_named(make: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()  # type: ignore[operator]
