"""``varishold measure``, and what else writes one table of many recordings, on many workers."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import click

from varishold._counted import counted
from varishold.cli.command import Argument, Commands, Option
from varishold.cli.files import Reads, Writes, with_option
from varishold.cli.options import Cluster, KeepParts, PitchM, SensorFile, Shape, Workers
from varishold.cli.printing import echo, parse_shape, print_json, printable

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractContextManager

    from varishold.corpus import Outcome
    from varishold.corpus.ask import Ask
    from varishold.files.crew import Worker

__all__ = ["Spread", "crew", "recognize_corpus", "touch_corpus"]

# So many recordings that failed are named once more at the end.
_MOST_NAMED = 5


@dataclass(frozen=True)
class Spread:
    """How a table is made.

    Parameters
    ----------
    output : Path
    workers : int or None
    cluster : str or None
    keep_parts : bool
    report : Path or None
        The summary page.
    json : bool
    """

    output: Path
    workers: int | None
    cluster: str | None
    keep_parts: bool
    report: Path | None
    json: bool


def register(app: Commands) -> None:
    """Add the command to the program."""
    app.command()(measure)


# A sensor file, a shape as it was written, and a pitch.
_Reading = tuple[str | None, str | None, float | None]


def measure(
    files: Annotated[
        list[str], Argument("Recordings: files, folders, patterns.", metavar="FILE..."), Reads("recordings")
    ],
    output: Annotated[
        Path,
        Option("Table to write (Parquet).", short="-o", metavar="TABLE"),
        Writes("table", ending=".parquet"),
    ],
    levels: Annotated[int, Option("Thresholds a contact.", min=4, max=512)] = 32,
    floor: Annotated[
        float | None, Option("Where contacts end, in the recording's unit. Default: by its noise.", min=0.0)
    ] = None,
    sensor: SensorFile = None,
    pitch_m: PitchM = None,
    shape: Shape = None,
    workers: Workers = None,
    cluster: Cluster = None,
    keep_parts: KeepParts = False,
    json: Annotated[bool, Option("Print one JSON object.")] = False,
) -> None:
    """Measure every contact of recordings: area, perimeter, moments, widths, parts and holes, in one table."""
    from varishold.corpus import AskMeasure

    spread = Spread(output, workers, cluster, keep_parts, None, json)
    _leave(_write_table(files, AskMeasure(levels, floor), spread, (sensor, shape, pitch_m)))


def touch_corpus(
    files: list[str],
    spread: Spread,
    *,
    frames: str | None,
    levels: int,
    skin: Path | None,
    exact: bool,
    reading: _Reading,
) -> None:
    """Write a table of every contact of many recordings."""
    from varishold.corpus import AskTouch
    from varishold.sensor import read_skin

    known = None if skin is None else read_skin(skin)
    found = _write_table(files, AskTouch("all" if frames is None else frames, levels, known, exact), spread, reading)
    if spread.report is not None:
        from varishold.corpus.summary import summarize_names
        from varishold.report import write_corpus_report

        summary = summarize_names(spread.output, found)
        write_corpus_report(spread.report, summary, title=spread.output.name, look=_how_to_look)
        if not spread.json:
            echo(f"report: {spread.report}")
    _leave(found)


def recognize_corpus(model: Path, files: list[str], spread: Spread, sensor: str | None) -> None:
    """Write a table of every press of many recordings."""
    from varishold.corpus import AskRecognize

    _leave(_write_table(files, AskRecognize.of_model(str(model.absolute())), spread, (sensor, None, None)))


def _write_table(files: list[str], ask: Ask, spread: Spread, reading: _Reading) -> Outcome:
    from varishold.cli.progress import progress_bar
    from varishold.cli.recordings import recording_files
    from varishold.corpus.opened import Reading
    from varishold.corpus.run import run_corpus
    from varishold.errors import InputError

    who = _crew(spread)
    named = recording_files(files)
    if "-" in named:
        raise InputError("-: standard input cannot be shared among workers; save it to a file")
    sensor, shape, pitch_m = reading
    with progress_bar(f"{ask.title}: frames") as update:
        found = run_corpus(
            named,
            ask,
            spread.output,
            reading=Reading(sensor, parse_shape(shape), pitch_m),
            **who,
            keep_parts=spread.keep_parts,
            tell=_tell,
            explain=with_option,
            tick=update,
        )
    n_good = len(found.health)
    if spread.json:
        print_json(
            {
                "output": str(spread.output),
                "rows": found.n_rows,
                "frames": found.n_frames,
                "recordings": n_good,
                "failures": dict(found.failures),
                "parts": None if found.folder is None else str(found.folder),
            }
        )
    else:
        echo(
            f"{spread.output}: {counted(found.n_rows, ask.counted)} in {counted(found.n_frames, 'frame')} of "
            f"{counted(n_good, 'recording')}"
        )
        if found.failures:
            # Each was told as it failed, in a line of its own.
            some, more = [*found.failures][:_MOST_NAMED], len(found.failures) - _MOST_NAMED
            names = ", ".join(some) + (f" and {more} more" if more > 0 else "")
            echo(
                f"note: {names} not in it; mend or leave out, and run again: the parts of the "
                f"others wait in {found.folder}"
            )
    return found


def crew(workers: int | None, cluster: str | None, *, usual: int) -> int | AbstractContextManager[Sequence[Worker]]:
    """Return who works: so many processes, as many as usual where nothing is asked for, or a cluster."""
    if cluster is None:
        return usual if workers is None else workers
    from varishold.corpus.cluster import LOCAL
    from varishold.corpus.cluster import cluster as workers_of
    from varishold.errors import InputError

    if workers is not None and cluster != LOCAL:
        raise InputError("--workers are of this machine, --cluster has its own: leave one out")
    return workers_of(cluster, number=workers)


def _leave(found: Outcome) -> None:
    """End with status 1 where a recording failed."""
    if found.failures:
        raise click.exceptions.Exit(1)


def _crew(spread: Spread) -> dict[str, Any]:
    """Return who works, as `run_corpus` is told."""
    from varishold.corpus.tasks import do_elsewhere
    from varishold.files.crew import processors

    workers = crew(spread.workers, spread.cluster, usual=processors())
    return {"workers": workers} if spread.cluster is None else {"workers": workers, "work": do_elsewhere}


def _tell(line: str) -> None:
    print(f"varishold: {' '.join(printable(line).split())}", file=sys.stderr, flush=True)


def _how_to_look(file: str, frame: int) -> str:
    """Return the command that shows a frame of a recording."""
    return f"varishold touch {quote(file)} --frames {frame} --report page.html"
