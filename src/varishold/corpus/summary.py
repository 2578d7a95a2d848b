"""A table of names in short: how many contacts of which name and size, the doubtful ones first, health by file and day.

The table is gone through once, some rows at a time, so that it may be as long as it likes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.corpus.columns import FILE
from varishold.corpus.run import Outcome

if TYPE_CHECKING:
    import pyarrow

__all__ = ["Doubtful", "FileHealth", "NameCount", "Sizes", "Summary", "summarize_names"]

#: A name of a lower probability is doubtful: the names that hold 90 % are more than one.
SURE = 0.9
# Doubtful contacts that are shown, and of frames so near one another only one.
_MOST_DOUBTFUL, _NEAR = 48, 64
# Sizes are counted in so many steps a decade from the least on: in metres, or in taxels.
_STEPS, _LEAST_M, _LEAST_TAXELS, _DECADES = 20, 1e-5, 1e-1, 6
# Rows that are in memory at a time.
_ROWS = 1 << 16
# Times between these are those of a calendar, in seconds since 1970; others count from a start that nobody knows.
_CALENDAR_S = (946684800.0, 4102444800.0)
_COLUMNS = (
    "file", "frame", "time_s", "pad", "contact", "name", "probability", "answer_set",
    "size_long_m", "size_short_m", "size_long_taxels", "size_short_taxels",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Sizes:
    """How often which size occurred.

    Parameters
    ----------
    least : float
        Where the first step begins: metres, or taxels.
    counts : ndarray of shape (n_steps,), int64
        Long sides in each step; each is a twentieth of a decade wide.
    """

    least: float
    counts: NDArray[np.int64]

    @property
    def n(self) -> int:
        return int(self.counts.sum())

    def quantile(self, share: float) -> float:
        """Return the size below which that share is, to a step's width; NaN of none."""
        if not self.n:
            return float("nan")
        step = int(np.searchsorted(np.cumsum(self.counts), share * self.n))
        return float(self.least * 10 ** ((min(step, self.counts.size - 1) + 0.5) / _STEPS))


@dataclass(frozen=True, eq=False)
class NameCount:
    """How often a name was given.

    Parameters
    ----------
    name : str
    n, n_sure : int
        Contacts, and those of which the name has 90 % or more.
    n_files : int
        Recordings in which it was given.
    metres, taxels : Sizes
        Of contacts whose pitch is known, and of the others.
    """

    name: str
    n: int
    n_sure: int
    n_files: int
    metres: Sizes
    taxels: Sizes


@dataclass(frozen=True)
class Doubtful:
    """A contact whose name is doubtful.

    Parameters
    ----------
    file : str
    frame, contact : int
    time_s : float or None
    pad, name : str
    probability : float
    answer_set : tuple of str
        The names that hold 90 %.
    size : (float, float)
        Long and short side, metres or taxels.
    metres : bool
    """

    file: str
    frame: int
    contact: int
    time_s: float | None
    pad: str
    name: str
    probability: float
    answer_set: tuple[str, ...]
    size: tuple[float, float]
    metres: bool


@dataclass(frozen=True)
class FileHealth:
    """How a recording is, and what was found in it.

    Parameters
    ----------
    file : str
    day : str
        By its clock, in UTC, as 2026-11-22; empty where that counts from a start that nobody knows.
    n_frames, n_contacts, n_doubtful : int
    n_taxels, n_broken, n_lacking : int
        Taxels, those that do not work, and frames that are missing in gaps.
    duration_s : float or None
    says : tuple of str
        What is wrong, in words.
    failure : str
        Why it was not answered; empty where it was.
    """

    file: str
    day: str
    n_frames: int
    n_contacts: int
    n_doubtful: int
    n_taxels: int
    n_broken: int
    n_lacking: int
    duration_s: float | None
    says: tuple[str, ...]
    failure: str = ""


@dataclass(frozen=True)
class Summary:
    """A table of names in short.

    Parameters
    ----------
    names : tuple of NameCount
        The most frequent first.
    doubtful : tuple of Doubtful
        The most doubtful first; of neighbouring frames one.
    files : tuple of FileHealth
        In the order of the table, then those that failed.
    """

    names: tuple[NameCount, ...]
    doubtful: tuple[Doubtful, ...]
    files: tuple[FileHealth, ...]

    @property
    def n_contacts(self) -> int:
        return sum(name.n for name in self.names)


def summarize_names(table: str | os.PathLike[str], outcome: Outcome) -> Summary:
    """Go once through a table of names.

    Parameters
    ----------
    table : path-like
        As `run_corpus` wrote it for `AskTouch`.
    outcome : Outcome
        What it said about it.
    """
    from pyarrow import parquet

    counted = _Counted()
    with parquet.ParquetFile(table) as file:
        for batch in file.iter_batches(_ROWS, columns=list(_COLUMNS)):
            counted.add(batch)
    files = [_health(name, health, counted) for name, health in outcome.health.items()]
    files += [FileHealth(name, "", 0, 0, 0, 0, 0, 0, None, (), why) for name, why in outcome.failures.items()]
    return Summary(counted.names, counted.doubtful, tuple(files))


@dataclass
class _Tally:
    n: int = 0
    n_sure: int = 0
    files: set[str] = field(default_factory=set)
    metres: NDArray[np.int64] = field(default_factory=lambda: np.zeros(_STEPS * _DECADES, np.int64))
    taxels: NDArray[np.int64] = field(default_factory=lambda: np.zeros(_STEPS * _DECADES, np.int64))


