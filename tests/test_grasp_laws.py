"""Laws of what stands behind the answer: likelihoods, decoders, ties, thresholds, what is said of a set's size."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.circuit import Hyperplane, Netlist, Score, Term, evaluate
from varishold.errors import InputError
from varishold.grasp import (
    HyperplaneClassifier,
    Selection,
    ThresholdEncoder,
    separating_set,
    shift_variants,
    training_grasps,
)
from varishold.grasp.certificate import certify, proved_flips
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.likelihood import GraspLikelihood, hamming, learn_likelihood, nearest_pattern
from varishold.grasp.modes.decoders import clearly_best, deal_folds, least_squares, nearest_code, one_against_one

Patterns = NDArray[np.bool_]
seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)


def labelled(rng: np.random.Generator, n: int, switches: int, classes: int) -> tuple[Patterns, NDArray[np.int64]]:
    """Different patterns, every class among them."""
    X = np.unique(rng.random((n, switches)) < 0.5, axis=0)
    labels = np.concatenate([np.arange(classes), rng.integers(0, classes, len(X) - classes)])
    return X, rng.permutation(labels)


def logic(rng: np.random.Generator, switches: int, classes: int) -> Netlist:
    """A circuit drawn at random, with few different scores, so that ties are many."""
    units = [
        Hyperplane([(k, int(w)) for k, w in enumerate(rng.integers(-1, 2, switches)) if w], int(rng.integers(-1, 2)))
        for _ in range(4)
    ]
    terms = [Term([(k, int(v)) for k, v in enumerate(rng.integers(-1, 2, 4)) if v >= 0] or [(0, 1)]) for _ in range(4)]
    scores = [
        Score([(t, int(w)) for t, w in enumerate(rng.integers(-1, 3, 4)) if w], int(rng.integers(0, 2)))
        for _ in range(classes)
    ]
    names = tuple(f"x{k}" for k in range(switches))
    return Netlist(names, (), tuple(units), tuple(terms), tuple(scores), tuple("abcdef"[:classes]))


@few
@given(seeds)
def test_a_certificate_holds_where_scores_tie(seed: int) -> None:
    rng = np.random.default_rng(seed)
    netlist = logic(rng, 5, 3)
    circuit = CompiledCircuit(netlist)
    X = np.array(list(product((0, 1), repeat=5)), dtype=np.bool_)
    answers = evaluate(netlist, X)
    np.testing.assert_array_equal(circuit.evaluate(X), answers)
    far = hamming(X, X)
    for k in range(0, 32, 5):
        other = far[k][answers != answers[k]]
        truth = int(other.min()) - 1 if other.size else 5
        assert proved_flips(circuit, X[k]) <= truth
        found = certify(circuit, X[k])
        assert (found.flips, found.exact) == (truth, True)
        if truth < 5:
            assert len(found.counterexample) == truth + 1
            there = X[k].copy()
            there[list(found.counterexample)] ^= True
            assert evaluate(netlist, there[None])[0] == found.other != answers[k]
        else:
            assert (found.counterexample, found.other) == ((), None)


def test_a_lone_unit_bears_as_many_flips_as_its_sum_exceeds_its_bias() -> None:
    nine = [(k, 1) for k in range(9)]
    netlist = Netlist(
        tuple(f"x{k}" for k in range(9)),
        (),
        (Hyperplane(nine, 4),),
        (Term([(0, 1)]),),
        (Score([(0, 2)], 0), Score([], 1)),
        ("many", "few"),
    )
    circuit = CompiledCircuit(netlist)
    for on in range(10):
        pattern = np.arange(9) < on
        # More than four of nine are on: the answer changes when it is four, or five again.
        assert proved_flips(circuit, pattern) == (on - 5 if on > 4 else 4 - on)


def test_a_set_says_whether_it_is_the_smallest() -> None:
    proved, loose = Selection((2,), 1), Selection((0, 1, 2), 2)
    assert (proved.gap, loose.gap) == (0, 1)
    assert str(proved) == "1 hyperplane, the fewest that separate the classes"
    assert str(Selection((0, 1), 2)) == "2 hyperplanes, the fewest that separate the classes"
    assert str(loose) == "3 hyperplanes; between 2 and 3 are needed (gap 1)"


@few
@given(seeds)
def test_without_a_solver_the_bound_is_still_a_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    signs, labels = rng.random((10, 9)) < 0.5, rng.integers(0, 5, 10)
    try:
        best = separating_set(signs, labels)
    except InputError:
        return
    greedy = separating_set(signs, labels, time_limit_s=0)
    # Two signs tell four classes at the most.
    assert greedy.lower_bound >= int(np.ceil(np.log2(len(np.unique(labels)))))
    assert greedy.lower_bound <= len(best.columns) <= len(greedy.columns)
    assert best.gap == 0


def test_five_classes_need_three_columns_and_four_need_two() -> None:
    signs = np.array(list(product((0, 1), repeat=3)), dtype=np.bool_)
    for classes, wanted in ((2, 1), (3, 2), (4, 2), (5, 3), (8, 3)):
        rows = signs[:, ::-1][:classes]
        found = separating_set(rows, np.arange(classes), time_limit_s=0)
        assert (len(found.columns), found.lower_bound) == (wanted, wanted)


@few
@given(seeds, st.floats(0.05, 3))
def test_likelihood_falls_with_every_switch_by_the_same_odds(seed: int, beta: float) -> None:
    rng = np.random.default_rng(seed)
    X, _ = labelled(rng, 3, 12, 2)
    if len(X) < 3:
        return
    told = GraspLikelihood(X, np.arange(3), np.ones(3, np.int64), 3, beta)
    V = rng.random((20, 12)) < 0.5
    mass = np.exp(-beta * (V[:, None] != X).sum(axis=2))
    posterior, p_values = told.judge(V)
    np.testing.assert_allclose(posterior, mass / mass.sum(axis=1, keepdims=True), atol=1e-9)
    assert (p_values == 1).all(), "nothing was held out"
    index, distance = nearest_pattern(V, told.patterns)
    np.testing.assert_array_equal(distance, (V[:, None] != X).sum(axis=2).min(axis=1))
    np.testing.assert_array_equal(index, (V[:, None] != X).sum(axis=2).argmin(axis=1))


def test_a_class_of_many_grasps_is_not_likelier_than_one_of_few() -> None:
    X = np.array([[0, 0, 0, 0], [1, 1, 1, 1], [0, 0, 0, 1]], dtype=np.bool_)
    often = GraspLikelihood(X[:2], np.array([0, 1]), np.array([9, 1]), 2, 1.0)
    none = np.zeros((1, 4), np.bool_)
    np.testing.assert_allclose(often.judge(np.array([[0, 0, 1, 1]], np.bool_))[0], [[0.5, 0.5]])
    # Two grasps of one class stand for it together: the mean of their likelihoods.
    both = GraspLikelihood(X, np.array([0, 1, 0]), np.array([3, 1, 1]), 2, 0.7)
    p = both.judge(none)[0][0]
    near = (3 + np.exp(-0.7)) / 4
    np.testing.assert_allclose(p, np.array([near, np.exp(-2.8)]) / (near + np.exp(-2.8)), rtol=1e-6)


def test_who_knows_no_grasp_holds_all_classes_alike() -> None:
    empty = GraspLikelihood(np.zeros((0, 3), np.bool_), np.zeros(0, np.int64), np.zeros(0, np.int64), 4, 1.0)
    posterior, p_values = empty.judge(np.ones((2, 3), np.bool_))
    np.testing.assert_allclose(posterior, 0.25)
    assert p_values.tolist() == [1.0, 1.0]
    index, distance = nearest_pattern(np.ones((2, 3), np.bool_), empty.patterns)
    assert (index.tolist(), distance.tolist()) == ([0, 0], [0, 0])


def held_out(
    X: Patterns, labels: NDArray[np.int64], groups: NDArray[np.int64], beta: float
) -> tuple[list[float], list[float]]:
    """Of each grasp whose class is left: its class's share, and how strange it is, to the grasps of other groups."""
    shares, strange = [], []
    for k in range(len(X)):
        rest = groups != groups[k]
        if not (rest & (labels == labels[k])).any():
            continue
        mass = np.exp(-beta * (X[rest] != X[k]).sum(axis=1))
        mean = [mass[labels[rest] == c].mean() if (labels[rest] == c).any() else 0.0 for c in np.unique(labels)]
        shares.append(mean[labels[k]] / sum(mean))
        strange.append(-np.log(np.mean(mean)))
    return shares, strange


