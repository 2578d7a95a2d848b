"""The program ``varishold``: its command groups, and how an error reaches a person."""

from __future__ import annotations

import errno
import io
import os
import sys
from importlib import import_module

import typer

from varishold import __version__
from varishold.errors import VarisholdError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Tactile pattern recognition: feel a surface, grip an object, say what it is, how sure, and why.",
)

# One file a group: its register(app) adds its commands and imports nothing heavy before a command runs.
COMMAND_GROUPS: tuple[str, ...] = ("touch", "grasp", "paper", "skin", "sensor", "hand", "perceive")

for _group in COMMAND_GROUPS:
    import_module(f"varishold.cli.{_group}").register(app)


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


def main() -> None:
    """Run the program; bad input ends in one line on standard error and exit status 1."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character shows its code instead.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        app()
    except VarisholdError as error:
        message = " ".join(str(error).split())
        print(f"varishold: {message}", file=sys.stderr)
        sys.exit(1)
    except BrokenPipeError:
        # The reader of a pipe (head, less) went away: no complaint, and no second one at interpreter exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except MemoryError as error:
        print(f"varishold: not enough memory: {error or 'ask for less at once'}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        print("varishold: cannot write: no space left on the device", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        print("varishold: interrupted", file=sys.stderr)
        sys.exit(130)
