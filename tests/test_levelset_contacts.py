"""Contacts: what is one, what is two, where a profile ends, and every message."""

from __future__ import annotations

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.frame import frame_noise
from varishold.frame.floor import FLOOR_OF_PEAK, FLOOR_SIGMAS, MOST_OF_PEAK
from varishold.levelset import Contact, find_contacts, find_contacts_batch


def two_cones(saddle: float, low: float = 1.0, high: float = 2.0) -> np.ndarray:
    """A row of taxels with two peaks and a valley between them, on a pad of zeros."""
    frame = np.zeros((5, 11))
    frame[2, 1:10] = np.r_[
        np.linspace(0.2, low, 3), np.linspace(low, saddle, 3)[1:], np.linspace(saddle, high, 3)[1:], 0.5, 0.2
    ]
    return frame


def test_two_peaks_are_two_contacts_only_below_half_of_the_lower():
    assert len(find_contacts(two_cones(0.51), 8, floor=0.1)) == 1
    a, b = find_contacts(two_cones(0.49), 8, floor=0.1)
    assert {a.peak, b.peak} == {1.0, 2.0}
    for contact in (a, b):
        assert contact.floor == 0.49
        assert contact.profile.threshold[-1] > 0.49
        assert contact.values[contact.mask].min() > 0.49
    assert not np.any(a.frame.label[1:-1, 1:-1][(two_cones(0.49) <= 0.49)] >= 0), (
        "what lies below the saddle belongs to neither"
    )


def test_parts_on_their_own_are_contacts_however_low():
    frame = np.zeros((5, 9))
    frame[2, 1], frame[2, 7] = 10.0, 1.0
    assert [c.peak for c in find_contacts(frame, 4, floor=0.5)] == [10.0, 1.0]


def test_a_bump_on_a_shoulder_is_no_contact_and_a_third_peak_is_one():
    frame = np.zeros((3, 17))
    frame[1] = [0, 4, 2, 1, 3, 5, 1.2, 1.3, 0.9, 0.3, 1, 0.8, 0.6, 0.55, 0.56, 0.3, 0]
    contacts = find_contacts(frame, 4, floor=0.2)
    assert sorted(c.peak for c in contacts) == [1.0, 4.0, 5.0]
    assert {c.peak: c.floor for c in contacts} == {4.0: 1.0, 5.0: 1.0, 1.0: 0.3}


def test_absolute_thresholds_are_nan_below_a_saddle_and_empty_above_a_peak():
    low, high = sorted(find_contacts(two_cones(0.3), np.array([1.5, 0.2, 0.5, 0.3]), floor=0.1), key=lambda c: c.peak)
    assert low.profile.threshold.tolist() == [1.5, 0.5, 0.3, 0.2]
    assert low.profile.area[0] == 0
    assert low.profile.parts.tolist() == [0, 1, 1, 0]
    assert high.profile.parts.tolist() == [1, 1, 1, 0]
    for profile in (low.profile, high.profile):
        assert profile.measured.tolist() == [True, True, True, False]
        assert np.isnan(profile.area[3])
        assert np.isnan(profile.extent[3]).all()


def test_contacts_come_by_falling_area():
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:30, 0:40]
    frame = np.zeros((30, 40))
    for cy, cx, r in ((6, 6, 3), (6, 25, 5), (22, 12, 6)):
        frame = np.maximum(frame, np.maximum(1 - np.hypot(x - cx, y - cy) / r, 0))
    contacts = find_contacts(frame + rng.normal(0, 0.005, frame.shape), 8)
    areas = [c.profile.area[-1] for c in contacts]
    assert len(areas) == 3
    assert areas == sorted(areas, reverse=True)


def test_many_contacts_come_by_falling_area_then_by_falling_number_of_taxels():
    rng = np.random.default_rng(3)
    frame = np.zeros((80, 80))
    frame[::2, ::2] = 1 + rng.integers(0, 3, (40, 40))
    frame[10:13, 10:12] = 2.0
    contacts = find_contacts(frame, 2, floor=0.5)
    keys = [(-c.profile.area[-1], -c.n_taxels, c.index) for c in contacts]
    assert len(keys) > 1500
    assert keys == sorted(keys)


