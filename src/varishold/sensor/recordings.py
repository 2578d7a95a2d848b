"""Recordings seen through a sensor file: the rest taken off, readings turned upright, what is unsaid filled in."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.recording import Pad, Recording
from varishold.sensor.model import Sensor

__all__ = ["upright_recording"]

# Readings go the wrong way where at the start every taxel is this share of the range away from its rest ...
_AWAY = 0.25
# ... and what changes afterwards goes back so many times as much as on.
_BACK = 2.0


def upright_recording(recording: Recording, sensor: Sensor | None) -> Recording:
    """Return a recording whose readings are zero at rest and go up with pressure.

    Nothing else of the sensor is undone: what is left is `Sensor.upright`. Pitch and field are the recording's
    own where it knows them, the sensor's otherwise; taxels without gain are marked in `valid`.

    Parameters
    ----------
    recording : Recording
        Raw readings.
    sensor : Sensor or None
        What made them; None where they are upright already.

    Raises
    ------
    InputError
        If the shapes differ, or the readings go the other way than the sensor says.
    """
    if sensor is None:
        return recording
    pads = {name: _upright_pad(recording, name, pad, sensor) for name, pad in recording.pads.items()}
    return replace(recording, pads=pads, sensor=recording.sensor or sensor.name)


def _upright_pad(recording: Recording, name: str, pad: Pad, sensor: Sensor) -> Pad:
    expected = sensor.readings_shape
    if expected is not None and pad.shape != expected:
        raise InputError(
            f"{_file(sensor)}is for {expected[0]} x {expected[1]} taxels, pad {name!r} of "
            f"{recording.source or 'the recording'} has {pad.shape[0]} x {pad.shape[1]}"
        )
    frames = _upright(pad.frames, sensor)
    _check_polarity(frames, pad, recording, sensor)
    broken = sensor.broken
    valid = pad.valid
    if broken is not None:
        valid = ~broken if valid is None else valid & ~broken
    field = sensor.field if pad.field is None else pad.field
    return Pad(frames, field=field, valid=valid, pitch_m=pad.pitch_m or sensor.pitch_m, positions_m=pad.positions_m)


def _upright(frames: NDArray[Any], sensor: Sensor) -> NDArray[Any]:
    """Return readings above rest; whole numbers stay whole where the rest is one."""
    if sensor.polarity == "up" and np.ndim(sensor.rest) == 0 and sensor.rest == 0:
        return frames
    rest = np.asarray(sensor.rest)
    whole = frames.dtype.kind in "iu" and np.all(rest == np.round(rest)) and frames.dtype.itemsize < 8
    kind = np.int64 if whole and frames.dtype.itemsize == 4 else np.int32 if whole else np.float64
    rest = rest.astype(kind)
    values = frames.astype(kind)
    above: NDArray[Any] = values - rest if sensor.polarity == "up" else rest - values
    return above


def _check_polarity(frames: NDArray[Any], pad: Pad, recording: Recording, sensor: Sensor) -> None:
    usable = pad.usable
    first = frames[0][usable].astype(np.float64)
    chosen = frames[np.unique(np.linspace(0, len(frames) - 1, 256).astype(np.intp))][:, usable]
    highest, lowest = float(chosen.max()), float(chosen.min())
    change = chosen.astype(np.float64) - first
    back, on = -change.sum(where=change < 0), change.sum(where=change > 0)
    turned = back > _BACK * on and back > 0
    # Either everything starts loaded and only ever lets go, or nearly all stands below rest.
    loaded = first.min() > _AWAY * highest > 0 and turned
    below = -lowest > _BACK * max(highest, 0.0) and turned and np.median(chosen) <= 0
    if not (loaded or below):
        return
    other = "down" if sensor.polarity == "up" else "up"
    rest = f"{sensor.rest:g}" if np.ndim(sensor.rest) == 0 else "given by taxel"
    raise InputError(
        f"{_file(sensor)}says polarity {sensor.polarity!r} with rest {rest}, but the readings of "
        f"{recording.source or 'the recording'} start near {np.median(pad.frames[0][usable]):g} and go the other way "
        f"under load; polarity = {other!r} with that rest would be right"
    )


def _file(sensor: Sensor) -> str:
    return f"{sensor.source}: " if sensor.source else f"the sensor {sensor.name or 'file'} "
