"""Which frames to look at: the strongest, all of them, one, or those of each press."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame import frame_noise, recording_noise, timed_noise
from varishold.frame.noise import MEDIAN_ABS_NORMAL
from varishold.frame.order_statistics import median_of, nearest_of, pieces_of, quantile_of
from varishold.frame.quiet import common_noise, few_taxels_noise, is_level, off_plane
from varishold.frame.spread import spread_over
from varishold.recording.framed import Framed
from varishold.recording.light_presses import light_presses

__all__ = ["frame_groups", "peak_frame", "presses", "select_frames"]

# A press begins above this share of the largest total and above this many sigma of an unloaded total, and it
# ends below half of that.
_BEGIN_SHARE = 0.02
_BEGIN_SIGMA = 6.0
_END = 0.5
# The total of the quietest frames is the sensor's rest where it stays within this share of the largest one;
# a recording that is loaded from end to end shows no rest, and 0 is taken.
_REST_QUANTILE = 0.05
_REST_SHARE = 0.25
_REST_SIGMA = 4.0
# What stands on a pad at rest, by so much of what stands highest, is no load where most of it, to within such a share,
# is the same in the most loaded frame.
_STANDS, _SAME_SHARE, _STAYS = 0.25, 0.1, 0.5
# What the whole pad does at rest (mains hum) lifts the begin of a press, but to no more than this share: a press of
# the whole pad that is never held looks like it.
_HUM_SHARE = 0.25
# Of normal totals below their median this share of successive ones differ by less than so many standard deviations; so
# many of them, of the first so many frames, tell it.
_QUIETER, _QUIETER_STEP, _FEWEST_STEPS, _MOST_TOTALS = 0.25, 0.255, 16, 1 << 20
# So many steps of each taxel tell its noise.
_MOST_STEPS = 64
# A press whose load reaches so many times what begins one is certain.
_CERTAIN = 2.0
# A press is over when its load has fallen by this share of what it rose by, whatever stays: creep, or drift.
_OVER = 0.75
# A single frame that falls so far is a glitch of the sensor where one beside it stands higher than this share of what
# the highest of so many there stands above it.
_FEWEST_OVER, _ON_THE_WAY, _AT_ONCE = 2, 4, 0.75
# Frames at the start that show where totals begin. Below that they rise or fall where halves of a window do, by this
# share of how far noise reaches; they come back to it where they rise so many times as often as they fall.
# They stay at a level where they do neither in so many windows.
_STARTS, _HALF, _STILL, _MOSTLY, _LASTS = 8, 3, 0.25, 2.0, 3


def peak_frame(recording: Framed) -> int:
    """Return the number of the frame with the largest total over the usable taxels of all pads.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording
    >>> peak_frame(Recording({"pad": Pad(np.array([[[0.0, 1.0]], [[2.0, 1.0]], [[1.0, 1.0]]]))}))
    1
    """
    return int(np.argmax(recording.totals()))


def presses(recording: Framed) -> list[range]:
    """Return the presses of a recording: runs of consecutive loaded frames.

    A frame's load is its total over all pads above the total at rest. A press begins where it exceeds both 2 % of
    its largest value and six sigma of an unloaded total, and ends where it falls below half of that, so that noise
    about the limit makes no presses. Where the load falls by three quarters of what it rose by, and rises again as
    much, there are two presses, although the rest has drifted, or something of the first one stays. A single frame
    that falls at once parts none. A press that is too light, or too small on a large pad, for its total is found where
    some taxels rise out of their noise together and fall again.

    Parameters
    ----------
    recording : Recording
        The recording.

    Returns
    -------
    list of range
        Frames of each press, in time; empty where nothing was pressed.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording
    >>> force = np.array([0, 0, 5, 9, 5, 0, 0, 0, 7, 8, 0])
    >>> presses(Recording({"pad": Pad(np.tile(force[:, None, None], (1, 4, 4)))}))
    [range(2, 5), range(8, 10)]
    """
    totals = recording.totals()
    noise, hum = _total_noise(recording), _hum(recording)
    rest = _total_at_rest(recording, totals, noise, hum)
    largest = float(totals.max()) - rest
    # Where taxels differ in noise the noisiest make that of the total; where something presses all the time it goes up
    # and down by more than noise.
    if largest < _BEGIN_SIGMA * _scatter(totals) and largest < _BEGIN_SIGMA * _scatter_of_taxels(recording):
        return light_presses(recording, [])
    begin = max(_BEGIN_SHARE * largest, _BEGIN_SIGMA * noise, min(_BEGIN_SIGMA * hum, _HUM_SHARE * largest))
    found = [part for run in _runs(totals, rest, begin, _END * begin) for part in _parted(totals, run, begin)]
    # What the total hardly shows, some taxels show better.
    certain = [run for run in found if float(totals[run.start : run.stop].max()) - rest >= _CERTAIN * begin]
    light = light_presses(recording, certain)
    known = np.zeros(len(totals), np.bool_)
    for run in (*certain, *light):
        known[run.start : run.stop] = True
    others = [run for run in found if not known[run.start : run.stop].any()]
    return sorted([*certain, *light, *others], key=lambda run: run.start)


def _total_at_rest(recording: Framed, totals: NDArray[np.float64], noise: float, hum: float) -> float:
    """Return the total of frames in which nothing presses; 0 where no frame is known to be one."""
    lowest = quantile_of(pieces_of(totals), _REST_QUANTILE)
    reach = max(_REST_SIGMA * noise, min(_REST_SIGMA * hum, _HUM_SHARE * (float(totals.max()) - lowest)))
    # The quantile lies at the lower end of the noise about the rest.
    most_at_rest = lowest + reach
    rest = median_of(lambda: (piece[piece <= most_at_rest] for piece in pieces_of(totals)()))
    start = _level_at_start(totals, rest, reach) if len(totals) > _STARTS else None
    if start is not None or rest <= _REST_SHARE * float(totals.max()):
        return rest if start is None else start
    number, rises = nearest_of(pieces_of(totals), rest), float(totals.max()) - rest
    more = rises > max(_BEGIN_SHARE * float(totals.max()), _BEGIN_SIGMA * noise)
    stays = more and _stays(recording, number, int(totals.argmax()))
    # What is below zero is no load.
    return rest if stays or _is_flat(recording, number) else 0.0


def _level_at_start(totals: NDArray[np.float64], lowest: float, reach: float) -> float | None:
    """Return the level at which totals begin, where they stay there first, and come up again from what is lower.

    Readings that adapt to what presses, or creep, fall below their rest when it is let go, and come back. None where
    totals stay at the lowest level, fall below the first one about as often as they rise, or never rise above it.
    """
    first = np.asarray(totals[:_STARTS])
    level = float(np.median(first))
    if np.ptp(first) > 2 * reach or level <= lowest + 2 * reach or totals.max() - level < level - lowest:
        return None
    rising = falling = lasting = 0
    for piece in pieces_of(totals)():
        if len(piece) < 2 * _HALF:
            continue
        windows = np.lib.stride_tricks.sliding_window_view(piece, 2 * _HALF)
        windows = windows[windows.max(axis=1) < level - reach]
        rises = windows[:, _HALF:].mean(axis=1) - windows[:, :_HALF].mean(axis=1)
        stays = np.abs(rises) <= _STILL * reach
        lasting += int(np.count_nonzero(stays & (np.abs(windows - lowest).max(axis=1) <= reach)))
        rising += int(np.count_nonzero(~stays & (rises > 0)))
        falling += int(np.count_nonzero(~stays & (rises < 0)))
    return level if rising > _MOSTLY * falling and lasting < _LASTS else None


def _is_flat(recording: Framed, index: int) -> bool:
    """Tell whether a frame is a plane to within noise and unevenness on every pad: at rest, with an offset."""
    for pad in recording.pads.values():
        works = pad.usable & ~pad.broken
        values = off_plane(pad.frames[index], works)[works]
        uneven = frame_noise(pad.frames[index], valid=works)
        sigma = max(recording_noise(pad.frames, pad.field, pad.valid), uneven)
        if not (is_level(pad.frames[index], works) or (sigma > 0 and np.ptp(values) <= 2 * _BEGIN_SIGMA * sigma)):
            return False
    return True


def _stays(recording: Framed, index: int, loaded: int) -> bool:
    """Tell whether a frame's form on every pad is there in a loaded frame too, but for less than half: no press is."""
    for pad in recording.pads.values():
        works = pad.usable & ~pad.broken
        off = np.abs(off_plane(pad.frames[index], works))
        change = np.abs(pad.frames[loaded].astype(np.float64) - pad.frames[index])
        sigma = recording_noise(pad.frames, pad.field, pad.valid)
        stands = works & (off >= _STANDS * off.max())
        if np.mean((change <= np.maximum(_REST_SIGMA * sigma, _SAME_SHARE * off))[stands]) < _STAYS:
            return False
    return True