@settings(max_examples=25)
@given(seeds, st.sampled_from([0, 2, 5]))
def test_beta_tells_each_grasp_best_by_those_of_other_groups(seed: int, n_groups: int) -> None:
    rng = np.random.default_rng(seed)
    patterns, of = labelled(rng, 14, 8, 2)
    again = rng.integers(1, 3, len(patterns))
    X, labels = np.repeat(patterns, again, axis=0), np.repeat(of, again)
    groups = np.arange(len(X)) if n_groups == 0 else rng.integers(0, n_groups, len(X))
    grasps = training_grasps(X, labels.tolist())
    learned = learn_likelihood(grasps, groups)
    np.testing.assert_array_equal(grasps.patterns[grasps.owners], X)
    shares, strange = held_out(X, labels, groups, learned.beta)
    if not shares:
        return
    np.testing.assert_allclose(np.sort(learned.known), np.sort(strange), atol=1e-5)
    # What is learned is at least as good as twice or half of it, or lies at the end of what is tried.
    loss = [-np.mean(np.log(held_out(X, labels, groups, learned.beta * by)[0])) for by in (1.0, 1.6, 1 / 1.6)]
    assert loss[0] <= loss[1] + 1e-6 or learned.beta > 3.9
    assert loss[0] <= loss[2] + 1e-6 or learned.beta < 0.021


