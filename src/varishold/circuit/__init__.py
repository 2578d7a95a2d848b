"""The circuit: hyperplanes between switch patterns, reduced to integers, gates and generated source.

A `Netlist` says what is computed; `evaluate` computes it in numpy and is the reference that every other
back end is compared with. `simplify` brings a netlist into a canonical form.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Comparator",
    "Cover",
    "Hyperplane",
    "Netlist",
    "PackedEvaluator",
    "PackedGrasps",
    "Score",
    "Term",
    "bits_of",
    "circuit_size",
    "class_scores",
    "evaluate",
    "fired_units",
    "gate_count",
    "minimize",
    "netlist_from_json",
    "netlist_to_json",
    "pack",
    "read_netlist",
    "simplify",
    "true_terms",
    "write_netlist",
]

if TYPE_CHECKING:
    from varishold.circuit.elements import Comparator, Hyperplane, Score, Term
    from varishold.circuit.evaluation import bits_of, class_scores, evaluate, fired_units, true_terms
    from varishold.circuit.interchange import netlist_from_json, netlist_to_json, read_netlist, write_netlist
    from varishold.circuit.minimization import Cover, minimize
    from varishold.circuit.netlist import Netlist
    from varishold.circuit.packed import PackedEvaluator, PackedGrasps, pack
    from varishold.circuit.simplification import simplify
    from varishold.circuit.synthesis import circuit_size, gate_count
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