def _total_noise(recording: Framed) -> float:
    variance = 0.0
    for pad in recording.pads.values():
        # Taxels that rest at values of their own are no noise: they are the same from frame to frame.
        sigma = timed_noise(pad.frames, pad.field, pad.valid)
        sigma = recording_noise(pad.frames, pad.field, pad.valid) if sigma is None else sigma
        sigma = sigma or few_taxels_noise(pad.frames, pad.usable)
        variance += np.count_nonzero(pad.usable) * sigma * sigma
    return math.sqrt(variance)


def _hum(recording: Framed) -> float:
    """Return the standard deviation of the total by what each pad's taxels do alike from frame to frame."""
    pads = recording.pads.values()
    return math.hypot(*(np.count_nonzero(pad.usable) * common_noise(pad.frames, pad.usable) for pad in pads))


def _scatter(totals: NDArray[np.float64]) -> float:
    """Return the standard deviation of the totals where they are low, by successive ones; 0 of few."""
    some = np.asarray(totals[:_MOST_TOTALS])
    low = some <= np.median(some)
    steps = np.abs(np.diff(some))[low[1:] & low[:-1]]
    return float(np.quantile(steps, _QUIETER)) / _QUIETER_STEP if steps.size >= _FEWEST_STEPS else 0.0


def _scatter_of_taxels(recording: Framed) -> float:
    """Return the standard deviation of the total by what each taxel changes by itself from frame to frame."""
    variance = 0.0
    for pad in recording.pads.values():
        first = spread_over(len(pad.frames) - 1, _MOST_STEPS)
        steps = [np.abs(pad.frames[i + 1].astype(np.float64) - pad.frames[i])[pad.usable] for i in first]
        variance += float((np.median(steps, axis=0) ** 2).sum()) / (2.0 * MEDIAN_ABS_NORMAL**2)
    return math.sqrt(variance)


