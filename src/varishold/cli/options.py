"""Options that several commands have, each said once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click
from click.core import ParameterSource

from varishold.cli.command import Option
from varishold.cli.files import Reads, Writes

if TYPE_CHECKING:
    from varishold.learning import PressClassifier

__all__ = [
    "Absolute",
    "Cluster",
    "Error",
    "Group",
    "KeepParts",
    "Label",
    "PitchM",
    "Portable",
    "Position",
    "SensorFile",
    "Shape",
    "Table",
    "Workers",
    "classifier_of",
    "option_told",
    "refuse_alone",
    "refuse_given",
]

Label = Annotated[
    str | None,
    Option(
        "Column of the presses that names the thing, or 'folder', that of the recording; 'folder/..' is around it.",
        metavar="COLUMN|folder",
    ),
]
Group = Annotated[
    str | None,
    Option(
        "Column, or 'folder', that names the session, or what else is to be new (sensor, object, size ...); "
        "whole groups are held out.",
        metavar="COLUMN|folder",
    ),
]
Position = Annotated[bool | None, Option("Learn where on the pads a thing is felt.")]
Absolute = Annotated[bool | None, Option("Learn how hard it is pressed.")]
Error = Annotated[
    float | None,
    Option("Share of known things that may be refused as none of these. Default: 0.05.", min=0.001, max=0.5),
]
SensorFile = Annotated[
    str | None,
    Option(
        "Sensor file (TOML) or a preset's name (varishold sensor list). Default: sensor.toml or "
        "FILE.sensor.toml beside the recording."
    ),
    Reads("sensor"),
]
PitchM = Annotated[float | None, Option("Taxel spacing in metres.")]
Shape = Annotated[str | None, Option("Rows x columns of a flat CSV or NPY, as in 16x16.")]
Table = Annotated[
    Path | None,
    Option("Write one table of all answers here (Parquet).", short="-o", metavar="TABLE"),
    Writes("table", ending=".parquet"),
]
Workers = Annotated[
    int | None,
    Option("With -o: processes to work with. Default: one a processor.", min=1, max=4096),
]
Cluster = Annotated[
    str | None,
    Option(
        "With -o: work on a cluster of dask: its scheduler's address, or 'local' for one of this machine.",
        metavar="ADDRESS|local",
    ),
]
KeepParts = Annotated[
    bool,
    Option("With -o: leave the parts there, so that more recordings can be added without redoing all."),
]
Portable = Annotated[
    bool,
    Option("Learn what a skin's own controller can hold; touch export --model writes it."),
]


def classifier_of(
    position: bool | None, absolute: bool | None, error: float | None, *, portable: bool
) -> PressClassifier:
    """Return the classifier that a command's options ask for; what is not said keeps its default."""
    from varishold.errors import InputError
    from varishold.learning import PortableClassifier, TactileClassifier

    said: dict[str, Any] = {} if error is None else {"error": error}
    if not portable:
        return TactileClassifier(position=position, absolute=absolute, **said)
    for name, value in (("position", position), ("absolute", absolute)):
        if value is not None:
            raise InputError(f"--portable looks neither at places nor at loads: leave out {option_told(name, value)}")
    return PortableClassifier(**said)


def option_told(name: str, value: object) -> str:
    """Return an option as it was given: ``--no-peers`` where it says no."""
    return f"--{'no-' if value is False else ''}{name.replace('_', '-')}"


def refuse_given(*names: str, because: str) -> None:
    """Refuse options that were given to the command that runs and say nothing there; names are the parameters'."""
    from varishold.errors import InputError

    context = click.get_current_context(silent=True)
    for name in names:
        if context is not None and context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise InputError(f"{option_told(name, context.params[name])} {because}")


def refuse_alone(**options: object) -> None:
    """Refuse options that mean nothing without -o; those that were not given are None."""
    from varishold.errors import InputError

    for name, value in options.items():
        if value is not None:
            raise InputError(f"{option_told(name, value)} is for tables: name one with -o, or leave it out")
