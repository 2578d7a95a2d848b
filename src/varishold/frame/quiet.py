"""The noise of a recording: what changes when nothing does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.files import let_go
from varishold.frame.checks import as_numbers, as_usable
from varishold.frame.noise import MEDIAN_ABS_NORMAL, ROUNDING, frame_noise
from varishold.frame.spread import spread_over

__all__ = [
    "FEWEST_FRAMES",
    "SMOOTHED",
    "common_noise",
    "few_taxels_noise",
    "is_level",
    "is_smoothed",
    "noise_in_time",
    "off_plane",
    "recording_noise",
    "shared_noise",
    "timed_noise",
]

#: What is said of smoothed readings.
SMOOTHED = "taxels share their noise, as where readings are smoothed or interpolated: small forms are not sure"
# Neighbours share so much of their noise there; those of most sensors share less than half of it.
_SHARED = 0.3
# The quietest changes from frame to frame are up to so many times the least, and more on small pads, by so many errors
# of what their taxels change in all. What a taxel changes by more than so many sigma of most of them is no noise.
_AS_QUIET, _AS_QUIET_ERRORS, _SIGMAS_OF_NOISE = 1.5, 6.0, 3.0
#: Frames that the noise in time takes.
FEWEST_FRAMES = 8
# Pairs of frames that the estimate looks at, and frames.
_FEWEST_PAIRS = 4
_MOST_FRAMES, _MOST_PAIRS = 64, 256
# Of a mapped file no more frames than these stay in memory.
_FRAMES_KEPT = 16
# While something moves, differences are more than noise: the share of pairs that hardly has any.
_QUIETER = 0.25
# So many standard deviations hold that share of what is normal, to both sides of its mean.
_QUIETER_SIGMAS = 0.3186
# What taxels do alike a thousand of them tell.
_MOST_TAXELS = 1024
# So many frames tell what is the same in all of them.
_FEWEST_ALIKE = 16
# A frame whose largest deviation is beyond this many sigma is no unloaded frame.
_LOADED = 6.0
# A pad of fewer taxels does not tell unevenness from form. There a rest with an offset is what lies this near a plane,
# in shares of itself: a press that is held is not so even.
_FEWEST_TAXELS = 36
_LEVEL = 0.05


def recording_noise(frames: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> float:
    """Estimate the standard deviation of a pad's noise from all its frames.

    Where the recording has unloaded frames, what changes between successive ones is noise; at most 256 pairs
    are looked at, and the quietest quarter decides. Without such frames, or where the sensor shows zeros
    instead of noise, the median of `frame_noise` over at most 64 loaded frames is returned.

    Parameters
    ----------
    frames : array_like of shape (n_frames, rows, cols), float or integer
        The frames; a memory map is read only where needed.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is broken.

    Returns
    -------
    float
        In the unit of the frames.

    Raises
    ------
    InputError
        If `frames` is not a (n_frames, rows, cols) array of numbers or a mask has another shape.

    Examples
    --------
    >>> import numpy as np
    >>> frames = np.random.default_rng(0).normal(0, 3.0, (50, 16, 16))
    >>> bool(abs(recording_noise(frames) / 3.0 - 1) < 0.05)
    True
    """
    given = as_numbers(frames, 3, "frames", masked=True)
    usable = as_usable(frames, given.shape[1:], field, valid)
    n_frames = given.shape[0]
    if n_frames == 0 or not usable.any():
        return 0.0
    if n_frames >= FEWEST_FRAMES:
        before, after = _quiet_pairs(given, usable)
        unloaded = None if _hide(before, after) else _unloaded_noise(before, after, given.dtype)
        if unloaded is not None:
            return unloaded
    chosen = given[spread_over(n_frames, _MOST_FRAMES)]
    loaded = [frame for frame in chosen if np.ptp(frame[usable]) > 0]
    return float(np.median([frame_noise(frame, valid=usable) for frame in loaded])) if loaded else 0.0


def timed_noise(frames: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> float | None:
    """Measure the standard deviation of a pad's noise in time: what changes from frame to frame when nothing else does.

    Unloaded frames tell it best, and many of which each taxel rests at a value of its own. Where there are none, the
    differences of successive frames do: what moves smoothly over them is taken out as `frame_noise` takes form out of
    a frame, and of 64 pairs the quieter ones decide. Unevenness between taxels, which a single frame shows as noise,
    stays the same from frame to frame and is not counted.

    Parameters
    ----------
    frames, field, valid
        As in `recording_noise`.

    Returns
    -------
    float or None
        In the unit of the frames; None with fewer than 8 frames, or where the sensor shows no noise that could be
        measured.

    Raises
    ------
    InputError
        As `recording_noise`.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> uneven = rng.normal(100, 20, (16, 16)) + rng.normal(0, 1.0, (50, 16, 16))
    >>> bool(abs(timed_noise(uneven) - 1.0) < 0.15)
    True
    >>> timed_noise(uneven[:1]) is None
    True
    """
    given = as_numbers(frames, 3, "frames", masked=True)
    usable = as_usable(frames, given.shape[1:], field, valid)
    return noise_in_time(given, usable)[0]


def noise_in_time(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[float | None, bool]:
    """Return `timed_noise` of arrays as they are checked, and whether zeros hide what noise there is at rest."""
    if frames.shape[0] < FEWEST_FRAMES or not usable.any():
        return None, False
    before, after = _quiet_pairs(frames, usable)
    hidden = _hide(before, after)
    unloaded = None if hidden else _unloaded_noise(before, after, frames.dtype, uneven=True)
    return _pairs_noise(frames, usable) if unloaded is None else unloaded, hidden


def off_plane(frame: NDArray[Any], usable: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return how far each usable taxel is off the plane that fits them best (0 elsewhere): what no slope explains."""
    row, col = np.nonzero(usable)
    values = frame[usable].astype(np.float64)
    plane = np.stack([np.ones(row.size), row, col], axis=1)
    fitted, *_ = np.linalg.lstsq(plane, values, rcond=None)
    off = np.zeros(frame.shape)
    off[usable] = values - plane @ fitted
    return off


