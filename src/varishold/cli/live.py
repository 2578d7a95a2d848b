"""``varishold live``: watch a sensor while it is touched."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from varishold.cli.files import Reads
from varishold.cli.printing import print_json, printable

if TYPE_CHECKING:
    from varishold.live.stream import Change


def register(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(live)


def live(
    source: Annotated[
        str,
        typer.Argument(help="Where the readings come from, as in sim:sphere or serial:/dev/ttyACM0?preset=flexitac."),
    ],
    sensor: Annotated[
        str | None,
        typer.Option(help="Sensor file (TOML) or a preset's name (varishold sensor list).", metavar="SENSOR"),
        Reads(sensor=True),
    ] = None,
    model: Annotated[
        Path | None, typer.Option(help="Model that was learned (NPZ): names each press.", metavar="MODEL"), Reads()
    ] = None,
    levels: Annotated[int, typer.Option(help="Thresholds a contact.", min=4, max=512)] = 32,
    json: Annotated[bool, typer.Option("--json", help="Print JSON Lines: frames, events, presses.")] = False,
) -> None:
    """Say what touches a sensor while it touches."""
    from varishold.live.address import parse_address
    from varishold.live.lines import change_line, lines_of
    from varishold.live.watching import watch
    from varishold.sensor import sensor_of

    known_sensor = None if sensor is None else sensor_of(sensor)
    learned = None
    if model is not None:
        from varishold.learning import read_model

        learned = read_model(model)
    address = parse_address(source)
    every = address.options.get("speed") == "0" or address.kind == "stdin"

    def tell(change: Change) -> None:
        print_json(change_line(change))
        if change.state == "lost":
            print(f"varishold: {printable(change.words)}; trying again", file=sys.stderr)

    for seen in watch(source, sensor=known_sensor, model=learned, levels=levels, every=every, on_change=tell):
        for line in lines_of(seen):
            print_json(line)
        sys.stdout.flush()
