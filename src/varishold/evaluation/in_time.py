"""Which presses are neighbours in time: those of one recording, and of recordings that follow one another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.touch.course.presses import Press

__all__ = ["in_order_of_time"]

# A recording that begins within so many seconds of another's end was made in the same go.
_SOON_S = 600.0


def in_order_of_time(presses: Sequence[Press], runs: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[Any]]:
    """Return the order of presses in time, and in which go each was made, shape (n_presses,) each.

    Recordings are of one clock, such as that of the day, where all have times and no two overlap; clocks that begin
    with each recording do. Without one clock presses stay in their order, and what was made in one go is a recording.

    Parameters
    ----------
    presses : sequence of Press
    runs : ndarray of shape (n_presses,)
        The recording of each; within one, presses stand in the order of time.
    """
    as_given = np.arange(len(presses)), runs
    times = [press.time_s for press in presses if press.time_s is not None]
    if not times or len(times) < len(presses):
        return as_given
    names, of = np.unique(runs, return_inverse=True)
    first, last = (np.array([float(time_s[k]) for time_s in times]) for k in (0, -1))
    begins = np.array([first[of == k].min() for k in range(len(names))])
    ends = np.array([last[of == k].max() for k in range(len(names))])
    order = np.argsort(begins, kind="stable")
    pauses = begins[order[1:]] - ends[order[:-1]]
    if (pauses <= 0).any():
        return as_given
    go = np.empty(len(names), np.intp)
    go[order] = np.concatenate([[0], np.cumsum(pauses > _SOON_S)])
    return np.argsort(first, kind="stable"), go[of]
