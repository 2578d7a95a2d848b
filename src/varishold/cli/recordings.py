"""Commands on files take one, several, folders, patterns or standard input, all alike."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import click

from varishold.cli.files import with_option
from varishold.cli.made import Others
from varishold.cli.named import recordings_named
from varishold.cli.printing import echo, printable
from varishold.errors import FormatError, InputError
from varishold.sensor.finding import sensor_beside, sensor_for

if TYPE_CHECKING:
    from varishold.recording import Recording
    from varishold.sensor import Sensor

# Of so many remarks on files each is told; whoever wants more asks for them.
_MOST_REMARKS = 6

__all__ = [
    "each_file",
    "odd_recordings",
    "read_recording",
    "read_upright",
    "read_with_sensor",
    "recording_files",
    "sensor_beside",
    "sensor_for",
]


def recording_files(names: Sequence[str]) -> list[str]:
    """Return the recordings that are named, each once; of a folder, those that a reader knows by ending or folder.

    What this program has made of recordings may lie in the folder with them: models, tables, and the maps of sensors.
    """
    others = Others()
    found: dict[str, None] = {}
    for name in names:
        try:
            found.update(dict.fromkeys(recordings_named(name, others.is_recording)))
        except InputError:
            if len(names) == 1:
                raise
            # Of several, one is told when its turn comes, and the others are still done.
            found[name] = None
    files = others.each_once(found)
    others.tell()
    return files


def read_recording(
    file: str, sensor: Sensor | None, *, shape: tuple[int, int] | None = None, pitch_m: float | None = None
) -> Recording:
    """Read a recording; what it leaves unsaid its sensor says."""
    from dataclasses import replace

    from varishold.recording import read
    from varishold.recording.pad import far_apart
    from varishold.sensor.recordings import other_pitches
    from varishold.sensor.words import sensor_name

    if sensor is None:
        return read(file, shape=shape, pitch_m=pitch_m)
    try:
        recording = read(file, shape=shape or sensor.readings_shape, pitch_m=pitch_m, polarity=sensor.polarity)
    except FormatError as error:
        if error.parameter != "shape" or shape is not None or sensor.readings_shape is None:
            raise
        found = str(error).removesuffix("; leave the shape out")
        raise FormatError(f"{found}, which is the shape of the sensor {sensor_name(sensor)}") from None
    notes = [f"read with the sensor {sensor_name(sensor)}"]
    if any(pad.pitch_m is None and pad.positions_m is None for pad in recording.pads.values()):
        notes += far_apart(sensor.pitch_m, sensor.positions_m)
    if pitch_m is None:
        notes += other_pitches(recording, sensor)
    return replace(recording, notes=(*recording.notes, *notes))


def read_with_sensor(file: str, named: str | None) -> tuple[Recording, Sensor | None]:
    """Read a recording, with the sensor that was named or stands beside it."""
    known = sensor_for(file, named)
    return read_recording(file, known), known


def read_upright(file: str, named: str | None) -> Recording:
    """Read a recording, turned upright by the sensor that was named or stands beside it."""
    from varishold.sensor.recordings import upright_recording

    return upright_recording(*read_with_sensor(file, named))


def odd_recordings(files: Sequence[str], recordings: Sequence[Recording]) -> list[str]:
    """Return in words what is odd about recordings, dead and saturated taxels among it: each remark with its files."""
    files_of: dict[str, list[str]] = {}
    for file, recording in zip(files, recordings, strict=True):
        for remark in recording.remarks:
            files_of.setdefault(remark, []).append(file)
    told = [
        f"{first}{f' and {len(rest)} more' if rest else ''}: {remark}" for remark, (first, *rest) in files_of.items()
    ]
    more = len(told) - _MOST_REMARKS
    return told if more <= 0 else [*told[:_MOST_REMARKS], f"{more} remarks more: varishold info FILE tells them"]


def each_file(files: Sequence[str], work: Callable[[str], None], *, heading: bool = False) -> None:
    """Do `work` with every one of some files.

    What is wrong with one of several is told, the others are still done, and the exit status is 1.

    Parameters
    ----------
    files : sequence of str
    work : callable
        Takes the path of a file.
    heading : bool
        Print each file's name before its answers, where there are several.
    """
    failed = False
    for file in files:
        try:
            if heading and len(files) > 1:
                echo(f"{file}:")
            work(file)
        except InputError as error:
            if len(files) == 1:
                raise
            failed = True
            message = with_option(error)
            named = message if message.startswith(file) else f"{file}: {message}"
            print(f"varishold: {' '.join(printable(named).split())}", file=sys.stderr)
    if failed:
        raise click.exceptions.Exit(1)
