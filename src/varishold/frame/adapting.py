"""Readings that adapt to what presses, and so fall below their rest when it is let go: found and undone.

A sensor that zeroes itself, a piezoelectric one and many an elastic one read y = x - b s, where x presses and s follows
it at a pace of its own. The inverse is of the same kind: x goes as y + g c, where c is all of y before, each frame of
it forgotten by so much. What is true of g and of the pace is that nothing is left of a press after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of
from varishold.frame.noise import sigma_of_half
from varishold.frame.spread import spread_over

__all__ = ["Adapting", "adapting_readings"]

_FEWEST_FRAMES, _FEWEST_TAXELS = 40, 16
# Taxels, and frames from the first on, that are looked at.
_MOST_TAXELS, _MOST_FRAMES = 256, 8192
# The first frames, at least and at most so many, tell the rest; none of them is further off it than so many sigma.
_FIRST, _MOST_FIRST, _STILL = 8, 64, 6.0
# A taxel is pressed, or below its rest, beyond so many sigma and this share of the highest press.
_SIGMAS, _SHARE = 4.0, 0.01
# Taxels that read this share of the highest were pressed; so many of them are below their rest when something was let
# go, while less than this share of all is pressed; they come back once they are so near their rest
# again, and mostly do: what drifts does not.
_PRESSED, _FEWEST_BELOW, _STILL_PRESSED, _BACK, _MOSTLY = 0.25, 3, 0.02, 0.93, 0.6
# In how many frames a reading may be forgotten.
_PACES = np.array([2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, 50.0, 80.0, 120.0, 200.0, 400.0, 1600.0])
# It is certain where taxels are so many sigma below their rest, others are not, and so little of that is left.
_CERTAIN, _OTHERS, _LEFT, _FEWEST = 1.5, 0.3, 0.3, 32
# What is near its rest with nothing pressing forgets by so much more, so that noise does not add up.
_SETTLES = 0.9
# Bytes of what is kept of the past.
_ROOM = 1 << 25


@dataclass(frozen=True, eq=False)
class Adapting:
    """How readings adapt.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    rest : ndarray of shape (rows, cols), float64
    gain : float
        How much of the past is added to a reading.
    keeps : float
        The part of the past that is kept from frame to frame.
    tolerance : float
        What is less off its rest is at rest.
    every : int
    past : ndarray of shape (n, rows, cols), float64
        The past of each taxel at frame 0 and after every so many frames.
    """

    frames: Frames
    rest: Floats
    gain: float
    keeps: float
    tolerance: float
    every: int
    past: Floats

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 as what presses; whole numbers become floating-point ones."""
        at = first // self.every
        begin, past = at * self.every, self.past[at].copy()
        read = np.asarray(self.frames[begin:last])
        made = np.empty((last - first, *read.shape[1:]), _type_of(read.dtype))
        for k, frame in enumerate(read, begin):
            pressed = self._step(frame, past)
            if k >= first:
                made[k - first] = self.rest + pressed
        return made

    def _step(self, frame: NDArray[Any], past: Floats) -> Floats:
        """Return what presses in a frame, and take the frame into the past."""
        off = frame - self.rest
        pressed = off + self.gain * past
        past *= self.keeps
        past += off
        settled = (np.abs(off) < self.tolerance) & (np.abs(pressed) < self.tolerance)
        past[settled] *= _SETTLES
        return np.asarray(pressed)

    def words(self) -> tuple[str, ...]:
        """Return how fast readings adapt, in words."""
        frames = -1.0 / math.log(max(self.keeps - self.gain, math.exp(-1.0)))
        return (
            f"readings adapt to what presses within about {frames:.2g} frames, and fall below their rest after it: "
            "undone",
        )


