"""Figures, splits, features and leaks against plain loops, and their limits at the edges."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import pytest
from scipy import stats

from varishold.errors import InputError
from varishold.evaluation import leaks as leaks_module
from varishold.evaluation.features import feature_table, pooled_frames
from varishold.evaluation.figures import difference_figure, mean_figure, share_figure
from varishold.evaluation.held_out import Felt
from varishold.evaluation.leaks import (
    Leak,
    duplicated,
    find_leaks,
    interleaved,
    one_block_each,
    sharing_frames,
    still_columns,
    untouched_taxels,
)
from varishold.evaluation.splits import Split, split_presses, usable_groups
from varishold.touch.course.presses import Press
from varishold.trust import difference_interval, share_interval

Floats = np.ndarray[Any, np.dtype[np.float64]]
Groups = np.ndarray[Any, np.dtype[np.str_]]


def a_press(frames: Floats, **columns: float) -> Press:
    frames = np.asarray(frames, float)
    return Press({"pad": frames}, {"pad": np.ones(frames.shape[1:], bool)}, columns=columns)


# ---- figures


def half_over_groups(values: Sequence[float], groups: Sequence[str]) -> float:
    """Half of Student's interval of a ratio of sums over groups, summed one by one."""
    mean, names = sum(values) / len(values), sorted(set(groups))
    squares = 0.0
    for name in names:
        mine = [v for v, g in zip(values, groups, strict=True) if g == name]
        squares += (sum(mine) - mean * len(mine)) ** 2
    n = len(names)
    return float(stats.t.ppf(0.975, n - 1) * math.sqrt(n / (n - 1) * squares) / len(values))


@pytest.mark.parametrize("n_groups", [1, 2, 3, 5])
@pytest.mark.parametrize("seed", range(4))
def test_figures_are_those_of_plain_sums(seed: int, n_groups: int) -> None:
    rng = np.random.default_rng((seed, n_groups))
    groups = np.array([f"g{k}" for k in [*range(n_groups), *rng.integers(0, n_groups, 20)]])
    values = rng.normal(3, 1, len(groups))
    right = rng.random(len(groups)) < (0.5, 0.02, 0.98, 0.8)[seed]
    mean, share = mean_figure(values, groups), share_figure(right, groups)
    for figure in (mean, share):
        assert (figure.n, figure.n_groups) == (len(groups), n_groups)
        assert figure.over == ("groups" if n_groups >= 3 else "presses")
    telling = float(len(right))
    assert share.value == pytest.approx(right.mean())
    if n_groups >= 3:
        few = float(stats.t.ppf(0.975, n_groups - 1))
        scatter = half_over_groups(right.astype(float).tolist(), groups.tolist()) / few
        by_chance = right.mean() * (1 - right.mean()) / len(right)
        telling *= min(1.0, by_chance / scatter**2 if scatter else 1.0) * (stats.norm.ppf(0.975) / few) ** 2
        around = half_over_groups(values.tolist(), groups.tolist())
    else:
        around = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)
    low, high = share_interval(right.mean() * telling, telling)
    assert (share.low, share.high) == pytest.approx((low, high))
    assert (mean.low, mean.high) == pytest.approx((values.mean() - around, values.mean() + around))
    other = right[::-1]
    told = difference_figure(right, other, groups)
    plain = mean_figure(right.astype(float) - other, groups)
    least, most = difference_interval(int((right & ~other).sum()), int((other & ~right).sum()), len(right))
    assert (told.value, told.over, told.n, told.n_groups) == (plain.value, plain.over, plain.n, plain.n_groups)
    assert (told.low, told.high) == pytest.approx((min(plain.low or 0.0, least), max(plain.high or 0.0, most)))
    assert mean_figure(values).n_groups == share_figure(right).n_groups == 0
    for figure in (mean, share, told):
        assert figure.low is not None
        assert figure.high is not None
        assert figure.to_dict() == {
            "value": round(figure.value, 6),
            "low": round(figure.low, 6),
            "high": round(figure.high, 6),
            "interval_over": figure.over,
            "n_presses": figure.n,
            "n_groups": figure.n_groups,
        }