def test_the_default_floor_stands_clear_of_noise_and_skirt():
    rng = np.random.default_rng(1)
    y, x = np.mgrid[-16:16, -16:16]
    clean = np.maximum(1 - np.hypot(x, y) / 8, 0)
    (contact,) = find_contacts(clean, 4)
    assert contact.floor == pytest.approx(FLOOR_OF_PEAK)
    noisy = clean + rng.normal(0, 0.018, clean.shape)
    contact = find_contacts(noisy, 4)[0]
    assert contact.sigma == frame_noise(noisy)
    assert contact.floor == pytest.approx(FLOOR_SIGMAS * contact.sigma)
    rough = clean + rng.normal(0, 0.05, clean.shape)
    assert find_contacts(rough, 4)[0].floor == pytest.approx(MOST_OF_PEAK * rough.max())


def test_what_a_broken_sensor_adds_is_taken_back_where_the_caller_fixed_nothing():
    y, x = np.mgrid[-16:16, -16:16]
    clean = np.maximum(1 - (np.hypot(x, y) / 10) ** 2, 0)
    worn = clean + 0.2 + 0.1 * x / 32
    worn[15, 14] = worn[18, 17] = 0.0
    (contact,) = find_contacts(worn, 4)
    assert np.argwhere(contact.frame.dead).tolist() == [[15, 14], [18, 17]]
    assert contact.frame.rest == pytest.approx((0.2 - 0.05, 0.1 / 32, 0.0), abs=1e-3)
    (same,) = find_contacts(clean, 4)
    assert contact.profile.area == pytest.approx(same.profile.area, rel=0.05)
    for options in ({"floor": 0.3}, {"levels": [0.5, 0.6]}):
        assert not any(c.frame.dead.any() or any(c.frame.rest) for c in find_contacts(worn, **options))


def test_a_contact_says_where_it_is():
    frame = np.zeros((6, 8))
    frame[1:4, 0:3] = [[2, 3, 2], [2, 4, 2], [2, 2, 2]]
    (contact,) = find_contacts(frame, 4, pitch=(0.002, 0.001), floor=1.0)
    assert isinstance(contact, Contact)
    assert contact.peak == 4.0
    assert contact.peak_taxel == (2, 1)
    assert contact.peak_position == pytest.approx((-0.0025, -0.001))
    assert contact.window == (slice(1, 4), slice(0, 3))
    assert contact.origin == (1, 0)
    assert contact.shape == (6, 8)
    assert contact.n_taxels == 9
    assert contact.mask.all()
    assert contact.mask.shape == (3, 3)
    assert contact.values.tolist() == frame[1:4, 0:3].tolist()
    assert contact.field.shape == (6, 8)
    assert contact.borders == (True, False, False, False)
    assert contact.spacing == contact.pitch == (0.002, 0.001)
    assert contact.taxel_area == pytest.approx(2e-6)
    assert contact.sigma == frame_noise(frame)


def test_broken_taxels_are_filled_and_missing_ones_are_not():
    frame = np.full((7, 7), 3.0)
    frame[3, 3] = -99.0
    valid = frame > 0
    (filled,) = find_contacts(frame, 3, valid=valid, floor=1.0)
    assert filled.values[3, 3] == pytest.approx(3.0)
    assert filled.profile.area == pytest.approx(49)
    (missing,) = find_contacts(frame, 3, field=valid, floor=1.0)
    assert missing.values[3, 3] == 0
    assert not missing.mask[3, 3]
    assert missing.profile.area == pytest.approx(48)
    frame[3, 3] = np.nan
    (nan,) = find_contacts(frame, 3, floor=1.0)
    assert nan.profile.area == pytest.approx(48)
    (also_filled,) = find_contacts(frame, 3, valid=valid, floor=1.0)
    assert also_filled.profile.area == pytest.approx(49)


def test_outlines_belong_to_their_contact():
    for contact in find_contacts(two_cones(0.3), 6, floor=0.1):
        for i in range(6):
            lines = contact.outlines(i)
            assert len(lines) == contact.profile.parts[i] + contact.profile.holes[i]
            length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in lines)
            assert length == pytest.approx(contact.profile.perimeter[i])
    low = min(find_contacts(two_cones(0.3), [0.5, 0.2], floor=0.1), key=lambda c: c.peak)
    assert low.outlines(1) == []


