"""Recordings seen through a sensor file: the rest taken off, readings turned upright, what is unsaid filled in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require_a
from varishold.frame.checks import as_usable
from varishold.frame.fault import pieces_at
from varishold.frame.polarity import find_fall
from varishold.frame.spread import spread_over
from varishold.recording import Pad, Recording
from varishold.recording.mended import stored_without_faults, without_faults
from varishold.recording.pad import far_apart, of_pad
from varishold.recording.stored import Column, Stored, StoredPad
from varishold.sensor.model import Sensor

__all__ = [
    "faults_beside",
    "misplaced",
    "other_pitches",
    "placed_by",
    "upright_recording",
    "upright_stored",
    "wrong_way",
]

# Readings go the wrong way where at the start every taxel is this share of the range away from its rest ...
_AWAY = 0.25
# ... and what changes afterwards goes back so many times as much as on.
_BACK = 2.0
# A pitch is another one where it differs by more than this share of it.
_SAME_PITCH = 0.01
# Frames that are looked at to see which way they go.
_LOOKED_AT = 256


def placed_by(pad: Pad, sensor: Sensor | None) -> Sensor | None:
    """Return a pad's sensor, with the places of its taxels where the pad says them: it knows best.

    Raises
    ------
    InputError
        If no taxels can stand there.
    """
    if pad.positions_m is None:
        return sensor
    known = sensor or Sensor()
    return replace(known, positions_m=pad.positions_m, shape=None, field=None, pitch_m=pad.pitch_m or known.pitch_m)


def misplaced(recording: Recording, sensor: Sensor | None) -> tuple[str, ...]:
    """Return in words where taxels cannot stand as a recording or its sensor says, or hardly: far from each other.

    Parameters
    ----------
    recording : Recording
    sensor : Sensor or None

    Examples
    --------
    >>> misplaced(Recording({"pad": Pad(np.ones((2, 1, 3)), positions_m=[[0, 0], [1, 0], [0, 1]])}), None)
    ('taxels are 1 m apart: are positions_m in millimetres?',)
    """
    found = [] if sensor is None else other_pitches(recording, sensor)
    for name, pad in recording.pads.items():
        which = of_pad(name)
        found += [f"{which}{words}" for words in far_apart(pad.pitch_m, pad.positions_m)]
        if sensor is not None and pad.pitch_m is None and pad.positions_m is None:
            found += far_apart(sensor.pitch_m, sensor.positions_m)
        try:
            placed = placed_by(pad, sensor)
            _ = None if placed is None else placed.resampling
        except InputError as error:
            found.append(f"{which}{error}")
    return tuple(dict.fromkeys(found))


def faults_beside(recording: Recording, sensor: Sensor | None) -> tuple[str, ...]:
    """Return in words what is wrong with a recording's places and readings beside what its sensor is said to be."""
    return (*misplaced(recording, sensor), *wrong_way(recording, sensor))


def other_pitches(recording: Recording, sensor: Sensor) -> list[str]:
    """Return in words which pads have another pitch by the recording than by their sensor; the recording's is taken.

    Examples
    --------
    >>> other_pitches(Recording({"pad": Pad(np.ones((2, 3, 3)), pitch_m=5e-3)}), Sensor(pitch_m=(4e-3, 5e-3)))
    ['taxels are 5 mm apart by the recording, which is taken, and 4 x 5 mm by the sensor']
    """
    found = []
    for name, pad in recording.pads.items():
        which = of_pad(name)
        if pad.pitch_m is None or sensor.pitch_m is None or np.allclose(pad.pitch_m, sensor.pitch_m, _SAME_PITCH, 0.0):
            continue
        here, there = (
            " x ".join(f"{1e3 * each:.4g}" for each in dict.fromkeys(p)) for p in (pad.pitch_m, sensor.pitch_m)
        )
        found.append(
            f"{which}taxels are {here} mm apart by the recording, which is taken, and {there} mm by "
            f"{sensor.source or sensor.name or 'the sensor'}"
        )
    return found


