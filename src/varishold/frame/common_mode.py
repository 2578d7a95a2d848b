"""What all taxels of a pad do together from frame to frame, as by mains hum: found and taken off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.frame.fault import Floats, Frames, Mask, blocks_of, pieces_at, starts_over
from varishold.frame.noise import OF_MEDIAN, sigma_of_half
from varishold.frame.spread import spread_over
from varishold.frame.together import LARGEST_SHARE, readings_end, shares_of, without_it

__all__ = ["CommonMode", "common_mode"]

_FEWEST_FRAMES, _FEWEST_TAXELS = 16, 16
# Frames and taxels that are looked at first: so many frames on end in each of so many places.
_SAMPLED, _PLACES, _MOST_TAXELS = 64, 16, 1024
# Bytes of frames of which all taxels are kept.
_MOST_SAMPLED = 1 << 27
# All but so few taxels move at all: what leaves some still is a touch.
_MOVING = 0.9
# Taxels do something together where the quarter that changes least does, by so many standard errors of what chance
# makes of its median, and by this share of their own noise.
_CALM, _ERRORS, _LEAST = 0.25, 4.0, 0.5
# A taxel that nothing presses is off what all do by so many sigma at most. Such taxels are this share, and so many.
_SIGMAS, _FEWEST_SHARE, _FEWEST_FREE = 8.0, 0.05, 8
# What presses stands so many times as high as what all do together, and goes up and down with it no more than so: else
# that is how far it reaches.
_ABOVE, _WITH_LOAD = 2.0, 0.5
# Frames in which nothing presses that tell each taxel's share; else all share alike.
_FEWEST_UNLOADED = 32
# What a taxel reads at rest is above so much of all that it reads.
_RESTING = 0.25
# What no press does: no more than this share of the variance of what all do is left in the mean of so many frames; it
# never rests, so that the lowest part of all frames lies apart by more than noise, and of its steps from frame to frame
# three of four are this share of its spread; and nearly all taxels go by this share of what the usual one does. Presses
# that leave a quarter of the frames free rest, on a rest that drifts too, and those of more than two frames last.
_LASTS, _FEWEST_LASTING, _LOW, _LOWEST, _STEPS = 1 / 3, 5, 0.25, 0.05, 0.25
_LEAST_SHARE, _NEARLY_ALL = 0.5, 0.05
# Whether they are pressed or not, all but so many taxels go by that share of what those do that show it.
_MOST = 0.25
# Hum of which frames see the same phases again and again rests too: it comes back after so many frames at most, but for
# this share of its variance, and that so often as nobody presses a whole pad.
_LONGEST_PERIOD, _COMES_BACK, _FEWEST_TURNS = 12, 0.25, 50


@dataclass(frozen=True, eq=False)
class CommonMode:
    """What all taxels do together, read from those that nothing presses in the whole recording.

    Parameters
    ----------
    frames : Frames
        All of a recording, shape (n_frames, rows, cols).
    free : ndarray of shape (rows, cols), bool
        The taxels that nothing presses.
    rest : ndarray of shape (rows, cols), float64
        Their median.
    share : ndarray of shape (rows, cols), float64
        How far each taxel goes where all go by 1; 0 where there is none.
    ends_at : float
        The value at which readings end; they stay there.
    spread : float
        Standard deviation of what all do together.
    pressed : bool
        Whether something stands out of that.
    """

    frames: Frames
    free: Mask
    rest: Floats
    share: Floats
    ends_at: float
    spread: float
    pressed: bool

    def mended(self, first: int, last: int) -> NDArray[Any]:
        """Return frames first to last - 1 without what all taxels do together."""
        read = np.asarray(self.frames[first:last])
        return without_it(read, self.together(read), self.share, self.ends_at)

    def together(self, read: NDArray[Any]) -> Floats:
        """Return how far all taxels together are off their rest in each of some frames, shape (n_frames,)."""
        share = self.share[self.free]
        return np.asarray((read[:, self.free] - self.rest[self.free]) @ share / (share @ share))

    def words(self) -> tuple[str, ...]:
        """Return what is taken off, in words."""
        return (f"all taxels go up and down together by {self.spread:.3g}, as by mains hum: taken off",)


def common_mode(frames: Frames, usable: Mask) -> CommonMode | None:
    """Return what all taxels of a recording do together; None where that is little, or no taxel is free to show it.

    Where nothing stands out of it, a press all over may be the cause: then it counts where it neither lasts nor rests.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), or what gives slices of it
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> frames = rng.normal(0, 1, (100, 8, 8)) + 3 * np.sin(2.3 * np.arange(100))[:, None, None]
    >>> frames[40:60, 2:6, 2:6] += 100.0
    >>> found = common_mode(frames, np.ones((8, 8), bool))
    >>> mended = found.mended(0, 100)
    >>> round(float(frames[:, 0, 0].std()), 1), round(float(mended[:, 0, 0].std()), 1)
    (2.3, 1.0)
    """
    n_frames, places = frames.shape[0], np.flatnonzero(usable)
    if n_frames < _FEWEST_FRAMES or places.size < _FEWEST_TAXELS:
        return None
    some = places[spread_over(places.size, _MOST_TAXELS)]
    starts = starts_over(n_frames, _SAMPLED, _PLACES)
    sampled = [
        piece.reshape(-1, usable.size)[:, some].astype(np.float64) for piece in pieces_at(frames, starts, _SAMPLED)
    ]
    calm = _calm(sampled)
    if calm is None:
        return None
    return _looked_through(frames, usable, starts, np.searchsorted(places, some[calm]))


def _calm(sampled: list[Floats]) -> NDArray[np.intp] | None:
    """Return the taxels that change least, if they do so together."""
    steps = np.concatenate([np.diff(part, axis=0) for part in sampled])
    moving = np.flatnonzero(np.abs(steps).max(axis=0) > 0.0)
    if moving.size < max(_FEWEST_FREE, _MOVING * steps.shape[1]):
        return None
    order = moving[np.argsort(np.abs(steps[:, moving]).sum(axis=0), kind="stable")]
    calm = order[: max(int(_CALM * moving.size), _FEWEST_FREE)]
    alike = np.median(steps[:, calm], axis=1)
    noise, together = sigma_of_half(steps[:, calm] - alike[:, None]), sigma_of_half(alike)
    by_chance = _ERRORS * noise * OF_MEDIAN / math.sqrt(calm.size)
    return calm if together > max(by_chance, _LEAST * noise) else None


def _looked_through(frames: Frames, usable: Mask, starts: list[int], calm: NDArray[np.intp]) -> CommonMode | None:
    """Return what all taxels do together, by those that the calm ones show to be free in all frames."""
    places = starts[:: max(1, -(-8 * _SAMPLED * usable.size * len(starts) // _MOST_SAMPLED))]
    sampled = np.concatenate([piece[:, usable] for piece in pieces_at(frames, places, _SAMPLED)]).astype(np.float64)
    rest, share = np.median(sampled, axis=0), _shares(sampled, calm)
    away = sampled - rest
    alike = np.median(away[:, calm], axis=1)
    sigma = sigma_of_half((away - alike[:, None] * share)[:, calm])
    farthest, highest, course = np.zeros(len(rest)), 0.0, np.empty(frames.shape[0])
    for at, block in blocks_of(frames):
        off = block[:, usable] - rest
        course[at : at + len(block)] = alike_here = np.median(off[:, calm], axis=1)
        off -= alike_here[:, None] * share
        np.maximum(farthest, np.abs(off).max(axis=0), out=farthest)
        highest = max(highest, float(off.max()))
    free = (share > 0.0) & (np.ptp(sampled, axis=0) > 0.0) & (farthest <= _SIGMAS * sigma)
    n_free = np.count_nonzero(free)
    if n_free < max(_FEWEST_FREE, _FEWEST_SHARE * len(free)):
        return None
    # Where nothing stands out of what all do, that may be a press all over.
    pressed = bool(n_free < len(free) and highest >= _ABOVE * float(np.abs(course).max()))
    fewest, low, usual = np.quantile(share[np.ptp(sampled, axis=0) > 0.0], [_NEARLY_ALL, _MOST, 0.5])
    if low < _LEAST_SHARE * float(np.median(share[calm])):
        # What some lines of taxels do for themselves is not what all do.
        return None
    even = fewest >= _LEAST_SHARE * usual
    if not (pressed or (even and _flickers(course, _ERRORS * OF_MEDIAN * sigma / math.sqrt(calm.size)))):
        return None
    load = (away - alike[:, None] * share)[:, ~free].sum(axis=1)
    with_load = float(np.corrcoef(load, alike)[0, 1]) if np.std(load) > 0.0 else 0.0
    # Of a press all over, taxels that bear less of it go the other way.
    if with_load > _WITH_LOAD or (with_load < -_WITH_LOAD and not pressed):
        return None
    ends_at = readings_end(sampled, np.asarray(frames[:1]).dtype.kind)
    spread = float(alike.std())
    free, rest, share = (_on_pad(values, usable) for values in (free, rest, share))
    return CommonMode(frames, free, rest, share, ends_at, spread, pressed)


def _flickers(course: Floats, noise: float) -> bool:
    """Tell whether what all do in each frame is no press: it neither lasts nor rests, to within so much."""
    means = np.convolve(course, np.full(_FEWEST_LASTING, 1.0 / _FEWEST_LASTING), mode="valid")
    low, lowest = np.quantile(course, [_LOW, _LOWEST])
    rests = low - lowest <= noise or np.quantile(np.abs(np.diff(course)), _LOW) < _STEPS * course.std()
    return bool(means.var() <= _LASTS * course.var() and (not rests or _comes_back(course)))


def _comes_back(course: Floats) -> bool:
    """Tell whether what all do is the same after some frames, again and again."""
    above = course > course.mean()
    if np.count_nonzero(above[1:] & ~above[:-1]) < _FEWEST_TURNS:
        return False
    allowed = _COMES_BACK * course.var()
    periods = range(2, min(_LONGEST_PERIOD, course.size // 2) + 1)
    return any(float(np.square(course[period:] - course[:-period]).mean()) <= allowed for period in periods)


def _shares(sampled: Floats, calm: NDArray[np.intp]) -> Floats:
    """Return how far each taxel goes where all go by 1, from frames in which nothing presses; 1 where these are few."""
    share = even = np.ones(sampled.shape[1])
    # Most taxels are pressed for less than three quarters of the time.
    away = sampled - np.quantile(sampled, _RESTING, axis=0)
    alike = np.median(away[:, calm], axis=1)
    alike -= np.median(alike)
    # At first nobody knows the shares: a taxel may go twice as far as all, and nothing presses it.
    for allowed in ((LARGEST_SHARE - 1.0) * np.abs(alike), np.zeros(len(alike))):
        off = away - alike[:, None] * share
        off -= np.quantile(off, _RESTING, axis=0)
        noise = sigma_of_half(off[:, calm] - np.median(off[:, calm], axis=0))
        unloaded = np.abs(off).max(axis=1) <= _SIGMAS * noise + allowed
        of_all = alike[unloaded]
        if len(of_all) < _FEWEST_UNLOADED or not np.ptp(of_all):
            return even
        share = shares_of(away[unloaded], of_all, noise)
    return share


def _on_pad(values: NDArray[Any], usable: Mask) -> NDArray[Any]:
    """Return values of the usable taxels in their places, shape (rows, cols); 0 elsewhere."""
    made = np.zeros(usable.shape, values.dtype)
    made[usable] = values
    return made