@pytest.mark.parametrize("gaps", [[], [(5, 5)]])
def test_the_area_that_outlines_and_border_enclose_is_the_profiles(gaps):
    frame = np.zeros((6, 8))
    frame[1:4, 0:3] = [[2, 3, 2], [2, 4, 2], [2, 2.5, 2]]
    for row, col in gaps:
        frame[row, col] = np.nan
    (contact,) = find_contacts(frame, 6, floor=0.5)
    for i in range(6):
        lines = contact.outlines(i)
        area = 0.0
        for line in lines:
            # The pad's left border closes the open ones: x dy vanishes on it when x counts from there.
            x, y = line[:, 0] + 4.0, line[:, 1]
            area += np.sum(0.5 * (x[1:] + x[:-1]) * np.diff(y))
        assert area == pytest.approx(contact.profile.area[i], rel=1e-9)


def test_many_frames_give_what_each_gives():
    rng = np.random.default_rng(2)
    frames = rng.normal(0, 0.3, (20, 9, 11)) ** 2
    for one, many in zip(frames, find_contacts_batch(frames, 5, floor=0.1), strict=True):
        for a, b in zip(find_contacts(one, 5, floor=0.1), many, strict=True):
            assert np.array_equal(a.profile.measures, b.profile.measures, equal_nan=True)
            assert np.array_equal(a.profile.counts, b.profile.counts)


@pytest.mark.parametrize("frame", [np.zeros((4, 4)), np.full((4, 4), 7.0), -np.ones((4, 4)), np.full((3, 3), np.nan)])
def test_frames_without_form(frame):
    contacts = find_contacts(frame)
    assert len(contacts) == int(frame[0, 0] > 0)
    for contact in contacts:
        assert contact.profile.area == pytest.approx(16)


def test_input_is_not_changed_and_may_be_read_only_or_whole_numbers():
    frame = np.arange(12).reshape(3, 4)
    frame.flags.writeable = False
    (contact,) = find_contacts(frame, 3, floor=2)
    assert contact.peak == 11.0
    assert np.array_equal(frame, np.arange(12).reshape(3, 4))


def test_extreme_magnitudes():
    y, x = np.mgrid[-5:6, -5:6]
    cone = np.maximum(4.0 - np.hypot(x, y), 0.0)
    (plain,) = find_contacts(cone, 6, floor=1.0)
    for factor in (1e-140, 1e90):
        (scaled,) = find_contacts(factor * cone, 6, floor=factor)
        np.testing.assert_allclose(scaled.profile.area, plain.profile.area, rtol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frame": np.ones(3)}, "numbers of shape (rows, cols), got float64 of shape (3,)"),
        ({"frame": np.ones((0, 3))}, "got float64 of shape (0, 3)"),
        ({"frame": [["a", "b"]]}, "must be numbers"),
        ({"frame": [[1.0], [1.0, 2.0]]}, "rows of different lengths"),
        ({"frame": [[1.0, np.inf]]}, "must be finite, got inf at (row, col) = (0, 1)"),
        ({"levels": 0}, "levels must be 1 to 65536, got 0"),
        ({"levels": 10**12}, "levels must be 1 to 65536, got 1000000000000"),
        ({"levels": True}, "levels must be a whole number or thresholds"),
        ({"levels": []}, "levels must be a whole number or thresholds"),
        ({"levels": [1.0, np.nan]}, "levels must be finite"),
        (
            {"levels": [[1, 2], [3]]},
            "levels must be a whole number or thresholds of shape (n_levels,), at most 65536, got",
        ),
        ({"levels": np.ma.array([1.0, 2.0], mask=[0, 1])}, "at most 65536, got some that are masked"),
        ({"pitch": 0.0}, "pitch must be one spacing in metres"),
        ({"pitch": (1.0, 2.0, 3.0)}, "pitch must be one spacing in metres"),
        ({"pitch": "wide"}, "pitch must be one spacing in metres"),
        ({"valid": np.ones((2, 2), bool)}, "valid must have the shape of a frame, (3, 3), got (2, 2)"),
        ({"field": np.ones((2, 2), bool)}, "field must have the shape of a frame, (3, 3), got (2, 2)"),
        ({"valid": np.ones((3, 3))}, "valid must be True or False for each taxel, got float64"),
        ({"valid": np.zeros((3, 3), bool)}, "every taxel of the frame is broken"),
        ({"floor": -1.0}, "floor must be finite and not negative, got -1.0"),
        ({"floor": np.nan}, "floor must be finite and not negative, got nan"),
    ],
)
def test_messages(options, message):
    arguments = {"frame": np.ones((3, 3)), **options}
    with pytest.raises(InputError) as caught:
        find_contacts(arguments.pop("frame"), **arguments)
    assert message in str(caught.value)


