"""Commands on files take one, several, folders, patterns or standard input, all alike."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import typer

from varishold.cli.files import with_option
from varishold.cli.printing import echo, printable

__all__ = ["each_file", "recording_files"]


def recording_files(names: Sequence[str]) -> list[str]:
    """Return the recordings that are named; of a folder, those that a reader knows by their ending."""
    from varishold.files import input_files
    from varishold.recording import FORMATS

    return input_files(names, endings=[ending for known in FORMATS.values() for ending in known.suffixes])


def each_file(
    names: Sequence[str], work: Callable[[str], None], *, heading: bool = False, endings: Sequence[str] = ()
) -> None:
    """Do `work` with every recording, or table, that is named.

    What is wrong with one of several is told, the others are still done, and the exit status is 1.

    Parameters
    ----------
    names : sequence of str
        Files, folders, patterns, or ``-``.
    work : callable
        Takes the path of a recording.
    heading : bool
        Print each file's name before its answers, where there are several.
    endings : sequence of str
        Endings of the files that are taken from a folder; default: those of recordings.
    """
    from varishold.errors import InputError
    from varishold.files import input_files

    files = input_files(names, endings=endings) if endings else recording_files(names)
    failed = False
    for file in files:
        try:
            if heading and len(files) > 1:
                echo(f"{file}:")
            work(file)
        except InputError as error:
            if len(files) == 1:
                raise
            failed = True
            message = with_option(error)
            named = message if message.startswith(file) else f"{file}: {message}"
            print(f"varishold: {' '.join(printable(named).split())}", file=sys.stderr)
    if failed:
        raise typer.Exit(1)
