"""What a library takes from its examples, what a new object leaves as it was, and what its file holds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from varishold.errors import InputError
from varishold.perceive import Belief, Evidence, Library


def rows(n: int, *, middle: float = 0.0, touches: tuple[str, ...] = ("grasp",), seed: int = 0) -> list[list[Evidence]]:
    rng = np.random.default_rng(seed)
    return [[Evidence(touch, {"a": middle + rng.normal(), "b": rng.normal()}) for touch in touches] for _ in range(n)]


def slip(touch: str = "grasp") -> list[Evidence]:
    return [Evidence(touch, {}, failed=True)]


@cache
def library() -> Library:
    return Library.from_examples(
        {"ball": [*rows(4), slip()], "box": [slip(), *rows(5, middle=3.0, seed=1)], "can": rows(3, seed=2)}
    )


def test_other_things_count_for_the_touch_that_was_made_of_them() -> None:
    others = [
        [Evidence("grasp", {"a": 7.0, "b": 1.0}), Evidence("tip", {"a": 8.0})],
        slip(),
        [Evidence("tip", {"a": 9.0, "b": 2.0}), Evidence("poke", {"a": 5.0, "b": 5.0})],
        [Evidence("grasp", {"c": 1.0})],
    ]
    of = Library.from_examples({"ball": rows(3, touches=("grasp", "tip"))}, others=others)
    np.testing.assert_array_equal(of.touches["grasp"].others, [[7.0, 1.0]])
    np.testing.assert_array_equal(of.touches["tip"].others, [[8.0, np.nan], [9.0, 2.0]])
    alone = Library.from_examples({"ball": rows(3)}, others=[slip()])
    assert alone.touches["grasp"].others.shape == (0, 2)


def test_what_failed_of_a_new_object_is_told_after_what_failed_before() -> None:
    of = library()
    assert of.touches["grasp"].failed.tolist() == [False] * 4 + [True, True] + [False] * 8
    more = of.with_object("egg", [[*slip(), Evidence("grasp", {"a": 1.0})], [Evidence("grasp", {"b": 1.0})]])
    model = more.touches["grasp"]
    assert model.failed.tolist() == [*of.touches["grasp"].failed.tolist(), False, False]
    np.testing.assert_array_equal(model.values[-2:], [[1.0, np.nan], [np.nan, 1.0]])
    both = Library.from_examples({"ball": rows(2, touches=("grasp", "tip"))})
    egg = [[*slip("tip"), Evidence("grasp", {"a": 0.0})], rows(1, touches=("grasp", "tip"))[0]]
    assert both.with_object("egg", egg).touches["tip"].failed.tolist() == [False, False, True, False]


def test_some_of_the_objects_are_taken_with_all_that_is_theirs_in_the_order_asked_for() -> None:
    of = library()
    some = of.only(["can", "ball"])
    keep = np.array([0, 1, 2, 3, 4, 11, 12, 13])
    assert some.owner.tolist() == [1] * 5 + [0] * 3
    assert some.counts.tolist() == [3, 5]
    for name in ("values", "scores", "failed", "size_values"):
        np.testing.assert_array_equal(getattr(some.touches["grasp"], name), getattr(of.touches["grasp"], name)[keep])
    with pytest.raises(InputError, match=r"the library has no 'egg'; it knows ball, box, can"):
        of.only(["ball", "egg", "bowl"])


def test_a_library_keeps_the_touches_it_was_given() -> None:
    of = library()
    touches = dict(of.touches)
    other = replace(of, touches=touches)
    touches.clear()
    assert list(other.touches) == ["grasp"]


@pytest.mark.parametrize("cost", [0.0, -1.0, float("inf"), float("nan"), "1"])
def test_a_touch_costs_something_and_not_everything(cost: object) -> None:
    with pytest.raises(InputError, match="the cost of touch 'grasp' must be positive and finite"):
        Library.from_examples({"ball": rows(2)}, costs={"grasp": cost})  # type: ignore[dict-item]
    told = Library.from_examples({"ball": rows(2, touches=("grasp", "tip"))}, costs={"tip": 1e-9})
    assert {touch: model.cost for touch, model in told.touches.items()} == {"grasp": 1.0, "tip": 1e-9}


def test_an_example_of_unknown_size_may_be_of_any() -> None:
    sizes = [0.05, float("nan"), 0.07]
    of = Library.from_examples({"ball": rows(3), "box": rows(2, seed=4)}, sizes_m={"ball": sizes})
    np.testing.assert_allclose(np.exp(of.log_size[:3]), sizes)
    assert np.isnan(of.log_size[3:]).all()
    np.testing.assert_allclose(of.size_prior[[1, 3, 4]], 1 / 101)
    np.testing.assert_allclose(of.size_prior.sum(axis=1), 1.0)
    # One size that is known is enough for an object to have one.
    told = Belief.before(of)
    assert told.size("ball") is not None
    assert told.size("box") is None
