"""Every measure of a pad against a slow reference, and the laws of what is told of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reference_pad import measures_of, pressed_piece, window_of

from varishold.skin import Skin, press, reconstruct, sense
from varishold.touch.pads import SURFACES, feel_surface
from varishold.touch.pads.measures import MEASURES, measure_pad

SKIN = Skin("layer", thickness_m=0.004, poisson=0.45, sensing_depth_m=0.001, youngs_modulus_pa=1.5e5)


def drawn(rng, rows, cols, form):
    """A load of some form anywhere on a pad, with a little noise."""
    y, x = np.ogrid[:rows, :cols]
    cx, cy = rng.uniform(0, cols), rng.uniform(0, rows)
    a, b = rng.uniform(1.5, 7, 2)
    turn = rng.uniform(0, np.pi)
    u = (x - cx) * np.cos(turn) + (y - cy) * np.sin(turn)
    v = (y - cy) * np.cos(turn) - (x - cx) * np.sin(turn)
    load = {
        "bump": np.exp(-((u / a) ** 2) - (v / b) ** 2),
        "cap": np.maximum(1 - (u / a) ** 2 - (v / b) ** 2, 0),
        "gable": np.maximum(1 - abs(u) / a, 0) * (abs(v) < b),
        "face": ((abs(u) < a) & (abs(v) < b)) * (1 + 0.3 * u / a),
        "two": np.exp(-((u / a) ** 2) - (v / b) ** 2) + 0.8 * np.exp(-(((u - 9) / 2) ** 2) - (v / 2) ** 2),
        "slope": np.maximum(1 + 0.1 * u + 0.05 * v, 0) + 0 * x * y,
    }[form]
    return 900 * load + rng.normal(0, 3, (rows, cols)) + np.where((y == int(cy) % rows) & (x == int(cx) % cols), 50, 0)


FORMS = ("bump", "cap", "gable", "face", "two", "slope")


def same(got, expected, cells):
    for name, value in zip(MEASURES, got, strict=True):
        # Of a few cells several hinges fit exactly, and none is the best.
        if cells >= 12 or "kink" not in name:
            assert value == pytest.approx(expected[name], rel=1e-6, abs=1e-7), name


@given(
    st.integers(0, 2**31),
    st.sampled_from([(3, 3), (3, 20), (8, 20), (7, 13), (16, 20), (14, 40), (26, 18), (40, 40), (24, 33)]),
    st.sampled_from(FORMS),
    st.sampled_from([(0.002, 0.002), (0.003, 0.001), (0.001, 0.0025)]),
    st.sampled_from([1.0, 3.0, 40.0]),
)
@settings(max_examples=120)
def test_every_measure_without_a_skin_is_that_of_the_reference(seed, shape, form, pitch, sigma):
    frame = drawn(np.random.default_rng(seed), *shape, form)
    foot = measure_pad(frame, None, pitch, sigma)
    top, bottom, left, right = window_of(frame, sigma)
    part = frame[top:bottom, left:right]
    load = np.maximum(part, 0.0)
    mask = pressed_piece(load)
    corner = (top - shape[0] / 2) * pitch[0], (left - shape[1] / 2) * pitch[1]
    # In want of a scale, a contact as deep as a taxel is wide.
    level = load / frame.max() * pitch[0]
    expected = measures_of(frame, level, load, mask, corner, pitch, pitch=pitch, sigma=sigma, seen=False)
    same(foot.measures, expected, mask.sum())
    y = corner[0] + (np.arange(load.shape[0]) + 0.5) * pitch[0]
    x = corner[1] + (np.arange(load.shape[1]) + 0.5) * pitch[1]
    assert foot.centre_m == pytest.approx(((load * x).sum() / load.sum(), (load * y[:, None]).sum() / load.sum()))
    assert foot.area_share == expected["area_share"]
    assert foot.borders == tuple(bool(edge.any()) for edge in (mask[:, 0], mask[:, -1], mask[0], mask[-1]))
    assert np.isnan(foot.curvature_1_m).all()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("shape", "pitch"), [((8, 14), (0.002, 0.002)), ((9, 8), (0.0015, 0.0025)), ((21, 23), (0.003, 0.002))]
)
def test_every_measure_through_a_skin_is_that_of_the_reference(form, shape, pitch):
    rng = np.random.default_rng([*map(ord, form), *shape])
    frame = drawn(rng, *shape, form)
    foot = measure_pad(frame, SKIN, pitch, 4.0)
    top, bottom, left, right = window_of(frame, 4.0)
    relief = reconstruct(frame[top:bottom, left:right], SKIN, pitch=pitch, noise=0.015 * frame.max())
    mask = relief.mask if relief.mask.any() else relief.pressure >= relief.pressure.max()
    corner = (top - shape[0] / 2) * pitch[0], (left - shape[1] / 2) * pitch[1]
    told = measures_of(
        frame, relief.displacement, relief.pressure, mask, corner, relief.pitch_m, pitch=pitch, sigma=4.0, seen=True
    )
    same(foot.measures, told, mask.sum())
    bends = [math.sinh(told[f"curvature_along_{way}"]) / 0.02 for way in ("cols", "rows")]
    assert foot.curvature_1_m == pytest.approx(bends)


@given(st.integers(0, 2**31), st.sampled_from(FORMS))
@settings(max_examples=25)
def test_a_pad_turned_a_quarter_has_its_measures_with_rows_for_columns(seed, form):
    frame = drawn(np.random.default_rng(seed), 12, 15, form)
    here = dict(zip(MEASURES, measure_pad(frame, None, (0.002, 0.002), 3.0).measures, strict=True))
    there = dict(zip(MEASURES, measure_pad(np.rot90(frame), None, (0.002, 0.002), 3.0).measures, strict=True))
    for name, value in here.items():
        turned = name.replace("cols", "ROWS").replace("rows", "cols").replace("ROWS", "rows")
        assert there[turned] == pytest.approx(value, rel=1e-5, abs=1e-5), name


def test_a_cylinder_bends_across_itself_only():
    """A height map cut off where it is a quarter of its height: 1 / r across, nothing along."""
    x = (np.arange(21) - 10) * 0.001
    frame = np.broadcast_to(np.maximum(0.006 - x**2 / (2 * 0.008), 0), (15, 21)) / 0.006
    foot = dict(zip(MEASURES, measure_pad(frame, None, (0.001, 0.001), 0.0).measures, strict=True))
    # The frame's peak counts as one taxel deep.
    assert math.sinh(foot["curvature_along_cols"]) / 0.02 == pytest.approx(1 / 0.008 / 6, rel=1e-3)
    assert foot["curvature_along_rows"] == pytest.approx(0, abs=1e-5)
    assert foot["curvature_greatest"] == pytest.approx(foot["curvature_along_cols"], rel=1e-3)
    assert foot["kink_gain"] < 0
    gable = np.broadcast_to(np.maximum(1 - abs(x) / 0.008, 0), (15, 21))
    foot = dict(zip(MEASURES, measure_pad(gable, None, (0.001, 0.001), 0.0).measures, strict=True))
    assert foot["kink_gain"] > 1
    assert foot["kink_offset"] == 0
    # It falls by a taxel on 8: on both sides of the crest.
    assert math.sinh(foot["kink_angle"]) / 3 == pytest.approx(2 / 8, rel=0.02)
    assert foot["tail_along_cols"] < math.log(2.5)
    even = dict(zip(MEASURES, measure_pad(np.ones((5, 40)), None, (0.001, 0.001), 0.0).measures, strict=True))
    assert even["tail_along_cols"] == pytest.approx(math.log(1.8 + 0.1), rel=0.01)
    assert even["profile_curvature_cols"] == pytest.approx(0, abs=1e-9)
    assert even["rim_pressure"] == even["area_share"] == 1
    assert even["cut_cols_least"] == even["cut_rows_least"] == 1


@pytest.fixture(scope="module")
def bar():
    """A bar of 40 mm radius across a pad, off its middle by 3 mm."""
    x = (np.arange(40) + 0.5 - 20) * 1e-3 - 3e-3
    height = np.broadcast_to(-(x**2) / (2 * 0.04), (16, 40))
    return sense(press(height, SKIN, force=3.0, shape=(8, 20), pitch_m=2e-3, per_taxel=2, tolerance=1e-3))


def test_what_is_told_of_a_bar(bar):
    felt = feel_surface(bar, SKIN, pitch_m=2e-3)
    assert felt.force_n == pytest.approx(bar.sum() * 4e-6)
    assert felt.centre_m == pytest.approx((3e-3, 0), abs=4e-4)
    assert felt.borders == (False, False, True, True)
    low, high = felt.radius_interval_m
    # The interval is even in the logarithm.
    assert low * high == pytest.approx(felt.radius_m**2)
    assert low < felt.radius_m < high
    assert felt.curvature_1_m[0] == pytest.approx(25, abs=3 * felt.curvature_sigma_1_m[0])
    assert abs(felt.curvature_1_m[1]) < 3 * felt.curvature_sigma_1_m[1]
    ranked = sorted(SURFACES, key=lambda name: -felt.by_name[name])
    odds = math.exp(min(felt.by_name[ranked[0]] - felt.by_name[ranked[1]], 20))
    reasons = felt.reasons
    assert reasons[0] == f"{ranked[0]} is {odds:.3g} times as likely as {ranked[1]}"
    (bx, by), (sx, sy) = felt.curvature_1_m, felt.curvature_sigma_1_m
    assert reasons[1] == (
        f"it bends {bx:.0f} +- {sx:.0f} 1/m along the columns, {by:.0f} +- {sy:.0f} 1/m along the rows"
    )
    assert reasons[2] == f"its radius is about {1e3 * felt.radius_m:.0f} mm"
    gain = felt.measures[MEASURES.index("kink_gain")]
    better, worse = ("kink", "bend") if gain > 0 else ("bend", "kink")
    assert reasons[3] == f"a {better} fits its form better than a {worse}"
    assert reasons[4] == "the pad's top and bottom borders cut it"


def test_one_border_is_told_in_the_singular_and_none_not_at_all():
    frame = np.zeros((9, 9))
    frame[3:6, :3] = 900.0
    assert feel_surface(frame, None, pitch_m=2e-3).reasons[-1] == "the pad's left border cuts it"
    frame = np.roll(frame, 3, axis=1)
    assert "border" not in feel_surface(frame, None, pitch_m=2e-3).reasons[-1]
    assert not any(feel_surface(frame, None, pitch_m=2e-3).borders)


def test_probabilities_are_those_of_the_likelihoods(bar):
    felt = feel_surface(bar, SKIN, pitch_m=2e-3)
    weights = [0.1, 0.2, 0.3, 0.4]
    plain = [w * math.exp(felt.by_name[name]) for w, name in zip(weights, SURFACES, strict=True)]
    np.testing.assert_allclose(felt.posterior(weights), np.array(plain) / sum(plain))
    assert felt.name == max(SURFACES, key=lambda name: felt.by_name[name])


@pytest.mark.parametrize("pitch", [1e-4, 0.05, (1e-4, 0.05)])
def test_a_pitch_between_a_tenth_of_a_millimetre_and_five_centimetres_is_taken(bar, pitch):
    assert feel_surface(bar, None, pitch_m=pitch) is not None


def test_a_radius_is_told_of_curved_surfaces_only(bar):
    x, y = (np.arange(40) + 0.5 - 20) * 1e-3, ((np.arange(16) + 0.5 - 8) * 1e-3)[:, None]
    forms = {"flat": 0 * x + 0 * y, "edge": -0.9 * np.abs(x) + 0 * y, "point": -0.9 * np.maximum(abs(x), abs(y))}
    for height in forms.values():
        for skin in (SKIN, None):
            frame = sense(press(height, SKIN, force=4.0, shape=(8, 20), pitch_m=2e-3, per_taxel=2, tolerance=1e-3))
            felt = feel_surface(frame, skin, pitch_m=2e-3)
            assert any("radius" in reason for reason in felt.reasons) == (
                felt.name == "curved" and felt.radius_m is not None
            )
            assert (felt.radius_m is None) == (felt.posterior()[1] < 0.05)
            assert (felt.radius_interval_m is None) == (felt.radius_m is None)
    # Odds are told up to e^20.
    far = feel_surface(bar, SKIN, pitch_m=2e-3)
    assert float(far.reasons[0].split(" is ")[1].split()[0]) <= math.exp(20)


def test_where_there_is_no_taxel_nothing_presses(bar):
    field = np.ones((8, 20), bool)
    field[:3, :4] = False
    held = np.where(field, bar, 0.0)
    for outside in (np.nan, 0.0, 7e4):
        felt = feel_surface(np.where(field, bar, outside), SKIN, pitch_m=2e-3, field=field)
        assert felt.force_n == pytest.approx(held.sum() * 4e-6)
        np.testing.assert_array_equal(felt.measures, feel_surface(held, SKIN, pitch_m=2e-3).measures)
