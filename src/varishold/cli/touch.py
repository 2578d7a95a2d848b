"""``varishold touch``: recognize the surfaces of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from varishold.touch import Answer


def register(app: typer.Typer) -> None:
    """Add the command to the program."""
    app.command()(touch)


def touch(
    file: Annotated[Path, typer.Argument(help="Recording: NPZ, NPY, CSV or Tekscan ASCII.", metavar="FILE")],
    frames: Annotated[
        str,
        typer.Option(help="'peak' (largest total), 'all', 'press' (one answer a press), or a frame number."),
    ] = "peak",
    skin: Annotated[Path | None, typer.Option(help="Skin file (TOML), where the skin is known.")] = None,
    exact: Annotated[
        bool, typer.Option("--exact", help="Recognize by fitting each form through the skin (needs --skin).")
    ] = False,
    levels: Annotated[int, typer.Option(help="Thresholds a contact.", min=4, max=512)] = 32,
    pitch_m: Annotated[float | None, typer.Option(help="Taxel spacing in metres.")] = None,
    shape: Annotated[str | None, typer.Option(help="Rows x columns of a flat CSV or NPY, as in 16x16.")] = None,
    report: Annotated[Path | None, typer.Option(help="Write a self-contained HTML report here.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object a contact.")] = False,
) -> None:
    """Say what surfaces a recording's contacts are, how sure that is, and why."""
    from varishold.cli.printing import parse_shape, print_answers
    from varishold.errors import InputError
    from varishold.recording import read
    from varishold.touch import recognize_recording

    if exact and skin is None:
        raise InputError("--exact fits forms through the skin and needs --skin SKIN.toml")
    if report is not None and not report.absolute().parent.is_dir():
        raise InputError(f"{report}: cannot write here: there is no folder {report.absolute().parent}; make it first")
    recording = read(file, shape=parse_shape(shape), pitch_m=pitch_m)
    known_skin = None
    if skin is not None:
        from varishold.skin import read_skin

        known_skin = read_skin(skin)
    answers: list[Answer] = print_answers(
        recognize_recording(recording, frames=frames, levels=levels, skin=known_skin, exact=exact), recording, json=json
    )
    if report is not None:
        from varishold.report import write_touch_report

        write_touch_report(report, answers, recording=recording, skin=None if known_skin is None else str(known_skin))
        if not json:
            typer.echo(f"report: {report}")
