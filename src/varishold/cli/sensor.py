"""``varishold sensor``: the sensors that are known by name, and a sensor file from recordings."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import PitchM, Shape
from varishold.cli.printing import echo
from varishold.cli.progress import progress_bar

if TYPE_CHECKING:
    from varishold.calibration import Calibration
    from varishold.recording import Recording
    from varishold.sensor import Sensor


class Pressed(StrEnum):
    """What pressed the sensor that is calibrated."""

    even = "even"
    objects = "objects"
    unlabelled = "unlabelled"
    scale = "scale"


def register(app: Commands) -> None:
    """Add the group to the program."""
    group = app.subgroup("sensor", "The sensor: what its readings mean, and how to measure that.")
    group.command("list")(list_presets)
    group.command("show")(show)
    group.command("calibrate")(calibrate)


def list_presets(
    json: Annotated[bool, Option("Print one JSON object a sensor.")] = False,
) -> None:
    """List the sensors that are known by name; touch --sensor takes any of them."""
    from varishold.cli.printing import print_json
    from varishold.sensor import PRESETS, sensor_of

    for name in PRESETS:
        sensor = sensor_of(name)
        rows, cols = sensor.readings_shape or (None, None)
        if json:
            pitch = None if sensor.pitch_m is None else list(sensor.pitch_m)
            print_json(
                {
                    "preset": name,
                    "name": sensor.name,
                    "shape": [rows, cols],
                    "pitch_m": pitch,
                    "polarity": sensor.polarity,
                    "third_party": sensor.third_party,
                    "notes": sensor.notes,
                }
            )
            continue
        pitch_words = "" if sensor.pitch_m is None else f" at {1e3 * sensor.pitch_m[0]:.3g} mm"
        marked = " (third-party)" if sensor.third_party else ""
        echo(f"{name:16} {f'{rows} x {cols}{pitch_words}':20} {sensor.name}{marked}: {sensor.notes}")


def show(
    sensor: Annotated[str, Argument("Sensor file (TOML) or a preset's name.", metavar="SENSOR"), Reads()],
) -> None:
    """Show what a sensor file says, in words."""
    from varishold.sensor import sensor_of
    from varishold.sensor.words import sensor_name, undone_words

    known = sensor_of(sensor)
    shape = known.readings_shape
    echo(sensor_name(known))
    echo(f"  taxels: {'unknown' if shape is None else f'{shape[0]} x {shape[1]}'}")
    for words in undone_words(known) or ("nothing to undo",):
        echo(f"  {words}")
    if known.cover is not None:
        echo(f"  cover: {known.cover}")
    if known.notes:
        echo(f"  {known.notes}")


def calibrate(
    recordings: Annotated[
        list[str],
        Argument(
            "Recordings of presses on one sensor: files, folders, patterns, or - for standard input.",
            metavar="RECORDINGS...",
        ),
        Reads("bare recordings"),
    ],
    kind: Annotated[
        Pressed,
        Option("What pressed: an even pressure, known objects, anything, or tips on a scale."),
    ],
    output: Annotated[Path, Option("The sensor file (TOML) to write.", short="-o"), Writes("sensor")],
    known: Annotated[
        list[str] | None,
        Option(
            "Known object, one a file: ball:SIZE, roller:SIZE or disc:SIZE (a round plate) by its diameter, "
            "plate:SIZE (a square one) by its breadth, metres.",
            name="--object",
        ),
    ] = None,
    pressure_pa: Annotated[
        str | None, Option("Pressure of each even press in pascal, between commas, where it is known.")
    ] = None,
    force_n: Annotated[str | None, Option("Force of each press on the scale, newton, between commas.")] = None,
    sensor: Annotated[
        str | None, Option("What is known already: a sensor file or a preset's name."), Reads("sensor")
    ] = None,
    pad: Annotated[str | None, Option("Which pad, where a recording has several.")] = None,
    pitch_m: PitchM = None,
    shape: Shape = None,
    report: Annotated[Path | None, Option("Write a self-contained HTML page here."), Writes("page")] = None,
    force: Annotated[bool, Option("Replace files that this command did not make.")] = False,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Measure a sensor from recordings: write its sensor file, and say how sure that is."""
    from varishold.cli.printing import parse_shape, print_json
    from varishold.cli.recordings import recording_files
    from varishold.errors import InputError
    from varishold.files import check_output
    from varishold.recording import read
    from varishold.sensor import Sensor, map_files, named_files, sensor_of, write_sensor

    if output.suffix.lower() != ".toml":
        raise InputError(f"{output}: a sensor file is TOML: name it *.toml")
    if (kind == Pressed.objects) != bool(known):
        raise InputError("--kind objects needs --object, as in --object ball:0.02, and no other kind takes it")
    for option, given, of in (("--pressure-pa", pressure_pa, Pressed.even), ("--force-n", force_n, Pressed.scale)):
        if given is not None and kind != of:
            raise InputError(f"{option} goes with --kind {of}, and no other kind takes it")
    files = recording_files(recordings)
    read_here = files if sensor is None else [*files, sensor, *map(str, named_files(sensor))]
    for path in map_files(output):
        check_output(path, "sensor", inputs=read_here, force=force)
        if report is not None and report.absolute() == path.absolute():
            raise InputError(f"{report}: is to be both a map of the sensor file and report; name two files")
    base = Sensor() if sensor is None else sensor_of(sensor)
    sized = parse_shape(shape) or base.shape
    read_all = [read(path, shape=sized, pitch_m=pitch_m, polarity=base.polarity) for path in files]
    found = _calibrated(kind, read_all, base, known or [], pressure_pa, force_n, pad)
    written = write_sensor(found.sensor, output)
    if report is not None:
        from varishold.report import write_calibration_report

        write_calibration_report(report, found, title=output.name)
    if json:
        print_json({"sensor": str(output), **found.to_dict()})
        return
    echo(counted(found.presses, "press"))
    for finding in found.findings:
        echo(f"found: {finding}")
    for words in found.unknown:
        echo(f"not known: {words}")
    for words in found.notes:
        echo(f"note: {words}")
    for path in (*written, *((report,) if report is not None else ())):
        echo(f"written: {path}")


def _calibrated(
    kind: Pressed,
    recordings: list[Recording],
    base: Sensor,
    known: list[str],
    pressure_pa: str | None,
    force_n: str | None,
    pad: str | None,
) -> Calibration:
    from varishold.calibration import (
        calibrate_even,
        calibrate_objects,
        calibrate_scale,
        calibrate_unlabelled,
        known_object,
    )

    if kind == Pressed.even:
        return calibrate_even(recordings, sensor=base, pressure_pa=_numbers("--pressure-pa", pressure_pa), pad=pad)
    if kind == Pressed.objects:
        things = [known_object(text) for text in known]
        with progress_bar("fitting the presses") as tick:
            return calibrate_objects(recordings, things, sensor=base, pad=pad, tick=tick)
    if kind == Pressed.scale:
        return calibrate_scale(recordings, sensor=base, force_n=_numbers("--force-n", force_n), pad=pad)
    return calibrate_unlabelled(recordings, sensor=base, pad=pad)


def _numbers(option: str, text: str | None) -> list[float] | None:
    from varishold.errors import InputError

    if text is None:
        return None
    try:
        return [float(word) for word in text.split(",")]
    except ValueError as error:
        raise InputError(f"{option} must be numbers between commas, as in 1000,2000, got {text!r}") from error
