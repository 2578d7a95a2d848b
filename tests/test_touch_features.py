"""Laws and contracts of the transformer and of a contact's pose."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.utils.estimator_checks import parametrize_with_checks

from varishold.errors import InputError
from varishold.touch import SurfaceFeatures, contact_pose, find_contacts


def spot(rows: int, cols: int, x: float, y: float, *, long: float = 3.0, short: float = 2.0, turn: float = 0.0):
    """Return an oblong Gaussian; positions from the pad's centre."""
    v, u = np.mgrid[:rows, :cols].astype(float)
    u, v = u - (cols - 1) / 2 - x, v - (rows - 1) / 2 - y
    along, across = u * math.cos(turn) + v * math.sin(turn), v * math.cos(turn) - u * math.sin(turn)
    return 100 * np.exp(-0.5 * ((along / long) ** 2 + (across / short) ** 2))


def some_frames(n: int = 6, shape: tuple[int, int] = (12, 10), seed: int = 1):
    rng = np.random.default_rng(seed)
    draw = rng.uniform(-2, 2, (n, 2))
    return np.stack([spot(*shape, x, y, turn=t) for (x, y), t in zip(draw, rng.uniform(0, 3, n), strict=True)])


@parametrize_with_checks([SurfaceFeatures(), SurfaceFeatures(levels=3, relative_levels=2, floor=0.0)])
def test_keeps_the_estimator_contract(estimator, check):
    check(estimator)


def named(features: SurfaceFeatures, frames):
    return dict(zip(features.get_feature_names_out(), features.transform(frames).T, strict=True))


def test_frames_and_flat_samples_give_the_same():
    frames = some_frames()
    from_frames = SurfaceFeatures().fit_transform(frames)
    from_flat = SurfaceFeatures(shape=(12, 10)).fit_transform(frames.reshape(len(frames), -1))
    np.testing.assert_array_equal(from_frames, from_flat)
    fitted = SurfaceFeatures().fit(frames)
    np.testing.assert_array_equal(fitted.transform(frames.reshape(len(frames), -1)), from_frames)
    np.testing.assert_array_equal(fitted.transform(frames.tolist()), from_frames)


def test_flat_samples_without_a_shape_are_the_squarest_grid():
    rng = np.random.default_rng(0)
    for n, shape in ((12, (3, 4)), (16, (4, 4)), (13, (1, 13))):
        assert SurfaceFeatures().fit(rng.random((5, n))).shape_ == shape


def test_a_frame_is_measured_alike_in_any_company():
    frames = some_frames(8)
    fitted = SurfaceFeatures().fit(frames)
    together = fitted.transform(frames)
    np.testing.assert_allclose([fitted.transform(f[None])[0] for f in frames], together, rtol=1e-12, atol=1e-12)


def test_thresholds_are_learned_from_training_frames_alone():
    frames = some_frames(6)
    fitted = SurfaceFeatures().fit(frames)
    before = fitted.levels_.copy()
    fitted.transform(10 * frames)
    np.testing.assert_array_equal(fitted.levels_, before)
    assert np.all(np.diff(before) < 0)


def test_numbers_are_what_their_names_say():
    frames = np.stack([spot(24, 24, 2.0, -1.0, long=4.0, short=2.5, turn=math.pi / 2)] * 2)
    features = SurfaceFeatures(floor=0.0).fit(frames)
    (contact,) = find_contacts(frames[0], features.levels_, floor=0.0)
    got = named(features, frames)
    for i in range(10):
        assert got[f"area_above_level_{i + 1}"][0] == pytest.approx(contact.profile.area[i])
        assert got[f"perimeter_above_level_{i + 1}"][0] == pytest.approx(contact.profile.perimeter[i])
        assert got[f"variance_y_above_level_{i + 1}"][0] == pytest.approx(contact.profile.covariance[i, 1, 1])
    assert got["x"][0] == pytest.approx(2.0, abs=0.05)
    assert got["y_above_0.583_of_peak"][0] == pytest.approx(-1.0, abs=0.05)
    ratio = got["length_above_0.583_of_peak"][0] / got["breadth_above_0.583_of_peak"][0]
    assert ratio == pytest.approx(4 / 2.5, rel=0.03)
    share = got["area_above_level_1"] / got["area_above_level_2"]
    assert got["growth_from_level_1_to_2"] == pytest.approx(share)
    assert got["contacts"].tolist() == [1, 1]
    assert got["peak"][0] == frames[0].max()


def test_two_contacts_are_taken_together():
    apart = spot(16, 40, -12, 0) + spot(16, 40, 12, 0)
    one = spot(16, 40, -12, 0)
    features = SurfaceFeatures(floor=1.0).fit(np.stack([apart, one]))
    got = named(features, np.stack([apart, one]))
    assert got["contacts"].tolist() == [2, 1]
    both, single = got["area_above_level_4"]
    assert both == pytest.approx(2 * single, rel=1e-3)
    assert got["x_above_level_4"][0] == pytest.approx(0, abs=1e-6)
    assert got["length_above_level_4"][0] > 24


@settings(max_examples=20)
@given(scale=st.floats(0.01, 100), seed=st.integers(0, 100))
def test_scaling_all_frames_changes_no_length(scale, seed):
    frames = some_frames(4, seed=seed)
    plain = SurfaceFeatures().fit(frames)
    scaled = SurfaceFeatures().fit(frames * scale)
    lengths = [i for i, name in enumerate(plain.get_feature_names_out()) if name not in ("total", "peak")]
    np.testing.assert_allclose(
        scaled.transform(frames * scale)[:, lengths], plain.transform(frames)[:, lengths], rtol=1e-6, atol=1e-6
    )


