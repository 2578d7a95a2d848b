"""Inputs on which generated source is checked against the reference evaluator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from varishold.circuit.elements import INT32_MAX
from varishold.circuit.netlist import Netlist
from varishold.frame.checks import as_whole

__all__ = ["check_vectors"]


def check_vectors(netlist: Netlist, most: int, *, largest: int = INT32_MAX) -> npt.NDArray[np.int64]:
    """Return inputs that exercise a netlist: every switch pattern if there are at most `most`.

    Otherwise `most` seeded ones: half at random, half a few flips from one pattern, and for counts the
    neighbourhood of every threshold and both ends of the range.

    Parameters
    ----------
    netlist : Netlist
    most : int
    largest : int
        Counts stay within ``-largest - 1 .. largest``.

    Returns
    -------
    ndarray of shape (n, n_channels), int64
    """
    most = as_whole(most, "vectors")
    r = len(netlist.channels)
    rng = np.random.default_rng(0)
    if not netlist.comparators:
        if 2**r <= most:
            return (np.arange(2**r)[:, None] >> np.arange(r)) & 1
        random = rng.integers(0, 2, (most - most // 2, r))
        near = rng.integers(0, 2, r) ^ (rng.random((most // 2, r)) < 2 / r)
        return np.concatenate([random, near.astype(np.int64)])
    low, high = max(-largest - 1, -INT32_MAX), largest
    out = np.empty((most, r), np.int64)
    for channel in range(r):
        thresholds = [c.threshold for c in netlist.comparators if c.channel == channel]
        edges = [low, high, 0, *(t + d for t in thresholds for d in (-1, 0, 1))]
        wide = rng.integers(min(edges[2:]) - 8, max(edges[2:]) + 9, most)
        out[:, channel] = np.where(rng.random(most) < 0.5, rng.choice(edges, most), wide)
    return np.clip(out, low, high)
