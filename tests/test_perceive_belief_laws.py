"""What a belief takes of a touch, where likelihoods end, and when it is atypical: with answers on paper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from varishold.perceive import Belief, Evidence, Library
from varishold.perceive.library import LOG_SIZES


def examples(n: int, middle: float, seed: int, *, sizes: list[float] | None = None) -> list[list[Evidence]]:
    rng = np.random.default_rng(seed)
    told = [{} if sizes is None else {"size.a": np.log(s) + rng.normal(0, 0.03)} for s in sizes or [0.0] * n]
    return [[Evidence("grasp", {"a": middle + rng.normal(), "b": rng.normal()} | size)] for size in told]


def two(*, sized: bool = True) -> Library:
    """A ball whose sizes are known, and a box without any."""
    sizes = np.linspace(0.05, 0.1, 8).tolist()
    ball = examples(8, 0.0, 1, sizes=sizes if sized else None)
    return Library.from_examples({"ball": ball, "box": examples(6, 2.0, 2)}, sizes_m={"ball": sizes} if sized else None)


def test_a_touch_that_tells_the_size_of_one_object_counts_as_one_that_tells_sizes() -> None:
    belief = Belief.before(two())
    size = Evidence("grasp", {"size.a": np.log(0.07)})
    assert [belief.after(size).sized, belief.after(size).after(size).sized] == [1, 2]
    assert belief.after(Evidence("grasp", {"a": 0.0})).sized == 0
    assert Belief.before(two(sized=False)).after(size).sized == 0
    once, twice = belief.after(size), belief.after(size).after(size)
    np.testing.assert_array_equal(twice.size_table, 2 * once.size_table)
    assert not once.size_table[1].any()


def test_one_number_of_a_touch_is_enough_to_have_felt_it() -> None:
    before = Belief.before(two())
    belief = before.after(Evidence("grasp", {"a": 0.3}))
    assert belief.remarks == ()
    assert np.isfinite(belief.scores).all()
    assert belief.scores.shape == (1, 2)
    assert len(belief.beyond) == 1
    assert [known.tolist() for known in belief.known] == [[True, False]]
    nothing = before.after(Evidence("grasp", {"size.a": np.log(0.07)}))
    assert nothing.remarks == ("grasp: nothing that the library knows was felt; the belief stays as it was",)
    assert np.isnan(nothing.scores).all()
    assert nothing.beyond == ()


def test_sizes_are_never_less_likely_than_sixty_nats_below_the_likeliest() -> None:
    sizes = [0.03, 0.2] * 20
    of = Library.from_examples({"ball": examples(40, 0.0, 3, sizes=sizes)}, sizes_m={"ball": sizes})
    for depth, expected in ((-20.0, -20.0), (-59.0, -59.0), (-61.0, -60.0), (-1e4, -60.0)):
        table = np.where(LOG_SIZES < np.log(0.08), 0.0, depth)[None]
        small, large = replace(Belief.before(of), size_table=table, sized=1).particles.reshape(20, 2).sum(axis=0)
        assert np.log(large / small) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("far", [-3e3, 0.0, 3e3])
@pytest.mark.parametrize("apart", [1.0, 50.0, 2e3])
def test_examples_however_unlikely_leave_the_others_as_they_are(far: float, apart: float) -> None:
    """What all are likely together says nothing of the name, the size and the examples; a move keeps it."""
    of = two()
    log_weight = far - apart * (np.arange(14) % 4)
    belief = replace(Belief.before(of), log_weight=log_weight, touches=("grasp",))
    share = np.exp(-apart * (np.arange(14) % 4)) / of.counts[of.owner]
    np.testing.assert_allclose(belief.particles, share / share.sum(), rtol=1e-9, atol=1e-290)
    plain = np.log([np.exp(log_weight[of.owner == k] - far) @ of.size_prior[of.owner == k] for k in (0, 1)])
    before = np.log([of.size_prior[of.owner == k].sum(axis=0) for k in (0, 1)])
    likely = plain > -600
    assert likely.any(axis=1).all()
    kept = belief.in_new_place().kept
    np.testing.assert_allclose(kept[likely], (plain - before + far)[likely], rtol=1e-9, atol=1e-9)
    assert np.isfinite(kept).all()


def test_a_size_is_that_of_the_examples_that_are_not_ruled_out() -> None:
    of = two()
    ruled_out = np.arange(14) % 4 > 0
    finite, endless = (
        replace(Belief.before(of), log_weight=np.where(ruled_out, -depth, 0.0)).size("ball") for depth in (40, 1e4)
    )
    assert endless == pytest.approx(finite)
    # Of an object that is ruled out altogether no size is told.
    assert replace(Belief.before(of), log_weight=np.where(of.owner == 0, -1e4, 0.0)).size("ball") is None


def test_a_known_object_is_atypical_in_fewer_than_one_look_of_a_hundred() -> None:
    """Where there are examples enough: at a p-value of .007."""
    rng = np.random.default_rng(4)
    of = Library.from_examples({"ball": [[Evidence("grasp", {"a": x})] for x in rng.normal(size=400)]})
    usual, seen = of.touches["grasp"].scores, set()
    for a in np.linspace(2.2, 3.4, 50):
        belief = Belief.before(of).after(Evidence("grasp", {"a": a}))
        rank = 1 + int((usual <= belief.scores[0, 0]).sum())
        assert belief.p_value == pytest.approx(rank / 401)
        assert belief.atypical == (rank <= 2)
        seen.add(rank)
    assert {2, 3} <= seen


def test_a_touch_that_only_some_examples_know_is_ranked_among_those() -> None:
    rng = np.random.default_rng(5)
    rows = [
        [Evidence("grasp", {"a": x}), Evidence("tip", {"a": x})][: 1 + k % 2] for k, x in enumerate(rng.normal(size=20))
    ]
    of = Library.from_examples({"ball": rows})
    assert Belief.before(of).after(Evidence("tip", {"a": 9.0})).p_value == pytest.approx(1 / 11)
    assert Belief.before(of).after(Evidence("grasp", {"a": 9.0})).p_value == pytest.approx(1 / 21)


@pytest.mark.parametrize("fall", [4.0, 5e3, 4e4])
def test_a_kernel_however_steep_leaves_the_mean_of_the_likeliest_examples(fall: float) -> None:
    of = two()
    model = replace(of.touches["grasp"], fall=fall)
    # One that does not know the touch changes nothing.
    values = np.where(np.arange(14)[:, None] == 3, np.nan, model.values)
    model = replace(model, values=values)
    belief = Belief.before(replace(of, touches={"grasp": model})).after(Evidence("grasp", {"a": 1.0, "b": -2.0}))
    told = model.log_kernel(np.array([1.0, -2.0]))
    assert np.isnan(told).tolist() == (np.arange(14) == 3).tolist()
    top = np.nanmax(told)
    for k in (0, 1):
        mine = told[(of.owner == k) & np.isfinite(told)]
        if mine.max() > top - 600:
            expected = top + np.log(np.exp(mine - top).mean())
            assert belief.scores[0, k] == pytest.approx(expected, rel=1e-9)
        else:
            assert belief.scores[0, k] < top - 600
    assert np.isfinite(belief.scores).all()


@pytest.mark.parametrize("tips", [(3, 1), (1, 4), (1, 0), (5, 0)])
def test_an_object_that_was_never_touched_so_is_as_likely_as_the_others_on_the_whole(tips: tuple[int, int]) -> None:
    rng = np.random.default_rng(6)

    def example(k: int, n: int) -> list[Evidence]:
        grasp = Evidence("grasp", {"a": rng.normal()})
        return [grasp, Evidence("tip", {"a": rng.normal()})] if k < n else [grasp]

    names = ("ball", "box", "can")
    of = Library.from_examples(
        {name: [example(k, n) for k in range(6)] for name, n in zip(names, (*tips, 0), strict=True)}
    )
    belief = Belief.before(of).after(Evidence("tip", {"a": 0.5}))
    p = np.exp(of.touches["tip"].log_kernel(np.array([0.5])))
    for k in range(3):
        mine = p[(of.owner == k) & np.isfinite(p)]
        expected = mine.mean() if mine.size else np.nanmean(p)
        assert belief.scores[0, k] == pytest.approx(np.log(expected))
    total = sum(np.exp(belief.scores[0]))
    assert belief.probability == pytest.approx(
        {name: np.exp(score) / total for name, score in zip(names, belief.scores[0], strict=True)}
    )


def test_a_number_is_remarked_where_it_lies_beyond_what_any_example_does() -> None:
    """One that stands as far from the rest as an example does is no wonder."""
    of = Library.from_examples({"ball": [[Evidence("grasp", {"a": x})] for x in (*range(20), 25.0)]})
    for a, remarked in ((10.0, False), (25.0, False), (30.0, False), (34.0, True), (-6.0, False), (-9.0, True)):
        belief = Belief.before(of).after(Evidence("grasp", {"a": a}))
        assert bool(belief.remarks) == remarked, a


def test_no_probability_exceeds_one_by_rounding() -> None:
    rng = np.random.default_rng(7)
    of = Library.from_examples({"ball": examples(9, 0.0, 8)})
    above = 0
    for _ in range(60):
        belief = replace(Belief.before(of), log_weight=rng.normal(size=9))
        assert belief.probability["ball"] <= 1.0
        assert belief.probability["ball"] == pytest.approx(1.0)
        above += np.bincount(of.owner, weights=belief.particles)[0] > 1.0
    assert above > 0
