"""A netlist as a network of gates: counters for the hyperplanes, AND for the terms, comparison of scores.

The construction is fixed, so that "so many two-input gates" has one meaning. A hyperplane is a sum of
bits, inverted where the weight is negative, compared with a constant:

1. A bit that decides alone (any one is enough, or no other matters without it) is split off as an OR or
   an AND; what remains is a proper vote.
2. The bits of equal weight stand in a column; full adders take three bits of a column and leave one and a
   carry to the next column, half adders take the last two.
3. The sum is compared with the constant from its lowest bit up, by one AND or OR a bit; or the distance
   of the constant from the next power of two is added in step 2, and the carries tell. The construction
   with fewer gates is taken.

Two classes are one more such vote, over the terms; more classes are sums, compared one after another by
one majority gate a bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from varishold._counted import counted
from varishold.circuit.gates import FALSE, TRUE, GateNetwork
from varishold.circuit.netlist import Netlist
from varishold.circuit.sharing import shared_adders
from varishold.circuit.simplification import simplify

__all__ = ["circuit_size", "exceeds", "gate_count", "synthesize"]

_Items = list[tuple[int, int]]
# Above this many bits a vote's two constructions differ by a few gates in hundreds.
_TRY_BOTH = 64
# Gates of a full adder, which adds one set bit of a weight; above so many bits gates are estimated from them.
_FULL_ADDER = 5
_COUNTED_BITS = 20_000
# Sizes of the votes that a program takes in one step.
_SMALLEST_VOTE, _LARGEST_VOTE = 5, 9


def gate_count(netlist: Netlist) -> int:
    """Return the number of two-input gates of the netlist by the module's construction.

    Inverters and comparators of counts (the encoder's) are not counted; a full adder is five gates.

    Parameters
    ----------
    netlist : Netlist

    Examples
    --------
    >>> from varishold.circuit import Hyperplane, Netlist, Score, Term
    >>> majority = Netlist(
    ...     channels=("a", "b", "c"),
    ...     comparators=(),
    ...     units=(Hyperplane([(0, 1), (1, 1), (2, 1)], 1),),
    ...     terms=(Term([(0, 1)]),),
    ...     scores=(Score([]), Score([(0, 1)])),
    ...     classes=("few", "many"),
    ... )
    >>> gate_count(majority)
    4
    """
    network, outputs = synthesize(netlist)
    return network.two_input_gates(outputs)


def circuit_size(netlist: Netlist) -> str:
    """How large a circuit is, in words: hyperplanes and two-input gates, counted or, of a large one, estimated."""
    bits = sum(
        abs(weight).bit_count() for layer in (netlist.units, netlist.scores) for x in layer for _, weight in x.weights
    )
    gates = f"{gate_count(netlist)}" if bits <= _COUNTED_BITS else f"about {float(f'{_FULL_ADDER * bits:.1e}'):.0f}"
    return f"{counted(len(netlist.units), 'hyperplane')}, {gates} two-input gate{'' if gates == '1' else 's'}"


def synthesize(netlist: Netlist, *, wide: bool = False) -> tuple[GateNetwork, list[int]]:
    """Return a network of gates and its output literals: the class index in binary, lowest bit first.

    Parameters
    ----------
    netlist : Netlist
    wide : bool
        Count seven bits at a time where possible: fewer, larger steps for a program; otherwise full
        adders only, and adders that several hyperplanes have in common are built once.
    """
    netlist = simplify(netlist)
    network = GateNetwork(netlist.bit_count)
    votes = [
        _positive([(network.input(bit), weight) for bit, weight in unit.weights], unit.bias) for unit in netlist.units
    ]
    if not wide:
        votes = shared_adders(network, votes)
    fired = [exceeds(network, items, bound, wide=wide) for items, bound in votes]
    true = []
    for term in netlist.terms:
        product = TRUE
        for unit, wanted in term.literals:
            product = network.both(product, fired[unit] if wanted else fired[unit] ^ 1)
        true.append(product)
    return network, _class_index(network, netlist, true, wide=wide)


def exceeds(network: GateNetwork, items: Iterable[tuple[int, int]], bound: int, *, wide: bool = False) -> int:
    """Return the literal of ``sum(weight of the true literals) > bound``.

    Parameters
    ----------
    network : GateNetwork
    items : iterable of (int, int)
        Pairs (literal, weight).
    bound : int
    wide : bool
        As in `synthesize`.
    """
    votes, bound = _positive(items, bound)
    # What is split off is kept as (literal, OR or AND) and put around the rest at the end.
    around: list[tuple[int, bool]] = []
    while True:
        divisor = math.gcd(*(weight for _, weight in votes))
        if divisor > 1:
            votes, bound = [(a, weight // divisor) for a, weight in votes], bound // divisor
        total = sum(weight for _, weight in votes)
        if bound < 0 or total <= bound:
            result = TRUE if bound < 0 else FALSE
            break
        heaviest = max(range(len(votes)), key=lambda k: votes[k][1])
        literal, weight = votes[heaviest]
        if weight > bound:
            around.append((literal, True))
        elif total - weight <= bound:
            around.append((literal, False))
            bound -= weight
        else:
            result = _compared(network, votes, bound, wide=wide)
            break
        votes = votes[:heaviest] + votes[heaviest + 1 :]
    for literal, enough in reversed(around):
        result = network.either(literal, result) if enough else network.both(literal, result)
    return result


def _positive(items: Iterable[tuple[int, int]], bound: int) -> tuple[_Items, int]:
    """Return the same vote with positive weights, one a wire: w x is |w| (1 - x) - |w| for w < 0."""
    weights: dict[int, int] = {}
    for literal, weight in items:
        if literal & 1:
            literal, bound, weight = literal ^ 1, bound - weight, -weight
        weights[literal] = weights.get(literal, 0) + weight
    votes = []
    for literal, weight in weights.items():
        if weight > 0:
            votes.append((literal, weight))
        elif weight < 0:
            votes.append((literal ^ 1, -weight))
            bound -= weight
    return votes, bound


def _compared(network: GateNetwork, votes: _Items, bound: int, *, wide: bool) -> int:
    if wide:
        return _by_vote(network, votes, bound)
    if len(votes) > _TRY_BOTH:
        return _by_comparison(network, votes, bound, wide=wide)
    # Tried on an empty network of their own, over as many inputs as there are votes.
    costs = []
    for construct in (_by_comparison, _by_carry):
        trial = GateNetwork(len(votes))
        alone = [(trial.input(k), weight) for k, (_, weight) in enumerate(votes)]
        costs.append(trial.two_input_gates([construct(trial, alone, bound, wide=False)]))
    construct = _by_carry if costs[1] < costs[0] else _by_comparison
    return construct(network, votes, bound, wide=False)


def _by_vote(network: GateNetwork, votes: _Items, bound: int) -> int:
    """Return the comparison as one majority vote where it is a small one, with constants to even it out."""
    ballots = [literal for literal, weight in votes for _ in range(min(weight, _LARGEST_VOTE))]
    size = len(ballots)
    voters = max(2 * bound + 1, 2 * (size - bound) - 1)
    if size > _LARGEST_VOTE or voters > _LARGEST_VOTE:
        return _by_carry(network, votes, bound, wide=True)
    voters = max(voters, _SMALLEST_VOTE)
    ones = voters // 2 - bound
    constants = [TRUE] * ones + [FALSE] * (voters - size - ones)
    if voters == _SMALLEST_VOTE and len(constants) > 1:
        return _by_carry(network, votes, bound, wide=True)
    return network.vote(ballots + constants)


def _by_comparison(network: GateNetwork, votes: _Items, bound: int, *, wide: bool) -> int:
    planes = _sum(network, votes, 0, wide=wide)
    result = FALSE
    for k, plane in enumerate(planes):
        result = network.both(plane, result) if bound >> k & 1 else network.either(plane, result)
    return result


def _by_carry(network: GateNetwork, votes: _Items, bound: int, *, wide: bool) -> int:
    width = bound.bit_length()
    planes = _sum(network, votes, (1 << width) - 1 - bound, wide=wide)
    result = FALSE
    for plane in planes[width:]:
        result = network.either(plane, result)
    return result


def _sum(network: GateNetwork, votes: _Items, constant: int, *, wide: bool) -> list[int]:
    """Return the bits of ``constant + sum(weight of the true literals)``, lowest first."""
    largest = constant + sum(weight for _, weight in votes)
    columns: list[list[int]] = [[] for _ in range(largest.bit_length())]
    for literal, weight in votes:
        for k in range(weight.bit_length()):
            if weight >> k & 1:
                columns[k].append(literal)
    for k in range(constant.bit_length()):
        if constant >> k & 1:
            columns[k].append(TRUE)
    planes = []
    for k, column in enumerate(columns):
        # constants last: a full adder is not spent on a constant while there are bits
        column.sort(key=lambda literal: literal <= TRUE)
        while len(column) > 1:
            size = 7 if wide and len(column) >= 7 else min(len(column), 3)
            total, *carries = network.count(column[:size])
            column = [total, *column[size:]] if total != FALSE else column[size:]
            for j, carry in enumerate(carries):
                # beyond the last column there is nothing: the largest sum fits
                if carry != FALSE and k + 1 + j < len(columns):
                    columns[k + 1 + j].append(carry)
        planes.append(column[0] if column else FALSE)
    return planes


def _class_index(network: GateNetwork, netlist: Netlist, true: Sequence[int], *, wide: bool) -> list[int]:
    classes = len(netlist.classes)
    scores = [dict(score.weights) for score in netlist.scores]
    biases = [score.bias for score in netlist.scores]
    if classes == 2:
        first, second = scores
        difference = [(true[t], second.get(t, 0) - first.get(t, 0)) for t in range(len(true))]
        return [exceeds(network, difference, biases[0] - biases[1], wide=wide)]
    # The same added to every class changes nothing: no weight and no bias need be negative.
    for t in range(len(true)):
        least = min(score.get(t, 0) for score in scores)
        for score in scores:
            score[t] = score.get(t, 0) - least
    sums = []
    for score, bias in zip(scores, biases, strict=True):
        votes, offset = _positive([(true[t], weight) for t, weight in score.items()], 0)
        # `_positive` moves inverted literals to the other side of the comparison, as -offset
        sums.append((votes, bias - offset))
    least = min(constant for _, constant in sums)
    best: list[int] = []
    index = [FALSE] * (classes - 1).bit_length()
    for k, (votes, constant) in enumerate(sums):
        planes = _sum(network, votes, constant - least, wide=wide)
        if k == 0:
            best = planes
            continue
        width = max(len(best), len(planes))
        best += [FALSE] * (width - len(best))
        planes += [FALSE] * (width - len(planes))
        larger = FALSE
        for a, b in zip(planes, best, strict=True):
            larger = network.majority(a, b ^ 1, larger)
        best = [network.choose(larger, a, b) for a, b in zip(planes, best, strict=True)]
        index = [
            network.either(larger, bit) if k >> j & 1 else network.both(larger ^ 1, bit) for j, bit in enumerate(index)
        ]
    return index
