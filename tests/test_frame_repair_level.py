"""Laws of repairing and levelling one frame: strong evidence is used, everything else stays to the last bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from varishold.frame.level import level
from varishold.frame.repair import repair
from varishold.levelset import find_contacts
from varishold.solids import SOLIDS, draw_contact, ideal_frame


def clean_frame(rng: np.random.Generator, key: str, side: int = 32) -> np.ndarray:
    drawn = draw_contact(rng, key, field_m=(side, side), size_m=(side / 4, 0.75 * side))
    frame = ideal_frame(drawn.solid, (side, side), 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
    return frame / frame.max()


@pytest.mark.parametrize("key", SOLIDS)
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_clean_frame_is_not_touched(key: str, noise: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(10):
        frame = clean_frame(rng, key) + rng.normal(0, noise, (32, 32))
        assert np.array_equal(repair(frame).values, frame)
        assert np.array_equal(level(frame).values, frame)


@pytest.mark.parametrize("side", [5, 9, 16, 33])
def test_a_frame_of_noise_alone_is_not_touched(side: int) -> None:
    rng = np.random.default_rng(side)
    for frame in (rng.normal(0, 1, (side, side)), rng.random((side, side)), rng.normal(100, 1, (side, side))):
        assert np.array_equal(repair(frame).values, frame)
        assert np.array_equal(level(frame).values, frame)


def test_an_even_frame_is_not_touched() -> None:
    for frame in (np.zeros((16, 16)), np.ones((16, 16)), np.ones((1, 9)), np.ones((9, 1))):
        assert np.array_equal(repair(frame).values, frame)
        assert np.array_equal(level(frame).values, frame)


def test_dead_taxels_inside_a_contact_are_found_and_nothing_else() -> None:
    rng = np.random.default_rng(5)
    frame = clean_frame(rng, "sphere")
    inside = frame > 0.6
    dead = np.zeros_like(inside)
    rows, cols = np.nonzero(inside)
    for k in range(0, len(rows), 17):
        dead[rows[k], cols[k]] = True
    broken = np.where(dead, 0.0, frame) + rng.normal(0, 0.005, frame.shape)
    mended = repair(broken)
    assert np.array_equal(mended.dead, dead)
    assert np.abs(mended.values - frame)[dead].max() < 0.1
    assert np.array_equal(mended.values[~dead], broken[~dead])


@pytest.mark.parametrize("high", [1.6, 4.0])
def test_a_hot_taxel_inside_a_contact_is_found_and_nothing_else(high: float) -> None:
    rng = np.random.default_rng(6)
    for key in ("sphere", "square-pillar", "cone"):
        frame = clean_frame(rng, key)
        rows, cols = np.nonzero(frame > 0.6)
        k = len(rows) // 2
        stuck = frame + rng.normal(0, 0.005, frame.shape)
        stuck[rows[k], cols[k]] = high
        mended = repair(stuck)
        assert np.argwhere(mended.dead).tolist() == [[rows[k], cols[k]]]
        assert abs(mended.values[rows[k], cols[k]] - frame[rows[k], cols[k]]) < 0.1
        (contact,) = find_contacts(stuck)
        assert np.array_equal(contact.frame.dead, mended.dead)
        assert contact.state.repaired == 1


@pytest.mark.parametrize("width", [0.3, 0.7, 1.0, 1.5])
@pytest.mark.parametrize("fall", [lambda r2: np.exp(-r2 / 2), lambda r2: (1 + r2) ** -1.5, lambda r2: 1 - np.sqrt(r2)])
def test_a_peak_however_sharp_is_no_hot_taxel(width: float, fall: Callable[[np.ndarray], np.ndarray]) -> None:
    rng = np.random.default_rng(7)
    rows, cols = np.mgrid[:16, :16]
    for _ in range(20):
        row, col = rng.uniform(3, 12, 2)
        peak = np.maximum(fall(((rows - row) ** 2 + (cols - col) ** 2) / width**2), 0.0)
        if peak.max() > 0:
            noisy = peak / peak.max() + rng.normal(0, 0.01, peak.shape)
            assert not repair(noisy).dead.any()


def test_pins_on_a_plate_are_a_form() -> None:
    frame = np.zeros((16, 16))
    frame[2:14, 2:14] = 0.5
    frame[3:13:3, 3:13:3] = 1.0
    assert not repair(frame).dead.any()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_dead_line_through_a_contact_is_found(axis: int) -> None:
    frame = np.zeros((16, 16))
    frame[4:12, 5:13] = 1.0
    broken = np.moveaxis(frame.copy(), axis, 0)
    broken[7] = 0.0
    mended = repair(np.moveaxis(broken, 0, axis))
    assert np.allclose(mended.values, frame, atol=0.35)
    assert mended.dead.sum() == 16


def test_a_hole_of_several_taxels_is_a_form() -> None:
    frame = np.zeros((16, 16))
    frame[3:13, 3:13] = 1.0
    frame[6:10, 6:10] = 0.0
    assert not repair(frame).dead.any()


def test_bars_a_taxel_apart_are_a_form() -> None:
    frame = np.zeros((16, 16))
    frame[2:14, 1:15:2] = 1.0
    assert not repair(frame).dead.any()


@pytest.mark.parametrize("slope", [0.05, 0.15, 0.3])
def test_a_slope_and_an_offset_are_taken_off(slope: float) -> None:
    rng = np.random.default_rng(7)
    row, col = np.mgrid[:24, :24] / 24
    for key in ("cylinder", "cone", "ridge"):
        frame = clean_frame(rng, key, 24)
        taken = level(frame + slope * (col - 0.3 * row) + 0.4 + rng.normal(0, 0.005, frame.shape))
        assert np.abs(taken.values - frame).mean() < 0.01
        assert taken.rest[1] * 24 == pytest.approx(slope, abs=0.015)


def test_a_plane_has_no_rest() -> None:
    rng = np.random.default_rng(9)
    row, _ = np.mgrid[:16, :16] / 16
    for frame in (1 + rng.normal(0, 0.05, (16, 16)), 1 - 0.5 * row):
        assert np.array_equal(level(frame).values, frame)


def test_the_rest_of_a_large_map_is_found_under_something_small() -> None:
    frame = 0.3 + np.random.default_rng(3).normal(0, 0.01, (480, 640))
    frame[203:215, 311:324] += 1.0
    taken = level(frame)
    assert taken.rest[0] == pytest.approx(0.3, abs=0.01)
    assert abs(np.median(taken.values)) < 0.01