def _parted(totals: NDArray[np.float64], run: range, begin: float) -> list[range]:
    """Return the presses that a run of loaded frames holds; most often it is one."""
    first, stop = max(run.start - 1, 0), min(run.stop + 1, len(totals))
    load = np.asarray(totals[first:stop])
    below = np.minimum(np.maximum.accumulate(load), np.maximum.accumulate(load[::-1])[::-1]) - load
    ends = run.start == 0 or run.stop == len(totals)
    if not ends and not below.max() >= begin:
        return [run]
    n = len(load)
    ahead, over = _valleys(load.tolist(), begin)
    back, over_back = _valleys(load[::-1].tolist(), begin)
    # A valley counts where it is one forward in time and backward: the tail of a press that wavers is none.
    shared = _shared(ahead, [(n - stop, n - start) for start, stop in reversed(back)])
    valleys = [(one, other) for one, other in shared if other - one >= _FEWEST_OVER or _is_reached_slowly(load, one)]
    # What goes before the first press, or follows the last one, as far as the recording goes.
    if run.start == 0 and over_back is not None:
        valleys.insert(0, (0, n - over_back))
    if run.stop == len(totals) and over is not None:
        valleys.append((over, n))
    parts, start = [], run.start - first
    for (one, other), (next_one, _) in itertools.pairwise([*valleys, (n, n)]):
        lowest = one + int(np.argmin(load[one:other]))
        before = load[start : lowest + 1] >= load[lowest] + _END * begin
        after = load[lowest:next_one] >= load[lowest] + begin
        if before.any() and one > 0:
            parts.append(range(first + start, first + start + int(np.flatnonzero(before)[-1]) + 1))
        start = lowest + int(np.argmax(after)) if after.any() else n
    return [*parts, range(first + start, run.stop)] if first + start < run.stop else parts


