"""From a signature to the probability of every kind: a small table of learned parameters.

The parameters are two layers of weights, learned from generated frames and shipped as plain arrays in
``parameters/*.npz``; `make parameters` rebuilds them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import open_archive
from varishold.files.compiling import njit
from varishold.touch.names import KINDS
from varishold.touch.signature import SIGNATURE_NAMES

__all__ = ["Parameters", "kind_logits", "load_parameters"]

# Training divides by no spread below a thousandth.
_DEAD_SCALE = 999.0
_FOLDER = Path(__file__).parent / "parameters"


@dataclass(frozen=True)
class Parameters:
    """A learned decision: whitening, three layers of weights, and what was seen of each kind.

    Parameters
    ----------
    shift, scale : ndarray of shape (n_inputs,), float64
        An input x enters as clip((x - shift) * scale, -clip, clip).
    clip : float
        Bound of a whitened input.
    weights : tuple of three ndarrays, float64
        Of shapes (n_inputs, h1), (h1, h2), (h2, n_kinds); between them max(x, 0).
    biases : tuple of three ndarrays, float64
    kind_means : ndarray of shape (n_kinds, n_inputs), float64
        Mean whitened input of each kind: what the reasons compare with.
    size_error : ndarray of shape (n_kinds, 2), float64
        Of each kind's size along its long and short side, the half-width in taxels within which 90 % of
        generated frames' true sizes lay.
    taxels_weight : float
        Weight of the log-odds by taxels alone beside this table's; 0 but for reliefs.
    """

    shift: NDArray[np.float64]
    scale: NDArray[np.float64]
    clip: float
    weights: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
    biases: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
    kind_means: NDArray[np.float64]
    size_error: NDArray[np.float64]
    taxels_weight: float = 0.0


@cache
def load_parameters(name: str = "surfaces") -> Parameters:
    """Load a shipped table of parameters by its name, once.

    Raises
    ------
    FormatError
        If the table is missing or belongs to another version of the signature.
    """
    path = _FOLDER / f"{name}.npz"
    if not path.is_file():
        raise FormatError(f"{path}: no such table of parameters; rebuild it with 'make parameters'")
    with open_archive(path) as table:
        read = {key: table.array(key) for key in table.names}
    names, kinds = read["inputs"].tolist(), read["kinds"].tolist()
    if tuple(kinds) != tuple(kind.key for kind in KINDS):
        raise FormatError(f"{path}: its kinds are not this version's; rebuild it with 'make parameters'")
    if tuple(names[: len(SIGNATURE_NAMES)]) != SIGNATURE_NAMES:
        raise FormatError(f"{path}: its inputs are not this version's; rebuild it with 'make parameters'")

    def array(key: str) -> NDArray[np.float64]:
        return np.ascontiguousarray(read[key], dtype=np.float64)

    scale = array("scale")
    # An input that never changed while the table was learned says nothing.
    scale[scale > _DEAD_SCALE] = 0.0
    return Parameters(
        shift=array("shift"),
        scale=scale,
        clip=float(read["clip"]),
        weights=(array("weight_1"), array("weight_2"), array("weight_3")),
        biases=(array("bias_1"), array("bias_2"), array("bias_3")),
        kind_means=array("kind_means"),
        size_error=array("size_error"),
        taxels_weight=float(read.get("taxels_weight", 0.0)),
    )


@njit(cache=True, nogil=True)
def _dense(x: NDArray[np.float64], weight: NDArray[np.float64], bias: NDArray[np.float64]) -> NDArray[np.float64]:
    out = bias.copy()
    for i in range(x.shape[0]):
        v = x[i]
        if v != 0.0:
            for j in range(out.shape[0]):
                out[j] += v * weight[i, j]
    return out


@njit(cache=True, nogil=True)
def _forward(
    x: NDArray[np.float64],
    w1: NDArray[np.float64],
    b1: NDArray[np.float64],
    w2: NDArray[np.float64],
    b2: NDArray[np.float64],
    w3: NDArray[np.float64],
    b3: NDArray[np.float64],
) -> NDArray[np.float64]:
    h = np.maximum(_dense(x, w1, b1), 0.0)
    h = np.maximum(_dense(h, w2, b2), 0.0)
    out: NDArray[np.float64] = _dense(h, w3, b3)
    return out


def kind_logits(whitened: NDArray[np.float64], parameters: Parameters) -> NDArray[np.float64]:
    """Return the log-odds (up to a constant) of every kind for one whitened input.

    Parameters
    ----------
    whitened : ndarray of shape (n_inputs,), float64
    parameters : Parameters

    Returns
    -------
    ndarray of shape (n_kinds,), float64
    """
    w, b = parameters.weights, parameters.biases
    logits: NDArray[np.float64] = _forward(whitened, w[0], b[0], w[1], b[1], w[2], b[2])
    return logits
