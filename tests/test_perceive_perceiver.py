"""The perceiver: what it says, when it stops, what it wants next; missing pads, dead pads, no coordinates."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.perceive import (
    NONE_OF_THESE,
    BeliefUpdate,
    Evidence,
    Library,
    Perceiver,
    library_file,
    shipped_library,
)

OBJECTS = {"ball": (0.0, 0.0, 0.0), "box": (2.5, 0.0, 0.0), "cone": (0.0, 2.5, 1.0)}
TOUCHES = ("grasp", "higher", "tip")
STRANGER = (-4.0, 2.0, 4.0)


def world(middle: tuple[float, ...], rng: np.random.Generator, size_m: float = 0.07) -> list[Evidence]:
    pose = rng.normal(0, 0.5, 3)
    return [
        Evidence(
            touch,
            {f"pad.{pad}.curve": x for pad, x in zip(("thumb", "palm"), np.add(middle, pose)[:2], strict=True)}
            | {"fit.circle.off": middle[2] + rng.normal(0, 0.4), "switch.thumb": float(rng.random() < 0.5)}
            | {"size.circle": np.log(size_m) + rng.normal(0, 0.03)},
        )
        for touch in TOUCHES
    ]


@cache
def some_library() -> Library:
    rng = np.random.default_rng(0)
    sizes = {name: rng.uniform(0.05, 0.1, 60).tolist() for name in OBJECTS}
    return Library.from_examples(
        {name: [world(middle, rng, s) for s in sizes[name]] for name, middle in OBJECTS.items()},
        sizes_m=sizes,
        others=[world(STRANGER, rng) for _ in range(30)],
    )


def feel_until_stopped(perceiver: Perceiver, touches: list[Evidence]) -> list[BeliefUpdate]:
    updates = []
    for touch in touches:
        updates.append(perceiver.feel(touch))
        if perceiver.stopped:
            break
    return updates


def test_known_objects_are_named_and_the_answer_is_the_last_thought() -> None:
    rng, right = np.random.default_rng(1), 0
    for k in range(60):
        name = list(OBJECTS)[k % 3]
        perceiver = Perceiver(some_library(), error=0.05, most_touches=3)
        updates = feel_until_stopped(perceiver, world(OBJECTS[name], rng, 0.08))
        answer = perceiver.answer()
        right += answer.object == name
        assert answer.trace == tuple(updates)
        assert [update.verdict for update in updates[:-1]] == ["go on"] * (len(updates) - 1)
        if answer.object != NONE_OF_THESE:
            assert answer.object == next(iter(updates[-1].probability))
            # A little is left for things that the library does not know.
            p = updates[-1].probability[answer.object]
            assert 0.5 * p <= answer.probability <= p
            assert answer.object not in answer.alternatives
            assert answer.size_m == updates[-1].size_m
            assert answer.size_interval_m is not None
            low, high = answer.size_interval_m
            assert answer.size_m is not None
            assert low <= answer.size_m <= high
        assert all(0.01 <= q <= 1 for q in answer.alternatives.values())
    assert right >= 52


def test_it_says_sure_only_when_it_is() -> None:
    rng = np.random.default_rng(2)
    seen = set()
    for k in range(60):
        perceiver = Perceiver(some_library(), error=0.02, most_touches=3)
        for update in feel_until_stopped(perceiver, world(list(OBJECTS.values())[k % 3], rng)):
            seen.add(update.verdict)
            best, p = next(iter(update.probability.items()))
            assert update.why
            assert "\n" not in update.why
            if update.verdict == "sure":
                assert p >= 0.98
                assert best in update.why
                assert f"{p:.4f}" in update.why
            if update.verdict == "enough":
                assert p < 0.98
                assert "3 touches were allowed" in update.why
    assert "sure" in seen


def test_a_stranger_is_none_of_these() -> None:
    rng, refused = np.random.default_rng(3), 0
    for _ in range(20):
        perceiver = Perceiver(some_library(), most_touches=3)
        updates = feel_until_stopped(perceiver, world(STRANGER, rng))
        answer = perceiver.answer()
        refused += answer.object == NONE_OF_THESE
        if answer.object == NONE_OF_THESE:
            assert updates[-1].verdict == "none of these"
            assert "no object of the library explains" in updates[-1].why
            assert answer.size_m is None
            assert answer.size_interval_m is None
            # One in ten is a stranger; of the others the p-value's share feels as odd.
            assert answer.probability == pytest.approx(0.1 / (0.1 + 0.9 * updates[-1].p_value))
            # The belief, were it one of the library's, is kept beside the answer.
            assert set(answer.alternatives) <= set(OBJECTS)
    assert refused >= 18


def test_it_never_stops_before_the_least_and_always_after_the_most_touches() -> None:
    rng = np.random.default_rng(4)
    for k in range(12):
        touches = world([*OBJECTS.values(), STRANGER][k % 4], rng)
        hasty = Perceiver(some_library(), error=0.9, least_touches=3, most_touches=3)
        verdicts = [hasty.feel(touch).verdict for touch in touches]
        assert verdicts[:2] == ["go on", "go on"]
        assert verdicts[2] != "go on"
        unsure = Perceiver(some_library(), error=1e-12, most_touches=2)
        assert len(feel_until_stopped(unsure, touches)) <= 2
        single = Perceiver(some_library(), most_touches=1)
        single.feel(touches[0])
        assert single.stopped


def test_it_wants_only_what_was_not_made() -> None:
    perceiver = Perceiver(some_library(), most_touches=9)
    made: list[str] = []
    evidence = {touch.touch: touch for touch in world(OBJECTS["box"], np.random.default_rng(5))}
    while (wanted := perceiver.next_touch()) is not None:
        assert wanted[0] not in made
        assert np.isfinite(wanted[1])
        made.append(wanted[0])
        perceiver.feel(evidence[wanted[0]])
    assert sorted(made) == sorted(TOUCHES)


def test_it_wants_only_what_can_be_done() -> None:
    perceiver = Perceiver(some_library())
    assert perceiver.next_touch([]) is None
    assert perceiver.next_touch(["unheard of"]) is None
    for touch in TOUCHES:
        wanted = perceiver.next_touch(["unheard of", touch])
        assert wanted is not None
        assert wanted[0] == touch


def test_what_costs_less_is_wanted_sooner() -> None:
    rng = np.random.default_rng(6)
    examples = {name: [world(middle, rng) for _ in range(20)] for name, middle in OBJECTS.items()}
    for cheap in TOUCHES:
        library = Library.from_examples(examples, costs={touch: 0.05 if touch == cheap else 1.0 for touch in TOUCHES})
        wanted = Perceiver(library).next_touch()
        assert wanted is not None
        assert wanted[0] == cheap


def test_an_unknown_touch_leaves_everything_as_it_was() -> None:
    perceiver = Perceiver(some_library(), least_touches=2)
    perceiver.feel(world(OBJECTS["box"], np.random.default_rng(7))[0])
    before, answer = perceiver.belief, perceiver.answer()
    with pytest.raises(InputError, match="the library knows no touch 'poke'; it knows grasp, higher, tip"):
        perceiver.feel(Evidence("poke", {"a": 1.0}))
    assert perceiver.belief is before
    assert perceiver.answer() == answer


def test_nothing_touched_is_no_answer() -> None:
    perceiver = Perceiver(some_library())
    assert not perceiver.stopped
    with pytest.raises(InputError, match="nothing was touched yet; feel at least one touch"):
        perceiver.answer()


def test_what_is_forgotten_is_forgotten() -> None:
    rng = np.random.default_rng(8)
    fresh, used = Perceiver(some_library()), Perceiver(some_library())
    feel_until_stopped(used, world(OBJECTS["cone"], rng))
    used.forget()
    touches = world(OBJECTS["box"], rng)
    assert feel_until_stopped(used, touches) == feel_until_stopped(fresh, touches)


def test_a_moved_object_may_be_felt_on() -> None:
    rng = np.random.default_rng(9)
    perceiver = Perceiver(some_library(), least_touches=2)
    perceiver.moved()
    perceiver.feel(world(OBJECTS["box"], rng)[0])
    perceiver.moved()
    update = perceiver.feel(world(OBJECTS["box"], rng)[1])
    assert next(iter(update.probability)) == "box"
    assert perceiver.belief.touches == ("grasp", "higher")


def test_reasons_name_the_objects_and_what_spoke() -> None:
    rng = np.random.default_rng(10)
    reasons = [
        reason for _ in range(10) for reason in Perceiver(some_library()).feel(world(OBJECTS["box"], rng)[0]).reasons
    ]
    assert any("the surfaces under the pads: for box against" in reason for reason in reasons)
    kept = Perceiver(some_library()).feel(Evidence("grasp", {"pad.thumb.curve": 2.5}, reasons=("round",))).reasons
    assert kept[0] == "round"


MISSING = {
    "a missing pad": ("pad.thumb.curve",),
    "no pads": ("pad.thumb.curve", "pad.palm.curve"),
    "no coordinates": ("fit.circle.off", "size.circle"),
    "no switches": ("switch.thumb",),
    "one pad alone": ("pad.palm.curve", "fit.circle.off", "size.circle", "switch.thumb"),
}


@pytest.mark.parametrize("what", MISSING)
@pytest.mark.parametrize("dead", [False, True])
def test_a_hand_that_lacks_something_still_answers_and_is_less_sure(what: str, dead: bool) -> None:
    rng = np.random.default_rng(11)
    doubt = np.zeros(2)
    for k in range(30):
        touch = world(list(OBJECTS.values())[k % 3], rng)[0]
        kept = {name: value for name, value in touch.values.items() if name not in MISSING[what]}
        if dead:
            kept |= dict.fromkeys(MISSING[what], float("nan"))
        for j, values in enumerate((touch.values, kept)):
            perceiver = Perceiver(some_library(), most_touches=1)
            p = np.array(list(perceiver.feel(Evidence("grasp", values)).probability.values()))
            assert p.sum() == pytest.approx(1)
            assert perceiver.answer().object in (*OBJECTS, NONE_OF_THESE)
            doubt[j] -= (p * np.log(np.maximum(p, 1e-300))).sum()
    assert doubt[1] >= doubt[0] - 0.5


@pytest.mark.parametrize("what", [*MISSING, "everything"])
def test_a_hand_that_lacks_something_does_not_refuse_what_it_knows(what: str) -> None:
    rng, refused = np.random.default_rng(12), 0
    for k in range(40):
        perceiver = Perceiver(some_library(), most_touches=2)
        for touch in world(list(OBJECTS.values())[k % 3], rng)[:2]:
            lost = MISSING.get(what, tuple(touch.values))
            perceiver.feel(Evidence(touch.touch, {n: v for n, v in touch.values.items() if n not in lost}))
        refused += perceiver.answer().object == NONE_OF_THESE
    assert refused <= 4


def test_a_touch_that_says_nothing_is_remarked_in_the_answer() -> None:
    perceiver = Perceiver(some_library(), least_touches=2)
    perceiver.feel(Evidence("grasp", {}, remarks=("the hand has no pads",)))
    remarks = perceiver.answer().remarks
    assert "the hand has no pads" in remarks
    assert any("nothing that the library knows was felt" in remark for remark in remarks)
    assert perceiver.answer().probability == pytest.approx(1 / 3)


def test_what_is_no_library_or_no_evidence_is_refused() -> None:
    with pytest.raises(InputError, match="library must be a Library, made by from_examples or read_library; got 'mine"):
        Perceiver("mine.npz")  # type: ignore[arg-type]
    perceiver = Perceiver(some_library())
    with pytest.raises(InputError, match="feel takes Evidence or NameEvidence, got dict"):
        perceiver.feel({"grasp": 1.0})  # type: ignore[arg-type]
    assert not perceiver.stopped
    with pytest.raises(InputError, match="remarks of touch 'grasp' must be a tuple of texts"):
        Evidence("grasp", {}, remarks="no pads")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"error": 0.0}, "error must lie between 0 and 1, got 0.0"),
        ({"error": 1.0}, "error must lie between 0 and 1, got 1.0"),
        ({"error": float("nan")}, "error must lie between 0 and 1, got nan"),
        ({"least_touches": 0}, "touches must be 1 <= least <= most, got least_touches=0, most_touches=4"),
        ({"least_touches": 5}, "touches must be 1 <= least <= most, got least_touches=5, most_touches=4"),
        ({"most_touches": 0}, "touches must be 1 <= least <= most"),
        ({"most_touches": 2.5}, "numbers of touches must be whole, got 2.5"),
        ({"error": "low"}, "error must lie between 0 and 1, got 'low'"),
    ],
)
def test_bad_settings_are_refused_in_one_line(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        Perceiver(some_library(), **options)
    assert "\n" not in str(refused.value)


@pytest.mark.skipif(not library_file._SHIPPED.is_file(), reason="no library of objects is shipped")
def test_the_shipped_library_takes_its_own_examples_with_and_without_pads() -> None:
    library = shipped_library()
    model = library.touches["grasp"]
    rng, right = np.random.default_rng(13), np.zeros(2)
    rows = rng.permutation(np.flatnonzero(model.made))[:20]
    for row in rows:
        full = dict(zip(model.metric.names, model.values[row].tolist(), strict=True))
        few = {name: value for name, value in full.items() if not name.startswith("pad.")}
        for k, values in enumerate((full, few)):
            update = Perceiver(library).feel(Evidence("grasp", values))
            assert sum(update.probability.values()) == pytest.approx(1)
            right[k] += next(iter(update.probability)) == library.objects[library.owner[row]]
    assert right[0] >= 18
    assert right[1] >= 10
