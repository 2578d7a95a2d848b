"""What grips, pads and recordings say as numbers: sections of breadth 1, parts that meet, bounds, broken pads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.test_perceive_edges import fitted
from tests.test_perceive_grip import laid_against

from varishold.errors import InputError
from varishold.perceive import (
    GRIP_SECTIONS,
    GripContacts,
    evidence_of_recording,
    fit_ball_size,
    fit_section,
    form_values,
    grip_values,
    pad_values,
)
from varishold.perceive.evidence import grip_reasons
from varishold.perceive.grip import _polygon, _rectangle
from varishold.perceive.section_fit import fit_ball, fit_turns, meeting
from varishold.recording import Pad, Recording
from varishold.touch import PadSurface

# Sections


def anticlockwise(corners: np.ndarray) -> bool:
    x, y = corners.T
    return bool((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() > 0)


def turned(corners: np.ndarray, turn_rad: float) -> np.ndarray:
    """The corners after a turn, in an order of their own."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    new = np.round(corners @ np.array([[c, s], [-s, c]]), 9) + 0.0
    return new[np.lexsort(new.T)]


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7, 8])
def test_a_polygon_is_regular_and_1_broad_from_a_side_across_minus_x(n: int) -> None:
    corners = _polygon(n)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, sides[0])
    np.testing.assert_allclose(np.linalg.norm(corners, axis=1), np.linalg.norm(corners[0]))
    np.testing.assert_allclose(corners.mean(axis=0), 0.0, atol=1e-12)
    assert corners.shape == (n, 2)
    assert anticlockwise(corners)
    x = corners[:, 0]
    assert np.ptp(x) == pytest.approx(1.0)
    # The side across -x is its least x; opposite lies a side, or one corner.
    assert (np.isclose(x, x.min()).sum(), np.isclose(x, x.max()).sum()) == (2, 1 + (n % 2 == 0))


@pytest.mark.parametrize("long", [1.0, 1.4, 3.0])
def test_a_rectangle_is_1_broad_and_so_many_times_as_long(long: float) -> None:
    corners = _rectangle(long)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [long, 1.0])
    np.testing.assert_allclose(corners.mean(axis=0), 0.0, atol=1e-12)
    assert anticlockwise(corners)
    assert len(np.unique(corners, axis=0)) == 4


def test_every_section_looks_the_same_after_its_period_and_no_sooner() -> None:
    assert list(GRIP_SECTIONS) == ["circle", "square", "rectangle", "hexagon", "triangle"]
    circle = GRIP_SECTIONS["circle"]
    assert (circle.corners.tolist(), circle.radius, circle.period_rad) == ([[0.0, 0.0]], 0.5, 0.0)
    for name, n in (("square", 4), ("rectangle", 2), ("hexagon", 6), ("triangle", 3)):
        section = GRIP_SECTIONS[name]
        assert (section.radius, section.period_rad) == (0.0, pytest.approx(2 * np.pi / n))
        here = turned(section.corners, 0.0)
        np.testing.assert_allclose(turned(section.corners, section.period_rad), here, atol=1e-8)
        for part in (1 / 3, 1 / 2, 2 / 3):
            assert not np.allclose(turned(section.corners, part * section.period_rad), here)
    np.testing.assert_allclose(np.ptp(GRIP_SECTIONS["rectangle"].corners, axis=0), [1.4, 1.0])


# Parts of a hand


def test_parts_of_two_digits_meet_where_their_heights_and_radii_do() -> None:
    """Two lines side by side, at two heights; what belongs to one digit never meets itself."""
    start = np.array([[0.0, 0.0, 0.0], [0.0, 0.01, 0.03], [0.5, 0.0, 0.0]])
    end = start + np.array([0.02, 0.0, 0.0])
    for parts, heights, meets in (
        (("a.tip", "b.tip", "c.tip"), None, False),
        (("a.tip", "b.tip", "c.tip"), [0.02, 0.02, 0.0], True),
        (("a.tip", "a.mid", "c.tip"), [0.02, 0.02, 0.0], False),
    ):
        hand = GripContacts(parts, start, end, np.full(3, 0.008), np.ones(3, bool), heights)
        assert hand.on_object().tolist() == [not meets, not meets, True]
        # Which end of a part is told first does not matter.
        other = replace(hand, start_m=hand.end_m, end_m=hand.start_m)
        assert other.on_object().tolist() == hand.on_object().tolist()


def test_parts_are_kept_as_numbers_of_their_own() -> None:
    start = [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0]]
    hand = GripContacts(("a", "b"), start, start, [0.01, 0.02], [1, 0])  # type: ignore[arg-type]
    start[0][0] = 9.0
    assert hand.start_m.tolist() == [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0]]
    assert (hand.touched.dtype, hand.touched.tolist()) == (np.bool_, [True, False])
    assert hand.half_height_m is not None
    assert hand.half_height_m.tolist() == hand.radius_m.tolist() == [0.01, 0.02]


