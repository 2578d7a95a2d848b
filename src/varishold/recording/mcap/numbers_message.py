"""Numbers as messages: `std_msgs/msg/Float32MultiArray` and its kin."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.mcap.cdr import LITTLE, cdr_order, cdr_text, filled, text_end

__all__ = ["NumbersLayout", "numbers_head", "numbers_layout", "numbers_message"]

# What the axes of signals are called.
_AXES = {1: ("signal",), 2: ("taxel", "axis"), 3: ("row", "column", "axis")}


def numbers_head(shape: tuple[int, ...]) -> bytes:
    """Return what stands before the numbers of a multi-array, the mark of its coding included.

    Numbers of eight bytes begin at a multiple of eight after that mark.
    """
    head = struct.pack("<I", len(shape))
    for axis, (label, size) in enumerate(zip(_AXES[len(shape)], shape, strict=True)):
        head = filled(head + cdr_text(label)) + struct.pack("<II", size, math.prod(shape[axis:]))
    return LITTLE + head + struct.pack("<II", 0, math.prod(shape))


def numbers_message(head: bytes, values: NDArray[Any]) -> bytes:
    """Return a multi-array of numbers in their own type, lowest byte first."""
    fill = bytes(-(len(head) - 4) % values.dtype.itemsize)
    return head + fill + values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


@dataclass(frozen=True)
class NumbersLayout:
    """Where the numbers of a multi-array are in its message.

    Parameters
    ----------
    shape : tuple of int
    dtype : dtype
        Of a number, with its byte order.
    head : bytes
        What stands before the numbers, which go on to the end.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    head: bytes

    def fits(self, message: bytes) -> bool:
        """Tell whether another message is laid out in the same way."""
        size = len(self.head) + math.prod(self.shape) * self.dtype.itemsize
        return len(message) == size and message.startswith(self.head)


def numbers_layout(message: bytes, dtype: np.dtype[Any]) -> NumbersLayout:
    """Return how a multi-array's message is laid out.

    Raises
    ------
    ValueError
        If it is no such message, or its sizes contradict each other.
    """
    order = cdr_order(message)
    sizes = []
    try:
        (n_dims,) = struct.unpack_from(f"{order}I", message, at := 4)
        at += 4
        for _ in range(n_dims):
            at = text_end(message, at, order)
            at += -at % 4 + 8
            sizes.append(struct.unpack_from(f"{order}I", message, at - 8)[0])
        offset, n = struct.unpack_from(f"{order}II", message, at)
    except struct.error:
        raise ValueError(f"its {len(message)} bytes end before its numbers begin") from None
    start = int(at) + 8
    start += -(start - 4) % dtype.itemsize if n else 0
    if offset or math.prod(sizes or [n]) != n or len(message) != start + n * dtype.itemsize:
        raise ValueError(
            f"its layout says {' x '.join(map(str, sizes)) or n} numbers from {offset} on, {n} are announced, "
            f"{len(message) - start} bytes are there"
        )
    return NumbersLayout(tuple(sizes) or (n,), dtype.newbyteorder(order), message[:start])
