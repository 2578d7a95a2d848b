"""Are the values fit for use: finite, of the right polarity, from taxels that live?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import MOST_READ
from varishold.frame.neighbours import largest_around, three_by_three, whole_lines

__all__ = [
    "Extent",
    "broken_taxels",
    "dead_taxels",
    "extent_of",
    "full_scale",
    "remarks_of",
    "stuck_taxels",
    "taxels_in_words",
]

# A recording is mostly negative if its negative values outweigh the positive ones this much, in sum and in
# the farthest one, and this share of the taxels goes deeper than any goes high; noise about zero is far from all
# three together.
_OUTWEIGH = 2.0
_DEEP_SHARE = 0.01
# Taxels that never change are told only in recordings of at least this many frames.
_FEWEST_FRAMES = 8
# A taxel that is always 0 is dead where this share of the others shows noise.
ALIVE_SHARE = 0.9
# So many lines side by side that never change may be faults, where all others do.
_SIDE_BY_SIDE = 3
# Full scale of the converters that sensors use.
FULL_SCALES = tuple(2**bits - 1 for bits in (7, 8, 10, 12, 14, 15, 16, 24, 31, 32))
# Of floats, the share of taxels that reach exactly the same highest value. It tells nothing of counts that stand as
# floats: multiples of a step to within so much of it.
_SATURATED_SHARE, _WHOLE = 0.01, 0.05
# A taxel beside one that stands at full scale comes and goes where it rises by this share of full scale, and rests to
# within this share of it at other times.
_COMES, _GOES = 0.1, 0.05
# Frames that are looked at for how often a taxel shows its usual value. Of taxels that never changed a hundredth is
# fewer than is to be expected, where it is the sensor's way to show one value while nothing presses.
_MOST_SAMPLED = 256
_EXPECTED = 0.01
# Noise of a part of a count goes no farther than this many counts, up and down together.
_FLICKER = 2
# Readings go from about zero to about full scale within this share of it.
_BY_ZERO = 0.125
# Places that a remark lists before it only counts.
_LISTED = 4


@dataclass(frozen=True, eq=False)
class Extent:
    """Lowest and highest value of each taxel over a recording.

    Parameters
    ----------
    low, high : ndarray of shape (rows, cols)
        In the frames' own type; meaningless where a taxel is not usable.
    by_chance : bool
        Whether taxels that nothing presses flicker so seldom that some may never have changed by chance.
    """

    low: NDArray[Any]
    high: NDArray[Any]
    by_chance: bool = False


def extent_of(blocks: Iterable[tuple[int, NDArray[Any]]], usable: NDArray[np.bool_], *, signed: bool = False) -> Extent:
    """Go once through all frames and check that they are finite and of the right polarity.

    Parameters
    ----------
    blocks : iterable of (int, ndarray of shape (some, rows, cols))
        Consecutive frames, each block with the number of its first frame.
    usable : ndarray of shape (rows, cols), bool
        The taxels that must be finite.
    signed : bool
        Whether negative values may outweigh the positive ones.

    Raises
    ------
    InputError
        If a value is not finite where `usable`, or the values are mostly negative and not `signed`.
    """
    lows, highs = [], []
    negative, positive, n_negative, n_positive = 0.0, 0.0, 0, 0
    sampled: list[NDArray[Any]] = []
    n_frames, room = 0, _MOST_SAMPLED
    for start, block in blocks:
        if block.dtype.kind == "f":
            wrong = ~np.isfinite(block)
            if wrong.any():
                wrong &= usable
                if wrong.any():
                    frame, row, col = (int(k) for k in np.argwhere(wrong)[0])
                    seldom = np.isnan(block).any(axis=0) & np.isfinite(block).any(axis=0) & usable
                    nothing = "; where NaN means that nothing touches, write 0" if seldom.any() else ""
                    raise InputError(
                        f"pressure must be finite, got {block[frame, row, col]} at (row, col) = ({row}, {col}) "
                        f"of frame {start + frame}; mark dead taxels in valid{nothing}"
                    )
                block = np.where(usable, block, 0)
        n_frames = start + block.shape[0]
        if room > 0:
            sampled.append(block[:: max(1, block.shape[0] // room)][:room].copy())
            room -= len(sampled[-1])
        block_low, block_high = block.min(axis=0), block.max(axis=0)
        if max(-float(block_low[usable].min()), float(block_high[usable].max())) > MOST_READ:
            frame, row, col = (int(k) for k in np.argwhere((np.abs(block) > MOST_READ) & usable)[0])
            raise InputError(
                f"pressure must be within {MOST_READ:g}, got {block[frame, row, col]:g} at (row, col) = ({row}, {col}) "
                f"of frame {start + frame}; is the file damaged? Mark dead taxels in valid"
            )
        lows.append(block_low)
        highs.append(block_high)
        if block_low[usable].min() < 0:
            inside = block[:, usable]
            below, above = inside < 0, inside > 0
            with np.errstate(over="ignore"):
                negative -= float(inside.sum(where=below, dtype=np.float64))
                positive += float(inside.sum(where=above, dtype=np.float64))
            n_negative += int(np.count_nonzero(below))
            n_positive += int(np.count_nonzero(above))
        elif block.dtype.kind != "u":
            inside = block[:, usable]
            with np.errstate(over="ignore"):
                positive += float(inside.sum(dtype=np.float64))
            n_positive += int(np.count_nonzero(inside))
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    lowest, highest = float(low[usable].min()), float(high[usable].max())
    # One broken taxel does not turn a sensor's polarity round.
    n_deep = np.count_nonzero(low[usable] < -max(highest, 0.0))
    several = n_deep >= max(2.0, _DEEP_SHARE * np.count_nonzero(usable)) or np.count_nonzero(usable) < 4
    if not signed and negative > _OUTWEIGH * positive and -lowest > _OUTWEIGH * max(highest, 0.0) and several:
        deep = low[usable][low[usable] < -max(highest, 0.0)]
        mark = f"; where {lowest:g} stands for no reading, mark those taxels in valid" if np.ptp(deep) == 0.0 else ""
        raise InputError(
            f"pressure is mostly negative ({n_negative} values below 0, {n_positive} above; {lowest:g} to "
            f"{highest:g}): larger must mean more pressure; negate the values, or give a sensor file that says rest, "
            f"and polarity = 'down' where they fall under pressure{mark}"
        )
    return Extent(low, high, _still_by_chance(sampled, usable & (low == high), usable & (low != high), n_frames))


def _still_by_chance(
    sampled: list[NDArray[Any]],
    still: NDArray[np.bool_],
    changing: NDArray[np.bool_],
    n_frames: int,
) -> bool:
    """Tell whether some of the taxels that never changed were to be expected to, by how seldom the others do.

    Only the half of the frames counts in which most taxels show their usual value: the others are pressed.
    """
    if not still.any() or not changing.any():
        return False
    inside = np.concatenate([frames[:, changing] for frames in sampled])
    usual = inside == np.median(inside, axis=0)
    calm = usual.mean(axis=1)
    share = usual[calm >= np.median(calm)].mean(axis=0)
    return bool((share**n_frames).sum() >= _EXPECTED * np.count_nonzero(still))


def _still(extent: Extent, usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the taxels that never change, although all around them are pressed where others may do so unpressed."""
    still: NDArray[np.bool_] = usable & (extent.low == extent.high)
    if extent.by_chance:
        still &= _amid_pressed(extent, usable, still)
    return still