@settings(max_examples=25)
@given(seeds)
def test_contradictory_grasps_are_evidence_of_each_of_their_classes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    X, labels = rng.random((30, 3)) < 0.5, rng.permutation(np.arange(30) % 3)
    grasps = training_grasps(X, labels.tolist())
    assert grasps.contradictions
    learned = learn_likelihood(grasps)
    of_row = np.array(grasps.classes)
    V = np.array(list(product([False, True], repeat=3)))
    kernel = np.exp(-learned.beta * (V[:, None] != X).sum(axis=2))
    mass = np.column_stack([kernel[:, labels == k].mean(axis=1) for k in of_row])
    np.testing.assert_allclose(learned.judge(V)[0], mass / mass.sum(axis=1, keepdims=True), atol=1e-6)
    strange = held_out(X, labels, np.arange(30), learned.beta)[1]
    np.testing.assert_allclose(np.sort(learned.known), np.sort(strange), atol=1e-5)


def test_what_is_known_of_grasps_without_fellows() -> None:
    X = np.tri(9, 8, -1, dtype=np.bool_)  # each one switch from the next
    # A grasp of no fellow has another class alone to be strange to; one that was made twice has its own.
    lonely = learn_likelihood(training_grasps(X[[0, 8]], [0, 1]))
    np.testing.assert_allclose(lonely.known, 8 + np.log(2))
    assert (lonely.beta, lonely.n_known) == (1.0, 2)
    twice = learn_likelihood(training_grasps(X[[0, 0, 8, 8]], [0, 0, 1, 1]))
    np.testing.assert_allclose(twice.known, np.log(2), atol=1e-3)
    single = learn_likelihood(training_grasps(X[:1], [0]))
    assert (single.known.size, single.n_known, single.beta) == (0, 0, 1.0)
    # How far the readings lay beyond counts in switches.
    far = learn_likelihood(training_grasps(X, [0] * 9), beyond=np.arange(9.0))
    near = learn_likelihood(training_grasps(X, [0] * 9))
    np.testing.assert_allclose(far.known - near.known, near.beta * np.arange(9.0), atol=1e-9)
    assert [told.learned for told in (lonely, twice, single)] == [False, True, False]
    # Grasps that contradict what was learned place no hyperplane.
    against = training_grasps(X[[0, 0, 0, 8]], [0, 0, 1, 1])
    assert against.owners.tolist() == [0, 0, -1, 1]


