"""A netlist over switches as a few matrices, made once, for answering many grasps in numpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.circuit import Netlist

__all__ = ["CompiledCircuit"]

_CHUNK_ENTRIES = 4_000_000


class CompiledCircuit:
    """Answers as `varishold.circuit.evaluate` does, without building the matrices anew at every call.

    Parameters
    ----------
    netlist : Netlist
        Without comparators: its channels are the switches.
    """

    def __init__(self, netlist: Netlist) -> None:
        units, terms = len(netlist.units), len(netlist.terms)
        # Doubles hold every sum exactly: a netlist bounds them to 31 bits.
        self.unit_weights = np.zeros((len(netlist.channels), units))
        for k, unit in enumerate(netlist.units):
            for bit, weight in unit.weights:
                self.unit_weights[bit, k] = weight
        self.unit_bias = np.array([unit.bias for unit in netlist.units], dtype=np.float64)
        # 1 where a term wants the unit to fire, -1 where it wants it not to.
        self.literals = np.zeros((units, terms), dtype=np.float64)
        for t, term in enumerate(netlist.terms):
            for unit_index, wanted in term.literals:
                self.literals[unit_index, t] = 1.0 if wanted else -1.0
        self.score_weights = np.zeros((terms, len(netlist.scores)))
        for c, score in enumerate(netlist.scores):
            for t, weight in score.weights:
                self.score_weights[t, c] = weight
        self.score_bias = np.array([score.bias for score in netlist.scores], dtype=np.float64)
        self._wanted = (self.literals > 0).sum(axis=0)
        single = terms == units and bool((self.literals == np.eye(units, terms)).all())
        self._terms_are_units = single
        self._step = max(1, _CHUNK_ENTRIES // max(1, units, terms, len(netlist.channels)))

    @property
    def n_switches(self) -> int:
        """How many switches a pattern has."""
        return int(self.unit_weights.shape[0])

    def excess(self, patterns: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Sum minus bias of every unit; it fires where that is positive."""
        return np.asarray(patterns.astype(np.float64) @ self.unit_weights - self.unit_bias)

    def true_terms(self, fired: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which terms hold, given which units fire."""
        if self._terms_are_units:
            return fired
        # A term holds where all wanted units fire and none of the unwanted ones.
        return np.asarray(fired.astype(np.float64) @ self.literals == self._wanted, dtype=np.bool_)

    def scores(self, patterns: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Score of every class, whole numbers."""
        true = self.true_terms(self.excess(patterns) > 0)
        return np.asarray(true.astype(np.float64) @ self.score_weights + self.score_bias)

    def evaluate(self, patterns: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Index of the winning class, the lowest among equals, shape (n_patterns,)."""
        out = np.empty(len(patterns), dtype=np.int64)
        for start in range(0, len(patterns), self._step):
            rows = slice(start, start + self._step)
            out[rows] = self.scores(patterns[rows]).argmax(axis=1)
        return out
