"""The circuit: hyperplanes between switch patterns, reduced to integers, gates and generated source.

A `Netlist` says what is computed; `evaluate` computes it in numpy and is the reference that every other
back end is compared with. `simplify` brings a netlist into a canonical form.
"""

from __future__ import annotations

from varishold.circuit.evaluation import bits_of, class_scores, evaluate, fired_units, true_terms
from varishold.circuit.interchange import netlist_from_json, netlist_to_json, read_netlist, write_netlist
from varishold.circuit.netlist import Comparator, Hyperplane, Netlist, Score, Term
from varishold.circuit.simplification import simplify

__all__ = [
    "Comparator",
    "Hyperplane",
    "Netlist",
    "Score",
    "Term",
    "bits_of",
    "class_scores",
    "evaluate",
    "fired_units",
    "netlist_from_json",
    "netlist_to_json",
    "read_netlist",
    "simplify",
    "true_terms",
    "write_netlist",
]
