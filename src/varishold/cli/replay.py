"""``varishold replay``: a recording watched as if it were measured now."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads
from varishold.cli.options import PitchM, Shape
from varishold.errors import InputError


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(replay)


def replay(
    file: Annotated[str, Argument("A recording of any format.", metavar="FILE"), Reads()],
    speed: Annotated[float, Option("Its seconds in one of ours; 0 for as fast as it goes.", min=0.0, max=1e6)] = 1.0,
    loop: Annotated[bool, Option("Begin again at its end.")] = False,
    shape: Shape = None,
    pitch_m: PitchM = None,
    sensor: Annotated[
        str | None,
        Option("Sensor file (TOML) or a preset's name. Default: the one inside or beside the recording."),
        Reads("sensor"),
    ] = None,
    model: Annotated[
        Path | None, Option("Model that was learned (NPZ): names each press.", metavar="MODEL"), Reads()
    ] = None,
    port: Annotated[
        int | None, Option("Port of the page, 0 for one that is free; else 8765.", min=0, max=65535)
    ] = None,
    no_open: Annotated[bool, Option("Do not open the page in a browser.")] = False,
    json: Annotated[bool, Option("Print JSON Lines: frames, events, presses; no page unless --port is given.")] = False,
) -> None:
    """Play a recording, and say what touches as if it were measured now."""
    from varishold.cli.live import live
    from varishold.cli.recordings import sensor_for

    known = sensor_for(file, sensor)
    options = {"speed": f"{speed:g}", "loop": f"{loop:d}"}
    if known is not None:
        # What the file leaves unsaid its sensor says.
        options["polarity"] = known.polarity
        if shape is None and known.shape is not None:
            shape = f"{known.shape[0]}x{known.shape[1]}"
    if shape is not None:
        options["shape"] = shape
    if pitch_m is not None:
        options["pitch_m"] = repr(pitch_m)
    if "?" in file:
        raise InputError(f"{file}: a file that is played must have no ? in its name")
    source = f"replay:{file}?{'&'.join(f'{name}={value}' for name, value in options.items())}"
    live(source, sensor=sensor, model=model, port=port, no_open=no_open, json=json)
