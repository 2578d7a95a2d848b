"""Full adders that several hyperplanes have in common."""

from __future__ import annotations

import itertools
import math
from collections import Counter

from varishold.circuit.gates import GateNetwork

__all__ = ["shared_adders"]

_Vote = tuple[list[tuple[int, int]], int]
# Triples looked at before sharing is given up as too slow; sets of this size gain little from it.
_MOST_TRIPLES = 60_000


def shared_adders(network: GateNetwork, votes: list[_Vote]) -> list[_Vote]:
    """Replace three bits of equal weight, where several votes count them, by the sum and carry of one adder.

    Greedy: the triple that most votes have in common first, the lowest literals among equals, until no
    triple is common to two votes.

    Parameters
    ----------
    network : GateNetwork
        Receives the adders.
    votes : list of (list of (int, int), int)
        For every vote its pairs (literal, positive weight), each of another wire, none constant; and its bound.

    Returns
    -------
    list of (list of (int, int), int)
        Equivalent votes.
    """
    columns = [_split(items) for items, _ in votes]
    while True:
        seen: Counter[tuple[int, int, int]] = Counter()
        triples = sum(math.comb(len(column), 3) for vote in columns for column in vote.values())
        if triples > _MOST_TRIPLES:
            break
        for vote in columns:
            mine = {
                _unsigned(triple) for column in vote.values() for triple in itertools.combinations(sorted(column), 3)
            }
            seen.update(mine)
        best = max(seen, key=lambda triple: (seen[triple], [-a for a in triple]), default=None)
        if best is None or seen[best] < 2:
            break
        total, carry = network.count(best)
        for vote in columns:
            for weight in sorted(vote):
                _replace(vote, weight, best, total, carry)
    return [
        ([(literal, weight) for weight in sorted(vote) for literal in vote[weight]], bound)
        for vote, (_, bound) in zip(columns, votes, strict=True)
    ]


def _split(items: list[tuple[int, int]]) -> dict[int, list[int]]:
    """Return the literals by power of two of their weights."""
    columns: dict[int, list[int]] = {}
    for literal, weight in items:
        for k in range(weight.bit_length()):
            if weight >> k & 1:
                columns.setdefault(1 << k, []).append(literal)
    return columns


def _unsigned(triple: tuple[int, ...]) -> tuple[int, int, int]:
    # Three literals and their three complements are one adder: its outputs are complements, too.
    if sum(literal & 1 for literal in triple) > 1:
        triple = tuple(sorted(literal ^ 1 for literal in triple))
    a, b, c = triple
    return a, b, c


def _replace(vote: dict[int, list[int]], weight: int, triple: tuple[int, int, int], total: int, carry: int) -> None:
    """Replace the triple in one column of one vote, in place."""
    column = vote[weight]
    for inverted in (0, 1):
        literals = [literal ^ inverted for literal in triple]
        if all(literal in column for literal in literals):
            for literal in literals:
                column.remove(literal)
            column.append(total ^ inverted)
            vote.setdefault(2 * weight, []).append(carry ^ inverted)
            return
