"""Gates, shared adders, programs and covers against the plainest way of each; and the edges of every limit."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.circuit_inputs import all_bits, few, seeds
from tests.test_circuit_laws import drawn, read
from tests.test_circuit_netlist import every_input, netlists

from varishold.circuit import (
    Hyperplane,
    Netlist,
    PackedEvaluator,
    Score,
    Term,
    evaluate,
    gate_count,
    pack,
    sharing,
    synthesis,
)
from varishold.circuit.gates import FALSE, TRUE, GateNetwork
from varishold.circuit.packed.kernel import KernelProgram
from varishold.circuit.packed.program import COLUMNS, OPERATIONS, Program, compile_program
from varishold.circuit.sharing import shared_adders
from varishold.circuit.synthesis import circuit_size


def grown(rng: np.random.Generator, inputs: int, gates: int, *, wide: bool) -> tuple[GateNetwork, list[int]]:
    """A network of any gates, and all its literals."""
    network = GateNetwork(inputs)
    literals = [FALSE, *(network.input(k) for k in range(inputs))]

    def some(n: int) -> list[int]:
        return [int(a) ^ int(rng.integers(2)) for a in rng.choice(literals, n)]

    for _ in range(gates):
        kind = int(rng.integers(6 if wide else 4))
        if kind == 0:
            literals.append(network.both(*some(2)))
        elif kind == 1:
            literals.append(network.differ(*some(2)))
        elif kind == 2:
            literals += network.count(some(3))
        elif kind == 3:
            literals.append(network.majority(*some(3)))
        elif kind == 4:
            literals += network.count(some(7))
        else:
            literals.append(network.vote(some(int(rng.choice([5, 7, 9])))))
    return network, literals


# Gates


@few
@given(seeds, st.integers(1, 5), st.booleans())
def test_what_outputs_need_is_all_that_leads_to_them(seed: int, inputs: int, wide: bool) -> None:
    rng = np.random.default_rng(seed)
    network, literals = grown(rng, inputs, 12, wide=wide)
    outputs = [int(a) for a in rng.choice(literals, 3)]
    gates, wires = network.needed(outputs)
    maker = {wire: gate for gate in network.gates for wire in gate.outputs}
    wanted, waiting = set(), [a >> 1 for a in outputs]
    while waiting:
        wire = waiting.pop()
        if wire not in wanted:
            wanted.add(wire)
            if wire in maker:
                waiting += [a >> 1 for a in maker[wire].operands]
    assert wires == wanted
    assert gates == [gate for gate in network.gates if wanted & set(gate.outputs)]
    assert len(maker) == sum(len(gate.outputs) for gate in network.gates)
    assert len({(gate.operation, gate.operands) for gate in network.gates}) == len(network.gates)
    if not wide:
        cost, total = {(True, True): 5, (False, True): 4, (True, False): 2}, 0
        for gate in gates:
            total += 1 if gate.operation != "count" else cost[tuple(wire in wanted for wire in gate.outputs)]
        assert network.two_input_gates(outputs) == total
    for gate in network.gates:
        inverted = [a & 1 for a in gate.operands]
        if gate.operation in ("count", "vote"):
            assert inverted == sorted(inverted)
            assert 2 * sum(inverted) <= len(inverted)
        assert gate.operation != "xor" or not any(inverted)


@given(st.permutations([2, 5, 6, 9, 10, 12, 15]), st.sampled_from([3, 5, 7]))
def test_symmetric_gates_are_built_once_whatever_the_order_and_all_inverted(operands: list[int], n: int) -> None:
    network, some = GateNetwork(7), sorted(operands[:n])
    build = network.count if n != 5 else lambda of: (network.vote(of),)
    first = build(some)
    assert build(operands[:n]) == first
    assert build([a ^ 1 for a in some]) == tuple(a ^ 1 for a in first)
    assert len(network.gates) == 1


@given(st.lists(st.integers(0, 9), min_size=7, max_size=7) | st.permutations(range(2, 10)).map(lambda of: of[:7]))
def test_seven_of_fewer_wires_take_no_counter_of_seven(operands: list[int]) -> None:
    network = GateNetwork(4)
    network.count(operands)
    assert all(len(gate.operands) < 7 for gate in network.gates)


# Adders in common


@few
@given(seeds, st.integers(2, 4))
def test_shared_adders_change_no_vote_and_leave_nothing_in_common(seed: int, n_votes: int) -> None:
    rng, inputs = np.random.default_rng(seed), 6
    network = GateNetwork(inputs)
    votes = []
    for _ in range(n_votes):
        chosen = rng.choice(inputs, int(rng.integers(3, inputs + 1)), replace=False)
        items = [(network.input(int(k)) ^ int(rng.integers(2)), int(rng.integers(1, 6))) for k in chosen]
        votes.append((items, int(rng.integers(0, 12))))
    before = [(list(items), bound) for items, bound in votes]
    bits = all_bits(inputs)
    told = shared_adders(network, votes)
    assert votes == before
    common: list[set[tuple[int, ...]]] = []
    for (old, bound), (new, also) in zip(votes, told, strict=True):
        assert also == bound
        sums = [sum(w * read(network, a, bits) for a, w in items) for items in (old, new)]
        np.testing.assert_array_equal(*sums)
        assert all(weight.bit_count() == 1 for _, weight in new)
        triples = set()
        for weight in {w for _, w in new}:
            column = sorted(a for a, w in new if w == weight)
            # One wire stands once in a column, so that no adder of it has a constant.
            assert len({a >> 1 for a in column}) == len(column)
            assert min(column) > TRUE
            for triple in itertools.combinations(column, 3):
                triples |= {triple, tuple(sorted(a ^ 1 for a in triple))}
        common.append(triples)
    for one, other in itertools.combinations(common, 2):
        assert not one & other


def test_the_triple_of_most_votes_is_shared_first_and_the_lowest_among_equals() -> None:
    network = GateNetwork(6)
    a, b, c, d, e, f = (network.input(k) for k in range(6))
    both = [(a, 1), (b, 1), (c, 1), (d, 1)]
    shared_adders(network, [(both, 1), (both, 2)])
    assert network.gates[0].operands == (a, b, c)
    network = GateNetwork(6)
    once, thrice = [(x, 1) for x in (a, b, c)], [(x, 1) for x in (d, e, f)]
    told = shared_adders(network, [(once, 0), (once + thrice, 0), (thrice, 0), (thrice, 1)])
    assert [gate.operands for gate in network.gates] == [(d, e, f), (a, b, c)]
    total, carry = network.count((d, e, f))
    assert told[3] == ([(total, 1), (carry, 2)], 1)
    network = GateNetwork(6)
    shared_adders(network, [([(x, 1) for x in of], 1) for of in ((b, c, f), (b, c, f), (a, d, e), (a, d, e))])
    assert [gate.operands for gate in network.gates] == [(a, d, e), (b, c, f)]
    # Three and their complements are one adder.
    network = GateNetwork(3)
    inverted = [(x ^ 1, 1) for x in (a, b, c)]
    told = shared_adders(network, [(once, 1), (inverted, 1)])
    assert len(network.gates) == 1
    assert [{x ^ 1 for x, _ in told[0][0]}, 1] == [{x for x, _ in told[1][0]}, told[1][1]]
    mixed = [(a, 1), (b ^ 1, 1), (c ^ 1, 1)]
    network = GateNetwork(3)
    shared_adders(network, [(mixed, 1), ([(x ^ 1, w) for x, w in mixed], 1)])
    assert [gate.operands for gate in network.gates] == [(b, c, a ^ 1)]


@pytest.mark.parametrize("spare", [-1, 0])
def test_too_many_triples_are_not_looked_at(monkeypatch: pytest.MonkeyPatch, spare: int) -> None:
    monkeypatch.setattr(sharing, "_MOST_TRIPLES", 2 * math.comb(5, 3) + spare)
    network = GateNetwork(5)
    items = [(network.input(k), 1) for k in range(5)]
    told = shared_adders(network, [(items, 1), (items, 2)])
    assert bool(network.gates) == (spare == 0)
    assert (told == [(items, 1), (items, 2)]) == (spare < 0)


def test_what_every_class_gains_alike_costs_no_gate() -> None:
    rng = np.random.default_rng(5)
    for _ in range(12):
        netlist = drawn(rng, switches=5, classes=3)
        t, more = int(rng.integers(len(netlist.terms))), int(rng.integers(-3, 4))
        raised = []
        for score in netlist.scores:
            weights = dict(score.weights)
            weights[t] = weights.get(t, 0) + more
            raised.append(Score([(k, w) for k, w in weights.items() if w], score.bias + 7))
        other = Netlist(netlist.channels, (), netlist.units, netlist.terms, tuple(raised), netlist.classes)
        assert gate_count(other) == gate_count(netlist)
        X = all_bits(5)
        np.testing.assert_array_equal(evaluate(other, X), evaluate(netlist, X))


@pytest.mark.parametrize(("units", "words"), [(0, "0 hyperplanes, "), (1, "1 hyperplane, "), (2, "2 hyperplanes, ")])
def test_the_size_is_told_in_words(units: int, words: str) -> None:
    netlist = Netlist(
        ("a", "b"),
        (),
        tuple(Hyperplane([(0, 1), (1, k + 1)], 0) for k in range(units)),
        tuple(Term([(k, 1)]) for k in range(units)),
        (Score([]), Score([(k, 1) for k in range(units)])),
        ("no", "yes"),
    )
    gates = gate_count(netlist)
    assert circuit_size(netlist) == f"{words}{gates} two-input gate{'' if gates == 1 else 's'}"


@pytest.mark.parametrize(("bits", "gates"), [(20, "7"), (21, "about 100"), (30, "about 150"), (31, "about 160")])
def test_gates_of_a_large_circuit_are_estimated_at_five_a_set_bit(
    monkeypatch: pytest.MonkeyPatch, bits: int, gates: str
) -> None:
    monkeypatch.setattr(synthesis, "_COUNTED_BITS", 20)
    monkeypatch.setattr(synthesis, "gate_count", lambda netlist: 7)
    # Nine bits in a score, two of each weight of -3, one of the others.
    weights = [(k, -3) for k in range(2)] + [(k + 2, 4) for k in range(bits - 13)]
    netlist = Netlist(
        tuple(f"x{k}" for k in range(len(weights))),
        (),
        (Hyperplane(weights, 0),),
        tuple(Term([(0, 1)]) for _ in range(9)),
        (Score([]), Score([(t, 1) for t in range(9)])),
        ("no", "yes"),
    )
    assert circuit_size(netlist) == f"1 hyperplane, {gates} two-input gates"


# Programs


def run(program: Program, bits: np.ndarray) -> np.ndarray:
    """Run a program as its operations' names say, on rows of input bits; shape (n, n_outputs)."""
    registers = np.full((program.registers, len(bits)), -1)
    registers[: program.inputs] = bits.T
    for code, *places in program.code.tolist():
        name, inverted = OPERATIONS[code]
        kind, size = name.rstrip("0123456789"), int(name[len(name.rstrip("0123456789")) :] or 0)
        n = {"zero": 0, "copy": 1}.get(kind, size or {"majority": 3}.get(kind, 3 if "nand" in kind else 2))
        x = registers[places[3 : 3 + n]]
        assert (x >= 0).all(), "what is read was written"
        if "nand" in kind:
            product = np.prod([x[k] ^ (k >= 2 - inverted) for k in (0, 1)], axis=0)
            out = [(x[2] ^ (kind == "not-and-nand")) & (1 - product)]
        else:
            x = np.array([row ^ (k >= n - inverted) for k, row in enumerate(x)]).reshape(n, len(bits))
            total = x.sum(axis=0)
            out = {
                "zero": lambda x=x, total=total: [0 * total],
                "copy": lambda x=x, total=total: [x[0]],
                "and": lambda x=x, total=total, n=n: [(total == n).astype(int)],
                "or": lambda x=x, total=total: [(total > 0).astype(int)],
                "xor": lambda x=x, total=total: [total % 2],
                "majority": lambda x=x, total=total, n=n: [(2 * total > n).astype(int)],
                "vote": lambda x=x, total=total, n=n: [(2 * total > n).astype(int)],
                "count": lambda x=x, total=total, n=n: [total >> j & 1 for j in range(2 if n == 3 else 3)],
            }[kind]()
        assert places[3 + n :] == [0] * (9 - n)
        assert places[len(out) : 3] == [0] * (3 - len(out))
        assert all(program.inputs <= place < program.registers for place in places[: len(out)])
        for place, row in zip(places, out, strict=False):
            registers[place] = row
    return registers[list(program.outputs)].T.reshape(len(bits), len(program.outputs))


