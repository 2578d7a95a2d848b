"""Readings that stand alone in time and in place: glitches of a sensor, or of the wire that they came over."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at, starts_over
from varishold.frame.neighbours import largest_around, whole_lines

__all__ = ["GlitchRule", "glitch_rule"]

# A frame is looked at beside the two before it and the two after it.
_BESIDE = 2
_WINDOW = 2 * _BESIDE + 1
# So far beyond all readings of its taxel beside it a glitch stands: in sigma of the noise, in the spread of those
# readings, and as a share of the highest that is read for two frames on end.
_SIGMAS, _SPREADS, _SHARE = 12.0, 2.0, 0.15
# What is touched shows on the taxels around it too: a glitch stands so many times as far out as they do.
_ALONE = 4.0
# Where glitches are more than this share of all that changes, it is the way in which this sensor is touched.
_MOST = 0.25
# As much as this share of all frames changes by what touches.
_TOUCHED = 0.9
_FEWEST_FRAMES, _FEWEST_TAXELS = 8, 4
# The standard deviation of noise by the median of its steps from frame to frame.
_SIGMA_OF_STEPS = 1.4826 / math.sqrt(2.0)
# Frames that are looked at for how much is read, and by how much: so many in each of so many places.
_SAMPLED, _PLACES = 64, 16
# Bytes of readings that are looked at together.
_TOGETHER = 1 << 22


@dataclass(frozen=True, eq=False)
class GlitchRule:
    """What is a glitch in a recording.

    Parameters
    ----------
    frames : Frames
        All of it, shape (n_frames, rows, cols).
    usable : ndarray of shape (rows, cols), bool
    least : float
        How far beyond all readings beside it a reading stands at least.
    """

    frames: Frames
    usable: Mask
    least: float

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1; what is a glitch has the median of the readings beside it."""
        read, start = self._with_those_beside(first, last)
        made = read[first - start : last - start]
        copied = False
        for number, glitch, instead in self._found(read, start, first, last):
            if not copied:
                made, copied = made.copy(), True
            made[number - first][glitch] = instead[glitch].astype(made.dtype)
        return made

    def words(self) -> tuple[str, ...]:
        """Return how many readings are replaced, in words."""
        n = 0
        for first, block in blocks_of(self.frames):
            last = first + len(block)
            read, start = self._with_those_beside(first, last)
            n += sum(int(np.count_nonzero(glitch)) for _, glitch, _ in self._found(read, start, first, last))
        what, them = ("1 reading stands", "it") if n == 1 else (f"{n} readings stand", "them")
        return (f"{what} alone in time and place: replaced by those beside {them}",) if n else ()

    def _with_those_beside(self, first: int, last: int) -> tuple[NDArray[Any], int]:
        """Return frames first to last - 1 and those beside them, and the number of the first that is returned."""
        n_frames = self.frames.shape[0]
        start, stop = max(0, min(first - _BESIDE, n_frames - _WINDOW)), min(n_frames, max(last + _BESIDE, _WINDOW))
        return np.asarray(self.frames[start:stop]), start

    def _found(self, read: NDArray[Any], start: int, first: int, last: int) -> Iterator[tuple[int, Mask, Floats]]:
        """Yield the number of each frame with glitches, where they are, and what is taken instead of them."""
        many = max(1, _TOGETHER // (8 * _WINDOW * self.usable.size))
        for begun in range(first, last, many):
            numbers = np.arange(begun, min(begun + many, last))
            readings = np.where(self.usable, read[numbers - start], 0.0)
            beside = np.where(self.usable, read[_numbers_beside(numbers, self.frames.shape[0]) - start], 0.0)
            inside = (numbers >= _BESIDE) & (numbers < self.frames.shape[0] - _BESIDE)
            for k in np.flatnonzero(self._odd(readings, beside, inside)):
                glitch = _glitches(readings[k], beside[k], self.usable, self.least)
                if glitch.any():
                    instead = np.median(beside[k], axis=0)
                    yield int(numbers[k]), glitch, np.rint(instead) if read.dtype.kind in "iu" else instead

    def _odd(self, readings: Floats, beside: Floats, inside: Mask) -> Mask:
        """Tell which of some frames may hold glitches; those that are `inside` have two before and two after them."""
        beyond = np.maximum(readings - beside.max(axis=1), beside.min(axis=1) - readings)
        odd: Mask = beyond.max(axis=(1, 2)) > self.least
        alike = np.ptp(readings[:, self.usable], axis=1) == 0.0
        if alike.any():
            # Two such frames may stand near each other. At the ends nobody knows whether something touched before, or
            # came after.
            mean, there = readings[:, self.usable].mean(axis=1), beside[:, :, self.usable].mean(axis=2)
            there.sort(axis=1)
            odd = np.where(alike, (inside & (mean < there[:, 1])) | (mean > there[:, -2]), odd)
        return odd


def glitch_rule(frames: Frames, usable: Mask) -> GlitchRule | None:
    """Return what is a glitch in a recording; None where nothing is to be called so.

    A reading is one that stands far beyond all readings of its taxel in the two frames before and the two after, while
    the taxels around it do not; so does a line of taxels, or a frame that shows one and the same value everywhere.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> frames = np.random.default_rng(0).normal(0, 1, (20, 8, 8))
    >>> frames[5:, 2:6, 2:6] += 100.0
    >>> frames[10, 3, 0] = 200.0
    >>> rule = glitch_rule(frames, np.ones((8, 8), bool))
    >>> rule.words(), bool(rule.mended(0, 20)[10, 3, 0] < 5)
    (('1 reading stands alone in time and place: replaced by those beside it',), True)
    """
    n_frames = frames.shape[0]
    if n_frames < _FEWEST_FRAMES or np.count_nonzero(usable) < _FEWEST_TAXELS:
        return None
    sampled = list(pieces_at(frames, starts_over(n_frames, _SAMPLED, _PLACES), _SAMPLED))
    rest = np.median(np.concatenate([part[:: max(1, len(sampled) // 4)] for part in sampled]), axis=0)
    away = [np.where(usable, np.abs(part - rest), 0.0) for part in sampled]
    # A glitch does not stay for two frames.
    span = max(float(np.minimum(part[1:], part[:-1]).max()) for part in away)
    steps = np.concatenate([np.diff(part[:, usable].astype(np.float64), axis=0).ravel() for part in sampled])
    sigma = _SIGMA_OF_STEPS * float(np.median(np.abs(steps)))
    least = max(_SHARE * span, _SIGMAS * sigma)
    if not 0.0 < least < np.inf:
        return None
    changes = np.concatenate([part.sum(axis=(1, 2), dtype=np.float64) for part in away])
    gone = np.concatenate([_gone(part, usable, least) for part in sampled])
    # No glitch counts more than what touches.
    most = float(np.quantile(changes, _TOUCHED))
    rare = np.minimum(gone, most).sum() <= _MOST * np.minimum(changes, most).sum()
    return GlitchRule(frames, usable, least) if rare else None


def _gone(frames: NDArray[Any], usable: Mask, least: float) -> Floats:
    """Return how much mending takes from each of some frames or gives to it."""
    if len(frames) < _WINDOW:
        return np.zeros(len(frames))
    mended = GlitchRule(frames, usable, least).mended(0, len(frames))
    changed: Floats = np.where(usable, np.abs(frames - mended.astype(np.float64)), 0.0).sum(axis=(1, 2))
    return changed


def _glitches(readings: Floats, beside: Floats, usable: Mask, least: float) -> Mask:
    """Return where a frame's readings are glitches: shape (rows, cols)."""
    there = np.sort(beside, axis=0)
    if np.ptp(readings[usable]) == 0.0:
        beyond = np.maximum(readings - there[-2], there[1] - readings)
        return usable if beyond[usable].max() > least else np.zeros_like(usable)
    limit = np.maximum(least, _SPREADS * (there[-1] - there[0]))
    found = np.zeros_like(usable)
    for beyond in (readings - there[-1], there[0] - readings):
        out = beyond > limit
        if out.any():
            found |= out & (beyond > _ALONE * largest_around(beyond))
            found |= whole_lines(out, usable)
    return found


def _numbers_beside(numbers: NDArray[np.intp], n_frames: int) -> NDArray[np.intp]:
    """Return the numbers of the four frames beside each, in time, shape (n, 4)."""
    first = np.clip(numbers - _BESIDE, 0, n_frames - _WINDOW)
    beside = first[:, None] + np.arange(_WINDOW - 1)
    return beside + (beside >= numbers[:, None])
