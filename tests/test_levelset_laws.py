"""Laws of sections: nesting, symmetry, scale, addition, borders, gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.levelset import (
    SCHEDULES,
    VaryingThreshold,
    cut,
    even,
    find_contacts,
    geometric,
    outlines,
    reconstruct_from_sections,
)
from varishold.levelset.schedule import whole_section


def bumps(seed: int, shape: tuple[int, int] = (14, 17), noise: float = 0.02, n: int = 3) -> np.ndarray:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    frame = np.zeros(shape)
    for _ in range(rng.integers(1, n + 1)):
        cy, cx = rng.uniform(0, shape[0]), rng.uniform(0, shape[1])
        frame = np.maximum(frame, rng.uniform(0.4, 1) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / rng.uniform(4, 30)))
    return frame + rng.normal(0, noise, shape)


def totals(frame, levels, **options):
    contacts = find_contacts(frame, levels, **options)
    return {
        name: sum(np.nan_to_num(getattr(c.profile, name)) for c in contacts)
        for name in ("area", "perimeter", "parts", "holes")
    }


seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=40)


@few
@given(seeds)
def test_sections_nest(seed):
    for contact in find_contacts(bumps(seed), 24, floor=0.1):
        profile = contact.profile
        assert np.all(np.diff(profile.threshold) < 0)
        assert np.all(np.diff(profile.area) >= -1e-12)
        assert np.all(np.diff(profile.extent, axis=0) >= -1e-12)
        assert np.all(profile.parts >= 1)
        assert np.all(profile.holes >= 0)
        assert profile.threshold[0] < contact.peak
        assert profile.threshold[-1] > contact.floor


@few
@given(seeds, st.integers(0, 5), st.integers(0, 5))
def test_translation_moves_the_centroid_and_nothing_else(seed, down, right):
    frame = bumps(seed, (8, 8))
    wide, moved = np.zeros((16, 16)), np.zeros((16, 16))
    wide[1:9, 1:9] = frame
    moved[1 + down : 9 + down, 1 + right : 9 + right] = frame
    for a, b in zip(find_contacts(wide, 12, floor=0.1), find_contacts(moved, 12, floor=0.1), strict=True):
        np.testing.assert_allclose(a.profile.area, b.profile.area, rtol=1e-9)
        np.testing.assert_allclose(a.profile.perimeter, b.profile.perimeter, rtol=1e-9)
        np.testing.assert_allclose(a.profile.covariance, b.profile.covariance, atol=1e-9)
        np.testing.assert_allclose(a.profile.extent, b.profile.extent, atol=1e-9)
        np.testing.assert_allclose(np.add(a.profile.centroid, (right, down)), b.profile.centroid, atol=1e-9)
        assert np.array_equal(a.profile.parts, b.profile.parts)
        assert np.array_equal(a.profile.holes, b.profile.holes)


@few
@given(seeds)
def test_quarter_turn_turns_centroid_covariance_and_widths(seed):
    frame = bumps(seed)
    # rot90 takes (x, y) to (y, -x), counted from the centre.
    for a, b in zip(find_contacts(frame, 12, floor=0.1), find_contacts(np.rot90(frame), 12, floor=0.1), strict=True):
        np.testing.assert_allclose(a.profile.area, b.profile.area, rtol=1e-9)
        x, y = a.profile.centroid.T
        np.testing.assert_allclose(b.profile.centroid, np.array([y, -x]).T, atol=1e-9)
        np.testing.assert_allclose(b.profile.covariance[:, 0, 0], a.profile.covariance[:, 1, 1], atol=1e-9)
        np.testing.assert_allclose(b.profile.covariance[:, 0, 1], -a.profile.covariance[:, 0, 1], atol=1e-9)
        np.testing.assert_allclose(np.roll(b.profile.extent, 8, axis=1), a.profile.extent, atol=1e-9)
        assert np.array_equal(a.profile.holes, b.profile.holes)


@few
@given(seeds)
def test_mirror_mirrors(seed):
    frame = bumps(seed)
    for a, b in zip(find_contacts(frame, 12, floor=0.1), find_contacts(frame[:, ::-1], 12, floor=0.1), strict=True):
        np.testing.assert_allclose(a.profile.area, b.profile.area, rtol=1e-9)
        np.testing.assert_allclose(a.profile.centroid * (-1, 1), b.profile.centroid, atol=1e-9)
        np.testing.assert_allclose(np.roll(a.profile.extent[:, ::-1], 1, axis=1), b.profile.extent, atol=1e-9)
        assert a.borders.left == b.borders.right
        assert a.borders.top == b.borders.top


@few
@given(seeds, st.integers(-20, 20))
def test_pressure_and_thresholds_scale_together(seed, power):
    frame, levels, factor = bumps(seed), np.linspace(0.1, 0.9, 9), 2.0**power
    for a, b in zip(
        find_contacts(frame, levels, floor=0.1),
        find_contacts(factor * frame, factor * levels, floor=factor * 0.1),
        strict=True,
    ):
        np.testing.assert_allclose(a.profile.area, b.profile.area, rtol=1e-12)
        np.testing.assert_allclose(a.profile.extent, b.profile.extent, rtol=1e-12)
        assert np.array_equal(a.profile.parts, b.profile.parts)


@few
@given(seeds, st.sampled_from(["rising", "shuffled", "crowded", "equal"]))
def test_a_section_depends_on_its_own_threshold_alone(seed, order):
    rng, frame = np.random.default_rng(seed), bumps(seed)
    levels = np.sort(rng.uniform(0.1, 1.0, 9))
    if order == "crowded":
        # All but one within a hair of each other, some of them values of the frame.
        levels = np.sort(np.r_[0.99, 0.5 + 1e-7 * rng.random(9), rng.choice(frame[frame > 0.11], 3)])
    elif order == "shuffled":
        rng.shuffle(levels)
    elif order == "equal":
        levels[:] = levels[4]
    together = find_contacts(frame, levels, floor=0.1)
    for i, level in enumerate(np.sort(levels)[::-1]):
        alone = {c.peak_taxel: c.profile for c in find_contacts(frame, [level], floor=0.1)}
        for contact in together:
            one = alone[contact.peak_taxel]
            np.testing.assert_allclose(contact.profile.area[i], one.area[0], rtol=1e-12)
            np.testing.assert_allclose(contact.profile.perimeter[i], one.perimeter[0], rtol=1e-12)
            np.testing.assert_allclose(contact.profile.extent[i], one.extent[0], rtol=1e-12)
            assert np.array_equal(contact.profile.counts[:, i], one.counts[:, 0])


@few
@given(seeds, st.floats(0.2, 5), st.floats(0.2, 5))
def test_pitch_scales_lengths(seed, row_pitch, col_pitch):
    frame = bumps(seed)
    plain = find_contacts(frame, 8, floor=0.1)
    scaled = find_contacts(frame, 8, floor=0.1, pitch=(row_pitch, col_pitch))
    for a, b in zip(plain, scaled, strict=True):
        np.testing.assert_allclose(a.profile.area * row_pitch * col_pitch, b.profile.area, rtol=1e-9)
        np.testing.assert_allclose(a.profile.centroid * (col_pitch, row_pitch), b.profile.centroid, atol=1e-9)
        np.testing.assert_allclose(a.profile.extent[:, 0] * col_pitch, b.profile.extent[:, 0], rtol=1e-9)
        np.testing.assert_allclose(a.profile.extent[:, 8] * row_pitch, b.profile.extent[:, 8], rtol=1e-9)
        assert b.pitch == (row_pitch, col_pitch)


@few
@given(seeds)
def test_contacts_add_up_to_the_whole_section(seed):
    frame = bumps(seed)
    floor = 0.51 * frame.max()
    levels = np.linspace(floor, frame.max(), 5)[:-1]
    total = totals(frame, levels, floor=floor)
    for i, level in enumerate(levels[::-1]):
        whole = whole_section(frame, level)
        assert total["area"][i] == pytest.approx(whole.area[0], rel=1e-9)
        assert total["perimeter"][i] == pytest.approx(whole.perimeter[0], rel=1e-9)
        assert total["parts"][i] == whole.parts[0]
        assert total["holes"][i] == whole.holes[0]


@few
@given(seeds)
def test_two_ways_through_the_border_agree(seed):
    """A pad inside a larger one whose other taxels do not exist is the pad itself."""
    frame = bumps(seed, (7, 9))
    larger = np.full((9, 12), np.nan)
    larger[1:8, 2:11] = frame
    for a, b in zip(find_contacts(frame, 16, floor=0.05), find_contacts(larger, 16, floor=0.05), strict=True):
        np.testing.assert_allclose(a.profile.area, b.profile.area, rtol=1e-9)
        np.testing.assert_allclose(a.profile.perimeter, b.profile.perimeter, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(a.profile.covariance, b.profile.covariance, atol=1e-9)
        np.testing.assert_allclose(a.profile.extent, b.profile.extent, atol=1e-9)
        assert np.array_equal(a.profile.parts, b.profile.parts)
        assert np.array_equal(a.profile.holes, b.profile.holes)
        assert a.borders == b.borders


@few
@given(seeds, st.floats(0.0, 0.4))
def test_a_plane_has_the_area_of_its_taxels_whatever_the_field(seed, share):
    rng = np.random.default_rng(seed)
    field = rng.random((8, 9)) >= share
    contacts = find_contacts(np.where(field, 1.0, np.nan), 3, floor=0.5)
    again = find_contacts(np.ones((8, 9)), 3, floor=0.5, field=field)
    assert sum(c.n_taxels for c in contacts) == field.sum()
    for i in range(3):
        assert sum(c.profile.area[i] for c in contacts) == pytest.approx(field.sum(), rel=1e-12)
        assert sum(c.profile.perimeter[i] for c in contacts) == 0
        # A gap with another contact inside is a hole: beside it stands a taxel that the section lacks.
        assert sum(c.profile.holes[i] for c in contacts) <= len(contacts) - 1
        assert [c.profile.area[i] for c in contacts] == [c.profile.area[i] for c in again]


def test_a_gap_is_a_hole_only_with_an_uncovered_taxel_beside_it():
    frame = np.ones((7, 7))
    frame[3, 3] = np.nan
    (contact,) = find_contacts(frame, [0.5], floor=0.2)
    assert contact.profile.holes.tolist() == [0]
    frame[3, 4] = 0.0
    (contact,) = find_contacts(frame, [0.5], floor=0.2)
    assert contact.profile.holes.tolist() == [1]
    frame[3, 3] = 0.0
    (contact,) = find_contacts(frame, [0.5], floor=0.2)
    assert contact.profile.holes.tolist() == [1]


def test_a_ring_has_one_hole_until_its_middle_comes_in():
    y, x = np.mgrid[-8:9, -8:9]
    frame = np.exp(-((np.hypot(x, y) - 4.5) ** 2) / 4)
    (contact,) = find_contacts(frame, np.array([0.8, 0.5, 0.2, 0.005]), floor=0.001)
    assert contact.profile.parts.tolist() == [1, 1, 1, 1]
    assert contact.profile.holes.tolist() == [1, 1, 1, 0]


def test_ties_and_plateaus():
    frame = np.zeros((6, 6))
    frame[1:5, 1:5] = 2.0
    (contact,) = find_contacts(frame, np.array([2.0, np.nextafter(2.0, 0), 1.0]), floor=0.5)
    area = contact.profile.area
    assert area[0] == 0
    assert area[1] == pytest.approx(9)
    assert area[2] == pytest.approx(9 + 4 * 1.5 + 4 * 0.125)
    assert contact.profile.parts.tolist() == [0, 1, 1]
    assert np.isnan(contact.profile.centroid[0]).all()
    assert contact.profile.extent[0].tolist() == [0] * 16


def test_saddles_follow_the_mean_of_the_cell():
    frame = np.zeros((4, 4))
    frame[1, 1] = frame[2, 2] = 1.0
    # The mean of the cell is 0.5.
    (contact,) = find_contacts(frame, np.array([0.6, 0.4]), floor=0.3)
    assert contact.profile.parts.tolist() == [2, 1]
    assert len(find_contacts(frame, 4, floor=0.5)) == 2
    assert len(outlines(frame, 0.6)) == 2
    assert len(outlines(frame, 0.4)) == 1


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
def test_pads_of_one_row_or_column(shape):
    frame = np.linspace(0.1, 1.0, max(shape)).reshape(shape)
    (contact,) = find_contacts(frame, 4, floor=0.05)
    n = max(shape)
    assert contact.profile.area[-1] <= n
    assert contact.profile.extent[:, 8 if shape[0] == 1 else 0] == pytest.approx(1.0)


@few
@given(seeds, st.sampled_from(sorted(SCHEDULES)))
def test_a_held_contact_gives_the_same_profile_section_by_section(seed, name):
    frame = bumps(seed, n=1)
    floor = max(0.51 * float(frame.max()), 1e-3)
    contacts = find_contacts(frame, SCHEDULES[name](float(frame.max()), floor, 9), floor=floor)
    falling = VaryingThreshold(SCHEDULES[name](float(frame.max()), floor, 9))
    while not falling.ended:
        falling.feed(frame)
    assert falling.profile.parts.tolist() == sum(c.profile.parts for c in contacts).tolist()
    if len(contacts) == 1:
        one = contacts[0].profile
        np.testing.assert_allclose(falling.profile.area, one.area, rtol=1e-9)
        np.testing.assert_allclose(falling.profile.covariance, one.covariance, atol=1e-9)
        np.testing.assert_allclose(falling.profile.extent, one.extent, atol=1e-9)
        np.testing.assert_allclose(falling.profile.centroid, one.centroid, atol=1e-9)


def test_the_even_schedule_is_the_default_of_contacts():
    frame = bumps(3)
    for contact in find_contacts(frame, 7, floor=0.1):
        np.testing.assert_allclose(contact.profile.threshold, even(contact.peak, contact.floor, 7), rtol=1e-12)


@few
@given(seeds, st.integers(1, 40))
def test_sections_rebuild_v_to_one_decrement(seed, n):
    frame = np.maximum(bumps(seed), 0.0)
    theta = np.sort(np.random.default_rng(seed).uniform(0.05, frame.max(), n))[::-1]
    rebuilt = reconstruct_from_sections(cut(frame, theta), theta, delta=0.0)
    largest = max(frame.max() - theta[0], theta[-1], *(theta[:-1] - theta[1:]), 0.0)
    assert np.all(rebuilt <= frame + 1e-12)
    assert np.all(frame - rebuilt <= largest + 1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: even(1.0, 2.0, 4), "falls from its top to delta, got top = 1.0, delta = 2.0"),
        (lambda: even(1.0, 0.0, 0), "at least one threshold, got 0"),
        (lambda: geometric(1.0, 0.0, 4), "delta > 0, got 0.0"),
        (lambda: VaryingThreshold(np.array([1.0, 2.0])), "thresholds must fall"),
        (lambda: VaryingThreshold(np.array([1.0])).feed(np.ones(3)), "shape (rows, cols), got float64 of shape (3,)"),
        (lambda: VaryingThreshold(np.array([1.0])).profile, "no section has arrived yet"),
        (lambda: outlines(np.ones(3), 0.5), "shape (rows, cols), got float64 of shape (3,)"),
        (lambda: outlines(np.ones((3, 3)), np.nan), "a level must be finite"),
        (lambda: reconstruct_from_sections(np.ones((2, 3, 3)), [1.0]), "one threshold for each"),
        (lambda: reconstruct_from_sections(np.ones((2, 3, 3)), [1.0, 2.0]), "thresholds must fall"),
    ],
)
def test_messages(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value)