@few
@given(seeds, st.integers(1, 5), st.integers(0, 25))
def test_a_program_says_what_its_gates_say(seed: int, inputs: int, gates: int) -> None:
    rng = np.random.default_rng(seed)
    network, literals = grown(rng, inputs, gates, wide=True)
    outputs = [int(a) ^ int(rng.integers(2)) for a in rng.choice(literals, int(rng.integers(1, 5)))]
    program, bits = compile_program(network, outputs), all_bits(inputs)
    wanted = np.stack([read(network, a, bits) for a in outputs], axis=1)
    np.testing.assert_array_equal(run(program, bits), wanted)
    assert program.code.shape[1] == COLUMNS
    assert program.code.dtype == np.int32
    assert program.inputs == inputs
    assert program.registers == max(inputs, program.code[:, 1:].max(initial=-1) + 1)
    words = pack(bits).words
    planes = KernelProgram(program).run(words)
    assert planes.shape == (len(outputs), words.shape[1])
    planes = (planes[:, :, None] >> np.arange(64, dtype=np.uint64) & np.uint64(1)).reshape(len(outputs), -1)
    np.testing.assert_array_equal(planes[:, : len(bits)].T, wanted)
    joined = KernelProgram(program).run_and_unpack(words, len(bits))
    np.testing.assert_array_equal(joined, wanted @ (1 << np.arange(len(outputs))))


