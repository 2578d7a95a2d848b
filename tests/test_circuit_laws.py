"""Laws of circuits beside their answers: what is proved, how small programs and types are, what a drawing shows."""

from __future__ import annotations

import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.circuit import (
    Hyperplane,
    Netlist,
    PackedEvaluator,
    Score,
    Term,
    bits_of,
    evaluate,
    gate_count,
    minimization,
    minimize,
    pack,
    simplify,
)
from varishold.circuit.gates import FALSE, TRUE, GateNetwork
from varishold.circuit.packed.program import compile_program
from varishold.circuit.synthesis import exceeds
from varishold.circuit.writers import c99_files, verilog_files

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=40)


def drawn(rng: np.random.Generator, *, switches: int = 6, classes: int = 3) -> Netlist:
    def pairs(n: int, low: int, high: int) -> list[tuple[int, int]]:
        return [(k, int(w)) for k, w in enumerate(rng.integers(low, high, n)) if w]

    units = [Hyperplane(pairs(switches, -2, 3) or [(0, 1)], int(rng.integers(-2, 3))) for _ in range(4)]
    terms = [Term([(k, int(v)) for k, v in enumerate(rng.integers(-1, 2, 4)) if v >= 0]) for _ in range(5)]
    scores = [Score(pairs(5, -2, 3), int(rng.integers(-2, 3))) for _ in range(classes)]
    return Netlist(
        tuple(f"x{k}" for k in range(switches)),
        (),
        tuple(units),
        tuple(terms),
        tuple(scores),
        tuple("abcdef"[:classes]),
    )


