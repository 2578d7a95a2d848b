"""A small network of weights as the kernel takes it: the one evaluator of every table that touch has learned."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._cached import cached_property
from varishold.kernel import address, bind, work_space

__all__ = ["Decision", "KernelLayer", "KernelNetwork", "kernel_struct"]

_kind_logits = bind("vh_kind_logits", "pppp")
_kind_logits_work = bind("vh_kind_logits_work", "p", "z")
_evidence_work = bind("vh_evidence_work", "p", "z")


class KernelLayer(ctypes.Structure):
    """``struct vh_layer`` of ``varishold.h``."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("inputs", "outputs")),
        *((name, ctypes.c_void_p) for name in ("weight", "coarse", "scale", "bias")),
    ]


def kernel_struct(real: type[ctypes.c_float] | type[ctypes.c_double]) -> type[ctypes.Structure]:
    """Return ``struct vh_parameters`` of ``varishold.h``, whose ``vh_real`` is of that type."""
    ints = ("inputs", "kinds", "names", "n_layers", "n_means", "stranger", "plane", "bar", "square", "smooth")
    fields = [
        *((name, ctypes.c_int) for name in ints),
        ("clip", real),
        ("farthest", ctypes.c_float),
        *((name, ctypes.c_void_p) for name in ("shift", "scale", "layers")),
        ("whiten", KernelLayer),
        *((name, ctypes.c_void_p) for name in ("means", "name_of")),
    ]
    return type("KernelStruct", (ctypes.Structure,), {"_fields_": fields})


_Struct = kernel_struct(ctypes.c_double)


class KernelNetwork:
    """A network as the kernel takes it: a `struct vh_parameters`, and the arrays that it points at.

    Parameters
    ----------
    weights : sequence of ndarrays, float32
        Of shapes (n_inputs, h1), (h1, h2) ... (h, n_outputs).
    biases : sequence of ndarrays, float32
    shift, scale : ndarray of shape (n_inputs,), float64
    clip : float
    smooth : bool
        Whether hidden layers give tanh(x) rather than max(x, 0).
    whiten, means, farthest, name_of, n_names, stranger, plane, bar, square
        What a decision about names knows besides; without them there are outputs only.

    Attributes
    ----------
    at : int
        Where it stands.
    n_outputs : int
    work, evidence_work : int
        Bytes of work space that the kernel's `vh_kind_logits` and `vh_evidence` take.
    """

    def __init__(
        self,
        weights: Sequence[NDArray[np.float32]],
        biases: Sequence[NDArray[np.float32]],
        *,
        shift: NDArray[np.float64],
        scale: NDArray[np.float64],
        clip: float,
        smooth: bool = False,
        whiten: NDArray[np.float32] | None = None,
        means: NDArray[np.float32] | None = None,
        farthest: float = 0.0,
        name_of: NDArray[np.uint8] | None = None,
        n_names: int = 0,
        stranger: int = -1,
        plane: int = -1,
        bar: int = -1,
        square: int = -1,
    ) -> None:
        self._kept: list[NDArray[Any]] = []
        self.n_outputs = weights[-1].shape[1]
        self._layers = (KernelLayer * len(weights))(
            *(self._layer(weight, bias) for weight, bias in zip(weights, biases, strict=True))
        )
        self._struct = _Struct(
            len(shift),
            self.n_outputs,
            n_names,
            len(weights),
            0 if means is None else len(means),
            stranger,
            plane,
            bar,
            square,
            smooth,
            clip,
            farthest,
            self._pointer(shift),
            self._pointer(scale),
            ctypes.addressof(self._layers),
            KernelLayer() if whiten is None else self._layer(whiten),
            self._pointer(means),
            self._pointer(name_of),
        )
        self.at = ctypes.addressof(self._struct)
        self.work: int = _kind_logits_work(self.at)
        self.evidence_work: int = _evidence_work(self.at)

    def outputs(self, whitened: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what the last layer gives for whitened inputs of shape (n_inputs,), shape (n_outputs,)."""
        inputs, given = np.array(whitened, dtype=np.float64), np.empty(self.n_outputs)
        _kind_logits(self.at, address(inputs), address(given), work_space(self.work))
        return given

    def _pointer(self, array: NDArray[Any] | None) -> int | None:
        if array is None or not array.size:
            return None
        # One's own copy: in one piece, and nobody changes it.
        self._kept.append(np.array(array, order="C"))
        return address(self._kept[-1])

    def _layer(self, weight: NDArray[np.float32], bias: NDArray[np.float32] | None = None) -> KernelLayer:
        return KernelLayer(*weight.shape, self._pointer(weight), None, None, self._pointer(bias))


@dataclass(frozen=True, eq=False, kw_only=True)
class Decision:
    """A learned decision about names: whitening, layers of weights, and how far off all that is known.

    Parameters
    ----------
    names : tuple of str
    name_of : ndarray of shape (n_kinds,), uint8
        The name of each kind, by its place.
    stranger, plane, bar, square : int
        Which kind is none of those that were learned, and which is a plane, a rectangular and a square pillar; -1 where
        none is.
    shift, scale : ndarray of shape (n_inputs,), float64
        An input x enters as clip((x - shift) * scale, -clip, clip).
    clip : float
        Bound of a whitened input.
    weights : tuple of ndarrays, float32
        Of shapes (n_inputs, h1), (h1, h2) ... (h, n_kinds); between them max(x, 0).
    biases : tuple of ndarrays, float32
    whiten : ndarray of shape (h, r), float32
        Turns the last hidden layer, or the inputs of a single one, into numbers that scatter by 1 within a kind; empty
        where distance says nothing.
    means : ndarray of shape (n, r), float32
        Of every kind that has a name, so turned.
    farthest : float
        What lies farther than this from the nearest of them is the more a stranger.
    """

    names: tuple[str, ...]
    name_of: NDArray[np.uint8]
    stranger: int
    plane: int
    bar: int
    square: int
    shift: NDArray[np.float64]
    scale: NDArray[np.float64]
    clip: float
    weights: tuple[NDArray[np.float32], ...]
    biases: tuple[NDArray[np.float32], ...]
    whiten: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    means: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    farthest: float = 0.0

    def __getstate__(self) -> dict[str, Any]:
        # Elsewhere the kernel's arrays have other addresses.
        return {name: value for name, value in self.__dict__.items() if name != "kernel"}

    @cached_property
    def kernel(self) -> KernelNetwork:
        """This decision as the kernel takes it."""
        return KernelNetwork(
            self.weights,
            self.biases,
            shift=self.shift,
            scale=self.scale,
            clip=self.clip,
            whiten=self.whiten,
            means=self.means,
            farthest=self.farthest,
            name_of=self.name_of,
            n_names=len(self.names),
            stranger=self.stranger,
            plane=self.plane,
            bar=self.bar,
            square=self.square,
        )
