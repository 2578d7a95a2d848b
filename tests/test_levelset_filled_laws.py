"""Closed outlines: they enclose what lies above the level, along the border too, and leave out gaps of the field."""

from __future__ import annotations

from itertools import pairwise

import contourpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reading_svg import area_of

from varishold.levelset import find_contacts
from varishold.levelset.outline import outlines_at

few = settings(max_examples=60)
seeds = st.integers(0, 2**32 - 1)


def hills(rng: np.random.Generator, rows: int, cols: int) -> np.ndarray:
    frame = rng.uniform(0.2, 1.0, (rows, cols))
    wide = np.pad(frame, 1, mode="edge")
    return wide[:-2, 1:-1] + wide[2:, 1:-1] + wide[1:-1, :-2] + wide[1:-1, 2:] + 2 * frame


@few
@given(seeds, st.integers(1, 9), st.integers(1, 9), st.floats(0.05, 0.95))
def test_they_enclose_what_contourpy_fills(seed: int, rows: int, cols: int, share: float) -> None:
    frame = hills(np.random.default_rng(seed), rows, cols)
    level = float(np.quantile(frame, share)) + 1e-9
    (lines,) = outlines_at(frame, None, 0, [level], (2.0, 0.5), closed=True).by_level()
    x = np.concatenate([[-cols / 2], np.arange(cols) + 0.5 - cols / 2, [cols / 2]]) * 0.5
    y = np.concatenate([[-rows / 2], np.arange(rows) + 0.5 - rows / 2, [rows / 2]]) * 2.0
    maker = contourpy.contour_generator(x, y, np.pad(frame, 1, mode="edge"), fill_type="OuterOffset")
    enclosed = 0.0
    for points, offsets in zip(*maker.filled(level, np.inf), strict=True):
        parts = [area_of(points[a : b - 1]) for a, b in pairwise(offsets)]
        enclosed += abs(parts[0]) - sum(map(abs, parts[1:]))
    assert sum(map(area_of, lines)) == pytest.approx(enclosed, abs=1e-9)
    for line in lines:
        assert np.all(np.abs(line) <= [0.25 * cols, rows])
        assert np.any(line != np.roll(line, 1, axis=0), axis=1).all()


@few
@given(seeds, st.integers(2, 9), st.integers(2, 9))
def test_no_point_is_spare_along_the_border(seed: int, rows: int, cols: int) -> None:
    frame = hills(np.random.default_rng(seed), rows, cols)
    for lines in outlines_at(frame, None, 0, [0.0, float(np.median(frame))], (1.0, 1.0), closed=True).by_level():
        for line in lines:
            before, after = np.roll(line, 1, axis=0), np.roll(line, -1, axis=0)
            along = (before == line) & (line == after) & (np.abs(line) == [0.5 * cols, 0.5 * rows])
            assert not along.any()


def test_a_pad_that_is_all_in_is_its_rectangle() -> None:
    (lines,) = outlines_at(np.ones((3, 5)), None, 0, [0.5], (1.0, 1.0), closed=True).by_level()
    (line,) = lines
    assert {tuple(point) for point in line.tolist()} == {(-2.5, -1.5), (2.5, -1.5), (2.5, 1.5), (-2.5, 1.5)}
    assert area_of(line) == 15.0


def test_a_gap_is_a_hole() -> None:
    frame = np.ones((5, 5))
    frame[2, 2] = np.nan
    outer, hole = outlines_at(frame, None, 0, [0.5], (1.0, 1.0), closed=True).by_level()[0]
    if area_of(outer) < 0:
        outer, hole = hole, outer
    assert area_of(outer) == 25.0
    assert {tuple(point) for point in hole.tolist()} == {(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)}
    assert area_of(hole) == -2.0


@few
@given(seeds)
def test_with_gaps_they_close_and_shrink_as_the_level_rises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame = hills(rng, 8, 9)
    frame[rng.random(frame.shape) < 0.1] = -np.inf
    levels = np.quantile(frame[np.isfinite(frame)], [0.9, 0.6, 0.3, 0.0]).tolist()
    found = outlines_at(frame, None, 0, levels, (1.0, 1.0), closed=True)
    assert np.isfinite(found.points).all()
    areas = [sum(map(area_of, lines)) for lines in found.by_level()]
    assert all(low <= high + 1e-9 for low, high in pairwise(areas))
    assert all(len(line) > 2 for lines in found.by_level() for line in lines)


@few
@given(seeds, st.sampled_from([None, (0.002, 0.003)]))
def test_a_contact_alone_is_filled_in_its_place(seed: int, pitch: tuple[float, float] | None) -> None:
    frame = hills(np.random.default_rng(seed), 12, 14)
    floor = float(np.quantile(frame, 0.6))
    contacts = find_contacts(frame, 4, floor=floor, pitch=pitch)
    wide, high = (1.0, 1.0) if pitch is None else (pitch[1], pitch[0])
    for i in range(4):
        level = float(contacts[0].profile.threshold[i])
        apart = [
            line.tolist()
            for contact in contacts
            if contact.profile.measured[i] and contact.profile.threshold[i] == level
            for line in contact.filled([level]).by_level()[0]
        ]
        for contact in contacts:
            for line in contact.filled([level]).by_level()[0] if level >= contact.floor else []:
                rows, cols = contact.window
                x, y = (line / [wide, high] + [7.0, 6.0]).T
                assert cols.start - 1 <= x.min() <= x.max() <= cols.stop + 1
                assert rows.start - 1 <= y.min() <= y.max() <= rows.stop + 1
        whole = outlines_at(frame, None, 0, [level], (high, wide), closed=True).by_level()[0]
        if level >= floor and all(c.profile.threshold[i] == level for c in contacts):
            assert sum(map(area_of, map(np.array, apart))) == pytest.approx(
                sum(map(area_of, whole)), rel=1e-9, abs=1e-15
            )


@pytest.mark.parametrize("n", [1, 40])
def test_many_points_find_room(n: int) -> None:
    """A chessboard has more points than there is at first room for."""
    frame = np.indices((40, 41)).sum(axis=0) % 2 + np.linspace(0, 0.4, 41)
    levels = np.linspace(0.5, 0.9, n).tolist()
    together = outlines_at(frame, None, 0, levels, (1.0, 1.0), closed=True)
    assert len(together.points) > 128 * n
    for level, lines in zip(levels, together.by_level(), strict=True):
        (alone,) = outlines_at(frame, None, 0, [level], (1.0, 1.0), closed=True).by_level()
        assert [line.tolist() for line in lines] == [line.tolist() for line in alone]
