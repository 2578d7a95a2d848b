"""Readings below zero that were stored without a sign: they came round at the far end of their type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.frame.fault import Frames, Mask, blocks_of, pieces_at
from varishold.frame.spread import spread_over

__all__ = ["Wrapped", "signed_of", "signed_type", "wrapped_readings"]

# Numbers of so many bits come round.
_BITS = (8, 10, 12, 14, 16, 24, 32)
# In parts of all numbers: what is below zero comes this near the end, and before that nothing is read for so long.
_NEAR, _GAP = 1 / 8, 1 / 4
# Taxels that come round again and again: in this share of the steps from frame to frame, at least so many times, and
# so many of them. What crosses zero by noise is above it, too: so many times for each time that it is below.
_OFTEN, _FEWEST_TIMES, _FEWEST_TAXELS, _ABOVE = 0.05, 4, 4, 0.1
# Steps from frame to frame that are looked at, and readings of them.
_MOST_STEPS, _MOST_READINGS = 256, 1 << 22


@dataclass(frozen=True, eq=False)
class Wrapped:
    """Readings that get their sign back.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols), whole numbers of at least zero.
    bits : int
        Bits of the numbers that came round.
    below : int
        How many readings are below zero.
    """

    frames: Frames
    bits: int
    below: int

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 with their signs, whole numbers."""
        return signed_of(np.asarray(self.frames[first:last]), self.bits)

    def words(self) -> tuple[str, ...]:
        """Return how many readings are below zero, in words."""
        were = counted(self.below, "reading below zero was", "readings below zero were")
        return (f"{were} stored without their sign, as {self.bits}-bit numbers: taken as below zero",)


def wrapped_readings(frames: Frames, usable: Mask) -> Wrapped | None:
    """Tell whether readings below zero were stored without their sign, as whole numbers; None where they were not.

    A rest about zero shows it: noise goes back and forth between zero and the far end of the type, where no pressure
    goes within a frame, and nothing is read between.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(0, 3, (40, 6, 6))
    >>> stored = np.rint(noise).astype(np.int64).astype(np.uint16)
    >>> found = wrapped_readings(stored, np.ones((6, 6), bool))
    >>> found.bits, int(found.mended(0, 40).min()) == int(np.rint(noise).min())
    (16, True)
    """
    places = np.flatnonzero(usable)
    steps = min(_MOST_STEPS, max(2, _MOST_READINGS // max(usable.size, 1)), frames.shape[0] - 1)
    if steps < _FEWEST_TIMES or places.size < _FEWEST_TAXELS:
        return None
    at = spread_over(frames.shape[0] - 1, steps).tolist()
    pairs = np.stack([pair.reshape(2, -1)[:, places] for pair in pieces_at(frames, at, 2)], axis=1)
    bits = _bits_of(pairs)
    if bits is None:
        return None
    far = pairs >= _far(bits)
    crosses = far[0] != far[1]
    often = crosses.sum(axis=0) >= max(_FEWEST_TIMES, _OFTEN * len(at))
    if np.count_nonzero(often) < _FEWEST_TAXELS:
        return None
    signed = signed_of(pairs[..., often], bits)
    deepest = -int(signed.min())
    above = np.count_nonzero((signed > 0) & (signed <= deepest))
    if above < _ABOVE * np.count_nonzero(signed < 0):
        return None
    below = sum(int(np.count_nonzero(block[:, usable] >= _far(bits))) for _, block in blocks_of(frames))
    return Wrapped(frames, bits, below)


def _bits_of(readings: NDArray[Any]) -> int | None:
    """Return of how many bits the numbers are that came round; None where these are none, or did not."""
    highest = float(readings.max())
    if readings.dtype.kind not in "iuf" or readings.min() < 0 or not highest < 2.0 ** _BITS[-1]:
        return None
    bits = next(bits for bits in _BITS if highest < 2.0**bits)
    between = (readings >= (1 - _NEAR - _GAP) * 2.0**bits) & (readings < _far(bits))
    if highest < _far(bits) or between.any():
        return None
    return bits if readings.dtype.kind in "iu" or bool((readings == np.rint(readings)).all()) else None


def _far(bits: int) -> int:
    """Return the least number that stands for one below zero."""
    return int((1 - _NEAR) * 2**bits)


def signed_of(readings: NDArray[Any], bits: int) -> NDArray[Any]:
    """Return readings that came round with so many bits, with their signs; floats stay floats."""
    kind = signed_type(readings.dtype)
    return np.where(readings >= _far(bits), readings.astype(kind) - kind.type(2**bits), readings.astype(kind))


def signed_type(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """Return the type of readings that have their sign: wide enough for a whole number with one, floats as they are."""
    return dtype if dtype.kind == "f" else np.dtype(np.int32 if dtype.itemsize <= 2 else np.int64)
