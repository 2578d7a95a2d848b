"""A netlist as source: C for a microcontroller, Verilog for an FPGA, JSON for another program.

`WRITERS` is the registry: a writer takes a netlist and a name, and returns the files by name.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

from varishold.circuit.netlist import Netlist
from varishold.circuit.writers.c99 import c99_files
from varishold.circuit.writers.json import json_files
from varishold.circuit.writers.verilog import verilog_files
from varishold.errors import InputError
from varishold.files import write_texts

__all__ = ["WRITERS", "c99_files", "export", "json_files", "verilog_files"]

WRITERS: Final[dict[str, Callable[..., dict[str, str]]]] = {
    "c": c99_files,
    "verilog": verilog_files,
    "json": json_files,
}


def export(
    netlist: Netlist,
    to: str,
    directory: str | os.PathLike[str],
    *,
    name: str = "recognizer",
    check: Callable[[Path], None] | None = None,
) -> list[Path]:
    """Write a netlist's source files into a folder, which is made where it is missing.

    Parameters
    ----------
    netlist : Netlist
    to : str
        A key of `WRITERS`.
    directory : path-like
    name : str
        Of the module; made an identifier, it opens every file's and symbol's name.
    check : callable, optional
        Called with the path of every file before the first is written; it may refuse.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        Where there is no such writer, or the folder cannot be written.
    """
    if to not in WRITERS:
        raise InputError(f"no writer called {to!r}; known are {', '.join(WRITERS)}")
    return write_texts(directory, WRITERS[to](netlist, name), check=check)
