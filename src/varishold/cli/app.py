"""The program ``varishold``: its command groups, and how an error reaches a person."""

from __future__ import annotations

import io
import os
import sys
from importlib import import_module
from itertools import pairwise
from typing import Any

import typer
from typer.core import TyperGroup

from varishold import __version__
from varishold._lazy import missing_extra
from varishold.cli.files import guarded
from varishold.cli.printing import printable
from varishold.errors import VarisholdError

# Options that name what is written.
_OUTPUTS = ("-o", "--output", "--folder")


class _Commands(TyperGroup):
    """Commands whose name may be two words, as in ``touch export``."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        for option, value in pairwise(args):
            # A path of nothing would be the current folder.
            if value == "" and option in _OUTPUTS:
                raise typer.BadParameter(f"{option} names nothing; '.' is the current folder")
        if empty := {f"{option}=" for option in _OUTPUTS}.intersection(args):
            raise typer.BadParameter(f"{min(empty)} names nothing; '.' is the current folder")
        if " ".join(args[:2]) in self.commands:
            args = [" ".join(args[:2]), *args[2:]]
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            # The checker's own word says nothing to a person.
            error.message = error.message.removeprefix("Value error, ")
            raise


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    help="Tactile pattern recognition: feel a surface, grip an object, say what it is, how sure, and why.",
)

# One file a group: its register(app) adds its commands and imports nothing heavy before a command runs.
COMMAND_GROUPS: tuple[str, ...] = (
    "touch",
    "corpus",
    "learn",
    "evaluate",
    "grasp",
    "paper",
    "skin",
    "sensor",
    "hand",
    "perceive",
    "objects",
    "live",
    "info",
    "convert",
    "record",
    "replay",
    "demo",
    "doctor",
    "sources",
)

for _group in COMMAND_GROUPS:
    import_module(f"varishold.cli.{_group}").register(app)
for _typer in (app, *(group.typer_instance for group in app.registered_groups)):
    for _command in _typer.registered_commands if _typer is not None else ():
        if _command.callback is not None:
            _command.callback = guarded(_command.callback)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"varishold {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(
        False, "--version", help="Print the version and leave.", callback=_print_version, is_eager=True
    ),
) -> None:
    pass


def run() -> int:
    """Run the program and return its exit status; an error becomes one line."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            # Closed by whoever started the program.
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            # A terminal that cannot show a character shows its code instead.
            stream.reconfigure(errors="backslashreplace")
    try:
        status = _run()
        sys.stdout.flush()
        return status
    except VarisholdError as error:
        return _fail(str(error))
    except ModuleNotFoundError as error:
        told = missing_extra(error)
        if told is error:
            raise
        return _fail(str(told))
    except BrokenPipeError:
        # The reader of a pipe (head, less) went away: no complaint.
        _silence()
        return 1
    except MemoryError as error:
        return _fail(f"not enough memory: {str(error) or 'ask for less at once'}")
    except OSError as error:
        _silence()
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{(error.strerror or str(error)).lower()}")


def _run() -> int:
    try:
        app()
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else int(left.code is not None)
    return 0


def _fail(message: str) -> int:
    print(f"varishold: {' '.join(printable(message).split())}", file=sys.stderr)
    return 1


def _silence() -> None:
    """Nothing more goes to standard output, not even what waits when the interpreter ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
