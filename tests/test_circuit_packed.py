"""Packing, gates and programs: 64 grasps a word say the same as one at a time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from tests.test_circuit_netlist import every_input, netlists

from varishold.circuit import (
    Comparator,
    Hyperplane,
    Netlist,
    PackedEvaluator,
    PackedGrasps,
    Score,
    Term,
    bits_of,
    evaluate,
    gate_count,
    pack,
    simplify,
)
from varishold.circuit.gates import GateNetwork
from varishold.circuit.packed.grasps import aligned_words
from varishold.circuit.synthesis import exceeds, synthesize
from varishold.errors import InputError

quick = settings(max_examples=60)


def run_gates(network: GateNetwork, outputs: list[int], bits: np.ndarray) -> np.ndarray:
    """Return the outputs' values (n, n_outputs) by evaluating every gate on bools."""
    values = {0: np.zeros(len(bits), np.bool_)}
    values.update({k + 1: bits[:, k] for k in range(bits.shape[1])})

    def read(literal: int) -> np.ndarray:
        return values[literal >> 1] ^ bool(literal & 1)

    for gate in network.gates:
        operands = [read(literal) for literal in gate.operands]
        if gate.operation == "and":
            values[gate.outputs[0]] = operands[0] & operands[1]
        elif gate.operation == "xor":
            values[gate.outputs[0]] = operands[0] ^ operands[1]
        elif gate.operation == "vote":
            values[gate.outputs[0]] = 2 * np.sum(operands, axis=0) > len(operands)
        else:
            total = np.sum(operands, axis=0)
            values.update({wire: (total >> j & 1).astype(np.bool_) for j, wire in enumerate(gate.outputs)})
    return np.stack([read(literal) for literal in outputs], axis=1) if outputs else np.zeros((len(bits), 0), bool)