def test_one_step_takes_four_products_and_only_what_is_read_is_written() -> None:
    network = GateNetwork(4)
    a, b, c, d = (network.input(k) for k in range(4))

    def steps(*outputs: int) -> list[tuple[str, int]]:
        code = compile_program(network, list(outputs)).code
        return [OPERATIONS[row[0]] for row in code]

    copy, inverted = ("copy", 0), ("copy", 1)
    assert steps(a) == [copy]
    assert steps(a ^ 1) == [inverted]
    assert steps(FALSE) == [("zero", 0), copy]
    assert steps(TRUE) == [("zero", 0), inverted]
    product = network.both(a, b)
    assert steps(network.both(product, c)) == [("and3", 0)]
    assert steps(network.both(network.both(a, b ^ 1), c)) == [("and3", 1)]
    assert steps(network.both(network.both(a, b), network.both(c, d ^ 1))) == [("and5", 1)]
    assert steps(network.both(product ^ 1, c)) == [("and-nand", 0)]
    assert steps(network.both(product ^ 1, c ^ 1)) == [("not-and-nand", 0)]
    assert steps(network.both(network.both(a, b ^ 1) ^ 1, c)) == [("and-nand", 1)]
    # The inverse of a product is a sum of inverses.
    assert steps(product ^ 1) == [("or5", 5)]
    assert steps(network.both(network.both(a, b ^ 1), c) ^ 1) == [("or5", 4)]
    # What is read twice is made once.
    assert steps(network.both(product, c), product) == [("and", 0), ("and", 0), copy]
    assert steps(network.both(product, c), network.both(product, d)).count(("and", 0)) == 3
    total, carry = network.count((a, b, c))
    assert steps(total) == [("xor3", 0), copy]
    assert steps(carry) == [("majority", 0), copy]
    assert steps(total, carry) == [("count3", 0), copy, copy]
    assert steps(network.count((a, b, c ^ 1))[0]) == [("count3", 1), copy]
    assert steps(network.count((a, b, c ^ 1))[1]) == [("majority", 1), copy]


