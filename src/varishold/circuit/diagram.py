"""The block diagram of a netlist: switches, hyperplanes, terms and classes, for a person to read."""

from __future__ import annotations

from varishold.circuit.netlist import Netlist

__all__ = ["svg_diagram", "text_diagram"]


def text_diagram(netlist: Netlist) -> str:
    """Return the block diagram as text, one line a hyperplane, a term and a class."""
    lines = []
    for k, unit in enumerate(netlist.units):
        sum_ = " ".join(f"{weight:+d} {netlist.bit_names[bit]}" for bit, weight in unit.weights)
        lines.append(f"s{k} = [{sum_ or '0'} > {unit.bias}]")
    for k, term in enumerate(netlist.terms):
        product = " AND ".join(("" if wanted else "NOT ") + f"s{unit}" for unit, wanted in term.literals)
        lines.append(f"t{k} = {product or 'true'}")
    for label, score in zip(netlist.classes, netlist.scores, strict=True):
        sum_ = " ".join(f"{weight:+d} t{term}" for term, weight in score.weights)
        lines.append(f"{label}: {sum_} {score.bias:+d}".replace("  ", " "))
    return "\n".join(lines) + "\n"


def svg_diagram(netlist: Netlist) -> str:
    """Return the block diagram as an SVG document."""
    raise NotImplementedError
