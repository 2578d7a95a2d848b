"""What is drawn and written of a circuit can be read back: text and SVG to a netlist, C to its types, JSON to lines."""

from __future__ import annotations

import itertools
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from tests.test_circuit_netlist import netlists
from tests.test_circuit_writers import CASES

from varishold.circuit import Comparator, Hyperplane, Netlist, Score, Term, evaluate, netlist_to_json, simplify
from varishold.circuit.writers import WRITERS, c99_files, verilog_files
from varishold.circuit.writers.c99 import _signed_type, _unsigned_type
from varishold.circuit.writers.names import identifier
from varishold.circuit.writers.vectors import check_vectors
from varishold.errors import InputError

few = settings(max_examples=40)
MOST = 2**31 - 1


def with_names(*names: str, classes: tuple[str, ...] = ("no", "yes")) -> Netlist:
    return Netlist(
        names,
        (),
        tuple(Hyperplane([(k, 1)], 0) for k in range(len(names))),
        (Term([(0, 1)]),),
        (Score([]), *(Score([(0, 1)]) for _ in classes[1:])),
        classes,
    )


# Text


def read_text(text: str, n_units: int) -> tuple[dict[str, list[str]], dict[str, str], list[str]]:
    """Return each wire's cells by its name, what stands behind them, and the lines of the decision."""
    body, _, decision = text.partition("\n\n") if not text.startswith("\n") else ("", "", text[1:])
    lines = body.splitlines()
    if not n_units:
        rows = [re.fullmatch(r"(\S+) +(── ?\w*)", line) for line in lines]
        assert all(rows)
        return {row[1]: [] for row in rows if row}, {row[1]: row[2] for row in rows if row}, decision.splitlines()
    ends = [match.end() for match in re.finditer(r"s\d+", lines[0])]
    assert lines[0].split() == [f"s{k + 1}" for k in range(n_units)]
    sum_row = next(line for line in lines if line.startswith("sum > "))
    names = [line for line in lines[1:] if not line.startswith(" ")]
    label = max(len(re.split(r"  +|──", line)[0]) for line in names) + 2
    width = ends[0] - label
    np.testing.assert_array_equal(np.diff(ends), width)
    cells: dict[str, list[str]] = {}
    behind: dict[str, str] = {}
    for line in lines[1:]:
        parts = [line[label + k * width : label + (k + 1) * width] for k in range(n_units)]
        fill = " " if line is sum_row or line.startswith(" ") else "─"
        assert all(part.startswith(fill * 2) for part in parts)
        name = line[:label].rstrip()
        cells[name] = [part.lstrip(fill) for part in parts]
        behind[name] = line[label + n_units * width :]
    # As narrow as can be.
    assert width == max(len(cell) for cell in [*itertools.chain(*cells.values()), *lines[0].split()]) + 2
    return cells, behind, decision.splitlines()


@few
@given(netlists())
def test_the_text_is_read_back_as_the_netlist(netlist: Netlist) -> None:
    cells, behind, decision = read_text(netlist.diagram(), len(netlist.units))
    used = sorted({bit for unit in netlist.units for bit, _ in unit.weights})
    names = [netlist.bit_names[bit] for bit in used]
    if len(set(names)) < len(names):
        return
    sums = ["sum >", ""] if netlist.units else []
    assert list(cells) == [*names, *sums, *(f"t{t + 1}" for t in range(len(netlist.terms)))]
    for k, unit in enumerate(netlist.units):
        read = [(bit, int(cells[name][k])) for bit, name in zip(used, names, strict=True) if cells[name][k] != "┼"]
        assert tuple(read) == unit.weights
        assert int(cells["sum >"][k]) == unit.bias
        assert cells[""][k] == "│"
    for t, term in enumerate(netlist.terms):
        marks = cells[f"t{t + 1}"]
        assert tuple((k, "○●".index(mark)) for k, mark in enumerate(marks) if mark != "┼") == term.literals
        gate = " AND" if len(term.literals) > 1 else "" if term.literals else " always"
        assert behind[f"t{t + 1}"] == f"──{gate}"
    if decision[0] != "the largest score wins, the upper among equals:":
        return
    assert len({line.index(" = ") for line in decision[1:]}) == 1
    assert min(line.index(" = ") for line in decision[1:]) == 2 + max(map(len, netlist.classes))
    for line, label, score in zip(decision[1:], netlist.classes, netlist.scores, strict=True):
        name, told = line.split(" = ")
        assert name.rstrip() == f"  {label}"
        assert int(told.split()[0]) == score.bias
        pairs = re.findall(r" ([+-]\d+) t(\d+)", told)
        assert tuple((int(t) - 1, int(w)) for w, t in pairs) == score.weights


