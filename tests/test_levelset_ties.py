"""What holds where values tie: taxels at the threshold, saddles at their mean, plateaus, equal peaks and areas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from varishold.errors import InputError
from varishold.levelset import SCHEDULES, Contact, cut, find_contacts, geometric, outlines, quadratic
from varishold.levelset import reconstruct_from_sections as rebuilt

# Few different values, so that taxels tie with thresholds and cells with their saddles all the time.
steps = arrays(np.float64, (6, 7), elements=st.integers(0, 4).map(float))
few = settings(max_examples=60)


def turned_area(outline: np.ndarray) -> float:
    """Signed area of a closed polygon: positive where it turns from x to y."""
    x, y = outline.T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2)


def framed(values: np.ndarray) -> np.ndarray:
    return np.pad(values, 1)


def sums(contacts: list[Contact], name: str) -> np.ndarray:
    return np.sum([np.zeros(5), *(np.nan_to_num(getattr(c.profile, name)) for c in contacts)], axis=0)


@few
@given(steps)
def test_outlines_hold_the_sections_to_the_tie(values: np.ndarray) -> None:
    frame = framed(values)
    levels = np.array([4.0, 3.0, 2.0, 1.0, 0.75])
    contacts = find_contacts(frame, levels, floor=0.5)
    merged = any(np.isnan(c.profile.area).any() for c in contacts)
    for i, level in enumerate(levels):
        found = outlines(frame, level)
        for line in found:
            assert (line[0] == line[-1]).all()
            # Every point is where V, linear between two neighbours, has the level.
            x, y = line.T[0] + 4.0, line.T[1] + 3.5
            c0, r0 = np.floor(x).astype(int), np.floor(y).astype(int)
            c1, r1 = np.ceil(x).astype(int), np.ceil(y).astype(int)
            assert ((c0 == c1) | (r0 == r1)).all()
            share = np.where(c0 != c1, x - c0, y - r0)
            np.testing.assert_allclose(frame[r0, c0] * (1 - share) + frame[r1, c1] * share, level, atol=1e-9)
        if merged:
            continue
        areas = [turned_area(line) for line in found]
        assert sum(areas) == pytest.approx(sums(contacts, "area")[i], abs=1e-9)
        length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in found)
        assert length == pytest.approx(sums(contacts, "perimeter")[i], abs=1e-9)
        assert len(found) == sums(contacts, "parts")[i] + sums(contacts, "holes")[i]


@few
@given(steps, st.integers(1, 3))
def test_a_taxel_at_the_threshold_is_out(values: np.ndarray, level: int) -> None:
    """Just above a value is as at it; just below, the taxels of that value are in."""
    frame = framed(values)
    at, above, below = (
        sum(len(outlines(frame, v)) for v in (x,)) for x in (level, np.nextafter(level, 9), np.nextafter(level, 0))
    )
    assert at == above
    if not (frame == level).any():
        assert at == below
    inside = frame > level
    around = np.zeros_like(inside)
    for line in outlines(frame, level):
        near = np.rint(line + np.array([4.0, 3.5])).astype(int)
        around[near[:, 1], near[:, 0]] = True
    assert around.any() == inside.any()


def test_a_cell_whose_mean_is_the_threshold_keeps_its_corners_apart() -> None:
    frame = np.zeros((4, 4))
    frame[1, 1] = frame[2, 2] = 2.0
    assert len(outlines(frame, 0.5)) == 1
    assert len(outlines(frame, 1.0)) == 2
    assert len(outlines(frame, np.nextafter(1.0, 0))) == 1
    assert [c.profile.parts.tolist() for c in find_contacts(frame, [1.0, 0.9], floor=0.6)] == [[2, 1]]
    # As long as the saddle is no lower than half the peak it is one contact; the saddle itself is where they meet.
    assert len(find_contacts(frame, [1.5], floor=0.6)) == 1
    frame[1, 2] = frame[2, 1] = -0.01
    assert len(find_contacts(frame, [1.5], floor=0.6)) == 2


def test_equal_contacts_come_in_the_order_of_their_taxels_and_larger_ones_first() -> None:
    frame = np.zeros((9, 60))
    for k in range(20):
        frame[3:5, 3 * k + 1] = 1.0
    same = find_contacts(frame, 4, floor=0.1)
    assert len(same) == 20
    columns = [c.peak_taxel[1] for c in same]
    assert columns == sorted(columns)
    frame[6, 1:40] = 1.0
    assert find_contacts(frame, 4, floor=0.1)[0].peak_taxel[0] == 6
    sizes = np.random.default_rng(0).permutation(40)
    many = np.zeros((3, 4 * 40 + 900))
    at = 1
    for size in sizes:
        many[1, at : at + size + 1] = 1.0
        at += size + 3
    areas = [c.profile.area[-1] for c in find_contacts(many, 4, floor=0.1)]
    assert len(areas) == 40
    assert areas == sorted(areas, reverse=True)


@few
@given(steps)
def test_a_plateau_is_one_peak(values: np.ndarray) -> None:
    """Contacts are the parts of {V > floor}, as long as none falls below half of its lower peak in between."""
    frame = framed(np.where(values > 2, 1.0, 0.0))
    contacts = find_contacts(frame, [0.5], floor=0.3)
    assert sum(c.n_taxels for c in contacts) == np.count_nonzero(frame)
    assert sum(int(c.profile.parts[0]) for c in contacts) == sum(turned_area(o) > 0 for o in outlines(frame, 0.5))
    for contact in contacts:
        assert contact.peak == 1.0
        assert frame[contact.peak_taxel] == 1.0
        assert contact.mask.sum() == contact.n_taxels
        window = contact.mask
        # The window is as small as can be.
        assert window.any(axis=0).all() or contact.n_taxels == 0
        assert window[0].any()
        assert window[-1].any()
        assert window[:, 0].any()
        assert window[:, -1].any()
        np.testing.assert_array_equal(frame[contact.window][window], 1.0)


def test_borders_are_those_that_taxels_reach() -> None:
    for row, col, wanted in (
        (0, 3, "top"),
        (6, 3, "bottom"),
        (3, 0, "left"),
        (3, 6, "right"),
    ):
        frame = np.zeros((7, 7))
        frame[row, col] = 1.0
        (contact,) = find_contacts(frame, 3, floor=0.1)
        reached = {name for name in ("left", "right", "top", "bottom") if getattr(contact.borders, name)}
        assert reached == {wanted}
    frame = np.zeros((7, 7))
    frame[3, 3] = 1.0
    (contact,) = find_contacts(frame, 3, floor=0.1)
    assert not any(getattr(contact.borders, name) for name in ("left", "right", "top", "bottom"))


@pytest.mark.parametrize("level", [0.25, 0.5, 0.75])
def test_an_outline_that_meets_the_border_is_open_and_ends_there(level: float) -> None:
    frame = np.zeros((5, 6))
    frame[:, :3] = 1.0
    (line,) = outlines(frame, level, pitch_m=(2.0, 0.5))
    # V falls from 1 in column 2 to 0 in column 3; column 2.5 is the pad's centre.
    np.testing.assert_allclose(line[:, 0], (2 + (1 - level) - 2.5) * 0.5, atol=1e-12)
    assert {line[0, 1], line[-1, 1]} == {-5.0, 5.0}
    # The section is on its left, where x is to the right and y up: it lies at smaller x, so the line runs toward -y.
    steps = np.diff(line[:, 1])
    assert (steps > 0).all() or (steps < 0).all()


def test_schedules_stand_at_half_steps_of_their_own_scale() -> None:
    top, delta, n = 5.0, 0.5, 9
    even, ratio, square = (SCHEDULES[name](top, delta, n) for name in ("even", "geometric", "quadratic"))
    np.testing.assert_allclose(np.diff(even), -(top - delta) / n)
    assert top - even[0] == pytest.approx(even[-1] - delta)
    np.testing.assert_allclose(ratio[1:] / ratio[:-1], (delta / top) ** (1 / n))
    assert top / ratio[0] == pytest.approx(ratio[-1] / delta)
    np.testing.assert_allclose(np.diff(np.sqrt(top - square)), np.sqrt(top - delta) / n)
    assert np.sqrt(top - square[0]) * 2 == pytest.approx(np.sqrt(top - delta) / n)
    assert geometric(2.0, 1.0, 1).shape == quadratic(2.0, 1.0, 1).shape == (1,)
    for bad in ((1.0, 1.0), (np.inf, 1.0), (1.0, np.nan)):
        with pytest.raises(InputError, match="falls from its top to delta"):
            quadratic(*bad, 3)


def test_sections_rebuild_a_staircase_exactly_and_end_on_the_standard_plane() -> None:
    frame = np.array([[0.0, 1.0, 2.0, 3.0]])
    theta = np.array([2.0, 1.0, 0.0])
    np.testing.assert_array_equal(rebuilt(cut(frame, theta), theta, delta=0.0), [[0.0, 0.0, 1.0, 2.0]])
    np.testing.assert_array_equal(rebuilt(cut(frame, theta), theta, delta=-1.0), [[-1.0, 0.0, 1.0, 2.0]])
    np.testing.assert_array_equal(rebuilt(cut(frame, theta), theta), [[0.0, 0.0, 1.0, 2.0]])
    with pytest.raises(InputError, match=r"thresholds must fall down to delta = 0\.5"):
        rebuilt(cut(frame, theta), theta, delta=0.5)
    with pytest.raises(InputError, match="one threshold for each"):
        rebuilt(np.zeros((0, 2, 2)), [])
    for bad in ((frame[0], theta), (frame, theta[None])):
        with pytest.raises(InputError, match=r"need a frame \(rows, cols\) and thresholds \(n,\)"):
            cut(*bad)


@pytest.mark.parametrize("scale", [1.0, 1 / 3, 0.1, 1 / 150, 1e5 / 7])
def test_equal_contacts_come_in_the_order_of_their_peaks_in_any_unit(scale: float) -> None:
    frame = np.zeros((20, 20))
    places = [(2, 3), (2, 12), (9, 8), (15, 2), (15, 14)]
    for r, c in places:
        frame[r : r + 3, c : c + 3] = [[3, 5, 3], [5, 7, 5], [3, 5, 3]]
    contacts = find_contacts(frame * scale, 20, pitch=(0.002, 0.0031))
    assert [contact.peak_taxel for contact in contacts] == [(r + 1, c + 1) for r, c in places]


@pytest.mark.parametrize("scale", [1.0, 1 / 3, 0.1, 0.7, 1 / 150, 1e5 / 7])
def test_what_is_just_so_high_as_the_floor_or_half_a_peak_is_so_in_any_unit(scale: float) -> None:
    frame = np.zeros((9, 12))
    frame[3:6, 2:5] = 60.0
    frame[3:6, 5] = 3.0
    (contact,) = find_contacts(frame * scale)
    assert contact.n_taxels == 9
    # A second peak, and a saddle that is half of the lower one.
    frame[3:6, 7:10], frame[3:6, 5:7] = 62.0, 30.0
    (contact,) = find_contacts(frame * scale)
    assert contact.n_taxels == 24
