"""The paper's closing remark as a figure: right answers against the length of the fingers."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from varishold.report.figure_file import figure_kind, new_figure, save_figure

__all__ = ["draw_finger_lengths"]


def draw_finger_lengths(rows: Sequence[Mapping[str, Any]], path: str | os.PathLike[str]) -> None:
    """Draw right answers and grasps held against the length of the digits.

    Parameters
    ----------
    rows : sequence of mappings
        One a length, with ``finger_scale``, ``mean_percent`` (by group of function) and ``held_percent``.
    path : str or path-like
        PNG, SVG or PDF, by its ending.

    Raises
    ------
    InputError
        If the ending is none of these, or the file cannot be written.
    """
    figure_kind(path)
    figure = new_figure(5.6, 3.4, beside=path)
    axes = figure.add_subplot()
    scales = [row["finger_scale"] for row in rows]
    for group in rows[0]["mean_percent"]:
        axes.plot(scales, [row["mean_percent"][group] for row in rows], marker="o", label=group)
    axes.plot(scales, [row["held_percent"] for row in rows], color="0.6", linestyle="--", label="held")
    axes.set(xlabel="length of the digits, times the usual", ylabel="percent of grasps", ylim=(0, 103))
    axes.set_xticks(scales)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, loc="lower right")
    save_figure(figure, path, dpi=150)
