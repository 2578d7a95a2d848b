"""The netlist: its meaning, its canonical form, its file, and what it refuses."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.circuit import (
    Comparator,
    Hyperplane,
    Netlist,
    Score,
    Term,
    class_scores,
    evaluate,
    fired_units,
    netlist_from_json,
    netlist_to_json,
    read_netlist,
    simplify,
    true_terms,
    write_netlist,
)
from varishold.errors import FormatError, InputError


def _sparse(size: int, low: int, high: int, max_entries: int = 6):
    if size == 0:
        return st.just([])
    return st.dictionaries(st.integers(0, size - 1), st.integers(low, high).filter(bool), max_size=max_entries).map(
        lambda d: list(d.items())
    )


@st.composite
def netlists(draw, max_channels: int = 6, with_comparators: bool | None = None) -> Netlist:
    """Any small netlist, including constant units, empty terms and single classes."""
    channels = draw(st.integers(1, max_channels))
    comparators: list[Comparator] = []
    if with_comparators or (with_comparators is None and draw(st.booleans())):
        pairs = st.tuples(st.integers(0, channels - 1), st.integers(-3, 3))
        comparators = [Comparator(c, t) for c, t in draw(st.lists(pairs, min_size=1, max_size=8))]
    bits = len(comparators) or channels
    units = [Hyperplane(draw(_sparse(bits, -3, 3)), draw(st.integers(-5, 5))) for _ in range(draw(st.integers(0, 5)))]
    terms = [Term(draw(_sparse_literals(len(units)))) for _ in range(draw(st.integers(0, 5)))]
    classes = draw(st.integers(1, 4))
    scores = [Score(draw(_sparse(len(terms), -4, 4)), draw(st.integers(-3, 3))) for _ in range(classes)]
    return Netlist(
        tuple(f"switch {k}" for k in range(channels)),
        tuple(comparators),
        tuple(units),
        tuple(terms),
        tuple(scores),
        tuple(f"class {k}" for k in range(classes)),
    )


def _sparse_literals(size: int):
    if size == 0:
        return st.just([])
    return st.dictionaries(st.integers(0, size - 1), st.integers(0, 1), max_size=4).map(lambda d: list(d.items()))


def every_input(netlist: Netlist) -> np.ndarray:
    """Every switch pattern; with comparators, random counts that straddle the thresholds."""
    r = len(netlist.channels)
    if netlist.comparators:
        return np.random.default_rng(0).integers(-5, 6, size=(200, r))
    return (np.arange(2**r)[:, None] >> np.arange(r)) & 1


def by_hand(netlist: Netlist, row: np.ndarray) -> int:
    """The definition in plain Python, written without looking at the evaluator."""
    bits = [int(row[c.channel] >= c.threshold) for c in netlist.comparators] or [int(x) for x in row]
    fired = [sum(w * bits[k] for k, w in unit.weights) > unit.bias for unit in netlist.units]
    terms = [all(fired[u] == bool(wanted) for u, wanted in term.literals) for term in netlist.terms]
    scores = [sum(w * terms[t] for t, w in score.weights) + score.bias for score in netlist.scores]
    return scores.index(max(scores))


CYLINDER = Netlist(
    channels=("palm", "tip"),
    comparators=(),
    units=(Hyperplane([(0, 1)], 0, pair=(3, 7)), Hyperplane([(1, 1)], 0)),
    terms=(Term([(0, 1), (1, 0)]),),
    scores=(Score([], 1), Score([(0, 2)], 0)),
    classes=("pillar", "cylinder"),
)


@given(netlists())
def test_evaluate_follows_the_definition(netlist: Netlist) -> None:
    X = every_input(netlist)
    assert evaluate(netlist, X).tolist() == [by_hand(netlist, row) for row in X]


@given(netlists())
def test_a_netlist_survives_its_file(netlist: Netlist) -> None:
    text = netlist_to_json(netlist)
    assert netlist_from_json(text) == netlist
    assert netlist_to_json(netlist_from_json(text)) == text
    assert Netlist.from_dict(json.loads(json.dumps(netlist.to_dict()))) == netlist


@given(netlists())
def test_simplify_keeps_every_answer_and_is_idempotent(netlist: Netlist) -> None:
    smaller = simplify(netlist)
    X = every_input(netlist)
    np.testing.assert_array_equal(evaluate(smaller, X), evaluate(netlist, X))
    assert simplify(smaller) == smaller
    assert len(smaller.units) <= len(netlist.units)
    assert len(smaller.terms) <= len(netlist.terms)


@given(netlists(), st.randoms(use_true_random=False))
def test_simplify_forgets_the_order_of_units_and_terms(netlist: Netlist, random) -> None:
    unit_order = list(range(len(netlist.units)))
    term_order = list(range(len(netlist.terms)))
    random.shuffle(unit_order)
    random.shuffle(term_order)
    shuffled = dataclasses.replace(
        netlist,
        units=tuple(netlist.units[u] for u in unit_order),
        terms=tuple(
            Term([(unit_order.index(u), wanted) for u, wanted in netlist.terms[t].literals]) for t in term_order
        ),
        scores=tuple(
            Score([(term_order.index(t), w) for t, w in score.weights], score.bias) for score in netlist.scores
        ),
    )
    assert netlist_to_json(simplify(shuffled)) == netlist_to_json(simplify(netlist))


@given(st.lists(st.tuples(st.integers(0, 1), st.integers(0, 1)), min_size=1, max_size=8))
def test_a_bisector_fires_where_the_first_pattern_is_nearer(pairs: list[tuple[int, int]]) -> None:
    first, second = np.array(pairs).T
    unit = Hyperplane.between(first.tolist(), second.tolist(), pair=(4, 2))
    names = tuple(f"v{k}" for k in range(len(first)))
    netlist = Netlist(names, (), (unit,), (), (Score([]),), ("any",))
    X = every_input(netlist)
    nearer = np.abs(X - first).sum(axis=1) < np.abs(X - second).sum(axis=1)
    np.testing.assert_array_equal(fired_units(netlist, X)[:, 0], nearer)
    assert unit.pair == (4, 2)


def test_a_tie_does_not_fire_and_the_lowest_class_wins() -> None:
    assert not fired_units(CYLINDER, [[0, 0]]).any()
    netlist = dataclasses.replace(CYLINDER, scores=(Score([], 1), Score([(0, 1)], 0)))
    assert class_scores(netlist, [[1, 0]]).tolist() == [[1, 1]]
    assert evaluate(netlist, [[1, 0]]).tolist() == [0]


def test_layers_can_be_looked_at() -> None:
    assert fired_units(CYLINDER, [[1, 1]]).tolist() == [[True, True]]
    assert true_terms(CYLINDER, [[1, 0], [1, 1]]).tolist() == [[True], [False]]


@pytest.mark.parametrize("dtype", [bool, np.int8, np.uint8, np.int64, np.float32, np.float64])
def test_switches_may_come_in_any_number_type(dtype: type) -> None:
    assert evaluate(CYLINDER, np.array([[1, 0], [1, 1]], dtype)).tolist() == [1, 0]


def test_evaluate_streams_in_bounded_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    X = np.random.default_rng(1).integers(0, 2, (1000, 2))
    expected = evaluate(CYLINDER, X)
    monkeypatch.setattr("varishold.circuit.evaluation._CHUNK_ENTRIES", 7)
    np.testing.assert_array_equal(evaluate(CYLINDER, X), expected)
    assert evaluate(CYLINDER, X[:0]).shape == (0,)
    X[777, 1] = 3
    with pytest.raises(InputError, match=r"got 3 at \(row, column\) = \(777, 1\)"):
        evaluate(CYLINDER, X)


@pytest.mark.parametrize(
    ("X", "message"),
    [
        ([0, 1], "X must have shape (n_grasps, 2), one column a channel, got (2,)"),
        ([[0, 1, 1]], "X must have shape (n_grasps, 2), one column a channel, got (1, 3)"),
        ([["a", "b"]], "X must hold integers, got dtype <U1"),
        ([[0, 1], [0, 2]], "X must hold 0 or 1, got 2 at (row, column) = (1, 1)"),
        ([[0.5, 1]], "X must hold 0 or 1, got 0.5 at (row, column) = (0, 0)"),
        ([[0, np.nan]], "X must hold 0 or 1, got nan at (row, column) = (0, 1)"),
    ],
)
def test_evaluate_says_what_is_wrong_with_the_input(X: object, message: str) -> None:
    with pytest.raises(InputError) as caught:
        evaluate(CYLINDER, X)
    assert str(caught.value) == message


def test_counts_must_be_integers() -> None:
    netlist = dataclasses.replace(CYLINDER, comparators=(Comparator(0, 300), Comparator(1, -2)))
    assert evaluate(netlist, [[300, -3], [299, -3]]).tolist() == [1, 0]
    with pytest.raises(InputError, match=r"integer counts within 32 signed bits, got 2\.5"):
        evaluate(netlist, [[2.5, 0]])
    with pytest.raises(InputError, match="got 4294967296 at"):
        evaluate(netlist, [[0, 2**32]])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Hyperplane([(0, 0)], 0), "must not be zero"),
        (lambda: Hyperplane([(0, 1), (0, 2)], 0), "must name each index once, got 0 twice"),
        (lambda: Hyperplane([(-1, 1)], 0), "must not be negative, got -1"),
        (lambda: Hyperplane([(0, 1.5)], 0), "must be an integer, got 1.5"),
        (lambda: Hyperplane([(0, True)], 0), "must be an integer, got True"),
        (lambda: Hyperplane([(0, 2**31)], 0), "must fit 32 signed bits"),
        (lambda: Hyperplane([(0, 2**30), (1, 2**30)], 0), "must sum to at most 1073741823 in magnitude"),
        (lambda: Hyperplane([7], 0), r"must hold pairs \(index, integer\), got 7"),
        (lambda: Term([(0, 2)]), "must want 0 or 1, got 2 for unit 0"),
        (lambda: Comparator(0, 2**40), "must fit 32 signed bits"),
        (
            lambda: dataclasses.replace(CYLINDER, classes=("a", "a")),
            "classes must all differ, got 'a' at 0 and 1",
        ),
        (
            lambda: dataclasses.replace(CYLINDER, channels=("", "b")),
            r"channels\[0\] must be a name of 1 to 256",
        ),
        (lambda: dataclasses.replace(CYLINDER, channels=("\ud800", "b")), "must be valid Unicode"),
        (lambda: dataclasses.replace(CYLINDER, channels=()), "channels must not be empty"),
        (
            lambda: dataclasses.replace(CYLINDER, channels=("a",)),
            r"units\[1\] reads bit 1, but there are 1 bits",
        ),
        (lambda: dataclasses.replace(CYLINDER, classes=("a",)), "got 2 scores and 1 classes"),
        (lambda: dataclasses.replace(CYLINDER, units=()), r"terms\[0\] reads unit 1, but there are 0 units"),
        (lambda: dataclasses.replace(CYLINDER, terms=()), r"scores\[1\] reads term 0, but there are 0 terms"),
        (lambda: dataclasses.replace(CYLINDER, terms=(3,)), r"terms\[0\] must be of type Term, got int"),
        (lambda: dataclasses.replace(CYLINDER, comparators=(Comparator(5, 0),)), "reads channel 5"),
    ],
)
def test_a_netlist_refuses_what_makes_no_sense(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def _broken(**changes: object) -> str:
    return json.dumps({**CYLINDER.to_dict(), **changes})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (netlist_to_json(CYLINDER)[:-40], "not complete JSON"),
        ("", "not complete JSON: Expecting value at line 1, column 1"),
        ("[" * 100_000, "nested too deeply"),
        ("[1]", "must be a JSON object, got a list"),
        ("{}", '"format" must be "varishold-netlist", got None'),
        (
            _broken(version=2),
            "written in version 2 of the format, this program reads up to 1; update varishold",
        ),
        (_broken(version=True), '"version" must be a positive integer, got True'),
        (_broken(version="1"), "\"version\" must be a positive integer, got '1'"),
        (_broken(units=float("nan")), "numbers must be finite, got NaN"),
        (_broken(units={}), "units must be a list, got an object"),
        (_broken(units=[3]), r"units\[0\]: must be an object with weights, bias, got a number"),
        (_broken(units=[{"weights": []}]), r'units\[0\]: "bias" is missing'),
        (
            _broken(units=[{"weights": [], "bias": 0, "run": 1}]),
            r"units\[0\]: 'run' is not a key of version 1",
        ),
        (_broken(units=[{"weights": [[0, 1.0]], "bias": 0}]), "must be a list of two integers"),
        (
            _broken(units=[{"weights": [[0, 10**40]], "bias": 0}]),
            "units.*integer of more than 30 digits|32 signed",
        ),
        (_broken(units=[{"weights": [[10**9, 1]], "bias": 0}]), r"units\[0\] reads bit 1000000000"),
        (_broken(units=[{"weights": [], "bias": 0.5}]), "bias of a unit must be an integer, got 0.5"),
        (_broken(terms=[[[0, 1, 2]]]), r"terms\[0\]: must be a list of two integers"),
        (_broken(terms="AND"), "terms must be a list, got a string"),
        (_broken(classes=["a", "a"]), "classes must all differ"),
        (_broken(classes=["a", None]), r"classes\[1\]: must be a string, got null"),
        (_broken(extra=1), "'extra' is not a key of version 1"),
        ('{"format": "varishold-netlist", "version": 1' + "}", '"channels" is missing'),
        ('{"version": 1, "version": 1}', "key 'version' stands twice"),
        ('{"version": ' + "9" * 10_000 + "}", "an integer of thousands of digits"),
    ],
)
def test_a_hostile_file_gets_one_clear_line(tmp_path, text: str, message: str) -> None:
    path = tmp_path / "model.json"
    path.write_text(text)
    with pytest.raises(FormatError, match=message) as caught:
        read_netlist(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text_or_not_there(tmp_path) -> None:
    path = tmp_path / "model.json"
    with pytest.raises(InputError, match="there is no such file"):
        read_netlist(path)
    path.write_bytes(b"\xff{}")
    with pytest.raises(FormatError, match="is no UTF-8 text: byte 0 is not"):
        read_netlist(path)
    path.write_bytes(b"\xff\xfe{}{")
    with pytest.raises(FormatError, match="is no UTF-16 text: byte 4 is not"):
        read_netlist(path)


@settings(max_examples=200)
@given(st.data())
def test_a_damaged_file_never_escapes_as_another_error(data) -> None:
    text = netlist_to_json(CYLINDER)
    start = data.draw(st.integers(0, len(text)))
    stop = data.draw(st.integers(start, min(len(text), start + 12)))
    damaged = text[:start] + data.draw(st.text(max_size=6)) + text[stop:]
    message = ""
    try:
        netlist_from_json(damaged)
    except FormatError as error:
        message = str(error)
    assert "\n" not in message


def test_a_written_file_reads_back(tmp_path) -> None:
    write_netlist(CYLINDER, tmp_path / "model.json")
    assert read_netlist(tmp_path / "model.json") == CYLINDER
