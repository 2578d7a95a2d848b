"""Solids that no library knows: their faces are what rays from above hit, and a lump is always the same lump."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.hand.objects import STRANGERS, graspable
from varishold.solids import Assembly, Ellipsoid, HalfCylinder, LBlock, Lump, Solid, Torus, Variant

SIZE_M = 0.07


def from_above(solid: Solid, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    high = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 1.0)])
    reach = np.min([part.hits(high, np.array([0.0, 0.0, -1.0])) for part in solid.body()], axis=0)
    return np.where(np.isfinite(reach), 1.0 - reach, 0.0).reshape(x.shape)


@pytest.mark.parametrize(
    ("solid", "near_m"),
    [
        (HalfCylinder.of_size(SIZE_M), 1e-9),
        (LBlock.of_size(SIZE_M), 1e-9),
        (Torus.of_size(SIZE_M), 2e-3),
        (Lump.of_size(SIZE_M), 1e-9),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_a_face_is_what_is_seen_from_above(solid: Solid, near_m: float) -> None:
    grid = np.linspace(-0.06, 0.06, 41) + 1e-4
    x, y = np.meshgrid(grid, grid)
    face, body = solid.height(x, y), from_above(solid, x, y)
    # Straight pieces stand for round ones: their rims may differ.
    same = np.abs(face - body) <= near_m
    assert same.mean() > 0.98
    assert face.max() == pytest.approx(solid.top_m, abs=near_m)


def test_an_ellipsoids_face_is_its_upper_half() -> None:
    solid = Ellipsoid.of_size(SIZE_M)
    x, y = np.meshgrid(np.linspace(-0.05, 0.05, 21), np.linspace(-0.03, 0.03, 21))
    lifted = solid.height(x, y) + solid.height_m / 2
    inside = solid.height(x, y) > 0
    assert np.allclose(lifted[inside], from_above(solid, x, y)[inside])


def test_strangers_are_as_broad_as_they_are_called() -> None:
    grid = np.linspace(-0.08, 0.08, 641)
    x, y = np.meshgrid(grid, grid)
    for name in STRANGERS:
        covered = graspable(name, SIZE_M).height(x, y) > 0
        breadths = [np.ptp(grid[covered.any(axis=axis)]) for axis in (0, 1)]
        assert min(breadths) == pytest.approx(SIZE_M * (0.5 if name == "half-cylinder" else 1.0), abs=1e-3)


@pytest.mark.parametrize("number", range(1, 30))
def test_a_lump_is_one_solid_of_its_size(number: int) -> None:
    lump = graspable(f"lump-{number}", SIZE_M)
    assert lump == graspable(f"lump-{number}", SIZE_M)
    corners = np.vstack([part.corners_m for part in lump.body()])
    again = np.vstack([part.corners_m for part in Lump(SIZE_M, number).body()])
    assert np.array_equal(corners, again)
    assert np.ptp(corners[:, 1]) == pytest.approx(SIZE_M)
    assert corners[:, 2].min() == pytest.approx(0.0)


@pytest.mark.parametrize(("kind", "number"), [(kind, n) for kind in (Assembly, Variant) for n in range(1, 41)])
def test_what_is_made_by_chance_is_one_thing_of_its_size(kind: type[Assembly | Variant], number: int) -> None:
    thing = graspable(f"{kind.name}-{number}", SIZE_M)
    assert thing == graspable(f"{kind.name}-{number}", SIZE_M)
    parts = [np.asarray(part.corners_m) for part in thing.body()]
    corners = np.vstack(parts)
    again = np.vstack([part.corners_m for part in kind(SIZE_M, number).body()])
    assert np.array_equal(corners, again)
    assert np.ptp(corners[:, 1]) == pytest.approx(SIZE_M)
    assert corners[:, 2].min() == pytest.approx(0.0)
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    assert low == pytest.approx(-high, abs=1e-9)
    # Every part meets another one: it is a single thing.
    boxes = [(part.min(axis=0), part.max(axis=0)) for part in parts]
    for k, (least, most) in enumerate(boxes):
        rest = [box for j, box in enumerate(boxes) if j != k]
        assert not rest or any((least <= b + 1e-9).all() and (a <= most + 1e-9).all() for a, b in rest)


def test_assemblies_differ_and_hold_one_to_four_parts() -> None:
    counts = [len(Assembly(SIZE_M, number).body()) for number in range(1, 60)]
    assert set(counts) == {1, 2, 3, 4}
    assert len({str(Assembly(SIZE_M, number).body()) for number in range(1, 60)}) == 59
    assert Assembly.of_size(0.14).breadth_m == 0.14
    tall = Assembly(0.14, 3)
    assert tall.top_m == pytest.approx(2 * Assembly(0.07, 3).top_m)
    assert tall.height(np.zeros(1), np.zeros(1))[0] <= tall.top_m + 1e-9


def test_variants_differ_and_most_are_as_tall_as_what_they_vary() -> None:
    made = [Variant(SIZE_M, number) for number in range(1, 200)]
    assert len({str(one.body()) for one in made}) == len(made)
    tall = np.array([one.top_m for one in made])
    assert 0.4 < np.mean(np.isclose(tall, graspable("cylinder", SIZE_M).top_m)) < 0.7
    assert tall.max() <= 0.2 + 1e-9
    # What is as tall at any size is no copy of itself on another scale.
    assert any(np.isclose(Variant(0.12, k).top_m, Variant(0.06, k).top_m) for k in range(1, 9))
