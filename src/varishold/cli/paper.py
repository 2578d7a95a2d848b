"""``varishold paper``: the paper's tables beside ours."""

from __future__ import annotations

from typing import Annotated

import typer

_group = typer.Typer(no_args_is_help=True, help="The paper's tables beside ours.")


def register(app: typer.Typer) -> None:
    """Add the command group to the program."""
    app.add_typer(_group, name="paper")


@_group.callback()
def _paper() -> None:
    """Group the commands, so that `table` stays a word of its own."""


@_group.command()
def table(
    number: Annotated[int, typer.Argument(help="1 to 5.", metavar="N")],
    seed: Annotated[int, typer.Option(help="Seed of the simulated grasps (Table 5).")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object a row.")] = False,
) -> None:
    """Print a table of the paper as scanned, as restored with reasons, and as computed here."""
    from varishold.cli.printing import print_json
    from varishold.paper import paper_table

    result = paper_table(number, seed=seed)
    if json:
        for row in result.rows:
            print_json(row)
        return
    typer.echo(str(result))
