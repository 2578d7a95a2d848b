"""Grasps as words: sixty-four grasps a word, one row of words a switch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from varishold.circuit.packed.kernel import pack_rows
from varishold.errors import InputError
from varishold.frame.checks import as_given

__all__ = ["WORD_BITS", "PackedGrasps", "aligned_words", "pack"]

WORD_BITS = 64
_VECTOR_WORDS = 8
# Rows packed at a time where they first have to be converted.
_CHUNK_ROWS = 1 << 16


@dataclass(frozen=True, slots=True)
class PackedGrasps:
    """Grasps as words of 64.

    Parameters
    ----------
    words : ndarray of shape (n_bits, ceil(n / 64)), uint64
        Bit g of ``words[k, w]`` is bit k of grasp ``64 w + g``.
    n : int
        Number of grasps.
    """

    words: npt.NDArray[np.uint64]
    n: int

    def __post_init__(self) -> None:
        words = self.words
        if words.ndim != 2 or words.dtype != np.uint64 or words.shape[1] != -(-self.n // WORD_BITS):
            raise InputError(
                f"words of {self.n} grasps must have shape (n_bits, {-(-self.n // WORD_BITS)}) and dtype "
                f"uint64, got {words.shape} and {words.dtype}"
            )


def pack(bits: npt.ArrayLike) -> PackedGrasps:
    """Pack rows of switches into words.

    Parameters
    ----------
    bits : array_like of shape (n, n_bits), bool or numbers 0 and 1
        Fastest as bool or uint8 in C order.

    Returns
    -------
    PackedGrasps

    Raises
    ------
    InputError
        Where a value is neither 0 nor 1.

    Examples
    --------
    >>> pack([[1, 0], [1, 1]]).words
    array([[3],
           [2]], dtype=uint64)
    """
    must = "switches must have shape (n_grasps, n_switches)"
    values = as_given(bits, must)
    if values.ndim != 2:
        raise InputError(f"{must}, got {values.shape}")
    n, r = values.shape
    words = aligned_words(r, -(-n // WORD_BITS))
    if n == 0 or r == 0:
        return PackedGrasps(words, n)
    as_bytes = words.view(np.uint8)
    if values.dtype.itemsize == 1 and values.dtype.kind in "bui" and r >= 8:
        if not pack_rows(np.ascontiguousarray(values).view(np.uint8), as_bytes):
            raise _not_binary(values)
        return PackedGrasps(words, n)
    for start in range(0, n, _CHUNK_ROWS):
        part = values[start : start + _CHUNK_ROWS]
        if part.dtype.kind not in "biuf" or not ((part == 0) | (part == 1)).all():
            raise _not_binary(values)
        rows = np.zeros((len(part), max(r, 8)), np.uint8)
        rows[:, :r] = part
        chunk = np.zeros((max(r, 8), -(-len(part) // 8)), np.uint8)
        pack_rows(rows, chunk)
        as_bytes[:, start // 8 : start // 8 + chunk.shape[1]] = chunk[:r]
    return PackedGrasps(words, n)


def aligned_words(rows: int, words: int) -> npt.NDArray[np.uint64]:
    """Return zeros of shape (rows, words) whose rows start on multiples of 64 bytes."""
    stride = -(-words // _VECTOR_WORDS) * _VECTOR_WORDS
    buffer = np.zeros(rows * stride + _VECTOR_WORDS, np.uint64)
    start = -(buffer.ctypes.data // 8) % _VECTOR_WORDS
    return buffer[start : start + rows * stride].reshape(rows, stride)[:, :words]


def _not_binary(values: npt.NDArray[np.generic]) -> InputError:
    if values.dtype.kind not in "biuf":
        return InputError(f"switches must be numbers 0 or 1, got dtype {values.dtype}")
    row, column = np.argwhere((values != 0) & (values != 1))[0]
    return InputError(f"switches must be 0 or 1, got {values[row, column]} at (row, column) = ({row}, {column})")