def test_one_press_has_no_interval_of_its_mean_and_two_have() -> None:
    one = mean_figure([0.25])
    assert one.to_dict() == {
        "value": 0.25, "low": None, "high": None, "interval_over": None, "n_presses": 1, "n_groups": 0
    }  # fmt: skip
    two = mean_figure([0.25, 0.75])
    assert (two.low, two.high) == pytest.approx(stats.t.interval(0.95, 1, loc=0.5, scale=0.25))
    assert mean_figure([0.25], np.array(["a"])).n_groups == 1


# ---- splits


@pytest.mark.parametrize("n_groups", [2, 3, 11, 12, 13, 24, 30])
def test_groups_are_dealt_into_a_dozen_folds_at_most(n_groups: int) -> None:
    groups = np.array([f"{k:02}" for k in range(n_groups) for _ in range(4)])
    labels = np.tile(["a", "b"], 2 * n_groups)
    split = split_presses(labels, groups)
    assert split.n_folds == min(n_groups, 12)
    assert split.kind == "groups"
    for k, group in enumerate(sorted(set(groups))):
        assert set(split.fold[groups == group]) == {k % 12}
    assert split.known.all()


def test_what_is_learned_from_has_two_presses_a_thing_and_is_known_if_there_are_two_things() -> None:
    labels = np.array(list("aabbc" + "aabbcc" + "abd"))
    groups = np.array(["1"] * 5 + ["2"] * 6 + ["3"] * 3)
    split = split_presses(labels, groups)
    for (train, test), group in zip(split.parts(), "123", strict=True):
        outside = [k for k in range(len(labels)) if groups[k] != group]
        counts = {name: sum(labels[k] == name for k in outside) for name in "abcd"}
        assert train.tolist() == [k for k in outside if counts[labels[k]] >= 2]
        assert test.tolist() == [k for k in range(len(labels)) if groups[k] == group]
        assert split.known[test].tolist() == [counts[labels[k]] >= 2 for k in test]


def test_a_press_is_unknown_where_one_thing_alone_is_left() -> None:
    # Without group 2 only "a" has two presses; without group 1 both have.
    labels, groups = np.array(list("aab" + "aabbb")), np.array(list("111" + "22222"))
    split = split_presses(labels, groups)
    assert split.known[:3].all()
    assert not split.known[3:].any()


def test_blocks_of_neighbours_are_as_many_as_is_said() -> None:
    labels = np.tile(["a", "b"], 12)
    for folds in (2, 3, 5):
        assert split_presses(labels, None, folds=folds).n_folds == folds
    assert split_presses(labels, None).known.all()
    with pytest.raises(InputError, match="'a' has 2 presses only: give each thing at least 3"):
        split_presses(np.array(list("aabbbb")), None)


def test_usable_groups_are_two_or_more_and_not_the_things() -> None:
    codes = np.array([0, 1, 0, 1])
    for groups, usable in (("xxxx", False), ("xyxy", False), ("yxyx", False), ("xxyy", True), ("xyxz", True)):
        given = np.array(list(groups))
        found = usable_groups(given, codes)
        assert found is given if usable else found is None
    assert usable_groups(None, codes) is None


# ---- features


