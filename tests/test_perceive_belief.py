"""The belief over objects, sizes and worlds, when it may stop, and what to touch next: laws and bad input."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.errors import InputError
from varishold.perceive import Belief, Evidence, Library, expected_information
from varishold.perceive.metric import Metric

OBJECTS = {"ball": (0.0, 0.0, 0.0), "box": (1.5, 0.0, 0.0), "cone": (0.0, 1.5, 1.0)}
TOUCHES = ("grasp", "higher", "tip")
SEEDS = st.integers(0, 2**32 - 1)


def world(middle: tuple[float, ...], rng: np.random.Generator, size_m: float) -> list[Evidence]:
    """What touches of one object in one world feel like: they share size and pose."""
    pose = rng.normal([0.0, 10 * (size_m - 0.07), 0.0], 0.5)
    return [
        Evidence(
            touch,
            {f"form.{k}": x for k, x in enumerate(np.add(middle, pose * (1 - k)) + rng.normal(0, 0.3, 3))}
            | {"size.circle": np.log(size_m) + rng.normal(0, 0.04)},
        )
        for k, touch in enumerate(TOUCHES)
    ]


@cache
def some_library(n: int = 40, *, seed: int = 0, others: int = 30, sized: bool = True) -> Library:
    rng = np.random.default_rng(seed)
    sizes = {name: rng.uniform(0.05, 0.1, n).tolist() for name in OBJECTS}
    return Library.from_examples(
        {name: [world(middle, rng, s) for s in sizes[name]] for name, middle in OBJECTS.items()},
        sizes_m=sizes if sized else None,
        others=[world((-3.0, 1.0, 2.0), rng, 0.07) for _ in range(others)],
    )


@pytest.fixture(scope="module", params=["sized", "without sizes"])
def library(request: pytest.FixtureRequest) -> Library:
    return some_library(sized=request.param == "sized")


@pytest.fixture(scope="module")
def sized() -> Library:
    return some_library()


def believe(library: Library, touches: list[Evidence]) -> Belief:
    belief = Belief.before(library)
    for touch in touches:
        belief = belief.after(touch)
    return belief


def only(evidence: Evidence, *names: str) -> Evidence:
    """A touch of which only some numbers are known."""
    return Evidence(evidence.touch, {name: value for name, value in evidence.values.items() if name in names})


def test_before_any_touch_every_object_is_alike(library: Library) -> None:
    belief = Belief.before(library)
    assert belief.probability == pytest.approx(dict.fromkeys(OBJECTS, 1 / 3))
    assert belief.p_value == 1.0
    assert not belief.atypical


def test_objects_of_which_more_is_known_are_not_likelier() -> None:
    rng = np.random.default_rng(1)
    library = Library.from_examples(
        {"a": [world((0, 0, 0), rng, 0.07) for _ in range(50)], "b": [world((0, 0, 0), rng, 0.07) for _ in range(5)]}
    )
    assert Belief.before(library).probability == pytest.approx({"a": 0.5, "b": 0.5})


@given(seed=SEEDS, scale=st.floats(0.1, 1e6))
@settings(max_examples=30)
def test_probabilities_sum_to_one_and_fall(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    belief = believe(some_library(8), world(tuple(rng.normal(0, scale, 3)), rng, 0.07))
    p = list(belief.probability.values())
    assert np.isfinite(p).all()
    assert sum(p) == pytest.approx(1)
    assert p == sorted(p, reverse=True)
    assert belief.particles.sum() == pytest.approx(1)
    assert 0 < belief.p_value <= 1
    assert belief.best == next(iter(belief.probability))


@given(seed=SEEDS, sized=st.booleans())
@settings(max_examples=15)
def test_the_order_of_touches_does_not_matter(seed: int, sized: bool) -> None:
    library = some_library(sized=sized)
    rng = np.random.default_rng(seed)
    touches = world(OBJECTS["box"], rng, 0.07)
    touches[1] = only(touches[1], "form.1")
    first, *others = (believe(library, list(order)) for order in permutations(touches))
    for belief in others:
        assert belief.probability == pytest.approx(first.probability, rel=1e-9, abs=1e-300)
        # Sums in another order may tie or not: one example of forty.
        assert belief.p_value == pytest.approx(first.p_value, abs=0.03)
        assert belief.size() == pytest.approx(first.size())


def test_a_belief_is_not_changed_by_what_comes_after(library: Library) -> None:
    rng = np.random.default_rng(2)
    before = believe(library, world(OBJECTS["box"], rng, 0.07)[:1])
    p, touches = dict(before.probability), before.touches
    before.after(world(OBJECTS["cone"], rng, 0.07)[1])
    assert (before.probability, before.touches) == (p, touches)


def test_the_number_of_examples_of_the_same_worlds_does_not_matter() -> None:
    """Every world twice is the same knowledge."""
    library = some_library(12, sized=False)
    twice = replace(
        library,
        owner=np.tile(library.owner, 2),
        log_size=np.tile(library.log_size, 2),
        touches={
            touch: replace(model, values=np.tile(model.values, (2, 1)), size_values=np.tile(model.size_values, (2, 1)))
            for touch, model in library.touches.items()
        },
    )
    touches = world((0.7, 0.3, 0.0), np.random.default_rng(3), 0.07)
    assert believe(twice, touches).probability == pytest.approx(believe(library, touches).probability, rel=1e-6)


def test_a_touch_of_which_nothing_is_known_changes_nothing_and_says_so(library: Library) -> None:
    rng = np.random.default_rng(4)
    before = believe(library, world(OBJECTS["box"], rng, 0.07)[:1])
    for nothing in (Evidence("tip", {}), Evidence("tip", {"form.0": float("nan"), "unheard of": 3.0})):
        after = before.after(nothing)
        assert after.probability == pytest.approx(before.probability, rel=1e-9)
        assert after.size() == pytest.approx(before.size())
        assert after.touches == ("grasp", "tip")
        assert any("tip" in remark and "nothing" in remark for remark in after.remarks)
    assert not before.remarks


def test_remarks_of_the_evidence_are_kept(library: Library) -> None:
    evidence = Evidence("grasp", {"form.0": 0.0}, remarks=("the thumb's pad is dead",))
    assert "the thumb's pad is dead" in Belief.before(library).after(evidence).remarks


def test_an_unknown_touch_is_refused_and_the_belief_stays(library: Library) -> None:
    before = believe(library, world(OBJECTS["box"], np.random.default_rng(5), 0.07)[:1])
    with pytest.raises(InputError, match="the library knows no touch 'poke'; it knows grasp, higher, tip"):
        before.after(Evidence("poke", {"form.0": 0.0}))
    assert before.touches == ("grasp",)
    with pytest.raises(InputError, match="the library knows no touch 'poke'"):
        expected_information(before, "poke")


@pytest.mark.parametrize("others", [0, 30])
@pytest.mark.parametrize("scale", [1.0, 1e3, 1e300])
def test_what_contradicts_every_object_is_odd(others: int, scale: float) -> None:
    library = some_library(others=others)
    far = {"form.0": 8.0 * scale, "form.1": -8.0 * scale, "form.2": 8.0 * scale}
    belief = Belief.before(library)
    for touch in TOUCHES:
        belief = belief.after(Evidence(touch, far | {"size.circle": 5.0 * scale}))
        p = list(belief.probability.values())
        assert np.isfinite(p).all()
        assert sum(p) == pytest.approx(1)
        assert belief.atypical
        size = belief.size()
        assert size is None or np.isfinite(size).all()


def test_touches_that_contradict_each_other_leave_finite_probabilities(library: Library) -> None:
    rng = np.random.default_rng(6)
    belief = Belief.before(library)
    for k in range(60):
        belief = belief.after(world(list(OBJECTS.values())[k % 3], rng, 0.07)[k % 3])
    p = list(belief.probability.values())
    assert np.isfinite(p).all()
    assert sum(p) == pytest.approx(1)


def test_ten_copies_of_a_touch_make_surer_of_the_same(library: Library) -> None:
    touch = world(OBJECTS["box"], np.random.default_rng(7), 0.07)[0]
    p = [believe(library, [touch] * n).probability for n in (1, 2, 10)]
    assert all(sum(q.values()) == pytest.approx(1) for q in p)
    assert next(iter(p[1])) == next(iter(p[2]))
    assert max(p[2].values()) >= max(p[1].values()) >= 1 / 3


@pytest.mark.parametrize("others", [0, 60])
@pytest.mark.parametrize("known", [("form.0", "form.1", "form.2"), ("form.0", "form.1"), ("form.0",), ()])
def test_known_objects_are_rarely_odd_whatever_is_missing(others: int, known: tuple[str, ...]) -> None:
    library = some_library(100, others=others)
    rng = np.random.default_rng(8)
    odd = np.zeros(2)
    for k in range(150):
        touches = world(list(OBJECTS.values())[k % 3], rng, rng.uniform(0.05, 0.1))[:2]
        touches = [only(touch, *known, "size.circle") for touch in touches]
        odd += [believe(library, touches[:1]).atypical, believe(library, touches).atypical]
    assert (odd / 150 <= 0.08).all()


def test_a_touch_that_says_nothing_does_not_make_odd(sized: Library) -> None:
    rng = np.random.default_rng(9)
    for k in range(30):
        before = believe(sized, world(list(OBJECTS.values())[k % 3], rng, 0.07)[:1])
        assert before.after(Evidence("tip", {})).p_value == pytest.approx(before.p_value)


def test_strangers_are_odd_more_often_than_known_objects(sized: Library) -> None:
    rng = np.random.default_rng(10)
    strange = [believe(sized, world((-3.0, 1.0, 2.0), rng, 0.07)).atypical for _ in range(30)]
    assert np.mean(strange) > 0.9


def test_a_moved_object_is_as_likely_as_before(library: Library) -> None:
    rng = np.random.default_rng(11)
    for middle in OBJECTS.values():
        belief = believe(library, world(middle, rng, 0.08)[:2])
        moved = belief.in_new_place()
        assert moved.probability == pytest.approx(belief.probability, abs=1e-6)
        assert moved.in_new_place().probability == pytest.approx(belief.probability, abs=1e-6)
        assert moved.touches == belief.touches
        assert moved.p_value == pytest.approx(belief.p_value)
        if belief.size() is not None:
            assert moved.size() == pytest.approx(belief.size(), rel=0.02)


def test_a_moved_objects_pose_is_unknown_again(library: Library) -> None:
    rng = np.random.default_rng(12)
    belief = believe(library, world(OBJECTS["box"], rng, 0.07)[:2])
    moved = belief.in_new_place()
    mine = library.owner == library.objects.index(belief.best)
    sharp, flat = (b.particles[mine] / b.particles[mine].sum() for b in (belief, moved))
    assert (flat**2).sum() < (sharp**2).sum()
    assert Belief.before(library).in_new_place().probability == pytest.approx(Belief.before(library).probability)


def test_sizes_are_told_with_an_interval_that_holds_them(sized: Library) -> None:
    rng = np.random.default_rng(13)
    held, off = [], []
    for k in range(90):
        size_m = rng.uniform(0.055, 0.095)
        size = believe(sized, world(list(OBJECTS.values())[k % 3], rng, size_m)).size()
        assert size is not None
        middle, low, high = size
        assert low <= middle <= high
        held.append(low <= size_m <= high)
        off.append(abs(middle / size_m - 1))
    assert np.mean(held) >= 0.85
    assert np.median(off) < 0.05


def test_a_touch_more_tells_the_size_better(sized: Library) -> None:
    rng = np.random.default_rng(14)
    widths = []
    for _ in range(20):
        touches = world(OBJECTS["ball"], rng, 0.07)
        sizes = [believe(sized, touches[:n]).size("ball") for n in (1, 3)]
        widths.append([np.log(size[2] / size[1]) for size in sizes if size is not None])
    one, three = np.mean(widths, axis=0)
    assert three < one


def test_only_what_tells_size_tells_the_size() -> None:
    library = some_library(sized=False)
    assert believe(library, world(OBJECTS["ball"], np.random.default_rng(15), 0.07)).size() is None
    for name in OBJECTS:
        assert Belief.before(library).size(name) is None


# Kernels of a library that makes its own evidence: two numbers a touch, Student's t with a scale of 1 about a world.
_FALL, _NUMBERS, _UNIT = 20.0, 2, 5.0


def generating_library(rng: np.random.Generator, worlds: int = 60) -> Library:
    """Objects that stand 2.5 apart with poses that scatter by 1, as much as the touches: they share their pose."""
    touches = [f"touch-{k}" for k in range(6)]

    def example(middle: float) -> list[Evidence]:
        pose = rng.normal(0, 1, _NUMBERS)
        return [Evidence(t, {"a": middle + pose[0], "b": pose[1]}) for t in touches]

    library = Library.from_examples({f"object-{k}": [example(2.5 * k) for _ in range(worlds)] for k in range(3)})
    freedom = _FALL - _NUMBERS
    metric = Metric(("a", "b"), np.zeros(2), np.full(2, _UNIT), np.eye(2) / _UNIT**2)
    models = {
        touch: replace(model, metric=metric, fall=_FALL, width=float(np.sqrt(freedom / _NUMBERS)))
        for touch, model in library.touches.items()
    }
    return replace(library, touches=models)


def test_when_it_stops_it_is_wrong_as_rarely_as_it_says() -> None:
    """A world must explain all touches; if each touch may have a world of its own, errors are as many times more."""
    rng = np.random.default_rng(16)
    library, error, freedom = generating_library(rng), 0.05, _FALL - _NUMBERS
    wrong: dict[str, list[bool]] = {"together": [], "one by one": []}
    for k in range(500):
        at = k % 3 * 60 + int(rng.integers(60))
        touches = []
        for touch, model in library.touches.items():
            off = rng.normal(0, 1, 2) / np.sqrt(rng.chisquare(freedom) / freedom)
            a, b = model.values[at] + off
            touches.append(Evidence(touch, {"a": a, "b": b}))
        for way, stopped in wrong.items():
            belief = Belief.before(library)
            for touch in touches:
                belief = belief.after(touch) if way == "together" else belief.in_new_place().after(touch)
                if belief.probability[belief.best] >= 1 - error:
                    stopped.append(belief.best != f"object-{k % 3}")
                    break
    assert len(wrong["together"]) > 150
    # Two standard deviations of so many draws.
    slack = 2 * np.sqrt(error * (1 - error) / len(wrong["together"]))
    assert np.mean(wrong["together"]) <= error + slack
    assert np.mean(wrong["one by one"]) > 2 * np.mean(wrong["together"])
    assert np.mean(wrong["one by one"]) > error + slack


def telling_library(*, apart: float = 6.0, unknown: int = 0) -> Library:
    """Two objects: one touch tells them apart, one feels the same in every world, one scatters and says nothing."""
    rng = np.random.default_rng(17)

    def example(middle: float) -> list[Evidence]:
        return [
            Evidence("telling", {"a": middle + rng.normal(0, 0.3), "b": rng.normal()}),
            Evidence("same", {"a": 1.0, "b": 2.0}),
            Evidence("scattered", {"a": rng.normal(), "b": rng.normal()}),
        ]

    examples = {"ball": [example(0.0) for _ in range(60)], "box": [example(apart) for _ in range(60)]}
    return Library.from_examples(examples)


def test_information_is_near_nothing_for_what_says_nothing_and_a_bit_for_what_tells_all() -> None:
    before = Belief.before(telling_library())
    gain = {touch: expected_information(before, touch) for touch in ("telling", "same", "scattered")}
    assert gain["same"] == pytest.approx(0, abs=1e-9)
    assert gain["scattered"] == pytest.approx(0, abs=0.08)
    assert 0.9 * np.log(2) < gain["telling"] <= np.log(2) + 1e-9


def test_information_grows_with_what_separates() -> None:
    gains = [expected_information(Belief.before(telling_library(apart=apart)), "telling") for apart in (0, 0.3, 1, 6)]
    assert gains == sorted(gains)


def test_who_knows_the_name_learns_nothing_more() -> None:
    library = telling_library()
    sure = believe(library, [Evidence("telling", {"a": 0.0, "b": 0.0})] * 8)
    assert max(sure.probability.values()) > 1 - 1e-6
    for touch in library.touches:
        assert expected_information(sure, touch) == pytest.approx(0, abs=1e-4)


@given(seed=SEEDS, touches=st.integers(0, 3), sized=st.booleans())
@settings(max_examples=20)
def test_information_lies_between_nothing_and_all_doubt(seed: int, touches: int, sized: bool) -> None:
    library = some_library(sized=sized)
    rng = np.random.default_rng(seed)
    belief = believe(library, world((rng.uniform(0, 1.5), 0.5, 0.5), rng, 0.07)[:touches])
    p = np.array(list(belief.probability.values()))
    doubt = -(p * np.log(np.maximum(p, 1e-300))).sum()
    for touch in library.touches:
        gain = expected_information(belief, touch)
        # Imagined outcomes are few, so that a gain may lie a little below nothing.
        assert -0.3 <= gain <= doubt + 1e-2
        assert gain == expected_information(belief, touch)


def test_information_says_how_much_doubt_goes() -> None:
    """On the whole: what is left of the doubt after touches of drawn worlds."""
    library = some_library(60, sized=False)
    rng = np.random.default_rng(18)
    before = Belief.before(library)
    left = []
    for k in range(150):
        touch = world(list(OBJECTS.values())[k % 3], rng, rng.uniform(0.05, 0.1))[0]
        p = np.array(list(before.after(touch).probability.values()))
        left.append(-(p * np.log(np.maximum(p, 1e-300))).sum())
    assert expected_information(before, "grasp") == pytest.approx(np.log(3) - np.mean(left), abs=0.15)


def test_a_touch_that_nobody_knows_of_the_likely_objects_tells_nothing() -> None:
    rng = np.random.default_rng(19)
    library = Library.from_examples(
        {
            "ball": [[Evidence("grasp", {"a": rng.normal()})] for _ in range(10)],
            "box": [
                [Evidence("grasp", {"a": 5 + rng.normal()}), Evidence("tip", {"a": rng.normal()})] for _ in range(10)
            ],
        }
    )
    belief = believe(library, [Evidence("grasp", {"a": 0.0})] * 3)
    assert expected_information(belief, "tip") == pytest.approx(0, abs=1e-6)
    # Nor does making it change the odds of objects of which it is not known.
    after = belief.after(Evidence("tip", {"a": 0.0}))
    assert np.isfinite(list(after.probability.values())).all()
    assert after.best == "ball"


# Touches that are made again


def posed_library(middles: np.ndarray, rng: np.random.Generator) -> Library:
    """Objects of which a touch feels the pose, and a little noise."""
    return Library.from_examples(
        {f"{k}": [[posed(middle, rng.normal(size=3), rng)] for _ in range(50)] for k, middle in enumerate(middles)}
    )


def posed(middle: np.ndarray, pose: np.ndarray, rng: np.random.Generator) -> Evidence:
    felt = middle + pose + rng.normal(0, 0.3, 3)
    return Evidence("grasp", {f"a{k}": value for k, value in enumerate(felt)})


def test_a_touch_that_is_made_again_in_the_same_place_makes_nobody_surer_than_right() -> None:
    rng, sure, right = np.random.default_rng(17), 0, 0
    for _ in range(4):
        middles = 1.5 * rng.normal(size=(4, 3))
        of = posed_library(middles, rng)
        for n in range(100):
            pose = rng.normal(size=3)
            belief = Belief.before(of)
            for _ in range(5):
                belief = belief.after(posed(middles[n % 4], pose, rng))
            sure += belief.probability[belief.best] > 0.95
            right += belief.probability[belief.best] > 0.95 and belief.best == str(n % 4)
    assert sure > 40
    assert right >= 0.95 * sure


@pytest.mark.parametrize("seed", range(4))
def test_copies_of_a_touch_say_what_it_says_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    of = posed_library(1.5 * rng.normal(size=(4, 3)), rng)
    grasp = posed(rng.normal(size=3), rng.normal(size=3), rng)
    once = Belief.before(of).after(grasp)
    for n in (2, 7):
        assert believe(of, [grasp] * n).probability == pytest.approx(once.probability)
    # Another place is another touch, and what was felt before the move stays as it was.
    moved = once.in_new_place()
    assert moved.after(grasp).after(grasp).probability == pytest.approx(moved.after(grasp).probability)
    assert max(moved.after(grasp).probability.values()) > max(once.probability.values())


@pytest.mark.parametrize("seed", range(4))
def test_sensors_that_speak_one_after_another_are_one_touch_in_any_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    of = posed_library(1.5 * rng.normal(size=(4, 3)), rng)
    whole = posed(rng.normal(size=3), rng.normal(size=3), rng)
    parts = [only(whole, "a0"), only(whole, "a1", "a2")]
    both = believe(of, parts)
    says = {name: believe(of, [part]).log_weight for name, part in zip("ab", parts, strict=True)}
    np.testing.assert_allclose(both.log_weight, says["a"] + says["b"], atol=1e-9)
    felt = [*parts, whole, only(whole, "a1")]
    first = believe(of, felt)
    for order in ([3, 1, 0, 2], [2, 0, 3, 1], [1, 3, 2, 0]):
        assert believe(of, [felt[k] for k in order]).probability == pytest.approx(first.probability)
