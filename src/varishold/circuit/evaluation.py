"""The reference evaluator: what a netlist means, layer by layer, in numpy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from varishold.circuit.elements import INT32_MAX
from varishold.circuit.netlist import Netlist
from varishold.errors import InputError, require
from varishold.frame.checks import as_given

__all__ = ["bits_of", "class_scores", "evaluate", "fired_units", "true_terms"]

# Rows evaluated at a time, so that memory stays bounded whatever the number of grasps.
_CHUNK_ENTRIES = 4_000_000


def evaluate(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Return the class of every grasp.

    Parameters
    ----------
    netlist : Netlist
    X : array_like of shape (n_grasps, n_channels), integers
        Switches 0 or 1, or counts where the netlist has comparators.

    Returns
    -------
    ndarray of shape (n_grasps,), intp
        Indices into ``netlist.classes``.

    Raises
    ------
    InputError
        Where the shape or a value does not fit the netlist.

    Examples
    --------
    >>> from varishold.circuit import Hyperplane, Netlist, Score, Term
    >>> netlist = Netlist(
    ...     channels=("palm", "tip"),
    ...     comparators=(),
    ...     units=(Hyperplane([(0, 1)], 0), Hyperplane([(1, 1)], 0)),
    ...     terms=(Term([(0, 1), (1, 0)]),),
    ...     scores=(Score([], 1), Score([(0, 2)], 0)),
    ...     classes=("pillar", "cylinder"),
    ... )
    >>> evaluate(netlist, [[0, 0], [1, 0], [0, 1], [1, 1]])
    array([0, 1, 0, 0])
    """
    values = _as_rows(netlist, X)
    out = np.empty(len(values), np.intp)
    for rows in _chunks(netlist, len(values)):
        _check_values(netlist, values[rows], rows.start)
        # argmax returns the first of equal maxima, which is the rule of the netlist
        scores = _scores(netlist, _terms(netlist, _units(netlist, _bits(netlist, values[rows]))))
        out[rows] = scores.argmax(axis=1)
    return out


def bits_of(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return the bits that the units see, shape (n_grasps, n_bits): switches, or thermometer bits."""
    values = _as_rows(netlist, X)
    _check_values(netlist, values, 0)
    return _bits(netlist, values)


def fired_units(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which units fire, shape (n_grasps, n_units)."""
    return _units(netlist, bits_of(netlist, X))


def true_terms(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which product terms are true, shape (n_grasps, n_terms)."""
    return _terms(netlist, fired_units(netlist, X))


def class_scores(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Return the score of every class, shape (n_grasps, n_classes)."""
    return _scores(netlist, true_terms(netlist, X))


def _as_rows(netlist: Netlist, X: npt.ArrayLike) -> npt.NDArray[Any]:
    must = f"X must have shape (n_grasps, {len(netlist.channels)}), one column a channel"
    values = as_given(X, must)
    require(values.ndim == 2 and values.shape[1] == len(netlist.channels), f"{must}, got {values.shape}")
    if values.dtype.kind not in "biuf":
        raise InputError(f"X must hold integers, got dtype {values.dtype}")
    return values


def _check_values(netlist: Netlist, values: npt.NDArray[Any], start: int) -> None:
    """Refuse values that are no switches or no counts; `start` is the number of the first row."""
    if values.dtype.kind == "b":
        return
    switches = not netlist.comparators
    low, high = (0, 1) if switches else (-INT32_MAX, INT32_MAX)
    bad = ~((values >= low) & (values <= high))  # NaN fails both
    if values.dtype.kind == "f":
        bad |= values != np.trunc(values)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        allowed = "0 or 1" if switches else "integer counts within 32 signed bits"
        raise InputError(
            f"X must hold {allowed}, got {values[row, column]} at (row, column) = ({start + row}, {column})"
        )


def _chunks(netlist: Netlist, n: int) -> Iterator[slice]:
    widest = max(netlist.bit_count, len(netlist.units), len(netlist.terms), len(netlist.classes))
    step = max(1, _CHUNK_ENTRIES // widest)
    for start in range(0, n, step):
        yield slice(start, start + step)


def _bits(netlist: Netlist, values: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    if not netlist.comparators:
        return np.asarray(values != 0, np.bool_)
    channels = np.array([c.channel for c in netlist.comparators])
    thresholds = np.array([c.threshold for c in netlist.comparators])
    counts = values.astype(np.int64)
    return counts[:, channels] >= thresholds


def _units(netlist: Netlist, bits: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    # Doubles hold every sum exactly (a netlist bounds them to 31 bits) and multiply far faster than integers.
    weights = np.zeros((bits.shape[1], len(netlist.units)))
    for k, unit in enumerate(netlist.units):
        for bit, weight in unit.weights:
            weights[bit, k] = weight
    return bits.astype(np.float64) @ weights > [unit.bias for unit in netlist.units]


def _terms(netlist: Netlist, fired: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    out = np.ones((len(fired), len(netlist.terms)), np.bool_)
    for k, term in enumerate(netlist.terms):
        for unit, wanted in term.literals:
            out[:, k] &= fired[:, unit] == bool(wanted)
    return out


def _scores(netlist: Netlist, true: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    weights = np.zeros((true.shape[1], len(netlist.scores)))
    for k, score in enumerate(netlist.scores):
        for term, weight in score.weights:
            weights[term, k] = weight
    sums = true.astype(np.float64) @ weights
    biases = np.array([score.bias for score in netlist.scores], np.int64)
    return sums.astype(np.int64) + biases
