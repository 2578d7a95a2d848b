"""Laws of what a touch is made into: sections as polygons, numbers of a grip and of a pad, words."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_perceive_grip import laid_against, moved

from varishold.errors import InputError
from varishold.perceive import (
    GRIP_SECTIONS,
    Evidence,
    GripContacts,
    Library,
    fit_ball_size,
    fit_section,
    fuse,
    grip_size,
    grip_values,
)
from varishold.perceive.evidence import form_values, grip_reasons, pad_values, switch_values
from varishold.perceive.metric import fit_metric
from varishold.perceive.size_model import fit_size_model
from varishold.touch.pads.surface import PadSurface

few = settings(max_examples=15)
seeds = st.integers(0, 2**32 - 1)

# Sections


@pytest.mark.parametrize("name", GRIP_SECTIONS)
def test_a_section_of_size_one_has_breadth_one_and_looks_the_same_after_its_period(name: str) -> None:
    section = GRIP_SECTIONS[name]
    angle = np.linspace(0, 2 * np.pi, 721)
    out = np.column_stack([np.cos(angle), np.sin(angle)])

    def support(turn: float) -> np.ndarray:
        c, s = np.cos(turn), np.sin(turn)
        return (section.corners @ np.array([[c, s], [-s, c]]) @ out.T).max(axis=0) + section.radius

    reach = support(0.0)
    # From a side across -x to the side or corner opposite.
    breadth = support(0.0)[180] + support(0.0)[540] if name == "rectangle" else reach[0] + reach[360]
    assert breadth == pytest.approx(1.0)
    np.testing.assert_allclose(support(section.period_rad), reach, atol=1e-9)
    if section.period_rad:
        assert np.abs(support(section.period_rad / 2) - reach).max() > 0.01
    sides = np.roll(section.corners, -1, axis=0) - section.corners
    if len(sides) > 1:
        lengths = np.linalg.norm(sides, axis=1)
        assert np.ptp(lengths) < 1e-9 or name == "rectangle"
        # Anticlockwise, and convex.
        turns = sides[:, 0] * np.roll(sides, -1, axis=0)[:, 1] - sides[:, 1] * np.roll(sides, -1, axis=0)[:, 0]
        assert (turns > 0).all()
        left = section.corners[np.isclose(section.corners[:, 0], section.corners[:, 0].min())]
        assert len(left) == 2
        assert left[:, 1].sum() == pytest.approx(0, abs=1e-12)
    # Its middle is that of the circle which touches all its sides, or of its corners.
    np.testing.assert_allclose(section.corners.mean(axis=0), 0, atol=1e-12)


# Numbers of a grip


@few
@given(seeds, st.sampled_from(["circle", "square"]))
def test_round_grips_are_round(seed: int, section: str) -> None:
    contacts = laid_against(section, 0.08, np.random.default_rng(seed), parts=10)
    (told,) = form_values(contacts).items()
    size = grip_size(contacts)
    assert size is not None
    assert told[0] == "form.grip_round"
    assert np.sinh(told[1]) == pytest.approx(size.pillar.cost - size.cylinder.cost, rel=1e-6)
    assert (told[1] > 0) == (section == "circle")


@few
@given(seeds, st.floats(-3, 3))
def test_numbers_of_a_grip_are_those_of_its_fits_however_the_hand_is_turned(seed: int, turn: float) -> None:
    contacts = laid_against("hexagon", 0.07, np.random.default_rng(seed), parts=9)
    values = grip_values(contacts)
    assert values["fit.parts"] == 9
    circle = np.log(fit_section(contacts, "circle").size_m)  # type: ignore[union-attr]
    for name in GRIP_SECTIONS:
        fit, grown = fit_section(contacts, name), fit_section(contacts, name, grows=True)
        assert fit is not None
        assert grown is not None
        assert values[f"fit.{name}.off"] == pytest.approx(np.log1p(fit.cost))
        assert values[f"fit.{name}.growing.off"] == pytest.approx(np.log1p(grown.cost))
        assert values[f"fit.{name}.growth"] == pytest.approx(np.clip(grown.growth, -1.5, 1.5))
        sizes = [key for key in values if key.endswith((f"{name}", f"{name}.growing")) and "fit" not in key]
        assert [values[key] for key in sizes] == pytest.approx([np.log(fit.size_m), np.log(max(grown.size_m, 0.005))])
        if name == "circle":
            assert "fit.circle.ratio" not in values
        else:
            assert values[f"fit.{name}.ratio"] == pytest.approx(np.clip(np.log(fit.size_m) - circle, -0.7, 0.7))
        ratio = np.clip(np.log(max(grown.size_m, 0.005)) - circle, -0.7, 0.7)
        assert values[f"fit.{name}.growing.ratio"] == pytest.approx(ratio)
    ball = fit_ball_size(contacts)
    assert ball is not None
    assert values["fit.ball.off"] == pytest.approx(np.log1p(ball[1]))
    assert values["fit.ball.ratio"] == pytest.approx(np.clip(np.log(ball[0]) - circle, -0.7, 0.7))
    assert values["fit.least.off"] == min(v for k, v in values.items() if k.endswith(".off") and "least" not in k)


def test_a_grip_in_words_says_size_doubt_and_what_is_left() -> None:
    contacts = laid_against("circle", 0.08, np.random.default_rng(3), parts=9, noise_m=0.001)
    (words,) = grip_reasons(contacts)
    size = grip_size(contacts)
    assert size is not None
    numbers = [float(n) for n in re.findall(r"[\d.]+", words)]
    expected = []
    for fit in (size.cylinder, size.pillar):
        expected += [round(1e3 * fit.size_m), 1e3 * fit.sigma_m, 1e3 * np.sqrt(np.mean(fit.off_m**2))]
    assert numbers == pytest.approx(expected, abs=0.051)
    assert words.index("circle") < words.index("square")
    assert grip_reasons(None) == ()
    few_parts = laid_against("circle", 0.08, np.random.default_rng(3), parts=2)
    assert grip_reasons(few_parts) == ()
    assert form_values(few_parts) == {}
    # Parts that all meet one another say nothing for certain.
    heap = GripContacts(
        ("a.b", "c.d", "e.f"), np.zeros((3, 3)), np.full((3, 3), 1e-3), np.full(3, 0.01), np.ones(3, bool)
    )
    assert not heap.on_object().any()
    assert grip_reasons(heap) == ()


def test_half_height_is_the_radius_where_nothing_else_is_said() -> None:
    contacts = laid_against("circle", 0.08, np.random.default_rng(1), parts=5)
    np.testing.assert_array_equal(contacts.half_height_m, contacts.radius_m)
    turned = moved(contacts, 1.0, (0.01, 0.0))
    assert fit_section(turned, "circle").size_m == pytest.approx(fit_section(contacts, "circle").size_m, rel=1e-4)  # type: ignore[union-attr]


# Numbers of a pad


def surface(*log: float, curvature: tuple[float, float] = (20.0, -3.0)) -> PadSurface:
    return PadSurface(
        np.array(log),
        curvature,
        (1.0, 1.0),
        0.05,
        (0.04, 0.06),
        np.zeros(1),
        (0.002, -0.001),
        1.0,
        0.4,
        (False,) * 4,
        (),  # type: ignore[arg-type]
    )


def test_a_pad_says_likelihoods_bends_and_place() -> None:
    flat = surface(0.0, -20.0, 1.0, 2.0)
    by_name = flat.by_name
    values = pad_values("thumb", flat, size_m=0.05)
    assert set(pad_values("thumb", None)) == set(values)
    assert set(pad_values("thumb", None).values()) == {0.0}
    assert values["pad.thumb.on"] == 1.0
    assert values["pad.thumb.area"] == 0.4
    for key in ("curved", "edge", "point"):
        assert values[f"pad.thumb.{key}"] == pytest.approx(np.clip(by_name[key] - by_name["flat"], -8, 8))  # type: ignore[index]
    assert np.sinh([values["pad.thumb.curve"], values["pad.thumb.curve_up"]]) == pytest.approx(
        [4 * 20 * 0.025, 4 * -3 * 0.025]
    )
    assert np.sinh([values["pad.thumb.x"], values["pad.thumb.y"]]) == pytest.approx([0.2, -0.1])
    # A cylinder twice as large feels alike, if the grip has told its size; sizes that no hand grips are cut.
    large = pad_values("thumb", surface(0.0, -20.0, 1.0, 2.0, curvature=(10.0, -1.5)), size_m=0.1)
    assert large == pytest.approx(values)
    for given_size, taken in ((None, 0.07), (0.01, 0.03), (1.0, 0.15)):
        assert pad_values("a", flat, size_m=given_size) == pad_values("a", flat, size_m=taken)


def test_round_pads_are_rounder_than_flat_ones_and_one_flat_one_is_the_least() -> None:
    names = list(surface(0, 0, 0, 0).by_name)

    def pad(**log: float) -> PadSurface:
        return surface(*(log.get(name, -9.0) for name in names))

    curved, flat, edge, none = pad(curved=3.0), pad(flat=3.0), pad(edge=3.0), surface(0, 0, 0, 0)
    assert form_values(None, {}) == form_values(None, {"a": None}) == {}
    for pads, least, total in (
        ([curved], 5.0, 5.0),
        ([flat], -5.0, -5.0),
        ([edge], -5.0, -5.0),
        ([none], 0.0, 0.0),
        ([curved, curved], 5.0, 10.0),
        ([curved, flat], -5.0, 0.0),
        ([curved, none, None], 0.0, 5.0),
    ):
        told = form_values(None, dict(zip("abc", pads, strict=False)))
        assert told["form.least_round"] == pytest.approx(least)
        assert np.sinh(told["form.pads_round"]) == pytest.approx(total)


def test_a_broken_switch_is_unknown() -> None:
    told = switch_values({"a": True, "b": False, "c": None})
    assert (told["switch.a"], told["switch.b"]) == (1.0, 0.0)
    assert np.isnan(told["switch.c"])


# What is learned


def test_nine_examples_teach_how_a_number_changes_with_size_and_eight_do_not() -> None:
    for n, known in ((8, False), (9, True)):
        log_size = np.linspace(-3, -2, n)
        values = np.column_stack([4 * log_size, np.random.default_rng(0).normal(size=n)])
        told = fit_metric(("a", "b"), values, np.zeros(n, int), log_size, shrink=0.0)
        assert (told.covariance[0, 0] < 1e-6) == known
    # One size alone, or a size that is not known, teaches nothing of size.
    for sizes in (np.full(9, -2.5), np.where(np.arange(9) == 4, np.nan, log_size)):
        assert fit_metric(("a", "b"), values, np.zeros(9, int), sizes, shrink=0.0).covariance[0, 0] > 0.5


@few
@given(seeds, st.integers(5, 9))
def test_the_more_examples_the_less_is_added_for_their_fewness(seed: int, copies: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-3, -2, (12, 1))
    y = x[:, 0] + 0.05 * rng.normal(size=12)
    scale = []
    for times in (4, copies):
        fitted = fit_size_model(("a",), np.tile(x, (times, 1)), np.tile(y, times), np.zeros(12 * times, int))
        scale.append(fitted.scale[0] / (1 + 2 / (12 * times)))
    assert scale[1] == pytest.approx(scale[0], rel=0.12)


@few
@given(seeds, st.sets(st.integers(0, 3), min_size=1))
def test_likelihood_is_of_the_distance_in_the_numbers_that_are_known(seed: int, known: set[int]) -> None:
    rng = np.random.default_rng(seed)
    library = Library.from_examples(
        {
            name: [[Evidence("grasp", {f"form.{k}": rng.normal() + at for k in range(4)})] for _ in range(12)]
            for name, at in (("ball", 0.0), ("box", 1.0))
        }
    )
    model = library.touches["grasp"]
    touch = np.where(np.isin(np.arange(4), list(known)), rng.normal(size=4), np.nan)
    which = sorted(known)
    units = model.metric.standardized(model.values)[:, which]
    off = units - model.metric.standardized(touch)[which]
    inverse = np.linalg.inv(model.metric.covariance[np.ix_(which, which)])
    squares = np.einsum("ni,ij,nj->n", off, inverse, off)
    told = model.log_kernel(touch)
    np.testing.assert_allclose(told, model.kernel(squares, len(which)), rtol=1e-3, atol=1e-3)
    rows = np.array([3, 0, 17])
    np.testing.assert_allclose(model.log_kernel(touch, rows=rows), told[rows], rtol=1e-6)
    assert (model.log_kernel(np.full(4, np.nan)) == 0).all()


def test_the_row_that_is_wrong_is_named() -> None:
    wrong = np.zeros((5, 3))
    wrong[3, 1] = np.inf
    with pytest.raises(InputError, match="got inf in row 3"):
        fuse({"a": wrong})
    wrong[3, 1] = np.nan
    with pytest.raises(InputError, match="row 3 is NaN in part"):
        fuse({"a": wrong})


@few
@given(seeds, st.floats(0.2, 3.0))
def test_what_the_prior_rules_out_is_as_if_it_were_not_there(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    sources = {name: np.log(rng.dirichlet(np.ones(4), size=3)) for name in "ab"}
    prior = np.log(rng.dirichlet(np.ones(3)))
    weights = dict.fromkeys("ab", weight)
    all_four = fuse(sources, weights, mixing=0.1, log_prior=np.array([-np.inf, *prior]))
    three = fuse({name: each[:, 1:] for name, each in sources.items()}, weights, mixing=0.1, log_prior=prior)
    assert np.isneginf(all_four[:, 0]).all()
    np.testing.assert_allclose(all_four[:, 1:], three, atol=1e-9)
