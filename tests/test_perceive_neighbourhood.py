"""Laws of the metric that is learned from examples: what it listens to, and that it is not believed too well."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.optimize
from numpy.typing import NDArray

from varishold.perceive import (
    NONE_OF_THESE,
    Belief,
    Evidence,
    Library,
    Perceiver,
    read_library,
    touch_learning,
    write_library,
)
from varishold.perceive.neighbourhood import folds_of, learn_map
from varishold.perceive.size_model import fit_size_model

KINDS = ("ball", "box", "can")
_NUMBERS, _EACH = 10, 100


def felt(rng: np.random.Generator, kind: int, n: int = _EACH) -> list[list[Evidence]]:
    """Two numbers tell the kind, by a ring that no straight line cuts off; the others are noise of the same breadth."""
    turn = rng.uniform(0, 2 * np.pi, n)
    far = (0.5, 1.5, 2.5)[kind] + 0.15 * rng.normal(size=n)
    numbers = rng.normal(size=(n, _NUMBERS)) * 1.5
    numbers[:, 0], numbers[:, 1] = far * np.cos(turn), far * np.sin(turn)
    return [[Evidence("grasp", {f"a{k}": x for k, x in enumerate(row)})] for row in numbers]


def library(seed: int = 1) -> Library:
    rng = np.random.default_rng(seed)
    return Library.from_examples({name: felt(rng, k) for k, name in enumerate(KINDS)})


def surprise(of: Library, seed: int) -> float:
    rng = np.random.default_rng(seed)
    told = [
        Belief.before(of).after(example[0]).probability[name]
        for k, name in enumerate(KINDS)
        for example in felt(rng, k, 40)
    ]
    return float(-np.log(np.maximum(told, 1e-12)).mean())


def plain(monkeypatch: pytest.MonkeyPatch, seed: int = 1) -> Library:
    with monkeypatch.context() as patch:
        patch.setattr(touch_learning, "_LEAST_OF_A_KIND", 10**9)
        return library(seed)


def test_numbers_that_tell_nothing_are_no_longer_listened_to(monkeypatch: pytest.MonkeyPatch) -> None:
    learned, before = library(), plain(monkeypatch)
    assert before.touches["grasp"].optimism is None
    assert surprise(learned, 2) < 0.5 * surprise(before, 2)
    whitening = learned.touches["grasp"].metric.whitening
    counts = (whitening @ whitening.T).diagonal()
    assert counts[:2].min() > 4 * counts[2:].max()


def test_few_examples_are_measured_as_before() -> None:
    rng = np.random.default_rng(3)
    few = Library.from_examples({name: felt(rng, k, 39) for k, name in enumerate(KINDS)})
    assert few.touches["grasp"].optimism is None


def test_a_metric_is_learned_from_some_of_very_many_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(touch_learning, "_MOST_LEARNED", 200)
    of = library()
    optimism = of.touches["grasp"].optimism
    assert optimism is not None
    assert np.count_nonzero(optimism) == 200
    assert surprise(of, 2) < 0.7 * surprise(plain(monkeypatch), 2)


def test_a_map_that_flattens_a_direction_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    flat = np.diag([*np.ones(_NUMBERS - 1), 1e-9])
    monkeypatch.setattr(touch_learning, "learn_map", lambda *_: flat)
    assert library().touches["grasp"].optimism is None


def in_two_poses(seed: int, n: int = 60) -> Library:
    """The first number tells the object and the second the pose, as plainly; the others are noise."""
    rng = np.random.default_rng(seed)

    def rows(thing: float, pose: float) -> list[list[Evidence]]:
        numbers = rng.normal(size=(n, 6))
        numbers[:, 0] += thing
        numbers[:, 1] += pose
        return [[Evidence("grasp", {f"a{k}": x for k, x in enumerate(row)})] for row in numbers]

    return Library.from_examples(
        {name: [*rows(thing, -1.0), *rows(thing, 1.0)] for name, thing in (("box", -1.0), ("can", 1.0))},
        poses=dict.fromkeys(("box", "can"), ["upright"] * n + ["lying"] * n),
    )


def test_poses_of_one_object_need_not_be_told_from_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    def counts(of: Library) -> NDArray[np.float64]:
        assert of.touches["grasp"].optimism is not None
        whitening = of.touches["grasp"].metric.whitening
        return np.asarray((whitening @ whitening.T).diagonal())

    by_object = counts(in_two_poses(6))
    assert by_object[0] > 2 * by_object[1:].max()
    learned = touch_learning._with_learned_metric
    monkeypatch.setattr(
        touch_learning,
        "_with_learned_metric",
        lambda model, owner, of, log_size: learned(model, owner, np.arange(len(of)), log_size),
    )
    by_kind = counts(in_two_poses(6))
    assert by_kind[1] > 2 * by_kind[2:].max()


def test_a_metric_is_that_of_all_poses_where_there_are_enough_of_each_to_learn_it() -> None:
    of = in_two_poses(7)
    values = of.touches["grasp"].values
    np.testing.assert_allclose(of.touches["grasp"].metric.shift, values.mean(axis=0))
    few = in_two_poses(7, 39)
    usual = few.touches["grasp"].values[few.usual]
    np.testing.assert_allclose(few.touches["grasp"].metric.shift, usual.mean(axis=0))


def test_what_a_metric_was_learned_from_is_not_thought_more_usual_than_what_it_was_not() -> None:
    """Fresh things of the same kinds fall below a p-value as often as it says."""
    p = []
    for seed in range(1, 5):
        of = library(seed)
        assert of.touches["grasp"].optimism is not None
        rng = np.random.default_rng(100 + seed)
        p += [
            Belief.before(of).after(example[0]).p_value
            for k in range(len(KINDS))
            for example in felt(rng, k, 60)
            if Belief.before(of).after(example[0]).best == KINDS[k]
        ]
    for level in (0.05, 0.1, 0.3):
        share = np.mean(np.array(p) <= level)
        assert share <= level + 3 * np.sqrt(level * (1 - level) / len(p)), level


@pytest.mark.parametrize(
    ("objects", "examples", "numbers"), [(5, 10, 40), (2, 40, 60), (2, 10, 200), (2, 50, 200), (3, 20, 100)]
)
def test_as_many_numbers_as_examples_make_known_things_no_stranger(objects: int, examples: int, numbers: int) -> None:
    """What an example brings into the metric makes no other touch seem odd beside it."""
    p, refused, n = [], 0, 12
    for seed in range(3):
        rng = np.random.default_rng(seed)
        middles = rng.normal(size=(objects, numbers))

        def touched(middle: NDArray[np.float64], rng: np.random.Generator = rng) -> list[Evidence]:
            return [
                Evidence(touch, {f"a{k}": x for k, x in enumerate(middle + rng.normal(size=numbers))})
                for touch in ("grasp", "regrasp")
            ]

        named = {f"thing {k}": middle for k, middle in enumerate(middles)}
        of = Library.from_examples({name: [touched(at) for _ in range(examples)] for name, at in named.items()})
        for name, at in named.items():
            for _ in range(n):
                perceiver = Perceiver(of)
                updates = [perceiver.feel(evidence) for evidence in touched(at)]
                p.append(updates[0].p_value)
                refused += perceiver.answer().object == NONE_OF_THESE
                assert max(updates[-1].probability, key=updates[-1].probability.__getitem__) == name
    for level in (1 / (1 + examples), 0.2):
        share = np.mean(np.array(p) <= level)
        assert share <= level + 3 * np.sqrt(level * (1 - level) / len(p)), level
    assert refused <= 0.05 * len(p)


def test_the_slope_is_that_of_the_surprise(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    white = rng.normal(size=(90, 4)).astype(np.float32)
    kind = rng.permutation(np.repeat([0, 1, 2, 3], [40, 25, 15, 10]))
    minimize, seen = scipy.optimize.minimize, []

    def spied(surprise, start, **settings):  # type: ignore[no-untyped-def]
        at = start + 0.1 * rng.normal(size=start.size)
        steps = 1e-2 * np.eye(at.size)
        by_steps = np.array([(surprise(at + step)[0] - surprise(at - step)[0]) / 2e-2 for step in steps])
        seen.append(np.abs(by_steps - surprise(at)[1]).max() / np.abs(by_steps).max())
        return minimize(surprise, start, **settings)

    monkeypatch.setattr(scipy.optimize, "minimize", spied)
    map_ = learn_map(white, kind, 1.0, 10.0)
    assert seen[0] < 1e-2
    assert map_.shape == (4, 4)
    assert np.array_equal(map_, learn_map(white, kind, 1.0, 10.0))


def test_the_map_does_not_depend_on_the_order_of_kinds() -> None:
    rng = np.random.default_rng(6)
    white = rng.normal(size=(80, 3)).astype(np.float32)
    kind = np.repeat([0, 1], 40)
    white[:, 0] += kind
    np.testing.assert_allclose(
        learn_map(white, kind, 1.0, 10.0), learn_map(white, 1 - kind, 1.0, 10.0), rtol=1e-2, atol=1e-2
    )


def test_folds_hold_the_same_share_of_every_kind() -> None:
    kind = np.repeat(np.arange(4), [8, 16, 5, 41])
    fold = folds_of(kind, 4)
    for k in range(4):
        counts = np.bincount(fold[kind == k], minlength=4)
        assert np.ptp(counts) <= 1
    assert np.array_equal(fold, folds_of(kind, 4))


def test_a_mapped_metric_whitens_and_then_maps() -> None:
    metric = library().touches["grasp"].metric
    map_ = np.random.default_rng(7).normal(size=(_NUMBERS, _NUMBERS)) / 9 + np.eye(_NUMBERS)
    rows = np.random.default_rng(8).normal(size=(5, _NUMBERS))
    wanted, got = rows @ metric.whitening @ map_, rows @ metric.mapped(map_).whitening
    apart = [np.linalg.norm(x[:, None] - x[None, :], axis=2) for x in (wanted, got)]
    np.testing.assert_allclose(*apart, rtol=1e-6, atol=1e-9)


def test_a_learned_library_is_written_and_read_as_it_is(tmp_path: Path) -> None:
    of = library().tempered(0.7, own=0.5)
    write_library(of, tmp_path / "own.npz")
    again = read_library(tmp_path / "own.npz").touches["grasp"]
    mine = of.touches["grasp"]
    assert again.own == 0.5
    assert again.optimism is not None
    np.testing.assert_allclose(again.optimism, mine.optimism, atol=2e-3)
    example = felt(np.random.default_rng(9), 1, 1)[0]
    beliefs = [Belief.before(each).after(example[0]).probability for each in (of, read_library(tmp_path / "own.npz"))]
    assert beliefs[0] == pytest.approx(beliefs[1], abs=0.02)
    assert read_library(tmp_path / "own.npz").only(["can", "ball"]).touches["grasp"].optimism is not None


def test_an_object_that_is_added_is_judged_by_its_own_examples() -> None:
    of = library()
    more = of.with_object("die", felt(np.random.default_rng(10), 1, 12))
    optimism = more.touches["grasp"].optimism
    assert optimism is not None
    assert not optimism[len(of) :].any()
    np.testing.assert_array_equal(optimism[: len(of)], of.touches["grasp"].optimism)


@pytest.mark.parametrize("own", [0.3, 0.6])
def test_one_touch_says_as_much_however_far_an_example_counts(own: float) -> None:
    of, example = library(), felt(np.random.default_rng(11), 2, 1)[0]
    softer = replace(of, touches={touch: replace(model, own=own) for touch, model in of.touches.items()})
    assert Belief.before(softer).after(example[0]).probability == pytest.approx(
        Belief.before(of).after(example[0]).probability
    )


def test_a_size_that_is_off_in_a_way_of_its_own_is_no_surprise() -> None:
    """Every fifth box is fitted with its other side: then the size is off by that, and by nothing between."""
    rng = np.random.default_rng(12)
    log_size: NDArray[np.float64] = rng.uniform(np.log(0.04), np.log(0.12), 200)
    other = rng.random(200) < 0.2
    values = (log_size - 0.35 * other + 0.005 * rng.normal(size=200))[:, None]
    model = fit_size_model(("size.square",), values, log_size, np.zeros(200, dtype=np.int64))
    at = np.log(0.07)
    said = model.log_likelihood(np.array([at]), at + np.array([0.0, 0.35, 0.17]))[0]
    assert said[0] - said[1] == pytest.approx(np.log(4), abs=0.7)
    assert said[1] - said[2] > 3