def signs_of(rng: np.random.Generator, n: int, m: int) -> NDArray[np.float64]:
    return np.where(rng.random((n, m)) < 0.5, -1.0, 1.0)


@few
@given(seeds)
def test_the_nearest_code_is_the_class_whose_majority_agrees_most(seed: int) -> None:
    rng = np.random.default_rng(seed)
    signs, labels = signs_of(rng, 12, 7), rng.integers(0, 3, 12)
    weights = rng.integers(1, 4, 12)
    slopes, offsets = nearest_code(signs, labels, weights, 4)
    for k in range(4):
        votes = np.repeat(signs, weights, axis=0)[np.repeat(labels, weights) == k].sum(axis=0)
        np.testing.assert_array_equal(slopes[k], np.sign(votes))
    answers = (signs @ slopes.T + offsets).argmax(axis=1)
    assert set(answers.tolist()) <= set(labels.tolist())


@few
@given(seeds, st.sampled_from([(6, 12), (25, 5)]), st.floats(0.01, 2))
def test_ridge_regression_is_least_squares_with_every_class_alike(
    seed: int, shape: tuple[int, int], ridge: float
) -> None:
    rng = np.random.default_rng(seed)
    n, m = shape
    signs = signs_of(rng, n, m)
    labels = np.concatenate([np.arange(3), rng.integers(0, 3, n - 3)])
    weights = rng.integers(1, 4, n)
    slopes, offsets = least_squares(signs, labels, weights, 3, ridge=ridge)
    importance = weights / np.bincount(labels, weights=weights)[labels]
    importance = importance * n / importance.sum()

    def cost(slope: NDArray[np.float64], offset: float, k: int) -> float:
        target = np.where(labels == k, 1.0, -1.0)
        return float(importance @ (signs @ slope + offset - target) ** 2 + ridge * m * (slope @ slope))

    for k in range(3):
        least = cost(slopes[k], offsets[k], k)
        for _ in range(6):
            step = rng.normal(0, 1e-3, m + 1)
            assert cost(slopes[k] + step[:-1], offsets[k] + step[-1], k) >= least - 1e-9
    twice = least_squares(signs, labels, 2 * weights, 3, ridge=ridge)
    np.testing.assert_allclose(twice[0], slopes, atol=1e-9)


@settings(max_examples=10)
@given(seeds, st.integers(2, 4))
def test_machines_add_up_their_margins(seed: int, classes: int) -> None:
    from sklearn.svm import SVC

    rng = np.random.default_rng(seed)
    codes = signs_of(rng, classes, 9)
    labels = np.repeat(np.arange(classes), 5)
    signs = codes[labels] * np.where(rng.random((len(labels), 9)) < 0.15, -1.0, 1.0)
    weights = np.ones(len(labels), np.int64)
    slopes, offsets = one_against_one(signs, labels, weights, classes + 1, cost=1.0)
    machine = SVC(kernel="linear", C=1.0, class_weight="balanced", decision_function_shape="ovo")
    margins = machine.fit(signs / 3, labels).decision_function(signs / 3).reshape(len(labels), -1)
    sums = np.zeros((len(labels), classes))
    if classes == 2:
        sums[:, 1] = margins[:, 0]
    else:
        pairs = [(a, b) for a in range(classes) for b in range(a + 1, classes)]
        for (a, b), margin in zip(pairs, margins.T, strict=True):
            sums[:, a] += margin
            sums[:, b] -= margin
    scores = signs @ slopes.T + offsets
    np.testing.assert_allclose(scores[:, :classes], sums, atol=1e-6)
    # A class that no grasp is of is never the answer, whatever the signs.
    anything = signs_of(rng, 50, 9) @ slopes.T + offsets
    assert (anything.argmax(axis=1) < classes).all()


