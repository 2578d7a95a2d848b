"""A network of gates over single bits: built once, then counted, or compiled to a program.

A wire carries a bit; a *literal* is a wire with or without inversion, written ``2 * wire + inverted``, so
that ``literal ^ 1`` is its complement and an inverter costs nothing, as in every library of two-input
gates where an input may be inverted. Equal gates are built once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

__all__ = ["FALSE", "TRUE", "Gate", "GateNetwork"]

FALSE: Final = 0
TRUE: Final = 1

Operation = Literal["and", "xor", "count", "vote"]


@dataclass(frozen=True, slots=True)
class Gate:
    """One gate.

    Parameters
    ----------
    operation : {"and", "xor", "count", "vote"}
        "count" writes the number of true operands (3 or 7 of them) in binary, lowest bit first;
        "vote" tells whether more than half of its operands (5, 7 or 9 of them) are true.
    operands : tuple of int
        Literals.
    outputs : tuple of int
        Wires.
    """

    operation: Operation
    operands: tuple[int, ...]
    outputs: tuple[int, ...]


class GateNetwork:
    """A network of gates that grows from its inputs; every method returns literals.

    Parameters
    ----------
    inputs : int
        Number of input bits; wire 0 is the constant false, wire k + 1 is input k.

    Examples
    --------
    >>> network = GateNetwork(3)
    >>> a, b, c = (network.input(k) for k in range(3))
    >>> total, carry = network.count((a, b, c))
    >>> network.two_input_gates([total, carry]), network.two_input_gates([carry])
    (5, 4)
    """

    def __init__(self, inputs: int) -> None:
        self.inputs = inputs
        self.gates: list[Gate] = []
        self.wires = inputs + 1
        self._known: dict[tuple[Operation, tuple[int, ...]], tuple[int, ...]] = {}

    def input(self, k: int) -> int:
        """Return the literal of input `k`."""
        return 2 * (k + 1)

    def both(self, a: int, b: int) -> int:
        """Return a AND b."""
        a, b = min(a, b), max(a, b)
        if a == FALSE or a ^ b == 1:
            return FALSE
        if a in (TRUE, b):
            return b
        return 2 * self._gate("and", (a, b), 1)[0]

    def either(self, a: int, b: int) -> int:
        """Return a OR b."""
        return self.both(a ^ 1, b ^ 1) ^ 1

    def differ(self, a: int, b: int) -> int:
        """Return a XOR b."""
        inverted = (a ^ b) & 1
        a, b = sorted((a & ~1, b & ~1))
        if a == FALSE:
            return b ^ inverted
        if a == b:
            return inverted
        return 2 * self._gate("xor", (a, b), 1)[0] ^ inverted

    def choose(self, where: int, a: int, b: int) -> int:
        """Return a where `where` holds, b elsewhere."""
        if a == b:
            return a
        return self.either(self.both(where, a), self.both(where ^ 1, b))

    def count(self, operands: Sequence[int]) -> tuple[int, ...]:
        """Return the number of true operands (2, 3 or 7 of them) in binary, lowest bit first."""
        if len(operands) == 7:
            return self._count7(operands)
        constants = [a for a in operands if a <= TRUE]
        free = [a for a in operands if a > TRUE]
        for k, a in enumerate(free):
            for j in range(k):
                if free[j] == a:  # a + a + x = 2 a + x
                    others = constants + [x for i, x in enumerate(free) if i not in (j, k)]
                    return (others[0] if others else FALSE), a
                if free[j] ^ a == 1:  # a + not a + x = 1 + x
                    others = constants + [x for i, x in enumerate(free) if i not in (j, k)]
                    rest = others[0] if others else FALSE
                    return rest ^ 1, rest
        ones = sum(constants)
        if len(free) == 3:
            return self._symmetric("count", free, 2)
        if len(free) == 2:
            a, b = free
            if ones:
                return self.differ(a, b) ^ 1, self.either(a, b)
            return self.differ(a, b), self.both(a, b)
        if len(free) == 1:
            return (free[0] ^ 1, free[0]) if ones == 1 else (free[0], TRUE if ones else FALSE)
        return (ones & 1, ones >> 1)

    def majority(self, a: int, b: int, c: int) -> int:
        """Return whether at least two of three hold."""
        return self.count((a, b, c))[1]

    def vote(self, operands: Sequence[int]) -> int:
        """Return whether more than half of the operands (5, 7 or 9 of them, constants allowed) hold."""
        return self._symmetric("vote", operands, 1)[0]

    def _count7(self, operands: Sequence[int]) -> tuple[int, ...]:
        if len({a >> 1 for a in operands}) == 7 and min(operands) > TRUE:
            return self._symmetric("count", operands, 3)
        sum_a, carry_a = self.count(operands[:3])
        sum_b, carry_b = self.count(operands[3:6])
        low, carry_c = self.count((sum_a, sum_b, operands[6]))
        return (low, *self.count((carry_a, carry_b, carry_c)))

    def _symmetric(self, operation: Operation, operands: Sequence[int], outputs: int) -> tuple[int, ...]:
        # Inverting every operand inverts every output (of 2^k - 1 bits counted, or of an odd vote), so at
        # most half of the operands need to be inverted; they stand last, in a fixed order.
        inverted = int(2 * sum(a & 1 for a in operands) > len(operands))
        key = tuple(sorted((a ^ inverted for a in operands), key=lambda a: (a & 1, a)))
        return tuple(2 * wire ^ inverted for wire in self._gate(operation, key, outputs))

    def _gate(self, operation: Operation, operands: tuple[int, ...], outputs: int) -> tuple[int, ...]:
        key = (operation, operands)
        known = self._known.get(key)
        if known is None:
            known = tuple(range(self.wires, self.wires + outputs))
            self.wires += outputs
            self._known[key] = known
            self.gates.append(Gate(operation, operands, known))
        return known

    def needed(self, outputs: Iterable[int]) -> tuple[list[Gate], set[int]]:
        """Return the gates that `outputs` (literals) depend on, in order, and the wires that are read."""
        wires = {literal >> 1 for literal in outputs}
        gates = []
        for gate in reversed(self.gates):
            if any(wire in wires for wire in gate.outputs):
                gates.append(gate)
                wires.update(literal >> 1 for literal in gate.operands)
        return gates[::-1], wires

    def two_input_gates(self, outputs: Iterable[int]) -> int:
        """Return the number of two-input gates behind `outputs` (literals), inverters free.

        AND and XOR count one. A full adder counts five, two where only its sum is read and four where
        only its carry is. Wider gates, which only programs use, have no such number.
        """
        gates, wires = self.needed(outputs)
        total = 0
        for gate in gates:
            if gate.operation != "count":
                total += 1
            else:
                total_read, carry_read = (wire in wires for wire in gate.outputs)
                total += 5 if total_read and carry_read else 4 if carry_read else 2
        return total
