"""Commands that write one table of many recordings, on many workers."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from varishold.cli.files import with_option
from varishold.cli.printing import echo, parse_shape, print_json, printable

if TYPE_CHECKING:
    from varishold.corpus.ask import Ask

__all__ = ["Spread", "touch_corpus"]


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


# A sensor file, a shape as it was written, and a pitch.
_Reading = tuple[str | None, str | None, float | None]


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
    _write_table(files, AskTouch(frames or "all", levels, known, exact), spread, reading, what="contacts")


def _write_table(files: list[str], ask: Ask, spread: Spread, reading: _Reading, *, what: str) -> None:
    from varishold.cli.progress import progress_bar
    from varishold.cli.recordings import recording_files
    from varishold.corpus.cluster import LOCAL
    from varishold.corpus.opened import Reading
    from varishold.corpus.run import run_corpus
    from varishold.errors import InputError

    if spread.workers is not None and spread.cluster not in (None, LOCAL):
        raise InputError("--workers are of this machine, --cluster has its own: leave one out")
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
            **_crew(spread),
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
        echo(f"{spread.output}: {found.n_rows} {what} in {found.n_frames} frames of {n_good} recordings")
        if found.failures:
            echo(
                f"note: {len(found.failures)} recordings are not in it; when they are mended, run again: the parts of "
                f"the others wait in {found.folder}"
            )
    if found.failures:
        raise typer.Exit(1)


def _crew(spread: Spread) -> dict[str, Any]:
    """Return who works, as `run_corpus` is told."""
    from varishold.corpus.cluster import cluster
    from varishold.corpus.crew import processors
    from varishold.corpus.tasks import do_elsewhere

    if spread.cluster is None:
        return {"workers": spread.workers or processors()}
    return {"workers": cluster(spread.cluster, number=spread.workers), "work": do_elsewhere}


def _tell(line: str) -> None:
    print(f"varishold: {' '.join(printable(line).split())}", file=sys.stderr, flush=True)
