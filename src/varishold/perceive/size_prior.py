"""Which sizes an example stands for: those near its own, the fewer examples there are the farther."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.likelihood import squared_distances
from varishold.perceive.touch_model import TouchModel

__all__ = ["ENOUGH_SIZES", "size_priors"]

Floats = NDArray[np.float64]

#: Where there are so many examples of known sizes, they say by themselves which sizes there are.
ENOUGH_SIZES = 40

# An example stands for sizes that near its own, in logarithm; where there are few, as near as one of these.
_NEAR = 0.08
_NEARS = _NEAR * 1.2 ** np.arange(13)

# Things of one name differ by so much in size, in logarithm, where their examples do not.
_USUAL = 0.3


def size_priors(log_sizes: Floats, log_size: Floats, kind: NDArray[np.int64], touches: Iterable[TouchModel]) -> Floats:
    off = log_sizes - log_size[:, None]
    near, few = np.full(len(log_size), _NEAR), []
    touches = list(touches)
    for k in np.unique(kind[np.isfinite(log_size)]):
        own = np.flatnonzero((kind == k) & np.isfinite(log_size))
        if len(own) < ENOUGH_SIZES:
            few.append(own)
            near[own] = _near(log_size[own], own, touches)
    prior = np.where(np.isfinite(off), np.exp(-0.5 * (off / near[:, None]) ** 2), 1.0)
    prior /= prior.sum(axis=1, keepdims=True)
    for own in few:
        mean = log_size[own].mean()
        wide = np.hypot(_USUAL, log_size[own].std())
        usual = np.exp(-0.5 * ((log_sizes - mean) / wide) ** 2)
        prior[own] += (usual / usual.sum() - prior[own]) / (len(own) + 1)
    return prior


def _near(log_size: Floats, rows: NDArray[np.int64], touches: list[TouchModel]) -> float:
    if len(rows) < 2:
        return _NEAR
    alike = np.zeros((len(rows), len(rows)))
    for model in touches:
        white = model.white[rows]
        told = model.own * model.kernel(squared_distances(white, white), white.shape[1])
        made = model.made[rows]
        alike += np.where(made & made[:, None], told, 0.0)
    np.fill_diagonal(alike, -np.inf)
    weight = np.exp(alike - alike.max(axis=1, keepdims=True))
    weight /= weight.sum(axis=1, keepdims=True)
    off = log_size[:, None] - log_size
    likely = [np.log((weight * np.exp(-0.5 * (off / near) ** 2)).sum(axis=1) / near + 1e-9).sum() for near in _NEARS]
    return float(_NEARS[int(np.argmax(likely))])
