"""One pad, watched: its readings with the sensor undone and zero at rest, and what touches it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.live.sample import PadLayout
from varishold.live.stand_in import ContactTracker, Event, FollowingZero, Track
from varishold.recording import pascals_per_unit
from varishold.sensor import Sensor
from varishold.sensor.words import sensor_name, undone_words
from varishold.touch import Answer, find_contacts

__all__ = ["PadWatcher", "SeenPad"]

Floats = NDArray[np.float64]

# Far beyond any pressure in any unit: such a reading is none.
_LARGEST = 1e30


@dataclass(frozen=True, eq=False)
class SeenPad:
    """What was seen on one pad in one reading.

    Parameters
    ----------
    name : str
    layout : PadLayout
    raw : ndarray
        As it came.
    zeroed : ndarray of shape (rows, cols), float64
        Upright and zero at rest, in the readings' unit; (1, n) of signals and of taxels on no grid.
    frame : ndarray of shape (rows, cols), float64
        The same with the sensor undone: where contacts are looked for.
    tracks : tuple of Track
        What touches now.
    events : tuple of Event
        What happened.
    sigma : float or None
        Standard deviation of the noise, in the frame's unit.
    unit : str
        Of the frame.
    """

    name: str
    layout: PadLayout
    raw: NDArray[Any]
    zeroed: Floats
    frame: Floats
    tracks: tuple[Track, ...] = ()
    events: tuple[Event, ...] = ()
    sigma: float | None = None
    unit: str = "raw"
    notes: tuple[str, ...] = ()
    sensor: str | None = None

    def answer(self, track: Track, *, number: int, time_s: float) -> Answer | None:
        """Return what touch says of a track by all that was seen of it; None while too little was.

        Parameters
        ----------
        track : Track
        number : int
            Running number of the reading.
        time_s : float
            Its time.
        """
        if track.answer is None:
            return None
        return Answer(
            file=None,
            frame=number,
            time_s=time_s,
            pad=self.name,
            contact=track.number,
            surface=track.answer,
            unit=self.unit,
            pascals_per_unit=pascals_per_unit(self.unit),
            pitch_m=track.contact.pitch,
            sensor=self.sensor,
            frame_notes=self.notes,
        )


class PadWatcher:
    """Watches one pad; one thread's only.

    Parameters
    ----------
    name : str
    layout : PadLayout
    sensor : Sensor, optional
        What made the readings.
    levels : int
        Thresholds a contact.

    Raises
    ------
    InputError
        If the sensor is another's than the pad's.
    """

    def __init__(self, name: str, layout: PadLayout, *, sensor: Sensor | None = None, levels: int = 32) -> None:
        self.name, self.layout = name, layout
        self.shape = grid_of(layout.shape)
        self.zero = FollowingZero(self.shape, field=None if sensor is None else sensor.field)
        self._levels = levels
        self._given, self._left = _sensor_of(name, self.shape, layout, sensor)
        self._tracker = ContactTracker(pad=name, pascals_per_unit=pascals_per_unit(self._unit))
        self._good = np.zeros(self.shape)

    def see(self, time_s: float, raw: NDArray[Any]) -> SeenPad:
        """Return what is seen in the pad's next reading; its shape is the layout's."""
        readings, works = self._upright(raw)
        zeroed = self.zero.update(time_s, readings)
        if self.layout.kind == "signals":
            return SeenPad(self.name, self.layout, raw, zeroed, zeroed, unit=self.layout.unit)
        sigma = self.zero.sigma
        left = self._left
        if left is not None and sigma is not None:
            sigma = left.least_stress(sigma)
        field = None if left is not None and left.resampling is not None else self.field
        contacts = find_contacts(
            zeroed, self._levels, pitch=self.layout.pitch_m, valid=works, field=field, sigma=sigma, sensor=left
        )
        if contacts:
            frame = contacts[0].frame.padded[1:-1, 1:-1]
        else:
            frame = zeroed if left is None else left.undo(zeroed, valid=works).frame
        events = self._tracker.update(time_s, contacts, frame)
        return SeenPad(
            name=self.name,
            layout=self.layout,
            raw=raw,
            zeroed=zeroed,
            frame=frame,
            tracks=self._tracker.tracks,
            events=tuple(events),
            sigma=sigma,
            unit=self._unit,
            notes=self._notes,
            sensor=None if self._given is None else sensor_name(self._given),
        )

    @cached_property
    def field(self) -> NDArray[np.bool_]:
        """Where there are taxels, shape (rows, cols)."""
        told = None if self._given is None else self._given.field
        return np.ones(self.shape, np.bool_) if told is None else told

    @cached_property
    def _unit(self) -> str:
        return self.layout.unit if self._given is None or self._given.unit.lower() == "raw" else self._given.unit

    @cached_property
    def _notes(self) -> tuple[str, ...]:
        return () if self._given is None else (f"sensor {sensor_name(self._given)}", *undone_words(self._given))

    def _upright(self, raw: NDArray[Any]) -> tuple[Floats, NDArray[np.bool_] | None]:
        """Return readings that go up with pressure, the last good one where one is no number, and which are good."""
        readings = np.array(raw, dtype=np.float64).reshape(self.shape)
        if self._given is not None:
            readings = readings - self._given.rest if self._given.polarity == "up" else self._given.rest - readings
        elif self.layout.polarity == "down":
            readings = -readings
        works = np.abs(readings) < _LARGEST
        if works.all():
            self._good = readings
            return readings, None
        readings = self._good = np.where(works, readings, self._good)
        return readings, works if works.any() else None


def grid_of(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return rows and columns; one row where there is no grid."""
    return (1, shape[0]) if len(shape) == 1 else (shape[0], shape[1])


def _sensor_of(
    name: str, shape: tuple[int, int], layout: PadLayout, sensor: Sensor | None
) -> tuple[Sensor | None, Sensor | None]:
    """Return a pad's sensor, and what is left of it to be undone once the readings stand upright."""
    if sensor is None or layout.kind == "signals":
        return None, None
    expected = sensor.readings_shape
    if expected is not None and expected != shape:
        raise InputError(
            f"{sensor.source or sensor.name or 'the sensor'} is for {expected[0]} x {expected[1]} taxels, pad {name!r} "
            f"has {shape[0]} x {shape[1]}"
        )
    return sensor, sensor.upright()
