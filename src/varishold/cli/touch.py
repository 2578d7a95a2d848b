"""``varishold touch``: recognize the surfaces of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from varishold.recording import Recording
    from varishold.sensor import Sensor
    from varishold.touch import Answer


def register(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(touch)


def touch(
    file: Annotated[Path, typer.Argument(help="Recording: NPZ, NPY, CSV or Tekscan ASCII.", metavar="FILE")],
    frames: Annotated[
        str,
        typer.Option(help="'peak' (largest total), 'all', 'press' (one answer a press), or a frame number."),
    ] = "peak",
    skin: Annotated[Path | None, typer.Option(help="Skin file (TOML), where the skin is known.")] = None,
    exact: Annotated[
        bool, typer.Option("--exact", help="Recognize by fitting each form through the skin (needs --skin).")
    ] = False,
    sensor: Annotated[
        str | None,
        typer.Option(
            help="Sensor file (TOML) or a preset's name (varishold sensor list). Default: sensor.toml or "
            "FILE.sensor.toml beside the recording.",
        ),
    ] = None,
    levels: Annotated[int, typer.Option(help="Thresholds a contact.", min=4, max=512)] = 32,
    pitch_m: Annotated[float | None, typer.Option(help="Taxel spacing in metres.")] = None,
    shape: Annotated[str | None, typer.Option(help="Rows x columns of a flat CSV or NPY, as in 16x16.")] = None,
    report: Annotated[Path | None, typer.Option(help="Write a self-contained HTML report here.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object a contact.")] = False,
) -> None:
    """Say what surfaces a recording's contacts are, how sure that is, and why."""
    from varishold.cli.printing import parse_shape, print_answers
    from varishold.errors import InputError
    from varishold.touch import recognize_recording

    known_sensor = _sensor(sensor, file)
    if exact and skin is None and (known_sensor is None or known_sensor.cover is None):
        raise InputError("--exact fits forms through the skin and needs --skin SKIN.toml, or [skin] in a sensor file")
    if report is not None and not report.absolute().parent.is_dir():
        raise InputError(f"{report}: cannot write here: there is no folder {report.absolute().parent}; make it first")
    recording = _read(file, parse_shape(shape), pitch_m, known_sensor)
    known_skin = None if known_sensor is None else known_sensor.cover
    if skin is not None:
        from varishold.skin import read_skin

        known_skin = read_skin(skin)
    answers: list[Answer] = print_answers(
        recognize_recording(
            recording,
            frames=frames,
            levels=levels,
            skin=known_skin,
            exact=exact,
            sensor=known_sensor,
        ),
        recording,
        json=json,
    )
    if report is not None:
        from varishold.report import write_touch_report

        write_touch_report(report, answers, recording=recording, skin=None if known_skin is None else str(known_skin))
        if not json:
            typer.echo(f"report: {report}")


def _sensor(given: str | None, file: Path) -> Sensor | None:
    """Return the sensor that was named, or that stands beside the recording."""
    from varishold.sensor import find_sensor_file, read_sensor, sensor_of

    if given is not None:
        return sensor_of(given)
    beside = find_sensor_file(file)
    return None if beside is None else read_sensor(beside)


def _read(file: Path, shape: tuple[int, int] | None, pitch_m: float | None, sensor: Sensor | None) -> Recording:
    """Read a recording; what it leaves unsaid the sensor file says."""
    from dataclasses import replace

    from varishold.recording import read
    from varishold.sensor.words import sensor_name

    if sensor is None:
        return read(file, shape=shape, pitch_m=pitch_m)
    recording = read(file, shape=shape or sensor.shape, pitch_m=pitch_m, polarity=sensor.polarity)
    return replace(recording, notes=(*recording.notes, f"read with the sensor {sensor_name(sensor)}"))
