"""How many switches may read wrongly before the answer changes: proved, and searched where that is small."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from varishold.grasp.compiled import CompiledCircuit

__all__ = ["Certificate", "certify", "proved_flips", "unit_flips"]

#: Up to this many switches the search runs to the end, and the number is exact.
EXACT_SWITCHES = 22
#: Patterns tried beyond that many switches; the sizes tried in full are proved thereby.
_BUDGET = 200_000
_BATCH = 1 << 15


@dataclass(frozen=True)
class Certificate:
    """What flips an answer bears.

    Parameters
    ----------
    flips : int
        Whatever that many switches read wrongly, or fewer, the answer stays.
    exact : bool
        One more can change it: `counterexample` does.
    counterexample : tuple of int
        Switches (from zero) whose flipping together changes the answer; empty where none was found.
    other : int or None
        Index of the class that it changes to.
    """

    flips: int
    exact: bool
    counterexample: tuple[int, ...] = ()
    other: int | None = None


def certify(circuit: CompiledCircuit, pattern: NDArray[np.bool_]) -> Certificate:
    """Prove a number of flips from the circuit, then try larger numbers one by one."""
    proved = proved_flips(circuit, pattern)
    r = circuit.n_switches
    answer = int(circuit.evaluate(pattern[None]).item())
    tried = 0
    for size in range(proved + 1, r + 1):
        tried += math.comb(r, size)
        if r > EXACT_SWITCHES and tried > _BUDGET:
            return Certificate(size - 1, False)
        subsets = combinations(range(r), size)
        while batch := list(islice(subsets, _BATCH)):
            flipped = np.repeat(pattern[None], len(batch), axis=0)
            rows = np.repeat(np.arange(len(batch)), size)
            flipped[rows, np.array(batch).ravel()] ^= True
            answers = circuit.evaluate(flipped)
            changed = np.flatnonzero(answers != answer)
            if len(changed):
                first = int(changed[0])
                return Certificate(size - 1, True, tuple(batch[first]), int(answers[first]))
    return Certificate(r, True)


def unit_flips(circuit: CompiledCircuit, pattern: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Fewest flips that turn each unit over, shape (n_units,); infinite where none do.

    For a bisector of v_i and v_j these are ceil(df / 2) where df = d(v, v_j) - d(v, v_i) > 0, else
    floor(-df / 2) + 1.
    """
    excess = circuit.excess(pattern[None])[0]
    # What the sum changes by when a switch is flipped.
    change = circuit.unit_weights * np.where(pattern, -1.0, 1.0)[:, None]
    fires = excess > 0
    useful = np.where(fires, -change, change).clip(min=0)
    needed = np.where(fires, excess, 1 - excess)
    reached = np.cumsum(-np.sort(-useful, axis=0), axis=0) >= needed
    return np.where(reached.any(axis=0), reached.argmax(axis=0) + 1.0, np.inf)


def proved_flips(circuit: CompiledCircuit, pattern: NDArray[np.bool_]) -> int:
    """Lower bound on the flips that the answer bears, from the units' own bounds.

    After k flips only units that k flips can turn over may differ, hence only terms with such a literal
    (if true) or with all violated literals such (if false). The answer stands while the worst that these
    can do to the difference of two scores does not decide it. For an OR of terms this is: if true, the
    largest over the true terms of the least over their literals; if false, the least over the terms of
    the largest over their violated literals; less one.
    """
    flips = unit_flips(circuit, pattern)
    fired = circuit.excess(pattern[None])[0] > 0
    true = circuit.true_terms(fired[None])[0]
    scores = circuit.scores(pattern[None])[0]
    winner = int(scores.argmax())
    used = circuit.literals != 0
    violated = used & ((circuit.literals > 0) != fired[:, None])
    # Constant terms have no literals: true ones never fall.
    falls = np.where(used, flips[:, None], np.inf).min(axis=0, initial=np.inf)
    rises = np.where(violated, flips[:, None], 0.0).max(axis=0, initial=0.0)
    turns = np.where(true, falls, rises)
    r = circuit.n_switches
    bound = r
    for rival in range(len(scores)):
        if rival == winner:
            continue
        lead = circuit.score_weights[:, winner] - circuit.score_weights[:, rival]
        harm = np.where(true, lead, -lead).clip(min=0)
        # Of equal scores the first class wins; scores are whole numbers.
        margin = scores[winner] - scores[rival] + (rival > winner)
        order = np.argsort(turns, kind="stable")
        lost = np.flatnonzero(np.cumsum(harm[order]) >= margin)
        if len(lost) and np.isfinite(turns[order][lost[0]]):
            bound = min(bound, int(turns[order][lost[0]]) - 1)
    return bound
