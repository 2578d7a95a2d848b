"""Sections taken together, their axes, cuts of a whole frame, thresholds in time: each against plain sums."""

from __future__ import annotations

import itertools

import contourpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.levelset import (
    DIRECTIONS,
    SCHEDULES,
    VaryingThreshold,
    cut,
    find_contacts,
    find_contacts_batch,
    outlines,
    reconstruct_from_sections,
)
from varishold.levelset.joined import join_sections
from varishold.levelset.outline import outlines_at
from varishold.levelset.schedule import whole_section
from varishold.levelset.second_moments import principal_angle, principal_moments

few = settings(max_examples=40)
seeds = st.integers(0, 2**32 - 1)
NAMES = ("area", "perimeter", "x", "y", "xx", "xy", "yy", "length", "breadth")


def hills(rng: np.random.Generator, rows: int, cols: int) -> np.ndarray:
    frame = rng.normal(0.0, 1.0, (rows, cols))
    wide = np.pad(frame, 1, mode="edge")
    frame = wide[:-2, 1:-1] + wide[2:, 1:-1] + wide[1:-1, :-2] + wide[1:-1, 2:] + 2 * wide[1:-1, 1:-1]
    return frame - frame.min() + 0.1


# Second moments


@few
@given(st.tuples(*3 * [st.floats(-3, 3)]))
def test_principal_moments_and_axes_are_those_of_the_matrix(factor: tuple[float, float, float]) -> None:
    half = np.array([[factor[0], 0.0], [factor[1], factor[2]]])
    matrix = half @ half.T
    xx, xy, yy = matrix[0, 0], matrix[0, 1], matrix[1, 1]
    small, large = np.linalg.eigvalsh(matrix)
    told = principal_moments(xx, xy, yy)
    np.testing.assert_allclose(told, [large, max(small, 0.0)], rtol=1e-9, atol=1e-12)
    angle = principal_angle(xx, xy, yy)
    assert -np.pi / 2 <= angle < np.pi / 2
    along = np.array([np.cos(angle), np.sin(angle)])
    assert along @ matrix @ along == pytest.approx(large, abs=1e-9)
    many = principal_moments(*(np.full(3, of) for of in (xx, xy, yy)))
    np.testing.assert_array_equal(many, [[of] * 3 for of in told])


@pytest.mark.parametrize("degrees", [-90, -89, -45, -1, 0, 1, 30, 45, 89])
def test_the_axis_of_a_turned_ellipse_has_its_angle_and_moments(degrees: float) -> None:
    turn = np.radians(degrees)
    c, s = np.cos(turn), np.sin(turn)
    xx, xy, yy = 9 * c * c + 4 * s * s, 5 * c * s, 9 * s * s + 4 * c * c
    assert principal_moments(xx, xy, yy) == pytest.approx((9.0, 4.0))
    angle = principal_angle(xx, xy, yy)
    assert np.angle(np.exp(2j * (angle - turn))) == pytest.approx(0.0, abs=1e-9)
    # Rounding may leave a moment a little below nothing.
    assert principal_moments(1.0, 1.0 + 1e-12, 1.0)[1] == 0.0
    assert principal_moments(-1.0, 0.0, -1.0) == (0.0, 0.0)


# Sections of all contacts of a frame


def plainly_joined(n_frames: int, frame: np.ndarray, area: np.ndarray, *others: np.ndarray) -> dict[str, np.ndarray]:
    """Contact by contact and level by level, by the second moments about the origin."""
    perimeter, centroid, covariance = others
    n_levels = area.shape[1]
    sums = np.zeros((n_frames, n_levels, 7))
    for k, f in enumerate(frame):
        for i in range(n_levels):
            own = [j for j in range(i + 1) if not np.isnan(area[k, j])]
            at = own[-1] if own else 0
            a = area[k, at]
            if not a > 0:
                continue
            (x, y), c = centroid[k, at], covariance[k, at]
            second = c[0, 0] + x * x, c[0, 1] + x * y, c[1, 1] + y * y
            sums[f, i] += [a, perimeter[k, at], a * x, a * y, *(a * of for of in second)]
    out = {name: np.zeros((n_frames, n_levels)) for name in NAMES}
    for at in np.ndindex(n_frames, n_levels):
        a, length, x, y, xx, xy, yy = sums[at]
        if not a > 0:
            continue
        x, y = x / a, y / a
        matrix = np.array([[xx / a - x * x, xy / a - x * y], [xy / a - x * y, yy / a - y * y]])
        small, large = np.maximum(np.linalg.eigvalsh(matrix), 0.0)
        told = (a, length, x, y, matrix[0, 0], matrix[0, 1], matrix[1, 1], 4 * np.sqrt(large), 4 * np.sqrt(small))
        for name, value in zip(NAMES, told, strict=True):
            out[name][at] = value
    return out


