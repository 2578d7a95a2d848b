"""The block diagram: every layer is on it, it lines up, and names cannot break it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

from hypothesis import given
from tests.test_circuit_netlist import CYLINDER, netlists

from varishold.circuit import Hyperplane, Netlist, Score, Term


@given(netlists())
def test_every_unit_term_and_class_is_drawn(netlist: Netlist) -> None:
    text = netlist.diagram()
    for k in range(len(netlist.units)):
        assert f"s{k + 1}" in text
    for k in range(len(netlist.terms)):
        assert f"t{k + 1} " in text
    for label in netlist.classes:
        assert label in text
    root = ElementTree.fromstring(netlist.diagram_svg())
    texts = "\n".join(element.text or "" for element in root.iter() if element.tag.endswith("text"))
    for label in netlist.classes:
        assert label in texts


def test_columns_line_up() -> None:
    lines = CYLINDER.diagram().splitlines()
    wires = [line for line in lines if "│" in line or "●" in line or "┼" in line]
    columns = {k for line in wires for k, character in enumerate(line) if character in "│┼●○"}
    assert len(columns) == 2


def test_an_or_is_called_an_or() -> None:
    assert "cylinder where t1, otherwise pillar" in CYLINDER.diagram()
    assert "OR: cylinder" in CYLINDER.diagram_svg()


def test_names_are_escaped_and_shortened() -> None:
    netlist = Netlist(
        ('<script>"&', "line\nbreak" + "x" * 100),
        (),
        (Hyperplane([(0, 1), (1, 1)], 0),),
        (Term([(0, 1)]),),
        (Score([]), Score([(0, 1)])),
        ("</svg>\x00", "手"),
    )
    ElementTree.fromstring(netlist.diagram_svg())
    assert "<script>" not in netlist.diagram_svg()
    assert max(map(len, netlist.diagram().splitlines())) < 80


def test_the_examples_of_the_documentation_hold() -> None:
    page = (Path(__file__).parents[1] / "docs" / "circuit.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    exec(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0], names)
    netlist = names["netlist"]
    assert isinstance(netlist, Netlist)
    assert netlist.diagram().strip("\n") in page
    assert Netlist.from_dict(json.loads(re.findall(r"```json\n(.*?)```", page, re.DOTALL)[0])) == netlist