def adapting_readings(frames: Frames, usable: Mask) -> Adapting | None:
    """Return how readings adapt to what presses; None where they do not, or that is not certain.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> force, rest = np.r_[np.zeros(20), np.full(30, 100.0), np.zeros(50)], 0.0
    >>> frames = np.random.default_rng(0).normal(0, 1, (100, 8, 8))
    >>> for k in range(100):
    ...     frames[k, 2:6, 2:6] += force[k] - rest
    ...     rest += (force[k] - rest) / 20
    >>> round(float(frames[49, 4, 4]), -1), round(float(frames[50, 4, 4]), -1)
    (20.0, -80.0)
    >>> mended = adapting_readings(frames, np.ones((8, 8), bool)).mended(0, 100)
    >>> round(float(mended[49, 4, 4]), -1), bool(abs(mended[50, 4, 4]) < 10)
    (100.0, True)
    """
    n_frames, places = frames.shape[0], np.flatnonzero(usable)
    if n_frames < _FEWEST_FRAMES or places.size < _FEWEST_TAXELS:
        return None
    first = np.asarray(frames[:_MOST_FIRST])[:, usable].astype(np.float64)
    rest, sigma = _rest(first)
    if rest is None:
        return None
    some = spread_over(places.size, _MOST_TAXELS)
    begin = takewhile(lambda numbered: numbered[0] < _MOST_FRAMES, blocks_of(frames))
    looked = [block.reshape(len(block), -1)[:, places[some]] for _, block in begin]
    off = np.concatenate(looked)[:_MOST_FRAMES] - rest[some]
    peak = off.max(axis=0)
    tolerance = max(_SIGMAS * sigma, _SHARE * float(peak.max()))
    pressed = peak > max(_PRESSED * float(peak.max()), tolerance)
    if np.count_nonzero(off.min(axis=0)[pressed] < -tolerance) < _FEWEST_BELOW:
        return None
    found = _fitted(off, pressed, tolerance, sigma)
    if found is None:
        return None
    whole = np.zeros(usable.shape)
    whole[usable] = rest
    every = max(64, -(-n_frames * usable.size * 8 // _ROOM))
    rule = Adapting(frames, whole, *found, tolerance, every, np.zeros((1, *usable.shape)))
    return replace(rule, past=_pasts(rule))


def _type_of(dtype: np.dtype[Any]) -> DTypeLike:
    """Return the type of readings that are no whole numbers any more."""
    if dtype.kind == "f":
        return dtype
    return np.float32 if dtype.itemsize <= 2 else np.float64


def _rest(first: Floats) -> tuple[Floats | None, float]:
    """Return what taxels read before anything presses, and their noise; no rest where something moves at once."""
    sigma = sigma_of_half(np.diff(first[:_FIRST], axis=0)) / math.sqrt(2.0)
    rest = np.median(first[:_FIRST], axis=0)
    moves = np.count_nonzero(np.abs(first - rest) > _STILL * sigma, axis=1) > 1
    still = int(np.argmax(moves)) if moves.any() else len(first)
    if still < _FIRST:
        return None, sigma
    # What moves next has begun to move before.
    return np.median(first[: max(_FIRST, still - 2)], axis=0), sigma


def _fitted(off: Floats, pressed: Mask, tolerance: float, sigma: float) -> tuple[float, float] | None:
    """Return gain and part kept that leave nothing of a press after it; None where none leave little.

    Takes what some taxels are off their rest, shape (n_frames, n_taxels), and which of them were pressed.
    """
    coming_back = _coming_back(off, pressed, tolerance)
    seen, below = off[coming_back.any(axis=1)], coming_back[coming_back.any(axis=1)]
    many, energy, noise = np.count_nonzero(below), float((seen[below] ** 2).sum()), sigma * sigma
    if many < _FEWEST or energy < _CERTAIN**2 * many * noise:
        return None
    # What all taxels do, pressed before or not, is no matter of presses.
    if not pressed.all() and np.mean(seen[:, ~pressed] ** 2) - noise > _OTHERS**2 * energy / many:
        return None
    keeps = np.exp(-1.0 / _PACES)
    past, both, squares = np.zeros((len(keeps), off.shape[1])), np.zeros(len(keeps)), np.zeros(len(keeps))
    for frame, there in zip(off, coming_back, strict=True):
        if there.any():
            both -= past[:, there] @ frame[there]
            squares += (past[:, there] ** 2).sum(axis=1)
        past = frame + keeps[:, None] * past
    gains = np.maximum(both, 0.0) / np.maximum(squares, np.finfo(float).tiny)
    left = energy - gains * both
    best = int(np.argmin(left))
    return (float(gains[best]), float(keeps[best])) if left[best] - many * noise <= _LEFT * energy else None


def _coming_back(off: Floats, pressed: Mask, tolerance: float) -> Mask:
    """Return when which taxels are on their way back from below their rest; nowhere where they mostly are not."""
    below, was_high = np.zeros(off.shape[1], np.bool_), np.zeros(off.shape[1], np.bool_)
    found = np.zeros(off.shape, np.bool_)
    n_let_go, deepest = 0, 0.0
    for k, frame in enumerate(off):
        high = frame > tolerance
        was_high |= high
        below = (below & ~high) | ((frame < -tolerance) & pressed & was_high)
        if np.count_nonzero(below) < _FEWEST_BELOW or np.count_nonzero(high) > _STILL_PRESSED * high.size:
            deepest = 0.0
            continue
        n_let_go += 1
        depth = -float(frame[below].sum())
        deepest = max(deepest, depth)
        if depth < _BACK * deepest:
            found[k] = below
    return found if np.count_nonzero(found.any(axis=1)) >= _MOSTLY * n_let_go else np.zeros_like(found)


def _pasts(rule: Adapting) -> Floats:
    """Return the past at frame 0 and after every so many frames."""
    past = rule.past[0].copy()
    kept = []
    for at, block in blocks_of(rule.frames):
        for k, frame in enumerate(block, at):
            if k % rule.every == 0:
                kept.append(past.copy())
            rule._step(frame, past)
    return np.array(kept)