@few
@given(netlists(max_channels=8))
def test_planes_are_the_class_index_in_binary(netlist: Netlist) -> None:
    X, evaluator = every_input(netlist), PackedEvaluator(netlist)
    packed, wanted = evaluator.pack(X), evaluate(netlist, X)
    planes = evaluator.class_planes(packed)
    assert len(planes) == (len(netlist.classes) - 1).bit_length()
    bits = (planes[:, :, None] >> np.arange(64, dtype=np.uint64) & np.uint64(1)).reshape(
        len(planes), 64 * -(-len(X) // 64)
    )
    bits = bits[:, : len(X)]
    np.testing.assert_array_equal(sum((bit.astype(int) << k for k, bit in enumerate(bits)), np.zeros(len(X))), wanted)
    told = evaluator.predict(packed)
    assert told.dtype == np.uint8
    np.testing.assert_array_equal(told, wanted)
    assert evaluator.evaluate(X).dtype == np.intp
    np.testing.assert_array_equal(run(evaluator.program, _bits_of(netlist, X)), bits.T)


def _bits_of(netlist: Netlist, X: np.ndarray) -> np.ndarray:
    if not netlist.comparators:
        return X
    return np.stack([X[:, c.channel] >= c.threshold for c in netlist.comparators], axis=1).astype(int)
