"""The paper's closing remark as a figure: right answers against the length of the fingers."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from varishold.errors import InputError
from varishold.recording import atomic_write

__all__ = ["draw_finger_lengths"]

_KINDS = ("png", "svg", "pdf")


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
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in _KINDS:
        raise InputError(f"{path}: a figure's name must end in {', '.join('.' + k for k in _KINDS)}")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.4), layout="constrained", facecolor="white")
    axes = figure.add_subplot()
    scales = [row["finger_scale"] for row in rows]
    for group in rows[0]["mean_percent"]:
        axes.plot(scales, [row["mean_percent"][group] for row in rows], marker="o", label=group)
    axes.plot(scales, [row["held_percent"] for row in rows], color="0.6", linestyle="--", label="held")
    axes.set(xlabel="length of the digits, times the usual", ylabel="percent of grasps", ylim=(0, 103))
    axes.set_xticks(scales)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, loc="lower right")
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    with atomic_write(path) as file:
        figure.savefig(file, format=kind, dpi=150, metadata=metadata)
