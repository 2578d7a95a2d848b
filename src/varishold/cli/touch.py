"""``varishold touch``: recognize the surfaces of a recording."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import Cluster, KeepParts, PitchM, SensorFile, Shape, Table, Workers, refuse_alone
from varishold.cli.printing import echo

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from varishold.touch import Answer


class Target(StrEnum):
    """What a recognizer can be exported to."""

    c = "c"


class Kept(StrEnum):
    """How a network's weights are kept."""

    int8 = "int8"
    float32 = "float32"


def register(app: Commands) -> None:
    """Add the commands to the program."""
    app.command()(touch)
    app.command("touch export")(export)


def touch(
    files: Annotated[
        list[str],
        Argument("Recordings: files, folders, patterns, or - for standard input.", metavar="FILE..."),
        Reads("recordings"),
    ],
    frames: Annotated[
        str | None,
        Option(
            "'peak' (largest total), 'all', 'press' (one answer a press), or a frame number. "
            "Default: peak; with -o all."
        ),
    ] = None,
    skin: Annotated[Path | None, Option("Skin file (TOML), where the skin is known."), Reads()] = None,
    exact: Annotated[bool, Option("Recognize by fitting each form through the skin (needs --skin).")] = False,
    sensor: SensorFile = None,
    levels: Annotated[int, Option("Thresholds a contact.", min=4, max=512)] = 32,
    pitch_m: PitchM = None,
    shape: Shape = None,
    report: Annotated[Path | None, Option("Write a self-contained HTML report here."), Writes("page")] = None,
    json: Annotated[bool, Option("Print one JSON object a contact.")] = False,
    output: Table = None,
    workers: Workers = None,
    cluster: Cluster = None,
    keep_parts: KeepParts = False,
) -> None:
    """Say what surfaces a recording's contacts are, how sure that is, and why."""
    if output is not None:
        from varishold.cli.corpus import Spread, touch_corpus

        spread = Spread(output, workers, cluster, keep_parts, report, json)
        touch_corpus(
            files, spread, frames=frames, levels=levels, skin=skin, exact=exact, reading=(sensor, shape, pitch_m)
        )
        return
    refuse_alone(workers=workers, cluster=cluster, keep_parts=keep_parts or None)
    from varishold.cli.printing import parse_shape, print_answers
    from varishold.cli.recordings import each_file, read_recording, recording_files, sensor_for
    from varishold.errors import InputError
    from varishold.touch import recognize_recording

    recordings = recording_files(files)
    if report is not None and len(recordings) > 1:
        raise InputError(f"{report}: a report shows one recording; name one file")
    given_shape = parse_shape(shape)

    def name_surfaces(file: str) -> None:
        known_sensor = sensor_for(file, sensor)
        if exact and skin is None and (known_sensor is None or known_sensor.cover is None):
            raise InputError(
                "fitting forms through the skin needs a skin, or [skin] in a sensor file", parameter="skin"
            )
        recording = read_recording(file, known_sensor, shape=given_shape, pitch_m=pitch_m)
        known_skin = None if known_sensor is None else known_sensor.cover
        if skin is not None:
            from varishold.skin import read_skin

            known_skin = read_skin(skin)
        answers = recognize_recording(
            recording,
            frames="peak" if frames is None else frames,
            levels=levels,
            skin=known_skin,
            exact=exact,
            sensor=known_sensor,
        )
        kept: list[Answer] = []
        print_answers(answers if report is None else _keeping(answers, kept), recording, json=json)
        if report is not None:
            from varishold.report import write_touch_report

            write_touch_report(report, kept, recording=recording, skin=None if known_skin is None else str(known_skin))
            if not json:
                echo(f"report: {report}")

    each_file(recordings, name_surfaces, heading=not json)


def export(
    to: Annotated[Target, Option("c: C99 for a controller.")],
    output: Annotated[Path, Option("Folder to write to.", short="-o", metavar="DIR"), Writes("source", folder=True)],
    shape: Annotated[str | None, Option("Rows x columns; default: the sensor's, or 16x16.")] = None,
    levels: Annotated[int, Option("Thresholds a contact.", min=4, max=512)] = 32,
    contacts: Annotated[int, Option("The most contacts that are told apart.", min=1, max=64)] = 2,
    sensor: Annotated[str | None, Option("Sensor file (TOML) or a preset's name, to be built in."), Reads()] = None,
    weights: Annotated[Kept, Option("How the network is kept.")] = Kept.int8,
    model: Annotated[
        Path | None,
        Option("What learn --portable wrote, or a table of touch (NPZ); default: the shipped one.", metavar="MODEL"),
        Reads(),
    ] = None,
    pad: Annotated[str | None, Option("Which pad, where a model was learned on several.")] = None,
    force: Annotated[bool, Option("Replace files that this command did not make.")] = False,
) -> None:
    """Write the recognizer, a sensor built in, as source for a controller. (A file called export is ./export.)"""
    from varishold.cli.decision_file import exported_decision
    from varishold.cli.printing import parse_shape
    from varishold.files import check_output
    from varishold.sensor import sensor_of
    from varishold.touch.writers import Export
    from varishold.touch.writers import export as write_sources

    wanted = Export(
        shape=parse_shape(shape),
        levels=levels,
        contacts=contacts,
        sensor=None if sensor is None else sensor_of(sensor),
        weights=weights.value,
        parameters=exported_decision(model, pad),
    )
    inputs = [file for file in (model, sensor) if file is not None and Path(file).is_file()]

    def check(path: Path) -> None:
        check_output(path, "source", inputs=inputs, force=force)

    written = write_sources(wanted, to.value, output, check=check)
    echo(f"{output}: {len(written)} files; README.md says what each is and how to build them")


def _keeping(answers: Iterable[Answer], kept: list[Answer]) -> Iterator[Answer]:
    """Yield answers, which are kept too."""
    for answer in answers:
        kept.append(answer)
        yield answer
