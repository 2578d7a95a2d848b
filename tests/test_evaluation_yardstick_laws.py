"""Faces of the yardstick lie where it says, its contacts obey mechanics, and scores are those of plain loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.evaluation.scores import Answers, refusal_curve, reliability, score
from varishold.evaluation.yardstick.forms import ENDLESS, KINDS, Change, Face, draw_face
from varishold.evaluation.yardstick.media import cell_centres, half_space_reading, height_map, taxel_means
from varishold.evaluation.yardstick.solver import CELLS, half_space_response, layer_compliance, solve, waves
from varishold.trust import share_interval

BOUNDED = [kind for kind in KINDS if kind not in ENDLESS]
OBLONG = ("rectangular pillar", "ridge", "hip", "lying cylinder")


def drawn(kind: str, seed: int, side: int, change: Change) -> Face | None:
    return draw_face((seed, side), kind, seed, side, change)


def touched(face: Face, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points that lie less deep than the face is pressed."""
    grid = np.linspace(-1.6 * side, 1.6 * side, 401)
    x, y = np.meshgrid(grid, grid)
    inside = face.gap(x, y) < face.depth
    return x[inside], y[inside]


@given(st.sampled_from(BOUNDED), st.integers(0, 10**6), st.sampled_from([16, 32]), st.sampled_from([0.0, 0.25]))
@settings(max_examples=40)
def test_a_face_lies_on_the_pad_and_is_as_large_and_deep_as_is_said(
    kind: str, seed: int, side: int, rounding: float
) -> None:
    face = drawn(kind, seed, side, Change(rounding=rounding))
    if face is None:
        return
    x, y = touched(face, side)
    # Its extent is looked for in steps of a hundredth of the pad.
    assert max(abs(x).max(), abs(y).max()) <= side / 2 - 1 + 0.015 * side
    gap = face.gap(x, y)
    assert gap.min() >= 0
    assert gap.min() < 0.1 * face.depth + 0.1
    low, high = (
        ((4.5, 11.0) if kind in OBLONG else (8.0, 22.0)) if side == 32 else ((3, 5.5) if kind in OBLONG else (5, 11))
    )
    assert low - 1e-9 <= face.breadth <= high + 1e-9
    if kind in ("sphere", "lying cylinder"):
        assert 0.1 <= face.depth / face.breadth <= 0.45
    else:
        assert 0.15 <= face.depth / face.breadth <= 0.35
    # The narrowest and the widest way across.
    turns = np.linspace(0, np.pi, 90, endpoint=False)
    across = [np.ptp(x * np.cos(turn) + y * np.sin(turn)) for turn in turns]
    step = 3.2 * side / 400
    if rounding == 0:
        assert min(across) == pytest.approx(face.breadth, abs=0.03 * face.breadth + 2 * step)
    if kind in OBLONG:
        assert (
            max(across)
            <= math.hypot(face.breadth, min(3.5 * face.breadth, max(26.0 * side / 32, 1.5 * face.breadth))) + step
        )
        assert max(across) > 1.2 * min(across)


@given(st.sampled_from(BOUNDED), st.integers(0, 10**6), st.sampled_from([0.2, 0.5]))
@settings(max_examples=40)
def test_the_share_that_is_said_lies_beyond_one_border(kind: str, seed: int, cut: float) -> None:
    side = 16
    face = drawn(kind, seed, side, Change(cut=cut))
    if face is None:
        return
    x, y = touched(face, side)
    beyond = [(x > side / 2).mean(), (x < -side / 2).mean(), (y > side / 2).mean(), (y < -side / 2).mean()]
    assert max(beyond) == pytest.approx(cut, abs=0.06)
    assert sorted(beyond)[-2] == 0
    border = int(np.argmax(beyond))
    beside = y if border < 2 else x
    assert abs(beside).max() <= side / 2 - 1 + 0.015 * side


def test_all_four_borders_cut() -> None:
    seen = set()
    for seed in range(24):
        face = drawn("cylinder", seed, 16, Change(cut=0.4))
        if face is not None:
            x, y = touched(face, 16)
            seen.add(int(np.argmax([x.mean(), -x.mean(), y.mean(), -y.mean()])))
    assert seen == {0, 1, 2, 3}


