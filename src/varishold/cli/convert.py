"""``varishold convert``: from one file format to another."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes
from varishold.cli.options import PitchM, Shape
from varishold.cli.printing import echo


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(convert)


def convert(
    file: Annotated[str, Argument("A recording.", metavar="A"), Reads()],
    output: Annotated[
        Path,
        Argument(
            "What to write: .npz, .mcap, .h5, .mat, .parquet, .lerobot hold all of it; .npy, .csv a pad's frames.",
            metavar="B",
        ),
        Writes("recording"),
    ],
    shape: Shape = None,
    pitch_m: PitchM = None,
    lossy: Annotated[bool, Option("Write it although something is lost, and say what.")] = False,
) -> None:
    """Write a recording in another format: without loss, or not at all."""
    from varishold.cli.printing import parse_shape
    from varishold.recording import read
    from varishold.recording.conversion import beyond_recording
    from varishold.recording.conversion import convert as write_as

    recording = read(file, shape=parse_shape(shape), pitch_m=pitch_m)
    lost = write_as(recording, output, beyond=beyond_recording(file), lossy=lossy)
    for each in lost:
        echo(f"lost: {each}")
    same = "the rest is the same" if lost else "the same"
    echo(f"{output}: {counted(recording.n_frames, 'frame')}, read back and compared: {same}")