def _shared(some: list[tuple[int, int]], others: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return what two lists of spans, each in order, have in common."""
    found, k = [], 0
    for start, stop in some:
        while k < len(others) and others[k][1] <= start:
            k += 1
        for a, b in itertools.islice(others, k, None):
            if a >= stop:
                break
            if min(stop, b) > max(start, a):
                found.append((max(start, a), min(stop, b)))
    return found


def _is_reached_slowly(load: NDArray[np.float64], lowest: int) -> bool:
    """Tell whether loads go down to one frame, and up again, in several frames each: no glitch does."""
    for beside in (load[max(lowest - _ON_THE_WAY, 0) : lowest][::-1], load[lowest + 1 : lowest + 1 + _ON_THE_WAY]):
        rises = beside - load[lowest]
        if rises.size < _ON_THE_WAY or rises[0] > _AT_ONCE * rises.max():
            return False
    return True


def _valleys(load: list[float], begin: float) -> tuple[list[tuple[int, int]], int | None]:
    """Return from where to where a press is over and the next has not begun, and since when the last one is over."""
    found = []
    low = high = load[0]
    since: int | None = None
    for k, value in enumerate(load):
        if since is not None:
            low = min(low, value)
            if value < low + begin:
                continue
            found.append((since, k))
            since, high = None, value
        high = max(high, value)
        if high - low >= begin and high - value >= max(_OVER * (high - low), begin):
            since, low = k, value
        elif value < low:
            low = high = value
    return found, since


def _runs(totals: NDArray[np.float64], rest: float, begin: float, end: float) -> list[range]:
    if begin <= 0:
        return []
    edges: list[int] = []
    start, before = 0, False
    for piece in pieces_of(totals)():
        load = piece - rest
        # 1 where a press begins or goes on, 0 where it is over, and between the two what the frame before was.
        certain = np.flatnonzero((load >= begin) | (load < end))
        known = np.full(load.size, -1, dtype=np.intp)
        known[certain] = certain
        known = np.maximum.accumulate(known)
        pressed = np.where(known >= 0, load[known] >= begin, before)
        edges += (start + np.flatnonzero(np.diff(pressed, prepend=before))).tolist()
        start, before = start + load.size, bool(pressed[-1])
    edges += [start] if before else []
    return [range(first, last) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def select_frames(recording: Framed, frames: str | int) -> list[range]:
    """Return the groups of frames that a person asked for; each group is to have one answer.

    Parameters
    ----------
    recording : Recording
        The recording.
    frames : {"peak", "all", "press"} or int or its digits
        The frame of the largest total, every frame for itself, each press that the recording names (where it names
        none, each run of loaded frames), or one frame by its number.

    Returns
    -------
    list of range
        At least one group; groups have at least one frame.

    Raises
    ------
    InputError
        If it is none of these, there is no such frame, or nothing was pressed.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording
    >>> recording = Recording({"pad": Pad(np.array([[[0.0, 1.0]], [[2.0, 1.0]]]))})
    >>> select_frames(recording, "peak"), select_frames(recording, "0")
    ([range(1, 2)], [range(0, 1)])
    """
    return [*frame_groups(recording, frames)]


def frame_groups(recording: Framed, frames: str | int) -> Iterable[range]:
    """As `select_frames`, one by one: of a million frames a list takes more memory than what is looked at.

    Raises
    ------
    InputError
        As `select_frames`.
    """
    source = f"{recording.source}: " if recording.source else ""
    if not isinstance(frames, str | int | np.integer):
        raise InputError(f"{source}frames must be 'peak', 'all', 'press' or a frame's number from 0, got {frames!r}")
    if frames == "peak":
        peak = peak_frame(recording)
        return [range(peak, peak + 1)]
    if frames == "all":
        return (range(index, index + 1) for index in range(recording.n_frames))
    if frames == "press":
        found: list[range] = list(recording.presses.frames)
        if not found:
            raise InputError(
                f"{source}no press found: the total never rises above its noise; ask for frames 'peak' or a number"
            )
        return found
    text = str(frames).strip()
    if isinstance(frames, bool) or not (text.isascii() and text.isdigit()):
        raise InputError(f"{source}frames must be 'peak', 'all', 'press' or a frame's number from 0, got {frames!r}")
    index = int(text[:18])
    if index >= recording.n_frames:
        raise InputError(f"{source}there is no frame {text[:18]}: frames are numbered 0 to {recording.n_frames - 1}")
    return [range(index, index + 1)]