@pytest.mark.parametrize("kind", ENDLESS)
@pytest.mark.parametrize("tilt", [3.0, 10.0])
def test_a_tilted_face_is_the_same_with_a_plane_on_it(kind: str, tilt: float) -> None:
    x, y = np.meshgrid(np.linspace(-8, 8, 41), np.linspace(-8, 8, 41))
    for seed in range(6):
        flat, leaning = (drawn(kind, seed, 16, Change(tilt=degrees)) for degrees in (0.0, tilt))
        assert flat is not None
        assert leaning is not None
        there = np.isfinite(flat.gap(x, y))
        assert np.array_equal(there, np.isfinite(leaning.gap(x, y)))
        added = leaning.gap(x, y)[there] - flat.gap(x, y)[there]
        plane, left, *_ = np.linalg.lstsq(np.stack([x[there], y[there]], axis=1), added, rcond=None)
        assert np.hypot(*plane) == pytest.approx(np.tan(np.radians(tilt)))
        assert left.sum() < 1e-12


def test_the_object_is_the_same_whatever_is_done_to_it() -> None:
    for kind in BOUNDED:
        faces = [
            drawn(kind, 3, 32, change) for change in (Change(), Change(tilt=5.0), Change(rounding=0.2), Change(cut=0.3))
        ]
        assert len({(face.breadth, face.depth) for face in faces if face is not None}) == 1


def test_a_height_map_is_how_deep_the_face_stands() -> None:
    face = drawn("sphere", 1, 16, Change())
    assert face is not None
    frame = height_map(face, 16)
    x, y = cell_centres(16, 8)
    fine = taxel_means(np.maximum(face.depth - face.gap(x, y), 0.0), 8)
    assert frame == pytest.approx(fine, abs=0.05 * face.depth)
    assert cell_centres(2, 2)[0].tolist() == [[-0.75, -0.25, 0.25, 0.75]] * 4
    assert taxel_means(np.arange(16.0).reshape(4, 4), 2).tolist() == [[2.5, 4.5], [10.5, 12.5]]


# Contacts.


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_a_contact_presses_where_it_touches_and_nowhere_pulls(seed: int) -> None:
    rng, n = np.random.default_rng(seed), 24
    x, y = (np.mgrid[:n, :n] - n / 2) / CELLS
    overlap = 0.6 - 0.05 * ((x - rng.uniform(-1, 1)) ** 2 + (y - rng.uniform(-1, 1)) ** 2) + 0.1 * rng.random((n, n))
    size = 2 * n
    spectrum = half_space_response(size, n)
    p = solve(overlap, spectrum, size)
    lifted = np.fft.irfft2(np.fft.rfft2(p, (size, size)) * spectrum, (size, size))[:n, :n]
    close = 2e-3 * overlap.max()
    assert (p >= 0).all()
    assert p.any()
    assert (p[overlap <= 0] == 0).all()
    assert np.sqrt(((lifted - overlap)[p > 0] ** 2).mean()) < close
    assert (lifted - overlap)[(p == 0) & (overlap > 0)].min(initial=0) > -close


def test_a_ball_on_a_half_space_is_that_of_hertz() -> None:
    radius, deep = 12.0, 1.5
    face = Face("sphere", lambda x, y: (x**2 + y**2) / (2 * radius), deep, 8.0)
    frame = half_space_reading(face, 16, 1e-3)
    reach = math.sqrt(radius * deep)
    assert frame.sum() == pytest.approx(4 / 3 * math.sqrt(radius) * deep**1.5, rel=0.03)
    x, y = cell_centres(16, 6)
    hertz = np.sqrt(np.maximum(1 - (x**2 + y**2) / reach**2, 0)) * 2 / math.pi * math.sqrt(deep / radius)
    assert frame == pytest.approx(taxel_means(hertz, 6), abs=0.06 * hertz.max())
    # Read deeper below the surface, the same load is spread.
    deeper = half_space_reading(face, 16, 1.0)
    assert deeper.max() < 0.97 * frame.max()
    assert deeper.sum() < frame.sum()


@pytest.mark.parametrize("nu", [0.2, 0.3, 0.45])
def test_a_layer_is_a_half_space_to_short_waves_and_a_column_to_long_ones(nu: float) -> None:
    k, thick = waves(48), 1.5
    compliance = layer_compliance(48, thick, nu)
    short = k * thick > 6
    assert (compliance * k)[short] == pytest.approx(np.full(short.sum(), 2 * (1 - nu**2)), rel=0.02)
    column = thick * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    assert compliance[0, 0] == pytest.approx(column)
    # Ever longer waves see ever more of a column.
    long = layer_compliance(1200, thick, nu)
    assert long[0, 1] == pytest.approx(column, rel=0.05)
    assert (compliance[k > 0] > 0).all()


