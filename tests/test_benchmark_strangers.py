"""The things that nobody knows, by which the benchmarks see who notices."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks._strangers import STRANGERS, to_touch
from varishold.hand.objects import OBJECTS
from varishold.hand.objects import STRANGERS as NAMED
from varishold.solids import MeshSolid

MADE = [name for name in STRANGERS if name not in NAMED]


def test_there_are_23_kinds_and_none_is_known() -> None:
    assert len(STRANGERS) == len(set(STRANGERS)) == 23
    assert not set(STRANGERS) & set(OBJECTS)
    assert all(to_touch(name, 0.06) == name for name in NAMED)


@pytest.mark.parametrize("name", MADE)
@pytest.mark.parametrize("size_m", [0.055, 0.105])
def test_a_stranger_stands_on_the_base_plane_and_is_as_broad_as_was_asked(name: str, size_m: float) -> None:
    thing = to_touch(name, size_m)
    assert isinstance(thing, MeshSolid)
    low = min(part.centre_m[2] - part.half_m[2] for part in thing.parts)
    assert low == pytest.approx(0.0, abs=1e-9)
    # A star of five points is a little narrower across than the circle about it.
    assert 0.95 * size_m <= thing.extents_m[1] <= 1.001 * size_m
    assert 0.04 < thing.top_m <= 0.17


def test_a_star_is_hollow_between_its_points_and_a_drop_is_pointed() -> None:
    star, drop = to_touch("star prism", 0.1), to_touch("drop-shaped prism", 0.1)
    assert isinstance(star, MeshSolid)
    assert isinstance(drop, MeshSolid)
    turn = 2 * np.pi * np.arange(10) / 10
    at = 0.035 * np.column_stack([np.cos(turn), np.sin(turn)])
    inside = star.height(at[:, 0], at[:, 1]) > 0
    assert inside.tolist() == [True, False] * 5
    ends = drop.height(np.array([0.06, -0.06]), np.zeros(2)) > 0
    assert ends.tolist() == [True, False]


def test_a_slanting_pillar_falls_from_its_whole_height_to_a_third() -> None:
    thing = to_touch("slanting pillar", 0.09)
    assert isinstance(thing, MeshSolid)
    x = np.array([-0.044, 0.0, 0.044])
    np.testing.assert_allclose(thing.height(x, np.zeros(3)), np.interp(x, [-0.045, 0.045], [0.16, 0.16 / 3]), atol=1e-6)