def test_an_empty_frame_measures_nothing():
    frames = np.concatenate([some_frames(3), np.zeros((1, 12, 10))])
    assert not SurfaceFeatures().fit_transform(frames)[3].any()
    assert not SurfaceFeatures().fit_transform(np.zeros((2, 4, 4))).any()


def test_pads_stand_side_by_side_and_in_pairs():
    one, other = some_frames(5, seed=1), some_frames(5, seed=2)
    both = np.stack([one, other], axis=1)
    features = SurfaceFeatures(pairs=True).fit(both)
    got = named(features, both)
    a, b = got["pad_0_area_above_level_3"], got["pad_1_area_above_level_3"]
    np.testing.assert_allclose(got["mean_of_pads_0_and_1_area_above_level_3"], (a + b) / 2)
    np.testing.assert_allclose(got["difference_of_pads_0_and_1_area_above_level_3"], a - b)
    names = features.get_feature_names_out()
    assert len(set(names)) == len(names) == features.transform(both).shape[1]
    assert features.shape_ == (2, 12, 10)


def test_a_place_without_taxels_does_not_count():
    field = np.ones((12, 10), bool)
    field[:3, :3] = False
    frames = some_frames(4)
    filled = frames.copy()
    filled[:, ~field] = 1e6
    features = SurfaceFeatures(field=field)
    np.testing.assert_array_equal(features.fit_transform(frames), features.fit_transform(filled))


def test_clones_and_tables():
    features = SurfaceFeatures(levels=2, relative_levels=2, field=np.ones((12, 10), bool))
    assert clone(features).levels == 2
    table = pytest.importorskip("pandas") and clone(features).set_output(transform="pandas").fit_transform(
        some_frames()
    )
    assert next(iter(table.columns)) == "area_above_level_1"


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"levels": -1}, "levels must be a whole number, at least 0, got -1"),
        ({"relative_levels": 1.5}, "relative_levels must be a whole number, at least 0, got 1.5"),
        ({"levels": 0, "relative_levels": 0}, "levels and relative_levels are both 0: no section to measure"),
        ({"shape": (3,)}, r"shape must be \(rows, cols\) or \(pads, rows, cols\), got \(3,\)"),
        ({"shape": "12x10"}, r"shape must be \(rows, cols\) or \(pads, rows, cols\), got '12x10'"),
        ({"shape": 120}, r"shape must be \(rows, cols\) or \(pads, rows, cols\), got 120"),
        ({"shape": (12, 10.5)}, r"shape must be \(rows, cols\) or \(pads, rows, cols\), got \(12, 10.5\)"),
        ({"shape": (10, 12)}, r"frames must have shape \(10, 12\), as `shape` says, got \(12, 10\)"),
        ({"field": np.ones((2, 2), bool)}, r"field must have the shape of a frame, \(12, 10\), got \(2, 2\)"),
        ({"floor": -1.0}, "floor must be finite and not negative, got -1.0"),
    ],
)
def test_says_which_parameter_is_wrong(parameters, message):
    with pytest.raises(InputError, match=message):
        SurfaceFeatures(**parameters).fit(some_frames())


def test_says_which_shape_is_wrong():
    flat = some_frames().reshape(6, -1)
    with pytest.raises(InputError, match=r"shape \(3, 3\) needs 9 values a sample, got 120"):
        SurfaceFeatures(shape=(3, 3)).fit(flat)
    with pytest.raises(InputError, match=r"frames must have the shape that fit saw, \(12, 10\), got \(10, 12\)"):
        SurfaceFeatures().fit(some_frames()).transform(some_frames(shape=(10, 12)))


@settings(max_examples=40)
@given(
    x=st.floats(-3, 3),
    y=st.floats(-3, 3),
    turn=st.floats(-1.5, 1.5),
    levels=st.sampled_from([8, 32, (1.0, 3.0, 10.0, 20.0, 40.0, 60.0, 80.0)]),
)
def test_a_spot_is_found_where_it_lies(x, y, turn, levels):
    contact = find_contacts(spot(25, 25, x, y, turn=turn, long=3.5), levels, floor=1.0)[0]
    pose = contact_pose(contact)
    assert pose.position == pytest.approx((x, y), abs=0.05)
    off = (pose.orientation - turn + math.pi / 2) % math.pi - math.pi / 2
    assert abs(off) < math.radians(2)
    assert -math.pi / 2 <= pose.orientation < math.pi / 2
    assert pose.aspect == pytest.approx(3.5 / 2, rel=0.1)


def test_a_pose_is_in_the_unit_of_the_pitch():
    frame = spot(20, 20, 1.0, -2.0)
    taxels = contact_pose(find_contacts(frame)[0])
    metres = contact_pose(find_contacts(frame, pitch=0.002)[0])
    assert metres.position == pytest.approx([0.002 * p for p in taxels.position])
    assert metres.mean_area == pytest.approx(4e-6 * taxels.mean_area)
    np.testing.assert_allclose(metres.covariance, 4e-6 * taxels.covariance, atol=1e-12)


def test_a_skirt_hardly_moves_the_pose():
    x = np.mgrid[:30, :30][1] - 14.5
    skirt = 8 * np.clip(1 - np.abs(x - 5) / 6, 0, 1) * (spot(30, 30, 0, 0, long=8, short=4) > 40)
    contact = find_contacts(np.maximum(spot(30, 30, 0, 0, long=2, short=2), skirt), floor=1.0)[0]
    assert contact.profile.centroid[-1, 0] > 1
    assert abs(contact_pose(contact).position[0]) < 0.15


def test_no_section_no_pose():
    contact = find_contacts(spot(9, 9, 0, 0), [1e4], floor=1.0)[0]
    with pytest.raises(InputError, match=r"no section of the contact at taxel \(4, 4\) has an area"):
        contact_pose(contact)
