"""Sixty-four grasps a word: a netlist evaluated by bitwise operations alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from varishold._counted import counted
from varishold.circuit.evaluation import bits_of
from varishold.circuit.netlist import Netlist
from varishold.circuit.packed.grasps import WORD_BITS, PackedGrasps, aligned_words, pack
from varishold.circuit.packed.kernel import KernelProgram, unpack_planes
from varishold.circuit.packed.program import Program, compile_program
from varishold.circuit.synthesis import synthesize
from varishold.errors import InputError, require_a
from varishold.frame.checks import as_given

__all__ = ["PackedEvaluator"]

# Rows packed at a time where they first have to be compared with thresholds.
_CHUNK_ROWS = 1 << 16


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
        self._kernel = KernelProgram(self.program)
        self._n_bits = netlist.bit_count

    def pack(self, X: npt.ArrayLike) -> PackedGrasps:
        """Pack grasps: switches, or counts, which are compared with the netlist's thresholds first.

        Parameters
        ----------
        X : array_like of shape (n_grasps, n_channels)
        """
        if not self.netlist.comparators:
            packed = pack(X)
            self._check(packed)
            return packed
        values = as_given(X, "X must have shape (n_grasps, n_channels)")
        if values.ndim != 2 or len(values) <= _CHUNK_ROWS:
            return pack(bits_of(self.netlist, values))
        words = aligned_words(self.netlist.bit_count, -(-len(values) // WORD_BITS))
        for start in range(0, len(values), _CHUNK_ROWS):
            part = pack(bits_of(self.netlist, values[start : start + _CHUNK_ROWS]))
            words[:, start // WORD_BITS : start // WORD_BITS + part.words.shape[1]] = part.words
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
        return self._kernel.run(self._readable(packed))

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
        self._check(packed)
        n_planes = len(self.program.outputs)
        if not packed.n or not n_planes:
            return np.zeros(packed.n, np.uint8)
        if n_planes <= 8:
            return self._kernel.run_and_unpack(self._readable(packed), packed.n)
        planes = self.class_planes(packed)
        parts = []
        for first in range(0, n_planes, 8):
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
        if not words.flags.writeable or words.strides[1] != words.itemsize:
            return words.copy()
        return words

    def _check(self, packed: PackedGrasps) -> None:
        require_a(PackedGrasps, packed, "grasps", "as pack(X) gives them")
        if len(packed.words) != self._n_bits:
            raise InputError(
                f"grasps must have {counted(self._n_bits, 'bit')} for this netlist, got {len(packed.words)}"
            )