@pytest.mark.parametrize("floor", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_features_are_those_of_plain_loops(seed: int, floor: float) -> None:
    rng = np.random.default_rng(seed)
    frames = rng.normal(0.3, 1.0, (5, 1, 6, 9))
    frames[3] = 0.0
    frames[4] = -1.0
    presses = [a_press(frame, **{"angle_rad.j": 0.1 * k}) for k, frame in enumerate(frames)]
    pooled = {"one": frames[:, 0], "two": 2 * frames[::-1, 0, :, :4]}
    kinds = ("raw frame", "on/off", "moments")
    tables = {kind: feature_table(kind, pooled, presses, ["angle_rad.j"], floor) for kind in kinds}
    for k in range(5):
        pads = [pad[k] for pad in pooled.values()]
        values = [float(v) for pad in pads for v in pad.ravel()]
        assert tables["raw frame"][k].tolist() == [*values, 0.1 * k]
        limit = max(0.1 * max(values), floor)
        assert tables["on/off"][k].tolist() == [*(float(v > limit) for v in values), 0.1 * k]
        loads = [sum(v for v in pad.ravel().tolist() if v > 0) for pad in pads]
        whole = max(sum(loads), floor, 1e-9)
        wanted = [math.log(whole), *(load / whole for load in loads)]
        for pad in pads:
            wanted += moments_of(pad, floor)
        assert tables["moments"][k] == pytest.approx([*wanted, 0.1 * k], rel=1e-6, abs=1e-6)
    assert feature_table("raw frame", pooled, presses, [], floor).shape == (5, 54 + 24)


def moments_of(pad: Floats, floor: float) -> list[float]:
    rows, cols = pad.shape
    largest = max(float(pad.max()), floor, 1e-9)
    weight = np.maximum(pad, 0) / largest
    found = cv2.moments(np.ascontiguousarray(weight))
    on = float((pad > max(0.1 * largest, floor)).sum())
    if found["m00"] == 0:
        return [0.0] * 12 + [math.log(largest), on]
    load = found["m00"]
    place = [found["m10"] / load - (cols - 1) / 2, found["m01"] / load - (rows - 1) / 2]
    spread = [found[name] / load for name in ("mu20", "mu11", "mu02")]
    hu = cv2.HuMoments(found).ravel().tolist()
    return [*place, *spread, *(math.copysign(math.log1p(1e6 * abs(h)), h) for h in hu), math.log(largest), on]


def test_pooled_are_the_frames_that_hold_the_load_and_nothing_where_there_is_no_pad() -> None:
    ramp = np.array([0.0, 0.5, 0.79, 0.9, 1.0, 0.1])[:, None, None] * np.ones((6, 2, 3))
    both = Press({"a": ramp, "b": 0 * ramp + 7}, {"a": np.ones((2, 3), bool), "b": np.ones((2, 3), bool)})
    one = Press({"a": 3 * ramp}, {"a": np.ones((2, 3), bool)})
    pooled = pooled_frames([one, both], {"a": (2, 3), "b": (2, 3)}, 0.0)
    assert pooled["a"][0] == pytest.approx(np.full((2, 3), 3 * 0.95))
    assert pooled["b"].tolist() == [[[0.0] * 3] * 2, [[7.0] * 3] * 2]


# ---- leaks


@pytest.mark.parametrize("shape", [(3, 9), (4, 4), (6, 7), (9, 3)])
def test_a_taxel_is_touched_with_its_eight_neighbours_unless_the_pad_is_narrow(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        pooled = rng.choice([0.0, 1.0, -2.0, 2.0], (3, *shape), p=[0.94, 0.04, 0.01, 0.01])
        away = untouched_taxels(pooled, 1.0)
        reach = 1 if min(shape) >= 4 else 0
        for r, c in np.ndindex(*shape):
            near = pooled[:, max(0, r - reach) : r + reach + 1, max(0, c - reach) : c + reach + 1]
            assert away[r, c] == (not (abs(near) > 1.0).any())


def test_joints_are_still_where_most_things_hold_them_still() -> None:
    codes = np.repeat([0, 1, 2], 3)
    swing = np.array([-1.0, 0.0, 1.0]) / np.std([-1.0, 0.0, 1.0])
    for spread, still in ((0.99e-3, True), (1.01e-3, False)):
        values = np.concatenate([5 * k + spread * swing for k in range(3)])[:, None]
        assert still_columns(values, codes).tolist() == [still]
    loose = np.concatenate([k + (1.0 if k == 2 else 1e-4) * swing for k in range(3)])[:, None]
    assert still_columns(loose, codes).tolist() == [True]


@pytest.mark.parametrize("seed", range(20))
def test_turns_and_blocks_are_those_that_can_be_counted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 9))
    runs, things = np.sort(rng.integers(0, 2, n)), rng.integers(0, 3, n)
    taken = False
    for run in set(runs.tolist()):
        inside = [int(t) for t, r in zip(things, runs, strict=True) if r == run]
        blocks = [inside[0], *(b for a, b in itertools.pairwise(inside) if a != b)]
        taken |= len(blocks) > len(set(blocks))
    assert (interleaved(things, runs) is not None) == taken
    both = list(zip(things.tolist(), runs.tolist(), strict=True))
    goes = [both[0], *(b for a, b in itertools.pairwise(both) if a != b)]
    assert (one_block_each(things, runs) is not None) == (len(goes) == len(set(things.tolist())))


