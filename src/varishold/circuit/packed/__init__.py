"""Packed evaluation: sixty-four grasps a word, a netlist as bitwise operations on words.

`grasps` packs rows into words, `program` orders a network of gates into instructions, `kernel` runs any program,
and `PackedEvaluator` does all of it for one netlist.
"""

from __future__ import annotations

from varishold.circuit.packed.evaluator import PackedEvaluator
from varishold.circuit.packed.grasps import PackedGrasps, pack

__all__ = ["PackedEvaluator", "PackedGrasps", "pack"]