def few_taxels_noise(frames: NDArray[Any], usable: NDArray[np.bool_]) -> float:
    """Return sigma of a pad that has too few taxels for `frame_noise`: of how successive frames differ, the quieter.

    What most taxels do alike is load.
    """
    if frames.shape[0] < FEWEST_FRAMES or np.count_nonzero(usable) >= _FEWEST_TAXELS:
        return 0.0
    found = []
    for i in _firsts_of_pairs(frames, _MOST_FRAMES):
        change = frames[i + 1][usable].astype(np.float64) - frames[i][usable]
        found.append(float(np.median(np.abs(change - np.median(change)))) / MEDIAN_ABS_NORMAL / math.sqrt(2))
        let_go(frames)
    return float(np.quantile(found, _QUIETER))


def common_noise(frames: NDArray[Any], usable: NDArray[np.bool_]) -> float:
    """Return the standard deviation of what the taxels of a pad do alike from frame to frame, as by mains hum.

    It is read from the quarter of the taxels that are pressed least, and the quieter quarter of successive frames
    decides: what presses moves less often than that. 0 with fewer than 8 frames.
    """
    if frames.shape[0] < FEWEST_FRAMES or not usable.any():
        return 0.0
    places = np.flatnonzero(usable)
    places = places[spread_over(len(places), _MOST_TAXELS)]
    first = _firsts_of_pairs(frames, _MOST_PAIRS)
    change = np.empty((first.size, places.size))
    for k, i in enumerate(first):
        change[k] = frames[i + 1].ravel()[places].astype(np.float64) - frames[i].ravel()[places]
        if k % _FRAMES_KEPT == 0:
            let_go(frames)
    calm = np.argsort(np.abs(change).sum(axis=0), kind="stable")[: max(places.size // 4, 1)]
    alike = np.abs(np.median(change[:, calm], axis=1))
    return float(np.quantile(alike, _QUIETER)) / (_QUIETER_SIGMAS * math.sqrt(2))


def shared_noise(frames: NDArray[Any], usable: NDArray[np.bool_]) -> float:
    """Return how far neighbouring taxels share their noise, from 0 for not at all to 1: as smoothing makes them.

    It is read from successive frames, the quieter ones, without what all do; what only rows share, or only columns, is
    none. Nor is what moves where something presses all the time: it stands out of the quietest frames, or of what most
    taxels change. 0 with fewer than 8 frames, and on pads of one line.
    """
    if frames.shape[0] < FEWEST_FRAMES or min(usable.shape) < 2:
        return 0.0
    changes = []
    for i in _firsts_of_pairs(frames, _MOST_FRAMES):
        change = np.where(usable, frames[i + 1].astype(np.float64) - frames[i], 0.0)
        change[usable] -= np.median(change[usable])
        changes.append(change)
        let_go(frames)
    totals = np.array([np.abs(change).sum() for change in changes])
    order = np.argsort(totals, kind="stable")[: max(len(changes) // 4, 1)]
    most = max(_AS_QUIET, 1.0 + _AS_QUIET_ERRORS / math.sqrt(np.count_nonzero(usable)))
    seen = np.array([changes[k] for k in order if totals[k] <= most * totals[order[0]]])
    limit = _SIGMAS_OF_NOISE / MEDIAN_ABS_NORMAL * np.median(np.abs(seen[:, usable]), axis=1)
    still = usable & (np.abs(seen) <= np.where(limit > 0.0, limit, np.inf)[:, None, None])
    alike = []
    for before, after in (np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:, :, :-1], np.s_[:, :, 1:]):
        both = still[before] & still[after]
        one, other = seen[before][both], seen[after][both]
        power = math.sqrt(float(one @ one) * float(other @ other))
        alike.append(float(one @ other) / power if power > 0.0 else 0.0)
    return max(min(alike), 0.0)


def is_smoothed(frames: NDArray[Any], usable: NDArray[np.bool_]) -> bool:
    """Tell whether taxels share their noise, as where readings are smoothed or interpolated."""
    return shared_noise(frames, usable) > _SHARED


def is_level(frame: NDArray[Any], usable: NDArray[np.bool_]) -> bool:
    """Tell whether a frame of a small pad is a plane to within a small share of itself, as a rest with an offset is.

    One whose taxels all show the same is none: no rest is without noise.
    """
    if np.count_nonzero(usable) >= _FEWEST_TAXELS or np.ptp(frame[usable]) == 0:
        return False
    return bool(np.abs(off_plane(frame, usable)).max() <= _LEVEL * abs(float(np.median(frame[usable]))))


def _firsts_of_pairs(frames: NDArray[Any], most: int) -> NDArray[np.intp]:
    """Return the first of each of at most so many pairs of successive frames, spread over a recording."""
    return spread_over(frames.shape[0] - 1, most)


def _pairs_noise(frames: NDArray[Any], usable: NDArray[np.bool_]) -> float | None:
    """Return sigma of the quieter differences between successive frames, or None where they are too few."""
    found = []
    for i in _firsts_of_pairs(frames, _MOST_FRAMES):
        before, after = frames[i].astype(np.float64), frames[i + 1].astype(np.float64)
        # Two equal values are no noise if they are the sensor's zero.
        hidden = (before == after) & (before == before[usable].min())
        sigma = frame_noise(after - before, valid=usable & ~hidden) / math.sqrt(2)
        if sigma > 0:
            found.append(sigma)
        let_go(frames)
    if len(found) < _FEWEST_PAIRS:
        return None
    quieter = float(np.quantile(found, _QUIETER))
    return max(quieter, ROUNDING) if frames.dtype.kind in "iu" else quieter


def _quiet_pairs(frames: NDArray[Any], usable: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the usable taxels of successive frames, shape (n_pairs, n_taxels) each: the least loaded quarter."""
    first = _firsts_of_pairs(frames, _MOST_PAIRS)
    before, after = np.empty((2, first.size, np.count_nonzero(usable)))
    for k, i in enumerate(first):
        before[k], after[k] = frames[i][usable], frames[i + 1][usable]
        if k % _FRAMES_KEPT == 0:
            let_go(frames)
    load = np.maximum(before.sum(axis=1), after.sum(axis=1))
    quiet = np.argsort(load, kind="stable")[: max(first.size // 4, _FEWEST_PAIRS)]
    return before[quiet], after[quiet]


def _hide(before: NDArray[np.float64], after: NDArray[np.float64]) -> bool:
    """Tell whether most values are zero twice: two that are equal are no noise if they are the sensor's zero."""
    return bool(np.mean((before == 0) & (after == 0)) > 0.5)


def _unloaded_noise(
    before: NDArray[np.float64], after: NDArray[np.float64], dtype: np.dtype[Any], *, uneven: bool = False
) -> float | None:
    """Return sigma of what changes between successive frames if these are unloaded, else None.

    With `uneven` they are unloaded also where what stands out of them is the same in all of them, if they are many.
    """
    change = (after - before) / math.sqrt(2)
    # A common drift of the whole pad is no noise of its taxels.
    change -= np.median(change, axis=1, keepdims=True)
    sigma = float(np.median(np.abs(change)) / MEDIAN_ABS_NORMAL)
    loads = [before - np.median(before, axis=1, keepdims=True)]
    loads += [before - np.median(before, axis=0)] if uneven and len(before) >= _FEWEST_ALIKE else []
    if sigma == 0 or min(np.median(np.abs(load).max(axis=1)) for load in loads) > _LOADED * sigma:
        return None
    return max(sigma, ROUNDING) if dtype.kind in "iu" else sigma