def test_a_loaded_cell_lowers_what_is_far_as_a_point_does() -> None:
    n, size = 40, 80
    response = np.fft.irfft2(half_space_response(size, n), (size, size))
    assert response[0, 30] == pytest.approx(CELLS**-2 / (math.pi * 30 / CELLS), rel=1e-3)
    assert response[20, 20] == pytest.approx(CELLS**-2 / (math.pi * math.hypot(20, 20) / CELLS), rel=1e-3)
    assert response[0, 5] == pytest.approx(response[5, 0])
    assert response[0, 5] == pytest.approx(response[0, size - 5])
    # Under a square of side a: 4 a ln(1 + sqrt 2) / pi.
    assert response[0, 0] == pytest.approx(4 / CELLS * math.log(1 + math.sqrt(2)) / math.pi)


# Scores.


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.booleans())
@settings(max_examples=50)
def test_scores_are_those_of_plain_loops(seed: int, n: int, grouped: bool) -> None:
    rng = np.random.default_rng(seed)
    probabilities = rng.dirichlet([0.3, 0.5, 0.7], n)
    truth, refused = rng.integers(0, 3, n), rng.random(n) < 0.3
    found = score(Answers(probabilities, truth, refused, rng.integers(0, 4, n) if grouped else None))
    said = [int(np.argmax(row)) for row in probabilities]
    top = [float(max(row)) for row in probabilities]
    right = [a == b for a, b in zip(said, truth.tolist(), strict=True)]
    assert found.right.value == pytest.approx(sum(right) / n)
    recalls = [np.mean([r for r, t in zip(right, truth, strict=True) if t == k]) for k in sorted(set(truth.tolist()))]
    assert found.macro_recall == pytest.approx(np.mean(recalls))
    assert found.log_loss.value == pytest.approx(
        np.mean([-math.log(max(row[t], 1e-12)) for row, t in zip(probabilities, truth, strict=True)])
    )
    assert found.overstated.value == pytest.approx(np.mean(top) - np.mean(right))
    assert found.sure.value == pytest.approx(np.mean([p > 0.9 for p in top]))
    sure_right = [r for r, p in zip(right, top, strict=True) if p > 0.9]
    assert (found.sure_right is None) == (not sure_right)
    if found.sure_right is not None:
        assert found.sure_right.value == pytest.approx(np.mean(sure_right))
    assert found.refused.value == pytest.approx(refused.mean())
    kept = [r for r, gone in zip(right, refused, strict=True) if not gone]
    assert (found.kept_right is None) == (not kept)
    if found.kept_right is not None:
        assert found.kept_right.value == pytest.approx(np.mean(kept))
    for t in range(3):
        for a in range(3):
            assert found.confusion[t, a] == sum(x == t and y == a for x, y in zip(truth.tolist(), said, strict=True))
    bins: dict[int, list[int]] = {}
    for i, p in enumerate(top):
        bins.setdefault(min(int(10 * p), 9), []).append(i)
    apart = sum(len(b) * abs(np.mean([top[i] for i in b]) - np.mean([right[i] for i in b])) for b in bins.values())
    assert found.calibration_error == pytest.approx(apart / n)
    assert [one.n for one in found.reliability] == [len(bins[k]) for k in sorted(bins)]
    for one, k in zip(found.reliability, sorted(bins), strict=True):
        hits = sum(right[i] for i in bins[k])
        assert one.probability == pytest.approx(np.mean([top[i] for i in bins[k]]))
        assert (one.right, one.low, one.high) == (hits / one.n, *share_interval(hits, one.n))
    assert found.reliability == reliability(np.array(top), np.array(right))
    surest = sorted(range(n), key=lambda i: -top[i])
    assert found.refusals == refusal_curve(np.array(top), np.array(right))
    assert found.refusals[0][0] == 0
    for share, errors in found.refusals:
        kept_n = round(n * (1 - share))
        assert errors == pytest.approx(np.mean([not right[i] for i in surest[:kept_n]]))
    shares = [share for share, _ in found.refusals]
    assert shares == sorted(set(shares))
    assert len(shares) == min(n, 20)
