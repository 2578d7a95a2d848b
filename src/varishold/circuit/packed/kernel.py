"""The interpreter of bit programs: 64 grasps a word, 64 words a block, one compiled function for all netlists.

Every instruction works through a block of each of its registers with explicit vectors, so that the cost
of fetching it is spread over 4096 grasps, and a block of every register stays in the nearest cache.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,misc,operator,attr-defined"

from __future__ import annotations

from typing import Any, Final

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from varishold.circuit.packed.program import COLUMNS, OPERATIONS
from varishold.files.compiling import njit

__all__ = ["BLOCK_WORDS", "pack_rows", "run_and_unpack", "run_program", "unpack_planes"]

BLOCK_WORDS: Final = 64
_LANES: Final = 8
_INT64 = ir.IntType(64)
_VECTOR = ir.VectorType(_INT64, _LANES)
_BYTES = ir.VectorType(ir.IntType(8), 64)
_MASK = ir.VectorType(ir.IntType(1), 64)
_WORDS = types.Array(types.uint64, 2, "A")
_PLANES = types.Array(types.uint64, 2, "C")
_CODE = types.Array(types.int32, 2, "C")
_OUTPUTS = types.Array(types.int64, 1, "C")
_ONES = ir.Constant(_VECTOR, [2**64 - 1] * _LANES)


@intrinsic
def _execute(typing_context, table, code, row):
    """Execute one instruction: ``table`` holds the address of every register's block."""
    signature = types.void(table, code, row)

    def generate(context, builder, signature, arguments):
        table_type, code_type, _ = signature.args
        addresses = context.make_array(table_type)(context, builder, arguments[0]).data
        instructions = context.make_array(code_type)(context, builder, arguments[1]).data
        start = builder.mul(arguments[2], ir.Constant(_INT64, COLUMNS))
        fields = builder.gep(instructions, [start], inbounds=True)

        def block_of(column):
            field = builder.gep(fields, [ir.Constant(_INT64, column)], inbounds=True)
            register = builder.sext(builder.load(field), _INT64)
            address = builder.load(builder.gep(addresses, [register], inbounds=True))
            return builder.inttoptr(address, _VECTOR.as_pointer())

        done = builder.append_basic_block("done")
        switch = builder.switch(builder.load(fields), done)
        for code_number, (name, inverted) in enumerate(OPERATIONS):
            case = builder.append_basic_block(f"{name}.{inverted}")
            switch.add_case(ir.Constant(ir.IntType(32), code_number), case)
            builder.position_at_end(case)
            sources, results, combine = _MEANING[name]
            reads = [block_of(4 + k) for k in range(sources)]
            writes = [block_of(1 + k) for k in range(results)]
            for j in range(BLOCK_WORDS // _LANES):
                # every source of a vector is read before any result of it is written, so that a
                # register may be source and destination at once
                place = [ir.Constant(_INT64, j)]
                values = [builder.load(builder.gep(read, place), align=8) for read in reads]
                for write, value in zip(writes, combine(builder, values, inverted), strict=True):
                    builder.store(value, builder.gep(write, place), align=8)
            builder.branch(done)
        builder.position_at_end(done)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def _eight_bytes(typing_context, address):
    """Return the eight bytes at an address, which need not be aligned, as one integer."""

    def generate(context, builder, signature, arguments):
        return builder.load(builder.inttoptr(arguments[0], _INT64.as_pointer()), align=1)

    return types.uint64(types.uint64), generate


@intrinsic
def _spread_bits(typing_context, address, plane, stride, planes):
    """Write 64 bytes: byte j has bit j of the word at ``plane + k * stride`` as its bit k."""
    signature = types.void(types.uint64, types.uint64, types.uint64, types.int64)

    def generate(context, builder, signature, arguments):
        place = builder.inttoptr(arguments[0], _BYTES.as_pointer())
        zeros = ir.Constant(_BYTES, [0] * 64)
        done = builder.append_basic_block("done")
        switch = builder.switch(arguments[3], done)
        for planes in range(1, 9):
            case = builder.append_basic_block(f"planes.{planes}")
            switch.add_case(ir.Constant(_INT64, planes), case)
            builder.position_at_end(case)
            total, word = zeros, arguments[1]
            for k in range(planes):
                bits = builder.load(builder.inttoptr(word, _MASK.as_pointer()), align=8)
                total = builder.or_(total, builder.select(bits, ir.Constant(_BYTES, [1 << k] * 64), zeros))
                word = builder.add(word, arguments[2])
            builder.store(total, place, align=1)
            builder.branch(done)
        builder.position_at_end(done)
        return context.get_dummy_value()

    return signature, generate


def _inverted_last(b, v, inverted):
    kept = len(v) - inverted
    return [*v[:kept], *(b.xor(value, _ONES) for value in v[kept:])]


def _zero(b, v, inverted):
    return [ir.Constant(_VECTOR, [0] * _LANES)]


def _copy(b, v, inverted):
    return _inverted_last(b, v, inverted)


def _and(b, v, inverted):
    first, *rest = _inverted_last(b, v, inverted)
    for value in rest:
        first = b.and_(first, value)
    return [first]


def _and_nand(b, v, inverted):
    return [b.and_(v[2], b.xor(_and(b, v[:2], inverted)[0], _ONES))]


def _not_and_nand(b, v, inverted):
    # not c and not (a and b) is not (c or (a and b))
    return [b.xor(b.or_(v[2], _and(b, v[:2], inverted)[0]), _ONES)]


def _xor(b, v, inverted):
    first, *rest = v
    for value in rest:
        first = b.xor(first, value)
    return [first]


def _majority(b, v, inverted):
    x, y, z = _inverted_last(b, v, inverted)
    return [b.or_(b.and_(x, y), b.and_(z, b.or_(x, y)))]


def _count3(b, v, inverted):
    v = _inverted_last(b, v, inverted)
    return [*_xor(b, v, 0), *_majority(b, v, 0)]


def _count7(b, v, inverted):
    v = _inverted_last(b, v, inverted)
    sum_a, carry_a = _count3(b, v[0:3], 0)
    sum_b, carry_b = _count3(b, v[3:6], 0)
    low, carry_c = _count3(b, [sum_a, sum_b, v[6]], 0)
    return [low, *_count3(b, [carry_a, carry_b, carry_c], 0)]


def _vote5(b, v, inverted):
    v = _inverted_last(b, v, inverted)
    total, carry = _count3(b, v[:3], 0)
    # more than two of 2 carry + total + x + y: one of the three with the carry, all three without
    return _majority(b, [carry, *_any_and_all(b, [total, *v[3:]])], 0)


def _vote7(b, v, inverted):
    v = _inverted_last(b, v, inverted)
    sum_a, carry_a = _count3(b, v[:3], 0)
    sum_b, carry_b = _count3(b, v[3:6], 0)
    # more than three of the seven: two carries, or one with two of the sums and the seventh
    return _majority(b, [carry_a, carry_b, *_majority(b, [sum_a, sum_b, v[6]], 0)], 0)


def _vote9(b, v, inverted):
    v = _inverted_last(b, v, inverted)
    sums, carries = zip(*(_count3(b, v[k : k + 3], 0) for k in (0, 3, 6)), strict=True)
    total, carry = _count3(b, sums, 0)
    # more than four of 2 (carries) + 2 carry + total: three of four carries, or two with the total
    low, high = _count3(b, carries, 0)
    at_least_one, all_three = _any_and_all(b, [low, carry, total])
    return _majority(b, [high, at_least_one, all_three], 0)


def _any_and_all(b, v):
    return b.or_(b.or_(v[0], v[1]), v[2]), b.and_(b.and_(v[0], v[1]), v[2])


# By name: number of sources, number of results, and what computes the results from the sources.
_MEANING: Final[dict[str, tuple[int, int, Any]]] = {
    "zero": (0, 1, _zero),
    "copy": (1, 1, _copy),
    "and": (2, 1, _and),
    "and3": (3, 1, _and),
    "and-nand": (3, 1, _and_nand),
    "not-and-nand": (3, 1, _not_and_nand),
    "xor": (2, 1, _xor),
    "xor3": (3, 1, _xor),
    "majority": (3, 1, _majority),
    "count3": (3, 2, _count3),
    "count7": (7, 3, _count7),
    "vote5": (5, 1, _vote5),
    "vote7": (7, 1, _vote7),
    "vote9": (9, 1, _vote9),
}


# One signature for contiguous and padded words alike, compiled once.
@njit(types.void(_WORDS, _CODE, types.int64, _OUTPUTS, _PLANES), nogil=True, cache=True)
def run_program(words, code, registers, outputs, planes):
    """Run a program over all words, block by block.

    Parameters
    ----------
    words : ndarray of shape (n_inputs, n_words), uint64
        Its last axis must be contiguous.
    code : ndarray of shape (n_instructions, 13), int32
    registers : int
        Number of registers; the first are the inputs.
    outputs : ndarray of shape (n_outputs,), int64
        Registers to copy out.
    planes : ndarray of shape (n_outputs, n_words), uint64
        Written.
    """
    inputs, n_words = words.shape
    address, stride = words.ctypes.data, words.strides[0]
    # One vector more, so that the blocks can start where a vector of 64 bytes may be read at once.
    scratch = np.empty((registers - inputs) * BLOCK_WORDS + _LANES, np.uint64)
    base = (-scratch.ctypes.data // 8) % _LANES
    tail = np.empty((inputs, BLOCK_WORDS), np.uint64)
    table = np.empty(registers, np.int64)
    for k in range(registers - inputs):
        table[inputs + k] = scratch.ctypes.data + 8 * (base + k * BLOCK_WORDS)
    for start in range(0, n_words, BLOCK_WORDS):
        length = min(BLOCK_WORDS, n_words - start)
        for k in range(inputs):
            table[k] = address + k * stride + 8 * start
            if length < BLOCK_WORDS:
                for j in range(length):
                    tail[k, j] = _eight_bytes(np.uint64(table[k] + 8 * j))
                table[k] = tail.ctypes.data + 8 * BLOCK_WORDS * k
        for row in range(len(code)):
            _execute(table, code, row)
        for k in range(len(outputs)):
            place = base + (outputs[k] - inputs) * BLOCK_WORDS
            for j in range(length):
                planes[k, start + j] = scratch[place + j]


@njit(nogil=True, cache=True)
def pack_rows(rows, bytes_of_words):
    """Pack bytes 0 or 1 into words: bit g of word w of column c is ``rows[64 w + g, c]``.

    Parameters
    ----------
    rows : ndarray of shape (n, r >= 8), uint8, C order
    bytes_of_words : ndarray of shape (r, 8 * n_words), uint8, zeros
        Written; the words seen as bytes, lowest first.

    Returns
    -------
    bool
        Whether every byte was 0 or 1.
    """
    n, r = rows.shape
    address = rows.ctypes.data
    seen = np.uint64(0)
    for group in range((n + 7) // 8):
        height = min(8, n - 8 * group)
        for chunk in range((r + 7) // 8):
            # the last chunk overlaps the one before it and so never reads beyond the row
            first = min(8 * chunk, r - 8)
            place = np.uint64(address + 8 * group * r + first)
            gathered = np.uint64(0)
            if height == 8:
                for i in range(8):
                    row = _eight_bytes(place + np.uint64(i * r))
                    seen |= row
                    gathered |= row << np.uint64(i)
            else:
                for i in range(height):
                    row = _eight_bytes(place + np.uint64(i * r))
                    seen |= row
                    gathered |= row << np.uint64(i)
            # byte c of `gathered` now holds eight grasps of column first + c
            for c in range(8):
                bytes_of_words[first + c, group] = np.uint8(gathered >> np.uint64(8 * c))
    return seen & np.uint64(0xFEFEFEFEFEFEFEFE) == 0


@njit(types.void(_PLANES, types.uint8[::1]), nogil=True, cache=True)
def unpack_planes(planes, out):
    """Join bit planes into one small integer a grasp.

    Parameters
    ----------
    planes : ndarray of shape (n_planes >= 1, n_words), uint64
        At most eight.
    out : ndarray of shape (n,), uint8
        Written.
    """
    n = len(out)
    last = np.empty(64, np.uint8)
    for word in range((n + 63) // 64):
        whole = 64 * word + 64 <= n
        place = np.uint64(out.ctypes.data + 64 * word) if whole else np.uint64(last.ctypes.data)
        _spread_bits(place, np.uint64(planes.ctypes.data + 8 * word), np.uint64(8 * planes.shape[1]), len(planes))
        if not whole:
            for j in range(n - 64 * word):
                out[64 * word + j] = last[j]


@njit(types.void(_WORDS, _CODE, types.int64, _OUTPUTS, _PLANES, types.uint8[::1]), nogil=True, cache=True)
def run_and_unpack(words, code, registers, outputs, planes, out):
    """Run a program and join its planes, at least one and at most eight, into one byte a grasp."""
    run_program(words, code, registers, outputs, planes)
    unpack_planes(planes, out)
