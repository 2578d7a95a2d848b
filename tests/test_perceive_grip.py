"""Size from the grip: laws on capsules that are laid against sections, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.perceive import GRIP_SECTIONS, GripContacts, fit_ball_size, fit_section, grip_size, grip_values
from varishold.perceive.grip import _SINKS_M

# Sections are told apart in grips of objects as large as these; smaller ones can hide behind the parts. Metres.
SIZES = st.floats(0.045, 0.115)
SEEDS = st.integers(0, 2**32 - 1)


def outline(section: str, size_m: float, turn_rad: float, n: int = 20000) -> np.ndarray:
    """Points all round a section about zero, without what is tested: from its supports in all directions."""
    shape = GRIP_SECTIONS[section]
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    corners = size_m * shape.corners @ np.array([[c, s], [-s, c]])
    if len(corners) == 1:
        round_ = 2 * np.pi * np.arange(n) / n
        return corners + shape.radius * size_m * np.column_stack([np.cos(round_), np.sin(round_)])
    along = np.arange(n // len(corners))[:, None] * len(corners) / n
    return np.vstack([a + along * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


def laid_against(
    section: str,
    size_m: float,
    rng: np.random.Generator,
    *,
    parts: int = 8,
    turn_rad: float | None = None,
    middle_m: tuple[float, float] | None = None,
    growth: float = 0.0,
    noise_m: float = 0.0,
) -> GripContacts:
    """Lay capsules tangent to a section from all sides: each line touches where the section reaches farthest."""
    turn = rng.uniform(0, 2 * np.pi) if turn_rad is None else turn_rad
    middle = (size_m / 2 + rng.uniform(-0.01, 0.01), rng.uniform(-0.03, 0.03)) if middle_m is None else middle_m
    radius = rng.uniform(0.005, 0.012, parts)
    facing = 2 * np.pi * np.arange(parts) / parts + rng.uniform(-0.3, 0.3, parts) + rng.uniform(0, 6)
    starts, ends = np.empty((2, parts, 3))
    for k in range(parts):
        # Each part has a height of its own, so that no two digits meet.
        z = 0.05 * (k - parts / 2) * (1 if growth == 0 else 0.5)
        out = np.array([np.cos(facing[k]), np.sin(facing[k])])
        points = outline(section, size_m + growth * z, turn, 4800)
        farthest = points[np.argmax(points @ out)] + middle
        line = farthest + (radius[k] - _SINKS_M + rng.normal(0, noise_m)) * out
        along, length, slid = np.array([-out[1], out[0]]), rng.uniform(0.015, 0.04), rng.uniform(0.1, 0.9)
        starts[k] = [*(line - slid * length * along), z]
        ends[k] = [*(line + (1 - slid) * length * along), z]
    return GripContacts(tuple(f"digit{k}.distal" for k in range(parts)), starts, ends, radius, np.ones(parts, bool))


def moved(
    contacts: GripContacts, turn_rad: float, shift_m: tuple[float, float], mirrored: bool = False
) -> GripContacts:
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    mirror = np.diag([1.0, -1.0 if mirrored else 1.0, 1.0])
    lines = (ends @ mirror @ turn + [*shift_m, 0.0] for ends in (contacts.start_m, contacts.end_m))
    return GripContacts(contacts.parts, *lines, contacts.radius_m, contacts.touched)


def with_part(contacts: GripContacts, name: str, start: object, end: object, touched: bool) -> GripContacts:
    return GripContacts(
        (*contacts.parts, name),
        np.vstack([contacts.start_m, start]),
        np.vstack([contacts.end_m, end]),
        np.append(contacts.radius_m, 0.008),
        np.append(contacts.touched, touched),
    )


@pytest.mark.parametrize("section", ["circle", "square"])
@given(size_m=SIZES, parts=st.integers(6, 11), seed=SEEDS)
@settings(max_examples=40)
def test_what_lies_against_all_parts_is_found_exactly(section: str, size_m: float, parts: int, seed: int) -> None:
    fit = fit_section(laid_against(section, size_m, np.random.default_rng(seed), parts=parts), section)
    assert fit is not None
    assert fit.size_m == pytest.approx(size_m, abs=max(1.5e-4, fit.sigma_m / 2))
    assert fit.cost < 1.0


@given(size_m=SIZES, seed=SEEDS)
@settings(max_examples=40)
def test_a_hexagon_is_found_within_its_uncertainty(size_m: float, seed: int) -> None:
    fit = fit_section(laid_against("hexagon", size_m, np.random.default_rng(seed), parts=10), "hexagon")
    assert fit is not None
    assert fit.size_m == pytest.approx(size_m, abs=max(2e-4, 3 * fit.sigma_m))


@pytest.mark.parametrize("section", ["circle", "square", "hexagon"])
def test_middle_and_turn_are_found_too(section: str) -> None:
    rng = np.random.default_rng(4)
    contacts = laid_against(section, 0.08, rng, parts=10, turn_rad=0.3, middle_m=(0.05, 0.01))
    fit = fit_section(contacts, section)
    assert fit is not None
    assert fit.middle_m == pytest.approx((0.05, 0.01), abs=1e-4)
    period = GRIP_SECTIONS[section].period_rad
    if period:
        assert abs((fit.turn_rad - 0.3 + period / 2) % period - period / 2) < 0.01
    assert np.abs(fit.off_m).max() < 1e-4


@given(size_m=st.floats(0.055, 0.1), growth=st.floats(-0.5, 0.5), seed=SEEDS)
@settings(max_examples=25)
def test_a_cone_tells_how_it_grows(size_m: float, growth: float, seed: int) -> None:
    assume(size_m - 0.1 * abs(growth) > 0.03)
    fit = fit_section(
        laid_against("circle", size_m, np.random.default_rng(seed), parts=10, growth=growth), "circle", grows=True
    )
    assert fit is not None
    assert fit.size_m == pytest.approx(size_m, abs=max(3e-4, fit.sigma_m))
    assert fit.growth == pytest.approx(growth, abs=0.02)


@given(
    size_m=SIZES,
    turn_rad=st.floats(-0.3, 0.3),
    shift_m=st.tuples(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01)),
    mirrored=st.booleans(),
    seed=SEEDS,
)
@settings(max_examples=40)
def test_the_size_stays_when_the_hand_turns_moves_or_is_mirrored(
    size_m: float, turn_rad: float, shift_m: tuple[float, float], mirrored: bool, seed: int
) -> None:
    contacts = laid_against("circle", size_m, np.random.default_rng(seed), noise_m=3e-4)
    here, there = fit_section(contacts, "circle"), fit_section(moved(contacts, turn_rad, shift_m, mirrored), "circle")
    assert here is not None
    assert there is not None
    assert there.size_m == pytest.approx(here.size_m, abs=2e-5)
    assert there.sigma_m == pytest.approx(here.sigma_m, rel=0.02)
    x, y = here.middle_m[0], here.middle_m[1] * (-1 if mirrored else 1)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    assert there.middle_m == pytest.approx((c * x - s * y + shift_m[0], s * x + c * y + shift_m[1]), abs=5e-5)


@given(size_m=st.floats(0.055, 0.08), factor=st.floats(0.85, 1.4), seed=SEEDS)
@settings(max_examples=40)
def test_the_size_scales_with_hand_and_object(size_m: float, factor: float, seed: int) -> None:
    small = laid_against("circle", size_m, np.random.default_rng(seed))
    large = GripContacts(
        small.parts,
        factor * small.start_m,
        factor * small.end_m,
        factor * (small.radius_m - _SINKS_M) + _SINKS_M,
        small.touched,
    )
    one, other = fit_section(small, "circle"), fit_section(large, "circle")
    assert one is not None
    assert other is not None
    assert other.size_m == pytest.approx(factor * one.size_m, abs=1e-4)


@pytest.mark.parametrize("section", ["circle", "square"])
@given(size_m=SIZES, seed=SEEDS, away_m=st.floats(0.02, 0.2), facing=st.floats(0, 6.28))
@settings(max_examples=25)
def test_a_part_that_touches_nothing_and_is_clear_does_not_count(
    section: str, size_m: float, seed: int, away_m: float, facing: float
) -> None:
    contacts = laid_against(section, size_m, np.random.default_rng(seed))
    without = fit_section(contacts, section)
    assert without is not None
    far = 1.5 * size_m + 0.02 + away_m
    at = np.array([without.middle_m[0] + far * np.cos(facing), without.middle_m[1] + far * np.sin(facing), 0.3])
    fit = fit_section(with_part(contacts, "spare.distal", at, at + np.array([0, 0.01, 0]), False), section)
    assert fit is not None
    assert fit.size_m == pytest.approx(without.size_m, abs=1e-6)


def test_a_part_that_touches_nothing_keeps_the_object_out() -> None:
    """Three parts on one side of a cylinder leave its size open; a free one behind it bounds it."""
    facing = np.array([np.pi - 0.25, np.pi, np.pi + 0.25])
    out = np.column_stack([np.cos(facing), np.sin(facing), 0 * facing])
    along = np.column_stack([-np.sin(facing), np.cos(facing), 0 * facing])
    line = [0.04, 0, 0] + (0.04 + 0.008 - _SINKS_M) * out
    rise = np.array([[0, 0, -0.05], [0, 0, 0], [0, 0, 0.05]])
    three = GripContacts(
        tuple("abc"), line - 0.01 * along + rise, line + 0.01 * along + rise, np.full(3, 0.008), np.ones(3, bool)
    )
    behind = [0.06, -0.02, 0.1]
    bounded = with_part(three, "d", behind, [0.06, 0.02, 0.1], False)
    open_, shut = fit_section(three, "circle"), fit_section(bounded, "circle")
    assert open_ is not None
    assert shut is not None
    assert shut.middle_m[0] + shut.size_m / 2 < 0.06 - 0.008 + 2e-3
    assert open_.sigma_m > 3e-3


@pytest.mark.parametrize("section", ["circle", "square"])
@given(size_m=SIZES, seed=SEEDS, facing=st.floats(0, 6.28), gap_m=st.floats(0.006, 0.03))
@settings(max_examples=25)
def test_a_part_that_touches_another_digit_does_not_decide(
    section: str, size_m: float, seed: int, facing: float, gap_m: float
) -> None:
    contacts = laid_against(section, size_m, np.random.default_rng(seed), parts=9)
    true = fit_section(contacts, section)
    assert true is not None
    far = (0.5 if section == "circle" else 0.71) * size_m + 0.008 + gap_m
    out = np.array([np.cos(facing), np.sin(facing), 0.0])
    at = [*true.middle_m, 0.4] + far * out
    two = with_part(contacts, "thumb.distal", at, at + np.array([0, 0, 1e-4]), True)
    # The other digit that it leans on stands behind it.
    two = with_part(two, "ring.middle", at + 0.016 * out, at + 0.04 * out, False)
    assert not two.on_object()[-2]
    assert two.on_object()[:-2].all()
    fit = fit_section(two, section)
    assert fit is not None
    assert fit.size_m == pytest.approx(size_m, rel=0.01)


def test_what_meets_another_digit_is_not_for_certain_on_the_object() -> None:
    def grip(height_m: float, name: str = "thumb.distal") -> np.ndarray:
        starts = np.array([[0.0, 0, 0], [0.0, 0.015, height_m], [0.1, 0, 0]])
        return GripContacts(
            ("index.distal", name, "ring.distal"),
            starts,
            starts + np.array([0.02, 0, 0]),
            np.full(3, 0.008),
            np.array([True, True, True]),
        ).on_object()

    assert grip(0.0).tolist() == [False, False, True]
    assert grip(0.05).tolist() == [True, True, True]
    assert grip(0.0, "index.middle").tolist() == [True, True, True]


@pytest.mark.parametrize("section", ["circle", "square"])
def test_the_uncertainty_is_honest(section: str) -> None:
    scores = []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        size_m = rng.uniform(0.05, 0.11)
        fit = fit_section(laid_against(section, size_m, rng, noise_m=5e-4), section)
        assert fit is not None
        scores.append((fit.size_m - size_m) / fit.sigma_m)
    assert abs(np.mean(scores)) < 0.35
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.4
    assert np.mean(np.abs(scores) < 1.96) > 0.85


@given(seed=SEEDS, size_m=SIZES)
@settings(max_examples=20)
def test_more_parts_leave_less_doubt(seed: int, size_m: float) -> None:
    contacts = laid_against("circle", size_m, np.random.default_rng(seed), parts=10)
    few = GripContacts(
        contacts.parts[::3], contacts.start_m[::3], contacts.end_m[::3], contacts.radius_m[::3], np.ones(4, bool)
    )
    all_, some = fit_section(contacts, "circle"), fit_section(few, "circle")
    assert all_ is not None
    assert some is not None
    assert all_.sigma_m < some.sigma_m


@pytest.mark.parametrize(("section", "round_"), [("circle", True), ("square", False)])
def test_the_likelier_section_is_the_true_one(section: str, round_: bool) -> None:
    right = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        size_m = rng.uniform(0.05, 0.11)
        size = grip_size(laid_against(section, size_m, rng, parts=9, noise_m=2e-4))
        assert size is not None
        right += (size.p_cylinder > 0.5) == round_
        likelier = size.cylinder if size.p_cylinder >= 0.5 else size.pillar
        assert (size.size_m, size.sigma_m) == (likelier.size_m, likelier.sigma_m)
    assert right >= 57


@given(diameter_m=SIZES, seed=SEEDS)
@settings(max_examples=25)
def test_a_ball_is_found_at_any_height(diameter_m: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle = np.array([rng.uniform(0.02, 0.06), rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02)])
    out = rng.normal(size=(14, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    along = np.cross(out, rng.normal(size=(14, 3)))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    radius = rng.uniform(0.005, 0.012, 14)
    line = middle + (diameter_m / 2 + radius - _SINKS_M)[:, None] * out
    # One digit, so that parts that happen to lie near each other do not count as meeting.
    contacts = GripContacts(
        tuple(f"digit.{k}" for k in range(14)), line - 0.01 * along, line + 0.012 * along, radius, np.ones(14, bool)
    )
    found = fit_ball_size(contacts)
    assert found is not None
    assert found[0] == pytest.approx(diameter_m, abs=3e-4)


@pytest.mark.parametrize("touched", [0, 1, 2])
def test_too_few_touched_parts_say_nothing(touched: int) -> None:
    contacts = laid_against("circle", 0.08, np.random.default_rng(1), parts=6)
    few = GripContacts(contacts.parts, contacts.start_m, contacts.end_m, contacts.radius_m, np.arange(6) < touched)
    assert grip_size(few) is None
    assert fit_section(few, "square", grows=True) is None
    assert fit_ball_size(few) is None
    assert grip_values(few) == {}


def test_no_parts_at_all_say_nothing() -> None:
    nothing = GripContacts((), np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0, bool))
    assert nothing.on_object().shape == (0,)
    assert grip_size(nothing) is None


def test_the_same_grip_gives_the_same_numbers() -> None:
    contacts = laid_against("square", 0.07, np.random.default_rng(9), noise_m=5e-4)
    assert grip_values(contacts) == grip_values(contacts)


@pytest.mark.parametrize("factor", [0.0, 1e-6, 0.1, 3.0, 9.0])
def test_grips_of_any_scale_give_finite_sizes(factor: float) -> None:
    """As when all parts lie on one point."""
    contacts = laid_against("square", 0.07, np.random.default_rng(9))
    odd = GripContacts(
        contacts.parts,
        factor * contacts.start_m,
        factor * contacts.end_m,
        factor * contacts.radius_m,
        contacts.touched,
    )
    values = grip_values(odd)
    assert values
    assert np.isfinite(list(values.values())).all()


GOOD = {
    "parts": ("a", "b", "c"),
    "start_m": np.zeros((3, 3)),
    "end_m": np.ones((3, 3)),
    "radius_m": np.full(3, 0.01),
    "touched": np.ones(3, bool),
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_m": np.zeros((3, 2))}, r"start_m of 3 grip contacts must have shape \(3, 3\), got \(3, 2\)"),
        ({"end_m": "far"}, r"end_m of 3 grip contacts must be numbers of shape \(3, 3\)"),
        ({"end_m": np.zeros((2, 3))}, r"end_m of 3 grip contacts must have shape \(3, 3\), got \(2, 3\)"),
        ({"radius_m": np.zeros(4)}, r"radius_m of 3 grip contacts must have shape \(3,\), got \(4,\)"),
        ({"touched": np.ones(2, bool)}, r"touched of 3 grip contacts must have shape \(3,\), got \(2,\)"),
        ({"touched": [1.0, np.nan, 1.0]}, "touched of grip contacts must be true or false each; leave out .*"),
        ({"touched": ["no"] * 3}, "touched of grip contacts must be true or false each; leave out .*"),
        ({"start_m": np.diag([1.0, np.nan, 1.0])}, "start_m of grip contact 'b' must be finite"),
        ({"end_m": np.diag([1.0, 1.0, np.inf])}, "end_m of grip contact 'c' must be finite"),
        ({"radius_m": np.array([0.01, np.nan, 0.01])}, "radius_m of grip contact 'b' must be finite"),
        ({"radius_m": np.array([0.01, -0.02, 0.01])}, "radius_m of grip contact 'b' is negative"),
        (
            {"start_m": np.diag([40.0, 0.0, 0.0])},
            "start_m of grip contact 'a' is out of a hand's reach of 2 m; give metres from the palm",
        ),
        ({"half_height_m": np.zeros(2)}, r"half_height_m of 3 grip contacts must have shape \(3,\), got \(2,\)"),
        ({"half_height_m": np.array([0.0, np.nan, 0.0])}, "half_height_m of grip contact 'b' must be finite"),
    ],
)
def test_bad_grips_are_refused_in_one_line(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}$"):
        GripContacts(**(GOOD | change))


def test_an_unknown_section_is_refused() -> None:
    with pytest.raises(InputError, match="unknown section 'oval'; known are circle, square, rectangle"):
        fit_section(GripContacts(**GOOD), "oval")