def _amid_pressed(extent: Extent, usable: NDArray[np.bool_], still: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return around what all taxels are pressed, and two of them on opposite sides; shape (rows, cols).

    What presses on both sides of a taxel presses it too. In a corner taxels are on one side alone.
    """
    living = usable & ~still
    rise = np.where(living, extent.high.astype(np.float64) - extent.low, 0.0)
    step = _step(extent.high[living]) if living.any() else None
    pressed = living & (rise > _FLICKER * (step or 0.0)) & (rise >= _COMES * rise.max())
    beside = three_by_three(pressed, False)
    opposite = np.any([one & other for one, other in zip(beside[:4], beside[:4:-1], strict=True)], axis=0)
    found: NDArray[np.bool_] = opposite & (largest_around((usable & ~pressed).astype(np.float64)) == 0.0)
    return found


def stuck_taxels(extent: Extent, usable: NDArray[np.bool_], n_frames: int) -> NDArray[np.bool_]:
    """Return the taxels that never change their value, which is not 0, while others do; shape (rows, cols)."""
    still = _still(extent, usable)
    known = n_frames >= _FEWEST_FRAMES and not np.array_equal(still, usable)
    return still & (extent.low != 0) if known else np.zeros_like(still)


def dead_taxels(extent: Extent, usable: NDArray[np.bool_], n_frames: int) -> NDArray[np.bool_]:
    """Return the taxels that are always 0 while nearly all others are not; lines between others may be half of them."""
    still = _still(extent, usable)
    known = n_frames >= _FEWEST_FRAMES and _are_faults(still, usable)
    return still & (extent.low == 0) if known else np.zeros_like(still)


def broken_taxels(extent: Extent, usable: NDArray[np.bool_], dtype: DTypeLike, n_frames: int) -> NDArray[np.bool_]:
    """Return the taxels that are not to be believed: dead, or stuck where nearly all others are not.

    What stands at full scale all the time may have been pressed all the time: it is saturated, not stuck, unless it is
    a single taxel or a line, and what is beside it comes and goes.
    """
    stuck = stuck_taxels(extent, usable, n_frames)
    if not _are_faults(stuck, usable):
        stuck[:] = False
    full = full_scale(extent, usable, dtype)
    if full is not None:
        stuck &= (extent.low < full) | _alone_at(full, extent, usable, stuck)
    return stuck | dead_taxels(extent, usable, n_frames)


def _alone_at(full: float, extent: Extent, usable: NDArray[np.bool_], stuck: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the single taxels and the lines that stand at full scale while what is beside them comes and goes."""
    always = stuck & (extent.low >= full)
    others = usable & ~always
    if not always.any() or not others.any():
        return np.zeros_like(always)
    rest = float(np.median(extent.low[others]))
    comes = extent.high - rest >= _COMES * (full - rest)
    near = largest_around((others & comes & (extent.low - rest <= _GOES * (full - rest))).astype(np.float64)) > 0.0
    lines = always & whole_lines(always, usable)
    alone = near & always & (largest_around(always.astype(np.float64)) == 0.0)
    found: NDArray[np.bool_] = alone | lines if (lines & near).any() else alone
    return found


def full_scale(extent: Extent, usable: NDArray[np.bool_], dtype: DTypeLike) -> float | None:
    """Return the value at which taxels are saturated, or None where none seems to be."""
    highs = extent.high[usable]
    highest = float(highs.max())
    if highest in FULL_SCALES:
        return highest
    if np.dtype(dtype).kind in "iu":
        return None
    n_full = np.count_nonzero(highs == highest)
    if n_full < max(2.0, _SATURATED_SHARE * highs.size):
        return None
    step = _step(highs)
    if step is None:
        return highest
    # Of counts that were divided by something, the highest is a usual full scale of theirs.
    return highest if round(highest / step) in FULL_SCALES else None


def _step(values: NDArray[Any]) -> float | None:
    """Return the step of which values are whole multiples, as counts are, whatever they were divided by; or None."""
    values = values.astype(np.float64)
    apart = np.diff(np.unique(np.append(values, 0.0)))
    if apart.size < 2:
        # One value alone tells no step, but that a count is a whole number.
        return 1.0 if values.max() > 1 and (values == np.rint(values)).all() else None
    step = float(apart.min())
    if np.abs(values).max() > 2 * FULL_SCALES[-1] * step:
        # No converter has so many steps.
        return None
    multiples = values / step
    return step if np.abs(multiples - np.rint(multiples)).max() <= _WHOLE else None


def remarks_of(extent: Extent, usable: NDArray[np.bool_], dtype: DTypeLike, n_frames: int) -> tuple[str, ...]:
    """Say in words what is odd: no change at all, stuck, dead and saturated taxels."""
    lowest, highest = extent.low[usable].min(), extent.high[usable].max()
    if lowest == highest:
        return (f"nothing changes: every value of every frame is {highest:g}",)
    remarks = []
    stuck, dead = stuck_taxels(extent, usable, n_frames), dead_taxels(extent, usable, n_frames)
    if stuck.any():
        remarks.append(f"{taxels_in_words(stuck)} never changes its value: stuck; mark it in valid")
    if dead.any():
        remarks.append(f"{taxels_in_words(dead)} is always 0 while nearly all others are not: dead or never touched")
    if full_scale(extent, usable, dtype) is not None:
        full = taxels_in_words(usable & (extent.high == highest))
        if np.dtype(dtype).kind in "iu":
            wraps = (extent.low <= _BY_ZERO * highest) & (extent.high >= (1 - _BY_ZERO) * highest)
            or_else = ", or readings below zero are stored without their sign" if _are_most(wraps, usable) else ""
            remarks.append(f"{full} reaches full scale, {highest:g}: saturated{or_else}")
        else:
            remarks.append(f"{full} reaches exactly the same highest value, {highest:g}: saturated, or flat")
    return tuple(remarks)


def _are_most(mask: NDArray[np.bool_], usable: NDArray[np.bool_]) -> bool:
    return bool(2 * np.count_nonzero(mask & usable) >= np.count_nonzero(usable))


def _are_faults(still: NDArray[np.bool_], usable: NDArray[np.bool_]) -> bool:
    """Tell whether taxels that never change are few, or few but for some lines between others that change."""
    lines = whole_lines(still, usable, side_by_side=_SIDE_BY_SIDE)
    return _are_few(still, usable) or (_are_few(still & ~lines, usable & ~lines) and bool((usable & ~lines).any()))


def _are_few(mask: NDArray[np.bool_], usable: NDArray[np.bool_]) -> bool:
    n = np.count_nonzero(usable)
    return bool(n - np.count_nonzero(mask) >= ALIVE_SHARE * n)


def taxels_in_words(mask: NDArray[np.bool_]) -> str:
    """Name the taxels of a mask, the first of many by their places; the subject of a sentence in the singular."""
    places = [f"({row}, {col})" for row, col in np.argwhere(mask)[:_LISTED]]
    n = int(np.count_nonzero(mask))
    if n == 1:
        return f"taxel {places[0]}"
    more = f" and {n - len(places)} more" if n > len(places) else ""
    return f"each of {n} taxels ({', '.join(places)}{more})"
