"""Contacts: where the pad is touched, and each one's sections at all thresholds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import (
    as_floats,
    as_floor,
    as_levels,
    as_mask,
    as_pitch,
    as_valid,
    beyond_reading,
    falling,
    is_ready,
)
from varishold.levelset.batch import ContactBatch, own_thresholds
from varishold.levelset.contact import Contact
from varishold.levelset.contact_state import Losses
from varishold.levelset.kernel import INFINITE, UNORDERED, Options, measure_frame, measure_frames

__all__ = ["find_contacts", "find_contacts_batch"]

_NO_MASK, _TO_CHOOSE = as_mask(None, (), "mask"), as_floor(None)


class Asked(NamedTuple):
    """What is asked of frames: so many levels of each contact's own, or 0 and thresholds; and the options."""

    n_even: int
    thresholds: NDArray[np.float64]
    options: Options


def find_contacts(
    frame: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    pitch: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
    floor: float | None = None,
    sigma: float | None = None,
) -> list[Contact]:
    """Find the contacts of a frame and measure their sections at all thresholds in one pass.

    A contact is a part of {V > floor}. Two peaks of one part are two contacts only if the saddle between them
    lies below half of the lower peak (``VH_SPLIT_RATIO`` of ``varishold.h``); the profiles of both
    then end at that saddle, and what lies below it belongs to neither, nor does a bump on their common skirt that
    is no contact of its own. A flat face that stands higher all along its rim than in its middle, as it presses on a
    bare elastic body, is one contact however low the saddles between its corners are.

    Where no floor is given, what noise alone makes is no contact: a peak that stands over its saddle no higher than
    noise reaches belongs to the contact around it, and a speck of a few taxels is left out that rises no higher above
    the floor. With a floor of your own every speck above it is a contact like any other.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Pressure, or a height map. NaN is no taxel.
    levels : int or array_like of shape (n_levels,)
        So many thresholds per contact, evenly from its own peak to its floor at half steps; or the same
        thresholds for all, in the unit of the frame and in any order (the profile's are falling). Where such a
        threshold lies below a contact's floor, its profile is NaN.
    pitch : float or (float, float), optional
        Taxel spacing in metres, one for both ways or (row spacing, column spacing). Without it lengths are in
        taxels.
    valid : array_like of shape (rows, cols), bool, optional
        False where a taxel is broken; it is filled from its neighbours first.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel.
    floor : float, optional
        The standard plane delta, in the unit of the frame, not negative. Default: four sigma of the frame's
        noise, but at least 5 % of its peak and at most 10 %, or with `sigma` at least 2 %, and never less than 1e-150:
        what is smaller is nothing. Where `levels` is a
        number too, dead and hot taxels and dead lines are filled and a sloping or offset rest is taken off first
        (`Frame.dead`, `Frame.rest`); of 64 x 64 taxels and more one that curves to second degree too.
    sigma : float, optional
        Standard deviation of the noise, measured in time (`varishold.frame.timed_noise`), in the unit of the frame.
        Default: estimated from the frame alone, in which noise and the taxels' unevenness are one.

    Returns
    -------
    list of Contact
        By falling area of the lowest section; empty where nothing stands above the floor.

    Raises
    ------
    InputError
        If an argument has the wrong shape or type, a value is infinite or beyond 1e100, or every taxel is broken.

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    >>> (contact,) = find_contacts(cone, 4, pitch=0.002, floor=1.0)
    >>> contact.profile.threshold.tolist()
    [5.375, 4.125, 2.875, 1.625]
    >>> (contact.profile.area * 1e6).round(1).tolist()
    [3.1, 41.5, 120.0, 237.9]
    """
    values = frame if is_ready(frame, 2) else as_floats(frame, 2, "a frame", masked=True)
    n_even, thresholds = as_levels(levels)
    options = _NOTHING_ASKED
    if not (pitch is valid is field is floor is sigma is None and type(frame) is np.ndarray):
        options = _options_of(frame, values.shape, pitch, valid, field, floor, sigma)
    return _find(values, n_even, thresholds, options)


