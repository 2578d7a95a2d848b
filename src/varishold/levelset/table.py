"""Every contact of a recording, measured: a table with the field's names and the unit in each."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.errors import MissingExtraError
from varishold.files import atomic_write
from varishold.frame.checks import as_floats
from varishold.levelset.batch import ContactBatch
from varishold.levelset.contacts import asked_of, batch_of
from varishold.levelset.second_moments import principal_angle, principal_moments

__all__ = ["MeasureTable", "Measured", "measure"]


_FRAMES_A_BLOCK = 1024
# How a formula begins.
_FORMULA = ("=", "+", "-", "@")
# Every row's first columns; the others are those of `_measures`.
_ROW = (
    "frame",
    "time_s",
    "pad",
    "contact",
    "peak",
    "threshold",
    "n_taxels",
    "parts",
    "holes",
    "euler_number",
    "orientation_rad",
)
_LENGTHS = {
    "area": "_m2",
    "perimeter": "_m",
    "equivalent_diameter": "_m",
    "centroid_x": "_m",
    "centroid_y": "_m",
    "second_moment_xx": "_m2",
    "second_moment_xy": "_m2",
    "second_moment_yy": "_m2",
    "principal_axis_major": "_m",
    "principal_axis_minor": "_m",
    "feret_width_most": "_m",
    "feret_width_least": "_m",
}


class Measured(Protocol):
    """What can be measured: pads by name, and the time of each frame where it is known."""

    @property
    def pads(self) -> Mapping[str, Any]: ...
    @property
    def time_s(self) -> NDArray[np.float64] | None: ...


class MeasureTable(dict[str, NDArray[Any]]):
    """Columns by name, one row a contact."""

    def write_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV, whole or not at all."""
        with atomic_write(path, "w") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(self)
            rows.writerows(zip(*(_cells(column) for column in self.values()), strict=True))

    def to_pandas(self) -> Any:
        """Return the table as a pandas DataFrame.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingExtraError("a DataFrame needs pandas; install it: pip install pandas") from error
        return pandas.DataFrame(dict(self))


def measure(recording: Measured, *, levels: int = 32, floor: float | None = None) -> MeasureTable:
    """Measure every contact of a recording at its lowest section.

    Parameters
    ----------
    recording : Recording
        Or whatever else has pads and times.
    levels, floor
        As in `find_contacts`.

    Returns
    -------
    MeasureTable
        A dict of arrays: ``frame``, ``time_s`` (NaN where unknown), ``pad``, ``contact``, ``peak``, ``threshold``,
        ``n_taxels``, ``parts``, ``holes``, ``euler_number``, ``orientation_rad``, and with a unit in their names
        ``area``, ``perimeter``, ``equivalent_diameter``, ``centroid_x``, ``centroid_y``, ``second_moment_xx``, ``_xy``,
        ``_yy``, ``principal_axis_major``, ``principal_axis_minor`` (of the ellipse of the same second moments),
        ``feret_width_most`` and ``feret_width_least``. The unit is metres (``area_m2``) where the pitch of every pad is
        known, and taxels (``area_taxels``, ``perimeter_taxels``) otherwise.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> frames = np.maximum(6.0 - np.hypot(x, y), 0.0)[None]
    >>> pad = SimpleNamespace(frames=frames, field=None, valid=None, pitch_m=(0.002, 0.002))
    >>> table = measure(SimpleNamespace(pads={"pad": pad}, time_s=None), floor=1.0)
    >>> float(table["equivalent_diameter_m"].round(4)[0]), int(table["euler_number"][0])
    (0.0196, 1)
    """
    known = all(pad.pitch_m is not None for pad in recording.pads.values())
    names = [*_ROW, *(name + (unit if known else "_taxels") for name, unit in _LENGTHS.items())]
    columns = zip(*_blocks(recording, known, levels, floor), strict=True)
    return MeasureTable((name, np.concatenate(column)) for name, column in zip(names, columns, strict=True))


def _cells(column: NDArray[Any]) -> list[Any]:
    """Return a column's values; a text that a spreadsheet would take for a formula gets an apostrophe."""
    return [f"'{cell}" if isinstance(cell, str) and cell[:1] in _FORMULA else cell for cell in column.tolist()]


def _blocks(recording: Measured, known: bool, levels: int, floor: float | None) -> Iterator[list[NDArray[Any]]]:
    """Yield the columns of some frames after the other, so that no more than those are in memory."""
    n_frames = max(len(pad.frames) for pad in recording.pads.values())
    for start in range(0, max(n_frames, 1), _FRAMES_A_BLOCK):
        parts = []
        for order, (name, pad) in enumerate(recording.pads.items()):
            given = pad.frames[start : start + _FRAMES_A_BLOCK]
            values, pitch = as_floats(given, 3, "frames", masked=True), pad.pitch_m if known else None
            asked = asked_of(given, values.shape[1:], levels, pitch, pad.valid, pad.field, floor, None)
            batch = batch_of(values, asked, start)
            frame = batch.frame + start
            time = np.full(len(frame), np.nan) if recording.time_s is None else np.asarray(recording.time_s)[frame]
            pads = np.full(len(frame), name)
            parts.append([frame, time, pads, batch.number, *_measures(batch), np.full(len(frame), order)])
        columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
        rows = np.lexsort((columns[3], columns[-1], columns[0]))
        yield [column[rows] for column in columns[:-1]]


def _measures(batch: ContactBatch) -> tuple[NDArray[Any], ...]:
    """Return what is measured of each contact's lowest section, in the order of the columns."""
    one, i = np.arange(len(batch.peak)), batch.n_measured - 1
    covariance, centroid = batch.covariance[one, i], batch.centroid[one, i]
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    major, minor = principal_moments(xx, xy, yy)
    area, extent = batch.area[one, i], batch.extent[one, i]
    parts, holes = batch.parts[one, i], batch.holes[one, i]
    return (
        batch.peak,
        batch.threshold[one, i],
        batch.n_taxels,
        parts,
        holes,
        parts - holes,
        principal_angle(xx, xy, yy),
        area,
        batch.perimeter[one, i],
        2 * np.sqrt(area / np.pi),
        centroid[:, 0],
        centroid[:, 1],
        xx,
        xy,
        yy,
        4 * np.sqrt(major),
        4 * np.sqrt(minor),
        extent.max(axis=1),
        extent.min(axis=1),
    )
