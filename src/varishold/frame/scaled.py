"""Frames of which each was scaled to its own range, or had its own mean taken off: found and taken back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, pieces_at
from varishold.frame.spread import spread_over

__all__ = ["OfItsOwn", "centred_frames", "scaled_frames", "scaled_words"]

# Frames and taxels that there must be; frames that are looked at.
_FEWEST, _FEWEST_TAXELS, _LOOKED_AT = 12, 16, 64
# Nearly all have the same largest reading, most in so few taxels, at so many places: neither saturated nor stuck.
_ALIKE, _TAXELS, _PLACES = 0.9, 2, 4
# Frames that were stretched between two ranks of their own, or stored as lossy pictures afterwards, end alike to within
# this share of their range. Noise that fills the range is as rough as noise, lies about the middle of the range and
# half of it takes a good part of that; frames in which something presses are so many times smoother. A tenth of the
# frames and more are of either.
_ENDS, _WHITE, _MIDDLE, _FILLS, _SMOOTHER, _EITHER = 0.1, 0.7, 1 / 3, 1 / 8, 3.0, 0.1
# What is equal but for rounding; a mean of whole numbers is.
_ROUNDING, _OF_WHOLE = 1e-6, 0.51
# Readings of these ranks, as shares of all taxels, are of taxels that nothing presses: they tell a frame's level, and
# how far taxels scatter. Where the lowest are all alike, as where noise ends at zero, higher ones tell it.
_LEVEL, _LOW, _HIGH = 0.25, 0.05, 0.7
# What frames scatter by in which nothing presses is what most do at most, so many times what some do in which something
# presses; none is enlarged more often than that.
_UNPRESSED, _UNLIKE, _MOST = 0.9, 2.0, 1e3


@dataclass(frozen=True, eq=False)
class OfItsOwn:
    """Frames of which each was treated for itself.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    ranks : (float, float, float)
        Which of a frame's readings, in shares of all, is its level, and which two tell how far taxels scatter.
    scatter : float or None
        How far they do where nothing presses; None where frames were not scaled.
    told : str
    """

    frames: Frames
    usable: Mask
    ranks: tuple[float, float, float]
    scatter: float | None
    told: str

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 on one level and one scale, that of what nothing presses, as numbers."""
        read = np.asarray(self.frames[first:last])
        made = read.astype(np.float64)
        level, low, high = _ranked(made[:, self.usable], self.ranks)
        made -= level[:, None, None]
        if self.scatter is not None:
            made *= (self.scatter / np.maximum(high - low, self.scatter / _MOST))[:, None, None]
        return np.where(self.usable, made, read)

    def words(self) -> tuple[str, ...]:
        """Return what was done to each frame, in words."""
        return (self.told,)


def scaled_frames(frames: Frames, usable: Mask) -> OfItsOwn | None:
    """Return frames that were each scaled to its own largest reading, or range, as they were; None for others.

    What nothing presses scatters alike in all frames of a sensor. How strong presses are becomes known roughly.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (60, 8, 8))
    >>> frames[20:40, 2:5, 2:5] += 100.0
    >>> scaled = frames / frames.max(axis=(1, 2), keepdims=True)
    >>> found = scaled_frames(scaled, np.ones((8, 8), bool))
    >>> mended = found.mended(0, 60)
    >>> bool(mended[20:40].max() > 20 * mended[:20].max())
    True
    """
    some = _some(frames, usable)
    told = () if some is None else _words(some)
    if some is None or not told:
        return None
    for ranks in ((_LEVEL, _LOW, _LEVEL), (_LOW, _LOW, _HIGH)):
        _, low, high = _ranked(some, ranks)
        if np.median(high - low) > 0.0:
            pressed, unpressed = np.quantile(high - low, [1.0 - _UNPRESSED, _UNPRESSED])
            if unpressed < _UNLIKE * pressed:
                return None
            words = f"{told[0]}; taken back to where what nothing presses scatters alike"
            return OfItsOwn(frames, usable, ranks, float(unpressed), words)
    return None


