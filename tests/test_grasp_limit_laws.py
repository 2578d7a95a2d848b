"""Training grasps against a dictionary, decoders by their names, and the edges of what may be learned."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_grasp_mode_laws import grasps_of

from varishold.circuit import Hyperplane, Netlist, Score, Term, evaluate
from varishold.errors import InputError
from varishold.grasp import HyperplaneClassifier, Hyperplanes, bisectors, certificate, likelihood, separating
from varishold.grasp import held_out as held_out_module
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.held_out import held_out_of, hold_out
from varishold.grasp.likelihood import GraspLikelihood, nearest_pattern
from varishold.grasp.modes import ModeOptions, decoders, paper, robust, vote
from varishold.grasp.modes.decoders import DECODERS, least_squares, one_against_one
from varishold.grasp.modes.learned import class_names, constant_circuit, term_scores, units_of
from varishold.grasp.separating import separating_set
from varishold.grasp.training import training_grasps

few = settings(max_examples=30)
seeds = st.integers(0, 2**32 - 1)


# Training grasps, and those held out


@few
@given(seeds, st.integers(1, 12))
def test_training_grasps_are_a_dictionary_of_patterns(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    X, y = rng.random((n, 3)) < 0.5, [str(c) for c in rng.choice(list("pqr"), n)]
    rows: dict[tuple[bool, ...], list[int]] = {}
    for k, row in enumerate(X.tolist()):
        rows.setdefault(tuple(row), []).append(k)
    told = training_grasps(X, y)
    learned, owners, duplicates, contradictions = [], [-1] * n, [], []
    for pattern in sorted(rows):
        votes = {label: [k for k in rows[pattern] if y[k] == label] for label in sorted(set(y))}
        most = max(map(len, votes.values()))
        best = [label for label, of in votes.items() if len(of) == most]
        if len(rows[pattern]) > 1:
            one_class = len({y[k] for k in rows[pattern]}) == 1
            (duplicates if one_class else contradictions).append(tuple(k + 1 for k in rows[pattern]))
        if len(best) == 1:
            for k in votes[best[0]]:
                owners[k] = len(learned)
            learned.append((pattern, best[0], most, votes[best[0]][0] + 1))
    assert [tuple(row) for row in told.patterns.tolist()] == [of[0] for of in learned]
    assert [told.classes[k] for k in told.labels] == [of[1] for of in learned]
    assert told.weights.tolist() == [of[2] for of in learned]
    assert told.numbers.tolist() == [of[3] for of in learned]
    assert told.duplicates == tuple(sorted(duplicates))
    assert told.contradictions == tuple(sorted(contradictions))
    assert told.owners.tolist() == owners
    # Classes of fewest patterns first, those of none last.
    counts = [sum(of[1] == label for of in learned) for label in told.classes]
    assert set(told.classes) == set(y)
    assert counts == sorted(counts, key=lambda count: (count == 0, count))
    seen = told.seen
    assert [
        (*row, told.classes[k]) for row, k in zip(seen.patterns[seen.owners], seen.labels[seen.owners], strict=True)
    ] == [(*row, name) for row, name in zip(X, y, strict=True)]
    assert len(seen) == len({(*row, name) for row, name in zip(X.tolist(), y, strict=True)})
    assert seen.weights.tolist() == [(seen.owners == k).sum() for k in range(len(seen))]
    held = hold_out(seen, None, 0.0)
    if held is not None:
        for pattern, left in zip(held.patterns, held.left, strict=True):
            wanted = seen.weights.copy()
            wanted[pattern] -= 1
            np.testing.assert_array_equal(left, wanted)
            fellows = (left > 0) & (seen.labels == seen.labels[pattern])
            assert fellows.any() == held.fellows


@pytest.mark.parametrize("part", ["groups", "beyond"])
@pytest.mark.parametrize("wrong", [[0, -1, 1], [0, 1], [[0, 1, 2]], [0.5, "a", 1], [0, 1, 2, 3]])
def test_what_a_file_says_of_grasps_held_out_is_checked(part: str, wrong: list[object]) -> None:
    document = {"groups": [0, 3, 3], "beyond": [0.0, 0.5, 2]}
    groups, beyond = held_out_of(document, 3)
    assert (groups.tolist(), beyond.tolist()) == ([0, 3, 3], [0.0, 0.5, 2.0])
    groups, beyond = held_out_of({"groups": None, "beyond": None}, 2)
    assert (groups.tolist(), beyond.tolist()) == ([0, 1], [0.0, 0.0])
    with pytest.raises((InputError, ValueError)):
        held_out_of({**document, part: wrong}, 3)


def test_any_number_of_patterns_is_judged_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    told = GraspLikelihood(rng.random((6, 8)) < 0.5, np.arange(6) % 3, np.arange(1, 7), 3, 0.8)
    V = rng.random((11, 8)) < 0.5
    whole = *told.judge(V), *nearest_pattern(V, told.patterns)
    for entries in (1, 12, 13, 66):
        monkeypatch.setattr(likelihood, "_CHUNK_ENTRIES", entries)
        for one, other in zip((*told.judge(V), *nearest_pattern(V, told.patterns)), whole, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-12)
        step = max(1, entries // 6)
        assert [len(range(11)[rows]) for rows in likelihood._chunks(11, 6)] == [
            min(step, 11 - start) for start in range(0, 11, step)
        ]
    assert told.flip_rate == pytest.approx(1 / (1 + np.exp(0.8)))


# Ways of learning


def test_every_decoder_is_what_its_name_says() -> None:
    rng = np.random.default_rng(1)
    signs = np.where(rng.random((20, 7)) < 0.5, -1.0, 1.0)
    labels, weights = np.arange(20) % 3, rng.integers(1, 4, 20)
    for name, decode in DECODERS.items():
        kind, _, number = name.rpartition(" ")
        if kind == "least squares, ridge":
            wanted = least_squares(signs, labels, weights, 3, ridge=float(number))
        elif kind == "one against one, cost":
            wanted = one_against_one(signs, labels, weights, 3, cost=float(number))
        else:
            assert name == "nearest code"
            continue
        for one, other in zip(decode(signs, labels, weights, 3), wanted, strict=True):
            np.testing.assert_array_equal(one, other)
    # A pattern's weight is how often it was made.
    as_often = np.repeat(signs, weights, axis=0), np.repeat(labels, weights), np.ones(weights.sum(), np.int64)
    for one, other in zip(
        least_squares(signs, labels, weights, 3, ridge=0.5),
        least_squares(*as_often, 3, ridge=0.5 * weights.sum() / len(signs)),
        strict=True,
    ):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_hyperplanes_are_halved_only_while_that_tells_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vote, "_FEWEST", 1)
    rng = np.random.default_rng(4)
    decode = DECODERS["least squares, ridge 0.1"]

    def fewest(patterns: np.ndarray, labels: np.ndarray, n_planes: int) -> int:
        grasps = training_grasps(patterns, labels.tolist())
        planes = Hyperplanes(np.eye(patterns.shape[1], dtype=np.int8)[:n_planes])
        signs = np.where(planes.signs(grasps.patterns), 1.0, -1.0)
        return vote._fewest_as_good(grasps, planes, signs, np.arange(len(grasps)), decode, np.random.default_rng(0))

    # One switch tells all: one hyperplane is as good as sixteen.
    easy = rng.random((150, 16)) < 0.5
    assert fewest(easy, easy[:, 0].astype(int), 16) == 1
    # Every switch tells a little of a majority: all sixteen are wanted.
    hard = rng.random((300, 16)) < 0.5
    assert fewest(hard, (hard.sum(axis=1) > 8).astype(int), 16) == 16


def test_robust_terms_are_made_of_so_many_patterns(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    grasps = grasps_of(rng, 20, 10, 2)
    monkeypatch.setattr(robust, "ROBUST_PATTERNS", len(grasps))
    assert robust.learn_robust(grasps, ModeOptions()).netlist.classes == ("0", "1")
    monkeypatch.setattr(robust, "ROBUST_PATTERNS", len(grasps) - 1)
    with pytest.raises(InputError, match=rf"takes up to {len(grasps) - 1} different patterns, got {len(grasps)}; use"):
        robust.learn_robust(grasps, ModeOptions())


@few
@given(seeds)
def test_circuits_of_terms_score_two_points_a_term(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, 12, 6, 3)
    planes = Hyperplanes(rng.integers(-1, 2, (3, 6)).astype(np.int8), pairs=np.array([[0, 3], [-1, -1], [2, 1]]))
    units = units_of(planes)
    assert [unit.pair for unit in units] == [(0, 3), None, (2, 1)]
    for unit, row, bias in zip(units, planes.weights.tolist(), planes.biases, strict=True):
        assert unit.weights == tuple((k, w) for k, w in enumerate(row) if w)
        assert unit.bias == bias
    counts = np.bincount(grasps.labels, weights=grasps.weights, minlength=3)
    constant = constant_circuit(grasps, planes)
    assert set(evaluate(constant, grasps.patterns)) == {int(counts.argmax())}
    assert len(constant.units) == 3
    terms_of = {k: [((k, 1),), ((0, 0), (1, 1))] for k in range(int(rng.integers(1, 4)))}
    products, scores = term_scores(grasps, terms_of)
    assert products == [term for terms in terms_of.values() for term in terms]
    default = len(terms_of) if len(terms_of) < 3 else int(counts.argmax())
    for k, score in enumerate(scores):
        assert score.weights == (((2 * k, 2), (2 * k + 1, 2)) if k in terms_of else ())
        assert score.bias == int(k == default)


def test_names_of_classes_are_texts_that_differ() -> None:
    assert class_names(["a", "", 1, "1", "1'", True]) == ["a", "(empty)", "1", "1'", "1''", "True"]


def test_options_have_limits() -> None:
    X, y = [[0, 1], [1, 0], [1, 1]], ["a", "b", "b"]
    for wrong, message in (
        ({"flip_rate": 0.5}, "flip_rate must be at least 0 and below 0.5, got 0.5"),
        ({"flip_rate": -0.01}, "flip_rate must be at least 0"),
        ({"error": 0.0}, "error must lie between 0 and 1, got 0.0"),
        ({"error": 1.0}, "error must lie between 0 and 1, got 1.0"),
        ({"max_hyperplanes": 0}, "max_hyperplanes must be positive or None, got 0"),
        ({"mode": "best"}, "mode must be auto, paper, robust, vote, got 'best'"),
        ({"variants": [[0, 2]]}, r"variants must be integers from -1 to 1 of shape \(n_variants, 2\)"),
        ({"variants": [[0, -2]]}, "variants must be integers from -1 to 1"),
        ({"variants": [0, 1]}, "variants must be integers from -1 to 1"),
        ({"variants": [[0.0, 1.0]]}, "variants must be integers from -1 to 1"),
        ({"variants": [[0, 1, 1]]}, "variants must be integers from -1 to 1"),
    ):
        with pytest.raises(InputError, match=message):
            HyperplaneClassifier(**{"mode": "vote", **wrong}).fit(X, y)
    fine = HyperplaneClassifier("vote", max_hyperplanes=1, flip_rate=0.0, error=0.999, variants=[[-1, 1]])
    assert set(fine.fit(X, y).predict(X)) <= {"a", "b"}


@pytest.mark.parametrize(
    ("limits", "n", "folds", "machines"),
    [
        ({}, 60, 5, True),
        ({"_FIVE_FOLDS": 60}, 60, 5, True),
        ({"_FIVE_FOLDS": 59}, 60, 1, True),
        ({"_CHOOSING": 40}, 40, 5, True),
        ({"_CHOOSING": 60}, 60, 5, True),
        ({"_MACHINES": 60 * 9}, 60, 5, True),
        ({"_MACHINES": 60 * 9 - 1}, 60, 5, False),
        ({"_MACHINE_CLASSES": 3}, 60, 5, True),
        ({"_MACHINE_CLASSES": 2}, 60, 5, False),
    ],
)
def test_decoders_are_compared_on_so_many_grasps_in_so_many_folds(
    monkeypatch: pytest.MonkeyPatch, limits: dict[str, int], n: int, folds: int, machines: bool
) -> None:
    for name, most in limits.items():
        monkeypatch.setattr(decoders, name, most)
    asked: dict[str, list[int]] = {}

    def spy(name: str) -> decoders.Decoder:
        def decode(signs: np.ndarray, labels: np.ndarray, weights: np.ndarray, n_classes: int) -> decoders.Weights:
            asked.setdefault(name, []).append(len(signs))
            assert len(signs) == len(labels) == len(weights)
            # Of all of these only one knows.
            known = "cost 1" if machines else "ridge 1"
            slopes = DECODERS["least squares, ridge 0.1"](signs, labels, weights, n_classes)
            return slopes if name.endswith(known) else (np.zeros((n_classes, signs.shape[1])), np.zeros(n_classes))

        return decode

    rng = np.random.default_rng(0)
    labels = np.arange(60) % 3
    signs = np.where(rng.random((3, 9)) < 0.5, -1.0, 1.0)[labels]
    signs *= np.where(rng.random(signs.shape) < 0.05, -1.0, 1.0)
    monkeypatch.setattr(decoders, "DECODERS", {name: spy(name) for name in DECODERS})
    chosen = decoders.choose_decoder(signs, labels, np.ones(60, np.int64), np.arange(60), 3, rng)
    assert chosen == ("one against one, cost 1" if machines else "least squares, ridge 1")
    assert set(asked) == {name for name in DECODERS if machines or not name.startswith("one against one")}
    for sizes in asked.values():
        assert len(sizes) == folds
        # What is held out is a fifth each time, or a quarter once.
        held = n * folds - sum(sizes)
        assert abs(held - (n if folds == 5 else n / 4)) <= (0 if folds == 5 else 2)


def test_sets_are_looked_for_alike_in_blocks_and_up_to_a_size(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    for _ in range(12):
        signs, labels = rng.random((9, 8)) < 0.5, np.arange(9) % 3
        pairs = [(i, j) for i, j in itertools.combinations(range(9), 2) if labels[i] != labels[j]]
        whole, greedy = separating_set(signs, labels), separating.greedy_cover(signs, labels)
        assert whole.gap == 0
        for name, most in (("_COLUMNS_AT_ONCE", 1), ("_COLUMNS_AT_ONCE", 3), ("_REDUCTION_ROWS", 0)):
            with monkeypatch.context() as patch:
                patch.setattr(separating, name, most)
                assert len(separating_set(signs, labels).columns) == len(whole.columns)
                assert separating.greedy_cover(signs, labels) == greedy
        size = len(pairs) * signs.shape[1]
        for spare in (-1, 0):
            with monkeypatch.context() as patch:
                patch.setattr(separating, "_SOLVER_ENTRIES", size + spare)
                assert (separating._cover_matrix(signs, labels, ()) is None) == (spare < 0)
        cover = separating._cover_matrix(signs, labels, (2,))
        assert cover is not None
        apart = {tuple(signs[i] != signs[j]) for i, j in pairs if signs[i, 2] == signs[j, 2]}
        least = {row for row in apart if not any(o != row and all(np.array(o) <= row) for o in apart)}
        assert {tuple(row) for row in cover.tolist()} == least


def test_so_many_grasps_are_held_out(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    grasps = grasps_of(rng, 40, 12, 2)
    n = len(grasps)
    everyone = held_out_module.hold_out(grasps, None, np.arange(40.0))
    assert everyone is not None
    assert len(everyone.patterns) == len(everyone.beyond) == 40
    for name, most, judged in (
        ("_JUDGES", 40, 40),
        ("_JUDGES", 9, 9),
        ("_JUDGED_DISTANCES", 40 * n, 40),
        ("_JUDGED_DISTANCES", 7 * n + 3, 7),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(held_out_module, name, most)
            some = held_out_module.hold_out(grasps, None, np.arange(40.0))
        assert some is not None
        assert len(some.patterns) == judged
        for pattern, beyond, left in zip(some.patterns, some.beyond, some.left, strict=True):
            assert grasps.owners[int(beyond)] == pattern
            assert left.sum() == grasps.weights.sum() - 1
        assert (np.diff(some.beyond) > 0).all()


@pytest.mark.parametrize(
    ("exact", "budget", "flips"),
    [(6, 0, None), (5, 14, 1), (5, 15, 2), (5, 34, 2), (5, 35, 3), (5, 49, 3), (5, 50, None)],
)
def test_flips_are_searched_up_to_so_many_patterns(
    monkeypatch: pytest.MonkeyPatch, exact: int, budget: int, flips: int | None
) -> None:
    monkeypatch.setattr(certificate, "EXACT_SWITCHES", exact)
    monkeypatch.setattr(certificate, "_BUDGET", budget)
    monkeypatch.setattr(certificate, "_BATCH", 4)
    # Two pairs of six switches must be on: each unit proves one flip, together they bear three.
    units = tuple(Hyperplane([(a, 1), (a + 1, 1)], 1) for a in (0, 2))
    scores = Score([], 1), Score([(0, 2)])
    circuit = CompiledCircuit(Netlist(tuple("abcdef"), (), units, (Term([(0, 1), (1, 1)]),), scores, ("off", "on")))
    off = np.zeros(6, np.bool_)
    assert certificate.proved_flips(circuit, off) == 1
    told = certificate.certify(circuit, off)
    found = (told.flips, told.exact, told.counterexample, told.other)
    assert found == ((3, True, (0, 1, 2, 3), 1) if flips is None else (flips, False, (), None))


def test_modes_say_how_many_patterns_they_take(monkeypatch: pytest.MonkeyPatch) -> None:
    grasps = grasps_of(np.random.default_rng(0), 20, 10, 2)
    n = len(grasps)
    monkeypatch.setattr(paper, "PAPER_PATTERNS", n)
    assert paper.learn_paper(grasps, ModeOptions()).selection is not None
    monkeypatch.setattr(paper, "PAPER_PATTERNS", n - 1)
    with pytest.raises(InputError, match=rf"takes up to {n - 1} different patterns, got {n}; use mode 'vote'"):
        paper.learn_paper(grasps, ModeOptions())


@few
@given(seeds, st.integers(1, 40))
def test_candidates_of_a_class_are_its_bisectors_with_the_nearest_enemies(seed: int, most: int) -> None:
    grasps = grasps_of(np.random.default_rng(seed), 15, 9, 3)
    own = grasps.labels == 0
    if not own.any() or own.all():
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(robust, "_CANDIDATES", most)
        planes, owners = robust._candidates(grasps, own, ~own, None)
    rows, foes = np.flatnonzero(own), np.flatnonzero(~own)
    each = min(len(foes), max(1, most // len(rows)))
    wanted: dict[tuple[int, ...], set[int]] = {}
    for n, row in enumerate(rows):
        distance = (grasps.patterns[row] != grasps.patterns[foes]).sum(axis=1)
        for foe in foes[np.argsort(distance, kind="stable")[:each]]:
            plane = bisectors(grasps.patterns[[row]], grasps.patterns[[foe]]).weights[0]
            wanted.setdefault(tuple(plane.tolist()), set()).add(n)
    assert [tuple(row) for row in planes.weights.tolist()] == list(wanted)
    for k, of in enumerate(wanted.values()):
        assert set(np.flatnonzero(owners[:, k])) == of
    accepted = np.random.default_rng(seed).random((5, 60)) < 0.4
    terms = robust._covering_terms(accepted)
    assert len(set(terms)) == len(terms)
    assert (accepted.any(axis=0) & ~accepted[terms].any(axis=0)).sum() <= 0.05 * 60
    assert (accepted.any(axis=0) & ~accepted[terms[:-1]].any(axis=0)).sum() > 0.05 * 60
    left = accepted.any(axis=0)
    for term in terms:
        gains = (accepted & left).sum(axis=1)
        assert gains[term] == gains.max()
        left = left & ~accepted[term]
