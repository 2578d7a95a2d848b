"""The conformal p-value: how rare a score as strange as this one is among known things."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = ["conformal_p_value"]


def conformal_p_value(strangeness: ArrayLike, known: ArrayLike) -> NDArray[np.float64]:
    """Return how rare it is that something known is as strange.

    Parameters
    ----------
    strangeness : array_like of shape (n,)
        Of what is to be judged; larger is stranger.
    known : array_like of shape (n_known,)
        Of known things that were held out when the measure was learned.

    Returns
    -------
    ndarray of shape (n,), float64
        (1 + how many of `known` are at least as strange) / (1 + n_known). Of things exchangeable with the known ones it
        is at most e in a share of at most e, whatever the measure.

    Raises
    ------
    InputError
        If `known` is empty.

    References
    ----------
    V. Vovk, A. Gammerman and G. Shafer, "Algorithmic Learning in a Random World", 2005, chapter 2.

    Examples
    --------
    >>> conformal_p_value([0.5, 9.0], [1.0, 2.0, 3.0]).tolist()
    [1.0, 0.25]
    """
    held = np.sort(np.asarray(known, dtype=np.float64))
    if held.ndim != 1 or not held.size:
        raise InputError(f"known must be one number for each of at least one known thing, got shape {held.shape}")
    below = np.searchsorted(held, np.asarray(strangeness, dtype=np.float64), side="left")
    return np.asarray((1 + held.size - below) / (1 + held.size))