def centred_frames(frames: Frames, usable: Mask) -> OfItsOwn | None:
    """Return frames of which each had its own mean taken off as they were; None where it was not.

    Parameters
    ----------
    frames, usable
        As of `scaled_frames`.

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (60, 8, 8))
    >>> frames[20:40, 2:5, 2:5] += 100.0
    >>> centred = frames - frames.mean(axis=(1, 2), keepdims=True)
    >>> mended = centred_frames(centred, np.ones((8, 8), bool)).mended(0, 60)
    >>> round(float(centred[30, 0, 0])), round(float(mended[30, 0, 0]))
    (-14, 1)
    """
    some = _some(frames, usable)
    if some is None:
        return None
    reach = _OF_WHOLE if (some == np.rint(some)).all() else _ROUNDING * float(np.abs(some).max())
    # Where readings hardly exceed that, all means do.
    if np.abs(some.mean(axis=1)).max() > reach or np.ptp(some) <= _FEWEST_TAXELS * reach:
        return None
    told = "each frame seems to have had its own mean taken off: taken back to where what nothing presses is alike"
    return OfItsOwn(frames, usable, (_LEVEL, _LEVEL, _LEVEL), None, told)


def _some(frames: Frames, usable: Mask) -> Floats | None:
    """Return some frames' usable taxels, shape (n, n_taxels); None where there are too few of either."""
    if frames.shape[0] < _FEWEST or np.count_nonzero(usable) < _FEWEST_TAXELS:
        return None
    numbers = spread_over(frames.shape[0], _LOOKED_AT).tolist()
    return np.array([piece[0][usable] for piece in pieces_at(frames, numbers)], dtype=np.float64)


def _ranked(readings: Floats, ranks: tuple[float, ...]) -> list[Floats]:
    """Return each frame's readings of some ranks."""
    places = [int(rank * (readings.shape[1] - 1)) for rank in ranks]
    found = np.partition(readings, sorted(set(places)), axis=1)
    return [found[:, place] for place in places]


def scaled_words(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[str, ...]:
    """Say that each frame seems to be scaled to its own largest reading, or range; nothing where it does not.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        Some of a recording.
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(10, 1, (40, 8, 8))
    >>> scaled_words(frames, np.ones((8, 8), bool))
    ()
    >>> scaled = frames / frames.max(axis=(1, 2), keepdims=True)
    >>> scaled_words(scaled, np.ones((8, 8), bool))[0][:55]
    'each frame seems to be scaled to its own largest readin'
    """
    return _words(frames[:, usable].astype(np.float64))


def _words(seen: Floats) -> tuple[str, ...]:
    """Say of some frames' usable taxels, shape (n, n_taxels), what `scaled_words` says."""
    if len(seen) < _FEWEST:
        return ()
    highest = seen.max(axis=1)
    usual = float(np.median(highest))
    alike = np.abs(highest - usual) <= _ROUNDING * abs(usual)
    few = np.count_nonzero(seen == highest[:, None], axis=1) <= _TAXELS
    places = np.unique(seen.argmax(axis=1)[alike & few])
    if np.ptp(seen) > 0.0 and alike.mean() >= _ALIKE and few.mean() > 0.5 and places.size >= _PLACES:
        return (_told(f"largest reading, {usual:g}"),)
    return (_told(f"range, about {np.median(seen.min(axis=1)):g} to {usual:g}"),) if _stretched(seen) else ()


def _stretched(seen: Floats) -> bool:
    """Tell whether nearly all frames take the same range, some of them with noise alone.

    Noise of a sensor is as large where something presses as where nothing does: it fills the range of no frame that was
    left as it is, beside presses.
    """
    low, high = seen.min(axis=1), seen.max(axis=1)
    reach = _ENDS * float(np.median(high - low))
    alike = np.maximum(np.abs(low - np.median(low)), np.abs(high - np.median(high))) <= reach
    if seen.shape[1] < _FEWEST_TAXELS or reach == 0.0 or alike.mean() < _ALIKE:
        return False
    # Taxels come row by row: those side by side are mostly neighbours.
    rough = np.median(np.abs(np.diff(seen, n=2, axis=1)), axis=1)
    quarter, middle, three_quarters = _ranked(seen, (_LEVEL, 0.5, 1.0 - _LEVEL))
    half = three_quarters - quarter
    noise = (rough > _WHITE * half) & (half > _FILLS * (high - low))
    noise &= np.abs(2.0 * middle - high - low) < _MIDDLE * (high - low)
    smooth = _SMOOTHER * rough < np.median(rough[noise]) if noise.any() else noise
    return bool(min(noise.mean(), smooth.mean()) >= _EITHER)


def _told(by_what: str) -> str:
    return (
        f"each frame seems to be scaled to its own {by_what}: loads cannot be told, and noise looks like a press; "
        "give the readings as they come"
    )
