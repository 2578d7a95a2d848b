"""What goes on beyond the pad is named no surer than what is seen of it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from varishold import Surface, find_contacts, recognize
from varishold.touch.cut import corner_alone, falls_off_all_round, goes_across

SIDE, FINE = 32, 4
FLAT = "it goes on beyond the pad and its sections hardly grow: a flat bar may look like this"
CORNER = "two borders of the pad that meet cut it: how far it goes on either way is not seen"
BENDS = "it falls off to every border: a plane, or a ball or a cushion that is larger than the pad"
CREST = "it is a narrow crest that leaves the pad at both ends: an edge, or a bar, round or flat"
PIECES = "it is many pieces, and what goes on beyond the pad is one: readings may have come round at their end"
# Points within taxels, from the pad's centre.
ROW, COL = (np.indices((FINE * SIDE,) * 2) + 0.5) / FINE - SIDE / 2


def frame_of(heights: NDArray[np.float64], rng: np.random.Generator, noise: float = 0.015) -> NDArray[np.float64]:
    """Return what taxels read of heights at finer points, each the mean of its own."""
    means = heights.reshape(SIDE, FINE, SIDE, FINE).mean(axis=(1, 3))
    frame: NDArray[np.float64] = 100.0 * (means + rng.normal(0.0, noise, means.shape))
    return frame


def seen_as(heights: NDArray[np.float64], rng: np.random.Generator) -> Surface:
    return recognize(find_contacts(frame_of(heights, rng))[0])


def across(half: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return how far from the middle line of a bar across the pad points are, in halves of its breadth."""
    angle, off = rng.uniform(0.0, np.pi), rng.uniform(-2.0, 2.0)
    line: NDArray[np.float64] = (np.cos(angle) * COL + np.sin(angle) * ROW - off) / half
    return line


@pytest.mark.parametrize("half", [3.5, 5.0, 7.0])
def test_a_flat_bar_across_the_pad_is_surely_no_lying_cylinder(half: float) -> None:
    rng = np.random.default_rng(int(half))
    for _ in range(12):
        surface = seen_as((np.abs(across(half, rng)) < 1.0) * 1.0, rng)
        assert surface.name != "lying cylinder" or surface.probability <= 0.55 + 1e-9
        assert (FLAT in surface.reasons) == (surface.name == "lying cylinder")


@pytest.mark.parametrize("power", [0.5, 1.0])
@pytest.mark.parametrize("half", [3.5, 5.0, 7.0])
def test_a_round_one_is_as_sure_as_before(power: float, half: float) -> None:
    # On an elastic body (Hertz), and on springs.
    rng = np.random.default_rng(int(half))
    for _ in range(12):
        surface = seen_as(np.maximum(1.0 - across(half, rng) ** 2, 0.0) ** power, rng)
        assert surface.name == "lying cylinder"
        assert surface.probability > 0.9
        assert FLAT not in surface.reasons


@pytest.mark.parametrize("turns", range(4))
def test_of_one_corner_nobody_knows_whether_it_is_a_square(turns: int) -> None:
    rng = np.random.default_rng(turns)
    for first in (-6.0, -2.0, 3.0):
        corner = np.rot90((first < COL) & (first < ROW), turns) * 1.0
        contact = find_contacts(frame_of(corner, rng))[0]
        assert corner_alone(contact)
        surface = recognize(contact)
        assert surface.name not in ("square pillar", "rectangular pillar") or surface.probability <= 0.85 + 1e-9
        assert (CORNER in surface.reasons) == (surface.form in ("pillar", "frustum"))


@pytest.mark.parametrize(
    ("heights", "why"),
    [
        (np.maximum(np.abs(ROW), np.abs(COL)) < 9.0, "whole"),
        ((np.abs(ROW) < 9.0) & (COL > 0.0), "one border"),
        (np.abs(ROW) < 6.0, "two that do not meet"),
        (np.abs(COL - 6.0) + np.abs(ROW - 6.0) < 12.0, "corners of a square on edge"),
    ],
)
def test_other_contacts_are_no_corners(heights: NDArray[np.bool_], why: str) -> None:
    contact = find_contacts(frame_of(heights * 1.0, np.random.default_rng(1)))[0]
    assert not corner_alone(contact), why


def test_a_ball_larger_than_the_pad_is_surely_no_plane() -> None:
    rng = np.random.default_rng(2)
    for radius in (0.75, 0.9, 1.0):
        x, y = rng.uniform(-2.0, 2.0, 2)
        surface = seen_as(1.0 - ((ROW - y) ** 2 + (COL - x) ** 2) / (radius * SIDE) ** 2, rng)
        assert surface.name == "plane"
        assert surface.probability <= 0.55 + 1e-9
        assert BENDS in surface.reasons