class _Counted:
    """What was counted so far."""

    def __init__(self) -> None:
        self._names: dict[str, _Tally] = {}
        self.by_file: dict[str, list[int]] = {}
        # The least doubtful of them first.
        self._kept: list[tuple[float, int, Doubtful]] = []
        self._number = 0

    def add(self, batch: pyarrow.RecordBatch) -> None:
        """Take some rows."""
        texts = {name: batch.column(name).dictionary_encode() for name in (FILE.name, "name")}
        codes = {name: column.indices.to_numpy() for name, column in texts.items()}
        words = {name: column.dictionary.to_pylist() for name, column in texts.items()}
        probability = batch.column("probability").to_numpy()
        sure = probability >= SURE
        for code, file in enumerate(words[FILE.name]):
            here = codes[FILE.name] == code
            counts = self.by_file.setdefault(file, [0, 0])
            counts[0] += int(np.count_nonzero(here))
            counts[1] += int(np.count_nonzero(here & ~sure))
        lengths = {unit: _numbers(batch.column(f"size_long_{unit}")) for unit in ("m", "taxels")}
        for code, name in enumerate(words["name"]):
            here = codes["name"] == code
            tally = self._names.setdefault(name, _Tally())
            tally.n += int(np.count_nonzero(here))
            tally.n_sure += int(np.count_nonzero(here & sure))
            tally.files.update(words[FILE.name][k] for k in np.unique(codes[FILE.name][here]))
            known = np.isfinite(lengths["m"])
            tally.metres += _steps(lengths["m"][here & known], _LEAST_M)
            tally.taxels += _steps(lengths["taxels"][here & ~known], _LEAST_TAXELS)
        self._doubt(batch, codes[FILE.name], probability)

    def _doubt(self, batch: pyarrow.RecordBatch, file: NDArray[Any], probability: NDArray[np.float64]) -> None:
        """Keep the most doubtful rows, one of neighbours."""
        unsure = np.flatnonzero(probability < SURE)
        near = batch.column("frame").to_numpy()[unsure] // _NEAR
        pad = batch.column("pad").dictionary_encode().indices.to_numpy()[unsure]
        order = np.lexsort((unsure, probability[unsure], near, pad, file[unsure]))
        place = np.stack([file[unsure], pad, near], axis=1)[order]
        first = np.flatnonzero(np.r_[True, (np.diff(place, axis=0) != 0).any(axis=1)]) if unsure.size else unsure
        for row in unsure[order][first][np.argsort(probability[unsure[order][first]], kind="stable")][:_MOST_DOUBTFUL]:
            if len(self._kept) == _MOST_DOUBTFUL and -probability[row] <= self._kept[0][0]:
                break
            self._number += 1
            entry = (-float(probability[row]), -self._number, _doubtful(batch.slice(int(row), 1).to_pylist()[0]))
            self._kept = sorted([*self._kept, entry], key=lambda kept: kept[:2])[-_MOST_DOUBTFUL:]

    @property
    def names(self) -> tuple[NameCount, ...]:
        counts = (
            NameCount(
                name,
                tally.n,
                tally.n_sure,
                len(tally.files),
                Sizes(_LEAST_M, tally.metres),
                Sizes(_LEAST_TAXELS, tally.taxels),
            )
            for name, tally in self._names.items()
        )
        return tuple(sorted(counts, key=lambda count: (-count.n, count.name)))

    @property
    def doubtful(self) -> tuple[Doubtful, ...]:
        return tuple(kept for *_, kept in reversed(self._kept))


def _numbers(column: pyarrow.Array) -> NDArray[np.float64]:
    found: NDArray[np.float64] = column.to_numpy(zero_copy_only=False)
    return found.astype(np.float64)


def _steps(sizes: NDArray[np.float64], least: float) -> NDArray[np.int64]:
    """Return how many sizes are in each step."""
    sizes = sizes[sizes > 0]
    step = np.floor(np.log10(sizes / least) * _STEPS).clip(0, _STEPS * _DECADES - 1).astype(np.intp)
    return np.bincount(step, minlength=_STEPS * _DECADES).astype(np.int64)


def _doubtful(row: Mapping[str, Any]) -> Doubtful:
    metres = row["size_long_m"] is not None
    unit = "m" if metres else "taxels"
    return Doubtful(
        file=row["file"],
        frame=row["frame"],
        contact=row["contact"],
        time_s=row["time_s"],
        pad=row["pad"],
        name=row["name"],
        probability=row["probability"],
        answer_set=tuple(row["answer_set"]),
        size=(row[f"size_long_{unit}"], row[f"size_short_{unit}"]),
        metres=metres,
    )


def _health(name: str, health: Mapping[str, Any], counted: _Counted) -> FileHealth:
    n_contacts, n_doubtful = counted.by_file.get(name, (0, 0))
    return FileHealth(
        file=name,
        day=_day(health["begin_s"]),
        n_frames=health["n_frames"],
        n_contacts=n_contacts,
        n_doubtful=n_doubtful,
        n_taxels=health["n_taxels"],
        n_broken=health["n_broken"],
        n_lacking=health["n_lacking"],
        duration_s=health["duration_s"],
        says=(*health["faults"], *health["notes"]),
    )


def _day(begin_s: float | None) -> str:
    if begin_s is None or not _CALENDAR_S[0] <= begin_s <= _CALENDAR_S[1]:
        return ""
    return datetime.fromtimestamp(begin_s, UTC).date().isoformat()
