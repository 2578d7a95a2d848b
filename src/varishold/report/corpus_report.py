"""The page of `varishold touch -o`: contacts by name and size, the doubtful ones first, health by file and day."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from varishold._counted import counted
from varishold.corpus.summary import Doubtful, FileHealth, NameCount, Sizes, Summary
from varishold.report.page import render_page, write_page
from varishold.report.quantities import length, number, percent
from varishold.report.size_bars import size_bars
from varishold.report.wording import sentences

__all__ = ["render_corpus_report", "write_corpus_report"]

# Files that are listed, and failures that are told one by one.
_MOST_FILES, _MOST_FAILURES = 400, 12


@dataclass(frozen=True)
class NameRow:
    """A line of the table of names."""

    name: str
    count: str
    share: float
    files: int
    sure: str
    size: str
    between: str
    bars: Markup


@dataclass(frozen=True)
class DoubtfulRow:
    """A line of the table of doubtful contacts."""

    name: str
    share: float
    probability: str
    among: str
    size: str
    file: str
    frame: int
    time: str
    pad: str
    contact: int


@dataclass(frozen=True)
class HealthRow:
    """A line of a table of health: of a file, or of a day."""

    name: str
    recordings: int
    frames: str
    duration: str
    contacts: str
    doubtful: str
    broken: str
    lacking: str
    says: tuple[str, ...]


def write_corpus_report(
    path: str | os.PathLike[str], summary: Summary, *, title: str, look: Callable[[str, int], str] | None = None
) -> None:
    """Write a self-contained page about a table of names.

    Parameters
    ----------
    path : str or path-like
        The HTML file to write.
    summary : Summary
    title : str
        Heading.
    look : callable, optional
        Says how somebody looks at a frame of a recording.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_page(path, render_corpus_report(summary, title=title, look=look))


def render_corpus_report(summary: Summary, *, title: str, look: Callable[[str, int], str] | None = None) -> str:
    """Return the page that `write_corpus_report` writes."""
    answered = [file for file in summary.files if not file.failure]
    # Whoever looks for what is wrong finds it first.
    worst = sorted(answered, key=lambda file: (-_trouble(file), file.file))
    days = sorted({file.day for file in answered if file.day})
    return render_page(
        "corpus.html",
        title=title,
        facts=_facts(summary, answered, days),
        n_contacts=_counted(summary.n_contacts),
        tally=[(name.name, _counted(name.n)) for name in summary.names],
        warnings=_warnings(summary, answered),
        names=[_name_row(name, summary.n_contacts) for name in summary.names],
        look="" if look is None or not summary.doubtful else look(summary.doubtful[0].file, summary.doubtful[0].frame),
        doubtful=[_doubtful_row(one) for one in summary.doubtful],
        several_pads=len({one.pad for one in summary.doubtful}) > 1,
        days=[_health_row(day, [file for file in answered if file.day == day]) for day in days],
        files=[_health_row(file.file, [file]) for file in worst[:_MOST_FILES]],
        n_more=max(0, len(worst) - _MOST_FILES),
    )


def _facts(summary: Summary, answered: Sequence[FileHealth], days: Sequence[str]) -> list[tuple[str, str]]:
    facts = [
        ("recordings", _counted(len(answered))),
        ("frames", _counted(sum(file.n_frames for file in answered))),
        ("contacts", _counted(summary.n_contacts)),
    ]
    lasts_s = [file.duration_s for file in answered if file.duration_s is not None]
    if lasts_s:
        facts.append(("duration", _duration(sum(lasts_s))))
    if days:
        facts.append(("days", days[0] if len(days) == 1 else f"{len(days)}, {days[0]} to {days[-1]}"))
    return facts


def _warnings(summary: Summary, answered: Sequence[FileHealth]) -> tuple[str, ...]:
    failed = [file for file in summary.files if file.failure]
    said = [f"not in the table: {file.failure}" for file in failed[:_MOST_FAILURES]]
    if len(failed) > _MOST_FAILURES:
        said.append(
            f"{counted(len(failed) - _MOST_FAILURES, 'more recording is', 'more recordings are')} not in the table; "
            "the command named them"
        )
    n_doubtful, n_contacts = sum(file.n_doubtful for file in answered), sum(file.n_contacts for file in answered)
    if n_doubtful:
        said.append(
            f"{percent(n_doubtful / n_contacts)} of the contacts have a name below 90\u202f%: count names by "
            "their probability, or look at the outline"
        )
    if any(name.taxels.n for name in summary.names):
        said.append("the spacing of taxels is not known of every recording: lengths of these are in taxels")
    return sentences(said)


def _name_row(name: NameCount, total: int) -> NameRow:
    sizes, metres = (name.metres, True) if name.metres.n else (name.taxels, False)
    return NameRow(
        name=name.name,
        count=_counted(name.n),
        share=name.n / max(total, 1),
        files=name.n_files,
        sure=percent(name.n_sure / name.n),
        size="–" if not sizes.n else length(_two(sizes.quantile(0.5)), metres=metres),
        between="" if not sizes.n else _between(sizes, metres),
        bars=size_bars(sizes.counts, label=f"How often which size of {name.name}"),
    )


def _between(sizes: Sizes, metres: bool) -> str:
    low, high = (length(_two(sizes.quantile(share)), metres=metres) for share in (0.05, 0.95))
    return low if low == high else f"{low} to {high}"


def _two(value: float) -> float:
    """Sizes are counted in steps of a twentieth of a decade: two digits are known."""
    return float(f"{value:.1e}") if math.isfinite(value) else value


def _doubtful_row(one: Doubtful) -> DoubtfulRow:
    long, short = (length(side, metres=one.metres) for side in one.size)
    return DoubtfulRow(
        name=one.name,
        share=one.probability,
        probability=percent(one.probability),
        among=", ".join(name for name in one.answer_set if name != one.name),
        size=long if long == short else f"{long} × {short}",
        file=one.file,
        frame=one.frame,
        time="" if one.time_s is None else f"{one.time_s:.2f}\u202fs",
        pad=one.pad,
        contact=one.contact,
    )


def _health_row(name: str, files: Sequence[FileHealth]) -> HealthRow:
    n_contacts = sum(file.n_contacts for file in files)
    n_taxels, n_broken = sum(file.n_taxels for file in files), sum(file.n_broken for file in files)
    lacking = sum(file.n_lacking for file in files)
    lasts_s = [file.duration_s for file in files if file.duration_s is not None]
    return HealthRow(
        name=name,
        recordings=len(files),
        frames=_counted(sum(file.n_frames for file in files)),
        duration=_duration(sum(lasts_s)) if lasts_s else "",
        contacts=_counted(n_contacts),
        doubtful=percent(sum(file.n_doubtful for file in files) / n_contacts) if n_contacts else "",
        broken=f"{_counted(n_broken)} of {_counted(n_taxels)}" if n_broken else "",
        lacking=_counted(lacking) if lacking else "",
        says=sentences(files[0].says) if len(files) == 1 else (),
    )


def _trouble(file: FileHealth) -> float:
    """Return how much is wrong with a recording: the share of its taxels, frames and contacts."""
    return (
        file.n_broken / max(file.n_taxels, 1)
        + file.n_lacking / max(file.n_frames, 1)
        + file.n_doubtful / max(file.n_contacts, 1)
    )


def _counted(n: int) -> str:
    return f"{n:,}".replace(",", "\u202f")


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{number(seconds)}\u202fs"
    minutes = seconds / 60
    return f"{number(minutes)}\u202fmin" if minutes < 120 else f"{number(minutes / 60)}\u202fh"