def told_by(n: int, hits: int, n_things: int = 2) -> Leak | None:
    """Ask what a feature tells that is right in so many of n presses, half of them of each thing."""
    codes = np.arange(2 * n) % n_things
    fold = np.repeat([0, 1], n)
    said = codes.copy()
    for side in (0, n):
        said[side : side + n - hits] = (codes[side : side + n - hits] + 1) % n_things
    split = Split("groups", fold, np.ones(2 * n, bool), codes)
    felt = Felt([a_press(np.zeros((1, 1, 1)))] * (2 * n), codes, np.array(["a", "b", "c"][:n_things]), None)

    def features(train: np.ndarray[Any, np.dtype[np.intp]]) -> Floats:
        table = said.astype(float)
        table[train] = codes[train]
        return table[:, None]

    return leaks_module._told_by("odd", "{share} of {chance}", features, felt, split, 0)


def test_what_tells_more_than_chance_by_enough_is_a_leak(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leaks_module, "_TREES", 3)
    assert told_by(100, 50) is None
    assert told_by(100, 54) is None
    sure = told_by(100, 80)
    assert sure is not None
    assert (sure.share, sure.chance, sure.says) == (0.8, 0.5, "80 % of 50 %")
    assert sure.to_dict() == {"name": "odd", "says": "80 % of 50 %", "share": 0.8, "chance": 0.5}
    assert Leak("a", "b").to_dict() == {"name": "a", "says": "b", "share": None, "chance": None}
    # Of few presses chance gives as much.
    assert told_by(6, 5) is None
    # Often, but hardly more than chance: 4 points of a great many.
    assert told_by(3000, 1620) is None
    assert told_by(3000, 1680) is not None
    # At one in a thousand.
    for hits in range(100, 140, 2):
        rare = stats.binomtest(2 * hits, 400, 0.5, alternative="greater").pvalue
        low, _ = share_interval(2 * hits, 400)
        leak = 2 * hits / 400 >= 0.55 and rare <= 0.001 and low > 0.5
        assert (told_by(200, hits) is not None) == leak


