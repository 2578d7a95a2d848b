"""Where readings end although the sensor could show more: an amplifier, or a taxel's material, gives no more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.files import let_go
from varishold.frame.spread import spread_over

__all__ = ["reading_end"]

# Taxels without which nothing is told, presses and frames of each that are looked at, and presses that must agree.
_FEWEST_TAXELS, _MOST_PRESSES, _MOST_FRAMES, _FEWEST_PRESSES = 16, 32, 64, 2
# The top of a press: this highest taxel, so that one alone makes none.
_TOP = 3
# It stays where it is to within so many sigma, or this share of it.
_STAYS_SIGMAS, _STAYS = 3.0, 0.01
# Meanwhile the load grows by this share, and by so many taxels at the top. A form whose top grows by a hundredth
# loads by at most a twentieth more: a tip on a thick skin.
_GROWS, _MORE_TAXELS, _FEWEST_AT_TOP = 0.1, 3, 6


def reading_end(
    frames: NDArray[Any],
    usable: NDArray[np.bool_],
    rest: NDArray[np.float64] | None,
    presses: Sequence[range],
    sigma: float,
) -> float | None:
    """Return the height above the rest beyond which no taxel reads, found by how presses grow; None where none is seen.

    While a press grows, its top grows. Where the top stays and the rest of the press goes on growing, and more taxels
    reach that same top, readings end there. Two presses at least must agree on it.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        May be mapped; some are read.
    usable : ndarray of shape (rows, cols), bool
    rest : ndarray of shape (rows, cols), float64, or None
    presses : sequence of range
        Frames of each press.
    sigma : float
        Standard deviation of the noise.

    Returns
    -------
    float or None
        In the unit of the frames; what noise leaves below the end lies above it.
    """
    if np.count_nonzero(usable) < _FEWEST_TAXELS or len(presses) < _FEWEST_PRESSES:
        return None
    below = np.zeros(np.count_nonzero(usable)) if rest is None else rest[usable]
    ends = []
    for k in spread_over(len(presses), _MOST_PRESSES):
        run = presses[int(k)]
        some = np.unique(np.linspace(run.start, run.stop - 1, _MOST_FRAMES).astype(np.intp))
        ends.append(_end_of(np.array([frames[i][usable] - below for i in some.tolist()], dtype=np.float64), sigma))
        let_go(frames)
    found = np.array([end for end in ends if end is not None])
    if found.size < _FEWEST_PRESSES:
        return None
    end = float(np.median(found))
    reach = max(_STAYS_SIGMAS * sigma, _STAYS * end)
    agree = np.count_nonzero(np.abs(found - end) <= reach)
    return end - reach if agree >= max(_FEWEST_PRESSES, found.size / 2) else None


def _end_of(press: NDArray[np.float64], sigma: float) -> float | None:
    """Return the top of a press, of shape (n_frames, n_taxels), that stays while the press grows; None of others."""
    tops = np.partition(press, -_TOP, axis=1)[:, -_TOP]
    highest = float(tops.max())
    reach = max(_STAYS_SIGMAS * sigma, _STAYS * highest)
    at_top = np.flatnonzero(tops >= highest - reach)
    if highest <= 2 * reach:
        return None
    load = np.maximum(press[at_top], 0.0).sum(axis=1)
    many = np.count_nonzero(press[at_top] >= highest - 2 * reach, axis=1)
    first, last = 0, int(np.argmax(load))
    grew = load[last] >= (1 + _GROWS) * load[first] and many[last] >= max(many[first] + _MORE_TAXELS, _FEWEST_AT_TOP)
    return float(np.median(tops[at_top])) if grew else None
