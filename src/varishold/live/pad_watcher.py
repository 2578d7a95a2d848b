"""One pad, watched: its readings with the sensor undone and zero at rest, and what touches it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame.floor import FLOOR_SIGMAS
from varishold.frame.health_report import BadTaxel, HealthReport, Word
from varishold.frame.noise import ROUNDING
from varishold.frame.running_flicker import RunningFlicker
from varishold.frame.running_health import TaxelHealth
from varishold.frame.running_open_line import RunningOpenLine
from varishold.frame.running_sign import RunningSign
from varishold.frame.running_silence import RunningSilence
from varishold.frame.running_spoilt import RunningSpoilt
from varishold.frame.zero import FollowingZero, Zeroing
from varishold.levelset.contact import Contact, with_losses
from varishold.live.pad_faults import PadFaults
from varishold.live.sample import PadLayout
from varishold.live.since import since
from varishold.recording import pascals_per_unit
from varishold.sensor import Sensor
from varishold.sensor.words import sensor_name, undone_words
from varishold.touch import Answer, find_contacts
from varishold.touch.caution import told_unknown, unsure_of_smoothed, unsure_of_way
from varishold.touch.tracking.event import Event
from varishold.touch.tracking.track import Track
from varishold.touch.tracking.tracker import ContactTracker

__all__ = ["PadWatcher", "SeenPad"]

Floats = NDArray[np.float64]

# Words for signals.
_OF_SIGNALS = ("stuck", "impulses", "no number")
# The noise is asked for anew after so many frames.
_NOISE_FRAMES = 16
# Where readings fall, what rises is what was let go of.
_CAUTIONS_OF_WAY = {"rise": (), "may fall": (unsure_of_way,), "fall": (told_unknown,)}
_SILENT = "all taxels show one and the same value: the pad says nothing"


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
    zeroings : tuple of Zeroing
        The zeros that were taken or refused.
    sigma : float or None
        Standard deviation of the noise, in the frame's unit.
    works : ndarray of shape (rows, cols), bool, or None
        Which taxels are believed in this reading; None where all are.
    unit : str
        Of the frame.
    notes : tuple of str
        What was done to the readings: what the sensor file says, and the remarks.
    remarks : tuple of str
        What is odd about the readings, and what was done about it.
    is_news : bool
        Whether the remarks are others than before.
    """

    name: str
    layout: PadLayout
    raw: NDArray[Any]
    zeroed: Floats
    frame: Floats
    tracks: tuple[Track, ...] = ()
    events: tuple[Event, ...] = ()
    zeroings: tuple[Zeroing, ...] = ()
    sigma: float | None = None
    works: NDArray[np.bool_] | None = None
    unit: str = "raw"
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    is_news: bool = False
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
    whole : bool
        Whether the readings are whole numbers: they have rounding's noise at least.

    Attributes
    ----------
    sound : ndarray of shape (rows, cols), bool
        Where taxels work, as the source says.
    zero : FollowingZero
    health : TaxelHealth

    Raises
    ------
    InputError
        If the sensor is another's than the pad's.
    """

    def __init__(
        self, name: str, layout: PadLayout, *, sensor: Sensor | None = None, levels: int = 32, whole: bool = False
    ) -> None:
        self.name, self.layout = name, layout
        self.shape = grid_of(layout.shape)
        self._levels = levels
        self._given, self._left = _sensor_of(name, self.shape, layout, sensor)
        self.sound = _mask(self.shape, layout.broken)
        self.zero = FollowingZero(
            self.shape,
            field=self.field,
            valid=self.sound,
            least_noise=ROUNDING if whole else None,
            follows=layout.kind == "pressure",
        )
        self.health = TaxelHealth(self.shape, field=self.field, valid=self.sound)
        rises = layout.polarity == "up" if self._given is None else self._given.polarity == "up"
        usable, is_told = self.sound & self.field, self._given is not None or not rises
        self._sign = RunningSign(usable)
        self._silence = RunningSilence(usable, rises=rises)
        self._spoilt = RunningSpoilt(usable)
        self._flicker = RunningFlicker(usable)
        self._line = RunningOpenLine(usable)
        self._faults = PadFaults(usable, self.zero, self.health, rises=rises, way_is_told=is_told)
        self._tracker = ContactTracker(pad=name, pascals_per_unit=pascals_per_unit(self.unit))
        self._last_zeroing: Zeroing | None = None
        self._remarks: tuple[str, ...] = ()
        self._all_sound, self._everywhere = bool(self.sound.all()), bool(self.field.all())
        self._noise: float
        self._noise_age = _NOISE_FRAMES

    def see(self, time_s: float, raw: NDArray[Any]) -> SeenPad:
        """Return what is seen in the pad's next reading; its shape is the layout's."""
        values = raw.reshape(self.shape)
        if self.layout.kind == "pressure":
            had_signs = self._sign.bits is not None
            values = self._sign.update(values)
            if self._sign.bits is not None and not had_signs:
                # What came so far was read without signs.
                self.zero.restart()
        # Of signals one may be alike by chance.
        shown = values if self.layout.kind == "signals" else self._spoilt.update(self._silence.update(values))
        silent = self._silence.lasts
        zeroed = np.zeros(self.shape) if silent else self.zero.update(time_s, self._steady(time_s, shown))
        self.health.update(time_s, values, touched=self.zero.is_pressed)
        frame, found = zeroed, dict[str, Any]()
        starts, is_felt = self.zero.state == "starting", self.layout.kind != "signals"
        if is_felt:
            noise = 0.0 if starts else self._sigma()
            if not silent:
                self._faults.look_which_way(time_s, noise)
        # Before there is a zero nothing can be told from the rest.
        if is_felt and not starts:
            self._faults.update(time_s, zeroed, noise)
            saturated = self._faults.saturated(values, zeroed)
            felt, beyond, works = self._felt(zeroed)
            contacts, sigma = self._contacts(felt, works, noise)
            if contacts:
                if saturated is not None and not (self._left is not None and self._left.tells_saturation):
                    contacts = with_losses(contacts, saturated=saturated)
                frame = contacts[0].frame.padded[1:-1, 1:-1]
            else:
                frame = self._undone(felt, beyond)
                for wrong in (self._faults.broken, self._faults.stuck):
                    frame = frame if wrong is None else np.where(wrong, 0.0, frame)
            events = self._tracker.update(time_s, contacts, frame)
            found = {"tracks": self._tracks(), "events": tuple(events), "sigma": sigma, "works": works}
        words = (
            *self._sign.words(),
            *self._spoilt.words(),
            *self._flicker.words(),
            *self._line.words(),
            *self._faults.words(),
        )
        remarks = (*words, _SILENT) if silent else words
        is_news, self._remarks = remarks != self._remarks, remarks
        return SeenPad(
            name=self.name,
            layout=self.layout,
            raw=raw,
            zeroed=zeroed,
            frame=frame,
            zeroings=self._new_zeroings(),
            unit=self.unit,
            notes=(*self._notes, *remarks),
            remarks=remarks,
            is_news=is_news,
            sensor=self._sensor_name,
            **found,
        )

    def _steady(self, time_s: float, shown: NDArray[Any]) -> NDArray[Any]:
        """Return readings upright, what flickers as those beside it, which is known where there is a zero."""
        upright = self._upright(shown)
        if self.layout.kind != "pressure" or self.zero.state == "starting":
            return upright
        rest, sigma = self.zero.baseline, self._sigma()
        return self._flicker.update(time_s, self._line.update(time_s, upright, rest, sigma), rest, sigma)

    @property
    def wrong_way(self) -> str | None:
        """Why nothing felt here is named: its readings fall where something presses; None where it is."""
        return self._faults.way_words()

    def end(self, time_s: float) -> tuple[Event, ...]:
        """Release what touches: no reading comes any more."""
        return tuple(self._tracker.end(time_s))

    def ask_zero(self, time_s: float) -> Zeroing | None:
        """Take the zero anew from now on; return the refusal where something presses."""
        return self.zero.ask(time_s)

    def how_it_is(self) -> HealthReport:
        """Return how the taxels are; of signals, which have units of their own, only what needs no comparison."""
        report = self.health.report()
        if self.layout.kind == "pressure":
            seen = [*_bad("sticks", self._faults.stuck), *_bad("flickers", self._flicker.flickering)]
            return replace(report, bad=(*report.bad, *seen)) if seen else report
        bad = tuple(taxel for taxel in report.bad if taxel.word in _OF_SIGNALS)
        return replace(report, bad=bad, open_rows=(), open_cols=())

    def _felt(self, zeroed: Floats) -> tuple[Floats, NDArray[np.bool_] | None, NDArray[np.bool_] | None]:
        """Return zeroed readings, which stand for no number, and which are believed; None where none does, and all are.

        Where no reading is left that stands for a number nothing is felt.
        """
        beyond = None if self._left is None else self._left.beyond(zeroed).reshape(self.shape)
        if beyond is None or not beyond.any():
            return zeroed, None, self._believed(None)
        works = self._believed(beyond)
        return (np.zeros(self.shape), None, None) if works is None else (zeroed, beyond, works)

    def _believed(self, beyond: NDArray[np.bool_] | None) -> NDArray[np.bool_] | None:
        """Return which taxels are believed in this reading; None where all are, or none is."""
        works = None if self._all_sound else self.sound
        faults, moves = self._faults, self._flicker.flickering
        for wrong in (self.zero.wrong, beyond, faults.broken, faults.stuck, moves, self._line.open):
            if wrong is not None:
                works = (self.sound if works is None else works) & ~wrong
        return None if works is None or not works.any() else works

    def _contacts(self, zeroed: Floats, works: NDArray[np.bool_] | None, sigma: float) -> tuple[list[Contact], float]:
        left = self._left
        pitch, field = self.layout.pitch_m, None if self._everywhere else self.field
        if left is None:
            if not float(zeroed.max()) > FLOOR_SIGMAS * sigma:
                return [], sigma
            frame = self._faults.up_to_end(zeroed)
            return find_contacts(frame, self._levels, pitch=pitch, valid=works, field=field, sigma=sigma), sigma
        sigma = left.least_stress(sigma)
        field = None if left.resampling is not None else field
        found = find_contacts(zeroed, self._levels, pitch=pitch, valid=works, field=field, sigma=sigma, sensor=left)
        return found, sigma

    def _tracks(self) -> tuple[Track, ...]:
        """Return what touches now, its names no surer than the readings let them be."""
        tracks = self._tracker.tracks
        cautions = list(_CAUTIONS_OF_WAY[self._faults.which_way])
        if self._faults.smoothed:
            cautions.append(unsure_of_smoothed)
        for caution in cautions:
            tracks = tuple(
                track if track.answer is None else replace(track, answer=caution(track.answer)) for track in tracks
            )
        return tracks

    def _sigma(self) -> float:
        """Return the noise of the usual taxel, in the readings' unit; it changes slowly."""
        if self._noise_age >= _NOISE_FRAMES:
            self._noise, self._noise_age = float(np.median(self.zero.noise[self.field])), 0
        self._noise_age += 1
        return self._noise

    def _undone(self, zeroed: Floats, beyond: NDArray[np.bool_] | None) -> Floats:
        if self._left is None:
            return zeroed
        return self._left.undo(zeroed, valid=None if beyond is None else ~beyond).frame

    def _new_zeroings(self) -> tuple[Zeroing, ...]:
        new = tuple(since(self.zero.log, self._last_zeroing))
        if new:
            self._last_zeroing = new[-1]
        return new

    @cached_property
    def pitch_m(self) -> tuple[float, float] | None:
        """Row and column spacing, metres, as the source or the sensor says."""
        return self.layout.pitch_m or (None if self._given is None else self._given.pitch_m)

    @cached_property
    def field(self) -> NDArray[np.bool_]:
        """Where there are taxels, shape (rows, cols)."""
        told = None if self._given is None else self._given.field
        return _mask(self.shape, self.layout.gaps) if told is None else told

    @cached_property
    def unit(self) -> str:
        """Unit of the readings with the sensor undone."""
        return self.layout.unit if self._given is None or self._given.unit.lower() == "raw" else self._given.unit

    @cached_property
    def _sensor_name(self) -> str | None:
        return None if self._given is None else sensor_name(self._given)

    @cached_property
    def _notes(self) -> tuple[str, ...]:
        return () if self._given is None else (f"sensor {sensor_name(self._given)}", *undone_words(self._given))

    def _upright(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return readings that go up with pressure."""
        if self._given is None and self.layout.polarity == "up":
            return values
        # What is no number stays none.
        with np.errstate(invalid="ignore", over="ignore"):
            readings = np.array(values, dtype=np.float64)
            if self._given is not None:
                return readings - self._given.rest if self._given.polarity == "up" else self._given.rest - readings
            return -readings


def _bad(word: Word, taxels: NDArray[np.bool_] | None) -> list[BadTaxel]:
    return [] if taxels is None else [BadTaxel(row, col, word, {}) for row, col in np.argwhere(taxels).tolist()]


def _mask(shape: tuple[int, int], but: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return a mask that is True but at some places, which count row by row."""
    mask = np.ones(shape, np.bool_)
    if but and not 0 <= min(but) <= max(but) < mask.size:
        raise InputError(f"places of taxels must be 0 to {mask.size - 1}, got {min(but)} to {max(but)}")
    mask.flat[list(but)] = False
    return mask


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
