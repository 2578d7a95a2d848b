"""What a perceiver says outside of what its library has seen: numbers beyond every example promise no name."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.toy_library import OBJECTS, library, touches

from varishold.perceive import NONE_OF_THESE, Belief, Evidence, Library, Perceiver, shipped_library
from varishold.perceive.metric import fit_metric
from varishold.perceive.number_words import number_in_words
from varishold.perceive.seen import range_look, seen_range

SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=40)
@given(SEEDS, st.sampled_from(list(OBJECTS)), st.sampled_from([0, 60]), st.booleans(), st.floats(10.0, 1e6))
def test_a_number_beyond_every_example_promises_no_name(
    seed: int, name: str, others: int, refuse: bool, off: float
) -> None:
    rng = np.random.default_rng(seed)
    seen = max(float(np.nanmax(np.abs(m.values[:, 1]))) for m in library(40, others).touches.values())
    perceiver = Perceiver(library(40, others), refuse=refuse, most_touches=2)
    for k, touch in enumerate(touches(OBJECTS[name], rng)):
        there = Evidence(
            touch.touch, {**touch.values, "load": rng.choice([-1, 1]) * (seen + off)} if k else touch.values
        )
        update = perceiver.feel(there)
    assert max(update.probability.values()) <= 0.9
    assert sum(update.probability.values()) == pytest.approx(1)
    assert update.verdict in ("none of these", "enough")
    assert perceiver.belief.inside <= 1
    answer = perceiver.answer()
    assert answer.object == NONE_OF_THESE or answer.probability <= 0.9
    assert refuse or answer.object != NONE_OF_THESE
    assert "higher: load lies beyond all that the library's examples have shown" in answer.remarks
    # The order of names is what the touches say.
    assert list(update.probability) == list(perceiver.belief.probability)


@settings(max_examples=30)
@given(SEEDS, st.booleans())
def test_what_is_atypical_promises_no_name_whether_it_may_be_refused_or_not(seed: int, refuse: bool) -> None:
    rng = np.random.default_rng(seed)
    perceiver = Perceiver(library(), refuse=refuse)
    update = perceiver.feel(Evidence("grasp", {"form": rng.uniform(1.7, 2.3), "load": 0.0}))
    if perceiver.belief.atypical:
        assert max(update.probability.values()) <= 0.9
        assert update.verdict != "sure"
    else:
        assert update.probability == perceiver.belief.probability


def test_known_things_lose_hardly_anything() -> None:
    rng, lost, named = np.random.default_rng(1), 0, 0
    for k in range(300):
        name = list(OBJECTS)[k % 3]
        belief = Belief.before(library())
        for touch in touches(OBJECTS[name], rng):
            belief = belief.after(touch)
        named += belief.probability[name] > 0.9
        lost += belief.probability[name] > 0.9 >= belief.believed[name]
    assert named > 270
    # Of forty examples of each one in 41 is refused at the least, and one of 121 lies beyond the others.
    assert lost <= 0.05 * named


def test_ranges_are_of_the_examples_that_made_the_touch() -> None:
    rng = np.random.default_rng(2)
    values = np.concatenate([rng.normal(0, 1, (50, 2)), np.full((5, 2), np.nan)])
    owner = np.zeros(55, np.int64)
    metric = fit_metric(("a", "b"), values[:50], owner[:50])
    seen = seen_range(metric, values)
    assert np.isfinite(seen.known).sum() == 50
    inside = seen.beyond(values[3])
    assert (inside.parts, range_look([(seen, inside)], 0.01).p_value) == (0.0, 1.0)
    far = seen.beyond(np.array([np.nan, 5.0]))
    assert far.name == "b"
    look = range_look([(seen, far)], 0.01)
    # Stranger than all fifty: outside, though fifty are too few for an error of a hundredth.
    assert (look.p_value, look.limit, look.inside) == (1 / 51, 1 / 51, 1.0)
    # It stays so whatever is felt besides.
    assert range_look([(seen, inside), (seen, far)], 0.01).p_value == 1 / 51
    assert range_look([], 0.01).p_value == 1.0
    # Of a number that no example knows nothing is said; one that never varied is beyond wherever it differs.
    lone = np.column_stack([np.full(20, 3.0), np.full(20, np.nan)])
    lone[0, 1] = 1.0
    flat = seen_range(fit_metric(("a", "b"), lone, np.zeros(20, np.int64)), lone)
    assert flat.beyond(np.array([3.0, 1.0])).parts == 0.0
    assert flat.beyond(np.array([3.5, np.nan])).parts == 1.0


def test_examples_lie_beyond_each_other_as_often_as_stated() -> None:
    rng, outside = np.random.default_rng(3), 0
    for _ in range(20):
        values = rng.standard_t(4, (400, 6))
        metric = fit_metric(tuple("abcdef"), values[:200], np.zeros(200, np.int64))
        seen = seen_range(metric, values[:200])
        outside += sum(range_look([(seen, seen.beyond(row))], 0.02).inside <= 1 for row in values[200:])
    assert outside / 4000 <= 0.03


def test_a_library_of_one_object_promises_it_no_more_than_others_do() -> None:
    rng = np.random.default_rng(4)
    one = Library.from_examples({"ball": [touches(0.0, rng) for _ in range(30)]})
    perceiver = Perceiver(one, refuse=False, most_touches=1)
    assert perceiver.feel(touches(0.0, rng)[0]).probability == pytest.approx({"ball": 1.0})
    perceiver.forget()
    update = perceiver.feel(Evidence("grasp", {"form": 0.0, "load": 50.0}))
    assert 0.5 <= update.probability["ball"] <= 0.9
    assert update.verdict == "enough"


def test_what_lies_beyond_is_told_in_words() -> None:
    """Every number of the shipped libraries has words of its own, without the name's dots."""
    known = [shipped_library(pose) for pose in ("upright", "lying")]
    names = {name for each in known for touch in each.touches.values() for name in touch.metric.names}
    words = {name: number_in_words(name) for name in names}
    assert len(set(words.values())) == len(names)
    assert not any(set("._") & set(told) for told in words.values())
    perceiver = Perceiver(known[0])
    grasp = known[0].touches["grasp"]
    usual = dict(zip(grasp.metric.names, grasp.values[int(np.argmax(grasp.made))].tolist(), strict=True))
    perceiver.feel(Evidence("grasp", {**usual, "pad.ring.middle.curve": 1e3}))
    (remark,) = perceiver.belief.remarks
    assert remark.startswith("grasp: how bent the surface is along the columns of pad ring middle lies beyond all")