@few
@given(seeds, st.booleans())
def test_joined_sections_are_plain_sums_over_the_contacts(seed: int, even: bool) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:14, :18]
    frames = np.zeros((4, 14, 18))
    for frame in frames[1:]:
        for _ in range(rng.integers(1, 4)):
            cx, cy = rng.uniform(0, 18), rng.uniform(0, 14)
            frame += rng.uniform(0.4, 1) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / rng.uniform(2, 12))
    levels = 5 if even else np.sort(rng.uniform(0.05, 1.2, 5))
    batch = find_contacts_batch(frames, levels, floor=0.05, pitch=(0.5, 0.25))
    parts = batch.frame, batch.area, batch.perimeter, batch.centroid, batch.covariance
    told = join_sections(parts[0], 4, *parts[1:])
    wanted = plainly_joined(4, *parts)
    assert tuple(told) == NAMES
    for name in NAMES:
        assert told[name].shape == (4, 5)
        np.testing.assert_allclose(told[name], wanted[name], rtol=1e-7, atol=1e-7, err_msg=name)
    assert not told["area"][0].any()


def test_a_disc_in_two_halves_is_a_disc_and_what_has_ended_stays_as_it_was() -> None:
    nan = np.nan
    # A unit square, and beside it another that ends after its first level.
    area = np.array([[1.0, 1.0, 4.0], [1.0, nan, nan], [nan, nan, nan]])
    perimeter = np.array([[4.0, 4.0, 8.0], [4.0, nan, nan], [nan, nan, nan]])
    centroid = np.array([[[0.0, 0.0]] * 3, [[1.0, 0.0], [nan, nan], [nan, nan]], [[nan, nan]] * 3])
    square = np.eye(2) / 12
    covariance = np.array([[square, square, 4 * square], [square, nan * square, nan * square], 3 * [nan * square]])
    told = join_sections(np.array([1, 1, 1]), 2, area, perimeter, centroid, covariance)
    np.testing.assert_array_equal(told["area"], [[0, 0, 0], [2, 2, 5]])
    np.testing.assert_array_equal(told["perimeter"], [[0, 0, 0], [8, 8, 12]])
    np.testing.assert_allclose(told["x"][1], [0.5, 0.5, 0.2])
    np.testing.assert_allclose(told["xx"][1, 0], 4 / 12)
    np.testing.assert_allclose(told["yy"][1, 0], 1 / 12)
    np.testing.assert_allclose(told["length"][1, 0], 4 * np.sqrt(4 / 12))
    np.testing.assert_allclose(told["breadth"][1, 0], 4 * np.sqrt(1 / 12))
    none = join_sections(np.empty(0, int), 2, np.empty((0, 3)), *(np.empty((0, 3, *s)) for s in ((), (2,), (2, 2))))
    assert all(of.shape == (2, 3) and not of.any() for of in none.values())


# Whole frames


def contour(frame: np.ndarray, pitch: tuple[float, float]) -> contourpy.ContourGenerator:
    axes = [(np.r_[-0.5, np.arange(n), n - 0.5] - (n - 1) / 2) * p for n, p in zip(frame.shape, pitch, strict=True)]
    return contourpy.contour_generator(
        axes[1], axes[0], np.pad(frame, 1, mode="edge"), name="serial", fill_type="OuterOffset", line_type="Separate"
    )