def test_a_batch_names_the_frame():
    frames = np.ones((3, 2, 2))
    frames[1, 0, 1] = np.inf
    with pytest.raises(InputError, match=r"frame 1: .*\(row, col\) = \(0, 1\)"):
        find_contacts_batch(frames)


@pytest.mark.parametrize("radius", [5.0, 9.0, 14.0])
def test_a_paraboloid_lacks_a_third_of_pi_taxels(radius):
    y, x = np.mgrid[-20:21, -20:21] + np.array([0.3, -0.2])[:, None, None]
    v = 1 - (x**2 + y**2) / radius**2
    (contact,) = find_contacts(np.maximum(v + 1, 0), 20, floor=1.0)
    exact = np.pi * radius**2 * (1 - (contact.profile.threshold - 1))
    usable = exact > 12
    bias = (contact.profile.area - exact)[usable]
    assert bias.mean() == pytest.approx(-np.pi / 3, abs=0.1)


def test_a_cone_lacks_two_thirds_of_a_taxel_and_a_pyramid_almost_nothing():
    y, x = np.mgrid[-20:21, -20:21] + np.array([0.3, -0.2])[:, None, None]
    (cone,) = find_contacts(np.maximum(16 - np.hypot(x, y), 0), 40, floor=1.0)
    exact = np.pi * (16 - cone.profile.threshold) ** 2
    usable = exact > 12
    assert (cone.profile.area - exact)[usable].mean() == pytest.approx(-0.52, abs=0.2)
    (pyramid,) = find_contacts(np.maximum(16 - np.maximum(abs(x), abs(y)), 0), 40, floor=1.0)
    exact = 4 * (16 - pyramid.profile.threshold) ** 2
    assert (pyramid.profile.area - exact)[exact > 12].mean() == pytest.approx(-0.5, abs=0.6)


#: A cylinder that covers half of a pad of six by six: most residuals that tell noise come from its rim.
ON_FEW_TAXELS = np.array(
    [
        [0.00, 0.00, 0.04, 0.01, 0.00, 0.00],
        [0.00, 0.25, 0.92, 1.00, 0.62, 0.00],
        [0.06, 1.00, 0.97, 1.00, 1.04, 0.39],
        [0.17, 1.00, 1.03, 1.01, 0.99, 0.59],
        [0.00, 0.85, 1.00, 0.99, 1.01, 0.26],
        [0.00, 0.09, 0.58, 0.67, 0.31, 0.00],
    ]
)


def test_a_broad_contact_on_few_taxels_is_not_taken_for_noise() -> None:
    (contact,) = find_contacts(ON_FEW_TAXELS)
    assert contact.peak == 1.04
    batch = find_contacts_batch(ON_FEW_TAXELS[None])
    assert batch.n_found.tolist() == [1]


@pytest.mark.parametrize(("n", "most"), [(6, 0.12), (16, 0.04)])
def test_noise_makes_no_broad_contact(n: int, most: float) -> None:
    rng = np.random.default_rng(n)
    assert np.mean([len(find_contacts(rng.normal(0, 1, (n, n)))) > 0 for _ in range(500)]) < most


@pytest.mark.parametrize("n_counts", [8, 15, 30])
@pytest.mark.parametrize("whole", [True, False])
def test_rounding_makes_no_contacts(n_counts: int, whole: bool) -> None:
    """Noise and rounding lift single taxels by one count, which of few counts is more than the floor."""
    y, x = np.mgrid[-8:8, -8:8]
    rng = np.random.default_rng(n_counts)
    for _ in range(20):
        frame = np.maximum(1 - np.hypot(x - rng.uniform(-2, 2), y) / 6, 0) + rng.normal(0, 0.03, x.shape)
        counts = np.round(n_counts * frame)
        assert len(find_contacts(counts.astype(int) if whole else counts / n_counts)) == 1


def test_two_contacts_of_few_counts_stay_two() -> None:
    counts = np.zeros((12, 24), int)
    counts[3:9, 3:9], counts[4:8, 15:20] = 8, 3
    assert len(find_contacts(counts)) == 2
