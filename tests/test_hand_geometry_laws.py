"""Where things are: surfaces and near sides by plain rays, what is set at once, what is seen of the scene."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

import mujoco

from varishold.hand import PAPER_22, HandDesign, Randomization, grasping
from varishold.hand.bench import Bench
from varishold.hand.model import CARRIAGE, build
from varishold.hand.objects import OBJECTS, SIZE_RANGE_M, STRANGERS, TABLE_5_OBJECTS, graspable
from varishold.hand.pads import surface_before
from varishold.solids import Solid

DESIGN = HandDesign()
STILL = Randomization().draw(np.random.default_rng(0), n_switches=22, still=True)
ALL = [*OBJECTS, *STRANGERS, "lump-3", "lump-4", "assembly-2", "assembly-6", "variant-3", "variant-5"]


def first_hit(solid: Solid, start: np.ndarray, way: np.ndarray) -> float:
    """Where a ray first meets a solid; infinite where it misses."""
    return float(np.min([part.hits(start[None], way)[0] for part in solid.body()]))


def turned(rng: np.random.Generator) -> np.ndarray:
    """Return axes that are drawn, as columns."""
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return axes * np.sign(np.linalg.det(axes))


# Before pads


@given(st.integers(0, 10**6), st.sampled_from(["l-block", "triangular-prism", "cone", "ellipsoid", "lump-4"]))
@settings(max_examples=25)
def test_the_surface_before_a_pad_is_met_by_a_ray_from_each_point(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    solid = graspable(name, 0.08)
    pad, place, axes = turned(rng), rng.uniform(-0.01, 0.01, 3), turned(rng)
    across, up, outward = pad.T
    middle = np.array([0.0, 0.0, 0.03])
    # The pad looks at the object's middle from where its surface begins, up to a few millimetres.
    in_object = -axes.T @ outward
    begins = first_hit(solid, middle - 0.5 * -in_object, -in_object)
    assume(np.isfinite(begins))
    origin = place + axes @ (middle - 0.5 * -in_object + begins * -in_object) + rng.uniform(-0.004, 0.004) * outward
    bench: Any = SimpleNamespace(
        solid=solid, pad_frame=lambda part: (origin, across, up, outward), object_pose=lambda: (place, axes)
    )
    rows, cols, pitch = 3, 5, 0.004
    found = surface_before(bench, "palm", (rows, cols), pitch)
    told = np.full((2 * rows, 2 * cols), -math.inf)
    for row, col in np.ndindex(*told.shape):
        # Two points a taxel, a quarter of a pitch to either side of its middle.
        aside = (col // 2 - (cols - 1) / 2 + (0.25 if col % 2 else -0.25)) * pitch
        above = (row // 2 - (rows - 1) / 2 + (0.25 if row % 2 else -0.25)) * pitch
        # Rays begin 15 mm behind the pad.
        start = origin + aside * across + above * up - 0.015 * outward
        told[row, col] = 0.015 - first_hit(solid, axes.T @ (start - place), axes.T @ outward)
    if told.max() <= -0.012:
        assert found is None
        return
    assert found is not None
    # What lies 12 mm deeper than the highest point cannot touch.
    np.testing.assert_allclose(found, np.maximum(told, told.max() - 0.012), atol=1e-9)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("yaw", [0.0, 0.4, -0.9, 2.0, -2.6])
def test_a_solid_s_near_side_is_where_a_wall_first_meets_it(name: str, yaw: float) -> None:
    solid = graspable(name, 0.07)
    c, s = math.cos(yaw), math.sin(yaw)
    # Along the world's x, as the turned solid sees it.
    way = np.array([c, -s, 0.0])
    side, height = np.meshgrid(np.linspace(-0.09, 0.09, 361), np.linspace(2e-4, 0.2, 140))
    starts = -way + side.reshape(-1, 1) * np.array([s, c, 0.0]) + height.reshape(-1, 1) * np.array([0.0, 0.0, 1.0])
    met = np.min([part.hits(starts, way) for part in solid.body()], axis=0)
    near = 1.0 - float(met.min())
    assert near - 1e-9 <= grasping._near_side(solid, yaw) <= near + 5e-4


def test_what_is_round_is_as_near_from_every_side() -> None:
    for name in ("cylinder", "sphere"):
        assert {grasping._near_side(graspable(name, 0.08), yaw) for yaw in np.linspace(-3, 3, 20)} == {0.04}


# At once


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench(graspable("box", 0.07), STILL)


def places(bench: Bench) -> np.ndarray:
    """Where every body is now, as others ask it."""
    return np.array(bench.data.xpos)


@pytest.mark.parametrize("how", ["carriage", "object", "reset"])
def test_what_is_set_at_once_is_seen_at_once(bench: Bench, how: str) -> None:
    bench.reset()
    bench.place_object(0.12, 0.0, 0.0)
    if how != "carriage":
        bench.put_carriage({"reach": -0.03})
    before = places(bench)
    if how == "carriage":
        bench.put_carriage({"reach": -0.05, "shift": 0.02, "raise": 0.03, "turn": 0.2})
        np.testing.assert_allclose(bench.data.body("arm").xpos, [-0.05, 0.02, 0.03], atol=1e-12)
        np.testing.assert_allclose(bench.pad_frame("palm")[3], [math.cos(0.2), math.sin(0.2), 0.0], atol=1e-12)
    elif how == "object":
        bench.place_object(0.2, 0.05, 0.7)
        place, axes = bench.object_pose()
        np.testing.assert_allclose(place, [0.2, 0.05, bench.table_m], atol=1e-12)
        np.testing.assert_allclose(axes[:, 0], [math.cos(0.7), math.sin(0.7), 0.0], atol=1e-12)
    else:
        bench.reset()
        assert bench.target == dict.fromkeys(CARRIAGE, 0.0)
        np.testing.assert_allclose(bench.data.body("arm").xpos, 0.0, atol=1e-12)
    seen = places(bench)
    assert not np.allclose(seen, before)
    mujoco.mj_forward(bench.model, bench.data)
    np.testing.assert_array_equal(places(bench), seen)
    # The drives hold it there.
    drives = [bench.model.actuator(name).id for name in CARRIAGE]
    np.testing.assert_allclose(bench.data.ctrl[drives], [bench.target[name] for name in CARRIAGE])


# What is seen


@pytest.mark.parametrize("name", ["cylinder", "sphere", "torus"])
def test_colours_are_shares_and_lights_add_up_to_white(name: str) -> None:
    model = build(DESIGN, PAPER_22, graspable(name, 0.08), STILL)
    for colours in (model.geom_rgba, model.site_rgba):
        assert colours.min() >= 0
        assert colours.max() <= 1
    # All that touches is seen but the table's plane, which a round top stands for; and what only measures is not.
    for g in range(model.ngeom):
        assert model.geom_rgba[g][3] == (0 if model.geom(g).name == "table" else 1)
    assert not model.site_rgba[:, 3].any()
    head = model.vis.headlight
    np.testing.assert_allclose(head.ambient + head.diffuse, 1.0, atol=1e-6)
    # Hand, buttons, object and table are told apart.
    seen = {tuple(np.round(model.geom(g).rgba, 2)) for g in ("palm", "palm_centre", "object.0")}
    assert len(seen) == 3


def test_the_top_that_is_seen_lies_right_under_what_stands_on_it() -> None:
    model = build(DESIGN, PAPER_22, graspable("cylinder", 0.08), STILL)
    table = model.body("table").id
    (top,) = (g for g in range(model.ngeom) if model.geom_bodyid[g] == table and model.geom(g).name != "table")
    radius, half = model.geom_size[top][:2]
    x, y, z = model.geom_pos[top]
    assert -0.001 <= z + half < 0
    assert y == 0
    # It bears whatever the hand can grip, wherever that may stand, and does not reach far behind the palm.
    reach = 0.10 + Randomization().search_m
    assert abs(reach - x) + SIZE_RANGE_M[1] / 2 < radius
    assert radius - x <= 0.10


def test_table_5_s_objects_can_be_gripped() -> None:
    for name, size_m in TABLE_5_OBJECTS:
        assert graspable(name, size_m).body()
    sizes = {kind: [size for name, size in TABLE_5_OBJECTS if name == kind] for kind, _ in TABLE_5_OBJECTS}
    for several in sizes.values():
        # Five sizes, a centimetre apart.
        np.testing.assert_allclose(np.diff(several), 0.01)
        assert len(several) == 5
