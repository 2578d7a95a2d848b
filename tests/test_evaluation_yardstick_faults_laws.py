"""What sensors do to frames, by their words: each fault against a plain sum, each row against its own name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
import pytest

from varishold.evaluation.yardstick import faults
from varishold.evaluation.yardstick.forms import KINDS, Change
from varishold.evaluation.yardstick.rows import NOISE, ROWS, Row, as_one, distorted

Floats = np.ndarray[Any, np.dtype[np.float64]]


def some_frames(n: int = 40, rows: int = 12, cols: int = 17, seed: int = 0) -> Floats:
    """Bumps of a peak of 1, each somewhere else and of another breadth."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :cols]
    made = []
    for _ in range(n):
        r, c, size = rng.uniform(4, rows - 5), rng.uniform(5, cols - 6), rng.uniform(1.5, 3.0)
        made.append(np.maximum(1 - ((y - r) ** 2 + (x - c) ** 2) / size**2, 0.0))
    frames = np.array(made)
    return np.asarray(frames / frames.max(axis=(1, 2), keepdims=True))


def fresh(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_memory_adds_another_press_each_once() -> None:
    v = some_frames(9)
    added = (faults.memory(v, fresh(), 0.25) - v) / 0.25
    others = [int(np.argmin(abs(v - one).sum(axis=(1, 2)))) for one in added]
    assert sorted(others) == list(range(9))
    assert others != list(range(9))
    assert added == pytest.approx(v[others])


@pytest.mark.parametrize("share", [0.05, 0.12, 0.3])
def test_crosstalk_gives_each_neighbour_its_share(share: float) -> None:
    v = some_frames(5)
    padded = np.pad(v, ((0, 0), (1, 1), (1, 1)), mode="edge")
    plain = np.empty_like(v)
    for k, r, c in np.ndindex(*v.shape):
        around = padded[k, r, c + 1] + padded[k, r + 2, c + 1] + padded[k, r + 1, c] + padded[k, r + 1, c + 2]
        plain[k, r, c] = v[k, r, c] + share * around
    plain /= plain.max(axis=(1, 2), keepdims=True)
    assert faults.crosstalk(v, fresh(), share) == pytest.approx(plain)


@pytest.mark.parametrize("taxels", [1.0, 2.0])
def test_a_blur_is_a_gaussians(taxels: float) -> None:
    v = some_frames(5, 24, 30)
    plain = np.array([cv2.GaussianBlur(f, (0, 0), taxels, borderType=cv2.BORDER_REPLICATE) for f in v])
    plain /= plain.max(axis=(1, 2), keepdims=True)
    assert faults.blur(v, fresh(), taxels) == pytest.approx(plain, abs=2e-2)
    point = np.zeros((1, 41, 41))
    point[0, 20, 20] = 1.0
    spread = faults.blur(point, fresh(), taxels)[0]
    at = np.arange(41) - 20
    assert np.sqrt((spread.sum(axis=0) * at**2).sum() / spread.sum()) == pytest.approx(taxels, rel=0.03)


def test_ghosts_are_products_of_row_and_column() -> None:
    v = some_frames(5)
    for before, after in zip(v, faults.ghosts(v, fresh(), 0.15), strict=True):
        ghost = np.array([[before[r].sum() * before[:, c].sum() for c in range(17)] for r in range(12)])
        assert after == pytest.approx(before + 0.15 * ghost / ghost.max())


def test_gains_are_each_taxels_own_about_one_and_never_below_a_twentieth() -> None:
    v = np.ones((30, 12, 17))
    spread = faults.gains(v, fresh(), 0.2)
    assert spread.mean() == pytest.approx(1, abs=0.01)
    assert spread.std() == pytest.approx(0.2, rel=0.03)
    wild = faults.gains(v, fresh(), 2.0)
    assert wild.min() == 0.05
    assert (wild == 0.05).mean() == pytest.approx(0.3174, abs=0.02)
    assert faults.gains(3 * v, fresh(), 0.2) == pytest.approx(3 * spread)


def test_noise_offsets_and_dead_taxels_are_as_large_and_many_as_is_said() -> None:
    v = some_frames()
    for fault in (faults.noise, faults.offsets):
        added = fault(v, fresh(), 0.06) - v
        assert added.mean() == pytest.approx(0, abs=0.003)
        assert added.std() == pytest.approx(0.06, rel=0.03)
        assert abs(np.corrcoef(added[:, :, 1:].ravel(), added[:, :, :-1].ravel())[0, 1]) < 0.05
    lost = faults.dead(v + 1, fresh(), 0.05)
    gone = lost == 0
    assert gone.mean() == pytest.approx(0.05, abs=0.008)
    assert np.array_equal(lost[~gone], (v + 1)[~gone])
    assert (faults.dead(v + 1, fresh(), 0.0) == v + 1).all()


def test_a_response_is_that_of_its_formula() -> None:
    v = np.linspace(-0.2, 1, 25).reshape(1, 5, 5)
    for before, power, logarithm, zone, most, steps in zip(
        v.ravel(),
        faults.power(v, fresh(), 2.0).ravel(),
        faults.logarithm(v, fresh(), 5.0).ravel(),
        faults.dead_zone(v, fresh(), 0.3).ravel(),
        faults.saturated(v, fresh(), 0.8).ravel(),
        faults.counts(v, fresh(), 6).ravel(),
        strict=True,
    ):
        up = max(before, 0.0)
        assert power == pytest.approx(up**2)
        assert logarithm == pytest.approx(np.log(1 + 5 * up) / np.log(6))
        assert zone == pytest.approx(max(before - 0.3, 0) / 0.7)
        assert most == min(before, 0.8)
        assert 6 * steps == pytest.approx(round(6 * steps))
        assert abs(steps - before) <= 1 / 12 + 1e-12


def test_a_slope_is_a_plane_from_nothing_to_its_rise_in_any_direction() -> None:
    v = some_frames(200)
    ramps = faults.slope(v, fresh(), 0.15) - v
    y, x = np.mgrid[:12, :17]
    ways = []
    for ramp in ramps:
        (a, b, _c), left, *_ = np.linalg.lstsq(
            np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1), ramp.ravel(), rcond=None
        )
        assert left.sum() < 1e-20
        assert (ramp.min(), ramp.max()) == pytest.approx((0, 0.15))
        ways.append(np.arctan2(b, a))
    counts, _ = np.histogram(ways, 8, (-np.pi, np.pi))
    assert counts.min() > 10


