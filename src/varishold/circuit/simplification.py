"""A netlist brought into canonical form: nothing unused, nothing twice, in a fixed order."""

from __future__ import annotations

import math
from collections.abc import Mapping

from varishold.circuit.elements import Hyperplane, Score, Term
from varishold.circuit.netlist import Netlist

__all__ = ["simplify"]

_Literals = tuple[tuple[int, int], ...]
_Key = tuple[tuple[tuple[int, int], ...], int]


def simplify(netlist: Netlist) -> Netlist:
    """Return an equivalent netlist in canonical form.

    Hyperplanes are divided by the greatest common divisor of their weights, equal and opposite ones are
    merged, constant ones and contradictory terms disappear, what no score reads is dropped, and units and
    terms are sorted; two netlists that differ only in such matters become the same bytes. Channels,
    comparators and classes stay as they are, so that the inputs and the answers keep their numbers.

    Parameters
    ----------
    netlist : Netlist

    Returns
    -------
    Netlist
        With the same class on every input.

    Examples
    --------
    >>> from varishold.circuit import Hyperplane, Netlist, Score, Term
    >>> netlist = Netlist(
    ...     channels=("palm", "tip"),
    ...     comparators=(),
    ...     units=(Hyperplane([(1, 1)], 0), Hyperplane([(0, 2)], 1)),
    ...     terms=(Term([(0, 1)]), Term([(1, 1)])),
    ...     scores=(Score([], 0), Score([(1, 1)], 0)),
    ...     classes=("no", "yes"),
    ... )
    >>> smaller = simplify(netlist)
    >>> smaller.units
    (Hyperplane(weights=((0, 1),), bias=0, pair=None),)
    >>> smaller.terms, smaller.scores[1]
    ((Term(literals=((0, 1),)),), Score(weights=((0, 1),), bias=0))
    """
    divided = [_divided(unit) for unit in netlist.units]
    kept, reduced = _merged_units(divided)

    biases = [score.bias for score in netlist.scores]
    columns: dict[_Literals, list[int]] = {}
    weights_of_term: list[dict[int, int]] = [{} for _ in netlist.terms]
    for k, score in enumerate(netlist.scores):
        for term, weight in score.weights:
            weights_of_term[term][k] = weight
    for product, weights in zip(netlist.terms, weights_of_term, strict=True):
        literals = _reduced_literals(product, reduced)
        if literals is None:
            continue
        if not literals:
            for k, weight in weights.items():
                biases[k] += weight
            continue
        column = columns.setdefault(literals, [0] * len(biases))
        for k, weight in weights.items():
            column[k] += weight
    # A term that adds the same to every class decides nothing.
    columns = {literals: column for literals, column in columns.items() if len(set(column)) > 1}

    used = sorted({unit for literals in columns for unit, _ in literals})
    used.sort(key=lambda unit: (kept[unit].weights, kept[unit].bias))
    rank = {unit: k for k, unit in enumerate(used)}
    terms = sorted((_renumbered(literals, rank), column) for literals, column in columns.items())
    return Netlist(
        channels=netlist.channels,
        comparators=netlist.comparators,
        units=tuple(kept[unit] for unit in used),
        terms=tuple(Term(literals) for literals, _ in terms),
        scores=tuple(
            Score([(t, column[k]) for t, (_, column) in enumerate(terms) if column[k]], bias)
            for k, bias in enumerate(biases)
        ),
        classes=netlist.classes,
    )


def _divided(unit: Hyperplane) -> Hyperplane:
    divisor = math.gcd(*(weight for _, weight in unit.weights))
    if divisor <= 1:
        return unit
    # sum > bias and sum a multiple of the divisor: floor(bias / divisor) keeps the strict inequality
    weights = [(bit, weight // divisor) for bit, weight in unit.weights]
    return Hyperplane(weights, unit.bias // divisor, unit.pair)


def _constant(unit: Hyperplane) -> bool | None:
    highest = sum(max(weight, 0) for _, weight in unit.weights)
    lowest = sum(min(weight, 0) for _, weight in unit.weights)
    if highest <= unit.bias:
        return False
    if lowest > unit.bias:
        return True
    return None


def _merged_units(units: list[Hyperplane]) -> tuple[list[Hyperplane], list[bool | tuple[int, int]]]:
    """Return the distinct units, and for every unit a constant or (its position among them, inverted)."""
    pairs: dict[_Key, tuple[int, int] | None] = {}
    for unit in units:
        known = pairs.setdefault(_key(unit), unit.pair)
        if unit.pair is not None and (known is None or unit.pair < known):
            pairs[_key(unit)] = unit.pair
    kept: list[Hyperplane] = []
    position: dict[_Key, int] = {}
    reduced: list[bool | tuple[int, int]] = []
    for unit in units:
        constant = _constant(unit)
        if constant is not None:
            reduced.append(constant)
            continue
        key, opposite = _key(unit), _opposite(unit)
        # Of two opposite units that are both there, the one whose first weight is positive stays.
        inverted = int(opposite in pairs and key < opposite)
        key = opposite if inverted else key
        if key not in position:
            position[key] = len(kept)
            kept.append(Hyperplane(*key, pairs[key]))
        reduced.append((position[key], inverted))
    return kept, reduced


def _key(unit: Hyperplane) -> _Key:
    return unit.weights, unit.bias


def _opposite(unit: Hyperplane) -> _Key:
    # not (sum > bias) is sum < bias + 1, that is -sum > -bias - 1
    return tuple((bit, -weight) for bit, weight in unit.weights), -unit.bias - 1


def _reduced_literals(term: Term, reduced: list[bool | tuple[int, int]]) -> _Literals | None:
    """Return the literals over the kept units, or None where they contradict each other."""
    wanted_of: dict[int, int] = {}
    for unit, wanted in term.literals:
        to = reduced[unit]
        if isinstance(to, bool):
            if to != bool(wanted):
                return None
            continue
        kept, inverted = to
        if wanted_of.setdefault(kept, wanted ^ inverted) != wanted ^ inverted:
            return None
    return tuple(sorted(wanted_of.items()))


def _renumbered(literals: _Literals, rank: Mapping[int, int]) -> _Literals:
    return tuple(sorted((rank[unit], wanted) for unit, wanted in literals))
