"""Contacts of a sensor's readings: what the sensor did is undone before they are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import require_a
from varishold.frame.checks import MOST_READ, as_mask, as_numbers, as_valid, beyond_reading
from varishold.levelset.contact import Contact, with_losses
from varishold.levelset.contacts import find_contacts as find_level_contacts
from varishold.levelset.contacts import find_contacts_batch as find_level_contacts_batch
from varishold.levelset.contacts import in_each
from varishold.sensor.model import Sensor

__all__ = ["find_contacts", "find_contacts_batch"]


def find_contacts(
    frame: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    pitch: float | tuple[float, float] | None = None,
    valid: ArrayLike | None = None,
    field: ArrayLike | None = None,
    floor: float | None = None,
    sigma: float | None = None,
    sensor: Sensor | None = None,
) -> list[Contact]:
    """Find the contacts of a frame and measure their sections at all thresholds in one pass.

    A contact is a part of {V > floor}. Two peaks of one part are two contacts only if the saddle between them
    lies below half of the lower peak (``VH_SPLIT_RATIO`` of ``varishold.h``).

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Pressure, or a height map; with `sensor`, its readings. NaN is no taxel, but where `valid` calls it broken.
        A sensor whose taxels stand on no grid has (n_taxels,).
    levels : int or array_like of shape (n_levels,)
        So many thresholds per contact, evenly from its own peak to its floor at half steps; or the same
        thresholds for all, in the unit of the frame, or of the sensor's stress.
    pitch : float or (float, float), optional
        Taxel spacing in metres, one for both ways or (row spacing, column spacing). Default: the sensor's; without
        one lengths are in taxels.
    valid : array_like of shape (rows, cols), bool, optional
        False where a taxel is broken; it is filled from its neighbours first.
    field : array_like of shape (rows, cols), bool, optional
        False where there is no taxel. Default: the sensor's.
    floor : float, optional
        The standard plane delta, in the unit of the levels, not negative. Default: from the noise that is left and
        the peak, as `varishold.frame.floor` says.
    sigma : float, optional
        Standard deviation of the noise, measured in time, in the unit of the levels. Default: from the frame alone.
    sensor : Sensor, optional
        What made the readings: its rest, polarity, response, gains, dead band, crosstalk and blur are
        undone, and `Contact.state` says what was saturated and repaired.

    Returns
    -------
    list of Contact
        By falling area of the lowest section; empty where nothing stands above the floor.

    Raises
    ------
    InputError
        If an argument has the wrong shape or type, a value is infinite or beyond 1e100, as it comes or once the
        sensor is undone, or every taxel is broken.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.sensor import Sensor
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> cone = np.maximum(6.0 - np.hypot(x, y), 0.0)
    >>> mat = Sensor(polarity="down", rest=255, span=10, full_scale=6.0, saturation=0.9)
    >>> (contact,) = find_contacts(mat.forward(cone), 4, pitch=0.002, floor=1.0, sensor=mat)
    >>> contact.state.saturated, round(contact.peak, 3)
    (1, 5.4)
    """
    if sensor is None:
        return find_level_contacts(frame, levels, pitch=pitch, valid=valid, field=field, floor=floor, sigma=sigma)
    require_a(Sensor, sensor, "sensor", "as read_sensor(path) gives it")
    readings = as_numbers(frame, 1 if np.ndim(frame) == 1 else 2, "a frame", masked=True)
    if readings.ndim == 1:
        readings = readings[None]
    works = _none_if_empty(as_valid(frame, valid, readings.shape))
    taxels = _none_if_empty(as_mask(field, readings.shape, "field"))
    taxels = sensor.field if taxels is None else taxels
    missing = np.isnan(readings) if readings.dtype.kind == "f" else np.zeros(readings.shape, np.bool_)
    if missing.any():
        # No taxel is no reading, unless it is called broken; until the sensor is undone it is one that is broken.
        absent = missing if works is None else missing & works
        works = ~missing if works is None else works & ~missing
        taxels = ~absent if taxels is None else taxels & ~absent
        readings = np.where(missing, sensor.rest, readings)
    wild = np.abs(readings, dtype=np.float64) > MOST_READ
    if works is not None:
        wild &= works
    if wild.any():
        raise beyond_reading(np.where(wild, readings, 0.0))
    undone = sensor.undo(readings, valid=works)
    if sensor.resampling is not None:
        taxels, pitch = sensor.resampling.field, pitch or sensor.resampling.pitch_m
    broken = undone.broken if undone.broken.any() else None
    contacts = find_level_contacts(
        undone.frame,
        levels,
        pitch=pitch or sensor.pitch_m,
        valid=None if broken is None else ~broken,
        field=taxels,
        floor=floor,
        sigma=sigma,
    )
    saturated = undone.saturated if undone.saturated.any() else None
    stands = None if sensor.resampling is None else sensor.resampling.stands
    return with_losses(contacts, repaired=broken, saturated=saturated, beneath=undone.beneath, stands=stands)


def find_contacts_batch(
    frames: ArrayLike,
    levels: int | ArrayLike = 32,
    *,
    sensor: Sensor | None = None,
    **options: Any,
) -> Sequence[list[Contact]]:
    """Find the contacts of many frames of one pad: the same as `find_contacts` on each.

    Parameters
    ----------
    frames : array_like of shape (n_frames, rows, cols), float or integer
        The frames.
    levels, sensor, **options
        As in `find_contacts`, for all frames.

    Returns
    -------
    sequence of list of Contact
        One list a frame; without a sensor a `varishold.levelset.ContactBatch`, which has arrays too.

    Raises
    ------
    InputError
        As `find_contacts`; the message names the frame.

    Examples
    --------
    >>> import numpy as np
    >>> [len(contacts) for contacts in find_contacts_batch(np.eye(3)[:, None, :])]
    [1, 1, 1]
    """
    if sensor is None:
        return find_level_contacts_batch(frames, levels, **options)
    values = as_numbers(frames, np.ndim(frames), "frames")
    return in_each(values, lambda frame: find_contacts(frame, levels, sensor=sensor, **options))


def _none_if_empty(mask: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    return None if mask.size == 0 else mask
