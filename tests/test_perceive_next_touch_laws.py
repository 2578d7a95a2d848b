"""What a touch is worth, with answers on paper; which is asked for next; and why it goes on."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from varishold.perceive import Belief, Evidence, Library, NameEvidence, Perceiver, expected_information, perceiver
from varishold.perceive.next_touch import _imagined, _thinned, time_until_sure
from varishold.perceive.reasons import reasons_of
from varishold.perceive.touch_model import TouchModel


def entropy(*p: float) -> float:
    return -sum(x * np.log(x) for x in p if x > 0)


def slips(values: list[float | None]) -> list[list[Evidence]]:
    """Examples of a tip, and of a grasp that says nothing; None where the tip failed, NaN where it was not tried."""
    grasp = Evidence("grasp", {"a": 0.0})
    tips = [Evidence("tip", {}, failed=True) if x is None else Evidence("tip", {"b": x}) for x in values]
    return [[grasp] if x is not None and np.isnan(x) else [grasp, tip] for x, tip in zip(values, tips, strict=True)]


def test_a_touch_that_tells_all_where_it_succeeds_leaves_the_doubt_of_its_failures() -> None:
    rng = np.random.default_rng(0)
    ball = [*rng.normal(0, 1, 12), *[None] * 4]
    box = [*rng.normal(80, 1, 8), *[None] * 8]
    of = Library.from_examples({"ball": slips(ball), "box": slips(box)})
    fails = np.array([12 * 0.1 + 4 * 0.9, 8 * 0.1 + 8 * 0.9]) / 16
    doubt = fails.sum() / 2 * entropy(*(fails / fails.sum()))
    assert expected_information(Belief.before(of), "tip") == pytest.approx(np.log(2) - doubt, rel=0.01)
    # Of what was never felt so a success says as much as a success of the others.
    never = of.with_object("can", slips([float("nan")] * 5))
    worth = expected_information(Belief.before(never), "tip")
    assert 0 < worth < np.log(3)


def test_a_name_is_worth_nothing_more_where_one_example_alone_is_believed() -> None:
    of = Library.from_examples({"ball": slips([0.0, 1.0]), "box": slips([5.0, 6.0])})
    alone = replace(Belief.before(of), log_weight=np.array([0.0, -1e4, -1e4, -1e4]))
    assert expected_information(alone, "tip") == 0.0
    # One example of each, neither of which can be explained by another of its own.
    pair = replace(Belief.before(of), log_weight=np.array([0.0, -1e4, 0.0, -1e4]))
    assert 0.0 <= expected_information(pair, "tip") <= np.log(2)
    untold = Library.from_examples({"ball": slips([0.0, 1.0]), "box": slips([float("nan")] * 2)})
    sure = replace(Belief.before(untold), log_weight=np.array([-1e4, -1e4, 0.0, 0.0]))
    assert expected_information(sure, "tip") == 0.0


def test_a_touch_that_is_made_again_where_the_object_lies_tells_nothing_more() -> None:
    rng = np.random.default_rng(0)
    both = {
        name: [
            [Evidence("grasp", {"a": rng.normal(at, 1)}), Evidence("tip", {"b": rng.normal(at, 2)})] for _ in range(9)
        ]
        for name, at in (("ball", 0.0), ("box", 1.0))
    }
    some = Perceiver(Library.from_examples(both), refuse=False)
    some.feel(Evidence("grasp", {"a": 0.5}))
    assert expected_information(some.belief, "grasp") == 0.0
    assert expected_information(some.belief, "tip") > 0
    # Whichever is named first.
    assert some.next_touch(["grasp", "tip"]) == some.next_touch(["tip", "grasp"]) == some.next_touch(["tip"])
    assert some.next_touch(["grasp"]) == ("grasp", 0.0)
    # Elsewhere it errs anew.
    some.moved()
    assert expected_information(some.belief, "grasp") > 0


def test_a_touch_that_was_felt_in_part_may_bring_news() -> None:
    rng = np.random.default_rng(0)
    both = {
        name: [[Evidence("grasp", {"a": rng.normal(at, 1), "b": rng.normal(at, 1)})] for _ in range(9)]
        for name, at in (("ball", 0.0), ("box", 1.0))
    }
    half = Belief.before(Library.from_examples(both)).after(Evidence("grasp", {"a": 0.5}))
    assert expected_information(half, "grasp") > 0
    assert expected_information(half.after(Evidence("grasp", {"b": 0.5})), "grasp") == 0.0


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("slipped", [0, 5])
def test_the_worth_is_the_loss_of_entropy_over_outcomes_that_the_particles_stand_for(seed: int, slipped: int) -> None:
    rng = np.random.default_rng(seed)
    middles = rng.permutation(3) * 2.0
    rows: list[list[float | None]] = [
        [*rng.normal(m, 1, 10 - slipped * (k > 0)), *[None] * (slipped * (k > 0))] for k, m in enumerate(middles)
    ]
    of = Library.from_examples({f"o{k}": slips(values) for k, values in enumerate(rows)})
    belief = replace(Belief.before(of), log_weight=rng.normal(0, 1.5, len(of)))
    model, p = of.touches["tip"], belief.particles
    fails = np.where(model.failed, 0.9, 0.1) if slipped else np.zeros(len(of))
    now = np.array([p[of.owner == k].sum() for k in range(3)])
    lost = np.array([(p * fails)[of.owner == k].sum() for k in range(3)])
    # What succeeds is shared by the examples in which it did.
    share = np.where(model.made, p, 0.0)
    for k in range(3):
        share[of.owner == k] *= (now - lost)[k] / share[of.owner == k].sum()
    share /= share.sum()
    order = sorted(np.flatnonzero(share), key=lambda i: -share[i])
    ends = np.cumsum(share[order])
    left = 0.0
    for outcome in range(48):
        at = next(i for i, end in zip(order, ends, strict=True) if end > (outcome + 0.5) / 48)
        like = np.exp(np.nan_to_num(model.log_kernel(model.values[at]), nan=-1e9))
        like[at] = 0.0
        after = np.zeros(3)
        for k in range(3):
            rest = (of.owner == k) & (np.arange(len(of)) != at)
            after[k] = share[of.owner == k].sum() * (share @ (like * rest)) / share[rest].sum()
        left += entropy(*(after / after.sum())) / 48
    left *= 1 - lost.sum()
    left += lost.sum() * entropy(*(lost / lost.sum())) if slipped else 0.0
    assert entropy(*now) - left > 0.01
    assert expected_information(belief, "tip") == pytest.approx(entropy(*now) - left, rel=1e-4)


def test_of_many_examples_that_are_as_likely_some_of_every_object_are_weighed() -> None:
    """Five hundred are; the likeliest alone would be those of the first objects."""
    n_objects, each = 10, 300
    owner = np.repeat(np.arange(n_objects), each)
    values = 9.0 * owner + np.random.default_rng(1).normal(0, 0.1, owner.size)
    told = expected_information(belief_over(values, owner, np.zeros(owner.size)), "tip")
    assert told == pytest.approx(np.log(n_objects), rel=0.01)
    alike = expected_information(belief_over(values % 9, owner, np.zeros(owner.size)), "tip")
    assert alike < 0.05


@pytest.mark.parametrize(("n", "most"), [(3000, 500), (3000, 7), (501, 500), (40, 1), (40, 40), (40, 60)])
@pytest.mark.parametrize("heavy", [0, 1, 3])
def test_examples_that_are_left_stand_for_all(n: int, most: int, heavy: int) -> None:
    rng = np.random.default_rng(n + most)
    weight = rng.exponential(1, n) ** (1 + heavy)
    weight[rng.permutation(n)[: n // 9]] = 0.0
    rows, share = _thinned(weight, most)
    assert len(rows) == len(set(rows.tolist())) <= most
    assert share.sum() == pytest.approx(1)
    assert (weight[rows] > 0).all()
    truth = weight / weight.sum()
    # Those that are heavier than the lightest that is left are as they were; the others are all of one weight.
    same = np.isclose(share, truth[rows], rtol=1e-9)
    assert np.ptp(share[~same]) < 1e-12 if (~same).any() else len(rows) == np.count_nonzero(weight)
    # The cumulated shares are nowhere farther off than half of one that is left.
    thinned = np.zeros(n)
    thinned[rows] = share
    off = np.abs(np.cumsum(thinned) - np.cumsum(truth)).max()
    assert off <= (share[~same].max() if (~same).any() else 0) + 1e-9


def belief_over(values: np.ndarray, owner: np.ndarray, log_weight: np.ndarray) -> Any:
    n = len(owner)
    white = (values[:, None]).astype(np.float32)
    particles = np.exp(log_weight) / np.exp(log_weight).sum()

    def kernel(squares: np.ndarray, known: int) -> np.ndarray:
        assert known == 1
        return -squares

    model = SimpleNamespace(failed=np.zeros(n, bool), made=np.ones(n, bool), white=white, kernel=kernel)

    class Of:
        touches, objects = {"tip": model}, tuple(str(k) for k in np.unique(owner))

        def __init__(self) -> None:
            self.owner = self.kind = owner

        def __len__(self) -> int:
            return n

    return SimpleNamespace(library=Of(), particles=particles, here={})


@pytest.mark.parametrize("own", [1.0, 0.6])
@pytest.mark.parametrize(("more", "off"), [([], 1e-6), ([None, None, float("nan")], 0.03)])
def test_what_is_imagined_of_an_outcome_is_what_is_believed_of_it(
    own: float, more: list[float | None], off: float
) -> None:
    rng = np.random.default_rng(3)
    felt = {name: slips([*rng.normal(k, 1, 12), *more]) for k, name in enumerate(("ball", "box", "can"))}
    library = Library.from_examples(felt).tempered(1.0, own=own)
    imagined = _imagined(library, Belief.before(library).particles, 500)
    assert imagined is not None
    tip = library.touches["tip"]
    for drawn, names in zip(imagined.rows[imagined.drawn], imagined.names_after(imagined.weighed(tip)), strict=True):
        if not (tip.made | tip.failed)[drawn]:
            continue
        outcome = Evidence("tip", {"b": tip.values[drawn, 0]} if tip.made[drawn] else {}, failed=tip.failed[drawn])
        # It never explains its own.
        others = library.of_examples(np.arange(len(library)) != drawn, [0, 1, 2])
        believed = Belief.before(others).after(outcome).probability
        assert names == pytest.approx([believed[name] for name in library.objects], abs=off)


def test_two_touches_are_looked_ahead_where_no_example_knows_all() -> None:
    def felt(k: int, j: int) -> list[Evidence]:
        row = [Evidence(t, {t: 10.0 * k + 0.1 * j}) for t in ("tip", "rub", "poke")]
        return [each for n, each in enumerate(row) if n != j % 3]

    library = Library.from_examples({name: [felt(k, j) for j in range(12)] for k, name in enumerate(("ball", "box"))})
    ahead = time_until_sure(Belief.before(library), {"tip": 3.0, "rub": 2.0, "poke": 4.0}, 0.01)
    assert min(ahead, key=lambda touch: ahead[touch][0]) == "rub"


# Which touch is next


def asked(
    monkeypatch: pytest.MonkeyPatch,
    powers: tuple[float, float],
    gains: tuple[float, float],
    *,
    p: float = 0.999,
    error: float = 0.01,
    felt: bool = True,
) -> str:
    """Which of two touches is asked for next; the second costs half."""
    rows = {
        name: [[Evidence("grasp", {"a": float(k)}), Evidence("tip", {"a": 0.0})] for k in range(3)] for name in "ab"
    }
    of = Library.from_examples(rows, costs={"tip": 0.5})

    def powered(model: TouchModel, power: float) -> TouchModel:
        return replace(model, power=np.array([power, 0.9]))

    of = replace(of, touches={t: powered(m, w) for (t, m), w in zip(of.touches.items(), powers, strict=True)})
    one = Perceiver(of, error=error)
    worth = dict(zip(("grasp", "tip"), gains, strict=True))
    monkeypatch.setattr(perceiver, "expected_information", lambda _, touch: worth[touch])
    if felt:
        one.feel(NameEvidence("camera", {"a": 0.5, "b": 0.5}))
    one.belief = replace(one.belief, log_weight=np.log(np.repeat([p, 1 - p], 3)))
    best = one.next_touch()
    assert best is not None
    assert best[1] == worth[best[0]]
    return best[0]


def test_power_counts_where_the_name_is_sure_and_some_touch_has_any(monkeypatch: pytest.MonkeyPatch) -> None:
    by_gain, by_power = (0.9, 0.1), (0.1, 0.3)
    assert asked(monkeypatch, by_power, by_gain) == "tip"
    # Not before anything was felt, nor while the name is in doubt, nor where none would tell another thing.
    assert asked(monkeypatch, by_power, by_gain, felt=False) == "grasp"
    assert asked(monkeypatch, by_power, by_gain, p=0.6) == "grasp"
    assert asked(monkeypatch, (0.0, 0.0), (0.1, 0.3)) == "tip"
    assert asked(monkeypatch, (np.nan, 0.0), (0.1, 0.3)) == "tip"
    # In doubt what tells the name for its cost.
    assert asked(monkeypatch, (0.3, 0.1), (0.3, 0.16), p=0.6) == "tip"
    assert asked(monkeypatch, (0.3, 0.1), (0.3, 0.14), p=0.6) == "grasp"


@pytest.mark.parametrize(("p", "named"), [(0.74, False), (0.75, True), (0.76, True)])
def test_a_name_is_sure_from_one_less_the_error(monkeypatch: pytest.MonkeyPatch, p: float, named: bool) -> None:
    assert asked(monkeypatch, (0.1, 0.9), (0.9, 0.1), p=p, error=0.25) == ("tip" if named else "grasp")


def test_why_it_goes_on_names_the_first_two() -> None:
    rows = {name: [[Evidence("t", {"a": float(k)})] for k in range(4)] for name in ("ball", "box", "can")}
    update = Perceiver(Library.from_examples(rows)).feel(NameEvidence("eye", {"box": 0.6, "can": 0.3, "ball": 0.1}))
    assert update.why == "box 0.60 against can 0.30"
    told: Any = SimpleNamespace(
        probability={"ball": 0.5}, p_value=0.9, atypical=False, inside=9.0, after=lambda _: told, touches=()
    )
    told.seen, told.p_value_with_sight = None, 0.9
    told.size, told.believed = lambda: None, told.probability
    alone = Perceiver(Library.from_examples(rows))
    alone.belief = told
    assert alone.feel(NameEvidence("eye", {"ball": 1.0})).why == "ball 0.50"


@pytest.mark.parametrize("likelier", ["a", "b"])
def test_an_object_that_was_never_touched_so_gives_no_reasons_wherever_it_stands(likelier: str) -> None:
    of = Library.from_examples({name: [[Evidence(t, {"x": 0.1 * k})] for k in range(5)] for name, t in ("at", "bu")})
    evidence = Evidence("t", {"x": 0.0})
    said = NameEvidence("eye", {name: 0.9 if name == likelier else 0.1 for name in "ab"})
    after = Belief.before(of).after(evidence).after(said)
    assert after.best == likelier
    assert reasons_of(evidence, after) == ()


def test_what_is_felt_alone_gives_the_whole_of_the_odds_and_nothing_felt_none() -> None:
    rng = np.random.default_rng(9)
    rows = {
        name: [[Evidence("t", {"pad.x": m + rng.normal(), "form.y": rng.normal()})] for _ in range(8)]
        for name, m in (("a", 0.0), ("b", 4.0))
    }
    of = Library.from_examples(rows)
    model, evidence = replace(of.touches["t"], width=1.0, fall=5.0), Evidence("t", {"pad.x": 0.0})
    of = replace(of, touches={"t": model})
    told = np.exp(model.log_kernel(evidence.vector(model.metric.names)))
    odds = told[:8].mean() / told[8:].mean()
    (reason,) = reasons_of(evidence, Belief.before(of).after(evidence))
    what, _, factor = reason.rpartition(" by a factor of ")
    assert what == "the surfaces under the pads: for a against b"
    assert float(factor) == pytest.approx(odds, abs=0.051)
    assert reasons_of(Evidence("t", {}), Belief.before(of)) == ()
