"""A network of gates as a straight-line program over registers, for the packed evaluator.

An instruction reads up to nine registers and writes up to three. Which of its operands are inverted is
part of its operation code, so that an inverter costs nothing; symmetric operands stand with the inverted
ones last, which leaves few codes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from varishold.circuit.gates import Gate, GateNetwork

__all__ = ["COLUMNS", "OPERATIONS", "Program", "compile_program"]

# Name and number of inverted operands of every operation code; the code is the position, in native/packed.c too.
# "and-nand" is c AND NOT (a AND b); its second number tells whether c is inverted.
OPERATIONS: Final = (
    *(("zero", 0), ("copy", 0), ("copy", 1)),
    *(("and", 0), ("and", 1), ("and", 2)),
    *(("and3", 0), ("and3", 1), ("and3", 2), ("and3", 3)),
    *(("and-nand", 0), ("and-nand", 1), ("and-nand", 2)),
    *(("not-and-nand", 0), ("not-and-nand", 1), ("not-and-nand", 2)),
    *(("xor", 0), ("xor3", 0), ("majority", 0), ("majority", 1), ("count3", 0), ("count3", 1)),
    *(("count7", 0), ("count7", 1), ("count7", 2), ("count7", 3)),
    *(("vote5", 0), ("vote5", 1), ("vote5", 2)),
    *(("vote7", 0), ("vote7", 1), ("vote7", 2), ("vote7", 3)),
    *(("vote9", 0), ("vote9", 1), ("vote9", 2), ("vote9", 3), ("vote9", 4)),
    *(("and5", 0), ("and5", 1), ("and5", 2), ("and5", 3), ("and5", 4), ("and5", 5)),
    *(("or5", 0), ("or5", 1), ("or5", 2), ("or5", 3), ("or5", 4), ("or5", 5)),
)
# Operation code, three destinations, nine sources.
COLUMNS: Final = 13

_WIDEST_PRODUCT: Final = 5
_CODES: Final = {operation: code for code, operation in enumerate(OPERATIONS)}


@dataclass(frozen=True, slots=True)
class Program:
    """Instructions over registers; the inputs are the first registers and are only read.

    Parameters
    ----------
    code : ndarray of shape (n_instructions, 13), int32
        Operation code, three destinations, nine sources; unused places are 0.
    inputs : int
        Number of input registers.
    registers : int
        Number of all registers.
    outputs : tuple of int
        Registers that hold the outputs at the end.
    """

    code: npt.NDArray[np.int32]
    inputs: int
    registers: int
    outputs: tuple[int, ...]


@dataclass(slots=True)
class _Step:
    operation: tuple[str, int]
    sources: tuple[int, ...]  # wires
    results: tuple[int, ...]  # wires


def compile_program(network: GateNetwork, outputs: list[int]) -> Program:
    """Return the program that computes `outputs` (literals) of a network.

    Registers are used again as soon as nothing reads them any more, the latest first, so that a block of
    each stays in the nearest cache.
    """
    gates, read = network.needed(outputs)
    results = [network.wires + k for k in range(len(outputs))]
    products = _Products(gates, outputs)
    # Backward, so that a product that another takes in is not computed for itself.
    steps = [
        products.joined(literal >> 1, (result,), inverted=bool(literal & 1))
        if products.is_taken(literal & ~1)
        else _Step(("copy", literal & 1), (literal >> 1,), (result,))
        for literal, result in zip(outputs, results, strict=True)
    ][::-1]
    for gate in reversed(gates):
        if gate.operation != "and":
            steps.append(_single(gate, read))
        elif gate.outputs[0] not in products.taken:
            steps.append(products.joined(gate.outputs[0], gate.outputs))
    steps.reverse()
    if any(0 in step.sources for step in steps):
        steps.insert(0, _Step(("zero", 0), (), (0,)))
    return _allocated(network.inputs, steps, results)


class _Products:
    """The products of two literals in a network, of which one that is read once is taken in by what reads it.

    Parameters
    ----------
    gates : list of Gate
    outputs : list of int
        Literals.

    Attributes
    ----------
    taken : set of int
        Wires of products that others have taken in.
    """

    def __init__(self, gates: list[Gate], outputs: list[int]) -> None:
        self.taken: set[int] = set()
        self._gates = {gate.outputs[0]: gate for gate in gates if gate.operation == "and"}
        self._uses = Counter(literal >> 1 for gate in gates for literal in gate.operands)
        self._uses.update(literal >> 1 for literal in outputs)

    def is_taken(self, literal: int) -> bool:
        """Take in the product that a literal is, if it is one that nothing else reads; tell whether it was."""
        wire = literal >> 1
        if wire not in self._gates or self._uses[wire] != 1:
            return False
        self.taken.add(wire)
        return True

    def joined(self, wire: int, results: tuple[int, ...], *, inverted: bool = False) -> _Step:
        """Return the step that computes a product, or its inverse, with as many of others as it has room for."""
        literals = [*self._gates[wire].operands]
        grown = True
        while grown:
            grown = False
            for literal in literals if len(literals) < _WIDEST_PRODUCT else ():
                if not literal & 1 and self.is_taken(literal):
                    literals.remove(literal)
                    literals += self._gates[literal >> 1].operands
                    grown = True
                    break
        if inverted:
            # Not a and b is not-a or not-b.
            return _wide("or", [literal ^ 1 for literal in literals], results)
        for literal in literals if len(literals) == 2 else ():
            if self.is_taken(literal):
                return _and_nand(literals[literals[0] == literal], self._gates[literal >> 1].operands, results)
        if len(literals) > 3:
            return _wide("and", literals, results)
        operands = _inverted_last(tuple(literals))
        name = "and" if len(literals) == 2 else "and3"
        return _Step((name, sum(a & 1 for a in operands)), tuple(a >> 1 for a in operands), results)


def _wide(name: str, literals: list[int], results: tuple[int, ...]) -> _Step:
    """Return a step of five literals; fewer are filled up with one of them, which changes nothing."""
    operands = _inverted_last((*literals, *[literals[0]] * (_WIDEST_PRODUCT - len(literals))))
    return _Step((f"{name}5", sum(a & 1 for a in operands)), tuple(a >> 1 for a in operands), results)


def _and_nand(other: int, product: tuple[int, ...], results: tuple[int, ...]) -> _Step:
    a, b = _inverted_last(product)
    name = "not-and-nand" if other & 1 else "and-nand"
    return _Step((name, (a & 1) + (b & 1)), (a >> 1, b >> 1, other >> 1), results)


def _single(gate: Gate, read: set[int]) -> _Step:
    operands = _inverted_last(gate.operands)
    name: str = gate.operation
    results = gate.outputs
    inverted = sum(a & 1 for a in operands)
    if gate.operation in ("count", "vote"):
        name = f"{gate.operation}{len(operands)}"
        if name == "count3" and results[1] not in read:
            return _sum_only(operands, results[0])
        if name == "count3" and results[0] not in read:
            name, results = "majority", results[1:]
    return _Step((name, inverted), tuple(a >> 1 for a in operands), results)


def _sum_only(operands: tuple[int, ...], result: int) -> _Step:
    inverted = sum(a & 1 for a in operands) & 1
    if inverted:
        # a XOR b XOR NOT c, by the full adder's code for one inverted operand, its carry unread
        return _Step(("count3", 1), tuple(a >> 1 for a in operands), (result, -1))
    return _Step(("xor3", 0), tuple(a >> 1 for a in operands), (result,))


def _inverted_last(operands: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(operands, key=lambda a: (a & 1, a)))


def _allocated(inputs: int, steps: list[_Step], results: list[int]) -> Program:
    last = {wire: k for k, step in enumerate(steps) for wire in step.sources}
    last.update((wire, len(steps)) for wire in results)
    register = {wire: wire - 1 for wire in range(1, inputs + 1)}
    free: list[int] = []
    count = inputs
    code = np.zeros((len(steps), COLUMNS), np.int32)
    for k, step in enumerate(steps):
        code[k, 0] = _CODES[step.operation]
        for j, wire in enumerate(step.sources):
            code[k, 4 + j] = register[wire]
        dying = {wire for wire in step.sources if not 0 < wire <= inputs and last[wire] == k}
        free.extend(sorted(register.pop(wire) for wire in dying))
        unread = []
        for j, wire in enumerate(step.results):
            if free:
                place = free.pop()
            else:
                place, count = count, count + 1
            code[k, 1 + j] = place
            if wire in last:
                register[wire] = place
            else:
                unread.append(place)
        free.extend(unread)
    return Program(code, inputs, count, tuple(register[wire] for wire in results))