def wrong_way(recording: Recording, sensor: Sensor | None) -> tuple[str, ...]:
    """Return in words which pads' readings go another way than is said, so that `upright_recording` refuses them.

    Parameters
    ----------
    recording : Recording
        Raw readings. Of a pad whose own polarity is down nothing is said without a sensor.
    sensor : Sensor or None
        What made them.

    Examples
    --------
    >>> y, x = np.mgrid[-6:7, -6:7]
    >>> falling = 250 - np.repeat([0.0, 20.0, 60.0], 4)[:, None, None] * np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> wrong_way(Recording({"pad": Pad(falling)}), Sensor(polarity="down", rest=250.0))
    ()
    >>> wrong_way(Recording({"pad": Pad(falling)}), None)[0][:65]
    "readings of pad 'pad' fall where something presses, from about 25"
    """
    found = []
    for name, pad in recording.pads.items():
        try:
            if sensor is not None:
                _upright_pad(recording, name, pad, sensor)
            elif pad.polarity == "up":
                _check_rises(pad.frames, pad.usable, pad.polarity, name, "")
        except InputError as error:
            found.append(str(error))
    return tuple(dict.fromkeys(found))


def upright_recording(recording: Recording, sensor: Sensor | None) -> Recording:
    """Return a recording whose readings are zero at rest and go up with pressure, without glitches.

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
        If the shapes differ, or the readings go the other way than the sensor says, or fall where something presses and
        no sensor says so.
    """
    require_a(Recording, recording, "recording", "as read(path) gives it, or Recording({'pad': Pad(frames)})")
    if sensor is None:
        for name, pad in recording.pads.items():
            _check_rises(pad.frames, pad.usable, pad.polarity, name, recording.source)
        return without_faults(recording)
    pads = {name: _upright_pad(recording, name, pad, sensor) for name, pad in recording.pads.items()}
    return without_faults(replace(recording, pads=pads, sensor=recording.sensor or sensor.name))


def upright_stored(stored: Stored, sensor: Sensor | None, *, checked: bool = False) -> Stored:
    """Return a recording in its file as `upright_recording` would: each block is turned as it is read.

    Parameters
    ----------
    stored : Stored
        Raw readings.
    sensor : Sensor or None
        What made them; None where they are upright already.
    checked : bool
        Whether it is known already that they go the way that the sensor says.

    Raises
    ------
    InputError
        As `upright_recording`.
    """
    if sensor is None:
        for name, pad in stored.pads.items() if not checked else ():
            chosen = _some(pad.frames)
            usable = as_usable(chosen, chosen.shape[1:], pad.field, pad.valid)
            _check_rises(chosen, usable, pad.polarity, name, stored.source)
        return stored_without_faults(stored)
    pads = {name: _upright_stored(stored, name, pad, sensor, checked) for name, pad in stored.pads.items()}
    return stored_without_faults(replace(stored, pads=pads, sensor=stored.sensor or sensor.name))


@dataclass(frozen=True)
class _Upright:
    """A column of frames that are turned as they are read."""

    source: Column
    sensor: Sensor

    @property
    def shape(self) -> tuple[int, ...]:
        return self.source.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return _upright(np.empty((0, *self.shape[1:]), self.source.dtype), self.sensor).dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        return _upright(np.asarray(self.source[wanted]), self.sensor)


def _upright_stored(stored: Stored, name: str, pad: StoredPad, sensor: Sensor, checked: bool) -> StoredPad:
    frames = pad.frames
    _check_shape(frames.shape[1:], name, stored.source, sensor)
    turned = _Upright(frames, sensor)
    if not checked:
        chosen = _some(turned)
        usable = as_usable(chosen, chosen.shape[1:], pad.field, pad.valid)
        _check_polarity(chosen, np.asarray(frames[0:1])[0], usable, stored.source, sensor)
    field, valid, pitch_m = _told(pad, sensor)
    return StoredPad(turned, pad.called, field, valid, pitch_m, pad.positions_m, notes=pad.notes)


