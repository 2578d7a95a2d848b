"""Other recognizers' answers as evidence: laws of the likelihood, of what they refuse, and of names nobody knows."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.toy_library import OBJECTS, library, touches

from varishold.errors import InputError
from varishold.learning import TactileClassifier, evidence_of_presses
from varishold.perceive import NONE_OF_THESE, Belief, Evidence, Library, NameEvidence, Perceiver
from varishold.perceive.name_evidence import names_in_words
from varishold.trust import merged_p_value, weighed_p_value
from varishold.trust.fusion import MIXING

SEEDS = st.integers(0, 2**32 - 1)
NAMES = tuple(OBJECTS)


def said(rng: np.random.Generator, names: tuple[str, ...] = NAMES, **more: Any) -> NameEvidence:
    p = rng.dirichlet(np.ones(len(names)))
    return NameEvidence("camera", dict(zip(names, p.tolist(), strict=True)), **more)


@given(SEEDS, st.integers(1, 6), st.floats(0.01, 1.0))
def test_an_answer_that_says_no_more_than_its_prior_changes_nothing(seed: int, n: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    names = (*NAMES, "a", "b", "c")[:n]
    prior = dict(zip(names, rng.dirichlet(np.ones(n)).clip(1e-3), strict=True))
    prior = {name: p / sum(prior.values()) for name, p in prior.items()}
    before = Belief.before(library()).after(touches(1.0, rng)[0])
    for of in (prior, None):
        same = prior if of else dict.fromkeys(names, 1 / n)
        after = before.after(NameEvidence("camera", same, of, weight=weight))
        assert after.probability == pytest.approx(before.probability, rel=1e-9)
        assert after.believed == pytest.approx(before.believed, rel=1e-9)
        assert after.atypical == before.atypical


@given(SEEDS)
@settings(max_examples=20)
def test_the_order_of_touches_and_answers_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    evidence = [*touches(1.5, rng), said(rng), said(rng, NAMES[:2], p_value=0.2)]
    found = []
    for order in permutations(evidence):
        belief = Belief.before(library())
        for one in order:
            belief = belief.after(one)
        found.append(belief)
    for belief in found[1:]:
        assert belief.probability == pytest.approx(found[0].probability, rel=1e-9)
        assert belief.p_value == pytest.approx(found[0].p_value, abs=0.03)
        assert belief.size() == found[0].size()


@given(SEEDS)
def test_answers_multiply_with_touches_wherever_the_object_was_moved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    touch, answer = touches(1.0, rng)[0], said(rng)
    felt = Belief.before(library()).after(touch)
    moved = felt.after(answer).in_new_place(), felt.in_new_place().after(answer)
    odds = {name: felt.probability[name] * (1 - MIXING) * 3 * answer.probability[name] for name in NAMES}
    odds = {name: p + felt.probability[name] * MIXING for name, p in odds.items()}
    total = sum(odds.values())
    for belief in (felt.after(answer), *moved):
        assert belief.probability == pytest.approx({name: p / total for name, p in odds.items()}, rel=1e-6)


def test_a_prior_is_divided_out_and_a_weight_is_a_power() -> None:
    p = {"ball": 0.6, "box": 0.4}
    even, skewed = NameEvidence("x", p), NameEvidence("x", p, {"ball": 0.9, "box": 0.1})
    assert np.diff(even.log_likelihood(NAMES)[:2])[0] < 0 < np.diff(skewed.log_likelihood(NAMES)[:2])[0]
    half = NameEvidence("x", p, weight=0.5)
    np.testing.assert_allclose(half.log_likelihood(NAMES), 0.5 * even.log_likelihood(NAMES))
    # A name that it does not know is neither likelier nor less likely; none is ruled out.
    assert even.log_likelihood(NAMES)[2] == 0.0
    never = NameEvidence("x", {"ball": 0.0, "box": 1.0})
    assert never.log_likelihood(NAMES)[0] == pytest.approx(np.log(MIXING))


@given(SEEDS, st.floats(0.001, 0.05))
def test_what_a_recognizer_refuses_says_no_name_and_that_it_may_be_none(seed: int, p_value: float) -> None:
    rng = np.random.default_rng(seed)
    felt = Belief.before(library()).after(touches(OBJECTS["box"], rng)[0])
    refused = said(rng, p_value=p_value)
    after = felt.after(refused)
    assert refused.refused
    assert after.probability == pytest.approx(felt.probability)
    assert after.atypical
    assert max(after.believed.values()) <= 0.9
    assert after.p_value <= p_value
    assert f"camera: none of its names, p = {p_value:.3f}" in after.remarks
    perceiver = Perceiver(library(), most_touches=2)
    perceiver.feel(touches(OBJECTS["box"], rng)[0])
    assert perceiver.feel(refused).verdict == "none of these"
    assert perceiver.answer().object == NONE_OF_THESE


@given(SEEDS, st.floats(0.001, 0.999))
def test_how_strange_a_thing_looks_is_weighed_with_how_strange_it_feels(seed: int, looked: float) -> None:
    rng = np.random.default_rng(seed)
    touch, camera = touches(OBJECTS["box"], rng)[0], said(rng, p_value=looked, error=0.0005)
    felt, both = Belief.before(library()).after(touch), Belief.before(library(), camera).after(touch)
    assert Perceiver(library(), prior=camera).feel(touch).p_value == both.p_value
    assert both.p_value_with_sight == pytest.approx(weighed_p_value(both.p_value, looked, 0.5))
    assert felt.p_value_with_sight == felt.p_value
    # One who does not say how strange it is to him changes names alone, and what is said later counts by itself.
    silent = Belief.before(library(), said(rng)).after(touch)
    assert silent.p_value_with_sight == silent.p_value
    assert felt.after(camera).p_value == pytest.approx(min(felt.p_value, looked))


@given(SEEDS)
def test_what_feels_strange_and_looks_usual_is_touched_to_the_end(seed: int) -> None:
    strange = touches(30.0, np.random.default_rng(seed))[0]
    for looked, expected in ((0.9, "go on"), (0.01, "none of these")):
        camera = NameEvidence("camera", dict.fromkeys(NAMES, 1 / 3), p_value=looked, error=0.0005)
        perceiver = Perceiver(library(), prior=camera, most_touches=3)
        assert [perceiver.feel(strange).verdict for _ in range(2)] == ["go on", expected]
        assert ("usual as it looked" in perceiver.feel(strange).why) == (perceiver.stopped is False)
        assert perceiver.answer().object == NONE_OF_THESE


def test_a_look_lets_nothing_pass_that_no_known_thing_feels_like() -> None:
    """With the 290 examples of each object of the shipped library, at the p-value below which it refuses."""
    assert weighed_p_value(1 / 291, 1.0, 0.5) < 0.008 < weighed_p_value(2 / 291, 0.5, 0.5)


def test_weighed_p_values_are_as_rare_as_stated_and_grow_with_both() -> None:
    rng = np.random.default_rng(3)
    p = rng.random((20000, 2))
    for weight in (0.2, 0.5, 0.9):
        found = np.array([weighed_p_value(one, other, weight) for one, other in p.tolist()])
        for error in (0.01, 0.1, 0.5):
            assert (found <= error).mean() == pytest.approx(error, abs=4 * np.sqrt(error / 20000))
        grid = [[weighed_p_value(one, other, weight) for one in (0.01, 0.2, 0.9)] for other in (0.01, 0.2, 0.9)]
        assert (np.diff(grid, axis=0) > 0).all()
        assert (np.diff(grid, axis=1) > 0).all()


def test_one_odd_answer_among_typical_ones_refuses_nothing() -> None:
    rng = np.random.default_rng(0)
    belief = Belief.before(library()).after(touches(OBJECTS["box"], rng)[0])
    for p_value in (0.04, 0.7, 0.5):
        belief = belief.after(said(rng, p_value=p_value))
    assert not belief.atypical
    assert merged_p_value([0.04, 0.7, 0.5]) == pytest.approx(0.8267, abs=1e-3)
    for p_value in (0.01, 0.02, 0.01, 0.02):
        strange = Belief.before(library()).after(said(rng, p_value=p_value)).after(said(rng, p_value=p_value))
        assert strange.atypical


@given(st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=6), SEEDS)
def test_merged_p_values_hold_whatever_hangs_together(p: list[float], seed: int) -> None:
    merged = merged_p_value(p)
    assert min(1.0, float(np.mean(p))) <= merged + 1e-12
    assert merged == pytest.approx(merged_p_value(np.random.default_rng(seed).permutation(p)))
    assert 0 < merged <= 1


def test_merged_p_values_are_as_rare_as_stated() -> None:
    rng = np.random.default_rng(1)
    for shared in (0.0, 0.5, 1.0):
        common = rng.random((4000, 1))
        p = np.where(rng.random((4000, 3)) < shared, common, rng.random((4000, 3)))
        found = np.array([merged_p_value(row) for row in p])
        for error in (0.05, 0.2):
            assert (found <= error).mean() <= error + 0.02


def test_names_that_the_library_does_not_know_widen_or_are_refused() -> None:
    box = touches(OBJECTS["box"], np.random.default_rng(2))[0]
    perceiver = Perceiver(library())
    perceiver.feel(box)
    before = perceiver.belief
    with pytest.raises(InputError) as caught:
        perceiver.feel(NameEvidence("camera", {"fork": 0.7, "spoon": 0.3}))
    assert str(caught.value) == (
        "'camera' knows fork, spoon, none of which is an object of the library; it knows ball, box, cone"
    )
    assert perceiver.belief is before
    mostly = before.after(NameEvidence("camera", {"box": 0.02, "fork": 0.98}))
    assert mostly.atypical
    assert max(mostly.believed.values()) <= 0.9
    assert mostly.remarks[-1] == "camera: 0.98 of its answer is about fork, which the library does not know"
    assert mostly.p_value == pytest.approx(0.04)
    partly = before.after(NameEvidence("camera", {"box": 0.6, "fork": 0.4}))
    assert not partly.atypical
    assert partly.probability["box"] >= before.probability["box"]
    fully = before.after(NameEvidence("camera", {"box": 1.0, "fork": 0.0}))
    assert not any("fork" in remark for remark in fully.remarks)


def test_it_counts_as_a_look_and_is_told() -> None:
    perceiver = Perceiver(library(), most_touches=1)
    update = perceiver.feel(NameEvidence("camera", {"ball": 0.9, "box": 0.06, "cone": 0.04}))
    assert (update.touch, update.verdict) == ("camera", "enough")
    assert update.reasons == ("camera: ball 0.90, else box 0.06",)
    assert perceiver.answer().object == "ball"
    assert perceiver.answer().probability == pytest.approx(0.9, abs=0.01)
    assert perceiver.belief.touches == ()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"source": " "}, "who says a name must have a name, got ' '"),
        ({"probability": {}}, "probability of 'x' must be numbers by name, got none"),
        ({"probability": [0.5, 0.5]}, "probability of 'x' must be numbers by name, got list"),
        ({"probability": {"a": "much"}}, "probability of 'x' must be numbers by name, got {'a': 'much'}"),
        ({"probability": {"a": 0.5}}, "probability of 'x' must be from 0 to 1 and sum to 1, got {'a': 0.5}"),
        ({"probability": {"a": 1.5, "b": -0.5}}, "must be from 0 to 1 and sum to 1"),
        ({"probability": {"a": np.nan, "b": 1.0}}, "must be from 0 to 1 and sum to 1"),
        ({"prior": {"a": 1.0}}, "prior of 'x' must be above 0 for each of a, b, got it for a"),
        ({"prior": {"a": 1.0, "b": 0.0}}, "prior of 'x' must be above 0 for each of a, b"),
        ({"p_value": 0.0}, "p_value of 'x' must be a number above 0 and at most 1, got 0.0"),
        ({"error": 2}, "error of 'x' must be a number above 0 and at most 1, got 2"),
        ({"weight": np.nan}, "weight of 'x' must be a number above 0 and at most 1, got nan"),
        ({"weight": "half"}, "weight of 'x' must be a number above 0 and at most 1, got 'half'"),
    ],
)
def test_what_is_no_answer_is_told(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        NameEvidence(**{"source": "x", "probability": {"a": 0.5, "b": 0.5}, **arguments})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_are_listed_in_few_words() -> None:
    assert names_in_words("abcdef") == "a, b, c, d and 2 more"
    assert names_in_words(["a"]) == "a"


def test_a_learned_model_is_a_source_of_evidence() -> None:
    rng = np.random.default_rng(3)
    row, col = np.indices((10, 10)) - 4.5
    shapes = {"ball": np.maximum(9 - row**2 - col**2, 0), "box": 9.0 * (np.maximum(abs(row), abs(col)) < 3)}
    frames = np.array([shapes[name] + rng.normal(0, 0.3, (10, 10)) for name in ("ball", "box") for _ in range(12)])
    model = TactileClassifier(drift=0.0).fit(frames, np.repeat(["ball", "box"], 12))
    weighed = Library.from_examples(
        {name: [[Evidence("lift", {"mass": m})] for m in rng.normal(5, 1, 12)] for name in ("ball", "box", "cup")}
    )
    new = np.array([shapes["box"] + rng.normal(0, 0.3, (10, 10)), rng.normal(0, 5, (10, 10))])
    known, strange = evidence_of_presses(model, new, source="fingertip")
    probabilities, p_values = model.judge(new)
    assert known.probability == pytest.approx(dict(zip(("ball", "box"), probabilities[0], strict=True)))
    assert (known.p_value, known.error, known.source) == (p_values[0], model.error, "fingertip")
    perceiver = Perceiver(weighed, most_touches=3)
    perceiver.feel(Evidence("lift", {"mass": 5.0}))
    update = perceiver.feel(known)
    assert next(iter(update.probability)) == "box"
    assert update.probability["box"] > 0.5
    if strange.refused:
        assert max(perceiver.feel(strange).probability.values()) <= 0.9
    light = evidence_of_presses(model, new[:1], weight=0.5)[0]
    np.testing.assert_allclose(2 * light.log_likelihood(("ball", "box")), known.log_likelihood(("ball", "box")))


@pytest.mark.parametrize("share", ["1", "0.5"])
def test_a_share_that_is_no_number_is_refused(share: object) -> None:
    with pytest.raises(InputError, match="probability of 'camera' must be numbers by name"):
        NameEvidence("camera", {"sphere": share})  # type: ignore[dict-item]
