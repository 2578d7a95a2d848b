"""A scene is what the bench holds, seen from the carriage."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[sim]'")

from varishold.hand import Bench, HandSetting, set_up
from varishold.hand.coordinates import phalanges
from varishold.hand.scene import SceneBody, take_scene

RED = (219, 69, 56)


@pytest.fixture
def bench() -> Bench:
    return set_up("hexagonal-prism", 0.06, seed=3, setting=HandSetting())[0]


def of_kind(scene: tuple[SceneBody, ...], kind: str) -> list[SceneBody]:
    return [body for body in scene if body.kind == kind]


def test_everything_that_can_be_seen_is_there_once(bench: Bench) -> None:
    scene = take_scene(bench)
    assert len(scene) == sum(bench.model.geom_rgba[:, 3] > 0)
    assert {body.kind for body in scene} == {"sphere", "capsule", "cylinder", "box", "mesh"}
    assert sum((body.corners_m is None) != (body.kind == "mesh") for body in scene) == len(scene)


def test_capsules_are_the_phalanges_that_the_angles_give(bench: Bench) -> None:
    bench.close_all()
    bench.advance(0.3)
    found = phalanges(bench.sense().angles_rad, bench.design)
    capsules = of_kind(take_scene(bench), "capsule")
    middles = found.start_m + found.length_m[:, None] * found.along / 2
    for middle, length, radius in zip(middles, found.length_m, found.radius_m, strict=True):
        # A broad phalanx is two capsules, one above and one below its middle; the carriage gives way by .1 mm.
        near = [
            body
            for body in capsules
            if np.allclose(body.place_m[:2], middle[:2], atol=1e-3) and abs(body.place_m[2] - middle[2]) < 0.015
        ]
        assert near
        for body in near:
            assert body.half_m[:2] == pytest.approx((radius, length / 2), abs=1e-6)


def test_a_mesh_lies_where_the_object_lies(bench: Bench) -> None:
    (mesh,) = of_kind(take_scene(bench), "mesh")
    assert mesh.corners_m is not None
    assert mesh.faces is not None
    (part,) = bench.solid.body()
    place, axes = bench.object_pose()
    there = np.asarray(part.corners_m) @ axes.T + place
    drawn = mesh.corners_m @ mesh.turn.T + mesh.place_m
    apart = np.linalg.norm(there[:, None] - drawn[None], axis=2)
    assert apart.min(axis=0).max() < 1e-6
    assert apart.min(axis=1).max() < 1e-6
    # Faces turn outward: together they hold the solid's volume, and no less.
    a, b, c = np.moveaxis(mesh.corners_m[mesh.faces], 1, 0)
    low, high = there.min(axis=0), there.max(axis=0)
    assert 0.5 < (a * np.cross(b, c)).sum() / 6 / np.prod(high - low) < 1


def test_it_is_seen_from_the_carriage_wherever_that_stands(bench: Bench) -> None:
    before = take_scene(bench)
    where = {"reach": 0.02, "shift": -0.03, "turn": 0.7}
    bench.put_carriage(where)
    after = take_scene(bench)
    for old, new in zip(before, after, strict=True):
        # Table and object stay where they are.
        if old.kind in ("capsule", "box", "sphere"):
            assert new.place_m == pytest.approx(old.place_m, abs=1e-6)
            assert new.turn == pytest.approx(old.turn, abs=1e-6)
    (mesh,) = of_kind(after, "mesh")
    place, _ = bench.object_pose()
    c, s = np.cos(0.7), np.sin(0.7)
    x, y = place[0] - 0.02, place[1] + 0.03
    middle = mesh.place_m - np.array([c * x + s * y, -s * x + c * y, place[2]])
    assert np.abs(middle[:2]).max() < 1e-6


def test_a_closed_switch_is_red_and_an_open_one_is_not(bench: Bench) -> None:
    bench.closed[:] = False
    assert RED not in [body.colour for body in take_scene(bench)]
    bench.closed[0] = True
    red = [body for body in take_scene(bench) if body.colour == RED]
    assert red
    assert len({body.kind for body in red}) == 1