def one_unit(weights: list[int], bias: int) -> Netlist:
    return Netlist(
        tuple(f"v{k}" for k in range(len(weights))),
        (),
        (Hyperplane([(k, w) for k, w in enumerate(weights) if w], bias),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("no", "yes"),
    )


@quick
@given(netlists(max_channels=9))
def test_packed_is_the_reference(netlist: Netlist) -> None:
    X = every_input(netlist)
    np.testing.assert_array_equal(PackedEvaluator(netlist).evaluate(X), evaluate(netlist, X))


@quick
@given(netlists(max_channels=8), st.booleans())
def test_the_gates_are_the_reference(netlist: Netlist, wide: bool) -> None:
    X = every_input(netlist)
    network, outputs = synthesize(netlist, wide=wide)
    index = run_gates(network, outputs, bits_of(netlist, X)) @ (1 << np.arange(len(outputs)))
    np.testing.assert_array_equal(index, evaluate(netlist, X))


@quick
@given(
    st.lists(st.integers(-5, 5).filter(bool), min_size=1, max_size=11),
    st.integers(-12, 12),
    st.booleans(),
)
def test_a_vote_of_any_weights(weights: list[int], bound: int, wide: bool) -> None:
    bits = np.array(list(itertools.product((0, 1), repeat=len(weights))), np.bool_)
    network = GateNetwork(len(weights))
    output = exceeds(network, [(network.input(k), w) for k, w in enumerate(weights)], bound, wide=wide)
    np.testing.assert_array_equal(run_gates(network, [output], bits)[:, 0], bits @ np.array(weights) > bound)


@quick
@given(hnp.arrays(np.uint8, st.tuples(st.integers(0, 200), st.integers(1, 40)), elements=st.integers(0, 1)))
def test_a_packed_bit_stands_where_it_should(bits: np.ndarray) -> None:
    packed = pack(bits)
    assert packed.n == len(bits)
    assert packed.words.shape == (bits.shape[1], -(-len(bits) // 64))
    for grasp, switch in np.ndindex(*bits.shape):
        word = int(packed.words[switch, grasp // 64])
        assert word >> (grasp % 64) & 1 == bits[grasp, switch]


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int8, np.int64, np.float32, np.float64])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("r", [3, 8, 22, 65])
def test_every_number_type_and_order_packs_alike(dtype: type, order: str, r: int) -> None:
    bits = np.random.default_rng(0).integers(0, 2, (133, r))
    np.testing.assert_array_equal(pack(np.asarray(bits, dtype, order=order)).words, pack(bits).words)


def test_readonly_and_strided_input() -> None:
    bits = np.random.default_rng(0).integers(0, 2, (300, 44)).astype(np.uint8)
    half = bits[::2, ::2]
    bits.flags.writeable = False
    np.testing.assert_array_equal(pack(half).words, pack(half.copy()).words)
    netlist = one_unit([1] * 22, 10)
    packed = pack(half)
    words = packed.words.copy()
    words.flags.writeable = False
    evaluator = PackedEvaluator(netlist)
    for given_words in (words, np.asfortranarray(words)):
        np.testing.assert_array_equal(evaluator.predict(PackedGrasps(given_words, packed.n)), evaluate(netlist, half))


@pytest.mark.parametrize("n", [0, 1, 63, 64, 65, 4095, 4096, 4097, 100_003])
def test_any_number_of_grasps(n: int) -> None:
    rng = np.random.default_rng(1)
    netlist = one_unit([1, -2, 1, 1, -1, 1, 1, 1, 1, -1], 1)
    X = rng.integers(0, 2, (n, 10)).astype(np.bool_)
    np.testing.assert_array_equal(PackedEvaluator(netlist).evaluate(X), evaluate(netlist, X))


def test_counts_are_compared_chunk_by_chunk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("varishold.circuit.packed.evaluator._CHUNK_ROWS", 128)
    netlist = Netlist(
        ("a", "b"),
        (Comparator(0, 10), Comparator(1, -5), Comparator(0, 20)),
        (Hyperplane([(0, 1), (1, 1), (2, 1)], 1),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("no", "yes"),
    )
    X = np.random.default_rng(0).integers(-30, 30, (1000, 2))
    np.testing.assert_array_equal(PackedEvaluator(netlist).evaluate(X), evaluate(netlist, X))


@pytest.mark.parametrize("classes", [2, 3, 200, 300])
def test_many_classes(classes: int) -> None:
    rng = np.random.default_rng(classes)
    netlist = Netlist(
        tuple(f"v{k}" for k in range(12)),
        (),
        tuple(Hyperplane([(k, 1)], 0) for k in range(12)),
        tuple(Term([(k, 1)]) for k in range(12)),
        tuple(Score([(k, int(w)) for k, w in enumerate(rng.integers(-3, 4, 12)) if w]) for _ in range(classes)),
        tuple(f"class {k}" for k in range(classes)),
    )
    X = rng.integers(0, 2, (500, 12))
    np.testing.assert_array_equal(PackedEvaluator(netlist).evaluate(X), evaluate(netlist, X))


@pytest.mark.parametrize(
    ("weights", "bias", "gates"),
    [
        ([1, 1], 0, 1),  # OR
        ([1, 1], 1, 1),  # AND
        ([1, -1], 0, 1),  # AND NOT
        ([1, 1, 1], 1, 4),  # majority of three
        ([1] * 5, 0, 4),  # OR of five
        ([3, 1, 1, 1], 2, 3),  # the heavy one, or all three others
        ([1], 0, 0),  # a wire
    ],
)
def test_known_gate_counts(weights: list[int], bias: int, gates: int) -> None:
    assert gate_count(one_unit(weights, bias)) == gates


@quick
@given(netlists())
def test_gate_count_does_not_depend_on_the_form(netlist: Netlist) -> None:
    assert gate_count(simplify(netlist)) == gate_count(netlist)


def test_a_common_adder_is_built_once() -> None:
    def voters(*bits: int) -> Hyperplane:
        return Hyperplane([(bit, 1) for bit in bits], 2)

    def netlist(*units: Hyperplane) -> Netlist:
        terms = tuple(Term([(k, 1)]) for k in range(len(units)))
        scores = (Score([]), *(Score([(k, 1)]) for k in range(len(units))))
        return Netlist(tuple("abcdefgh"), (), units, terms, scores, tuple("wxyz"[: len(scores)]))

    one, other = voters(0, 1, 2, 3, 4), voters(0, 1, 2, 5, 6)
    apart = gate_count(netlist(one, voters(3, 4, 5, 6, 7)))
    assert apart - gate_count(netlist(one, other)) == 5


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda e: e.pack([[0, 1, 2]]), r"got 2 at \(row, column\) = \(0, 2\)"),
        (lambda e: e.pack(np.full((70, 3), 7, np.uint8)), r"got 7 at \(row, column\) = \(0, 0\)"),
        (lambda e: e.pack([[0.0, np.nan, 1.0]]), r"got nan at \(row, column\) = \(0, 1\)"),
        (lambda e: e.pack([["a", "b", "c"]]), "numbers 0 or 1, got dtype <U1"),
        (lambda e: e.pack([0, 1, 1]), r"must have shape \(n_grasps, n_switches\), got \(3,\)"),
        (lambda e: e.pack([[0, 1]]), "must have 3 bits for this netlist, got 2"),
        (lambda e: pack(np.full((9, 12), 2, np.uint8)), r"must be 0 or 1, got 2 at"),
        (lambda e: PackedGrasps(np.zeros((3, 2), np.uint64), 64), r"must have shape \(n_bits, 1\)"),
    ],
)
def test_bad_grasps_are_named(call, message: str) -> None:
    evaluator = PackedEvaluator(one_unit([1, 1, 1], 1))
    with pytest.raises(InputError, match=message):
        call(evaluator)


def test_an_evaluator_that_was_copied_or_sent_elsewhere_answers_alike() -> None:
    import copy
    import pickle

    netlist = Netlist(
        channels=("a", "b", "c"),
        comparators=(),
        units=(Hyperplane([(0, 1), (1, 1), (2, 1)], 1),),
        terms=(Term([(0, 1)]),),
        scores=(Score([]), Score([(0, 1)])),
        classes=("few", "many"),
    )
    evaluator = PackedEvaluator(netlist)
    rows = [[0, 1, 0], [1, 1, 0], [1, 1, 1]]
    text = pickle.dumps(evaluator)
    others = [copy.deepcopy(evaluator), pickle.loads(text)]
    del evaluator
    for other in others:
        assert other.evaluate(rows).tolist() == [0, 1, 1]


@pytest.mark.parametrize(("classes", "dtype"), [(256, np.uint8), (257, np.intp)])
def test_so_many_classes_fit_a_byte(classes: int, dtype: type) -> None:
    network_bits = 9
    # Class k wins where the bits say k: a term of each, which outweighs all others.
    terms = [Term([(b, k >> b & 1) for b in range(network_bits)]) for k in range(classes)]
    scores = tuple(Score([(k, 1)]) for k in range(classes))
    netlist = Netlist(
        tuple(f"b{k}" for k in range(network_bits)),
        (),
        tuple(Hyperplane([(k, 1)], 0) for k in range(network_bits)),
        tuple(terms),
        scores,
        tuple(f"class {k}" for k in range(classes)),
    )
    evaluator = PackedEvaluator(netlist)
    X = np.arange(classes)[:, None] >> np.arange(network_bits) & 1
    told = evaluator.predict(evaluator.pack(X))
    assert told.dtype == dtype
    assert told.tolist() == list(range(classes))
    assert evaluator.predict(evaluator.pack(X[:0])).shape == (0,)


@pytest.mark.parametrize("rows", [0, 1, 3])
@pytest.mark.parametrize("words", [0, 1, 7, 8, 9, 17])
def test_rows_of_words_begin_where_vectors_do(rows: int, words: int) -> None:
    for _ in range(4):
        made = aligned_words(rows, words)
        assert made.shape == (rows, words)
        assert not made.any()
        if made.size:
            assert made.ctypes.data % 64 == made.strides[0] % 64 == 0
            assert made.strides[0] < 8 * words + 64


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([[2.0, 0.0, 0.0]], "got 2.0 at"),
        (np.ones((1, 3), complex), "numbers 0 or 1, got dtype complex128"),
        (np.full((2, 9), -1, np.int8), r"got -1 at \(row, column\) = \(0, 0\)"),
        ([[0, 1, 0], [1, 0.5, 0]], r"got 0.5 at \(row, column\) = \(1, 1\)"),
    ],
)
def test_switches_are_on_or_off(values: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        pack(values)
