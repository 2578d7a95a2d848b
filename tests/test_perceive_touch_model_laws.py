"""What a touch of every example says of another touch, against plain sums: likelihood, conformity, kernel, power."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from varishold.perceive import touch_model as module
from varishold.perceive.conformity import Calibration
from varishold.perceive.likelihood import (
    log_mean,
    mean_by_every_kind,
    mean_by_kind,
    members_of_kinds,
    squared_distances,
)
from varishold.perceive.metric import Metric
from varishold.perceive.touch_learning import touch_model
from varishold.perceive.touch_model import TouchModel, tempered, with_own_examples, with_scores

WIDTHS, FALLS = (0.7, 1.0, 1.4), (5.0, 10.0, 20.0, 40.0, 80.0)


def learned(
    table: np.ndarray, owner: np.ndarray, *, others: np.ndarray | None = None, failed: np.ndarray | None = None
) -> TouchModel:
    n, d = table.shape
    return touch_model(
        tuple(f"n{k}" for k in range(d)),
        table,
        owner,
        np.full(n, np.nan),
        others=np.zeros((0, d)) if others is None else others,
        failed=np.zeros(n, bool) if failed is None else failed,
        cost=1.0,
    )


def holed(seed: int, *, n_others: int = 9) -> tuple[TouchModel, np.ndarray]:
    """Three objects of nine examples in any order; some lack a number, some were never touched so."""
    rng = np.random.default_rng(seed)
    owner = rng.permutation(np.repeat(np.arange(3), 9))
    table = rng.normal(size=(27, 3)) + 1.5 * owner[:, None]
    table[rng.random((27, 3)) < 0.15] = np.nan
    table[rng.integers(27, size=2)] = np.nan
    others = rng.normal(size=(n_others, 3)) * 1.5 + (4.0, 0.0, 2.0)
    others[rng.random(others.shape) < 0.15] = np.nan
    return learned(table, owner, others=others), owner


def units(model: TouchModel, values: np.ndarray) -> np.ndarray:
    """Values in standard units, cut at six; what is missing counts as the mean."""
    return np.nan_to_num(np.clip((values - model.metric.shift) / model.metric.scale, -6, 6))


def likelihoods(model: TouchModel, felt: np.ndarray, rows: np.ndarray, known: np.ndarray | None = None) -> np.ndarray:
    """Kernel of every touch that was felt at every row, by the known numbers; shape (n_felt, n_rows)."""
    known = np.ones(felt.shape[1], bool) if known is None else known
    off = (units(model, felt)[:, None] - units(model, rows)[None])[..., known]
    covariance = model.metric.covariance[np.ix_(known, known)]
    squares = np.einsum("abi,ij,abj->ab", off, np.linalg.inv(covariance), off)
    fall = model.fall * np.sqrt(known.mean())
    out: np.ndarray = (1 + squares / (known.sum() * model.width**2)) ** (-fall / 2)
    return out


def alone(model: TouchModel, owner: np.ndarray, i: int) -> TouchModel:
    """The model with the metric of all examples but one; as much is added to its scatter as where it was learned."""
    made = np.flatnonzero(model.made)
    rest, d = made[made != i], model.values.shape[1]
    known = model.values[rest]
    with np.errstate(invalid="ignore"):
        scale = np.nanstd(known, axis=0)
    metric = Metric(model.metric.names, np.nanmean(known, axis=0), np.where(scale > 0, scale, 1.0), np.eye(d))
    free = [max(len(rows) - len(np.unique(owner[rows])), 1) for rows in (made, rest)]
    at = units(replace(model, metric=metric), known)
    off = np.concatenate(
        [at[owner[rest] == k] - at[owner[rest] == k].mean(axis=0) for k in np.unique(owner[rest])] or [at]
    )
    return replace(
        model, metric=replace(metric, covariance=off.T @ off / free[1] + 0.2 * (1 + d / free[0]) * np.eye(d))
    )


def conformity(
    model: TouchModel, owner: np.ndarray, known: np.ndarray | None = None, *, left_out: bool = False
) -> np.ndarray:
    """Log of the mean likelihood under the others of one's object, less that under other things.

    `left_out`: by the metric without the example.
    """
    out = np.full(len(owner), np.nan)
    for i in np.flatnonzero(model.made):
        rest = (owner == owner[i]) & model.made & (np.arange(len(owner)) != i)
        by = alone(model, owner, i) if left_out else model
        out[i] = np.log(likelihoods(by, by.values[[i]], by.values[rest], known).mean()) if rest.any() else np.nan
        if len(model.others):
            out[i] -= np.log(likelihoods(by, by.values[[i]], by.others, known).mean())
    return out


@pytest.mark.parametrize("seed", range(4))
def test_an_example_that_lacks_a_number_knows_the_touch_and_counts_as_the_mean_there(seed: int) -> None:
    model, _ = holed(seed)
    lacking = np.isnan(model.values)
    assert (lacking.any(axis=1) & ~lacking.all(axis=1)).any()
    np.testing.assert_array_equal(model.made, ~lacking.all(axis=1))
    np.testing.assert_allclose(model.metric.shift, np.nanmean(model.values, axis=0))
    felt = np.random.default_rng(seed).normal(size=3)
    rows = np.array([3, 0, 20])
    for known in ([True, True, True], [True, False, True], [False, True, False]):
        part = np.where(known, felt, np.nan)
        expected = np.log(likelihoods(model, felt[None], model.values, np.array(known))[0])
        expected = np.where(model.made, expected, np.nan)
        np.testing.assert_allclose(model.log_kernel(part), expected, rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(model.log_kernel(part, rows=rows), expected[rows], rtol=1e-4, atol=1e-5)
        strange = np.log(likelihoods(model, felt[None], model.others, np.array(known)).mean())
        assert model.log_others(part) == pytest.approx(strange, rel=1e-4, abs=1e-5)
    nothing = np.full(3, np.nan)
    np.testing.assert_array_equal(model.log_kernel(nothing), np.zeros(27))
    np.testing.assert_array_equal(model.log_kernel(nothing, rows=rows), np.zeros(3))
    assert model.log_others(nothing) == 0.0
    assert replace(model, others=np.zeros((0, 3))).log_others(felt) == 0.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("n_others", [0, 1, 9])
def test_an_example_conforms_as_the_others_of_its_object_say_less_what_other_things_say(
    seed: int, n_others: int
) -> None:
    model, owner = holed(seed, n_others=n_others)
    np.testing.assert_allclose(model.scores, conformity(model, owner, left_out=True), rtol=1e-4, atol=1e-4)
    better = conformity(model, owner) - model.scores
    for known in ([True, True, False], [False, False, True]):
        # What it conforms better for being one of those that the metric is of, by so many of the numbers.
        expected = conformity(model, owner, np.array(known)) - np.mean(known) * better
        for k in range(3):
            told = model.calibration(k, owner, np.array(known)).scores
            made = model.made[owner == k] & np.isfinite(model.values[owner == k][:, known]).any(axis=1)
            # Among its own that know one of these numbers at least.
            if made.all() or not model.made[owner == k][~made].any():
                np.testing.assert_allclose(told, expected[owner == k], rtol=1e-4, atol=1e-4)
    for k in range(3):
        every = model.calibration(k, owner, np.ones(3, bool))
        np.testing.assert_array_equal(every.scores, model.scores[owner == k])
        assert model.calibration(k, owner) is every


def test_a_calibration_is_that_of_who_owns_the_examples_and_of_their_sizes() -> None:
    model, owner = holed(0)
    sizes = np.log(np.linspace(0.01, 0.1, 27))
    first = model.calibration(0, owner, log_size=sizes)
    assert model.calibration(0, owner, log_size=sizes) is first
    # As of another library of the same touches, whose objects stand in another order, or whose sizes are others.
    other = model.calibration(0, 2 - owner, log_size=sizes)
    np.testing.assert_array_equal(other.scores, model.scores[owner == 2])
    larger = model.calibration(0, owner, log_size=sizes + 1.0)
    np.testing.assert_array_equal(larger.log_size, sizes[owner == 0] + 1.0)  # type: ignore[arg-type]
    np.testing.assert_array_equal(model.calibration(0, owner).scores, first.scores)


def test_how_many_are_judged_at_once_changes_no_score(monkeypatch: pytest.MonkeyPatch) -> None:
    model, _ = holed(5)
    monkeypatch.setattr(module, "_AT_ONCE", 4)
    again, _ = holed(5)
    np.testing.assert_allclose(again.scores, model.scores, rtol=1e-6)


# Each of these comes out with a kernel of its own.
SEEDS_OF_KERNELS = (0, 2, 5, 7, 10, 11, 15, 22, 35, 130, 149, 183, 206, 518)


def test_the_kernel_is_the_one_of_fifteen_that_names_left_out_examples_best() -> None:
    chosen = set()
    for seed in SEEDS_OF_KERNELS:
        rng, d = np.random.default_rng(seed), (1, 2, 3)[seed % 3]
        owner = np.repeat(np.arange(3), 6)
        noise = (
            rng.standard_t(2, size=(18, d))
            if seed % 5 < 2
            else rng.normal(size=(18, d))
            if seed % 5 < 4
            else rng.uniform(-1, 1, (18, d))
        )
        model = learned((0.3, 1.0, 2.0, 4.0)[seed % 4] * owner[:, None] + noise, owner)
        losses = {}
        for width in WIDTHS:
            for fall in FALLS:
                tried = replace(model, width=width, fall=fall)
                each = [alone(tried, owner, i) for i in range(18)]
                table = np.concatenate([likelihoods(by, by.values[[i]], by.values) for i, by in enumerate(each)])
                np.fill_diagonal(table, 0.0)
                # Five others of its own object, six of each other one.
                means = np.stack([table[:, owner == k].sum(axis=1) / (6 - (owner == k)) for k in range(3)], axis=1)
                losses[width, fall] = -np.log(means[np.arange(18), owner] / means.sum(axis=1)).mean()
        assert losses[model.width, model.fall] == pytest.approx(min(losses.values()), rel=1e-5)
        chosen.add((model.width, model.fall))
    assert len(chosen) == len(SEEDS_OF_KERNELS)


def test_of_kernels_that_name_as_well_the_one_with_the_heaviest_tail_is_kept() -> None:
    """With one object every kernel is right."""
    model = learned(np.arange(6.0)[:, None] ** 2, np.zeros(6, np.int64))
    assert (model.width, model.fall) == (min(WIDTHS), min(FALLS))


def test_one_example_alone_falls_as_the_fortieth_power_at_the_usual_distance() -> None:
    """It names nothing when it is left out; what it says stays finite."""
    model = learned(np.array([[5.0]]), np.zeros(1, np.int64))
    assert np.isnan(model.scores).all()
    # Its unit is 1, and .2 of that twice over is its scatter: it is as few examples as numbers.
    off = np.array([0.0, 1.0, -3.0])
    told = [model.log_kernel(np.array([5.0 + x]))[0] for x in off]
    np.testing.assert_allclose(told, -20 * np.log(1 + off**2 / 0.4), rtol=1e-5)


def test_two_examples_of_an_object_are_each_the_others_whole_likelihood() -> None:
    owner = np.array([0, 0, 1, 1])
    model = learned(np.array([0.0, 0.4, 1.0, 1.7])[:, None], owner)
    np.testing.assert_allclose(model.scores, conformity(model, owner, left_out=True), rtol=1e-5)


@pytest.mark.parametrize(("n_others", "likest"), [(2, 1), (9, 1), (19, 1), (20, 2), (31, 3), (50, 5)])
def test_the_power_is_told_by_the_tenth_of_other_things_that_is_most_like_the_object(
    n_others: int, likest: int
) -> None:
    rng = np.random.default_rng(n_others)
    owner = np.repeat(np.arange(2), (8, 30))
    table = rng.normal(size=(38, 2)) + 1.5 * owner[:, None]
    table[3] = np.nan
    # One of the likest or more feels as the first object does, all others feel otherwise and alike.
    others = rng.normal(9.0, 0.1, (n_others, 2))
    hidden = max(1, likest - 1)
    others[:hidden] = 0.0
    others[0] += 0.05
    model = learned(table, owner, others=others)
    told = plain_power(model, owner)
    np.testing.assert_allclose(model.power, told)
    assert told[0] == pytest.approx(1 - hidden / likest)


def plain_power(model: TouchModel, owner: np.ndarray, significance: float = 0.02) -> np.ndarray:
    """Share of the likest tenth, one at least, that conforms worse than all but a fiftieth of the object's own."""
    rest = likelihoods(model, model.others, model.others)
    np.fill_diagonal(rest, 0.0)
    unnamed = np.log(rest.sum(axis=1) / (len(rest) - 1))
    out = []
    for k in range(int(owner.max()) + 1):
        mine = (owner == k) & model.made
        odds = np.log(likelihoods(model, model.others, model.values[mine]).mean(axis=1)) - unnamed
        likest = np.sort(odds)[::-1][: max(1, len(rest) // 10)]
        out.append(np.mean(likest <= np.quantile(model.scores[mine], significance)))
    return np.array(out)


def test_a_thing_is_told_from_an_object_where_one_of_fifty_examples_conforms_as_badly() -> None:
    rng = np.random.default_rng(8)
    owner = np.zeros(51, np.int64)
    table = rng.normal(size=(51, 1))
    known = learned(table, owner, others=np.array([[2.0], [2.0]]))
    otherwise = {0.01: 0, 0.04: 0}
    for x in np.linspace(-2.6, -1.6, 61):
        model = with_scores(replace(known, others=np.array([[x], [x]])), owner)
        assert model.power[0] == plain_power(model, owner)[0]
        for share in otherwise:
            otherwise[share] += model.power[0] != plain_power(model, owner, share)[0]
    assert min(otherwise.values()) > 0


@pytest.mark.parametrize("n_others", [0, 1])
def test_without_two_other_things_no_power_is_known(n_others: int) -> None:
    assert np.isnan(holed(0, n_others=n_others)[0].power).all()
    assert np.isfinite(holed(0, n_others=2)[0].power).all()
    # Nor of an object that was never touched so.
    rng = np.random.default_rng(1)
    owner = np.repeat([0, 1], 5)
    table = rng.normal(size=(10, 2))
    table[owner == 0] = np.nan
    power = learned(table, owner, others=rng.normal(size=(9, 2))).power
    assert np.isnan(power).tolist() == [True, False]


@pytest.mark.parametrize("failed", [True, False])
def test_a_touch_succeeds_as_it_did_in_the_example_or_as_its_objects_rate_says(failed: bool) -> None:
    owner = np.array([2, 0, 1, 0, 2, 0, 1, 2])
    slipped = np.array([1, 0, 0, 1, 0, 0, 0, 0], bool)
    table = np.arange(8.0)[:, None]
    # Not tried in the last of each object; of the second it was tried in neither example.
    table[[0, 3, 5, 2, 6, 7]] = np.nan
    model = learned(table, owner, failed=slipped)
    # One of two tries failed of the first and of the third, with a tenth of a try more each way.
    rate = {0: 1.1 / 2.2, 1: 0.1 / 0.2, 2: 1.1 / 2.2}
    fails = np.array([0.9, 0.1, rate[1], 0.9, 0.1, rate[0], rate[1], rate[2]])
    np.testing.assert_allclose(np.exp(model.log_success(owner, failed=failed)), fails if failed else 1 - fails)
    never = learned(table, owner)
    assert not never.log_success(owner, failed=failed).any()
    unmade = replace(model, values=np.full((8, 1), np.nan))
    assert not unmade.log_success(owner, failed=failed).any()


def test_a_rate_is_of_the_tries_of_ones_own_object() -> None:
    owner = np.array([1, 1, 1, 1, 0, 0, 0])
    slipped = np.array([1, 1, 0, 0, 0, 0, 0], bool)
    table = np.array([np.nan, np.nan, 1.0, np.nan, 2.0, 3.0, np.nan])[:, None]
    told = np.exp(learned(table, owner, failed=slipped).log_success(owner, failed=True))
    assert told[3] == pytest.approx(2.1 / 3.2)
    assert told[6] == pytest.approx(0.1 / 2.2)


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_tempering_judges_examples_and_power_anew(share: float) -> None:
    model, owner = holed(2)
    soft = tempered(model, owner, share)
    assert (soft.fall, soft.width) == (share * model.fall, model.width)
    better = share * (conformity(model, owner) - model.scores)
    np.testing.assert_allclose(soft.scores, conformity(soft, owner) - better, rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(soft.power, plain_power(soft, owner))


def test_new_examples_are_judged_by_their_own_object_and_the_old_keep_their_scores() -> None:
    model, owner = holed(3)
    rng = np.random.default_rng(3)
    more = rng.normal(6, 1, (7, 3))
    more[2] = np.nan
    wider_owner = np.append(owner, np.full(7, 3))
    wider = replace(model, values=np.vstack([model.values, more]), failed=np.append(model.failed, np.zeros(7, bool)))
    wider = with_own_examples(wider, wider_owner, np.arange(27, 34))
    np.testing.assert_array_equal(wider.scores[:27], model.scores)
    np.testing.assert_allclose(wider.scores[27:], conformity(wider, wider_owner)[27:], rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(wider.power, plain_power(wider, wider_owner))
    np.testing.assert_array_equal(wider.power[:3], model.power)


def test_surprisal_of_examples_is_of_each_among_all() -> None:
    told = Calibration(np.array([3.0, np.nan, 1.0, 4.0, 2.0]))
    # It stands among the examples itself, once more.
    shares = [4 / 5, np.nan, 2 / 5, 1.0, 3 / 5]
    np.testing.assert_allclose(told.of_examples(), -np.log(shares))


def test_distances_are_never_below_nothing_and_means_are_taken_along_the_last_axis() -> None:
    rng = np.random.default_rng(0)
    far = (1e3 + rng.normal(0, 1e-4, (40, 3))).astype(np.float32)
    assert squared_distances(far, far).min() == 0.0
    assert squared_distances(far[:2], far).shape == (2, 40)
    p = rng.uniform(0.1, 1, (2, 3, 5))
    np.testing.assert_allclose(log_mean(np.log(p)), np.log(p.mean(axis=2)))
    np.testing.assert_allclose(log_mean(np.log(p) + 900), np.log(p.mean(axis=2)) + 900)


@pytest.mark.parametrize("seed", range(4))
def test_means_by_kind_are_of_the_examples_that_know_and_belief_gives_a_silent_kind_what_all_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    owner = rng.permutation(np.repeat(np.arange(3), 5))
    members = members_of_kinds(owner)
    np.testing.assert_array_equal(members, owner == np.arange(3)[:, None])
    told = rng.normal(-30, 3, (4, 15))
    told[rng.random(told.shape) < 0.2] = np.nan
    told[:, owner == 1] = -np.inf
    # What is less than any float says nothing, and is no silence.
    told[3, owner == 2], told[3, np.flatnonzero(owner == 0)[0]] = -2000.0, -20.0
    means, of_every = mean_by_kind(told, members), mean_by_every_kind(told, members)
    for row, judged, believed in zip(np.exp(np.where(np.isfinite(told), told, np.nan)), means, of_every, strict=True):
        assert judged[0] == pytest.approx(np.log(np.nanmean(row[owner == 0])))
        assert judged[1] == -np.inf
        assert believed[1] == pytest.approx(np.log(np.nanmean(row)))
    np.testing.assert_array_equal(of_every[:3, [0, 2]], means[:3, [0, 2]])
    assert means[0, 2] == pytest.approx(np.log(np.nanmean(np.exp(told[0, owner == 2]))))
    assert means[3, 2] == -np.inf
    assert of_every[3, 2] == pytest.approx(-20 + np.log(1e-300))
    nobody = np.full(15, -np.inf)
    assert np.isnan(mean_by_kind(nobody, members)).all()
    np.testing.assert_array_equal(mean_by_every_kind(nobody, members), np.full(3, np.log(1e-300)))


def test_with_fewer_numbers_the_kernel_falls_slower_by_the_root_of_their_share() -> None:
    metric = Metric(("a", "b", "c"), np.zeros(3), np.ones(3), np.eye(3))
    model = replace(holed(0)[0], metric=metric, width=0.5, fall=12.0)
    squares = np.array([0.0, 1.0, 30.0])
    for known in (1, 2, 3):
        expected = -(12.0 * np.sqrt(known / 3)) / 2 * np.log(1 + squares / (known * 0.25))
        np.testing.assert_allclose(model.kernel(squares, known), expected)
