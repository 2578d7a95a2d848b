"""Sections equal contourpy's filled polygons and lines; holes and parts equal OpenCV's."""

from __future__ import annotations

import itertools

import contourpy
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.levelset import DIRECTIONS, find_contacts, outlines


def smooth(rng: np.random.Generator, shape: tuple[int, int], times: int) -> np.ndarray:
    frame = rng.normal(0.0, 1.0, shape)
    for _ in range(times):
        wide = np.pad(frame, 1, mode="edge")
        frame = (wide[:-2, 1:-1] + wide[2:, 1:-1] + wide[1:-1, :-2] + wide[1:-1, 2:] + 2 * wide[1:-1, 1:-1]) / 6
    return frame - frame.min() + 0.01


def generator(frame: np.ndarray) -> contourpy.ContourGenerator:
    rows, cols = frame.shape
    x = np.r_[-0.5, np.arange(cols), cols - 0.5] - (cols - 1) / 2
    y = np.r_[-0.5, np.arange(rows), rows - 0.5] - (rows - 1) / 2
    return contourpy.contour_generator(
        x, y, np.pad(frame, 1, mode="edge"), name="serial", fill_type="OuterOffset", line_type="Separate"
    )


def moments(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    x0, x1, y0, y1 = x[:-1], x[1:], y[:-1], y[1:]
    cross = x0 * y1 - x1 * y0
    return np.array(
        [
            cross.sum() / 2,
            ((x0 + x1) * cross).sum() / 6,
            ((y0 + y1) * cross).sum() / 6,
            ((x0 * x0 + x0 * x1 + x1 * x1) * cross).sum() / 12,
            ((x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0) * cross).sum() / 24,
            ((y0 * y0 + y0 * y1 + y1 * y1) * cross).sum() / 12,
        ]
    )


def expected(frame: np.ndarray, level: float) -> dict[str, object]:
    gen = generator(frame)
    polygons, offsets = gen.filled(level, np.inf)
    total = np.zeros(6)
    for points, offset in zip(polygons, offsets, strict=True):
        for a, b in itertools.pairwise(offset):
            total += moments(points[a:b, 0], points[a:b, 1])
    perimeter = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in gen.lines(level))
    points = np.concatenate(polygons) if polygons else np.zeros((1, 2))
    return {
        "moments": total,
        "perimeter": perimeter,
        "parts": len(polygons),
        "holes": sum(len(offset) - 2 for offset in offsets),
        "extent": np.ptp(points @ np.array([np.cos(DIRECTIONS), np.sin(DIRECTIONS)]), axis=0),
    }


def raw_moments(profile, i: int) -> np.ndarray:
    area = profile.area[i]
    if area == 0:
        return np.zeros(6)
    x, y = profile.centroid[i]
    (xx, xy), (_, yy) = profile.covariance[i]
    return area * np.array([1, x, y, xx + x * x, xy + x * y, yy + y * y])


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    rows=st.integers(1, 20),
    cols=st.integers(1, 20),
    times=st.integers(0, 6),
    plateaus=st.booleans(),
)
def test_every_section_equals_contourpy(seed, rows, cols, times, plateaus):
    rng = np.random.default_rng(seed)
    frame = smooth(rng, (rows, cols), times)
    if plateaus:
        frame = np.round(frame, 1) + 0.01
    # Above half of the highest peak no saddle can split a contact.
    floor = 0.51 * frame.max()
    levels = np.linspace(floor + 1e-7, frame.max(), 7)
    contacts = find_contacts(frame, levels, floor=floor)
    scale = np.array([1, rows + cols, rows + cols, *3 * [(rows + cols) ** 2]])
    for i, level in enumerate(levels[::-1]):
        want = expected(frame, level)
        got = sum((raw_moments(c.profile, i) for c in contacts), np.zeros(6))
        area = max(want["moments"][0], 1e-3)
        np.testing.assert_allclose(got / scale / area, want["moments"] / scale / area, rtol=0, atol=1e-9)
        assert sum(c.profile.perimeter[i] for c in contacts) == pytest.approx(want["perimeter"], rel=1e-9)
        assert sum(c.profile.parts[i] for c in contacts) == want["parts"]
        assert sum(c.profile.holes[i] for c in contacts) == want["holes"]
        if len(contacts) == 1:
            np.testing.assert_allclose(contacts[0].profile.extent[i], want["extent"], rtol=1e-9, atol=1e-9)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), times=st.integers(0, 4))