def test_class_names_of_different_lengths_line_up_and_long_names_end_in_an_ellipsis() -> None:
    netlist = with_names("x" * 32, "y" * 33, "tab\there", classes=("a", "long name", "b"))
    text = netlist.diagram()
    assert "x" * 32 in text
    assert "y" * 31 + "…" in text
    assert "y" * 32 not in text
    assert "tab here" in text
    assert "\n  a         = 0\n  long name = 0 +1 t1\n" in text
    root = ElementTree.fromstring(netlist.diagram_svg())
    written = [element.text for element in root.iter() if element.tag.endswith("text")]
    assert {"x" * 32, "y" * 31 + "…", "tab here"} <= set(written)


# SVG


def even(places: list[float], height: float, row: int) -> None:
    """Check that places divide the height below the heads, and above the foot, evenly."""
    wanted = 2 * row + (np.arange(len(places)) + 0.5) * (height - 3 * row) / max(len(places), 1)
    assert all(0 <= exact - place < 1 for exact, place in zip(wanted, places, strict=True))


@few
@given(netlists(max_channels=9))
def test_a_drawing_is_read_back_as_the_netlist(netlist: Netlist) -> None:
    root = ElementTree.fromstring(netlist.diagram_svg())
    elements = [(element.tag.rpartition("}")[2], element) for element in root]
    heads = [(float(e.get("x", 0)), e.text) for tag, e in elements if tag == "text" and e.get("fill") == "#666"]
    assert [text for _, text in heads] == ["switches", "hyperplanes", "terms", "class"]
    x_bits, x_units, x_terms, x_classes = (x for x, _ in heads)
    _, _, width, height = map(float, root.get("viewBox", "").split())
    assert (root.get("width"), root.get("height")) == (f"{width:.0f}", f"{height:.0f}")
    assert x_bits < x_units < x_terms < x_classes < width

    used = sorted({bit for unit in netlist.units for bit, _ in unit.weights})
    boxes = [e for tag, e in elements if tag == "rect" and e.get("rx")]
    bits = [e for tag, e in elements if tag == "text" and float(e.get("x", 0)) == x_bits and e.get("fill") is None]
    y_bits = [float(e.get("y", 0)) - 4 for e in bits]
    assert [e.text for e in bits] == [netlist.bit_names[bit] for bit in used]
    y_units, y_classes = (
        [float(e.get("y", 0)) + 10 for e in boxes if float(e.get("x", 0)) == x] for x in (x_units, x_classes)
    )
    y_terms = [float(re.findall(r"M\d+ (\d+)", e.get("d", ""))[0]) + 10 for tag, e in elements if tag == "path"]
    # One row a switch and two a box, three for heads and foot.
    rows = max(len(used), 2 * len(netlist.units), 2 * len(netlist.terms), 2 * len(netlist.classes), 1)
    assert height % (rows + 3) == 0
    for places in (y_bits, y_units, y_terms, y_classes):
        even(places, height, int(height // (rows + 3)))

    gate_paths = [re.findall(r"h(\d+)a(\d+) ", e.get("d", ""))[0] for tag, e in elements if tag == "path"]
    right_of_gate = sum(map(float, gate_paths[0])) if gate_paths else 0.0
    weights: list[list[tuple[int, int]]] = [[] for _ in netlist.units]
    votes: list[list[tuple[int, int]]] = [[] for _ in netlist.scores]
    pins: list[list[tuple[int, float]]] = [[] for _ in netlist.terms]
    for (tag, line), (_, after) in itertools.pairwise([*elements, ("", ElementTree.Element("end"))]):
        if tag != "line":
            continue
        x1, y1, x2, y2 = (float(line.get(name, 0)) for name in ("x1", "y1", "x2", "y2"))
        sign = -1 if line.get("stroke-dasharray") else 1
        if x2 == x_units:
            # A weight other than one stands behind its line, at three quarters of it.
            weight = sign
            if after.get("font-size") == "10":
                weight = int(after.text or 0)
                assert abs(weight) != 1
                assert np.sign(weight) == sign
                assert float(after.get("x", 0)) == (x1 + 3 * x2) // 4
                assert float(after.get("y", 0)) == (y1 + 3 * y2) // 4 - 2
            weights[y_units.index(y2)].append((used[y_bits.index(y1)], weight))
            assert x1 > x_bits
        elif x2 == x_terms:
            term = int(np.argmin(np.abs(np.array(y_terms) - y2)))
            assert x1 == x_units + float(boxes[0].get("width", 0))
            pins[term].append((y_units.index(y1), y2))
        else:
            assert (x1, x2) == (x_terms + right_of_gate, x_classes)
            votes[y_classes.index(y2)].append((y_terms.index(y1), sign))
    assert [tuple(sorted(row)) for row in weights] == [unit.weights for unit in netlist.units]
    signs_of = [tuple((t, 1 if w > 0 else -1) for t, w in score.weights) for score in netlist.scores]
    assert [tuple(sorted(row)) for row in votes] == signs_of
    rings = {float(e.get("cy", 0)) for tag, e in elements if tag == "circle"}
    assert all(float(e.get("cx", 0)) + float(e.get("r", 0)) == x_terms for tag, e in elements if tag == "circle")
    for y, row, term in zip(y_terms, pins, netlist.terms, strict=True):
        assert tuple((unit, int(pin not in rings)) for unit, pin in row) == term.literals
        # Pins stand evenly on the gate's side, which is 20 high.
        wanted = y - 8 + 16 * (np.arange(len(row)) + 1) / (len(row) + 1)
        assert all(0 <= exact - pin < 1 for exact, (_, pin) in zip(wanted, row, strict=True))
    written = [e.text for tag, e in elements if tag == "text" and e.get("x") == f"{x_units + 6:.0f}"]
    assert written == [f"s{k + 1}: sum > {unit.bias}" for k, unit in enumerate(netlist.units)]
    gates = [e.text for tag, e in elements if tag == "text" and e.get("x") == f"{x_terms + 8:.0f}"]
    assert gates == [("1", None, "AND")[min(len(term.literals), 2)] for term in netlist.terms]
    classes = [e.text or "" for tag, e in elements if tag == "text" and e.get("x") == f"{x_classes + 6:.0f}"]
    told_or = re.search(r"^(.*) where .*, otherwise (.*)$", netlist.diagram(), re.MULTILINE)
    for text, label in zip(classes, netlist.classes, strict=True):
        assert text == ("" if told_or is None else "OR: " if label == told_or[1] else "else: ") + label


# Source


@pytest.mark.parametrize("to", ["c", "verilog"])
@pytest.mark.parametrize("netlist", CASES)
def test_source_is_laid_out_for_people(to: str, netlist: Netlist) -> None:
    for name, text in WRITERS[to](netlist, "hand", vectors=8).items():
        assert text.endswith("\n"), name
        assert not text.endswith("\n\n"), name
        assert not text.startswith("\n"), name
        assert "\n\n\n" not in text, name
        for line in text.splitlines():
            assert line == line.rstrip(), name
            assert (len(line) - len(line.lstrip())) % 4 == 0, name


@pytest.mark.parametrize(
    ("most", "unsigned", "signed"),
    [
        (0, "uint8_t", "int8_t"),
        (127, "uint8_t", "int8_t"),
        (128, "uint8_t", "int16_t"),
        (255, "uint8_t", "int16_t"),
        (256, "uint16_t", "int16_t"),
        (32767, "uint16_t", "int16_t"),
        (32768, "uint16_t", "int32_t"),
        (65535, "uint16_t", "int32_t"),
        (65536, "uint32_t", "int32_t"),
    ],
)
def test_types_are_as_small_as_can_be(most: int, unsigned: str, signed: str) -> None:
    assert _unsigned_type(most) == unsigned
    assert _signed_type([most]) == _signed_type([0, -most, 1]) == signed
    assert _signed_type([]) == "int8_t"


def tables_of(text: str) -> dict[str, tuple[str, list[int]]]:
    found = re.findall(r"static const (\w+) (\w+)\[(\d+)\] = \{(.*?)\};", text, re.DOTALL)
    tables = {name: (kind, [int(value) for value in re.findall(r"-?\d+", body)]) for kind, name, _, body in found}
    assert [len(tables[name][1]) for _, name, _, _ in found] == [int(n) for _, _, n, _ in found]
    return tables


@settings(max_examples=10)
@given(netlists(max_channels=9))
def test_tables_in_c_are_the_simplified_netlist(netlist: Netlist) -> None:
    small, files = simplify(netlist), c99_files(netlist, "hand", vectors=20)
    tables = tables_of(files["hand.c"])
    X = check_vectors(netlist, 20)
    rows = re.findall(r"^    \{ (.*) \},?$", files["hand_test.c"], re.MULTILINE)
    assert [[int(v) for v in row.split(", ")] for row in rows] == X.tolist()
    assert tables_of(files["hand_test.c"])["expected"][1] == evaluate(netlist, X).tolist()
    assert re.findall(r"scores\[HAND_CLASSES\] = \{ (.*) \}", files["hand.c"]) == [
        ", ".join(str(score.bias) for score in small.scores)
    ]
    if not small.units:
        assert not tables
        return
    used = sorted({bit for unit in small.units for bit, _ in unit.weights})
    channels = [netlist.comparators[bit].channel for bit in used] if netlist.comparators else used
    assert tables["bit_channels"][1] == channels
    assert ("bit_thresholds" in tables) == bool(netlist.comparators)
    if netlist.comparators:
        assert tables["bit_thresholds"][1] == [netlist.comparators[bit].threshold for bit in used]
    ends = [0, *tables["unit_ends"][1]]
    bits, weights = tables["unit_bits"][1], tables["unit_weights"][1]
    units = [
        tuple((used[k], w) for k, w in zip(bits[a:b], weights[a:b], strict=True)) for a, b in itertools.pairwise(ends)
    ]
    assert units == [unit.weights for unit in small.units]
    assert tables["unit_biases"][1] == [unit.bias for unit in small.units]
    literals = tables["term_literals"][1]
    terms = [tuple((x // 2, x % 2) for x in literals[a:b]) for a, b in itertools.pairwise([0, *tables["term_ends"][1]])]
    assert terms == [term.literals for term in small.terms]
    classes, gains = tables["gain_classes"][1], tables["gains"][1]
    columns = [
        list(zip(classes[a:b], gains[a:b], strict=True)) for a, b in itertools.pairwise([0, *tables["gain_ends"][1]])
    ]
    for t, column in enumerate(columns):
        assert column == [(k, dict(s.weights)[t]) for k, s in enumerate(small.scores) if t in dict(s.weights)]


@few
@given(netlists())
def test_json_has_one_line_for_each_part(netlist: Netlist) -> None:
    text, document = netlist_to_json(netlist), netlist.to_dict()
    lines = text.splitlines()
    lists = [value for value in document.values() if isinstance(value, list) and value]
    assert len(lines) == 2 + len(document) + sum(1 + len(value) for value in lists)
    assert json.loads(text) == document
    assert text.endswith("}\n")
    inner = [json.loads(line.strip().rstrip(",")) for line in lines if line.startswith("  ")]
    assert inner == [item for value in lists for item in value]


@pytest.mark.parametrize(
    ("threshold", "count_bits", "fits"),
    [(127, 8, True), (128, 8, False), (-128, 8, True), (-129, 8, False), (MOST, 32, True), (-MOST, 32, True)],
)
def test_thresholds_fit_the_counts_of_a_bench(threshold: int, count_bits: int, fits: bool) -> None:
    netlist = Netlist(
        ("a", "b"),
        (Comparator(1, threshold), Comparator(0, 3)),
        (Hyperplane([(0, 2), (1, -1)], 0),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("no", "yes"),
    )
    if not fits:
        with pytest.raises(
            InputError, match=rf"comparators\[0\] has threshold {threshold}, which does not fit 8 signed"
        ):
            verilog_files(netlist, count_bits=count_bits)
        return
    files = verilog_files(netlist, "hand", vectors=64, count_bits=count_bits)
    lines = files["hand_vectors.hex"].splitlines()
    assert len(lines) == 64
    least, most = -(2 ** (count_bits - 1)), 2 ** (count_bits - 1) - 1
    rows = []
    for line in lines:
        word = int(line, 16)
        row = [word >> k * count_bits & (2**count_bits - 1) for k in (0, 1)]
        row = [value - 2**count_bits if value > most else value for value in row]
        assert evaluate(netlist, [row])[0] == word >> 2 * count_bits
        rows.append(row)
    assert np.min(rows) == max(least, -MOST)
    assert np.max(rows) == most
    assert f"{count_bits}'h{threshold % 2**count_bits:x}" in files["hand.v"]


@settings(max_examples=10)
@given(netlists())
def test_sums_in_verilog_are_as_wide_as_they_need(netlist: Netlist) -> None:
    small, text = simplify(netlist), verilog_files(netlist, "hand", vectors=8)["hand.v"]
    widths = [int(n) + 1 for n in re.findall(r"wire \[(\d+):0\] sum_\d+ = ", text)]
    assert widths == [sum(abs(w) for _, w in unit.weights).bit_length() for unit in small.units]
    rows = [[dict(score.weights).get(t, 0) for t in range(len(small.terms))] for score in small.scores]
    raised = np.array(rows, int).reshape(len(rows), -1)
    raised = raised - raised.min(axis=0, initial=0) if not raised.size else raised - raised.min(axis=0)
    biases = np.array([score.bias for score in small.scores])
    most = int((raised.sum(axis=1) + biases - biases.min()).max())
    score_widths = {int(n) + 1 for n in re.findall(r"wire \[(\d+):0\] score_\d+ = ", text)}
    assert score_widths == {max(1, most.bit_length())}
    assert "'d-" not in text


def test_identifiers_are_of_at_most_forty_eight_characters() -> None:
    assert identifier("a" * 48) == identifier("a" * 60) == "a" * 48
    assert identifier("a" * 47 + "--b") == "a" * 47
    assert identifier("-A--b.") == "a_b"
    assert (identifier(""), identifier("9"), identifier("while")) == ("m", "m_9", "m_while")
