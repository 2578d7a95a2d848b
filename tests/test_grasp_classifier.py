"""Laws of the classifier: one circuit, no order, honest certificates."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from varishold.circuit import Netlist, Score, evaluate
from varishold.errors import InputError
from varishold.grasp import HyperplaneClassifier, shift_variants, training_grasps
from varishold.grasp.certificate import certify, proved_flips, unit_flips
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.hyperplanes import Hyperplanes, bisectors
from varishold.grasp.likelihood import hamming
from varishold.grasp.modes import MODES, ModeOptions
from varishold.grasp.modes.learned import circuit_of
from varishold.grasp.training import TrainingGrasps

Patterns = NDArray[np.bool_]


def noisy_grasps(
    seed: int, *, classes: int = 2, each: int = 8, switches: int = 12, flips: float = 0.1
) -> tuple[Patterns, NDArray[np.str_]]:
    rng = np.random.default_rng(seed)
    prototypes = rng.random((classes, switches)) < 0.5
    X = np.repeat(prototypes, each, axis=0) ^ (rng.random((classes * each, switches)) < flips)
    return X, np.repeat([f"object {k}" for k in range(classes)], each)


seeds = st.integers(0, 10_000)


def nearest_terms(grasps: TrainingGrasps, label: int) -> tuple[Hyperplanes, list[tuple[tuple[int, int], ...]]]:
    """All bisectors of a class's grasps with their enemies, and one term a grasp: the unpruned circuit.

    The OR of the terms is true exactly where the nearest training grasp belongs to the class; of equally
    near ones of different classes the lexicographically smallest counts, for a tie gives s = 0.
    """
    own, enemies = np.flatnonzero(grasps.labels == label), np.flatnonzero(grasps.labels != label)
    i, j = (side.ravel() for side in np.meshgrid(own, enemies, indexing="ij"))
    planes = bisectors(grasps.patterns[i], grasps.patterns[j])
    wanted = (i > j).astype(int).reshape(len(own), len(enemies))
    numbers = np.arange(len(planes)).reshape(wanted.shape)
    return planes, [tuple(zip(n.tolist(), w.tolist(), strict=True)) for n, w in zip(numbers, wanted, strict=True)]


modes = st.sampled_from(sorted(MODES))


@settings(max_examples=25)
@given(seeds, modes, st.integers(2, 4))
def test_neither_row_order_nor_class_names_matter(seed: int, mode: str, classes: int) -> None:
    X, y = noisy_grasps(seed, classes=classes)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(X))
    names = dict(zip(sorted(set(y.tolist())), rng.permutation([f"n{k}" for k in range(classes)]), strict=True))
    V = rng.random((200, X.shape[1])) < 0.5
    here = HyperplaneClassifier(mode).fit(X, y)  # type: ignore[arg-type]
    there = HyperplaneClassifier(mode).fit(X[order], [names[label] for label in y[order]])  # type: ignore[arg-type]
    assert [names[label] for label in here.predict(V)] == there.predict(V).tolist()
    np.testing.assert_array_equal(here.hyperplanes_.weights, there.hyperplanes_.weights)


@settings(max_examples=25)
@given(seeds, modes, st.integers(2, 4))
def test_the_classifier_answers_as_its_netlist(seed: int, mode: str, classes: int) -> None:
    X, y = noisy_grasps(seed, classes=classes)
    clf = HyperplaneClassifier(mode).fit(X, y)  # type: ignore[arg-type]
    V = np.random.default_rng(seed).random((200, X.shape[1])) < 0.5
    by_netlist = np.array(clf.netlist_.classes)[evaluate(clf.netlist_, V)]
    assert clf.predict(V).tolist() == by_netlist.tolist()
    probabilities = clf.predict_proba(V)
    np.testing.assert_allclose(probabilities.sum(axis=1), 1)
    np.testing.assert_array_equal(clf.classes_[probabilities.argmax(axis=1)], clf.predict(V))


@settings(max_examples=15)
@given(seeds)
def test_paper_mode_answers_every_training_grasp(seed: int) -> None:
    X, y = noisy_grasps(seed, classes=3, flips=0.2)
    clf = HyperplaneClassifier("paper").fit(X, y)
    told = [k for k in range(len(X)) if all(k + 1 not in rows for rows in clf.grasps_.contradictions)]
    assert clf.predict(X[told]).tolist() == y[told].tolist()
    assert clf.selection_ is not None
    assert clf.selection_.gap == 0


@settings(max_examples=15)
@given(seeds)
def test_the_printed_circuit_answers_what_was_learned_of_contradictory_grasps_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    X, y = rng.random((20, 3)) < 0.5, rng.permutation(np.repeat([0, 1], 10))
    clf = HyperplaneClassifier("paper").fit(X, y)
    table = clf.minimal_table_
    for pattern, label in zip(clf.grasps_.patterns, clf.grasps_.labels.tolist(), strict=True):
        (signs,) = clf.hyperplanes_.signs(pattern[None])
        for k, name in enumerate(clf.grasps_.classes):
            true = any(all(signs[at] == wanted for at, wanted in term) for term in table.terms(name))
            assert true == (k == label)


@settings(max_examples=30)
@given(seeds, st.integers(0, 1))
def test_the_unpruned_terms_are_the_nearest_training_grasp(seed: int, label: int) -> None:
    X, y = noisy_grasps(seed, flips=0.3)
    grasps = training_grasps(X, y.tolist())
    if len(set(grasps.labels.tolist())) < 2:
        return
    planes, terms = nearest_terms(grasps, label)
    scores = [Score([(t, 2) for t in range(len(terms))]) if k == label else Score([], 1) for k in (0, 1)]
    V = np.random.default_rng(seed).random((300, X.shape[1])) < 0.5
    answers = evaluate(circuit_of(grasps, planes, terms, scores), V)
    # Patterns stand in lexicographic order: argmin takes the lexicographically smallest of equally near ones.
    np.testing.assert_array_equal(answers, grasps.labels[hamming(V, grasps.patterns).argmin(axis=1)])


def least_changing_flips(netlist: Netlist, pattern: Patterns) -> int:
    answer = evaluate(netlist, pattern[None])[0]
    for size in range(1, len(pattern) + 1):
        for chosen in combinations(range(len(pattern)), size):
            flipped = pattern.copy()
            flipped[list(chosen)] ^= True
            if evaluate(netlist, flipped[None])[0] != answer:
                return size
    return len(pattern) + 1


@settings(max_examples=15)
@given(seeds, modes)
def test_the_certificate_is_sound_and_exact(seed: int, mode: str) -> None:
    X, y = noisy_grasps(seed, switches=7, each=5, classes=2 + seed % 2)
    clf = HyperplaneClassifier(mode, max_hyperplanes=12).fit(X, y)  # type: ignore[arg-type]
    circuit = CompiledCircuit(clf.netlist_)
    for pattern in np.random.default_rng(seed).random((3, 7)) < 0.5:
        truth = least_changing_flips(clf.netlist_, pattern) - 1
        assert proved_flips(circuit, pattern) <= truth
        certificate = certify(circuit, pattern)
        assert certificate.exact
        assert certificate.flips == truth
        if certificate.counterexample:
            assert len(certificate.counterexample) == truth + 1
            flipped = pattern.copy()
            flipped[list(certificate.counterexample)] ^= True
            assert circuit.evaluate(flipped[None])[0] == certificate.other


@settings(max_examples=20)
@given(seeds)
def test_the_flips_of_a_unit_are_those_of_the_formula(seed: int) -> None:
    X, y = noisy_grasps(seed)
    clf = HyperplaneClassifier("paper").fit(X, y)
    grasps = clf.grasps_
    rows = {int(number): pattern for number, pattern in zip(grasps.numbers, grasps.patterns, strict=True)}
    pattern = np.random.default_rng(seed).random(X.shape[1]) < 0.5
    for flips, (i, j) in zip(unit_flips(CompiledCircuit(clf.netlist_), pattern), clf.hyperplanes_.pairs, strict=True):
        near, far = hamming(pattern[None], np.array([rows[int(i)], rows[int(j)]]))[0]
        df = int(far - near)
        assert flips == (-(-df // 2) if df > 0 else (-df) // 2 + 1)


def test_an_explanation_names_its_reasons() -> None:
    X = [[1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 1]]
    clf = HyperplaneClassifier("paper").fit(X, ["round", "square"])
    why = clf.explain([1, 1, 0, 0, 0, 0])
    assert why.label == "round"
    assert why.nearest == (1, "round", 1)
    assert why.hyperplanes[0].pair == (1, 2)
    assert why.hyperplanes[0].agreeing == (1, 2, 4, 5, 6)
    assert why.hyperplanes[0].opposing == (3,)
    assert (why.certified_flips, why.exact, len(why.flips), why.other) == (1, True, 2, "square")
    assert "the answer bears any 1 wrong switch;" in str(why)


def test_many_switches_get_a_proved_bound() -> None:
    X, y = noisy_grasps(0, switches=200, each=3)
    clf = HyperplaneClassifier("paper").fit(X, y)
    why = clf.explain(X[0])
    assert not why.exact
    assert why.certified_flips >= 10


@settings(max_examples=15)
@given(seeds, modes)
def test_adding_a_class_keeps_the_hyperplanes(seed: int, mode: str) -> None:
    X, y = noisy_grasps(seed, classes=3, switches=14)
    old = y != "object 2"
    clf = HyperplaneClassifier(mode, max_hyperplanes=20).fit(X[old], y[old])  # type: ignore[arg-type]
    before = {row.tobytes() for row in clf.hyperplanes_.weights}
    clf.add_class(X[~old], "object 2")
    assert before <= {row.tobytes() for row in clf.hyperplanes_.weights}
    assert clf.classes_.tolist() == ["object 0", "object 1", "object 2"]
    assert len(clf.grasps_) + sum(len(d) - 1 for d in clf.grasps_.duplicates) <= len(X)
    assert np.mean(clf.predict(X) == y) > 0.8


def test_strange_patterns_are_rejected() -> None:
    X, y = noisy_grasps(1, switches=40, flips=0.05)
    clf = HyperplaneClassifier().fit(X, y)
    labels, rejected = clf.predict_or_reject(np.concatenate([X, ~X]))
    assert labels.tolist() == clf.predict(np.concatenate([X, ~X])).tolist()
    assert rejected[: len(X)].sum() == 0
    assert rejected[len(X) :].all()
    _, unsure = clf.predict_or_reject(X, min_probability=1.1)
    assert unsure.all()


def test_contradictions_are_reported_and_answered() -> None:
    X = [[1, 0], [1, 0], [0, 1], [0, 1]]
    for mode in ("auto", *MODES):
        clf = HyperplaneClassifier(mode).fit(X, ["a", "b", "a", "b"])  # type: ignore[arg-type]
        assert clf.grasps_.contradictions == ((1, 2), (3, 4))
        assert "grasps 1, 2 have equal patterns but different labels" in clf.remarks_
        assert set(clf.predict(X)) <= {"a", "b"}
        assert "bears" in str(clf.explain([1, 0]))


def test_a_mode_says_which_sizes_it_takes() -> None:
    learn = np.random.default_rng(0).random((1300, 30)) < 0.5
    with pytest.raises(InputError, match="up to 600 different patterns, got 1300; use mode 'vote'"):
        HyperplaneClassifier("paper").fit(learn, np.arange(1300) % 2)


@pytest.mark.parametrize(("mode", "classes", "switches"), [("robust", 50, 64), ("paper", 20, 300)])
def test_a_mode_that_cannot_do_well_says_so(mode: str, classes: int, switches: int) -> None:
    X, y = noisy_grasps(0, classes=classes, each=30, switches=switches)
    known = np.arange(len(y)) % 30 < 10
    poor, good = (HyperplaneClassifier(m).fit(X[known], y[known]) for m in (mode, "vote"))  # type: ignore[arg-type]
    (told,) = [text for text in poor.remarks_ if text.startswith(f"mode {mode!r} names")]
    assert told.endswith("mode 'vote' does better with many objects or switches")
    assert poor.score(X[~known], y[~known]) < 0.8
    assert not [text for text in good.remarks_ if "noisy copies" in text]
    assert good.score(X[~known], y[~known]) > 0.95


def test_duplicates_are_reported() -> None:
    clf = HyperplaneClassifier().fit([[1, 0], [1, 0], [0, 1]], ["a", "a", "b"])
    assert clf.grasps_.duplicates == ((1, 2),)
    assert clf.remarks_ == ("1 grasp repeats the pattern and label of an earlier one",)


def test_the_same_seed_learns_the_same_circuit() -> None:
    X, y = noisy_grasps(3, classes=4)
    one, other = (HyperplaneClassifier("vote", random_state=5).fit(X, y) for _ in range(2))
    assert one.netlist_ == other.netlist_


def test_the_robust_mode_keeps_to_its_number_of_hyperplanes() -> None:
    X, y = noisy_grasps(4, switches=22, each=10, flips=0.2)
    clf = HyperplaneClassifier("robust", max_hyperplanes=3).fit(X, y)
    assert len(clf.hyperplanes_) <= 3


def test_variants_teach_shifted_grasps() -> None:
    rng = np.random.default_rng(0)
    shapes = {"bar": np.zeros((6, 6), dtype=bool), "block": np.zeros((6, 6), dtype=bool)}
    shapes["bar"][1:5, 2] = True
    shapes["block"][2:4, 2:4] = True
    X = np.array([s.ravel() ^ (rng.random(36) < 0.02) for s in shapes.values() for _ in range(4)])
    y = np.repeat(list(shapes), 4)
    shifted = np.array([np.roll(s, (1, 1), axis=(0, 1)).ravel() for s in shapes.values()])
    clf = HyperplaneClassifier("vote", variants=shift_variants((6, 6), diagonal=True)).fit(X, y)
    assert clf.predict(shifted).tolist() == ["bar", "block"]
    assert len(clf.grasps_) <= 8


def test_a_class_that_is_refused_leaves_what_was_learned_whole() -> None:
    X, y = noisy_grasps(5, switches=9)
    clf = HyperplaneClassifier("vote").fit(X, y)
    before = clf.predict(X).tolist(), clf.predict_proba(X).tolist()
    clf.set_params(variants=[[9] * 9])
    with pytest.raises(InputError, match="variants must be integers from -1 to 8"):
        clf.add_class(X[:2], "a name before all others")
    with pytest.raises(InputError, match="variants must be integers from -1 to 8"):
        clf.fit(X[:6], [f"another {k % 3}" for k in range(6)])
    assert (clf.predict(X).tolist(), clf.predict_proba(X).tolist()) == before


def test_shifts_of_thermometer_bits_move_whole_channels() -> None:
    bits = np.array([2, 1, 3])
    variants = shift_variants((1, 3), axes=(0, 1), bits=bits)
    assert variants.tolist() == [[2, 2, 3, -1, -1, -1], [-1, -1, 0, 2, 2, 2]]


@pytest.mark.parametrize("mode", sorted(MODES))
def test_one_learned_class_answers_that_class(mode: str) -> None:
    grasps = training_grasps(np.array([[1, 0], [1, 0], [0, 1]], dtype=bool), ["a", "b", "a"])
    learned = MODES[mode](grasps, ModeOptions())
    answers = evaluate(learned.netlist, np.array([[0, 0], [1, 1]]))
    assert {grasps.classes[k] for k in answers} == {"a"}