def test_covariance_of_small_sections_far_from_the_centre(seed, times):
    rng = np.random.default_rng(seed)
    frame = np.zeros((60, 80))
    y, x = np.mgrid[0:60, 0:80]
    cy, cx = rng.uniform(5, 55), rng.uniform(5, 75)
    frame += np.maximum(1 - np.hypot(x - cx, y - cy) / rng.uniform(2, 5), 0)
    (contact,) = find_contacts(frame, 8, floor=0.05)
    for i, level in enumerate(contact.profile.threshold):
        polygons, _ = generator(frame).filled(level, np.inf)
        points = polygons[0] - contact.peak_position
        m = moments(points[:, 0], points[:, 1])
        mx, my = m[1:3] / m[0]
        want = np.array([[m[3] / m[0] - mx * mx, m[4] / m[0] - mx * my], [0, m[5] / m[0] - my * my]])
        want[1, 0] = want[0, 1]
        np.testing.assert_allclose(contact.profile.area[i], m[0], rtol=1e-9)
        np.testing.assert_allclose(
            contact.profile.centroid[i], np.add(contact.peak_position, (mx, my)), rtol=1e-9, atol=1e-9
        )
        np.testing.assert_allclose(contact.profile.covariance[i], want, rtol=1e-9, atol=1e-9 * np.trace(want))


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), times=st.integers(0, 4))
def test_outlines_equal_contourpy_lines(seed, times):
    frame = smooth(np.random.default_rng(seed), (9, 12), times)
    level = float(np.median(frame)) + 1e-7
    mine = outlines(frame, level)
    theirs = generator(frame).lines(level)
    assert len(mine) == len(theirs)
    assert sorted(len(line) for line in mine) == sorted(len(line) for line in theirs)

    def points(lines):
        return np.array(sorted({(round(x, 9), round(y, 9)) for line in lines for x, y in line}))

    np.testing.assert_allclose(points(mine), points(theirs), atol=2e-9)
    closed = [line for line in mine if np.array_equal(line[0], line[-1])]
    assert len(closed) == sum(np.array_equal(line[0], line[-1]) for line in theirs)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), times=st.integers(0, 3))
def test_missing_taxels_equal_contourpy_where_no_contact_meets_them(seed, times):
    rng = np.random.default_rng(seed)
    frame = np.zeros((16, 16))
    frame[4:12, 4:12] = smooth(rng, (8, 8), times)
    holey = frame.copy()
    holey[:2] = np.nan
    holey[13:, 3:5] = np.nan
    floor = 0.51 * frame.max()
    levels = np.linspace(floor + 1e-7, frame.max(), 6)
    gen = contourpy.contour_generator(
        z=np.ma.masked_invalid(holey), name="serial", fill_type="OuterOffset", corner_mask=False
    )
    contacts = find_contacts(holey, levels, floor=floor)
    for i, level in enumerate(levels[::-1]):
        polygons, offsets = gen.filled(level, np.inf)
        area = sum(
            moments(p[a:b, 0], p[a:b, 1])[0]
            for p, o in zip(polygons, offsets, strict=True)
            for a, b in itertools.pairwise(o)
        )
        assert sum(c.profile.area[i] for c in contacts) == pytest.approx(area, rel=1e-9)
        assert sum(c.profile.holes[i] for c in contacts) == sum(len(o) - 2 for o in offsets)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_parts_and_holes_equal_opencv_where_no_cell_is_a_saddle(seed):
    # Every taxel doubled: then taxels that touch at a corner only are told apart by the cell's mean alone,
    # which is below the threshold for 0.4 / 1.0.
    rng = np.random.default_rng(seed)
    on = rng.random((10, 12)) < 0.55
    frame = np.where(on, 1.0, 0.2)
    contacts = find_contacts(frame, np.array([0.8]), floor=0.7)
    n_parts, _ = cv2.connectedComponents(on.astype(np.uint8), connectivity=4)
    off = np.pad(~on, 1, constant_values=True).astype(np.uint8)
    n_off, _ = cv2.connectedComponents(off, connectivity=8)
    assert sum(int(c.profile.parts[0]) for c in contacts) == n_parts - 1
    assert sum(int(c.profile.holes[0]) for c in contacts) == n_off - 2