def test_a_flat_or_sloping_plane_does_not_fall_off_all_round() -> None:
    rng = np.random.default_rng(3)
    for slope in (0.0, 0.3, 0.8):
        contact = find_contacts(frame_of(1.0 + slope * across(SIDE / 2, rng), rng))[0]
        assert not falls_off_all_round(contact)
        assert BENDS not in recognize(contact).reasons


def test_where_no_taxels_are_within_nothing_falls_off() -> None:
    around = np.maximum(np.abs(np.arange(SIDE)[:, None] - 15.5), np.abs(np.arange(SIDE) - 15.5)) > 11.0
    contact = find_contacts(np.ones((SIDE, SIDE)), field=around)[0]
    assert all(contact.borders)
    assert not falls_off_all_round(contact)


def bar_across(side: int, breadth: float, angle: float, spread: float, power: float, seed: int) -> Surface:
    """Return what a bar across a pad is called, by taxels behind a cover that spreads; power 0 is flat."""
    row, col = (np.indices((8 * side,) * 2) + 0.5) / 8 - side / 2
    off = np.abs(np.cos(angle) * col + np.sin(angle) * row) / (breadth / 2)
    height = (off < 1.0) * np.maximum(1.0 - off**2, 0.0) ** power
    height = gaussian_filter(height, 8 * spread, mode="nearest").reshape(side, 8, side, 8).mean(axis=(1, 3))
    return recognize(find_contacts(height + np.random.default_rng(seed).normal(0, 0.01, height.shape))[0])


@pytest.mark.parametrize("side", [8, 12, 16])
def test_a_narrow_flat_bar_across_a_small_pad_is_surely_no_lying_cylinder(side: int) -> None:
    called = 0
    for seed in range(24):
        angle, breadth, spread = np.random.default_rng([side, seed]).uniform((0.0, 2.0, 0.0), (np.pi, 5.0, 0.5))
        surface = bar_across(side, breadth, angle, spread, 0.0, seed)
        if surface.name == "lying cylinder":
            called += 1
            assert surface.probability <= 0.55 + 1e-9
            assert FLAT in surface.reasons
    assert called >= 6


@pytest.mark.parametrize("power", [0.5, 1.0])
def test_a_crest_of_few_taxels_across_is_surely_no_edge(power: float) -> None:
    for seed in range(24):
        angle, breadth, spread = np.random.default_rng(seed).uniform((0.0, 1.2, 0.0), (np.pi, 3.0, 0.4))
        surface = bar_across(8, breadth, angle, spread, power, seed)
        assert surface.name != "edge" or surface.probability <= 0.55 + 1e-9
        assert (CREST in surface.reasons) <= (surface.name == "edge")


@pytest.mark.parametrize("turns", range(4))
def test_a_face_that_ends_in_one_border_is_no_crest(turns: int) -> None:
    rng = np.random.default_rng(turns)
    for angle in (0.0, 0.3, np.pi / 4, 1.2):
        line = np.cos(angle) * COL + np.sin(angle) * ROW
        for first in (-6.0, 0.0, 9.0):
            contact = find_contacts(frame_of(np.rot90(line > first, turns) * 1.0, rng))[0]
            assert not goes_across(contact)
            assert CREST not in recognize(contact).reasons
        strip = find_contacts(frame_of(np.rot90(np.abs(line) < 4.0, turns) * 1.0, rng))[0]
        assert goes_across(strip)
    assert not goes_across(find_contacts(frame_of((np.hypot(ROW, COL) < 9.0) * 1.0, rng))[0])


@pytest.mark.parametrize("side", [16, 24, 32])
def test_readings_that_came_round_at_their_end_are_surely_no_edge_and_no_plane(side: int) -> None:
    row, col = np.indices((side, side)) - (side - 1) / 2
    told = 0
    for seed in range(30):
        rng = np.random.default_rng([side, seed])
        y, x = rng.uniform(-0.1, 0.1, 2) * side
        form = np.maximum(1.0 - np.hypot(row - y, col - x) / (rng.uniform(0.2, 0.35) * side), 0.0)
        counts = np.rint(rng.choice([300, 600, 1000]) * (form + rng.normal(0, 0.01, form.shape))).astype(np.int64)
        for contact in find_contacts(counts % 256)[:1]:
            surface = recognize(contact)
            assert surface.name not in ("edge", "plane") or surface.probability <= 0.55 + 1e-9
            told += PIECES in surface.reasons
    assert told or side == 16


def test_a_noisy_plane_and_edge_are_whole() -> None:
    rng = np.random.default_rng(5)
    for heights in (np.ones_like(COL), (COL > 2.0) * 1.0):
        for noise in (0.01, 0.08, 0.15):
            surface = recognize(find_contacts(frame_of(heights, rng, noise))[0])
            assert surface.name in ("plane", "edge")
            assert PIECES not in surface.reasons
