"""``varishold grasp``: learn from a grasp table, answer, show the tables, export the circuit."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import refuse_given
from varishold.cli.printing import echo, printable, tell


class Mode(StrEnum):
    """Modes of the classifier."""

    auto = "auto"
    paper = "paper"
    robust = "robust"
    vote = "vote"


class Encode(StrEnum):
    """Where an encoder's thresholds lie."""

    quantile = "quantile"
    even = "even"
    supervised = "supervised"


class Target(StrEnum):
    """What a circuit can be exported to."""

    c = "c"
    verilog = "verilog"
    json = "json"


_Tables = Annotated[
    list[str],
    Argument(
        "Grasp tables (CSV), of any length: files, folders, patterns, or - for standard input.", metavar="TABLE..."
    ),
    Reads("tables"),
]


def register(app: Commands) -> None:
    """Add the command group to the program."""
    group = app.subgroup("grasp", "Tell objects by the switches that a grasp closes.")
    for command in (fit, predict, tables, export):
        group.command()(command)


def fit(
    tables: _Tables,
    label: Annotated[str, Option("Column that names the object.", metavar="COLUMN")],
    output: Annotated[Path, Option("Model file to write.", short="-o", metavar="MODEL.json"), Writes("model")],
    mode: Annotated[Mode, Option("Way from grasps to a circuit.")] = Mode.auto,
    group: Annotated[str | None, Option("Column that names each grasp's session.", metavar="COLUMN")] = None,
    columns: Annotated[
        str | None, Option("Columns to read; default: switch.*, or all but the label.", metavar="GLOB")
    ] = None,
    encode: Annotated[Encode | None, Option("Cut numbers at thresholds: --levels of them.")] = None,
    levels: Annotated[int, Option("Thresholds a column.", min=1, max=1024)] = 4,
    seed: Annotated[int, Option("Seed of everything that is drawn.", min=0)] = 0,
) -> None:
    """Learn hyperplanes and a circuit from grasp tables."""
    from varishold.circuit import circuit_size
    from varishold.cli.named import table_files
    from varishold.files import encoding_notes
    from varishold.grasp import fit_model, write_model
    from varishold.grasp.comparison import FEWEST_TELLING
    from varishold.recording import GraspTable, read_grasp_table

    if encode is None:
        refuse_given("levels", because="are thresholds of columns that are cut: say how with --encode, or leave it out")
    read = None if columns is None else [columns] if group is None else [columns, group]
    files = table_files(tables)
    grasps = GraspTable.joined([read_grasp_table(each, label=label, columns=read) for each in files])
    cut = None if encode is None else encode.value
    model = fit_model(
        grasps, label=label, group=group, columns=columns, mode=mode.value, encode=cut, levels=levels, seed=seed
    )
    write_model(model, output)
    clf = model.classifier
    echo(
        f"{output}: {counted(len(grasps), 'grasp')} of {counted(len(clf.classes_), 'object')}, "
        f"{counted(len(model.columns), 'column')}, "
        f"{counted(clf.n_features_in_, 'switch')}, mode {clf.mode_}, {circuit_size(clf.netlist_)}"
    )
    for text in (*(f"{each}: {note}" for each in files for note in encoding_notes(each)), *clf.remarks_):
        echo(f"note: {text}")
    if mode is Mode.auto and len(clf.hyperplanes_) and len(clf.grasps_) < FEWEST_TELLING:
        echo(
            f"note: {counted(len(clf.grasps_), 'grasp does', 'different grasps do')} not tell "
            f"whether a smaller circuit does as well, "
            f"{FEWEST_TELLING} may; --mode robust makes one all the same"
        )


def predict(
    model: Annotated[Path, Argument("Model file.", metavar="MODEL.json"), Reads()],
    tables: _Tables,
    why: Annotated[bool, Option("Say what decided, and how many switches may fail before the answer changes.")] = False,
    json: Annotated[bool, Option("Print one JSON object a row.")] = False,
) -> None:
    """Answer every row of grasp tables; memory does not grow with their length."""
    import json as jsonlib
    import sys

    from varishold.cli.named import table_files
    from varishold.cli.recordings import each_file
    from varishold.files import encoding_notes
    from varishold.grasp import read_model

    learned = read_model(model)

    def predict_file(table: str) -> None:
        row = 0
        for note in encoding_notes(table):
            tell(f"note: {table}: {note}")
        for answers in learned.answer_file(table, why=why):
            if json:
                for answer in answers:
                    sys.stdout.write(jsonlib.dumps({"row": row, **answer.to_dict(), "file": table}) + "\n")
                    row += 1
            else:
                for answer in answers:
                    lines = [f"{answer.object}{' ?' if answer.rejected else ''}", *(f"  {line}" for line in answer.why)]
                    sys.stdout.write(printable("\n".join(lines) + "\n"))

    each_file(table_files(tables), predict_file, heading=not json)


def tables(
    model: Annotated[Path, Argument("Model file.", metavar="MODEL.json"), Reads()],
) -> None:
    """Print hyperplanes and sign tables as the paper prints its Tables 1 to 4."""
    from varishold.grasp import describe_tables, read_model

    echo(describe_tables(read_model(model)))


def export(
    model: Annotated[Path, Argument("Model file.", metavar="MODEL.json"), Reads()],
    to: Annotated[Target, Option("c (C99), verilog, or json (the netlist).")],
    output: Annotated[Path, Option("Folder to write to.", short="-o", metavar="DIR"), Writes("circuit", folder=True)],
    force: Annotated[bool, Option("Replace files that this command did not make.")] = False,
) -> None:
    """Write the circuit, encoder included, as source for a microcontroller or an FPGA."""
    from dataclasses import replace

    from varishold.circuit.writers import export as write_sources
    from varishold.circuit.writers.names import identifier, taken_by
    from varishold.files import check_output
    from varishold.grasp import read_model

    learned = read_model(model)

    def check(path: Path) -> None:
        check_output(path, "circuit", inputs=[model], force=force)

    # A header says of its inputs all that whoever fills them must know; a netlist is read again by its columns.
    named = learned.netlist if to is Target.json else replace(learned.netlist, channels=learned.inputs_in_words)
    for path in write_sources(named, to.value, output, name=model.stem, check=check):
        echo(str(path))
    if taken := taken_by(model.stem, header=to is Target.c):
        echo(f"note: called {identifier(model.stem, header=to is Target.c)}, for {model.stem!r} is {taken}")
    for text in learned.counts:
        echo(f"note: {text}")
