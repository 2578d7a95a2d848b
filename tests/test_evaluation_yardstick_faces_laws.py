"""Faces of the yardstick by plain geometry: a section of each, rounded by a ball that rolls in it, and its sizes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from varishold.evaluation.yardstick.forms import KINDS, Change, Face, _form, draw_face
from varishold.evaluation.yardstick.media import _GROW, _LEAST_TAXELS, clean_frames, pressed

OBLONG = ("rectangular pillar", "ridge", "hip", "lying cylinder")
TAPERS = ("frustum of a cone", "frustum of a pyramid", "cone", "pyramid", "ridge", "hip", "sphere", "lying cylinder")
BALLS = ("sphere", "lying cylinder")
SEEDS = range(12)


def form(kind: str, seed: int, *, side: int = 32, grow: float = 1.0, rounding: float = 0.0, index: int = 0) -> Face:
    """Return a face about the origin, unturned."""
    return _form(np.random.default_rng(seed), kind, index, side, grow, rounding)


def opened(height: np.ndarray, step: float, radius: float) -> np.ndarray:
    """Return the lower border of all balls that lie above a section, the lowest point of it at 0."""
    n = int(radius / step)
    bow = np.sqrt(np.maximum(radius**2 - (step * np.arange(-n, n + 1)) ** 2, 0.0))
    padded = np.pad(height, 2 * n, constant_values=np.inf)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * n + 1)
    centres = (windows + bow).max(axis=1)
    found = (np.lib.stride_tricks.sliding_window_view(centres, 2 * n + 1) - bow).min(axis=1)
    return np.asarray(found - found.min())


def section(face: Face, along: str, reach: float, n: int = 1601) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(-reach, reach, n)
    zero = np.zeros(n)
    return t, face.gap(t, zero) if along == "x" else face.gap(zero, t)


@pytest.mark.parametrize("rounding", [0.1, 0.25, 0.5])
@pytest.mark.parametrize(
    ("kind", "along"),
    [
        *((kind, "x") for kind in ("cylinder", "square pillar", "frustum of a cone", "frustum of a pyramid")),
        *(("cone", "y"), ("pyramid", "y"), ("ridge", "y"), ("ridge", "x"), ("rectangular pillar", "y")),
        *(("rectangular pillar", "x"), ("lying cylinder", "x")),
    ],
)
def test_what_bends_is_rounded_by_a_ball_and_nothing_else_is_moved(kind: str, along: str, rounding: float) -> None:
    for seed in SEEDS:
        sharp, soft = form(kind, seed), form(kind, seed, rounding=rounding)
        assert (sharp.depth, sharp.breadth) == (soft.depth, soft.breadth)
        radius = rounding * soft.breadth
        t, plain = section(sharp, along, 45.0)
        _, told = section(soft, along, 45.0)
        wanted = opened(plain, float(t[1] - t[0]), radius)
        there = np.isfinite(plain)
        assert np.array_equal(there, np.isfinite(told))
        # On the last step before a wall the ball's own side is as steep as the wall.
        inner = there & np.roll(there, 8) & np.roll(there, -8)
        # What a section has at its deepest, its highest point hides.
        seen = inner & (wanted < 2 * soft.depth)
        assert told[seen] - told[seen].min() == pytest.approx(wanted[seen], abs=0.03 * radius + 0.02)
        assert told[there].min() == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("edge", "plane")])
def test_sections_are_straight_or_round_and_end_where_the_breadth_ends(kind: str) -> None:
    for seed in SEEDS:
        face = form(kind, seed)
        half = face.breadth / 2
        t, across = section(face, "y", 1.2 * half)
        inside = abs(t) <= half + 1e-9
        if kind in ("cylinder", "square pillar", "rectangular pillar"):
            assert (across[inside] == 0).all()
            assert np.isinf(across[~inside]).all()
        elif kind in BALLS:
            # A circle through the foremost point and both ends at the depth.
            radius = (half**2 + face.depth**2) / (2 * face.depth)
            assert across[inside] == pytest.approx(radius - np.sqrt(radius**2 - t[inside] ** 2))
            assert face.gap(np.array([0.0]), np.array([0.9999 * radius]))[0] < radius
            assert np.isinf(face.gap(np.array([0.0]), np.array([1.0001 * radius]))[0])
        else:
            # Flat in the middle, then straight down to the depth.
            flat = abs(t[across < 1e-6 * face.depth]).max()
            share = flat / half
            assert (0.4 - 0.01 <= share <= 0.65) if kind.startswith("frustum") else share < 0.01
            top = 0.0 if share < 0.01 else share
            slope = across[-1] / (1.2 - top)
            assert across == pytest.approx(slope * np.maximum(abs(t) / half - top, 0), abs=0.02 * face.depth)
            assert np.interp(half, t, across) == pytest.approx(face.depth, rel=1e-3)
        x, y = np.meshgrid(t[5::9], t[5::9])
        np.testing.assert_allclose(face.gap(x, y), face.gap(-x, -y), rtol=1e-9)
        if kind in ("cylinder", "frustum of a cone", "sphere", "cone"):
            turned = face.gap(t / math.sqrt(2), t / math.sqrt(2))
            assert turned[inside] == pytest.approx(across[inside], abs=1e-6)
        elif kind not in OBLONG:
            # A square: along the diagonal all is sqrt 2 times as far.
            assert face.gap(t, t) == pytest.approx(across)
        else:
            assert not np.array_equal(face.gap(t, 0 * t), across)


def length_of(face: Face) -> float:
    """How far an oblong face reaches before it ends, or is as deep as it is pressed."""
    t = np.linspace(0, 60, 60001)
    return float(2 * t[face.gap(t, 0 * t) <= face.depth + 1e-9].max())


@pytest.mark.parametrize("side", [16, 32])
@pytest.mark.parametrize("kind", OBLONG)
def test_what_is_oblong_is_so_many_times_as_long_as_broad(kind: str, side: int) -> None:
    faces = [form(kind, seed, side=side) for seed in range(150)]
    most = 26.0 * side / 32
    ratios = []
    for face in faces:
        ratio = length_of(face) / face.breadth
        assert 1.5 - 1e-3 <= ratio <= 3.5 + 1e-3
        assert length_of(face) <= max(most, 1.5 * face.breadth) + 0.01
        ratios.append(ratio if length_of(face) < most - 0.01 and ratio > 1.501 else math.nan)
    # All of the range is drawn from.
    assert np.nanmin(ratios) < 1.65
    assert np.nanmax(ratios) > 3.2
    assert sum(abs(length_of(face) - most) < 0.01 for face in faces) > 3
    if kind == "hip":
        # Its line is .4 to .65 of its length.
        lines = []
        for face in faces[:60]:
            t = np.linspace(0, 60, 60001)
            flat = 2 * t[face.gap(t, 0 * t) < 1e-9].max()
            lines.append(flat / length_of(face))
        assert 0.399 < min(lines) < 0.45
        assert 0.6 < max(lines) < 0.651
        ends = face.gap(np.array([length_of(face) / 2]), np.zeros(1))
        assert ends == pytest.approx(face.depth, rel=1e-3)


@pytest.mark.parametrize("side", [16, 32])
@pytest.mark.parametrize("kind", KINDS)
def test_sizes_are_drawn_from_the_whole_of_their_ranges(kind: str, side: int) -> None:
    grow = 1.25
    faces = [form(kind, seed, side=side, grow=grow) for seed in range(300)]
    low, high = {(32, True): (4.5, 11), (32, False): (8, 22), (16, True): (3, 5.5), (16, False): (5, 11)}[
        side, kind in OBLONG
    ]
    by = grow if kind in TAPERS else 1.0
    breadths = [face.breadth / by for face in faces]
    assert low <= min(breadths) < low + 0.05 * (high - low)
    assert high - 0.05 * (high - low) < max(breadths) <= high
    depths = [face.depth / face.breadth for face in faces]
    least, most = (0.1, 0.45) if kind in BALLS else (0.15, 0.35)
    assert least <= min(depths) < least + 0.02
    assert most - 0.02 < max(depths) <= most
    # Neither hangs on the other.
    assert abs(np.corrcoef(breadths, depths)[0, 1]) < 0.2


@pytest.mark.parametrize("side", [16, 32])
def test_edges_lie_across_the_pads_middle_half_planes_and_wedges_in_turns(side: int) -> None:
    for rounding in (0.0, 0.2):
        walls, lines = [], []
        for seed in range(200):
            t = np.linspace(-side / 2, side / 2, 1601)
            plane, wedge = (form("edge", seed, side=side, index=index, rounding=rounding) for index in (4, 7))
            gap = plane.gap(t, 0 * t + 3.0)
            at = t[np.isfinite(gap)].min()
            walls.append(at / side)
            assert np.isinf(gap[t < at]).all()
            assert gap[t > at + rounding * plane.breadth + 0.02] == pytest.approx(0)
            gap = wedge.gap(t, 0 * t - 2.0)
            lines.append(t[np.argmin(gap)] / side)
            far = abs(t / side - lines[-1]) * side > 1.0 + rounding * wedge.breadth
            slopes = abs(np.gradient(gap, t))[far][1:-1]
            if far.any():
                assert np.median(slopes) == pytest.approx(wedge.depth / (wedge.breadth / 2), rel=0.01)
        for places, most in ((walls, 0.3), (lines, 0.18)):
            assert -most - 2e-3 <= min(places) < -0.9 * most
            assert 0.9 * most < max(places) <= most + 2e-3
        assert np.corrcoef(walls, lines)[0, 1] > 0.999
    assert (form("plane", 1, side=side).gap(np.ones(3), np.arange(3.0)) == 0).all()


def test_places_turns_and_leans_are_drawn_from_all_there_are() -> None:
    turns, leans, places = [], [], []
    for seed in range(80):
        face, leaning = (draw_face((seed,), "edge", 0, 16, Change(tilt=tilt)) for tilt in (0.0, 8.0))
        assert face is not None
        assert leaning is not None
        x, y = np.meshgrid(np.linspace(-20, 20, 161), np.linspace(-20, 20, 161))
        there = np.isfinite(face.gap(x, y))
        turns.append(math.atan2(y[there].mean(), x[there].mean()))
        added = leaning.gap(x, y)[there] - face.gap(x, y)[there]
        (a, b), *_ = np.linalg.lstsq(np.stack([x[there], y[there]], axis=1), added, rcond=None)
        leans.append(math.atan2(b, a))
        ball = draw_face((seed,), "sphere", 0, 32, Change())
        if ball is not None:
            x, y = np.meshgrid(np.linspace(-16, 16, 257), np.linspace(-16, 16, 257))
            touched = ball.gap(x, y) < ball.depth
            room = 15 - ball.breadth / 2
            places.append((x[touched].mean() / room, y[touched].mean() / room))
    for angles in (turns, leans):
        counts, _ = np.histogram(angles, 4, (-math.pi, math.pi))
        assert counts.min() >= 8
    at = np.array(places)
    assert abs(at).max() < 1.05
    assert (at.min(axis=0) < -0.9).all()
    assert (at.max(axis=0) > 0.9).all()
    assert abs(np.corrcoef(at.T)[0, 1]) < 0.35


# ---- frames


def test_the_names_of_changes_are_those_of_files() -> None:
    assert Change().key == "tilt0-round0-cut0"
    assert Change(5.0, 0.25, 0.15).key == "tilt5-round0.25-cut0.15"


@pytest.mark.parametrize("side", [16, 32])
def test_a_frame_has_so_many_loaded_taxels_and_a_peak_of_one(side: int) -> None:
    least = {16: 11, 32: 24}[side]
    assert _LEAST_TAXELS[side] == least
    ticks: list[int] = []
    frames, kinds = clean_frames("ideal", side, Change(cut=0.5), 3, 11, tick=lambda: ticks.append(1))
    assert len(ticks) == len(KINDS)
    assert kinds.tolist() == [kind for kind in KINDS for _ in range(3)]
    for frame, kind in zip(frames, kinds, strict=True):
        assert frame.max() == 1
        loaded = (frame > 0.1).sum()
        assert loaded >= (side if kind in ("edge", "plane") else least * 0.5)
    assert np.array_equal(frames, frames.astype(np.float32))


def test_what_tapers_is_drawn_larger_the_softer_the_skin() -> None:
    assert 1 == _GROW["ideal"] < _GROW["cover"] < _GROW["half-space"] < 1.5


@pytest.mark.parametrize("medium", ["cover", "half-space"])
def test_a_pressed_pad_is_that_of_a_larger_one_within_its_borders(medium: str) -> None:
    """What lies beyond the border is solved for, too: a ball in the middle reads the same on both."""
    face = Face("sphere", lambda x, y: (x**2 + y**2) / 14, 1.2, 8.0)
    small, large = (pressed(face, side, medium, np.random.default_rng(3)) for side in (16, 32))
    assert small.shape == (16, 16)
    inner = large[8:24, 8:24]
    if medium == "half-space":
        # Half as deep below the surface on the small pad, whose taxels are twice as large.
        assert small.max() > inner.max()
        assert small.sum() == pytest.approx(inner.sum(), rel=0.1)
    else:
        assert small == pytest.approx(inner, abs=2e-3 * inner.max())
    for quarter in (small[::-1], small[:, ::-1], small.T):
        assert small == pytest.approx(quarter, abs=5e-3 * small.max())
