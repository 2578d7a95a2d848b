"""``varishold learn`` and ``recognize``: a user's own surfaces and objects."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import (
    Absolute,
    Cluster,
    Error,
    Group,
    KeepParts,
    Label,
    Portable,
    Position,
    SensorFile,
    Table,
    Workers,
    classifier_of,
    option_told,
    refuse_alone,
)
from varishold.cli.printing import echo, print_json, tell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from varishold.learning import LabelledPresses, Recognition
    from varishold.touch.course.presses import Press


# Fewer presses that are refused may be strangers; and so many of the measures that make them strange are named.
_FEW_REFUSED, _MOST_NAMED = 3, 3


def register(app: Commands) -> None:
    """Add the commands to the program."""
    app.command()(learn)
    app.command()(recognize)


def learn(
    recordings: Annotated[
        list[str],
        Argument(
            "Recordings to learn from: files, folders, patterns; with --add the model to add to.",
            metavar="RECORDING...",
        ),
        Reads("recordings"),
    ],
    output: Annotated[Path, Option("Model file to write (NPZ).", short="-o", metavar="MODEL"), Writes("learned")],
    label: Label = None,
    group: Group = None,
    add: Annotated[
        tuple[str, str] | None,
        Option("Add a class to a model: its name, and the recording of it.", metavar="LABEL FILE"),
    ] = None,
    position: Position = None,
    absolute: Absolute = None,
    error: Error = None,
    portable: Portable = False,
    sensor: SensorFile = None,
) -> None:
    """Learn your own surfaces or objects from recordings of presses or grasps."""
    from varishold.errors import InputError
    from varishold.learning import write_model

    if add is not None:
        _check_alone(
            label=label, group=group, position=position, absolute=absolute, error=error, portable=portable or None
        )
        _add(recordings, add, output, sensor)
        return
    if label is None:
        raise InputError("what names the things is not said: a column of the presses, or folder", parameter="label")
    from varishold.cli.progress import progress_bar
    from varishold.cli.recordings import odd_recordings, read_upright, recording_files
    from varishold.learning import labelled_presses

    files = recording_files(recordings)
    read = [read_upright(file, sensor) for file in files]
    given = labelled_presses(read, label=label, group=group)
    _check_things(given, label, files)
    classifier = classifier_of(position, absolute, error, portable=portable)
    with progress_bar("learning") as update:
        classifier.fit(given.presses, given.labels, given.groups, tick=lambda: update(advance=1))
    write_model(classifier, output)
    echo(
        f"{output}: {counted(len(given), 'press')} of {counted(len(classifier.classes_), 'thing')}; "
        f"{_told_loss(classifier.loss_)}"
    )
    for remark in (*odd_recordings(files, read), *classifier.remarks_):
        echo(f"note: {remark}")


def _told_loss(loss: float) -> str:
    from math import exp

    return f"held out, the true thing has p = {exp(-loss):.2f} on the geometric mean"


def _check_alone(**options: object) -> None:
    """Refuse what is chosen once, when a model is learned."""
    from varishold.errors import InputError

    for name, value in options.items():
        if value is not None:
            raise InputError(f"--add leaves all else of the model as it is: leave out {option_told(name, value)}")


def _check_things(given: LabelledPresses, label: str, files: list[str]) -> None:
    """Refuse presses of one thing, and a thing of one press, with the column and the file that say so."""
    from varishold.errors import InputError

    labels = [*map(str, given.labels)]
    counted = Counter(labels)
    if len(counted) < 2:
        more = f" and {len(files) - 1} more" if len(files) > 1 else ""
        one = next(iter(counted))
        raise InputError(
            f"{files[0]}{more}: {label!r} names one thing only, {one!r}; give recordings of another too",
            parameter="label",
        )
    name, n = min(counted.items(), key=lambda item: item[1])
    if n < 2:
        place = given.presses[labels.index(name)].place
        raise InputError(f"{place}: {name!r} has one press only; give at least two of each thing")


def _add(recordings: list[str], add: tuple[str, str], output: Path, sensor: str | None) -> None:
    """Add a class to a model."""
    from varishold.cli.inputs import files_beside
    from varishold.cli.recordings import odd_recordings, read_upright
    from varishold.errors import InputError
    from varishold.files import check_output
    from varishold.learning import read_model, write_model
    from varishold.touch.course.presses import cut_presses

    label, file = add
    if len(recordings) != 1:
        raise InputError(f"to add a class name the one model to add to, got {len(recordings)} files")
    beside = files_beside([file]) if sensor is None else []
    check_output(output, "learned", inputs=[file, *beside], force=True)
    model = read_model(recordings[0])
    recording = read_upright(file, sensor)
    presses = cut_presses(recording)
    said = len(model.remarks_)
    model.add(label, presses)
    for remark in (*odd_recordings([file], [recording]), *model.remarks_on(presses), *model.remarks_[said:]):
        echo(f"note: {remark}")
    write_model(model, output)
    echo(
        f"{output}: {label.strip()} added from {counted(len(presses), 'press')}; "
        f"{counted(len(model.classes_), 'thing')}"
    )


def recognize(
    model: Annotated[Path, Argument("Model file.", metavar="MODEL"), Reads()],
    recordings: Annotated[
        list[str],
        Argument("Recordings: files, folders, patterns, or - for standard input.", metavar="RECORDING..."),
        Reads("recordings"),
    ],
    sensor: SensorFile = None,
    adapt: Annotated[
        bool,
        Option("Estimate from all these presses how things have drifted since; a session's at a time."),
    ] = False,
    output: Table = None,
    workers: Workers = None,
    cluster: Cluster = None,
    keep_parts: KeepParts = False,
    json: Annotated[bool, Option("Print one JSON object a press.")] = False,
) -> None:
    """Say what each press of a recording is, by a model that was learned, how sure that is, and why."""
    if output is not None:
        from varishold.cli.corpus import Spread, recognize_corpus
        from varishold.errors import InputError

        if adapt:
            raise InputError("--adapt needs all presses at once: leave out -o")
        recognize_corpus(model, recordings, Spread(output, workers, cluster, keep_parts, None, json), sensor)
        return
    refuse_alone(workers=workers, cluster=cluster, keep_parts=keep_parts or None)
    from varishold.cli.recordings import each_file, odd_recordings, read_upright, recording_files
    from varishold.learning import TactileClassifier, read_model
    from varishold.touch.course.presses import cut_presses, without_copies

    learned = read_model(model)
    files = recording_files(recordings)

    def presses_of(file: str) -> list[Press]:
        recording = read_upright(file, sensor)
        for remark in odd_recordings([file], [recording]):
            tell(f"note: {remark}")
        return cut_presses(recording)

    if adapt:
        # Every file is asked twice; otherwise no more than one is in memory.
        presses_of = cache(presses_of)
        unlabelled = [press for file in files for press in presses_of(file)]
        learned = learned.adapt(unlabelled)
        if not json:
            some, left_out = learned.adapted_to_, len(unlabelled) - learned.adapted_to_
            copies = len(unlabelled) - len(without_copies(unlabelled)) if left_out else 0
            faint = left_out - copies
            all_of_them = f"{'this' if some == 1 else 'these'} {counted(some, 'press')}"
            which = f"{some} of these {len(unlabelled)} presses" if left_out else all_of_them
            why = f"; {faint} that {'bears' if faint == 1 else 'bear'} next to nothing left out" if faint else ""
            why += f"; {counted(copies, 'copy', 'copies')} of others left out" if copies else ""
            why += "" if any(of.any() for of in learned.learned_.drift.values()) else "; they have none in common"
            echo(f"note: drift since the model was learned was estimated from {which}{why}")

    def answer(file: str) -> None:
        presses = presses_of(file)
        answers = learned.explain(presses)
        for remark in learned.remarks_on(presses):
            tell(f"note: {file}: {remark}")
        for number, found in enumerate(answers):
            if json:
                print_json({"file": file, **found.to_dict(), "press": number})
            else:
                echo(f"{number:>5}  {_in_words(found)}")
        tell_strange(file, answers, adaptable=not adapt and isinstance(learned, TactileClassifier))

    each_file(files, answer, heading=not json)


def tell_strange(file: str, answers: Sequence[Recognition], *, adaptable: bool = False) -> None:
    """Say where most presses of a recording are like nothing known, and in what: it may not be of the same sensor.

    Where the model is `adaptable`, it may be of another day, which it can be asked to allow for.
    """
    refused = [found for found in answers if found.refused]
    if len(refused) < _FEW_REFUSED or 2 * len(refused) <= len(answers):
        return
    counted = Counter(name for found in refused for name in found.outside)
    most = ", ".join(name for name, _ in counted.most_common(_MOST_NAMED))
    words = f", above all in {most}" if most else ""
    allow = "; if it is another day, --adapt allows for its drift" if adaptable else ""
    tell(
        f"note: {file}: {len(refused)} of {len(answers)} presses are like nothing that was learned{words}: "
        f"other things, or another sensor, unit, clock or load{allow}"
    )


def _in_words(found: Recognition) -> str:
    reasons = ", ".join(f"{name} {nats:+.1f}" for name, nats in found.measures[:3])
    like = f"most like {' '.join(found.nearest.split())}"
    if found.refused:
        beyond = f"; outside of all that was learned: {', '.join(found.outside[:_MOST_NAMED])}" if found.outside else ""
        return f"none of these (p = {found.p_value:.3f}{beyond}); nearest is {found.label}, {like}"
    other = next(iter(found.alternatives.items()), None)
    also = "" if other is None else f", else {other[0]} {other[1]:.2f}"
    unlike = "; felt unlike the session that was learned" if found.unlike_session else ""
    return f"{found.label} {found.probability:.2f}{also}{unlike}; {reasons}; {like}"
