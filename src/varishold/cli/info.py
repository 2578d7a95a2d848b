"""``varishold info`` and ``validate``: what a recording holds, and what is wrong with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import click

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads
from varishold.cli.options import Shape
from varishold.cli.printing import echo, print_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from varishold.recording import Recording
    from varishold.recording.inspection import PadSummary, Summary
    from varishold.sensor import Sensor

# The picture of a frame: signs from nothing to the highest taxel, and the most rows and columns that it takes.
_SIGNS = " .:-=+*#%@"
_MOST_ROWS, _MOST_COLS = 24, 36

_Files = Annotated[
    list[str],
    Argument("Recordings: files, folders, patterns, or - for standard input.", metavar="FILE..."),
    Reads(),
]
_Sensor = Annotated[
    str | None,
    Option("Sensor file (TOML) or a preset's name. Default: sensor.toml or FILE.sensor.toml beside the recording."),
    Reads("sensor"),
]


def register(app: Commands) -> None:
    """Add the commands to the program."""
    app.command()(info)
    app.command()(validate)


def info(
    files: _Files,
    sensor: _Sensor = None,
    shape: Shape = None,
    json: Annotated[bool, Option("Print one JSON object a file.")] = False,
) -> None:
    """Say what a recording holds: pads, rate and gaps, unit, range, health, and what was guessed."""
    from dataclasses import replace

    from varishold.cli.recordings import each_file, recording_files
    from varishold.recording.inspection import summarize
    from varishold.sensor.recordings import faults_beside

    def tell(file: str) -> None:
        recording, known = _read(file, sensor, shape)
        found = summarize(recording)
        # What is only asked about is among the notes.
        more = (fault for fault in faults_beside(recording, known) if fault not in found.notes)
        found = replace(found, faults=(*found.faults, *more))
        if known is not None and known.pitch_m is not None:
            # As every command takes it that reads with the sensor.
            pads = (pad if pad.pitch_m else replace(pad, pitch_m=known.pitch_m) for pad in found.pads)
            found = replace(found, pads=tuple(pads))
        if json:
            print_json({"file": file, **found.to_dict()})
            return
        for line in _lines(found):
            echo(" ".join(line.splitlines()))
        for pad in found.pads:
            _draw(recording, pad)

    each_file(recording_files(files), tell, heading=not json)


def validate(
    files: _Files,
    sensor: _Sensor = None,
    shape: Shape = None,
    json: Annotated[bool, Option("Print one JSON object a fault.")] = False,
) -> None:
    """Name every fault of recordings, one a line; the exit status is 1 where there is one."""
    from varishold.cli.recordings import recording_files
    from varishold.errors import InputError
    from varishold.recording.inspection import faults_of
    from varishold.sensor.recordings import faults_beside

    n_faults = 0
    for file in recording_files(files):
        try:
            recording, known = _read(file, sensor, shape)
            faults = (*faults_of(recording), *faults_beside(recording, known))
        except InputError as error:
            faults = (str(error).removeprefix(f"{file}: "),)
        n_faults += len(faults)
        for fault in faults:
            if json:
                print_json({"file": file, "fault": fault})
            else:
                echo(f"{file}: {fault}")
        if not faults and not json:
            echo(f"{file}: no fault found")
    if n_faults:
        raise click.exceptions.Exit(1)


def _read(file: str, sensor: str | None, shape: str | None) -> tuple[Recording, Sensor | None]:
    from varishold.cli.printing import parse_shape
    from varishold.cli.recordings import read_recording, sensor_for

    known = sensor_for(file, sensor)
    return read_recording(file, known, shape=parse_shape(shape)), known


def _lines(found: Summary) -> list[str]:
    time = found.time
    lines = [f"frames    {found.n_frames}{'' if time is None else f' in {time.duration_s:.6g} s'}"]
    if time is not None and time.rate_hz is not None and time.jitter_s is not None:
        lines.append(f"rate      {time.rate_hz:.4g} Hz, jitter {1e3 * time.jitter_s:.3g} ms")
    lines.append(f"unit      {found.unit}")
    if found.sensor:
        lines.append(f"sensor    {found.sensor}")
    if found.n_presses is not None:
        columns = f", with {', '.join(found.press_columns)}" if found.press_columns else ""
        lines.append(f"presses   {found.n_presses}{columns}")
    lines += [_pad_line(pad) for pad in found.pads]
    lines += [f"note: {note}" for note in found.notes]
    return lines + [f"fault: {fault}" for fault in found.faults]


def _pad_line(pad: PadSummary) -> str:
    rows, cols = pad.shape
    taxels = f"{rows} x {cols} taxels" if pad.on_grid else f"{counted(cols, 'taxel')} on no grid"
    if pad.n_taxels < rows * cols:
        taxels += f", {pad.n_taxels} of them in the field"
    if pad.n_broken:
        taxels += f", {pad.n_broken} broken"
    pitch = "pitch unknown"
    if pad.pitch_m is not None:
        across, along = (1e3 * each for each in pad.pitch_m)
        pitch = f"{across:.4g} mm apart" if across == along else f"rows {across:.4g} mm, columns {along:.4g} mm apart"
    down = ", smaller is more pressure" if pad.polarity == "down" else ""
    return f"{pad.name:<9} {taxels}, {pitch}; {pad.dtype} from {pad.low:.6g} to {pad.high:.6g}{down}"


def _draw(recording: Recording, pad: PadSummary) -> None:
    """Print the pad's frame of largest total."""
    from varishold.recording import frame_of

    if not pad.on_grid or pad.high <= pad.low:
        return
    of = recording.pads[pad.name]
    frame = frame_of(of, pad.peak_frame)
    frame[~of.usable] = pad.low if pad.polarity == "up" else pad.high
    share = (frame - pad.low) / (pad.high - pad.low)
    echo(f"frame {pad.peak_frame} of {pad.name}:")
    for row in _small(share if pad.polarity == "up" else 1 - share):
        # Signs are about twice as high as they are wide.
        echo("".join(2 * _SIGNS[round(float(each) * (len(_SIGNS) - 1))] for each in row.clip(0, 1)).rstrip())


def _small(frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a frame of no more taxels than are drawn, each the highest of those that it stands for."""
    import numpy as np

    rows, cols = frame.shape
    step = max(-(-rows // _MOST_ROWS), -(-cols // _MOST_COLS))
    by_rows = np.maximum.reduceat(frame, np.arange(0, rows, step), axis=0)
    return np.asarray(np.maximum.reduceat(by_rows, np.arange(0, cols, step), axis=1))
