"""``replay:FILE`` a recording, as if it were measured now."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.pace import Pace
from varishold.live.sample import PadLayout, Sample
from varishold.live.source import Source
from varishold.live.sources.kind import SourceKind
from varishold.live.unsaid import Reading, places
from varishold.recording import Pad, Recording, read
from varishold.recording.formats.mcap import is_measured

__all__ = ["KIND", "Replayed"]


class Replayed:
    """A recording that is played.

    Parameters
    ----------
    address : str
    file : str
        A file or folder of any format that `varishold.recording.read` reads.
    speed : float
        Its seconds in one of ours; 0 for as fast as it goes.
    rate_hz : float
        Frames a second, where the file does not say when each was measured.
    loop : bool
        Whether it begins again at its end; its time goes on.
    reading : Reading, optional
        What the file leaves unsaid.
    """

    def __init__(
        self, address: str, file: str, *, speed: float, rate_hz: float, loop: bool, reading: Reading | None = None
    ) -> None:
        self._address, self._file = address, file
        self._rate_hz, self._loop = rate_hz, loop
        self._reading = reading or Reading()
        self._pace = Pace(speed)
        self._recording: Recording | None = None
        self._pads: dict[str, PadLayout] = {}
        self._next = 0

    @property
    def address(self) -> str:
        return self._address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._pads

    def open(self) -> None:
        if self._recording is None:
            how = self._reading
            self._recording = read(self._file, shape=how.shape, pitch_m=how.pitch_m, polarity=how.polarity)
            self._due_s = _due_s(self._recording, self._rate_hz)
            # From the last frame to the first it takes as long as between others.
            step_s = float(np.median(np.diff(self._due_s))) if len(self._due_s) > 1 else 1 / self._rate_hz
            self._turn_s = float(self._due_s[-1]) + step_s
            # Plain arrays: a part of what is mapped from a file costs more.
            self._frames = {name: np.asarray(pad.frames) for name, pad in self._recording.pads.items()}
            self._count = self._recording.n_frames
            unit = self._recording.unit
            self._pads = {name: _layout(pad, unit) for name, pad in self._recording.pads.items()}
        self._next = 0
        self._pace.restart()

    def read(self, timeout_s: float) -> list[Sample]:
        if self._recording is None:
            raise LostSourceError(f"{self._address}: is not open")
        count = self._count
        if self._next >= count and not self._loop:
            raise EndOfSourceError(f"{self._address}: {counted(count, 'frame')}, all of the file")
        due = self._pace.due(self._due, self._next, self._next + count if self._loop else count, timeout_s)
        samples = [self._sample(self._recording, number) for number in range(self._next, due)]
        self._next = due
        return samples

    def close(self) -> None:
        """Nothing is held open but what the recording maps, which is kept for the next time."""

    def _due(self, number: int) -> float:
        """Return when a frame is due, seconds since the beginning; where it loops, numbers go on."""
        turn, frame = divmod(number, len(self._due_s))
        return float(self._due_s[frame]) + turn * self._turn_s

    def _sample(self, recording: Recording, number: int) -> Sample:
        (turn, frame), due_s = divmod(number, self._count), self._due(number)
        pads = {name: np.array(frames[frame]) for name, frames in self._frames.items()}
        device_s = None
        if recording.time_s is not None:
            device_s = float(recording.time_s[frame]) + turn * self._turn_s
        return Sample(device_s, self._pace.host_time_s(due_s), number, pads)


def _layout(pad: Pad, unit: str) -> PadLayout:
    return PadLayout(
        pad.shape,
        pitch_m=pad.pitch_m,
        unit=unit,
        polarity=pad.polarity,
        gaps=places(pad.field),
        broken=places(pad.valid),
    )


def _due_s(recording: Recording, rate_hz: float) -> NDArray[np.float64]:
    """Return when each frame is due, from 0 on; one whose time goes back is due at once."""
    if recording.time_s is None:
        return np.arange(recording.n_frames) / rate_hz
    return np.maximum.accumulate(recording.time_s - recording.time_s[0])


def _make(address: Address) -> Source:
    address.only("speed", "rate_hz", "loop", "shape", "pitch_m", "polarity")
    # A recording may be a folder.
    path = Path(address.place)
    if not address.place or not path.exists():
        raise InputError(f"{address.text}: there is no file {address.place!r}")
    polarity = address.options.get("polarity", "up")
    if polarity not in ("up", "down"):
        raise InputError(f"{address.text}: polarity must be up or down, got {polarity!r}")
    pitch_m = address.number("pitch_m", 0.0, least=1e-9, most=1e3) if "pitch_m" in address.options else None
    reading = Reading(address.shape(), pitch_m, "down" if polarity == "down" else "up")
    speed = address.number("speed", 1.0, least=0, most=1e6)
    rate_hz = address.number("rate_hz", 100.0, least=1e-3, most=1e6)
    loop = bool(address.whole("loop", 0, least=0, most=1))
    if path.is_file() and is_measured(path):
        from varishold.live.sources.measured import Measured

        return Measured(address.text, address.place, speed=speed, loop=loop, reading=reading)
    return Replayed(address.text, address.place, speed=speed, rate_hz=rate_hz, loop=loop, reading=reading)


KIND = SourceKind("a recording, played again", "replay:FILE?speed=1", _make)
