"""``varishold evaluate``: an honest figure for a user's own surfaces and objects."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import (
    Absolute,
    Error,
    Group,
    Label,
    Portable,
    Position,
    SensorFile,
    classifier_of,
    option_told,
)
from varishold.cli.printing import echo, print_json, tell

if TYPE_CHECKING:
    from collections.abc import Callable

    from varishold.evaluation import Evaluation
    from varishold.recording import Recording
    from varishold.sensor import Sensor

_SHIPPED = "shipped"


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(evaluate)


def evaluate(
    recordings: Annotated[
        list[str] | None,
        Argument("Recordings: files, folders, patterns.", metavar="[RECORDING]..."),
        Reads("recordings"),
    ] = None,
    label: Label = None,
    group: Group = None,
    report: Annotated[Path | None, Option("Write a self-contained HTML page here."), Writes("page")] = None,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
    given: Annotated[
        str | None,
        Option(
            "Learn nothing: test a model of 'learn', or the 'shipped' names of touch; "
            "with --distortions these or your own function.",
            name="--with",
            metavar="shipped|MODEL|MODULE:FUNCTION",
        ),
        Reads("word"),
    ] = None,
    shots: Annotated[
        str | None,
        Option("Presses a thing for the shots curve, between commas; 0 for none. Default: 1,2,5,10,20."),
    ] = None,
    peers: Annotated[bool | None, Option("Let plain peers answer the same presses.")] = None,
    position: Position = None,
    absolute: Absolute = None,
    error: Error = None,
    portable: Portable = False,
    distortions: Annotated[
        bool,
        Option("Read nothing: score names of the public yardstick's frames of bad sensors."),
    ] = False,
    pads: Annotated[
        str | None,
        Option("With --distortions: shape of the pads.", name="--shape", metavar="16x16|32x32|both"),
    ] = None,
    frames: Annotated[
        int | None,
        Option("With --distortions: frames of each form on each medium in a row. Default: 40.", min=1, max=10_000),
    ] = None,
    seed: Annotated[
        int | None,
        Option("The same seed gives the same figures. Default: 0; with --distortions 1972.", min=0),
    ] = None,
    workers: Annotated[
        int | None,
        Option("Processes of this machine that share the work. Default: 1.", min=1, max=4096),
    ] = None,
    cluster: Annotated[
        str | None,
        Option(
            "Work on a cluster of dask: its scheduler's address, or 'local' for one of this machine.",
            metavar="ADDRESS|local",
        ),
    ] = None,
    sensor: SensorFile = None,
) -> None:
    """Tell how well your own things are told apart, beside plain peers, with what flatters named."""
    from varishold.cli.corpus import crew
    from varishold.cli.progress import progress_bar
    from varishold.cli.recordings import odd_recordings, read_with_sensor, recording_files
    from varishold.errors import InputError

    if distortions:
        from varishold.cli.distortions import evaluate_distortions

        about: dict[str, object] = {
            "recordings": recordings,
            "label": label,
            "group": group,
            "report": report,
            "shots": shots,
        }
        about |= {"peers": peers, "position": position, "absolute": absolute, "error": error, "sensor": sensor}
        about |= {"portable": portable or None, "workers": workers, "cluster": cluster}
        evaluate_distortions(given, pads, frames, seed, json=json, **about)
        return
    for name, value in (("shape", pads), ("frames", frames)):
        if value is not None:
            raise InputError(f"--{name} is for --distortions alone: leave it out")
    if not recordings:
        raise click.UsageError("name recordings, or --distortions")
    seed = 0 if seed is None else seed
    if label is None:
        raise InputError("what names the things is not said: a column of the presses, or folder", parameter="label")
    if given is not None:
        learning = {"position": position, "absolute": absolute, "error": error, "portable": portable or None}
        _check_alone(shots=shots, peers=peers, workers=workers, cluster=cluster, **learning)
    team = crew(workers, cluster, usual=1)
    files = recording_files(recordings)
    read = [read_with_sensor(file, sensor) for file in files]
    for remark in odd_recordings(files, [recording for recording, _ in read]):
        tell(f"note: {remark}")
    with progress_bar("evaluating") as update:
        if given is None:
            classifier = classifier_of(position, absolute, error, portable=portable)
            how = {"classifier": classifier, "peers": peers is not False, "seed": seed, "workers": team}
            found = _learned_here(read, label, group, _numbers(shots), tick=update, **how)
        else:
            found = _given(given, read, label, group, seed, update)
    if report is not None:
        from varishold.report import write_evaluation_report

        write_evaluation_report(report, found, title=_title(recordings))
    if json:
        print_json(found.to_dict())
        return
    _print(found)
    if report is not None:
        echo(f"report: {report}")


def _learned_here(
    read: list[tuple[Recording, Sensor | None]],
    label: str,
    group: str | None,
    shots: tuple[int, ...] | None,
    **how: Any,
) -> Evaluation:
    """Evaluate what is learned from recordings; `how` goes to `varishold.evaluation.evaluate`."""
    import numpy as np

    from varishold.evaluation import SHOTS
    from varishold.evaluation import evaluate as evaluate_presses
    from varishold.learning import labelled_presses
    from varishold.sensor.recordings import upright_recording

    upright = [upright_recording(*one) for one in read]
    known = labelled_presses(upright, label=label, group=group)
    return evaluate_presses(
        known.presses,
        known.labels,
        known.groups,
        runs=np.repeat(np.arange(len(upright)), [len(one.presses) for one in upright]),
        shots=SHOTS if shots is None else shots,
        **how,
    )


def _given(
    given: str,
    read: list[tuple[Recording, Sensor | None]],
    label: str,
    group: str | None,
    seed: int,
    update: Callable[..., None],
) -> Evaluation:
    """Test a model, or the shipped names."""
    from varishold.errors import InputError
    from varishold.evaluation import evaluate_model, evaluate_shipped
    from varishold.learning import labelled_presses, read_model
    from varishold.sensor.recordings import upright_recording

    if given != _SHIPPED and not Path(given).exists():
        raise InputError(
            f"{given}: is neither 'shipped' nor a file; name a model as learn writes it", parameter="given"
        )
    model = None if given == _SHIPPED else read_model(given)
    known = labelled_presses([upright_recording(*one) for one in read], label=label, group=group)
    if model is not None:
        return evaluate_model(model, known.presses, known.labels, known.groups, seed=seed, tick=update)
    return evaluate_shipped(
        [recording for recording, _ in read],
        known.labels,
        known.groups,
        sensors=[sensor for _, sensor in read],
        seed=seed,
        tick=update,
    )


def _print(found: Evaluation) -> None:
    """Print the figures, each with what spoils it in its own line."""
    from varishold.report.evaluation_words import figure_lines, flatters, headline, interval, points
    from varishold.report.quantities import percent

    spoilt = flatters(found)
    mark = f"  [{spoilt}]" if spoilt else ""

    def say(text: str) -> None:
        echo(text.replace("\u202f", " ").replace("−", "-") + mark)

    groups = f" of {counted(len(found.groups), 'group')}" if found.groups else ""
    echo(f"{counted(found.n_presses, 'press')}{groups}, {counted(len(found.things), 'thing')}")
    say(headline(found))
    for line in figure_lines(found):
        where = f"({line.interval}) " if line.interval else ""
        say(f"  {line.name:<36} {line.value:>12}  {where}{line.says}")
    for shots in found.shots:
        mine = "-" if shots.right is None else f"{percent(shots.right.value)} ({interval(shots.right)})"
        beside = "" if shots.peer is None else f"; best peer {percent(shots.peer.value)}"
        say(f"  learned from {counted(shots.presses, 'press') + ' a thing':<23} {mine}{beside}")
    for peer in found.peers:
        ahead = f"ours {points(peer.ahead.value)} points ({interval(peer.ahead, signed=True)})"
        say(f"  peer: {peer.name:<30} {percent(peer.right.value):>12}  {ahead}")
    for leak in found.leaks:
        echo(f"warning: {leak.says}")
    for remark in found.remarks:
        echo(f"note: {remark}")


def _check_alone(**options: object) -> None:
    """Refuse what is about learning where nothing is learned."""
    from varishold.errors import InputError

    for name, value in options.items():
        if value is not None:
            told = option_told(name, value)
            raise InputError(f"with a model or the shipped names nothing is learned: leave out {told}")


def _numbers(shots: str | None) -> tuple[int, ...] | None:
    from varishold.errors import InputError

    if shots is None:
        return None
    try:
        numbers = tuple(int(word) for word in shots.split(","))
    except ValueError:
        numbers = (-1,)
    if numbers == (0,):
        return ()
    if min(numbers) < 1 or max(numbers) > 1_000_000:
        raise InputError(
            f"--shots must be numbers of presses between commas, as in 1,2,5, or 0 for none; got {shots!r}"
        )
    return tuple(sorted(set(numbers)))


def _title(recordings: list[str]) -> str:
    first = Path(recordings[0]).name or recordings[0]
    return first if len(recordings) == 1 else f"{first} and {len(recordings) - 1} more"
