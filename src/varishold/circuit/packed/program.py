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
)
# Operation code, three destinations, nine sources.
COLUMNS: Final = 13

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
    steps = _steps(network, outputs)
    results = [network.wires + k for k in range(len(outputs))]
    for literal, result in zip(outputs, results, strict=True):
        steps.append(_Step(("copy", literal & 1), (literal >> 1,), (result,)))
    if any(0 in step.sources for step in steps):
        steps.insert(0, _Step(("zero", 0), (), (0,)))
    return _allocated(network.inputs, steps, results)


def _steps(network: GateNetwork, outputs: list[int]) -> list[_Step]:
    gates, read = network.needed(outputs)
    uses = Counter(literal >> 1 for gate in gates for literal in gate.operands)
    uses.update(literal >> 1 for literal in outputs)
    products = {gate.outputs[0]: gate for gate in gates if gate.operation == "and"}
    absorbed: set[int] = set()
    steps: list[_Step] = []
    for gate in reversed(gates):
        if gate.operation == "and" and gate.outputs[0] in absorbed:
            continue
        inner = _absorbable(gate, products, uses, absorbed) if gate.operation == "and" else None
        if inner is not None:
            absorbed.add(inner >> 1)
            steps.append(_fused(gate, inner, products[inner >> 1]))
        else:
            steps.append(_single(gate, read))
    return steps[::-1]


def _absorbable(gate: Gate, products: dict[int, Gate], uses: Counter[int], absorbed: set[int]) -> int | None:
    for literal in reversed(gate.operands):
        if literal >> 1 in products and uses[literal >> 1] == 1 and literal >> 1 not in absorbed:
            return literal
    return None


def _fused(gate: Gate, inner: int, product: Gate) -> _Step:
    (other,) = (literal for literal in gate.operands if literal != inner)
    if inner & 1:
        a, b = _inverted_last(product.operands)
        name = "not-and-nand" if other & 1 else "and-nand"
        return _Step((name, (a & 1) + (b & 1)), (a >> 1, b >> 1, other >> 1), gate.outputs)
    operands = _inverted_last((other, *product.operands))
    return _Step(("and3", sum(a & 1 for a in operands)), tuple(a >> 1 for a in operands), gate.outputs)


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
