"""Edges that somebody can meet: sizes of grips with few or odd parts, pads that just suffice, libraries changed."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_perceive_grip import laid_against

from varishold.errors import InputError
from varishold.perceive import (
    GRIP_SECTIONS,
    Belief,
    Evidence,
    GripContacts,
    Library,
    evidence_of_recording,
    evidence_of_row,
    fit_ball_size,
    fit_section,
    grip_size,
    grip_values,
    merge_evidence,
)
from varishold.perceive.metric import fit_metric
from varishold.perceive.section_fit import fit_turns
from varishold.perceive.size_prior import size_priors
from varishold.recording import GraspTable, Pad, Recording

SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=15, deadline=None)


def fitted(contacts: GripContacts, section: str, *, grows: bool) -> tuple[np.ndarray, ...]:
    """Fits from turns that are no more than .3 radian apart over a period, the parts half a millimetre sunk in."""
    shape = GRIP_SECTIONS[section]
    n = 1
    while shape.period_rad / n > 0.3:
        n += 1
    certain = np.where(contacts.on_object(), 2, np.where(contacts.touched, 1, 0))
    capsules = contacts.start_m, contacts.end_m, contacts.radius_m - 0.0005, certain
    turns = np.array([shape.period_rad * k / n for k in range(n)])
    return fit_turns(*capsules, shape.corners, shape.radius, turns, grows, 0.0005)


@FEW
@given(SEEDS, st.sampled_from(list(GRIP_SECTIONS)), st.booleans(), st.integers(3, 9), st.floats(0, 0.003))
def test_a_section_is_the_best_of_its_turns_and_all_of_them_say_how_unsure_it_is(
    seed: int, section: str, grows: bool, parts: int, noise_m: float
) -> None:
    contacts = laid_against("square", 0.08, np.random.default_rng(seed), parts=parts, noise_m=noise_m)
    fit = fit_section(contacts, section, grows=grows)
    assert fit is not None
    found, off, cost, variance = fitted(contacts, section, grows=grows)
    best = int(np.argmin(cost))
    assert (fit.section, fit.cost) == (section, cost[best])
    assert (*fit.middle_m, fit.size_m, fit.turn_rad, fit.growth) == pytest.approx(tuple(found[best]))
    np.testing.assert_array_equal(fit.off_m, off[best])
    # Middle and size are fitted, the turn of what is not round, and growth: what is left tells how well it fits.
    free = int(contacts.on_object().sum()) - 3 - (section != "circle") - grows
    poor = max(1.0, 2 * cost[best] / max(free, 1))
    share = np.array([np.exp((cost[best] - c) / poor) for c in cost])
    share /= share.sum()
    mean = sum(share * found[:, 2])
    expected = poor * variance[best] + sum(share * (found[:, 2] - mean) ** 2)
    assert fit.sigma_m == pytest.approx(np.sqrt(expected), rel=1e-6)
    if not grows:
        assert fit.growth == pytest.approx(0, abs=1e-9)
    assert fit_section(contacts, section, grows=grows) is fit


@FEW
@given(SEEDS, st.sampled_from(["circle", "square"]), st.floats(0.001, 0.004))
def test_round_or_square_is_weighed_by_cost_and_the_squares_turn_is_one_number_more(
    seed: int, section: str, noise_m: float
) -> None:
    contacts = laid_against(section, 0.08, np.random.default_rng(seed), parts=6, noise_m=noise_m)
    size, round_, square = grip_size(contacts), fit_section(contacts, "circle"), fit_section(contacts, "square")
    assert size is not None
    assert round_ is not None
    assert square is not None
    odds = np.exp(np.clip(square.cost - round_.cost, -45, 45)) * np.sqrt(6)
    assert size.p_cylinder == pytest.approx(odds / (1 + odds), rel=1e-6, abs=1e-15)
    likelier = round_ if size.p_cylinder >= 0.5 else square
    assert (size.size_m, size.sigma_m) == (likelier.size_m, likelier.sigma_m)
    even = replace(size, p_cylinder=0.5)
    assert even.size_m == round_.size_m
    assert replace(size, p_cylinder=0.499).size_m == square.size_m


def test_three_touched_parts_are_enough_and_two_are_not() -> None:
    contacts = laid_against("circle", 0.08, np.random.default_rng(1), parts=6)
    for touched, enough in ((2, False), (3, True)):
        some = replace(contacts, touched=np.arange(6) < touched)
        told = (grip_values(some), fit_ball_size(some), fit_section(some, "hexagon"), grip_size(some))
        assert [bool(one) for one in told] == [enough] * 4
        if enough:
            assert grip_values(some)["fit.parts"] == 3.0


def test_what_lies_just_within_a_hands_reach_is_taken() -> None:
    lines = np.diag([2.0, -2.0, 0.0])
    there = GripContacts(("a", "b", "c"), lines, -lines, np.zeros(3), np.ones(3, bool))
    np.testing.assert_array_equal(there.half_height_m, 0.0)
    with pytest.raises(InputError, match="grip contact 'b' is out of a hand's reach of 2 m"):
        replace(there, start_m=lines * (1, 1.001, 1))
    none = GripContacts((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, bool))
    assert none.on_object().shape == (0,)


def test_growths_and_ratios_that_are_absurd_are_cut() -> None:
    ends = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        start = rng.normal(0, 0.05, (5, 3))
        contacts = GripContacts(
            tuple("abcde"), start, start + rng.normal(0, 0.02, (5, 3)), np.full(5, 0.008), start[:, 0] < 9
        )
        values = grip_values(contacts)
        growths = np.array([x for name, x in values.items() if name.endswith(".growth")])
        ratios = np.array([x for name, x in values.items() if name.endswith(".ratio")])
        assert np.abs(growths).max() <= 1.5
        assert np.abs(ratios).max() <= 0.7
        circle = values["size.circle"]
        for name in GRIP_SECTIONS:
            fit = fit_section(contacts, name, grows=True)
            assert fit is not None
            assert values[f"fit.{name}.growth"] == pytest.approx(np.clip(fit.growth, -1.5, 1.5))
            assert values[f"size.{name}.growing"] == pytest.approx(np.log(max(fit.size_m, 0.005)))
            ratio = np.clip(np.log(max(fit.size_m, 0.005)) - circle, -0.7, 0.7)
            assert values[f"fit.{name}.growing.ratio"] == pytest.approx(ratio)
        ends += int((np.abs(growths) == 1.5).any()) + int((np.abs(ratios) == 0.7).any())
    assert ends > 10


# Evidence


def test_evidence_of_no_number_and_of_a_failure() -> None:
    assert Evidence("t", {"a": float("nan")}, failed=True).failed
    with pytest.raises(InputError, match="failed, so that it cannot have values; got 1"):
        Evidence("t", {"a": 1.0}, failed=True)
    plain = Evidence("t", {"a": 1})
    assert (plain.failed, plain.remarks, plain.reasons) == (False, (), ())
    np.testing.assert_array_equal(plain.vector(("b", "a")), [np.nan, 1.0])
    both = merge_evidence(Evidence("t", {"a": np.nan, "b": 2.0}), Evidence("t", {"a": 1.0, "b": np.nan}))
    assert dict(both.values) == {"a": 1.0, "b": 2.0}
    assert not both.failed
    assert merge_evidence(Evidence("t", {}), Evidence("t", {}, failed=True)).failed
    twice = [Evidence("t", {"a": 1.0}, ("odd",), ("said",)), Evidence("t", {"a": 1.0}, ("odd", "old"), ("said",))]
    assert (merge_evidence(*twice).remarks, merge_evidence(*twice).reasons) == (("odd", "old"), ("said",))


def test_every_column_that_tells_how_a_grasp_went_is_no_evidence() -> None:
    told = ("object", "size_m", "seed", "step", "held", "attempt", "attempts", "outcome")
    cells = {name: np.array([1.0, 2.0]) for name in told} | {"load": np.array([3.0, 4.0])}
    assert dict(evidence_of_row(GraspTable(cells), 1).values) == {"load": 4.0}
    last = evidence_of_row(GraspTable({"switch.a": np.array([1.0, np.nan])}), 1)
    assert last.remarks == ("grasp: nothing is known of switch.a",)
    with pytest.raises(InputError, match="there is no row -1"):
        evidence_of_row(GraspTable(cells), -1)


def blob(n: int, rows: int, cols: int) -> np.ndarray:
    y, x = np.mgrid[:rows, :cols]
    shape = 1000.0 * np.exp(-((y - rows / 2) ** 2 + (x - cols / 2) ** 2) / 4)
    return np.linspace(0.1, 1, n)[:, None, None] * shape


@pytest.mark.parametrize(("shape", "enough"), [((3, 3), True), ((3, 6), True), ((2, 6), False), ((6, 2), False)])
def test_three_by_three_taxels_tell_a_surface(shape: tuple[int, int], enough: bool) -> None:
    pad = Pad(blob(4, *shape), pitch_m=3.4e-3)
    assert bool(evidence_of_recording(Recording({"a": pad}, unit="Pa")).values) == enough


@pytest.mark.parametrize(("frames", "value", "broken"), [(8, 9.0, True), (7, 9.0, False), (8, 0.0, False)])
def test_a_pad_whose_values_never_change_over_eight_frames_is_broken(frames: int, value: float, broken: bool) -> None:
    pad = Pad(np.full((frames, 5, 5), value), pitch_m=3.4e-3)
    told = evidence_of_recording(Recording({"a": pad}, unit="Pa"))
    assert bool(told.remarks) == broken
    assert bool(told.values) != broken
    # One taxel that works is enough, and dead ones that are marked do not count.
    works = np.full((frames, 5, 5), value)
    works[0, 2, 2] += 1.0
    assert evidence_of_recording(Recording({"a": Pad(works, pitch_m=3.4e-3)}, unit="Pa")).values


def test_a_pads_own_spacing_counts_before_the_one_that_is_given() -> None:
    own, without = Pad(blob(4, 9, 6), pitch_m=3.4e-3), Pad(blob(4, 9, 6))
    told = evidence_of_recording(Recording({"a": own, "b": without}, unit="Pa"), pitch_m=3.4e-3).values
    for name in ("curve", "x", "y", "edge"):
        assert told[f"pad.a.{name}"] == told[f"pad.b.{name}"]
    other = evidence_of_recording(Recording({"a": own, "b": without}, unit="Pa"), pitch_m=5e-3).values
    assert other["pad.a.x"] == told["pad.a.x"]
    assert other["pad.b.curve"] != told["pad.b.curve"]
    for frame in (0, 3):
        assert evidence_of_recording(Recording({"a": own}, unit="Pa"), frame=frame).values["pad.a.on"] == 1.0
    for frame in (-1, 4):
        with pytest.raises(InputError, match="frames are numbered 0 to 3"):
            evidence_of_recording(Recording({"a": own}, unit="Pa"), frame=frame)


# Libraries


@cache
def library() -> Library:
    rng = np.random.default_rng(6)

    def example(middle: float, size_m: float) -> list[Evidence]:
        size = {"size.a": np.log(size_m) + rng.normal(0, 0.05)}
        return [Evidence(t, {"a": middle + rng.normal(), "b": rng.normal()} | size) for t in ("grasp", "tip")]

    sizes = {name: rng.uniform(0.04, 0.12, 12).tolist() for name in ("ball", "box")}
    return Library.from_examples(
        {name: [example(2.0 * k, s) for s in sizes[name]] for k, name in enumerate(sizes)},
        sizes_m=sizes,
        others=[example(-3.0, 0.07) for _ in range(12)],
    )


def test_a_library_keeps_the_first_touch_that_succeeded_and_costs_one_a_touch() -> None:
    rows = [
        [Evidence("t", {}, failed=True), Evidence("t", {"a": float(k)}), Evidence("t", {"a": 99.0})] for k in range(3)
    ]
    of = Library.from_examples({"ball": [*rows, [Evidence("t", {}, failed=True)], [Evidence("t", {"a": 5.0})]]})
    model = of.touches["t"]
    np.testing.assert_array_equal(model.values[:, 0], [0, 1, 2, np.nan, 5])
    assert model.failed.tolist() == [False, False, False, True, False]
    assert model.made.tolist() == [True, True, True, False, True]
    assert model.cost == 1.0
    assert (len(of), of.counts.tolist(), of.members.tolist()) == (5, [5], [[1.0] * 5])


@pytest.mark.parametrize("share", [1.0, 0.5, 1e-3])
def test_tempered_likelihoods_are_powers(share: float) -> None:
    of, there = library(), np.array([0.5, 0.5])
    soft = of.tempered(share)
    one = of.tempered(share, ["tip"])
    for name, model in of.touches.items():
        np.testing.assert_allclose(soft.touches[name].log_kernel(there), share * model.log_kernel(there), rtol=1e-6)
        same = one.touches[name] is model
        assert same == (name == "grasp")
    for wrong in (0.0, -0.5, 1.0001):
        with pytest.raises(InputError, match=r"share must lie in \(0, 1\]"):
            of.tempered(wrong)


def test_sizes_of_examples_stand_for_sizes_near_them_and_unknown_ones_for_any() -> None:
    of = library()
    sizes = np.linspace(np.log(0.02), np.log(0.25), 101)
    for owner, row, size in zip(of.owner, of.size_prior, of.log_size, strict=True):
        near = np.array([np.exp(-((x - size) ** 2) / (2 * 0.08**2)) for x in sizes])
        # Beside few examples one more counts, whose size may be any that is usual.
        own = of.log_size[of.owner == owner]
        wide = np.sqrt(0.3**2 + own.var())
        usual = np.array([np.exp(-((x - own.mean()) ** 2) / (2 * wide**2)) for x in sizes])
        expected = (len(own) * near / near.sum() + usual / usual.sum()) / (len(own) + 1)
        np.testing.assert_allclose(row, expected, rtol=1e-9)
    many = np.full(40, np.log(0.05))
    near = np.exp(-((sizes - many[0]) ** 2) / (2 * 0.08**2))
    np.testing.assert_allclose(size_priors(sizes, many, np.zeros(40, np.int64))[0], near / near.sum(), rtol=1e-9)
    rows = [[Evidence("t", {"a": float(k)})] for k in range(3)]
    unknown = of.with_object("egg", [[Evidence("tip", {"a": 1.0})]])
    np.testing.assert_allclose(unknown.size_prior[-1], 1 / 101)
    assert Library.from_examples({"a": rows}).size_prior.sum() == pytest.approx(3)
    # A size for each, or one for all; a tenth of a millimetre of a file's rounding does not matter.
    each = of.with_object("egg", [[Evidence("tip", {"a": 1.0})]] * 2, size_m=[0.05, 0.06])
    alike = of.with_object("egg", [[Evidence("tip", {"a": 1.0})]] * 2, size_m=0.05)
    np.testing.assert_allclose(np.exp(each.log_size[-2:]), [0.05, 0.06])
    np.testing.assert_allclose(np.exp(alike.log_size[-2:]), 0.05)
    assert alike.objects[-1] == "egg"
    assert alike.owner[-2:].tolist() == [2, 2]


def test_a_new_object_is_scored_as_if_it_had_been_there_and_leaves_others_as_they_are() -> None:
    of, rng = library(), np.random.default_rng(8)
    rows = [[Evidence("grasp", {"a": 5 + rng.normal(), "b": rng.normal()})] for _ in range(6)]
    wider = of.with_object("egg", rows)
    model, old = wider.touches["grasp"], of.touches["grasp"]
    np.testing.assert_array_equal(model.scores[: len(of)], old.scores)
    np.testing.assert_allclose(model.power[:2], old.power)
    known = np.ones(2, bool)
    for i in range(len(of), len(wider)):
        others = [j for j in range(len(of), len(wider)) if j != i]
        own = model.log_kernel(model.values[i])[others]
        expected = np.log(np.mean(np.exp(own))) - model.log_others(model.values[i])
        assert model.scores[i] == pytest.approx(expected, abs=1e-4)
    assert model.calibration(2, wider.owner, known).scores.tolist() == model.scores[len(of) :].tolist()
    # The touch that was not made of it has no score and no power.
    assert np.isnan(wider.touches["tip"].scores[len(of) :]).all()
    assert np.isnan(wider.touches["tip"].power[2])
    back = wider.only(["egg", "ball"])
    assert (back.objects, back.counts.tolist()) == (("egg", "ball"), [6, 12])
    np.testing.assert_array_equal(back.touches["grasp"].power, model.power[[2, 0]])


# The belief


def test_a_size_that_was_ruled_out_can_come_back() -> None:
    """Errors end at sixty nats: after a slip far off, true touches find the size again."""
    belief = Belief.before(library())
    true = Evidence("grasp", {"size.a": np.log(0.06)})
    for _ in range(3):
        belief = belief.after(Evidence("grasp", {"size.a": np.log(0.24)}))
    for _ in range(12):
        belief = belief.after(true)
    size = belief.size()
    assert size is not None
    assert size[0] == pytest.approx(0.06, rel=0.1)
    moved = belief.in_new_place()
    assert np.isfinite(moved.kept).all()
    assert np.isfinite(list(moved.probability.values())).all()


def test_numbers_beyond_all_examples_are_remarked_and_odd_p_values_are_atypical() -> None:
    rng = np.random.default_rng(2)
    rows = {n: [[Evidence("t", {"a": k + rng.normal()})] for _ in range(200)] for k, n in enumerate(("ball", "box"))}
    of = Library.from_examples(rows)
    usual = Belief.before(of).after(Evidence("t", {"a": 0.5}))
    assert (usual.remarks, usual.atypical) == ((), False)
    assert usual.believed == usual.probability
    assert usual.inside > 1
    far = Belief.before(of).after(Evidence("t", {"a": 40.0}))
    assert far.remarks == ("t: a lies beyond all that the library's examples have shown",)
    assert far.atypical
    assert max(far.believed.values()) <= 0.9
    # With 200 examples it is atypical at .007, with 20 only beyond all of them.
    for a in np.linspace(-5, 6, 120):
        belief = Belief.before(of).after(Evidence("t", {"a": a}))
        assert belief.atypical == (belief.p_value <= 0.007)
        few = Library.from_examples({n: r[:20] for n, r in rows.items()})
        one = Belief.before(few).after(Evidence("t", {"a": a}))
        assert one.atypical == (one.p_value <= 1 / 21)


# Metrics


@FEW
@given(SEEDS, st.integers(9, 30), st.booleans())
def test_scatter_is_what_is_left_of_a_curve_over_size(seed: int, n: int, sized: bool) -> None:
    rng = np.random.default_rng(seed)
    owner = np.repeat([0, 1], n)
    log_size = rng.uniform(-3, -2, 2 * n) if sized else np.full(2 * n, -2.5)
    values = rng.normal(size=(2 * n, 3)) + np.outer(log_size, [1, 2, 0])
    metric = fit_metric(("a", "b", "c"), values, owner, log_size)
    units = (values - values.mean(axis=0)) / values.std(axis=0)
    total, free = np.zeros((3, 3)), 2 * n - (6 if sized else 2)
    for k in (0, 1):
        s, own = log_size[owner == k], units[owner == k]
        # A parabola over sizes that differ, else the mean.
        rest = np.array([y - (np.polyval(np.polyfit(s + 2.5, y, 2), s + 2.5) if sized else y.mean()) for y in own.T])
        total += rest @ rest.T
    added = 0.2 * (1 + 3 / free) * np.eye(3)
    np.testing.assert_allclose(metric.covariance, total / free + added, rtol=1e-6, atol=1e-8)