def test_each_kind_of_leak_is_looked_for_once_and_where_it_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    for name in ("_told_by_untouched", "_told_by_still"):
        monkeypatch.setattr(leaks_module, name, lambda *given, name=name: asked.append(name))
    rng = np.random.default_rng(0)
    presses = [a_press(rng.random((2, 3, 3))) for _ in range(8)]
    codes, groups = np.tile([0, 1], 4), np.array(list("aaaabbbb"))
    ticks: list[int] = []
    for grouped in (True, False):
        felt = Felt(presses, codes, np.array(["x", "y"]), groups if grouped else None)
        split = split_presses(felt.classes[codes], felt.groups)
        found = find_leaks(felt, split, np.zeros(8), seed=0, tick=lambda: ticks.append(1))
        assert [leak.name for leak in found] == ([] if grouped else ["one session on both sides"])
    assert asked == ["_told_by_untouched", "_told_by_still"] * 2
    assert len(ticks) == 6
    in_blocks = Felt(presses, np.repeat([0, 1], 4), np.array(["x", "y"]), None)
    split = split_presses(in_blocks.classes[in_blocks.codes], None)
    names = [leak.name for leak in find_leaks(in_blocks, split, np.zeros(8), seed=0)]
    assert names == ["one session on both sides", "one session a thing"]
    turns = Felt(presses, codes, np.array(["x", "y"]), np.array(list("aabbaabb")))
    split = split_presses(turns.classes[codes], turns.groups)
    assert [leak.name for leak in find_leaks(turns, split, np.zeros(8), seed=0)] == ["groups take turns"]
    twice = Felt([*presses[:7], presses[0]], codes, np.array(["x", "y"]), groups)
    split = split_presses(twice.classes[codes], groups)
    (leak,) = find_leaks(twice, split, np.zeros(8), seed=0)
    assert leak.says.startswith("1 press is there more than once")
    more = Felt([*presses[:6], *presses[:2]], codes, np.array(["x", "y"]), groups)
    (leak,) = find_leaks(more, split, np.zeros(8), seed=0)
    assert leak.says.startswith("2 presses are there more than once")


# ---- presses that share frames


def drawn_presses(seed: int, n: int = 12, *, steps: float = 0.0) -> list[Floats]:
    """Return presses of one thing in one place: a ramp, a hold, noise, whole steps where a sensor has these."""
    rng = np.random.default_rng((7, seed))
    y, x = np.indices((5, 6))
    form = np.maximum(1 - ((y - 2) ** 2 + (x - 3) ** 2) / 5, 0)
    course = np.concatenate([np.zeros(3), np.linspace(0, 1, 8), np.ones(7)])
    drawn = [rng.uniform(0.8, 1.2) * course[:, None, None] * form + rng.normal(0, 0.01, (18, 5, 6)) for _ in range(n)]
    return [np.rint(frames / steps) for frames in drawn] if steps else drawn


@pytest.mark.parametrize("steps", [0.0, 0.01, 0.03, 0.1, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_presses_of_one_thing_share_no_frames(seed: int, steps: float) -> None:
    presses = [a_press(frames) for frames in drawn_presses(seed, steps=steps)]
    assert not sharing_frames(presses, np.arange(len(presses))).any()


@pytest.mark.parametrize(
    "changed",
    [
        lambda frames: frames[2:],
        lambda frames: frames[:-3],
        lambda frames: frames.astype(np.float32),
        lambda frames: frames.round(4),
        lambda frames: frames + 0.5,
        lambda frames: frames + np.linspace(0, 1, 30).reshape(5, 6),
    ],
)
def test_copies_share_frames_however_they_are_cut_and_rounded(changed: Any) -> None:
    drawn = drawn_presses(0)
    presses = [a_press(frames) for frames in [*drawn, *map(changed, drawn[:4])]]
    fold = np.repeat([0, 1], [12, 4])
    assert np.flatnonzero(sharing_frames(presses, fold)).tolist() == [0, 1, 2, 3, 12, 13, 14, 15]
    leak = duplicated(presses, Split("groups", fold, np.ones(16, bool), np.zeros(16, int)))
    assert leak is not None
    assert leak.name == "same presses on both sides"
    assert leak.says.startswith("8 presses share frames with others on the other side of the split")
    # On one side they do no harm.
    assert not sharing_frames(presses, np.zeros(16, int)).any()


def test_windows_that_overlap_share_frames() -> None:
    windows = [a_press(frames[k : k + 14]) for frames in drawn_presses(1) for k in (0, 2, 4)]
    assert sharing_frames(windows, np.arange(len(windows)) % 3).all()
    assert not sharing_frames(windows, np.arange(len(windows)) // 3).any()


def test_presses_of_one_frame_or_of_nothing_share_none() -> None:
    still = [a_press(np.zeros((6, 5, 6))), a_press(np.zeros((6, 5, 6))), a_press(np.ones((1, 5, 6)))]
    assert not sharing_frames(still, np.arange(3)).any()