@pytest.mark.parametrize("n", [1, 2, 4, 5])
def test_the_part_that_is_wrong_is_told_however_many_there_are(n: int) -> None:
    parts = tuple("abcde"[:n])
    good = {"start_m": np.zeros((n, 3)), "end_m": np.zeros((n, 3)), "radius_m": np.zeros(n), "touched": np.ones(n)}
    assert GripContacts(parts, **good).radius_m.tolist() == [0.0] * n
    for k in range(n):
        for name, wrong in (("start_m", np.nan), ("end_m", -2.1), ("radius_m", -1e-9), ("radius_m", 2.1)):
            values = good[name].copy()
            values[(k, 1) if values.ndim == 2 else k] = wrong
            with pytest.raises(
                InputError, match=f"^{name} of grip contact '{parts[k]}' is|{name} .* '{parts[k]}' must"
            ):
                GripContacts(parts, **(good | {name: values}))


def test_which_end_of_a_part_is_told_first_changes_no_fit() -> None:
    hand = laid_against("square", 0.07, np.random.default_rng(3), noise_m=1e-3)
    other = GripContacts(hand.parts, hand.end_m, hand.start_m, hand.radius_m, hand.touched)
    here, there = grip_values(hand), grip_values(other)
    assert here.keys() == there.keys()
    np.testing.assert_allclose(list(there.values()), list(here.values()), rtol=1e-4, atol=1e-4)


def test_fits_have_the_shapes_that_they_state() -> None:
    hand = laid_against("circle", 0.07, np.random.default_rng(4), parts=6)
    touch = np.full(6, 2)
    capsules = hand.start_m, hand.end_m, hand.radius_m, touch
    ball, cost = fit_ball(*capsules, 0.0005)
    assert (ball.shape, type(cost)) == ((4,), float)
    turns = np.array([0.0, 0.4, 0.8])
    shape = GRIP_SECTIONS["square"]
    found, off, costs, variance = fit_turns(*capsules, shape.corners, shape.radius, turns, False, 0.0005)
    assert (found.shape, off.shape, costs.shape, variance.shape) == ((3, 5), (3, 6), (3,), (3,))
    heights = np.full(6, 0.01)
    assert meeting(hand.start_m, hand.end_m, hand.radius_m, heights, np.arange(6)).shape == (6,)
    none = np.zeros((0, 3))
    assert meeting(none, none, np.zeros(0), np.zeros(0), np.zeros(0, np.int64)).shape == (0,)


@pytest.mark.parametrize("parts", [3, 4, 5, 8])
def test_a_poor_fit_makes_its_size_as_much_less_sure(parts: int) -> None:
    """By what is off, over the parts beyond the three that a circle is fitted by; one at least."""
    hand = laid_against("square", 0.08, np.random.default_rng(5), parts=parts, noise_m=6e-3)
    fit = fit_section(hand, "circle")
    _, _, (cost,), (variance,) = fitted(hand, "circle", grows=False)
    poor = 2 * cost / max(1, parts - 3)
    assert poor > 1 or parts == 3
    assert fit is not None
    assert fit.sigma_m == pytest.approx(np.sqrt(max(1.0, poor) * variance))


# What a grip says


def with_fit(hand: GripContacts, section: str, *, grows: bool, size_m: float) -> GripContacts:
    """The same grip, as if a section of another size lay best against it."""
    other = replace(hand)
    fit = fit_section(other, section, grows=grows)
    assert fit is not None
    other._fits[section, grows] = replace(fit, size_m=size_m)
    return other


def test_sizes_are_compared_within_a_factor_of_two() -> None:
    """The logarithm of a size less that of the circle's is cut at .7 to either side."""
    hand = laid_against("circle", 0.07, np.random.default_rng(5))
    plain = grip_values(hand)
    ball = fit_ball_size(hand)
    assert ball is not None
    for size_m, cut in ((9.0, -0.7), (0.001, 0.7)):
        values = grip_values(with_fit(hand, "circle", grows=False, size_m=size_m))
        assert values["size.circle"] == pytest.approx(np.log(size_m))
        ratios = [name for name in values if name.endswith(".ratio")]
        assert len(ratios) == len(GRIP_SECTIONS) * 2
        assert [values[name] for name in ratios] == [cut] * len(ratios)
    for name in GRIP_SECTIONS:
        if name != "circle":
            ratio = plain[f"size.{name}"] - plain["size.circle"]
            assert plain[f"fit.{name}.ratio"] == pytest.approx(np.clip(ratio, -0.7, 0.7))
    assert plain["fit.ball.ratio"] == pytest.approx(np.clip(np.log(ball[0]) - plain["size.circle"], -0.7, 0.7))


