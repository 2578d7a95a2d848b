"""Commands on recordings take one file, several, folders, patterns or standard input, all alike."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import typer

from varishold.cli.files import with_option
from varishold.cli.printing import printable

if TYPE_CHECKING:
    from varishold.recording import Recording

__all__ = ["each_recording"]


def each_recording(
    names: Sequence[str],
    work: Callable[[Recording], None],
    *,
    shape: tuple[int, int] | None = None,
    pitch_m: float | None = None,
    heading: bool = False,
) -> None:
    """Read every recording that is named and do `work` with it.

    What is wrong with one of several is told, the others are still done, and the exit status is 1.

    Parameters
    ----------
    names : sequence of str
        Files, folders, patterns, or ``-``.
    work : callable
        Takes a recording.
    shape, pitch_m
        As those of `varishold.read`.
    heading : bool
        Print each file's name before its answers, where there are several.
    """
    from varishold.errors import InputError
    from varishold.files import input_files
    from varishold.recording import FORMATS, read

    files = input_files(names, endings=[ending for known in FORMATS.values() for ending in known.suffixes])
    failed = False
    for file in files:
        try:
            recording = read(file, shape=shape, pitch_m=pitch_m)
            if heading and len(files) > 1:
                typer.echo(printable(f"{file}:"))
            work(recording)
        except InputError as error:
            if len(files) == 1:
                raise
            failed = True
            message = with_option(error)
            named = message if message.startswith(file) else f"{file}: {message}"
            print(f"varishold: {' '.join(printable(named).split())}", file=sys.stderr)
    if failed:
        raise typer.Exit(1)
