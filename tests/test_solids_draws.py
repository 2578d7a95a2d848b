"""Laws of random contacts: what chance is given, and what each solid makes of it, against plain sums."""

from __future__ import annotations

import inspect
from dataclasses import astuple, dataclass
from typing import ClassVar

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.solids import SOLIDS, Box, Chance, Drawn, Lump, Pose, Solid, Sphere, draw_contact
from varishold.solids.raised import Raised


@dataclass(frozen=True)
class Told(Raised):
    """A block that keeps what chance told it."""

    name: ClassVar[str] = "told"
    chances: ClassVar[list[Chance]] = []

    height_m: float = 1.0

    @classmethod
    def of_size(cls, size_m: float) -> Told:
        return cls(size_m)

    @classmethod
    def drawn(cls, chance: Chance) -> Drawn:
        cls.chances.append(chance)
        return Drawn(cls(), Pose(), 1.0, (1.0, 2.0))

    def rise(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.ones_like(x)


class Middle:
    """A generator that draws the share `at` of every range, and notes the ranges."""

    def __init__(self, at: float = 0.5) -> None:
        self.at, self.ranges = at, []

    def uniform(self, low: float, high: float) -> float:
        self.ranges.append((low, high))
        return low + self.at * (high - low)

    def random(self) -> float:
        return self.at


def chance(rng: object = None, **told: object) -> Chance:
    rng = rng or Middle()
    plain = {"field_m": (40.0, 60.0), "size_m": 12.0, "aspect": 2.0, "slope": 0.25, "top": 0.5, "yaw_rad": 0.0}
    return Chance(rng, **plain | told)  # type: ignore[arg-type]


def test_chance_is_drawn_from_the_ranges_that_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SOLIDS, "told", Told)
    ranges = {"size_m": (8.0, 24.0), "aspect": (1.5, 2.5), "slope": (0.1, 0.4), "top": (0.2, 0.7)}
    for at in (0.0, 0.25, 1.0):
        Told.chances.clear()
        draw_contact(Middle(at), "told", field_m=(30.0, 50.0), **ranges)  # type: ignore[arg-type]
        (found,) = Told.chances
        assert found.size_m == pytest.approx(8 + 16 * at)
        assert found.aspect == pytest.approx(1.5 + at)
        assert found.slope == pytest.approx(0.1 * 4**at)
        assert found.top == pytest.approx(0.2 + 0.5 * at)
        assert found.yaw_rad == pytest.approx(np.pi * (at - 0.5))
        assert found.field_m == (30.0, 50.0)
        assert found.wanted_depth_m is None
    draw_contact(Middle(), "told", field_m=(30.0, 50.0), size_m=(8, 24), depth_m=0.5)  # type: ignore[arg-type]
    assert Told.chances[-1].wanted_depth_m == 0.5


def test_without_ranges_chance_is_drawn_from_the_usual_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SOLIDS, "told", Told)
    for at, wanted in ((0.0, (1.4, 0.05, 0.3)), (1.0, (2.8, 0.4, 0.6))):
        Told.chances.clear()
        draw_contact(Middle(at), "told", field_m=(30.0, 50.0), size_m=(8.0, 24.0))  # type: ignore[arg-type]
        (found,) = Told.chances
        assert (found.aspect, found.slope, found.top) == pytest.approx(wanted)


def test_a_depth_follows_the_slope_unless_it_is_wanted() -> None:
    assert chance(slope=0.25).depth_m(8.0) == 2.0
    assert chance(wanted_depth_m=0.0).depth_m(8.0) == 0.0
    assert chance(wanted_depth_m=3.0).depth_m(8.0) == 3.0


def test_a_cap_is_cut_at_its_size_and_is_half_a_ball_at_most() -> None:
    # Of a ball of diameter 10, at 1 below its top, the cap is 6 broad; at 2 below, 8.
    assert chance(size_m=6.0, wanted_depth_m=1.0).cap() == pytest.approx((1.0, 10.0))
    assert chance(size_m=8.0, slope=0.25).cap() == pytest.approx((2.0, 10.0))
    assert chance(size_m=6.0, wanted_depth_m=3.0).cap() == pytest.approx((3.0, 6.0))
    assert chance(size_m=6.0, wanted_depth_m=5.0).cap() == pytest.approx((3.0, 6.0))