def find_contacts_batch(
    frames: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    pitch: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
    floor: float | None = None,
    sigma: float | None = None,
) -> ContactBatch:
    """Find the contacts of many frames of one pad.

    The same as `find_contacts` on each, with the options looked at once.

    Parameters
    ----------
    frames : array_like of shape (n_frames, rows, cols), float or integer
        The frames.
    levels : int or array_like of shape (n_levels,) or (n_frames, n_levels)
        As in `find_contacts`, for all frames; or each frame's own thresholds.
    pitch, valid, field, floor, sigma
        As in `find_contacts`, for all frames.

    Returns
    -------
    ContactBatch
        A sequence of one list of contacts a frame, and arrays of what is measured of all of them. The arrays cost
        no Python object a contact, and other threads run meanwhile; a list is made anew each time it is asked for.

    Raises
    ------
    InputError
        As `find_contacts`; the message names the frame.

    Examples
    --------
    >>> import numpy as np
    >>> batch = find_contacts_batch(np.eye(3)[:, None, :], 4)
    >>> [len(contacts) for contacts in batch], batch.area.shape
    ([1, 1, 1], (3, 4))
    """
    values = as_floats(frames, 3, "frames", masked=True)
    own = own_thresholds(levels, len(values)) if np.ndim(levels) == 2 else None
    asked = asked_of(frames, values.shape[1:], levels if own is None else 1, pitch, valid, field, floor, sigma)
    return batch_of(values, asked if own is None else asked._replace(n_even=0, thresholds=own))


def asked_of(
    given: ArrayLike,
    shape: tuple[int, ...],
    levels: int | ArrayLike,
    pitch: float | tuple[float, float] | None,
    valid: ArrayLike | None,
    field: ArrayLike | None,
    floor: float | None,
    sigma: float | None,
) -> Asked:
    """Return the options of `find_contacts`, checked, for frames of a shape, which may be masked arrays."""
    return Asked(*as_levels(levels), _options_of(given, shape, pitch, valid, field, floor, sigma))


# The same object for the same options: the kernel's call looks no further.
@lru_cache(maxsize=64)
def _without_masks(pitch: tuple[float, float] | None, floor: float, sigma: float) -> Options:
    return Options(pitch, _NO_MASK, _NO_MASK, floor, sigma)


_NOTHING_ASKED = _without_masks(None, _TO_CHOOSE, _TO_CHOOSE)


def _options_of(
    given: ArrayLike,
    shape: tuple[int, ...],
    pitch: float | tuple[float, float] | None,
    valid: ArrayLike | None,
    field: ArrayLike | None,
    floor: float | None,
    sigma: float | None,
) -> Options:
    pitches = None if pitch is None else as_pitch(pitch, "pitch")
    options = _without_masks(pitches, as_floor(floor), as_floor(sigma, "sigma"))
    if valid is field is None and type(given) is np.ndarray:
        return options
    return options._replace(valid=as_valid(given, valid, shape), field=as_mask(field, shape, "field"))


def batch_of(values: NDArray[np.float64], asked: Asked, first: int = 0) -> ContactBatch:
    """Do `find_contacts_batch` with what was checked; an error counts the frames from `first`."""
    if asked.thresholds.size:
        asked = asked._replace(thresholds=falling(asked.thresholds))

    def contacts_of(i: int) -> list[Contact]:
        own = asked.thresholds.ndim == 2
        try:
            return _find(values[i], asked.n_even, asked.thresholds[i] if own else asked.thresholds, asked.options)
        except InputError as error:
            raise InputError(f"frame {first + i}: {error}") from None

    rows, n_found, noise = measure_frames(values, *asked)
    if len(n_found) < len(values):
        contacts_of(len(n_found))
    return ContactBatch(n_found, noise, rows, contacts_of)


def in_each(frames: NDArray[Any], find: Callable[[NDArray[Any]], list[Contact]]) -> list[list[Contact]]:
    """Return the contacts of many frames, one by one; an error names the frame."""
    found = []
    for i, frame in enumerate(frames):
        try:
            found.append(find(frame))
        except InputError as error:
            raise InputError(f"frame {i}: {error}") from None
    return found


def _find(values: NDArray[np.float64], n_even: int, thresholds: NDArray[np.float64], options: Options) -> list[Contact]:
    fault, frame, order = measure_frame(values, n_even, thresholds, options)
    if frame is None:
        if fault == UNORDERED:
            return _find(values, n_even, falling(thresholds), options)
        if fault == INFINITE:
            raise beyond_reading(np.where(options.valid, values, 0.0) if options.valid.size else values)
        raise InputError("every taxel of the frame is broken: nothing to fill from")
    if options.valid.size:
        frame = replace(frame, losses=Losses(repaired=~options.valid))
    return [Contact(frame, index) for index in order]
