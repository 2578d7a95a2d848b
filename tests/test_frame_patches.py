"""Masks as whole numbers against a slow reference that goes from taxel to taxel."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from varishold.frame.patches import PatchGrid

shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))
masks = shapes.flatmap(lambda shape: arrays.arrays(np.bool_, shape))
pairs = shapes.flatmap(lambda shape: st.tuples(*[arrays.arrays(np.bool_, shape)] * 2))


def around(shape, taxel):
    """The taxel and its eight neighbours inside the pad."""
    row, col = taxel
    return {
        (r, c)
        for r in range(max(row - 1, 0), min(row + 2, shape[0]))
        for c in range(max(col - 1, 0), min(col + 2, shape[1]))
    }


def taxels(mask):
    return {(int(r), int(c)) for r, c in np.argwhere(mask)}


def patches(mask):
    """The connected patches of a mask, by flooding."""
    left, found = taxels(mask), []
    while left:
        patch, edge = set(), {left.pop()}
        while edge:
            taxel = edge.pop()
            patch.add(taxel)
            near = around(mask.shape, taxel) & left
            left -= near
            edge |= near
        found.append(patch)
    return found


@given(masks)
def test_a_mask_comes_back_from_its_number(mask):
    grid = PatchGrid(mask.shape)
    assert np.array_equal(grid.mask(grid.bits(mask)), mask)
    assert grid.bits(mask).bit_count() == mask.sum()
    assert grid.all == grid.bits(np.ones(mask.shape, bool))


@given(masks, st.integers(0, 3))
def test_growing_takes_every_neighbour(mask, by):
    grid = PatchGrid(mask.shape)
    grown = taxels(mask)
    for _ in range(by):
        grown = set().union(*(around(mask.shape, taxel) for taxel in grown)) if grown else grown
    assert taxels(grid.mask(grid.grown(grid.bits(mask), by))) == grown


@given(masks)
def test_crowded_taxels_have_two_neighbours_and_stand_in_every_patch_of_three(mask):
    grid, inside = PatchGrid(mask.shape), taxels(mask)
    crowded = {taxel for taxel in inside if len(around(mask.shape, taxel) & inside) >= 3}
    assert taxels(grid.mask(grid.crowded(grid.bits(mask)))) == crowded
    for patch in patches(mask):
        assert bool(patch & crowded) == (len(patch) >= 3)


@given(masks)
def test_parts_are_the_patches(mask):
    grid = PatchGrid(mask.shape)
    parts = [frozenset(taxels(grid.mask(part))) for part in grid.parts(grid.bits(mask))]
    assert sorted(map(sorted, parts)) == sorted(map(sorted, patches(mask)))


@given(pairs)
def test_joining_finds_what_is_connected_with_a_seed(pair):
    seeds, through = pair
    grid = PatchGrid(seeds.shape)
    wanted = set().union(*(patch for patch in patches(through) if patch & taxels(seeds)))
    assert taxels(grid.mask(grid.joined(grid.bits(seeds), grid.bits(through)))) == wanted
