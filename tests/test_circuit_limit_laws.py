"""Covers against all that could be chosen, inputs for checks, and the edges of every limit."""

from __future__ import annotations

import itertools
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.circuit_inputs import MOST, all_bits, few
from tests.test_circuit_laws import drawn, read

from varishold.circuit import (
    Comparator,
    Hyperplane,
    Netlist,
    Score,
    Term,
    evaluate,
    evaluation,
    minimization,
    minimize,
    synthesis,
)
from varishold.circuit.elements import shown
from varishold.circuit.gates import GateNetwork
from varishold.circuit.packed.program import OPERATIONS, compile_program
from varishold.circuit.synthesis import exceeds, synthesize
from varishold.circuit.writers.vectors import check_vectors
from varishold.errors import InputError

# Covers


@pytest.mark.parametrize("without", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_the_fewest_rows_win_and_the_fewest_literals_among_these(
    seed: int, without: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if without:
        monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    rng = np.random.default_rng(seed)
    covers = rng.random((9, 6)) < 0.4
    covers[rng.integers(9, size=6), np.arange(6)] = True
    # Rows of few literals tempt to take more of them.
    literals = rng.choice([1, 1, 2, 9], 9).tolist()
    greedy = minimization._greedy_cover(covers)
    assert covers[greedy].any(axis=0).all()
    for k in greedy:
        rest = [other for other in greedy if other != k]
        assert not (rest and covers[rest].any(axis=0).all())
    found, proved = minimization._minimum_cover(covers, literals, greedy, limited=False)
    every = [c for n in range(1, 7) for c in itertools.combinations(range(9), n) if covers[list(c)].any(axis=0).all()]
    assert proved
    assert covers[found].any(axis=0).all()
    assert (len(found), sum(literals[k] for k in found)) == min((len(c), sum(literals[k] for k in c)) for c in every)
    kept = minimization._undominated(covers, literals)
    for k in range(9):
        # Another covers all that it covers, is as short, and covers more, is shorter or stands before it.
        beaten = any(
            (covers[j] >= covers[k]).all()
            and literals[j] <= literals[k]
            and ((covers[j] > covers[k]).any() or (literals[j], j) < (literals[k], k))
            for j in range(9)
            if j != k
        )
        assert (k not in kept) == beaten
    assert kept == sorted(kept)


@few
@given(st.lists(st.integers(1, 63), min_size=1, max_size=6))
def test_hitting_sets_are_all_that_meet_every_set_and_none_is_too_large(sets: list[int]) -> None:
    told = minimization._minimal_hitting_sets(sets, None)
    meets = [h for h in range(64) if all(h & s for s in sets)]
    wanted = {h for h in meets if not any(o != h and o & h == o for o in meets)}
    assert told is not None
    assert len(told) == len(wanted)
    assert set(told) == wanted
    assert minimization._minimal_hitting_sets(sets, 0) is None
    most = 0
    for k in range(1, len(sets) + 1):
        most = max(most, len(minimization._minimal_hitting_sets(sets[:k], None) or []))
    assert minimization._minimal_hitting_sets(sets, most) == told
    assert minimization._minimal_hitting_sets(sets, most - 1) is None


def test_what_differs_is_kept_once_and_without_what_holds_it() -> None:
    off = np.array([[0, 0, 1], [1, 1, 1], [1, 1, 0], [0, 0, 1], [0, 1, 1]], np.uint8)
    # From 0 0 0: bits 2; 0 1 2; 0 1; 2; 1 2. Those that hold another are hit with it.
    assert minimization._differences(np.zeros(3, np.uint8), off) == [0b100, 0b011]


@pytest.mark.parametrize("spare", [-1, 0])
def test_so_many_primes_are_still_all_found(monkeypatch: pytest.MonkeyPatch, spare: int) -> None:
    patterns = all_bits(4)
    odd = patterns.sum(axis=1) % 2 == 1
    # Parity has eight primes, one for each pattern.
    monkeypatch.setattr(minimization, "_MOST_PRIMES", 8 + spare)
    assert minimize(patterns[odd], patterns[~odd]).proved == (spare == 0)
    monkeypatch.undo()
    monkeypatch.setattr(minimization, "_LARGEST_EXACT_TABLE", 8 * 8 + spare)
    assert minimize(patterns[odd], patterns[~odd]).proved == (spare == 0)
    monkeypatch.undo()
    monkeypatch.setattr(minimization, "_MOST_PRIMES_EACH", 1 + spare)
    assert minimize(patterns[odd], patterns[~odd]).proved == (spare == 0)


def test_a_cover_takes_patterns_of_any_type() -> None:
    cover = minimize([[True, False]], [[False, False]])
    for rows in ([[1, 0], [0, 0]], [[1.0, 0.0], [0.0, 0.0]], np.array([[True, False], [False, False]])):
        told = cover(rows)
        assert told.tolist() == [True, False]
        assert told.dtype == np.bool_
    assert minimize([[1.0, 0.0]], [[0.0, 0.0]]) == cover
    with pytest.raises(InputError, match="off must hold 0 and 1 only"):
        minimize([[1, 0]], np.zeros((1, 2), complex))


# Inputs for checks


@pytest.mark.parametrize("r", [1, 3, 5, 70])
def test_every_pattern_is_checked_where_there_are_few(r: int) -> None:
    netlist = drawn(np.random.default_rng(0), switches=r, classes=2)
    if r < 10:
        for most in (2**r, 2**r + 5):
            X = check_vectors(netlist, most)
            np.testing.assert_array_equal(X, np.arange(2**r)[:, None] >> np.arange(r) & 1)
    for most in (min(2**r - 1, 400), min(2**r, 301) // 2 + 1):
        X = check_vectors(netlist, most)
        assert X.shape == (most, r)
        assert X.dtype == np.int64
        assert set(np.unique(X)) <= {0, 1}
        np.testing.assert_array_equal(check_vectors(netlist, most), X)
    if r == 70:
        X = check_vectors(netlist, 400)
        # Half far from one another, half near one pattern, two flips from it on average.
        random, near = X[:200], X[200:]
        centre = np.median(near, axis=0)
        assert np.abs(random - 0.5).mean() == 0.5
        assert 0.4 < random.mean() < 0.6
        assert 1.0 < np.abs(near - centre).sum(axis=1).mean() < 3.0
        assert 30 < np.abs(random - centre).sum(axis=1).mean() < 40
        odd = check_vectors(netlist, 401)
        assert np.abs(odd[201:] - np.median(odd[201:], axis=0)).sum(axis=1).mean() < 3.0


@pytest.mark.parametrize(("largest", "low", "high"), [(127, -128, 127), (MOST, -MOST, MOST), (32767, -32768, 32767)])
def test_counts_are_checked_at_every_threshold_and_at_both_ends(largest: int, low: int, high: int) -> None:
    comparators = (Comparator(0, 40), Comparator(0, -17), Comparator(2, 3), Comparator(0, 41))
    netlist = Netlist(("a", "b", "c"), comparators, (), (), (Score([]),), ("any",))
    X = check_vectors(netlist, 600, largest=largest)
    assert X.shape == (600, 3)
    for channel, edges in enumerate(([39, 40, 41, 42, -18, -17, -16], [], [2, 3, 4])):
        values = X[:, channel].tolist()
        for value in (low, high, 0, *edges):
            assert 8 < values.count(value) < 200, (channel, value)
        others = [value for value in values if value not in (low, high)]
        inner = [0, *edges]
        assert min(inner) - 8 == min(others)
        assert max(inner) + 8 == max(others)
    if largest == MOST:
        np.testing.assert_array_equal(check_vectors(netlist, 600), X)


# Limits


@pytest.mark.parametrize("sign", [-1, 1])
def test_numbers_fit_thirty_two_bits_and_sums_half_of_them(sign: int) -> None:
    assert Comparator(0, sign * MOST).threshold == sign * MOST
    with pytest.raises(InputError, match=f"threshold of a comparator must fit 32 signed bits, got {sign * (MOST + 1)}"):
        Comparator(0, sign * (MOST + 1))
    half = MOST // 2
    for make in (lambda pairs, bias: Hyperplane(pairs, bias), lambda pairs, bias: Score(pairs, bias)):
        assert make([(0, sign * (half - 5)), (1, -2)], sign * 3).bias == sign * 3
        with pytest.raises(InputError, match=f"must sum to at most {half} in magnitude, got {half + 1}"):
            make([(0, sign * (half - 5)), (1, -2)], sign * 4)
    assert Hyperplane([(MOST, 1)], 0).weights == ((MOST, 1),)


def test_counts_within_thirty_two_bits_are_taken() -> None:
    netlist = Netlist(
        ("a",),
        (Comparator(0, MOST),),
        (Hyperplane([(0, 1)], 0),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        "ab",
    )
    assert evaluate(netlist, [[MOST], [-MOST], [MOST - 1]]).tolist() == [1, 0, 0]
    assert evaluate(netlist, np.array([[float(MOST)]])).tolist() == [1]
    assert evaluate(netlist, np.array([[MOST]], np.uint64)).tolist() == [1]
    for wrong in (MOST + 1, -MOST - 1, np.inf, 0.5):
        with pytest.raises(InputError, match="integer counts within 32 signed bits"):
            evaluate(netlist, [[0], [wrong]])
    with pytest.raises(InputError, match="X must hold integers, got dtype complex128"):
        evaluate(netlist, np.zeros((1, 1), complex))


@given(st.integers(1, 50), st.integers(0, 60), st.integers(1, 7))
def test_what_is_evaluated_at_a_time_stays_bounded(entries: int, n: int, classes: int) -> None:
    netlist = drawn(np.random.default_rng(classes), switches=4, classes=min(classes, 6))
    widest = max(4, len(netlist.units), len(netlist.terms), len(netlist.classes))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluation, "_CHUNK_ENTRIES", entries)
        chunks = list(evaluation._chunks(netlist, n))
    assert [k for chunk in chunks for k in range(n)[chunk]] == list(range(n))
    for chunk in chunks:
        size = chunk.stop - chunk.start
        assert size == 1 or size * widest <= entries
        assert (size + 1) * widest > entries


def test_whole_numbers_of_numpy_are_whole_numbers() -> None:
    assert Hyperplane([(np.int8(2), np.uint16(3)), (np.int64(0), np.int64(-1))], np.int32(4), (np.int8(1), 2)) == (
        Hyperplane([(0, -1), (2, 3)], 4, (1, 2))
    )
    assert Term([(np.int64(1), np.int64(0)), (0, 1)]).literals == ((0, 1), (1, 0))
    assert all(type(number) is int for pair in Hyperplane([(np.int8(2), np.uint16(3))], 0).weights for number in pair)
    with pytest.raises(InputError, match="pair of a unit must not be negative, got -1"):
        Hyperplane([(0, 1)], 0, (0, -1))
    with pytest.raises(InputError, match="a term must name each unit once, got 3 twice"):
        Term([(3, 0), (1, 1), (3, 1)])


def test_what_was_got_is_shown_in_forty_characters() -> None:
    assert shown("x" * 38) == "'" + "x" * 38 + "'"
    assert shown("x" * 39) == "'" + "x" * 36 + "..."
    assert shown("é") == r"'\xe9'"
    assert shown(10**30) == "1" + "0" * 30
    assert shown(-(10**30)) == "-1" + "0" * 30
    assert shown(10**30 + 1) == shown(-(10**40)) == "an integer of more than 30 digits"


@pytest.mark.parametrize("length", [0, 1, 256, 257])
def test_names_have_one_to_two_hundred_and_fifty_six_characters(length: int) -> None:
    parts = (), (), (), (Score([]), Score([]))
    if 0 < length <= 256:
        assert Netlist(("a", "x" * length), *parts, ("b", "y" * length)).classes[1] == "y" * length
        return
    for names in ((("a", "x" * length), ("b", "c")), (("a", "b"), ("c", "y" * length))):
        with pytest.raises(InputError, match=rf"\[1\] must be a name of 1 to 256 characters, got {length}"):
            Netlist(names[0], *parts, names[1])


@pytest.mark.parametrize(
    ("weights", "bound", "step"),
    [
        ([1] * 5, 2, "vote5"),
        ([2, 1, 1, 1], 2, "vote5"),
        ([1] * 7, 3, "vote7"),
        ([2, 2, 2, 1], 3, "vote7"),
        ([1] * 9, 4, "vote9"),
        ([3, 2, 2, 1, 1], 4, "vote9"),
        ([2, 2, 1, 1, 1], 4, "vote9"),
        ([1] * 6, 2, "vote7"),
        ([1] * 4, 1, "vote5"),
    ],
)
def test_a_small_vote_is_one_step(weights: list[int], bound: int, step: str) -> None:
    network = GateNetwork(len(weights))
    output = exceeds(network, [(network.input(k), w) for k, w in enumerate(weights)], bound, wide=True)
    bits = all_bits(len(weights))
    np.testing.assert_array_equal(read(network, output, bits), bits @ np.array(weights) > bound)
    names = [OPERATIONS[row[0]][0] for row in compile_program(network, [output]).code]
    assert [name for name in names if name != "zero"] == [step, "copy"]


@pytest.mark.parametrize(("bits", "tried"), [(64, True), (65, False)])
def test_both_ways_of_a_vote_are_tried_up_to_sixty_four_bits(
    bits: int, tried: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    by_carry = synthesis._by_carry
    monkeypatch.setattr(synthesis, "_by_carry", lambda *given_, **named: calls.append(1) or by_carry(*given_, **named))
    netlist = Netlist(
        tuple(f"x{k}" for k in range(bits)),
        (),
        (Hyperplane([(k, 1) for k in range(bits)], bits // 3),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("no", "yes"),
    )
    network, outputs = synthesize(netlist)
    assert bool(calls) == tried
    rows = (np.random.default_rng(0).random((200, bits)) < 0.33).astype(int)
    np.testing.assert_array_equal(read(network, outputs[0], rows), rows.sum(axis=1) > bits // 3)
