"""Variants of grasps, as of an array that lies a place aside: which there are, and grasps that are taught with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import require
from varishold.frame.checks import as_given
from varishold.grasp.modes import ModeOptions
from varishold.grasp.training import TrainingGrasps, distinct_rows

__all__ = ["shift_variants", "with_variants"]


def shift_variants(
    shape: tuple[int, ...],
    *,
    distance: int = 1,
    diagonal: bool = False,
    axes: tuple[int, int] = (-2, -1),
    bits: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]:
    """Shifts of a switch array by up to `distance` places, as `HyperplaneClassifier` takes them in `variants`.

    Parameters
    ----------
    shape : tuple of int
        Shape in which the switches (or channels) lie, like (pads, rows, columns).
    distance : int, default 1
        Largest shift along rows or along columns.
    diagonal : bool, default False
        Include shifts along both.
    axes : (int, int), default (-2, -1)
        Which axes of `shape` are rows and columns.
    bits : ndarray of shape (n_channels,), optional
        Bits per channel, where the switches are an encoder's bits (`ThresholdEncoder.bits_per_channel_`).
        A bit reads its channel's neighbour's bit of the same rank, or its highest.

    Returns
    -------
    ndarray of shape (n_variants, n_switches), int64
        Which switch each one reads; -1 where the array ends.

    Examples
    --------
    >>> shift_variants((1, 3), axes=(0, 1))[0]
    array([ 1,  2, -1])
    """
    channels = np.arange(int(np.prod(shape)), dtype=np.int64).reshape(shape)
    rows, columns = (axis % len(shape) for axis in axes)
    found = []
    steps = range(-distance, distance + 1)
    for down in steps:
        for right in steps:
            outside = abs(down) >= shape[rows] or abs(right) >= shape[columns]
            if outside or (down, right) == (0, 0) or (down and right and not diagonal):
                continue
            moved = np.full(shape, -1, dtype=np.int64)
            to, of = [slice(None)] * len(shape), [slice(None)] * len(shape)
            for axis, by in ((rows, down), (columns, right)):
                to[axis] = slice(max(0, by), shape[axis] + min(0, by))
                of[axis] = slice(max(0, -by), shape[axis] + min(0, -by))
            moved[tuple(to)] = channels[tuple(of)]
            found.append(moved.ravel())
    variants = np.array(found, dtype=np.int64).reshape(len(found), channels.size)
    if bits is None:
        return variants
    starts = np.concatenate([[0], np.cumsum(bits)[:-1]])
    channel = np.repeat(np.arange(len(bits)), bits)
    rank = np.arange(int(bits.sum())) - starts[channel]
    source = variants[:, channel]
    return np.where(source < 0, -1, starts[source] + np.minimum(rank, bits[source] - 1))


def with_variants(
    grasps: TrainingGrasps, options: ModeOptions, variants: ArrayLike | None
) -> tuple[TrainingGrasps, ModeOptions]:
    """Add to the training grasps what each would read in every variant; copies remember their grasp."""
    if variants is None:
        return grasps, options
    r = grasps.n_switches
    maps = as_given(variants, f"variants must be integers from -1 to {r - 1} of shape (n_variants, {r})")
    fit = maps.ndim == 2 and maps.shape[1] == r and maps.dtype.kind in "iu"
    require(
        fit and ((maps >= -1) & (maps < r)).all(),
        f"variants must be integers from -1 to {r - 1} of shape (n_variants, {r}), "
        f"got shape {maps.shape} and dtype {maps.dtype}",
    )
    padded = np.column_stack([grasps.patterns, np.zeros(len(grasps), dtype=np.bool_)])
    patterns = np.concatenate([grasps.patterns, *(padded[:, row] for row in maps)])
    origin = np.tile(np.arange(len(grasps)), len(maps) + 1)
    distinct, first, _ = distinct_rows(patterns)
    owner = origin[first]
    taught = replace(
        grasps,
        patterns=distinct,
        labels=grasps.labels[owner],
        weights=grasps.weights[owner],
        numbers=grasps.numbers[owner],
    )
    return taught, replace(options, groups=tuple(owner.tolist()))