# Of a contact 12 long, half as broad where it has two sides, a quarter of its breadth deep, with a top of a half:
# the solid's fields, the depth, the contact's sides and what recognition should say.
_CONTACTS = {
    "cylinder": ((12, 6), 3, (12, 12), (12, 12)),
    "square-pillar": ((12, 6), 3, (12, 12), (12, 12)),
    "rectangular-pillar": ((12, 6, 3), 1.5, (12, 6), (12, 6)),
    "cone-frustum": ((18, 6, 6), 3, (12, 12), (6, 6)),
    "pyramid-frustum": ((18, 6, 6), 3, (12, 12), (6, 6)),
    "sphere": ((15,), 3, (12, 12), (12, 12)),
    "cone": ((24, 6), 3, (12, 12), (12, 12)),
    "pyramid": ((24, 6), 3, (12, 12), (12, 12)),
    "ridge": ((12, 12, 3), 1.5, (12, 6), (12, 6)),
    "hip": ((18, 12, 3), 1.5, (12, 6), (12, 6)),
    # Half of the way from 1.3 to 3 times its size.
    "lying-cylinder": ((15, 2.15 * 12), 3, (2.15 * 12, 12), (2.15 * 12, 12)),
    "edge": ((6,), 3, (np.inf, np.inf), (np.inf, np.inf)),
    "wedge": ((24, 6), 3, (np.inf, 12), (np.inf, 12)),
    "plane": ((6,), 3, (np.inf, np.inf), (np.inf, np.inf)),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_each_solid_makes_of_chance_what_its_form_asks(name: str) -> None:
    fields, depth_m, contact_m, said_m = _CONTACTS[name]
    drawn = SOLIDS[name].drawn(chance())
    assert type(drawn.solid) is SOLIDS[name]
    assert astuple(drawn.solid) == pytest.approx(fields)
    assert drawn.depth_m == pytest.approx(depth_m)
    assert drawn.size_m == pytest.approx(contact_m)
    assert drawn.true_size_m == pytest.approx(said_m)
    uneven = SOLIDS[name].drawn(chance(top=0.3)).solid
    if "frustum" in name:
        assert astuple(uneven)[:2] == pytest.approx((12 + 12 * 0.7, 12 * 0.3))


def test_a_third_of_lying_cylinders_are_four_fields_long() -> None:
    lying = SOLIDS["lying-cylinder"]
    assert lying.drawn(chance(Middle(0.33))).size_m == (240.0, 12.0)
    assert lying.drawn(chance(Middle(1 / 3))).size_m[0] == pytest.approx((1.3 + 1.7 / 3) * 12)
    assert lying.drawn(chance(Middle(0.33), field_m=(70.0, 60.0))).size_m == (280.0, 12.0)


def free(solid: Solid, long_m: float, short_m: float, **told: object) -> list[tuple[float, float]]:
    """The ranges from which the pose of a contact is drawn."""
    rng = Middle(0.75)
    drawn = solid.at_random(chance(rng, **told), 1.0, long_m, short_m)
    assert (drawn.pose.x_m, drawn.pose.y_m) == pytest.approx([high / 2 for _, high in rng.ranges])
    assert all(low == -high for low, high in rng.ranges)
    assert (drawn.solid, drawn.depth_m, drawn.size_m) == (solid, 1.0, (long_m, short_m))
    assert drawn.pose.yaw_rad == told.get("yaw_rad", 0.0)
    return [high for _, high in rng.ranges]  # type: ignore[misc]


def test_a_contact_may_lie_wherever_it_stays_within_the_field() -> None:
    block = Box(10.0, 6.0, 1.0)
    assert free(block, 10.0, 6.0) == pytest.approx([30 - 5, 20 - 3])
    assert free(block, 10.0, 6.0, yaw_rad=np.pi / 2) == pytest.approx([30 - 3, 20 - 5])
    assert free(block, 10.0, 6.0, yaw_rad=-np.pi / 2) == pytest.approx([30 - 3, 20 - 5])
    turn = np.arctan2(3, 4)
    for yaw_rad in (turn, -turn):
        assert free(block, 10.0, 6.0, yaw_rad=yaw_rad) == pytest.approx([30 - (8 + 3.6) / 2, 20 - (6 + 4.8) / 2])
        assert free(Sphere(10.0), 10.0, 10.0, yaw_rad=yaw_rad) == pytest.approx([25, 15])
    # What is longer than the field lies in its middle.
    assert free(block, 50.0, 6.0) == pytest.approx([5, 17])
    assert free(block, 70.0, 50.0) == [0.0, 0.0]


def test_what_leaves_the_field_has_its_middle_in_the_fields_middle_half() -> None:
    plane = SOLIDS["plane"].of_size(1.0)
    assert free(plane, np.inf, np.inf) == [10.0, 10.0]
    assert free(plane, 3.0, 2.0, field_m=(60.0, 20.0)) == [5.0, 5.0]
    # So has what is longer than twice the field.
    block = Box(10.0, 6.0, 1.0)
    assert free(block, 121.0, 6.0) == [10.0, 10.0]
    assert free(block, 120.0, 6.0) == pytest.approx([0.0, 17.0])


def test_which_solids_are_round_and_which_may_leave_the_field() -> None:
    assert {name for name, kind in SOLIDS.items() if kind.round} == {"cylinder", "cone", "cone-frustum", "sphere"}
    leaving = {"lying-cylinder", "edge", "wedge", "plane"}
    assert {name for name, kind in SOLIDS.items() if kind.may_leave_field} == leaving


def test_a_contact_is_said_long_before_short() -> None:
    assert Sphere(1.0).true_size_m((2.0, 3.0)) == (3.0, 2.0)
    assert Sphere(1.0).true_size_m((3.0, 2.0)) == (3.0, 2.0)


def test_a_solid_that_is_not_drawn_and_one_without_a_body_say_so() -> None:
    with pytest.raises(InputError, match=r"^a lump cannot be drawn at random: its class does not say how$"):
        Lump.drawn(chance())
    for name in ("plane", "edge", "ridge", "hip", "wedge", "lying-cylinder"):
        with pytest.raises(InputError, match=r"is only a face and has no body to grip$"):
            SOLIDS[name].of_size(1.0).body()


def test_a_pose_stands_still_by_itself() -> None:
    assert astuple(Pose()) == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert all(found.default == 0.0 for found in inspect.signature(Pose).parameters.values())


@pytest.mark.parametrize("field", ["x_m", "y_m", "yaw_rad", "tip_x", "tip_y"])
def test_every_number_of_a_pose_is_bounded_on_both_sides(field: str) -> None:
    for bad in (1.01e100, -1.01e100, np.inf, -np.inf, np.nan):
        with pytest.raises(InputError, match=rf"^{field} of a pose must be finite, at most 1e\+100, got "):
            Pose(**{field: bad})
    for good in (1e100, -1e100):
        assert getattr(Pose(**{field: good}), field) == good


def test_a_tip_of_either_slope_alone_lifts_a_face() -> None:
    block = Box(6.0, 2.0, 1.0)
    x, y = np.array([2.0, -2.0, 4.0]), np.array([0.5, -0.5, 0.0])
    np.testing.assert_allclose(block.placed(x, y), [1, 1, 0])
    np.testing.assert_allclose(block.placed(x, y, Pose(tip_x=0.1)), [1.2, 0.8, 0])
    np.testing.assert_allclose(block.placed(x, y, Pose(tip_y=0.1)), [1.05, 0.95, 0])
    np.testing.assert_allclose(block.placed(x, y, Pose(tip_x=-0.1, tip_y=0.1)), [0.85, 1.15, 0])
    np.testing.assert_allclose(block.placed(x, y, Pose(1.0, 0.25, tip_x=0.1, tip_y=0.2)), [1.15, 0.55, 1.25])


@pytest.mark.parametrize("slope", [1.0, -1.0, 0.5, 2.0, 1e-9])
def test_a_tip_of_any_slope_lifts_a_face(slope: float) -> None:
    block = Box(6.0, 2.0, 8.0)
    x, y = np.array([2.0, -2.0, 4.0]), np.array([0.5, -0.5, 0.0])
    np.testing.assert_allclose(block.placed(x, y, Pose(tip_x=slope)), [8 + 2 * slope, 8 - 2 * slope, 0], rtol=1e-14)
    np.testing.assert_allclose(block.placed(x, y, Pose(tip_y=slope)), [8 + slope / 2, 8 - slope / 2, 0], rtol=1e-14)