def _upright_pad(recording: Recording, name: str, pad: Pad, sensor: Sensor) -> Pad:
    _check_shape(pad.shape, name, recording.source, sensor)
    frames = _upright(pad.frames, sensor)
    _check_polarity(frames[spread_over(len(frames), _LOOKED_AT)], pad.frames[0], pad.usable, recording.source, sensor)
    field, valid, pitch_m = _told(pad, sensor)
    try:
        return Pad(frames, field=field, valid=valid, pitch_m=pitch_m, positions_m=pad.positions_m, notes=pad.notes)
    except InputError as error:
        if np.median(frames[:, pad.usable]) >= 0:
            raise
        raise InputError(
            f"{_file(sensor)}says rest {_rest_words(sensor)}, but {recording.source or 'the recording'} lies "
            f"{'below' if sensor.polarity == 'up' else 'above'} that nearly everywhere, its first frame near "
            f"{np.median(pad.frames[0][pad.usable]):g}: give the readings without load"
        ) from error


def _check_shape(shape: tuple[int, ...], name: str, source: str, sensor: Sensor) -> None:
    expected = sensor.readings_shape
    if expected is not None and shape != expected:
        raise InputError(
            f"{_file(sensor)}is for {expected[0]} x {expected[1]} taxels, pad {name!r} of "
            f"{source or 'the recording'} has {shape[0]} x {shape[1]}"
        )


def _told(
    pad: Pad | StoredPad, sensor: Sensor
) -> tuple[NDArray[np.bool_] | None, NDArray[np.bool_] | None, tuple[float, float] | None]:
    """Return field, valid and pitch, each the pad's own where it knows it."""
    broken, valid = sensor.broken, pad.valid
    if broken is not None:
        valid = ~broken if valid is None else valid & ~broken
    return sensor.field if pad.field is None else pad.field, valid, pad.pitch_m or sensor.pitch_m


def _some(frames: Column) -> NDArray[Any]:
    return np.concatenate(list(pieces_at(frames, spread_over(frames.shape[0], _LOOKED_AT).tolist())))


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


def _check_polarity(
    upright: NDArray[Any], raw: NDArray[Any], usable: NDArray[np.bool_], source: str, sensor: Sensor
) -> None:
    """Refuse frames, the first among them, that go the other way than the sensor says; `raw` is the first unturned."""
    chosen = upright[:, usable]
    first = chosen[0].astype(np.float64)
    highest, lowest = float(chosen.max()), float(chosen.min())
    change = chosen.astype(np.float64) - first
    back, on = -change.sum(where=change < 0), change.sum(where=change > 0)
    turned = back > _BACK * on and back > 0
    # Either everything starts loaded and only ever lets go of a good part, or nearly all stands below rest.
    loaded = first.min() > _AWAY * highest > 0 and turned and -change.min() > _AWAY * highest
    below = -lowest > _BACK * max(highest, 0.0) and turned and np.median(chosen) <= 0
    if not (loaded or below):
        return
    other = "down" if sensor.polarity == "up" else "up"
    raise InputError(
        f"{_file(sensor)}says polarity {sensor.polarity!r} with rest {_rest_words(sensor)}, but the readings of "
        f"{source or 'the recording'} start near {np.median(raw[usable]):g} and go the other way "
        f"under load; polarity = {other!r} with that rest would be right"
    )


def _rest_words(sensor: Sensor) -> str:
    return f"{sensor.rest:g}" if np.ndim(sensor.rest) == 0 else "given by taxel"


def _check_rises(frames: NDArray[Any], usable: NDArray[np.bool_], polarity: str, name: str, source: str) -> None:
    """Refuse readings that fall under pressure: without a sensor nobody turns them."""
    where = f"{source}: " if source else ""
    if polarity == "down":
        raise InputError(f"{where}smaller readings mean more pressure here; give a sensor file, which turns them")
    fall = find_fall(frames, usable)
    if fall is not None:
        raise InputError(
            f"{where}readings of pad {name!r} fall where something presses, from about {fall.rest:.4g} to "
            f"{fall.pressed:.4g}: give a sensor file that says polarity = 'down' and rest = {fall.rest:.4g}; "
            "where they do not fall, mark failed taxels in valid, or say polarity = 'up'"
        )


def _file(sensor: Sensor) -> str:
    return f"{sensor.source}: " if sensor.source else f"the sensor {sensor.name or 'file'} "