def test_pink_noise_has_less_power_the_shorter_its_waves() -> None:
    n, side = 400, 32
    noise = faults.pink(np.zeros((n, side, side)), fresh(), 0.05)
    assert noise.std(axis=(1, 2)) == pytest.approx(np.full(n, 0.05))
    assert noise.mean(axis=(1, 2)) == pytest.approx(np.zeros(n), abs=1e-12)
    power = (abs(np.fft.fft2(noise)) ** 2).mean(axis=0)
    wave = np.hypot(*np.meshgrid(np.fft.fftfreq(side), np.fft.fftfreq(side)))
    known = (wave > 0) & (wave < 0.5)
    slope, _ = np.polyfit(np.log(wave[known]), np.log(power[known]), 1)
    assert slope == pytest.approx(-1, abs=0.05)
    # As many rows as columns or not, its shape is the pad's.
    assert faults.pink(np.zeros((2, 5, 8)), fresh(), 1.0).shape == (2, 5, 8)
    assert faults.pink(np.zeros((2, 6, 7)), fresh(), 1.0).shape == (2, 6, 7)


def test_a_dead_line_is_a_row_or_a_column_through_the_contact() -> None:
    v = some_frames(200) + 0.01
    before = v.copy()
    rows = 0
    places = []
    for whole, lost in zip(v, faults.dead_line(v, fresh()), strict=True):
        gone = lost == 0
        across, down = np.flatnonzero(gone.all(axis=1)), np.flatnonzero(gone.all(axis=0))
        assert len(across) + len(down) == 1
        assert gone.sum() == (17 if len(across) else 12)
        line = whole[across[0]] if len(across) else whole[:, down[0]]
        assert line.max() > 0.1
        assert np.array_equal(lost[~gone], whole[~gone])
        rows += len(across)
        there = np.flatnonzero((whole > 0.1).any(axis=1 if len(across) else 0))
        places.append(np.flatnonzero(there == (across if len(across) else down)[0])[0] / max(len(there) - 1, 1))
    assert 70 < rows < 130
    assert min(places) == 0
    assert max(places) == 1
    assert np.array_equal(v, before)


