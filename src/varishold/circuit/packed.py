"""Sixty-four grasps a word: a netlist evaluated by bitwise operations alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from varishold.circuit.evaluation import bits_of
from varishold.circuit.netlist import Netlist
from varishold.circuit.program import Program, compile_program
from varishold.circuit.synthesis import synthesize
from varishold.errors import InputError

__all__ = ["PackedEvaluator", "PackedGrasps", "pack"]

_WORD_BITS = 64
_VECTOR_WORDS = 8
# Rows packed at a time where they first have to be compared with thresholds or converted.
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
        if words.ndim != 2 or words.dtype != np.uint64 or words.shape[1] != -(-self.n // _WORD_BITS):
            raise InputError(
                f"words of {self.n} grasps must have shape (n_bits, {-(-self.n // _WORD_BITS)}) and dtype "
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
    from varishold.circuit.kernel import pack_rows

    values = np.asarray(bits)
    if values.ndim != 2:
        raise InputError(f"switches must have shape (n_grasps, n_switches), got {values.shape}")
    n, r = values.shape
    words = _aligned_words(r, -(-n // _WORD_BITS))
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


class PackedEvaluator:
    """A netlist compiled to bitwise operations on 64 grasps a word.

    Agrees with `varishold.circuit.evaluate` on every input.

    Parameters
    ----------
    netlist : Netlist

    Attributes
    ----------
    netlist : Netlist
    program : Program
        The instructions; the same interpreter runs every program.

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
    >>> PackedEvaluator(majority).evaluate([[0, 1, 0], [1, 1, 0]])
    array([0, 1])
    """

    netlist: Netlist
    program: Program

    def __init__(self, netlist: Netlist) -> None:
        self.netlist = netlist
        network, outputs = synthesize(netlist, wide=True)
        self.program = compile_program(network, outputs)
        self._outputs = np.array(self.program.outputs, np.int64)

    def pack(self, X: npt.ArrayLike) -> PackedGrasps:
        """Pack grasps: switches, or counts, which are compared with the netlist's thresholds first.

        Parameters
        ----------
        X : array_like of shape (n_grasps, n_channels)
        """
        values = np.asarray(X)
        if not self.netlist.comparators:
            packed = pack(values)
            self._check(packed)
            return packed
        if len(values) <= _CHUNK_ROWS:
            return pack(bits_of(self.netlist, values))
        words = _aligned_words(self.netlist.bit_count, -(-len(values) // _WORD_BITS))
        for start in range(0, len(values), _CHUNK_ROWS):
            part = pack(bits_of(self.netlist, values[start : start + _CHUNK_ROWS]))
            words[:, start // _WORD_BITS : start // _WORD_BITS + part.words.shape[1]] = part.words
        return PackedGrasps(words, len(values))

    def class_planes(self, packed: PackedGrasps) -> npt.NDArray[np.uint64]:
        """Return the class index in binary, one plane of words a bit, the lowest bit first.

        Parameters
        ----------
        packed : PackedGrasps

        Returns
        -------
        ndarray of shape (n_planes, ceil(n / 64)), uint64
            Bits beyond the last grasp are unspecified. A single class has no planes.
        """
        from varishold.circuit.kernel import run_program

        words = self._readable(packed)
        planes = np.empty((len(self._outputs), words.shape[1]), np.uint64)
        if planes.size:
            run_program(words, self.program.code, self.program.registers, self._outputs, planes)
        return planes

    def predict(self, packed: PackedGrasps) -> npt.NDArray[np.uint8] | npt.NDArray[np.intp]:
        """Return the class index of every packed grasp.

        Parameters
        ----------
        packed : PackedGrasps

        Returns
        -------
        ndarray of shape (n,)
            uint8 up to 256 classes, intp beyond.
        """
        from varishold.circuit.kernel import run_and_unpack, unpack_planes

        if 0 < len(self._outputs) <= 8:
            words = self._readable(packed)
            planes = np.empty((len(self._outputs), words.shape[1]), np.uint64)
            out = np.empty(packed.n, np.uint8)
            run_and_unpack(words, self.program.code, self.program.registers, self._outputs, planes, out)
            return out
        planes = self.class_planes(packed)
        if not len(planes):
            return np.zeros(packed.n, np.uint8)
        parts = []
        for first in range(0, len(planes), 8):
            part = np.empty(packed.n, np.uint8)
            unpack_planes(planes[first : first + 8], part)
            parts.append(part)
        joined = np.zeros(packed.n, np.intp)
        for k, part in enumerate(parts):
            joined |= part.astype(np.intp) << 8 * k
        return joined

    def evaluate(self, X: npt.ArrayLike) -> npt.NDArray[np.intp]:
        """Return the class index of every grasp, as `varishold.circuit.evaluate` does.

        Parameters
        ----------
        X : array_like of shape (n_grasps, n_channels)
        """
        return self.predict(self.pack(X)).astype(np.intp)

    def _readable(self, packed: PackedGrasps) -> npt.NDArray[np.uint64]:
        """Return the words as the compiled code takes them: rows of neighbouring words, writeable."""
        self._check(packed)
        words = packed.words
        if not words.flags.writeable or (words.size and words.strides[1] != words.itemsize):
            return words.copy()
        return words

    def _check(self, packed: PackedGrasps) -> None:
        if len(packed.words) != self.netlist.bit_count:
            raise InputError(
                f"grasps must have {self.netlist.bit_count} bits for this netlist, got {len(packed.words)}"
            )


def _aligned_words(rows: int, words: int) -> npt.NDArray[np.uint64]:
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
