"""The program ``varishold``: its command groups, and how an error reaches a person."""

from __future__ import annotations

import io
import os
import sys
from importlib import import_module

import click

from varishold import __version__
from varishold._lazy import missing_extra
from varishold.cli.command import Commands
from varishold.cli.printing import printable
from varishold.errors import FULL_DISK, VarisholdError, reason_of

app = Commands(
    "varishold",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True},
    help="Tactile pattern recognition: feel a surface, grip an object, say what it is, how sure, and why.",
)
click.version_option(__version__, message="varishold %(version)s", help="Print the version and leave.")(app)

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
        where = _where(error)
        return _fail(f"{where}: {reason_of(error)}" if where else reason_of(error))


def _run() -> int:
    try:
        return app(prog_name="varishold", standalone_mode=False) or 0
    except click.ClickException as error:
        return _misused(error)
    except click.Abort:
        return _fail("aborted")
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else int(left.code is not None)


def _misused(error: click.ClickException) -> int:
    """Say what was wrong in how the program was called, and where that is told."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    command = "varishold" if context is None else context.command_path
    words = error.format_message().strip().removesuffix(".")
    words = f"{words[:1].lower()}{words[1:]} ({command} --help)"
    _fail(": ".join([*command.split(maxsplit=1)[1:], words]))
    return error.exit_code


def _where(error: OSError) -> str:
    """Say where a system's error is; what opens or writes a file names it."""
    if error.filename:
        return str(error.filename)
    if error.errno in FULL_DISK:
        # What is printed has no place.
        return "standard output"
    try:
        os.getcwd()
    except OSError:
        return "the current folder"
    return ""


def _fail(message: str) -> int:
    print(f"varishold: {' '.join(printable(message).split())}", file=sys.stderr)
    return 1


def _silence() -> None:
    """Nothing more goes to standard output, not even what waits when the interpreter ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
