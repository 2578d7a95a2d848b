"""What is learned of grasps against the plainest way of saying it: sums, dictionaries, all sets; and limits' edges."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.test_grasp_mode_laws import grasps_of

from varishold.circuit import Hyperplane, Netlist, Score, Term, evaluate
from varishold.errors import InputError
from varishold.grasp import Hyperplanes, bisectors, hyperplanes, separating_set
from varishold.grasp import compiled as compiled_module
from varishold.grasp.certificate import certify, proved_flips, unit_flips
from varishold.grasp.compiled import CompiledCircuit
from varishold.grasp.explanation import _deciding, explain_pattern
from varishold.grasp.hyperplanes import align, distinct
from varishold.grasp.modes.learned import units_of
from varishold.grasp.separating import greedy_cover, smallest_sets

few = settings(max_examples=30)
seeds = st.integers(0, 2**32 - 1)


def drawn(rng: np.random.Generator, switches: int = 6, classes: int = 3, n_units: int = 4) -> Netlist:
    """Any circuit over switches."""

    def pairs(n: int) -> list[tuple[int, int]]:
        return [(k, int(w)) for k, w in enumerate(rng.integers(-2, 3, n)) if w]

    units = [Hyperplane(pairs(switches), int(rng.integers(-2, 3))) for _ in range(n_units)]
    terms = [Term([(k, int(v)) for k, v in enumerate(rng.integers(-1, 2, n_units)) if v >= 0]) for _ in range(5)]
    scores = [Score(pairs(5), int(rng.integers(-2, 3))) for _ in range(classes)]
    channels = tuple(f"x{k + 1}" for k in range(switches))
    return Netlist(channels, (), tuple(units), tuple(terms), tuple(scores), tuple("abcdef"[:classes]))


# Hyperplanes


@few
@given(seeds, st.integers(1, 9), st.integers(0, 7), st.sampled_from([1, 20, 1 << 25]))
def test_an_excess_is_a_sum_less_a_bias_whatever_is_multiplied_at_a_time(
    seed: int, switches: int, n: int, block: int
) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.integers(-1, 2, (n, switches)).astype(np.int8)
    planes = Hyperplanes(weights)
    patterns = rng.random((5, switches)) < 0.5
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hyperplanes, "_BLOCK_WEIGHTS", block)
        excess = planes.excess(patterns)
    wanted = [[int(w[p].sum()) - math.floor(w.sum() / 2) for w in weights.astype(int)] for p in patterns]
    assert excess.tolist() == wanted
    assert excess.dtype == np.int32
    np.testing.assert_array_equal(planes.signs(patterns), np.array(wanted).reshape(5, n) > 0)
    # s = 1 where the weighted sum of -1 and 1 is above 0 (eq. [24]).
    np.testing.assert_array_equal(planes.signs(patterns), (2 * patterns - 1) @ weights.T.astype(int) > 0)
    assert len(planes) == n
    np.testing.assert_array_equal(planes.pairs, np.full((n, 2), -1))


def test_planes_over_no_switch_and_over_too_many() -> None:
    none = Hyperplanes(np.zeros((0, 0), np.int8))
    assert none.excess(np.zeros((3, 0), np.bool_)).shape == (3, 0)
    # Single precision holds whole numbers up to 2**24.
    assert Hyperplanes(np.zeros((0, 2**24 - 1), np.int8)).n_switches == 2**24 - 1
    for shape in ((0, 2**24), (3,), (1, 2, 3)):
        with pytest.raises(InputError, match=r"weights must be a table \(hyperplanes, switches\), got \("):
            Hyperplanes(np.zeros(shape, np.int8))
    for wrong in ({"names": ("I",)}, {"pairs": np.zeros((1, 2), np.int64)}, {"pairs": np.zeros((2, 3), np.int64)}):
        with pytest.raises(InputError, match="2 hyperplanes need as many names and pairs"):
            Hyperplanes(np.zeros((2, 3), np.int8), **wrong)
    for weight in (-2, 2):
        with pytest.raises(InputError, match="must be -1, 0 or 1"):
            Hyperplanes(np.array([[weight]], np.int8))


@few
@given(seeds)
def test_planes_are_taken_and_joined_by_their_weights(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sets = [
        Hyperplanes(rng.integers(-1, 2, (n, 2)).astype(np.int8), pairs=rng.integers(1, 99, (n, 2)))
        for n in rng.integers(1, 6, 2)
    ]
    rows: dict[tuple[int, ...], list[int]] = {}
    for planes in sets:
        for weights, pair in zip(planes.weights.tolist(), planes.pairs.tolist(), strict=True):
            rows.setdefault(tuple(weights), pair)
    joined = distinct(*sets)
    assert [tuple(row) for row in joined.weights.tolist()] == list(rows)
    assert joined.pairs.tolist() == list(rows.values())
    order = rng.permutation(len(joined))[:3]
    taken = joined.take(order)
    np.testing.assert_array_equal(taken.weights, joined.weights[order])
    np.testing.assert_array_equal(taken.pairs, joined.pairs[order])
    assert taken.names == ("I", "II", "III")[: len(order)]


def test_restricted_bisectors_look_at_their_switches_alone() -> None:
    first, second = np.array([[1, 1, 0, 1]], np.bool_), np.array([[0, 1, 1, 0]], np.bool_)
    within = np.array([[False, True, True, True]])
    numbers = np.array([[4, 9]])
    plane = bisectors(first, second, within=within, pairs=numbers, orient=False)
    assert (plane.weights.tolist(), plane.pairs.tolist()) == ([[0, 0, -1, 1]], [[4, 9]])
    turned = bisectors(first, second, within=within, pairs=numbers)
    assert (turned.weights.tolist(), turned.pairs.tolist()) == ([[0, 0, 1, -1]], [[9, 4]])
    two = np.concatenate([first, second])
    with pytest.raises(InputError, match="pair 1 holds two equal patterns"):
        bisectors(two, np.concatenate([second, second]))
    assert align([["", "ab"], ["name", "c"]]) == "      ab\nname   c"


# Circuits as matrices


@few
@given(seeds, st.integers(1, 5), st.sampled_from([1, 30, 4_000_000]))
def test_a_compiled_circuit_answers_as_its_netlist(seed: int, classes: int, entries: int) -> None:
    rng = np.random.default_rng(seed)
    netlist = drawn(rng, 6, classes)
    X = np.array(list(itertools.product((False, True), repeat=6)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled_module, "_CHUNK_ENTRIES", entries)
        circuit = CompiledCircuit(netlist)
    answers = circuit.evaluate(X)
    np.testing.assert_array_equal(answers, evaluate(netlist, X))
    assert answers.dtype == np.int64
    sums = [[sum(w * x[b] for b, w in unit.weights) - unit.bias for unit in netlist.units] for x in X.astype(int)]
    np.testing.assert_array_equal(circuit.excess(X), np.array(sums).reshape(len(X), -1))
    fired = np.array(sums).reshape(len(X), -1) > 0
    holds = [[all(f[u] == v for u, v in term.literals) for term in netlist.terms] for f in fired]
    np.testing.assert_array_equal(circuit.true_terms(fired), holds)
    assert circuit.n_switches == 6


@few
@given(seeds)
def test_flips_that_turn_a_unit_or_an_answer_are_counted_by_trying_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    netlist = drawn(rng, 5, int(rng.integers(1, 4)))
    circuit, pattern = CompiledCircuit(netlist), rng.random(5) < 0.5
    answer, fires = int(circuit.evaluate(pattern[None])[0]), circuit.excess(pattern[None])[0] > 0
    units, first = np.full(len(netlist.units), np.inf), None
    for size in range(1, 6):
        for chosen in itertools.combinations(range(5), size):
            other = pattern.copy()
            other[list(chosen)] ^= True
            turned = (circuit.excess(other[None])[0] > 0) != fires
            units = np.where(turned & np.isinf(units), size, units)
            if first is None and int(circuit.evaluate(other[None])[0]) != answer:
                first = (chosen, int(circuit.evaluate(other[None])[0]))
    np.testing.assert_array_equal(unit_flips(circuit, pattern), units)
    told = certify(circuit, pattern)
    assert told.exact
    if first is None:
        assert (told.flips, told.counterexample, told.other) == (5, (), None)
    else:
        assert (told.flips, told.counterexample, told.other) == (len(first[0]) - 1, *first)
    assert proved_flips(circuit, pattern) <= told.flips


@few
@given(seeds)
def test_an_explanation_names_what_speaks_for_the_answer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grasps = grasps_of(rng, 14, 8, 3)
    planes = Hyperplanes(
        rng.integers(-1, 2, (4, 8)).astype(np.int8), pairs=np.array([[1, 2], [3, 4], [-1, -1], [5, 6]])
    )
    netlist = drawn(rng, 8, 3)
    netlist = Netlist(netlist.channels, (), units_of(planes), netlist.terms, netlist.scores, netlist.classes)
    circuit, pattern = CompiledCircuit(netlist), grasps.patterns[0]
    fired = circuit.excess(pattern[None])[0] > 0
    holds = [all(fired[u] == v for u, v in term.literals) for term in netlist.terms]
    scores = [sum(w * holds[t] for t, w in score.weights) + score.bias for score in netlist.scores]
    answer = scores.index(max(scores))
    rival = max((k for k in range(3) if k != answer), key=lambda k: (scores[k], -k))
    worth = np.zeros(4)
    for t, term in enumerate(netlist.terms):
        lead = dict(netlist.scores[answer].weights).get(t, 0) - dict(netlist.scores[rival].weights).get(t, 0)
        for u, v in term.literals:
            if holds[t]:
                worth[u] += max(lead, 0)
            elif fired[u] != v:
                worth[u] += max(-lead, 0)
    order = [int(k) for k in np.argsort(-worth, kind="stable") if worth[k] > 0]
    assert _deciding(circuit, fired, answer) == order
    told = explain_pattern(circuit, planes, pattern, labels=["p", "q", "r"], nearest=(7, "q", 2))
    assert told.label == "pqr"[answer]
    assert len(told.hyperplanes) == len(order)
    for reason, k in zip(told.hyperplanes, order, strict=True):
        signed = planes.weights[k] * (2 * pattern - 1) * (1 if fired[k] else -1)
        assert (reason.name, reason.sign) == (planes.names[k], int(fired[k]))
        assert reason.pair == (None if k == 2 else tuple(planes.pairs[k]))
        assert reason.agreeing == tuple(np.flatnonzero(signed > 0) + 1)
        assert reason.opposing == tuple(np.flatnonzero(signed < 0) + 1)
        flips = unit_flips(circuit, pattern)[k]
        assert reason.flips == (None if np.isinf(flips) else flips)
    lines = str(told).splitlines()
    assert lines[0] == "pqr"[answer]
    assert lines[1 + len(order)] == "  nearest training grasp: v7 (q), 2 switches differ"
    n = told.certified_flips
    bears = "no wrong switch for certain" if n == 0 else f"any {n} wrong switch{'es' if n > 1 else ''}"
    assert lines[-1].startswith(f"  the answer bears {bears}")
    if told.flips:
        which = " ".join(f"x{k}" for k in told.flips)
        assert lines[-1].endswith(f"; {which} read wrongly would make it {told.other}")


# Sets that separate


@few
@given(seeds, st.sets(st.integers(0, 5), max_size=3))
def test_with_kept_columns_the_set_is_the_smallest_that_holds_them(seed: int, keep: set[int]) -> None:
    rng = np.random.default_rng(seed)
    signs, labels = rng.random((7, 6)) < 0.5, rng.integers(0, 3, 7)
    apart = [signs[i] != signs[j] for i, j in itertools.combinations(range(7), 2) if labels[i] != labels[j]]

    def separates(columns: tuple[int, ...]) -> bool:
        return all(row[list(columns)].any() for row in apart)

    if not separates(tuple(range(6))):
        return
    kept = tuple(sorted(keep))
    found = separating_set(signs, labels, keep=kept)
    sizes = [n for n in range(7) for c in itertools.combinations(range(6), n) if keep <= set(c) and separates(c)]
    assert keep <= set(found.columns)
    assert separates(found.columns)
    assert found.columns == tuple(sorted(found.columns))
    assert len(found.columns) == min(sizes)
    assert found.lower_bound <= min(sizes)
    greedy = greedy_cover(signs, labels, keep=kept)
    assert greedy[: len(kept)] == list(kept)
    assert separates(tuple(greedy))
    for column in greedy[len(kept) :]:
        assert not separates(tuple(c for c in greedy if c != column))
    size = len(found.columns)
    every = [c for c in itertools.combinations(range(6), size) if separates(c)]
    assert smallest_sets(signs, labels, size=size) == every
    assert smallest_sets(signs, labels, size=size, limit=math.comb(6, size)) == every
    assert smallest_sets(signs, labels, size=size, limit=math.comb(6, size) - 1) is None