@pytest.mark.parametrize("section", ["circle", "hexagon"])
def test_a_section_that_grows_from_nothing_is_five_millimetres_at_the_palm(section: str) -> None:
    hand = laid_against("circle", 0.07, np.random.default_rng(6))
    for size_m, told_m in ((-0.02, 0.005), (0.001, 0.005), (0.006, 0.006)):
        values = grip_values(with_fit(hand, section, grows=True, size_m=size_m))
        assert values[f"size.{section}.growing"] == pytest.approx(np.log(told_m))


def test_a_grip_is_told_in_words_by_the_parts_that_touch() -> None:
    hand = laid_against("circle", 0.07, np.random.default_rng(7))
    some = replace(hand, touched=np.arange(8) < 6)
    (said,) = grip_reasons(some)
    for name, what in (("circle", "circle"), ("square", "square")):
        fit = fit_section(some, name)
        assert fit is not None
        off_mm = 1e3 * np.sqrt(np.mean(fit.off_m[:6] ** 2))
        size_mm = f"{1e3 * fit.size_m:.0f} ± {1e3 * fit.sigma_m:.1f} mm"
        assert f"a {what} of {size_mm} leaves {off_mm:.1f} mm" in said
    assert grip_reasons(replace(hand, touched=np.arange(8) < 2)) == ()
    assert grip_reasons(None) == ()


# What a pad says


def surface(*log_likelihood: float) -> PadSurface:
    return PadSurface(
        log_likelihood=np.array(log_likelihood),
        radius_m=None,
        radius_interval_m=None,
        centre_m=(0.0, 0.01),
        area_share=0.5,
        force_n=1.0,
        curvature_1_m=(20.0, -10.0),
        curvature_sigma_1_m=(1.0, 1.0),
        measures=np.zeros(1),
        borders=(False, False, False, False),
        reasons=(),
    )


@pytest.mark.parametrize("constant", [-40.0, 0.0, 7.0])
def test_what_all_surfaces_have_in_common_says_nothing(constant: float) -> None:
    """A likelihood is known up to a constant."""
    log = np.array([-2.0, 1.5, -1.0, -4.0])
    values = pad_values("thumb", surface(*(log + constant)))
    numbers = [values[f"pad.thumb.{name}"] for name in ("curved", "edge", "point")]
    assert numbers == pytest.approx([3.5, 1.0, -2.0])
    form = form_values(None, {"thumb": surface(*(log + constant)), "palm": None})
    round_ = 1.5 - np.log((np.exp(-2.0) + np.exp(-1.0)) / 2)
    assert form == pytest.approx({"form.pads_round": np.arcsinh(round_), "form.least_round": round_})


def test_a_curve_is_told_in_parts_of_the_gripped_size() -> None:
    flat = surface(0.0, 0.0, 0.0, 0.0)
    for size_m, radius_m in ((0.1, 0.05), (0.01, 0.015), (0.5, 0.075), (None, 0.035), (0.03, 0.015), (0.15, 0.075)):
        values = pad_values("thumb", flat, size_m=size_m)
        assert values["pad.thumb.curve"] == pytest.approx(np.arcsinh(4 * 20.0 * radius_m))
        assert values["pad.thumb.curve_up"] == pytest.approx(np.arcsinh(-4 * 10.0 * radius_m))
        assert (values["pad.thumb.x"], values["pad.thumb.y"]) == (0.0, pytest.approx(np.arcsinh(1.0)))
    far = pad_values("thumb", surface(0.0, 99.0, -99.0, 8.5))
    assert [far[f"pad.thumb.{name}"] for name in ("curved", "edge", "point")] == [8.0, -8.0, 8.0]
    forms = form_values(None, {"a": surface(0.0, 99.0, 0.0, 0.0), "b": surface(99.0, 0.0, 0.0, 0.0)})
    assert forms == pytest.approx({"form.pads_round": 0.0, "form.least_round": -5.0})


def test_a_pad_that_reads_some_values_for_ever_is_broken_and_one_that_reads_nothing_is_not() -> None:
    frames = np.zeros((8, 5, 5))
    assert not evidence_of_recording(Recording({"a": Pad(frames, pitch_m=3.4e-3)}, unit="Pa")).remarks
    frames[:, :2] = 9.0
    told = evidence_of_recording(Recording({"a": Pad(frames, pitch_m=3.4e-3)}, unit="Pa"))
    assert told.remarks == ("grasp: pad a is left out: none of its taxels works: their values never change",)
    assert not told.values


def test_a_unit_that_is_no_pressure_is_taken_as_it_is() -> None:
    y, x = np.mgrid[:9, :6]
    frame = 5e3 * np.exp(-((y - 4) ** 2 + (x - 2.5) ** 2) / 5)[None]
    counts, pascals = (
        evidence_of_recording(Recording({"a": Pad(frame, pitch_m=3.4e-3)}, unit=unit)) for unit in ("count", "Pa")
    )
    assert counts.values == pascals.values
    assert counts.reasons == pascals.reasons