def test_another_decoder_is_taken_only_where_it_is_clearly_better() -> None:
    right = np.zeros((3, 100))
    right[0, :50] = 1
    right[1, :52] = 1
    right[2, :70] = 1
    assert clearly_best(right, 0) == 2
    assert clearly_best(right[:2], 0) == 0  # two of a hundred are chance
    assert clearly_best(right[:2], 1) == 1  # never a worse one
    assert clearly_best(right[[2, 0]], 0) == 0
    assert clearly_best(np.zeros((3, 0)), 1) == 1
    assert clearly_best(np.ones((2, 40)), 1) == 1


@few
@given(seeds, st.integers(2, 5))
def test_folds_share_every_class_alike_and_keep_copies_together(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    groups = rng.integers(0, 20, 40)
    labels = groups % 3
    fold_of = deal_folds(labels, groups, count, rng)
    assert fold_of.min() >= 0
    assert fold_of.max() < count
    for group in np.unique(groups):
        assert len(set(fold_of[groups == group])) == 1
    for label in range(3):
        own = np.unique(groups[labels == label])
        sizes = np.bincount([fold_of[groups == g][0] for g in own], minlength=count)
        assert sizes.max() - sizes.min() <= 1


@few
@given(seeds, st.integers(1, 6))
def test_thresholds_stand_where_their_strategy_says(seed: int, levels: int) -> None:
    rng = np.random.default_rng(seed)
    column = np.concatenate([np.zeros(5), rng.integers(1, 1000, 40)]).astype(float)
    (even,) = ThresholdEncoder("even", levels=levels).fit(column[:, None]).thresholds_
    np.testing.assert_array_equal(
        even, np.unique(np.ceil([column.max() * k / (levels + 1) for k in range(1, levels + 1)]))
    )
    (shares,) = ThresholdEncoder("quantile", levels=levels).fit(column[:, None]).thresholds_
    loaded = column[column > 0]
    # The lowest that is no rest is on, and each step up leaves about as many more off: equal values go together.
    assert shares[0] == loaded.min()
    for k, threshold in enumerate(shares):
        if len(shares) == levels:
            off, off_or_at = (loaded < threshold).mean(), (loaded <= threshold).mean()
            assert off - 1 / len(loaded) - 1e-9 <= k / levels <= off_or_at + 1 / len(loaded) + 1e-9
    y = (column > 500).astype(int)
    if len(set(y)) == 2:
        (told,) = ThresholdEncoder("supervised", levels=levels).fit(column[:, None], y).thresholds_
        assert told.shape == (1,)
        np.testing.assert_array_equal(column >= told[0], y)


@few
@given(
    st.floats(-1e5, 1e5), st.floats(1e-3, 1e3), st.integers(2, 5), st.sampled_from(["quantile", "even", "supervised"])
)
@example(32768.0, 0.001953125, 3, "supervised")
def test_the_values_of_a_channel_of_few_are_told_apart_whatever_its_unit(
    rest: float, step: float, n_values: int, strategy: str
) -> None:
    # Counts of the circuit divide what is largest into some 2**28: smaller steps are none.
    values = rest + step * np.arange(n_values)
    column = np.repeat(values, 3)
    bits = (
        ThresholdEncoder(strategy, levels=4)
        .fit(column[:, None], np.arange(len(column)) // 3)
        .transform(values[:, None])
    )
    assert (np.diff(bits.sum(axis=1)) >= 1).all()
    # What rests is off, but where nothing ever changes.
    assert not bits[0].any()


@few
@given(seeds, st.integers(4, 40), st.booleans())
def test_one_threshold_alone_halves_what_does_not_rest(seed: int, n: int, shared: bool) -> None:
    rng = np.random.default_rng(seed)
    column = rng.uniform(-1, 1) + rng.permutation(n).astype(float) * rng.uniform(0.1, 10)
    bits = ThresholdEncoder("quantile", levels=1, shared=shared).fit_transform(column[:, None])
    assert bits.shape == (n, 1)
    assert abs(int(bits.sum()) - n / 2) <= 1
    # What rests is touched or not.
    resting = np.append(column, [column.min()] * n)
    bits = ThresholdEncoder("quantile", levels=1, shared=shared).fit_transform(resting[:, None])
    np.testing.assert_array_equal(bits[:, 0], resting > column.min())


def test_a_switch_in_volts_is_a_switch() -> None:
    for low, high in ((0.0, 3.3), (0.1, 1.1), (-2e-9, 1e-9), (1e6 + 0.1, 1e6 + 0.2)):
        read = np.array([low, high] * 5)[:, None]
        np.testing.assert_array_equal(ThresholdEncoder().fit(read).transform(read), read == high)


def test_a_channel_is_counted_finely_enough_for_its_range_and_coarsely_enough_for_the_circuit() -> None:
    rng = np.random.default_rng(0)
    X = np.column_stack(
        [
            rng.integers(-50, 50, 200),
            rng.uniform(0, 1, 200),
            1e6 + rng.uniform(0, 1, 200),
            rng.uniform(0, 1e12, 200),
            np.full(200, 2.5),
        ]
    )
    step = ThresholdEncoder().fit(X).resolution_
    assert step[0] == 1
    assert 2**16 <= np.ptp(X[:, 1]) / step[1] <= 2**17
    assert (np.abs(X).max(axis=0) / step <= 2**31 - 1).all()
    assert (np.log2(step) % 1 == 0).all()
    assert step[2] <= 1 / 256
    assert (np.abs(X[:, 2:4]).max(axis=0) / step[2:4]).max() > 2**15
    assert ThresholdEncoder().fit([[0.0], [float(2**31)]]).resolution_[0] > 1
    assert ThresholdEncoder().fit([[0.0], [float(2**31 - 1)]]).resolution_[0] == 1


@few
@given(st.integers(1, 4), st.integers(1, 5), st.integers(1, 3), st.booleans())
def test_a_shifted_array_reads_what_lies_beside(rows: int, columns: int, distance: int, diagonal: bool) -> None:
    found = {tuple(row) for row in shift_variants((rows, columns), distance=distance, diagonal=diagonal).tolist()}
    wanted = set()
    for down in range(-distance, distance + 1):
        for right in range(-distance, distance + 1):
            if (down, right) == (0, 0) or abs(down) >= rows or abs(right) >= columns:
                continue
            if down and right and not diagonal:
                continue
            wanted.add(
                tuple(
                    (r - down) * columns + c - right if 0 <= r - down < rows and 0 <= c - right < columns else -1
                    for r in range(rows)
                    for c in range(columns)
                )
            )
    assert found == wanted


@pytest.mark.parametrize("mode", ["paper", "robust", "vote", "auto"])
def test_a_circuit_learned_from_clear_grasps_bears_flipped_switches(mode: str) -> None:
    rng = np.random.default_rng(6)
    prototypes = np.zeros((3, 24), np.bool_)
    for k in range(3):
        prototypes[k, 8 * k : 8 * k + 8] = True
    y = np.repeat(["a", "b", "c"], 8)
    X = np.repeat(prototypes, 8, axis=0) ^ (rng.random((24, 24)) < 0.03)
    clf = HyperplaneClassifier(mode, max_hyperplanes=60).fit(X, y)  # type: ignore[arg-type]
    assert (clf.predict(X) == y).all()
    fresh = np.repeat(prototypes, 60, axis=0) ^ (rng.random((180, 24)) < 0.08)
    assert np.mean(clf.predict(fresh) == np.repeat(["a", "b", "c"], 60)) > (0.85 if mode == "paper" else 0.97)
    p = clf.predict_proba(prototypes)
    assert (p.argmax(axis=1) == [0, 1, 2]).all()
    assert p.max(axis=1).min() > 0.9
