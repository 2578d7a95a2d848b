"""From a signature to the probability of every kind: a small table of learned parameters.

The parameters are a few layers of weights, learned from generated frames and shipped as plain arrays in
``parameters/*.npz``; `make parameters` rebuilds them.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import open_archive
from varishold.touch.names import KINDS, NAMES
from varishold.touch.network import Decision
from varishold.touch.signature import SIGNATURE_NAMES

__all__ = [
    "NAME_OF",
    "PLANE",
    "STRANGER",
    "Parameters",
    "kind_logits",
    "load_parameters",
    "read_parameters",
]

# Training divides by no spread below a thousandth.
_DEAD_SCALE = 999.0
#: Places of two kinds in `KINDS`, and of each kind's name in `NAMES`.
STRANGER = [kind.key for kind in KINDS].index("stranger")
PLANE = [kind.name for kind in KINDS].index("plane")
_BAR, _SQUARE = ([kind.name for kind in KINDS].index(name) for name in ("rectangular pillar", "square pillar"))
NAME_OF = np.array([NAMES.index(kind.name) for kind in KINDS], dtype=np.uint8)
# What every table has, but for its layers.
_ENTRIES = frozenset(
    (
        *("inputs", "kinds", "shift", "scale", "clip", "kind_means", "size_spread", "map_spread"),
        *("whiten", "means", "farthest", "weight_1", "bias_1"),
    )
)
# Sizes are uncertain by at least and by at most so much, in taxels.
_LEAST_HALF, _MOST_HALF = 0.02, 64.0
_FOLDER = Path(__file__).parent / "parameters"


@dataclass(frozen=True, eq=False, kw_only=True)
class Parameters(Decision):
    """A learned decision about the surface of a contact, and what was seen of each kind.

    Parameters
    ----------
    kind_means : ndarray of shape (n_kinds, n_inputs), float64
        Mean whitened input of each kind: what the reasons compare with.
    size_spread : ndarray of shape (n_kinds, 2, 2, 1 + n_signature), float64
        Of each kind's long and short side, as linear functions of the inputs that are the signature's: the middle of
        the interval that held 90 % of generated frames' true sizes, from the measured size, and the logarithm of its
        half-width. Taxels.
    map_spread : ndarray of shape (n_kinds, 2, 2, 1 + n_signature), float64
        The same on height maps: no fault but noise, whole faces hardly worn.
    farthest : float
        Distance from the nearest kind beyond which one in a thousand that has a name lies.
    taxels_weight : float
        Weight of the log-odds by taxels alone beside this table's; 0 but for reliefs.
    """

    names: tuple[str, ...] = NAMES
    name_of: NDArray[np.uint8] = field(default_factory=lambda: NAME_OF)
    stranger: int = STRANGER
    plane: int = PLANE
    bar: int = _BAR
    square: int = _SQUARE
    kind_means: NDArray[np.float64]
    size_spread: NDArray[np.float64]
    map_spread: NDArray[np.float64]
    taxels_weight: float = 0.0

    def size_error(
        self, kind: int, inputs: NDArray[np.float64], height_map: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where true sizes lie, long side and short, beside the measured ones: the middle, and half of 90 %.

        Taxels.
        """
        spread = self.map_spread if height_map else self.size_spread
        told = spread[kind] @ np.append(1.0, inputs[: len(SIGNATURE_NAMES)])
        return told[:, 0], np.clip(np.exp(told[:, 1]), _LEAST_HALF, _MOST_HALF)


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
    return read_parameters(path)


def read_parameters(path: str | os.PathLike[str]) -> Parameters:
    """Read a table of parameters.

    Parameters
    ----------
    path : str or path-like
        An NPZ, as those in ``parameters/``.

    Raises
    ------
    FormatError
        If it is no such table, or belongs to another version of the signature.
    """
    with open_archive(path) as table:
        read = {key: table.array(key) for key in table.names}
    missing = _ENTRIES - set(read)
    if missing:
        raise FormatError(f"{path}: is no table of parameters: it has no {min(missing)}")
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
        map_spread=array("map_spread"),
        whiten=np.ascontiguousarray(read["whiten"], np.float32),
        means=np.ascontiguousarray(read["means"], np.float32),
        farthest=float(read["farthest"]),
        taxels_weight=float(read.get("taxels_weight", 0.0)),
    )


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
    return parameters.kernel.outputs(whitened)
