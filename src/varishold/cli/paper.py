"""``varishold paper``: the paper's tables beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Writes
from varishold.cli.options import refuse_given
from varishold.cli.printing import echo


def register(app: Commands) -> None:
    """Add the command group to the program."""
    app.subgroup("paper", "The paper's tables beside ours.").command()(table)


def table(
    number: Annotated[int, Argument("1 to 5.", metavar="N")],
    seed: Annotated[int, Option("Table 5: seed of the simulated grasps.")] = 0,
    grasps: Annotated[int, Option("Table 5: test grasps an object in each repetition.", min=1)] = 20,
    repetitions: Annotated[int, Option("Table 5: training sets.", min=1)] = 2,
    processes: Annotated[int | None, Option("Table 5: processes; default: one a processor.")] = None,
    finger_length: Annotated[
        Path | None,
        Option("Table 5: repeat it with digits of several lengths and draw the figure here (PNG, SVG)."),
        Writes("picture"),
    ] = None,
    json: Annotated[bool, Option("Print one JSON object a row.")] = False,
) -> None:
    """Print a table of the paper as scanned, as restored with reasons, and as computed here."""
    from varishold.cli.printing import print_json
    from varishold.paper import paper_table

    if number == 5:
        _table_5(seed, grasps, repetitions, processes, finger_length, json)
        return
    of_5 = ("seed", "grasps", "repetitions", "processes", "finger_length")
    refuse_given(*of_5, because=f"belongs to Table 5, got Table {number}")
    result = paper_table(number, seed=seed)
    if json:
        for row in result.rows:
            print_json(row)
        return
    echo(str(result))


def _table_5(
    seed: int, grasps: int, repetitions: int, processes: int | None, finger_length: Path | None, json: bool
) -> None:
    from varishold.cli.printing import print_json
    from varishold.cli.progress import progress_bar
    from varishold.paper.finger_length import finger_length_sweep
    from varishold.paper.table5 import as_paper_table, table_5

    with progress_bar("grasps") as update:

        def progress(done: int, wanted: int) -> None:
            update(completed=done, total=wanted)

        if finger_length is None:
            result = as_paper_table(
                table_5(seed=seed, grasps=grasps, repetitions=repetitions, processes=processes, progress=progress)
            )
            rows, text = list(result.rows), str(result)
        else:
            sweep = finger_length_sweep(
                seed=seed, grasps=grasps, repetitions=repetitions, processes=processes, progress=progress
            )
            rows, text = list(sweep.to_dicts()), str(sweep)
            from varishold.report.finger_length import draw_finger_lengths

            draw_finger_lengths(rows, finger_length)
    if json:
        for row in rows:
            print_json(row)
        return
    echo(text)
    if finger_length is not None:
        echo(f"figure: {finger_length}")