def vote(weights: list[int], bias: int) -> Netlist:
    return Netlist(
        tuple(f"v{k}" for k in range(len(weights))),
        (),
        (Hyperplane([(k, w) for k, w in enumerate(weights) if w], bias),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("no", "yes"),
    )


# Minimization


def random_table(rng: np.random.Generator, k: int) -> tuple[np.ndarray, np.ndarray]:
    patterns = np.array(list(itertools.product((0, 1), repeat=k)), np.uint8)
    side = rng.integers(0, 3, len(patterns))
    side[:2] = (0, 1)
    return patterns[side == 1], patterns[side == 0]


def test_nothing_is_proved_where_the_search_was_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    on, off = random_table(np.random.default_rng(0), 4)
    assert minimize(on, off).proved
    assert minimize(on, off, exact=True).proved
    assert not minimize(on, off, exact=False).proved
    monkeypatch.setattr(minimization, "_LARGEST_EXACT_TABLE", 0)
    assert not minimize(on, off).proved
    assert minimize(on, off, exact=True).proved
    monkeypatch.undo()
    # Too many primes: those that were found may lack one of the smallest sum.
    monkeypatch.setattr(minimization, "_MOST_PRIMES", 1)
    assert not minimize(on, off).proved
    assert minimize(on, off, exact=True).proved


@settings(max_examples=15)
@given(seeds, st.integers(2, 4))
def test_a_greedy_sum_has_no_term_and_no_literal_too_many(seed: int, k: int) -> None:
    on, off = random_table(np.random.default_rng(seed), k)
    cover = minimize(on, off, exact=False)
    best = minimize(on, off, exact=True)
    assert len(cover.terms) >= len(best.terms)

    def true(literals: tuple[tuple[int, int], ...], rows: np.ndarray) -> np.ndarray:
        return np.all([rows[:, v] == w for v, w in literals] or np.ones((1, len(rows)), bool), axis=0)

    for term in cover.terms:
        assert list(term) == sorted(term)
        others = [t for t in cover.terms if t != term]
        assert not np.any([true(t, on) for t in others] or np.zeros((1, len(on)), bool), axis=0).all()
        for literal in term:
            rest = tuple(other for other in term if other != literal)
            assert true(rest, off).any()


# Gates


def read(network: GateNetwork, literal: int, bits: np.ndarray) -> np.ndarray:
    """Return the value of a literal for rows of input bits."""
    values = {0: np.zeros(len(bits), np.int64)} | {k + 1: bits[:, k].astype(np.int64) for k in range(bits.shape[1])}
    for gate in network.gates:
        operands = [values[a >> 1] ^ (a & 1) for a in gate.operands]
        if gate.operation == "and":
            out = [operands[0] & operands[1]]
        elif gate.operation == "xor":
            out = [operands[0] ^ operands[1]]
        elif gate.operation == "vote":
            out = [(2 * np.sum(operands, axis=0) > len(operands)).astype(np.int64)]
        else:
            out = [np.sum(operands, axis=0) >> j & 1 for j in range(len(gate.outputs))]
        values |= dict(zip(gate.outputs, out, strict=True))
    return values[literal >> 1] ^ (literal & 1)


@pytest.mark.parametrize("operands", list(itertools.product(range(6), repeat=3)))
def test_gates_of_constants_and_of_equal_and_inverted_wires(operands: tuple[int, int, int]) -> None:
    bits = np.array(list(itertools.product((0, 1), repeat=2)))
    network = GateNetwork(2)
    a, b, c = (read(network, literal, bits) for literal in operands)
    x, y, z = operands
    told = {
        network.both(x, y): a & b,
        network.either(x, y): a | b,
        network.differ(x, y): a ^ b,
        network.majority(x, y, z): (a + b + c) // 2,
        network.choose(x, y, z): np.where(a, b, c),
    }
    total, carry = network.count((x, y, z))
    for literal, wanted in [*told.items(), (total, (a + b + c) % 2), (carry, (a + b + c) // 2)]:
        np.testing.assert_array_equal(read(network, literal, bits), wanted)
    two, more = network.count((x, y))
    np.testing.assert_array_equal(read(network, two, bits) + 2 * read(network, more, bits), a + b)


@few
@given(st.lists(st.integers(0, 9), min_size=7, max_size=7))
def test_seven_are_counted_in_three_bits(operands: list[int]) -> None:
    bits = np.array(list(itertools.product((0, 1), repeat=4)))
    network = GateNetwork(4)
    outputs = network.count(operands)
    total = sum(read(network, literal, bits) for literal in operands)
    np.testing.assert_array_equal(sum(read(network, o, bits) << j for j, o in enumerate(outputs)), total)


def test_what_costs_nothing_has_no_gate() -> None:
    network = GateNetwork(2)
    a, b = network.input(0), network.input(1)
    assert (a, b) == (2, 4)
    assert (network.both(a, a), network.both(a, a ^ 1), network.both(TRUE, a), network.both(FALSE, a)) == (
        a,
        FALSE,
        a,
        FALSE,
    )
    assert (network.differ(a, a), network.differ(a, a ^ 1), network.differ(a, TRUE)) == (FALSE, TRUE, a ^ 1)
    assert network.choose(a, b, b) == b
    assert network.count((a, a, b)) == (b, a)
    assert network.count((a, a ^ 1, b)) == (b ^ 1, b)
    assert not network.gates
    assert network.both(a, b) == network.both(b, a)
    assert network.differ(a, b) ^ 1 == network.differ(a ^ 1, b)
    assert len(network.gates) == 2
    network.both(a ^ 1, b)
    assert network.two_input_gates([network.both(a, b)]) == 1
    assert network.two_input_gates([network.both(a, b), network.differ(a, b)]) == 2


@pytest.mark.parametrize(
    ("weights", "bias", "gates"),
    [
        ([1] * 4, 1, 9),
        ([1] * 5, 2, 14),
        ([1] * 7, 3, 19),
        ([2, 2, 1, 1, 1], 3, 11),
        ([1] * 9, 0, 8),
        ([1] * 9, 8, 8),
        ([4, 2, 1], 3, 0),
        ([4, 2, 1], 4, 2),
        ([3, -3, 3], 2, 4),
    ],
)
def test_votes_cost_no_more_than_known(weights: list[int], bias: int, gates: int) -> None:
    assert gate_count(vote(weights, bias)) <= gates


# Programs


def test_a_product_of_many_takes_four_at_a_step_and_few_registers() -> None:
    network = GateNetwork(40)
    product = TRUE
    for k in range(40):
        product = network.both(product, network.input(k))
    program = compile_program(network, [product])
    # Thirty-nine products, four in a step.
    assert len(program.code) == 10
    assert program.registers <= 42
    assert program.inputs == 40


def test_a_vote_of_many_uses_its_registers_again() -> None:
    network = GateNetwork(60)
    output = exceeds(network, [(network.input(k), 1) for k in range(60)], 29, wide=True)
    program = compile_program(network, [output])
    assert program.registers <= 60 + 21
    assert len(program.code) <= 30


@pytest.mark.parametrize("n", [0, 1, 7, 8, 9, 63, 64, 65, 4095, 4097, 8191, 8193, 17001])
@pytest.mark.parametrize("switches", [8, 13])
def test_any_number_of_grasps_is_answered_alike(n: int, switches: int) -> None:
    rng = np.random.default_rng(n + switches)
    netlist = drawn(rng, switches=switches, classes=5)
    X = (rng.random((n, switches)) < 0.5).astype(np.uint8)
    evaluator = PackedEvaluator(netlist)
    wanted = evaluate(netlist, X)
    np.testing.assert_array_equal(evaluator.evaluate(X), wanted)
    np.testing.assert_array_equal(evaluator.evaluate(X.astype(bool)), wanted)
    words = pack(X).words
    bits = (words[:, :, None] >> np.arange(64, dtype=np.uint64) & np.uint64(1)).reshape(switches, -1)
    np.testing.assert_array_equal(bits[:, :n].T, X)
    assert not bits[:, n:].any()


# Canonical form


@few
@given(seeds)
def test_a_canonical_netlist_answers_alike_and_holds_nothing_idle(seed: int) -> None:
    netlist = drawn(np.random.default_rng(seed))
    small = simplify(netlist)
    X = np.array(list(itertools.product((0, 1), repeat=6)))
    np.testing.assert_array_equal(evaluate(small, X), evaluate(netlist, X))
    assert simplify(small) == small
    read_units = {unit for term in small.terms for unit, _ in term.literals}
    assert read_units == set(range(len(small.units)))
    read_terms = {term for score in small.scores for term, _ in score.weights}
    assert read_terms == set(range(len(small.terms)))
    assert len({(u.weights, u.bias) for u in small.units}) == len(small.units)
    assert len({t.literals for t in small.terms}) == len(small.terms)
    bits = bits_of(small, X)
    for unit in small.units:
        fires = sum(w * bits[:, b].astype(int) for b, w in unit.weights) > unit.bias
        assert fires.any()
        assert not fires.all()
        assert np.gcd.reduce([w for _, w in unit.weights]) == 1


# Writers


@pytest.mark.parametrize(
    ("weights", "bias", "wanted"),
    [
        ([100], 27, "int8_t"),
        ([100], 28, "int16_t"),
        ([100, -25], 0, "int8_t"),
        ([100, -26], 0, "int16_t"),
        ([32000], 767, "int16_t"),
        ([32000], 768, "int32_t"),
    ],
)
def test_sums_get_the_smallest_type_that_holds_them(weights: list[int], bias: int, wanted: str) -> None:
    # A weight of one beside them, so that no common divisor makes the others smaller.
    netlist = vote([*weights, 1], bias - 1)
    text = c99_files(netlist, "hand")["hand.c"]
    types = set(re.findall(r"(?<!u)int\d+_t", text))
    assert wanted in types
    sizes = {"int8_t": 8, "int16_t": 16, "int32_t": 32}
    assert max(sizes[name] for name in types) == sizes[wanted]


@pytest.mark.parametrize(("switches", "classes", "digits"), [(10, 3, 3), (11, 3, 4), (6, 5, 3), (7, 2, 2), (8, 2, 3)])
def test_a_vector_has_as_many_digits_as_it_needs(switches: int, classes: int, digits: int) -> None:
    netlist = drawn(np.random.default_rng(1), switches=switches, classes=classes)
    lines = verilog_files(netlist, "hand", vectors=20)["hand_vectors.hex"].splitlines()
    assert {len(line) for line in lines} == {digits}
    for line in lines:
        word = int(line, 16)
        row = [word >> k & 1 for k in range(switches)]
        assert word >> switches == evaluate(netlist, [row])[0]


# Diagrams


@few
@given(seeds, st.integers(1, 4))
def test_a_drawing_shows_every_weight_inversion_and_sign(seed: int, classes: int) -> None:
    netlist = drawn(np.random.default_rng(seed), classes=classes)
    root = ElementTree.fromstring(netlist.diagram_svg())
    kinds = [element.tag.rpartition("}")[2] for element in root.iter()]
    weights = [w for unit in netlist.units for _, w in unit.weights]
    wanted = [v for term in netlist.terms for _, v in term.literals]
    votes = [w for score in netlist.scores for _, w in score.weights]
    lines = [e for e in root.iter() if e.tag.endswith("line")]
    assert len(lines) == len(weights) + len(wanted) + len(votes)
    assert kinds.count("circle") == wanted.count(0)
    dashed = [e for e in lines if e.get("stroke-dasharray")]
    assert len(dashed) == sum(w < 0 for w in weights + votes)
    assert kinds.count("path") == len(netlist.terms)
    assert kinds.count("rect") == 1 + len(netlist.units) + classes
    _, _, width, height = map(float, root.get("viewBox", "").split())
    for element in root.iter():
        for name, most in (("x", width), ("x1", width), ("x2", width), ("y", height), ("y1", height), ("y2", height)):
            assert 0 <= float(element.get(name, "0")) <= most
    # A line ends at the left of what it leads to and begins at the right of where it comes from.
    assert all(float(e.get("x1")) < float(e.get("x2")) for e in lines)
    # Units, terms and classes stand apart from one another, in order, and inside.
    boxes = [float(e.get("y")) for e in root.iter() if e.tag.endswith("rect") and e.get("rx")]
    for group in (boxes[: len(netlist.units)], boxes[len(netlist.units) :]):
        assert all(b - a >= 20 for a, b in itertools.pairwise(group))
        assert group[-1] + 20 <= height
    text = netlist.diagram()
    assert text.count("●") == wanted.count(1)
    assert text.count("○") == wanted.count(0)
    assert text.count(" AND") == sum(len(t.literals) > 1 for t in netlist.terms)
    assert text.count("always") == sum(not t.literals for t in netlist.terms)
    for weight in {*weights}:
        assert len(re.findall(rf"─\{weight:+d}\b", text)) == weights.count(weight)


@few
@given(seeds)
def test_a_class_is_called_an_or_of_terms_only_where_it_is_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scores = [
        Score([(k, int(w)) for k, w in enumerate(rng.integers(-1, 3, 3)) if w], int(rng.integers(-2, 3)))
        for _ in range(2)
    ]
    if rng.random() < 0.7:
        scores[int(rng.integers(2))] = Score([], int(rng.integers(-1, 2)))
    netlist = Netlist(
        ("p", "q", "r"),
        (),
        tuple(Hyperplane([(k, 1)], 0) for k in range(3)),
        tuple(Term([(k, 1)]) for k in range(3)),
        tuple(scores),
        ("no", "yes"),
    )
    X = np.array(list(itertools.product((0, 1), repeat=3)))
    answers = evaluate(netlist, X)
    told = re.search(r"(no|yes) where (.*), otherwise", netlist.diagram())
    if told:
        own = [int(t[1:]) - 1 for t in told[2].split(" OR ")]
        np.testing.assert_array_equal(answers == ("no", "yes").index(told[1]), X[:, own].any(axis=1))
    else:
        # No class with votes of its own against one without is an OR of all its terms.
        for k in (0, 1):
            own = [t for t, _ in scores[k].weights]
            if own and not scores[1 - k].weights and all(w > 0 for _, w in scores[k].weights):
                assert ((answers == k) != X[:, own].any(axis=1)).any()