@few
@given(seeds, st.integers(1, 9), st.integers(1, 9), st.sampled_from([None, 0.5, (2.0, 0.25)]))
def test_a_whole_section_is_contourpys_at_any_pitch(seed: int, rows: int, cols: int, pitch: object) -> None:
    frame = hills(np.random.default_rng(seed), rows, cols)
    level = float(np.quantile(frame, 0.6)) + 1e-7
    spacing = (1.0, 1.0) if pitch is None else (pitch, pitch) if isinstance(pitch, float) else pitch
    gen = contour(frame, spacing)
    polygons, offsets = gen.filled(level, np.inf)
    lines = gen.lines(level)
    area = 0.0
    for points, stops in zip(polygons, offsets, strict=True):
        for a, b in itertools.pairwise(stops):
            x, y = points[a:b].T
            area += (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2
    told = whole_section(frame, level, pitch)
    assert len(told) == 1
    assert told.threshold.tolist() == [level]
    assert told.area[0] == pytest.approx(area, rel=1e-9, abs=1e-12)
    assert told.perimeter[0] == pytest.approx(sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in lines))
    assert (told.parts[0], told.holes[0]) == (len(polygons), sum(len(stops) - 2 for stops in offsets))
    if polygons:
        points = np.concatenate(polygons)
        reach = points @ np.array([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
        np.testing.assert_allclose(told.extent[0], np.ptp(reach, axis=0), rtol=1e-9, atol=1e-9)
    mine = outlines(frame, level, pitch_m=pitch)

    def points_of(lines: list[np.ndarray]) -> np.ndarray:
        return np.array(sorted({(round(x, 9), round(y, 9)) for line in lines for x, y in line})).reshape(-1, 2)

    np.testing.assert_allclose(points_of(mine), points_of(lines), atol=2e-9)
    assert len(mine) == len(lines)


def test_widths_stand_in_sixteen_even_directions() -> None:
    np.testing.assert_allclose(DIRECTIONS, np.pi * np.arange(16) / 16)
    square = np.zeros((9, 13))
    square[3:6, 4:9] = 1.0
    section = whole_section(square, 1.0 - 1e-9)
    np.testing.assert_allclose(section.extent[0], 4 * np.abs(np.cos(DIRECTIONS)) + 2 * np.abs(np.sin(DIRECTIONS)))


@few
@given(seeds)
def test_outlines_of_part_of_an_array_at_several_levels_are_those_of_its_own(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wide = hills(rng, 9, 12)
    top, left = rng.integers(0, 3, 2)
    part = wide[top : top + 6, left : left + 8]
    levels = [*np.quantile(wide, [0.3, 0.6, 0.9, 0.99]).tolist(), float(wide.max()) + 1.0]
    together = outlines_at(part, None, 0, levels, (2.0, 0.5)).by_level()
    assert len(together) == len(levels)
    assert together[-1] == []
    for level, lines in zip(levels, together, strict=True):
        alone = outlines(part.copy(), level, pitch_m=(2.0, 0.5))
        assert len(lines) == len(alone)
        for one, other in zip(lines, alone, strict=True):
            np.testing.assert_array_equal(one, other)


@few
@given(seeds, st.sampled_from([None, (2.0, 0.5)]))
def test_the_outlines_of_all_contacts_are_those_of_the_frame(seed: int, pitch: tuple[float, float] | None) -> None:
    frame = hills(np.random.default_rng(seed), 8, 11)
    floor = 0.51 * float(frame.max())
    levels = np.linspace(floor + 1e-7, float(frame.max()), 4)[::-1]
    contacts = find_contacts(frame, levels, floor=floor, pitch=pitch)
    row_pitch, col_pitch = pitch or (1.0, 1.0)
    for i, level in enumerate(levels):
        each = [contact.outlines(i) for contact in contacts]
        mine = sorted(line.tolist() for lines in each for line in lines)
        assert mine == sorted(line.tolist() for line in outlines(frame, level, pitch_m=pitch))
        for contact, lines in zip(contacts, each, strict=True):
            rows, cols = contact.window
            for line in lines:
                # No farther than the next taxel, which is another's or below.
                col, row = line[:, 0] / col_pitch + 5, line[:, 1] / row_pitch + 3.5
                assert ((col > cols.start - 1) & (col < cols.stop)).all()
                assert ((row > rows.start - 1) & (row < rows.stop)).all()


@pytest.mark.parametrize("level", [np.inf, -np.inf, np.nan])
def test_a_level_is_finite(level: float) -> None:
    with pytest.raises(InputError, match=f"a level must be finite, got {level}"):
        outlines(np.ones((2, 2)), level)


# Thresholds in time


@few
@given(seeds, st.sampled_from([None, 0.5, (2.0, 0.25)]))
def test_each_instant_cuts_its_own_frame_at_its_own_threshold(seed: int, pitch: object) -> None:
    rng = np.random.default_rng(seed)
    frames = [hills(rng, 7, 8) for _ in range(4)]
    theta = np.sort(rng.uniform(1.0, 8.0, 4))[::-1]
    theta[2] = theta[1]  # it may rest
    falling = VaryingThreshold(theta.tolist(), pitch)
    assert falling.thresholds.dtype == np.float64
    for i, frame in enumerate(frames):
        assert (falling.instant, falling.ended) == (i, False)
        section = falling.feed(frame)
        wanted = whole_section(frame, theta[i], pitch)
        np.testing.assert_array_equal(section.measures, wanted.measures)
        so_far = falling.profile
        assert len(so_far) == i + 1
        for name in ("threshold", "area", "perimeter", "centroid", "covariance", "extent", "parts", "holes"):
            np.testing.assert_array_equal(getattr(so_far, name)[i], getattr(wanted, name)[0], err_msg=name)
            np.testing.assert_array_equal(getattr(so_far, name)[: i + 1], getattr(so_far, name))
    np.testing.assert_array_equal(falling.profile.threshold, theta)
    assert (falling.instant, falling.ended) == (4, True)
    with pytest.raises(InputError, match="the threshold has ended after 4 instants; start a new one"):
        falling.feed(frames[0])
    assert falling.instant == 4


@pytest.mark.parametrize(
    "thresholds", [[], [1.0, np.nan], [np.inf, 1.0], [[2.0, 1.0]], 1.0, [1.0, 2.0], [1.0, 0.5, 0.6]]
)
def test_thresholds_in_time_fall_and_are_finite(thresholds: object) -> None:
    with pytest.raises(InputError, match="thresholds must fall and be finite, got shape"):
        VaryingThreshold(thresholds)


@given(st.floats(-5, 5), st.floats(0.1, 9), st.integers(1, 30))
def test_schedules_fall_between_their_ends(delta: float, height: float, n: int) -> None:
    depth = (np.arange(n) + 0.5) / n
    for name, schedule in SCHEDULES.items():
        if name == "geometric":
            low, top = abs(delta) + 0.1, abs(delta) + 0.1 + height
            wanted = np.exp(np.log(top) * (1 - depth) + np.log(low) * depth)
        else:
            low, top = delta, delta + height
            wanted = top - height * depth ** (1 if name == "even" else 2)
        theta = schedule(top, low, n)
        np.testing.assert_allclose(theta, wanted, rtol=1e-9, atol=1e-12)
        assert theta.dtype == np.float64


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ((1.0, 0.5, 0), "at least one threshold, got 0"),
        ((1.0, 1.0, 1), "falls from its top to delta, got top = 1.0, delta = 1.0"),
        ((np.inf, 1.0, 1), "got top = inf, delta = 1.0"),
        ((1.0, -np.inf, 1), "got top = 1.0, delta = -inf"),
        ((np.nan, 0.5, 1), "got top = nan"),
    ],
)
def test_every_schedule_refuses_alike(given_: tuple[float, float, int], message: str) -> None:
    for schedule in SCHEDULES.values():
        with pytest.raises(InputError, match=message):
            schedule(*given_)
    with pytest.raises(InputError, match=r"needs delta > 0, got -0\.5"):
        SCHEDULES["geometric"](1.0, -0.5, 3)
    assert SCHEDULES["geometric"](4.0, 1.0, 1).tolist() == [2.0]


# The sum of the sections


@given(
    st.lists(st.lists(st.integers(0, 6), min_size=3, max_size=3), min_size=1, max_size=4),
    st.lists(st.integers(0, 6), min_size=1, max_size=6),
    st.integers(0, 2),
)
def test_sections_sum_to_the_highest_threshold_below_v(rows: list[list[int]], levels: list[int], below: int) -> None:
    """Eq. [4] telescopes: with delta = 0, what is rebuilt is the highest of 0 and the next threshold under each V."""
    frame, theta = np.array(rows, float), np.sort(np.array(levels, float))[::-1]
    sections = cut(rows, levels := theta.tolist())
    assert sections.shape == (len(theta), *frame.shape)
    assert sections.dtype == np.bool_
    for section, level in zip(sections, theta, strict=True):
        np.testing.assert_array_equal(section, frame > level)
    delta = theta[-1] - below
    told = reconstruct_from_sections(sections.tolist(), levels, delta=delta)
    wanted = np.full(frame.shape, delta)
    for at, v in np.ndenumerate(frame):
        wanted[at] = max([delta, *(t for t in theta if t < v)])
    np.testing.assert_allclose(told, wanted)
    assert told.dtype == np.float64
    np.testing.assert_array_equal(reconstruct_from_sections(sections, theta), np.maximum(wanted, theta[-1]))


@pytest.mark.parametrize(
    ("sections", "theta", "delta"),
    [
        (np.ones((2, 3, 3)), [2.0, np.nan], None),
        (np.ones((2, 3, 3)), [np.inf, 1.0], None),
        (np.ones((2, 3, 3)), [2.0, 1.0], 1.5),
        (np.ones((1, 3, 3)), [2.0], 2.5),
    ],
)
def test_thresholds_of_sections_fall(sections: np.ndarray, theta: list[float], delta: float | None) -> None:
    with pytest.raises(InputError, match="thresholds must fall down to delta"):
        reconstruct_from_sections(sections, theta, delta=delta)


@pytest.mark.parametrize(
    ("shape", "n"), [((2, 3, 3), 3), ((3, 3), 3), ((2, 3, 3, 3), 2), ((0, 3, 3), 0), ((1, 3, 3), 2)]
)
def test_sections_have_one_threshold_each(shape: tuple[int, ...], n: int) -> None:
    with pytest.raises(InputError, match=r"need sections \(n, rows, cols\) and one threshold for each, got shapes"):
        reconstruct_from_sections(np.ones(shape), np.arange(n)[::-1])