@pytest.mark.parametrize("ratio", [1.0, 1.25, 2.0])
def test_a_stretch_makes_a_contact_narrower_about_its_centre(ratio: float) -> None:
    v = some_frames(20, 12, 31)
    at = np.arange(31)
    for before, after in zip(v, faults.stretch(v, fresh(), ratio), strict=True):
        assert after.max() == pytest.approx(1)
        (x, wide), (now, narrow) = (
            ((f.sum(axis=0) @ at) / f.sum(), (f.max(axis=0) > 0.2).sum()) for f in (before, after)
        )
        assert now == pytest.approx(x, abs=0.35)
        assert narrow == pytest.approx(wide / ratio, abs=1.5)
        # Each reading is that of the place which lies as many times as far from the centre.
        plain = np.array([[np.interp(x + ratio * (c - x), at, row) for c in at] for row in before])
        assert after == pytest.approx(plain / plain.max(), abs=1e-9)


# ---- rows


def values_of(row: Row) -> list[float]:
    """Every number that a row's faults and its change are given."""
    found: list[float] = []
    for fault in (*row.before, *row.after):
        if isinstance(fault, partial):
            found += fault.keywords.values()
    return [*found, *(value for value in (row.change.tilt, row.change.rounding, row.change.cut) if value)]


IN_WORDS: Mapping[str, float] = {"a quarter": 0.25, "half": 0.5, "six": 6.0}


@pytest.mark.parametrize("row", [row for row in ROWS if "mix" not in row.name], ids=lambda row: row.name)
def test_a_row_is_as_strong_as_its_name_says(row: Row) -> None:
    wanted = [value for words, value in IN_WORDS.items() if words in row.name]
    for text, share in re.findall(r"(\d*\.?\d+)( %)?", row.name):
        wanted.append(float(text) / (100 if share else 1))
    assert values_of(row) == pytest.approx(wanted)
    assert len(wanted) == (0 if row.name in ("clean", "dead line") else 1)


def test_mixes_are_made_of_faults_that_have_rows_of_their_own() -> None:
    strongest: dict[Any, list[float]] = {}
    for row in ROWS:
        for fault in (*row.before, *row.after):
            if isinstance(fault, partial) and "mix" not in row.name:
                strongest.setdefault(fault.func, []).append(*fault.keywords.values())
    plausible, bad = (row for row in ROWS if "mix" in row.name)
    for row in (plausible, bad):
        assert all(isinstance(f, partial) for f in (*row.before, *row.after))
        for fault in row.before:
            assert isinstance(fault, partial)
            assert next(iter(fault.keywords.values())) in strongest[fault.func]
    # Eight bits, and six.
    assert [values_of(row)[-1] for row in (plausible, bad)] == [255, 60]


def test_every_row_has_a_name_of_its_own_and_the_mildest_of_a_kind_comes_first() -> None:
    names = [row.name for row in ROWS]
    assert len(set(names)) == len(names) == 35
    assert [row.name for row in ROWS if not row.counted] == names[-4:]
    heads: dict[str, list[float]] = {}
    for row in ROWS:
        if values_of(row) and "mix" not in row.name:
            heads.setdefault(re.sub(r"[\d.]+|half|a quarter|six", "", row.name).strip(), []).append(values_of(row)[0])
    for head, values in heads.items():
        if not head.startswith(("saturated", "counts")):
            assert values == sorted(values), head
    assert all(a < b for a, b in pairwise(sorted(NOISE.values())))


@pytest.mark.parametrize("row", [row for row in ROWS if row.change == Change()], ids=lambda row: row.name)
def test_a_row_is_its_faults_in_turn_about_white_noise(row: Row) -> None:
    clean = some_frames(8, 16, 16)
    read, truths = distorted(row, clean, np.array(["hip", *KINDS[:7]]), "ideal", 9)
    rng = np.random.default_rng([9, 16, 5, *row.name.encode()])
    plain = clean
    for fault in row.before:
        plain = fault(plain, rng)
    plain = plain + NOISE[16] * rng.standard_normal(plain.shape)
    for fault in row.after:
        plain = fault(plain, rng)
    assert np.array_equal(read, plain)
    for kind, truth in zip(["ridge", *KINDS[:7]], truths, strict=True):
        assert truth == (kind, *row.also.get(kind, ()))


def test_ridge_and_hip_are_one_and_all_else_is_itself() -> None:
    assert [as_one(kind) for kind in KINDS] == ["ridge" if kind == "hip" else kind for kind in KINDS]


def test_noise_of_a_pad_of_four_times_the_taxels_is_half_as_much() -> None:
    assert NOISE[16] == 2 * NOISE[32] == 0.02
    clean = np.zeros((50, 32, 32))
    read, _ = distorted(ROWS[0], clean, np.repeat("cone", 50), "ideal", 0)
    assert read.std() == pytest.approx(0.01, rel=0.02)
