"""Presses that are too light, or too small, for the total of a pad to show them: some taxels do."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import blocks_of, pieces_at
from varishold.frame.noise import MEDIAN_ABS_NORMAL, ROUNDING
from varishold.frame.runs import runs_of
from varishold.frame.spread import spread_over
from varishold.recording.framed import Framed

__all__ = ["light_presses"]

# Frames in which nothing seems to press, that there must be and that are looked at, of a large pad as few as hold so
# many readings, but some; and taxels of a pad.
_FEWEST_FRAMES, _LOOKED_AT, _READINGS, _LEAST_LOOKED_AT, _FEWEST_TAXELS = 24, 256, 1 << 21, 16, 16
# A taxel's rest is above this share of what it reads in them, by so many sigma of its noise.
_RESTING, _ABOVE = 0.3, 0.524
# Its noise is no less than this share of what is read at most.
_LEAST = 0.002
# What a taxel reads above its rest counts from so many sigma on, and no more than so many: single ones tell nothing.
_FROM, _MOST = 3.0, 4.0
# What all taxels show so is as in the quietest frames, but for so many of them, and so many times how far it scatters
# there; a press shows so much more, for so many frames, and twice that in one.
_QUIET, _LEAST_SHOWN, _SCATTERS, _FEWEST, _CERTAIN = 0.1, 16.0, 8.0, 3, 2.0
# Between the quietest frames and those that are not much louder lies this share of half of what holds half of a normal
# noise.
_STILL_QUIET, _IN_SCATTERS = 0.3, 0.89
# Of normal noise a taxel shows so little, on average and in its square.
_SHOWN_BY_NOISE, _SQUARE_BY_NOISE = 3.8e-4, 2.5e-4


def light_presses(recording: Framed, found: list[range]) -> list[range]:
    """Return the presses that some taxels show in frames in which the totals show none.

    Parameters
    ----------
    recording : Recording
    found : list of range
        The presses that the totals show, in time.

    Returns
    -------
    list of range
        In time; none of them touches one that was found.

    Examples
    --------
    >>> from varishold.recording import Pad, Recording
    >>> frames = np.random.default_rng(0).normal(0, 1, (60, 64, 64))
    >>> frames[30:40, 5:9, 5:9] += 10.0
    >>> light_presses(Recording({"pad": Pad(frames)}), [])
    [range(30, 40)]
    """
    free = np.ones(recording.n_frames, np.bool_)
    for press in found:
        free[max(press.start - 1, 0) : press.stop + 1] = False
    numbers = np.flatnonzero(free)
    if numbers.size < _FEWEST_FRAMES:
        return []
    shown, n_taxels = np.zeros(recording.n_frames), 0
    for pad in recording.pads.values():
        works = pad.usable & ~pad.broken
        if np.count_nonzero(works) >= _FEWEST_TAXELS:
            shown += _shown(pad.frames, works, numbers)
            n_taxels += int(np.count_nonzero(works))
    # Presses may be in most of these frames.
    quiet, above = np.quantile(shown[free], [_QUIET, _STILL_QUIET])
    scatter = max(math.sqrt(_SQUARE_BY_NOISE * n_taxels), _IN_SCATTERS * float(above - quiet))
    level, more = max(quiet, _SHOWN_BY_NOISE * n_taxels), max(_LEAST_SHOWN, _SCATTERS * scatter)
    certain = level + _CERTAIN * more
    return [run for run in _runs(np.where(free, shown, math.inf), level + more) if _comes_and_goes(shown, run, certain)]


def _shown(frames: NDArray[Any], works: NDArray[np.bool_], quiet: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return how much a pad's taxels show above their noise in each frame, in sigma."""
    many = min(_LOOKED_AT, max(_LEAST_LOOKED_AT, _READINGS // int(np.count_nonzero(works))))
    some = quiet[spread_over(quiet.size - 1, many)]
    pairs = np.array(
        [pair[:, works] for pair in pieces_at(frames, some[some + 1 < len(frames)].tolist(), 2)], np.float64
    )
    sigma = np.median(np.abs(pairs[:, 1] - pairs[:, 0]), axis=0) / (MEDIAN_ABS_NORMAL * math.sqrt(2.0))
    usual = max(float(np.median(sigma)), _LEAST * float(np.ptp(pairs)))
    sigma = np.maximum(sigma, max(usual, ROUNDING) if frames.dtype.kind in "iu" else usual)
    rest = np.quantile(pairs[:, 0], _RESTING, axis=0) + _ABOVE * sigma
    if not (sigma > 0.0).all():
        return np.zeros(len(frames))
    shown = np.empty(len(frames))
    for at, block in blocks_of(frames):
        above = (block[:, works] - (rest + _FROM * sigma)) / sigma
        shown[at : at + len(block)] = np.clip(above, 0.0, _MOST).sum(axis=1)
    return shown


def _runs(shown: NDArray[np.float64], least: float) -> list[range]:
    """Return runs of frames that show more; one that goes on from what was found, or into it, belongs to that."""
    return [run for run in runs_of(shown > least) if np.isfinite(shown[run.start : run.stop]).all()]


def _comes_and_goes(shown: NDArray[np.float64], run: range, certain: float) -> bool:
    """Tell whether a run is a press from its beginning to its end: what drifts is there at an end of the recording."""
    clear = len(run) >= _FEWEST and float(shown[run.start : run.stop].max()) >= certain
    return clear and run.start > 0 and run.stop < len(shown)
