"""The interpreter of bit programs: 64 grasps a word, one compiled function for all netlists."""

from __future__ import annotations

import struct

import numpy as np
import numpy.typing as npt

from varishold.circuit.packed.program import Program
from varishold.kernel import address, bind, work_space

__all__ = ["KernelProgram", "pack_rows", "unpack_planes"]

# struct vh_program of varishold.h.
_PROGRAM = struct.Struct("@4i2P")
_run_program = bind("vh_run_program", "ppzzpp")
_run_and_unpack = bind("vh_run_and_unpack", "ppzzpp")
_run_program_work = bind("vh_run_program_work", "p", "z")
_pack_rows = bind("vh_pack_rows", "pzzpz", "i")
_unpack_planes = bind("vh_unpack_planes", "pizp")


class KernelProgram:
    """A program as the kernel takes it.

    Parameters
    ----------
    program : Program
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._code = np.array(program.code, np.int32, order="C")
        self._outputs = np.array(program.outputs, np.int32)
        pointers = (address(array) if array.size else 0 for array in (self._code, self._outputs))
        self._packed = _PROGRAM.pack(len(self._code), program.inputs, program.registers, len(self._outputs), *pointers)
        self._work: int = _run_program_work(self._packed)

    def __reduce__(self) -> tuple[type[KernelProgram], tuple[Program]]:
        # Elsewhere its arrays have other addresses.
        return KernelProgram, (self._program,)

    def run(self, words: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
        """Return the outputs over all words, shape (n_outputs, n_words), uint64.

        Parameters
        ----------
        words : ndarray of shape (n_inputs, n_words), uint64
            Writeable, its last axis contiguous.
        """
        planes = np.empty((len(self._outputs), words.shape[1]), np.uint64)
        if planes.size:
            at, stride = _rows(words)
            _run_program(self._packed, at, stride, words.shape[1], address(planes), work_space(self._work))
        return planes

    def run_and_unpack(self, words: npt.NDArray[np.uint64], n: int) -> npt.NDArray[np.uint8]:
        """Return the outputs, at least one and at most eight, of n >= 1 grasps, joined into one byte a grasp."""
        out = np.empty(n, np.uint8)
        at, stride = _rows(words)
        _run_and_unpack(self._packed, at, stride, n, address(out), work_space(self._work))
        return out


def _rows(words: npt.NDArray[np.uint64]) -> tuple[int | None, int]:
    """Return the address of rows of words and how far they are apart; each is one piece, all need not be."""
    return (address(words[0]), words.strides[0] // words.itemsize) if len(words) else (None, 0)


def pack_rows(rows: npt.NDArray[np.uint8], bytes_of_words: npt.NDArray[np.uint8]) -> bool:
    """Pack bytes 0 or 1 into words: bit g of word w of column c is ``rows[64 w + g, c]``.

    Parameters
    ----------
    rows : ndarray of shape (n >= 1, r >= 8), uint8, C order
    bytes_of_words : ndarray of shape (r, 8 * n_words), uint8, zeros
        Written; the words seen as bytes, lowest first.

    Returns
    -------
    bool
        Whether every byte was 0 or 1.
    """
    if not rows.flags.writeable:
        rows = rows.copy()
    n, r = rows.shape
    return bool(_pack_rows(address(rows), n, r, address(bytes_of_words[0]), bytes_of_words.strides[0]))


def unpack_planes(planes: npt.NDArray[np.uint64], out: npt.NDArray[np.uint8]) -> None:
    """Join bit planes into one small integer a grasp.

    Parameters
    ----------
    planes : ndarray of shape (n_planes, n_words), uint64, C order
        At least one plane and at most eight.
    out : ndarray of shape (n >= 1,), uint8
        Written.
    """
    _unpack_planes(address(planes), len(planes), len(out), address(out))
