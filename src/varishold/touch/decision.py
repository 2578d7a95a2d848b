"""From a signature to the probability of every kind: a small table of learned parameters.

The parameters are a few layers of weights, learned from generated frames and shipped as plain arrays in
``parameters/*.npz``; `make parameters` rebuilds them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import open_archive
from varishold.files.compiling import njit
from varishold.touch.names import KINDS
from varishold.touch.signature import SIGNATURE_NAMES

__all__ = ["SPREADING", "Parameters", "kind_logits", "load_parameters"]

# Training divides by no spread below a thousandth.
_DEAD_SCALE = 999.0
#: The inputs that tell how uncertain a size is.
SPREADING: tuple[str, ...] = (
    "noise",
    "log_size",
    "roughness",
    "mixed_roughness",
    "near_top_share",
    "edge_half",
    "cut_half",
    "free_level",
    "lean",
)
_STRANGER = [kind.key for kind in KINDS].index("stranger")
# Log-odds of a stranger for each unit of distance beyond the farthest that is known.
_PER_DISTANCE = 0.3
_SPREADING = np.array([SIGNATURE_NAMES.index(name) for name in SPREADING])
_FOLDER = Path(__file__).parent / "parameters"


@dataclass(frozen=True)
class Parameters:
    """A learned decision: whitening, layers of weights, and what was seen of each kind.

    Parameters
    ----------
    shift, scale : ndarray of shape (n_inputs,), float64
        An input x enters as clip((x - shift) * scale, -clip, clip).
    clip : float
        Bound of a whitened input.
    weights : tuple of ndarrays, float32
        Of shapes (n_inputs, h1), (h1, h2) ... (h, n_kinds); between them max(x, 0).
    biases : tuple of ndarrays, float32
    kind_means : ndarray of shape (n_kinds, n_inputs), float64
        Mean whitened input of each kind: what the reasons compare with.
    size_spread : ndarray of shape (n_kinds, 2, 1 + n), float64
        Of each kind's long and short side: the logarithm of the half-width in taxels within which 90 % of
        generated frames' true sizes lay, as a linear function of the inputs `SPREADING`.
    whiten : ndarray of shape (h, r), float32
        Turns the last hidden layer into numbers that scatter by 1 within a kind; empty where distance says nothing.
    means : ndarray of shape (n, r), float32
        Of every kind that has a name, so turned.
    farthest : float
        Distance from the nearest of them beyond which one in a thousand that has a name lies.
    taxels_weight : float
        Weight of the log-odds by taxels alone beside this table's; 0 but for reliefs.
    """

    shift: NDArray[np.float64]
    scale: NDArray[np.float64]
    clip: float
    weights: tuple[NDArray[np.float32], ...]
    biases: tuple[NDArray[np.float32], ...]
    kind_means: NDArray[np.float64]
    size_spread: NDArray[np.float64]
    whiten: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    means: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    farthest: float = 0.0
    taxels_weight: float = 0.0

    def size_error(self, kind: int, inputs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the half-widths in taxels, long side and short, that hold 90 % of true sizes at these inputs."""
        half: NDArray[np.float64] = np.exp(self.size_spread[kind] @ np.append(1.0, inputs[_SPREADING]))
        return half


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

    layers = range(1, 1 + sum(key.startswith("weight_") for key in read))
    scale = array("scale")
    # An input that never changed while the table was learned says nothing.
    scale[scale > _DEAD_SCALE] = 0.0
    return Parameters(
        shift=array("shift"),
        scale=scale,
        clip=float(read["clip"]),
        weights=tuple(np.ascontiguousarray(read[f"weight_{i}"], np.float32) for i in layers),
        biases=tuple(np.ascontiguousarray(read[f"bias_{i}"], np.float32) for i in layers),
        kind_means=array("kind_means"),
        size_spread=array("size_spread"),
        whiten=np.ascontiguousarray(read["whiten"], np.float32),
        means=np.ascontiguousarray(read["means"], np.float32),
        farthest=float(read["farthest"]),
        taxels_weight=float(read.get("taxels_weight", 0.0)),
    )


@njit(nogil=True)
def _forward(x, weights, biases):  # type: ignore[no-untyped-def]
    """Return the outputs of a network's last layer and of the one before; hidden layers are max(x, 0)."""
    h = x.astype(np.float32)
    hidden = h
    for layer in range(len(weights)):
        weight, out = weights[layer], biases[layer].copy()
        hidden = h
        for i in range(h.shape[0]):
            v = h[i]
            if v != 0.0:
                for j in range(out.shape[0]):
                    out[j] += v * weight[i, j]
        h = np.maximum(out, np.float32(0.0)) if layer + 1 < len(weights) else out
    return h, hidden


@njit(nogil=True)
def _distance(hidden, whiten, means):  # type: ignore[no-untyped-def]
    """Return how far a hidden layer lies from the nearest kind, in the kinds' own scatter."""
    y = np.zeros(whiten.shape[1], np.float32)
    for i in range(hidden.shape[0]):
        v = hidden[i]
        if v != 0.0:
            for j in range(y.shape[0]):
                y[j] += v * whiten[i, j]
    nearest = np.inf
    for k in range(means.shape[0]):
        total = 0.0
        for j in range(y.shape[0]):
            total += (y[j] - means[k, j]) ** 2
        nearest = min(nearest, total)
    return math.sqrt(nearest)


def kind_logits(whitened: NDArray[np.float64], parameters: Parameters) -> NDArray[np.float64]:
    """Return the log-odds (up to a constant) of every kind for one whitened input.

    What lies farther from all that is known than nearly anything known does is the more unknown for it.

    Parameters
    ----------
    whitened : ndarray of shape (n_inputs,), float64
    parameters : Parameters

    Returns
    -------
    ndarray of shape (n_kinds,), float64
    """
    out, hidden = _forward(whitened, parameters.weights, parameters.biases)
    logits: NDArray[np.float64] = out.astype(np.float64)
    if parameters.means.size:
        beyond = _distance(hidden, parameters.whiten, parameters.means) - parameters.farthest
        logits[_STRANGER] += _PER_DISTANCE * max(beyond, 0.0)
    return logits
