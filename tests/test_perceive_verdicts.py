"""When a perceiver stops, what it answers and wants next, and what it gives as reasons: against plain rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.perceive import NONE_OF_THESE, Belief, Evidence, Library, NameEvidence, Perceiver, expected_information
from varishold.perceive.reasons import reasons_of

SEEDS = st.integers(0, 2**32 - 1)
WORDS = {
    "fit.": "how sections fit the grip",
    "switch.": "the switches",
    "pad.": "the surfaces under the pads",
    "form.": "round or angular on the whole",
    "tip.": "the fingertip's height",
    "load.": "its other numbers",
}


@cache
def library(n: int = 30) -> Library:
    rng = np.random.default_rng(2)
    middles = {"ball": 0.0, "box": 1.2, "cone": -1.5}

    def example(middle: float) -> list[Evidence]:
        of = [middle, 0.7 * middle, 0.4 * middle, -middle, 0.1 * middle, 2 * middle]
        numbers = {f"{start}a": x for start, x in zip(WORDS, of + rng.normal(0, 1, 6), strict=True)}
        tip = Evidence("tip", {"tip.a": middle + rng.normal()})
        return [Evidence("grasp", numbers), tip]

    return Library.from_examples(
        {name: [example(middle) for _ in range(n)] for name, middle in middles.items()},
        others=[example(3.0) for _ in range(20)],
        costs={"tip": 0.5},
    )


@dataclass
class Told:
    """A belief that says what it is told to, whatever is felt."""

    probability: dict[str, float]
    p_value: float
    atypical: bool
    inside: float
    touches: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ("odd",)
    seen: NameEvidence | None = None
    looks_usual: bool = False
    pose: str | None = None

    @property
    def p_value_with_sight(self) -> float:
        return self.p_value

    @property
    def believed(self) -> dict[str, float]:
        return self.probability

    @property
    def best(self) -> str:
        return next(iter(self.probability))

    @property
    def said(self) -> tuple[str, float]:
        return self.best, self.probability[self.best]

    def after(self, _: object) -> Told:
        return self

    def size(self, _: str | None = None) -> tuple[float, float, float]:
        return 0.07, 0.06, 0.08


HEARD = NameEvidence("camera", {"ball": 0.5, "box": 0.5})


def believing(perceiver: Perceiver, **said: Any) -> Perceiver:
    p = said.pop("p", 0.999)
    given = {"probability": {"ball": p, "box": 1 - p}, "p_value": 0.9, "atypical": False, "inside": 90.0} | said
    perceiver.belief = Told(**given)  # type: ignore[assignment]
    return perceiver


def verdict(
    n: int,
    p: float,
    p_value: float,
    odd: str,
    least: int,
    most: int,
    refuse: bool,
    error: float,
    *,
    seen: bool,
    looks_usual: bool,
) -> str:
    """What the class says: never before the least, always at the most, sure only of what is typical."""
    if n < least:
        return "go on"
    if odd == "atypical" and refuse:
        return "none of these" if (n >= 2 and not looks_usual) or n >= most else "go on"
    if p >= 1 - error and odd == "":
        usual = 0.05 if seen else {1: 0.5, 2: 0.15}.get(n, 0.05)
        if n >= most or not refuse or p_value > usual:
            return "sure"
        return "go on"
    return "enough" if n >= most else "go on"


@pytest.mark.parametrize("refuse", [True, False])
@pytest.mark.parametrize(("least", "most"), [(1, 1), (1, 2), (1, 4), (2, 3), (3, 3), (3, 5)])
def test_it_stops_by_the_rule_that_it_states(refuse: bool, least: int, most: int) -> None:
    p_values = (0.049, 0.05, 0.051, 0.149, 0.15, 0.151, 0.499, 0.5, 0.501, 1.0)
    for p, p_value, odd, error, (seen, looks_usual) in product(
        (0.6, 0.949, 0.95, 0.995),
        p_values,
        ("", "beyond", "atypical"),
        (0.05, 0.01),
        ((None, False), (HEARD, False), (HEARD, True)),
    ):
        perceiver = Perceiver(library(), error=error, least_touches=least, most_touches=most, refuse=refuse)
        said = {"p": p, "p_value": p_value, "atypical": odd == "atypical", "inside": 1.0 if odd else 1.01}
        believing(perceiver, **said, seen=seen, looks_usual=looks_usual)
        for n in range(1, most + 1):
            update = perceiver.feel(HEARD)
            expected = verdict(
                n, p, p_value, odd, least, most, refuse, error, seen=seen is not None, looks_usual=looks_usual
            )
            assert update.verdict == expected, (n, p, p_value, odd)
            assert perceiver.stopped == (expected != "go on")
            assert (update.size_m, update.size_interval_m) == (0.07, (0.06, 0.08))
            often = f"{100 * p_value:.3g} % of its own examples conform no better"
            words = {
                "sure": f"ball with probability {p:.4f}, and {often}",
                "none of these": f"no object of the library explains the touches: {often}",
                "enough": f"allowed; ball with probability {p:.2f}",
            }
            assert words.get(expected, "") in update.why
            if n < least:
                assert update.why == f"at least {least} touches are asked for"


def test_why_it_goes_on_is_told() -> None:
    cases = [
        ({"p": 0.61}, "ball 0.61 against box 0.39"),
        ({"p_value": 0.4}, "ball, were it one of these; but 40 % of its own examples conform no better"),
        ({"p_value": 0.004, "atypical": True}, "atypical for a ball: 0.4 % of its own examples"),
        ({"inside": 0.5}, "ball, were it one of these"),
    ]
    for said, why in cases:
        update = believing(Perceiver(library()), **said).feel(HEARD)
        assert (update.verdict, why in update.why) == ("go on", True), update.why
    for most, words in ((1, "1 touch was allowed"), (2, "2 touches were allowed")):
        perceiver = believing(Perceiver(library(), most_touches=most), p=0.6)
        assert words in [perceiver.feel(HEARD) for _ in range(most)][-1].why
    alone = believing(Perceiver(library()), probability={"ball": 0.5}).feel(HEARD)
    assert alone.verdict == "go on"


def test_defaults_are_one_to_four_touches_an_error_of_a_hundredth_and_that_it_may_refuse() -> None:
    perceiver = Perceiver(library())
    assert (perceiver.error, perceiver.least_touches, perceiver.most_touches) == (0.01, 1, 4)
    assert (perceiver.refuse, perceiver.prior) == (True, None)
    for bad in ({"error": 0.0}, {"error": 1.0}, {"least_touches": 0}, {"least_touches": 5}, {"most_touches": 0}):
        with pytest.raises(ValueError, match=r"must (lie|be)"):
            Perceiver(library(), **bad)
    assert Perceiver(library(), least_touches=4, error=1e-9).least_touches == 4


@pytest.mark.parametrize("refuse", [True, False])
def test_the_answer_is_the_last_update_and_others_of_a_hundredth(refuse: bool) -> None:
    shares = {"ball": 0.9, "box": 0.0801, "cone": 0.01, "egg": 0.0099}
    perceiver = believing(Perceiver(library(), refuse=refuse), probability=shares)
    update = perceiver.feel(HEARD)
    answer = perceiver.answer()
    assert (answer.object, answer.probability, answer.alternatives) == ("ball", 0.9, {"box": 0.0801, "cone": 0.01})
    assert (answer.size_m, answer.size_interval_m) == (0.07, (0.06, 0.08))
    assert (answer.trace, answer.remarks) == ((update,), ("odd",))
    # While it goes on, what is atypical is none of these, unless it may not be.
    doubted = believing(
        Perceiver(library(), refuse=refuse), probability=shares, atypical=True, inside=0.5, p_value=0.004
    )
    assert doubted.feel(HEARD).verdict == "go on"
    answer = doubted.answer()
    if refuse:
        assert (answer.object, answer.probability) == (NONE_OF_THESE, pytest.approx(0.1 / (0.1 + 0.9 * 0.004)))
        assert (answer.size_m, answer.size_interval_m) == (None, None)
        assert answer.alternatives == {"ball": 0.9, "box": 0.0801, "cone": 0.01}
    else:
        assert (answer.object, answer.size_m) == ("ball", 0.07)


def test_a_failure_is_said_once_and_moves_the_object() -> None:
    rng = np.random.default_rng(0)
    rows = [
        [
            Evidence("grasp", {"a": k + rng.normal()}),
            Evidence("tip", {"a": 0.0}) if k else Evidence("tip", {}, failed=True),
        ]
        for k in (0, 1)
        for _ in range(10)
    ]
    of = Library.from_examples({"ball": rows[:10], "box": rows[10:]})
    perceiver = Perceiver(of)
    before = Belief.before(of)
    perceiver.failed("poke")
    assert perceiver.belief.probability == pytest.approx(before.probability)
    perceiver.failed("tip")
    once = perceiver.belief
    assert once.probability == pytest.approx({"ball": 0.9, "box": 0.1})
    assert once.touches == ("tip",)
    perceiver.failed("tip")
    assert perceiver.belief.probability == pytest.approx(once.probability)
    # The pose that the particles share is unknown again.
    assert not perceiver.belief.log_weight.any()
    assert not perceiver.stopped


def powered(*powers: Sequence[float]) -> Library:
    of = library()
    touches = {
        name: replace(model, power=np.array(power))
        for (name, model), power in zip(of.touches.items(), powers, strict=True)
    }
    return replace(of, touches=touches)


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.floats(0.05, 20))
def test_the_next_touch_tells_most_for_its_cost(seed: int, cost: float) -> None:
    of = library()
    of = replace(of, touches=of.touches | {"tip": replace(of.touches["tip"], cost=cost)})
    perceiver, rng = Perceiver(of), np.random.default_rng(seed)
    perceiver.belief = perceiver.belief.after(Evidence("grasp", {"form.a": rng.normal()}))
    gains = {name: expected_information(perceiver.belief, name) for name in of.touches}
    best = max(gains, key=lambda name: gains[name] / (cost if name == "tip" else 1.0))
    assert perceiver.next_touch(of.touches) == (best, gains[best])
    assert perceiver.next_touch() == ("tip", gains["tip"])
    assert perceiver.next_touch(["poke"]) is None
    assert perceiver.next_touch([]) is None


def test_who_is_sure_of_the_name_asks_what_would_reveal_another_thing() -> None:
    # Powers of ball, box and cone; the tip costs a half.
    cases = [
        ([0.5, 0, 0], [0.3, 0, 0], "tip"),
        ([0.5, 0, 0], [0.2, 0, 0], "grasp"),
        ([0.5, 0, 0], [np.nan, 1, 1], "grasp"),
        ([np.nan, 1, 1], [0.01, 0, 0], "tip"),
    ]
    for grasp, tip, wanted in cases:
        perceiver = Perceiver(powered(grasp, tip))
        perceiver.belief = perceiver.belief.after(NameEvidence("eye", {"ball": 0.9999, "box": 5e-5, "cone": 5e-5}))
        while next(iter(perceiver.belief.probability.values())) < 0.99:
            perceiver.feel(NameEvidence("camera", {"ball": 0.9999, "box": 5e-5, "cone": 5e-5}))
        perceiver.feel(NameEvidence("camera", {"ball": 0.9999, "box": 5e-5, "cone": 5e-5}))
        best = perceiver.next_touch(("grasp", "tip"))
        assert best == (wanted, expected_information(perceiver.belief, wanted))
        # Before anything is felt, the name is not taken for sure: what tells the name is asked.
        perceiver = Perceiver(powered(grasp, tip))
        gains = {name: expected_information(perceiver.belief, name) for name in ("grasp", "tip")}
        assert perceiver.next_touch() == max(
            ((name, gain) for name, gain in gains.items()), key=lambda one: one[1] / (0.5 if one[0] == "tip" else 1)
        )


# Reasons


def parts_of(evidence: Evidence, belief: Belief, asked: int = 80) -> dict[str, float]:
    """What the log-odds of the two likeliest lose without each part: from all examples, or the likeliest of many."""
    of, names = belief.library, list(belief.probability)[:2]
    model = of.touches[evidence.touch]
    values = evidence.vector(model.metric.names)

    def odds(values: np.ndarray) -> float:
        out = []
        for name in names:
            own = np.flatnonzero(of.owner == of.objects.index(name))
            own = own[np.argsort(belief.log_weight[own])[::-1][:asked]]
            out.append(np.logaddexp.reduce(model.log_kernel(values)[own]) - np.log(len(own)))
        return float(out[0] - out[1])

    groups = [start for start in WORDS if any(name.startswith(start) for name in evidence.values)]
    if len(groups) == 1:
        return {groups[0]: odds(values)}
    whole = odds(values)
    without = [np.array([name.startswith(start) for name in model.metric.names]) for start in groups]
    return {start: whole - odds(np.where(mask, np.nan, values)) for start, mask in zip(groups, without, strict=True)}


def words(log_odds: float) -> str:
    """A factor with one decimal below 55, whole below 8103, then its power of ten."""
    factor = float(np.exp(min(abs(log_odds), 30.0)))
    return f"{factor:.1f}" if factor < np.exp(4) else f"{factor:.0f}" if factor <= np.exp(9) else f"{factor:.0e}"


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sets(st.sampled_from(list(WORDS)), min_size=1), st.floats(1, 20), st.sampled_from([30, 120]))
def test_reasons_are_what_the_odds_lose_without_each_part(seed: int, starts: set[str], power: float, n: int) -> None:
    rng, of = np.random.default_rng(seed), library(n)
    model = of.touches["grasp"]
    # The steeper the kernel, the larger the factors.
    of = replace(of, touches=of.touches | {"grasp": replace(model, fall=model.fall * power)})
    evidence = Evidence("grasp", {f"{start}a": rng.normal(0, 1.5) for start in WORDS if start in starts})
    after = Belief.before(of).after(evidence)
    first, second = list(after.probability)[:2]
    parts = sorted(parts_of(evidence, after).items(), key=lambda part: -abs(part[1]))
    told = reasons_of(evidence, after)
    expected = [
        (f"{WORDS[start]}: for {first if said > 0 else second} against {second if said > 0 else first}", abs(said))
        for start, said in parts
        if abs(said) >= 0.3
    ]
    assert [text.split(" by a factor of ")[0] for text in told] == [text for text, _ in expected]
    factors = [float(text.split(" by a factor of ")[1]) for text in told]
    # One figure after the point, or one figure in all.
    for factor, (_, said) in zip(factors, expected, strict=True):
        assert factor == pytest.approx(np.exp(min(said, 30.0)), rel=0.02 if said < 8.9 else 0.51, abs=0.051)


def test_a_factor_is_told_in_few_figures_and_a_small_one_not_at_all() -> None:
    """Two examples, one number: what is said is the ratio of two kernels."""
    of = Library.from_examples(
        {"a": [[Evidence("t", {"form.x": x})] for x in (0.0, 0.1)], "b": [[Evidence("t", {"form.x": 5.0})]]}
    )
    model = of.touches["t"]
    evidence = Evidence("t", {"form.x": 0.05})
    ratio = parts_of(evidence, Belief.before(of).after(evidence))["form."] / model.fall
    seen = set()
    for wanted in (0.29, 0.31, 0.69315, 3.9, 4.05, 8.9, 9.1, 13.8, 29.0, 31.0, 60.0):
        other = replace(of, touches={"t": replace(model, fall=wanted / ratio)})
        told = reasons_of(evidence, Belief.before(other).after(evidence))
        assert told == (
            (f"round or angular on the whole: for a against b by a factor of {words(wanted)}",) if wanted > 0.3 else ()
        )
        seen.update(text.split()[-1] for text in told)
    assert {"2.0", "49.4", "57", "7332", "9e+03", "1e+06", "4e+12", "1e+13"} <= seen
    assert reasons_of(Evidence("t", {}), Belief.before(of)) == ()
    alone = of.only(["a"])
    assert reasons_of(evidence, Belief.before(alone).after(evidence)) == ()
    two = reasons_of(evidence, Belief.before(of.only(["b", "a"])).after(evidence))
    assert all("for a against b" in text for text in two)


def test_objects_that_were_never_touched_so_give_no_reasons() -> None:
    rows = {
        "a": [[Evidence("t", {"x": 0.1 * k})] for k in range(5)],
        "b": [[Evidence("u", {"x": 0.1 * k})] for k in range(5)],
    }
    of = Library.from_examples(rows)
    evidence = Evidence("t", {"x": 0.0})
    assert reasons_of(evidence, Belief.before(of).after(evidence)) == ()
