"""The page of `varishold sensor calibrate`: the map before and after, the response, and what is left."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.calibration.result import Calibration
from varishold.report.page import render_page, write_page
from varishold.report.quantities import number, percent
from varishold.report.response_plot import response_plot
from varishold.report.taxel_map import taxel_map
from varishold.report.wording import sentences

__all__ = ["render_calibration_report", "write_calibration_report"]

_HEADINGS = {
    "even": "an even pressure",
    "objects": "known objects",
    "unlabelled": "presses of anything",
    "scale": "a tip on a scale",
}
_UNDONE = "the same presses, their own gains undone"
# What the maps show of each kind, before and after.
_WORDS = {
    "even": ("reading beside the usual taxel's, as it came", _UNDONE),
    "objects": ("highest reading of each taxel, of the highest", "reading beside what the fit predicts"),
    "unlabelled": ("reading beside the neighbours', on the median of the presses", _UNDONE),
    "scale": ("reading beside the force, for presses at this taxel", _UNDONE),
}


@dataclass(frozen=True)
class MapPane:
    """A map with its words."""

    picture: Markup
    words: str


def write_calibration_report(path: str | os.PathLike[str], calibration: Calibration, *, title: str) -> None:
    """Write a self-contained page about a calibration.

    Parameters
    ----------
    path : str or path-like
        The HTML file to write.
    calibration : Calibration
        What was found.
    title : str
        Heading.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_page(path, render_calibration_report(calibration, title=title))


def render_calibration_report(calibration: Calibration, *, title: str) -> str:
    """Return the page that `write_calibration_report` writes."""
    before_words, after_words = _WORDS[calibration.kind]
    if calibration.kind == "objects" and np.isfinite(calibration.error).any():
        before_words = "reading beside what the fit would predict of taxels that are all alike"
    before, after, left = calibration.before, calibration.after, calibration.residual
    low, high = _range(before, after)
    panes = [
        MapPane(taxel_map(before, low, high, label=before_words), f"Before: {before_words}. {_spread(before)}"),
        MapPane(taxel_map(after, low, high, label=after_words), f"After: {after_words}. {_spread(after)}"),
        MapPane(
            taxel_map(left, 0.0, _top(left), label="what is left unexplained"),
            f"What is left unexplained at each taxel, on the mean {percent(_mean(left))} of a press.",
        ),
    ]
    curve = calibration.curve
    sensor = calibration.sensor
    return render_page(
        "calibration.html",
        title=title,
        facts=[
            ("calibrated by", _HEADINGS[calibration.kind]),
            ("presses", str(calibration.presses)),
            ("taxels", "unknown" if sensor.shape is None else f"{sensor.shape[0]} × {sensor.shape[1]}"),
            ("response", sensor.response.kind),
        ],
        found=[
            (each.name.replace("_", " "), _value(each.value, each.share), _value(each.error, each.share), each.says)
            for each in calibration.findings
        ],
        notes=sentences([*(f"not known: {words}" for words in calibration.unknown), *calibration.notes]),
        panes=panes,
        plot=None if curve is None else response_plot(sensor.response, curve, sensor.dead_band, sensor.saturation),
        scale=(number(low), number(high)),
    )


def _value(value: float, share: bool) -> str:
    return percent(value) if share else number(value)


def _range(*maps: NDArray[np.float64]) -> tuple[float, float]:
    values = np.concatenate([m[np.isfinite(m)] for m in maps])
    if values.size == 0:
        return 0.0, 1.0
    low, high = np.quantile(values, (0.01, 0.99)).tolist()
    return float(low), float(max(high, low + 1e-9))


def _top(values: NDArray[np.float64]) -> float:
    inside = values[np.isfinite(values)]
    return float(np.quantile(inside, 0.99)) if inside.size and inside.max() > 0 else 1.0


def _mean(values: NDArray[np.float64]) -> float:
    inside = values[np.isfinite(values)]
    return float(inside.mean()) if inside.size else 0.0


def _spread(values: NDArray[np.float64]) -> str:
    inside = values[np.isfinite(values)]
    return f"Taxels differ by {percent(float(inside.std()))}." if inside.size else "No taxel was pressed enough."
