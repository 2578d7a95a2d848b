"""A recording as a worker has it open: upright, its frames still in the file, and the same blocks for everybody."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from varishold.corpus.content import files_of
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.recording.formats import open_stored
from varishold.recording.stored import Stored, stored_of
from varishold.sensor.finding import sensor_for
from varishold.sensor.model import Sensor
from varishold.sensor.recordings import upright_stored

__all__ = ["Opened", "Reading", "Stamp", "open_recording", "stamp_of"]

# Names, sizes and times of change of a recording's files.
Stamp = tuple[tuple[str, int, int], ...]


@dataclass(frozen=True)
class Reading:
    """How recordings are read.

    Parameters
    ----------
    sensor : str or None
        A sensor file or a preset's name. Default: the one beside each recording, or inside it.
    shape : (int, int) or None
        Rows and columns, where files do not say them.
    pitch_m : float or None
    """

    sensor: str | None = None
    shape: tuple[int, int] | None = None
    pitch_m: float | None = None


@dataclass(frozen=True, eq=False)
class Opened:
    """An open recording.

    Parameters
    ----------
    stored : Stored
        Upright.
    sensor : Sensor or None
        What is to be undone of it.
    stamp : Stamp
        By which a change of the file is seen.
    """

    stored: Stored
    sensor: Sensor | None
    stamp: Stamp

    def whole(self) -> Recording:
        """Return all of it, checked as a whole; what would take much memory is mapped from a temporary file."""
        return self.stored.whole()

    def kept(self, whole: Recording) -> Opened:
        """Return it with the frames where they are now, so that nothing is read twice."""
        self.stored.close()
        return replace(self, stored=stored_of(whole))

    def block(self, first: int, last: int) -> Recording:
        """Return frames first to last - 1, upright."""
        # Whether a recording is mostly negative is asked of the whole; some frames of a good one may well be.
        pads = {name: replace(pad, polarity="down") for name, pad in self.stored.pads.items()}
        return replace(self.stored, pads=pads).part(first, last)

    def close(self) -> None:
        self.stored.close()


def open_recording(path: str, reading: Reading, *, checked: bool = False) -> Opened:
    """Open a recording.

    Parameters
    ----------
    path : str
    reading : Reading
    checked : bool
        Whether its polarity was looked at before.

    Raises
    ------
    InputError
        If it cannot be opened, or is none.
    """
    stamp = stamp_of(path)
    sensor = sensor_for(path, reading.sensor)
    stored = open_stored(
        path,
        shape=reading.shape or (None if sensor is None else sensor.readings_shape),
        pitch_m=reading.pitch_m,
        polarity="up" if sensor is None else sensor.polarity,
    )
    try:
        return Opened(upright_stored(stored, sensor, checked=checked), sensor, stamp)
    except BaseException:
        stored.close()
        raise


def stamp_of(path: str) -> Stamp:
    """Return what changes when a recording is changed.

    Raises
    ------
    InputError
        If there is no such file.
    """
    try:
        told = [(str(each), os.stat(each)) for each in files_of(Path(path))]
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file") from error
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    return tuple((name, stat.st_size, stat.st_mtime_ns) for name, stat in told)
