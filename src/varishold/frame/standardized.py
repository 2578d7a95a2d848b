"""Taxels that were each scaled to a mean of zero and a spread of one: found and taken back by their noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at
from varishold.frame.spread import spread_over

__all__ = ["ROUGHLY", "Standardized", "standardized_taxels"]

_OWN = "each taxel seems to have been scaled to its own mean and spread"
#: What is said where few frames tell by how much.
ROUGHLY = f"{_OWN}: taken back roughly"

# Frames and taxels that there must be; first frames that may have told mean and spread; pairs of frames that tell
# noise, and how many there must be; readings that are looked at together.
_FEWEST, _FEWEST_TAXELS, _FIRST, _MOST_PAIRS, _FEWEST_PAIRS, _MOST_READINGS = 8, 16, 256, 1024, 12, 1 << 22
# Of readings that have a spread of one most go no farther than this.
_USUAL = 2.0
# Nearly all taxels have their mean this near to zero, in spreads, and the same spread, about one, to within that share.
_NEARLY_ALL, _MEAN, _SPREAD, _ONE = 0.95, 2e-3, 2e-3, 0.1
# A scale that is off by more leaves small forms unsure.
_ROUGH = 0.05
# A frame and the next differ by noise where not even one taxel in fifty changes much more than in most pairs.
_FEW, _MUCH = 0.98, 1.5


@dataclass(frozen=True, eq=False)
class Standardized:
    """Taxels that get a scale on which all of them have the same noise.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    scale : ndarray of shape (rows, cols), float64
        What readings are multiplied by.
    error : float
        Standard error of the scale, as a share.
    """

    frames: Frames
    scale: Floats
    error: float

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1, in sigma of the noise."""
        made: Floats = np.asarray(self.frames[first:last]) * self.scale
        return made

    def words(self) -> tuple[str, ...]:
        """Return what was done to the taxels, in words."""
        how = ROUGHLY if self.error > _ROUGH else f"{_OWN}: taken back"
        to_within = f"to within {100 * self.error:.0f} %"
        return (f"{how} to where all have the same noise, {to_within}; give the readings as they come",)


def standardized_taxels(frames: Frames, usable: Mask) -> Standardized | None:
    """Return readings of which each taxel's mean and spread were taken out as they were; None for others.

    The mean and the spread may be those of all frames, or of the first ones. What all taxels read with the same noise
    then has different noise, which tells by how much each was scaled.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(50, 1, (90, 8, 8))
    >>> frames[20:40, 2:5, 2:5] += 100.0
    >>> found = standardized_taxels((frames - frames.mean(axis=0)) / frames.std(axis=0), np.ones((8, 8), bool))
    >>> mended = found.mended(0, 90)
    >>> bool(np.ptp(mended[30]) > 80), standardized_taxels(frames, np.ones((8, 8), bool)) is None
    (True, True)
    """
    n_taxels = int(np.count_nonzero(usable))
    if frames.shape[0] < _FEWEST or n_taxels < _FEWEST_TAXELS:
        return None
    many = max(_FEWEST, _MOST_READINGS // n_taxels)
    (first,) = pieces_at(frames, [0], min(_FIRST, many))
    if first.dtype.kind != "f" or not (_by_first(first[:, usable]) or _by_all(frames, usable)):
        return None
    noise, n_pairs = _noise(frames, usable, min(_MOST_PAIRS, max(many, 4 * _FEWEST_PAIRS)))
    if n_pairs < _FEWEST_PAIRS:
        return None
    scale = np.ones(usable.shape)
    scale[usable] = 1.0 / np.where(noise > 0.0, noise, 1.0)
    return Standardized(frames, scale, 1.0 / math.sqrt(n_pairs))


def _by_first(first: NDArray[Any]) -> bool:
    """Tell whether some number of a recording's first frames has mean 0 and spread 1 in nearly all taxels."""
    if not np.median(np.abs(first[:_FEWEST])) < _USUAL:
        return False
    mean = np.cumsum(first, axis=0, dtype=np.float64) / np.arange(1, len(first) + 1)[:, None]
    near = np.mean(np.abs(mean) <= _MEAN, axis=1) >= _NEARLY_ALL
    near[: _FEWEST - 1] = False
    return any(_standard(mean[k], first[: k + 1].std(axis=0)) for k in np.flatnonzero(near).tolist())


def _by_all(frames: Frames, usable: Mask) -> bool:
    """Tell whether all frames together have mean 0 and spread 1 in nearly all taxels."""
    total, squares = np.zeros((2, np.count_nonzero(usable)))
    some = np.array([piece[0][usable] for piece in pieces_at(frames, spread_over(frames.shape[0], _FEWEST).tolist())])
    if not np.median(np.abs(some)) < _USUAL:
        return False
    for _, block in blocks_of(frames):
        read = block[:, usable].astype(np.float64)
        total += read.sum(axis=0)
        squares += np.square(read).sum(axis=0)
    mean = total / frames.shape[0]
    return _standard(mean, np.sqrt(np.maximum(squares / frames.shape[0] - mean * mean, 0.0)))


def _standard(mean: Floats, spread: Floats) -> bool:
    """Tell whether nearly all of some means are zero, and of some spreads the same, about one."""
    usual = float(np.median(spread))
    alike = (np.abs(mean) <= _MEAN) & (np.abs(spread - usual) <= _SPREAD)
    return abs(usual - 1.0) <= _ONE and bool(alike.mean() >= _NEARLY_ALL)


def _noise(frames: Frames, usable: Mask, most_pairs: int) -> tuple[Floats, int]:
    """Return each usable taxel's noise, and how many pairs of successive frames tell it: those without more than it."""
    pairs = spread_over(frames.shape[0] - 1, most_pairs).tolist()
    read = (piece[:, usable].astype(np.float64) for piece in pieces_at(frames, pairs, 2))
    change = np.array([each[1] - each[0] for each in read])
    usual = np.median(np.abs(change), axis=0)
    shares = np.abs(change) / np.where(usual > 0.0, usual, 1.0)
    most = np.quantile(shares, _FEW, axis=1)
    quiet = change[most <= _MUCH * np.quantile(most, 0.25)]
    return np.sqrt(np.mean(np.square(quiet), axis=0) / 2.0), len(quiet)
