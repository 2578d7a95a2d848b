"""How far stated probabilities are true: the reliability diagram."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from varishold.report.figure_file import figure_kind, new_figure, save_figure

__all__ = ["draw_reliability"]

# Points beyond this probability crowd; their numbers stand so low.
_CROWD, _BELOW = 0.9, 0.55


def draw_reliability(rows: Sequence[tuple[float, float, float, float, int]], path: str | os.PathLike[str]) -> None:
    """Draw how often statements of a probability were right, with intervals.

    Parameters
    ----------
    rows : sequence of (float, float, float, float, int)
        One a bin: mean probability, share right, both ends of the share's interval, number of statements.
    path : str or path-like
        PNG, SVG or PDF, by its ending.

    Raises
    ------
    InputError
        If the ending is none of these, or the file cannot be written.
    """
    figure_kind(path)
    p, share, low, high, count = (np.array(column, dtype=float) for column in zip(*rows, strict=True))
    figure = new_figure(4.4, 4.2, beside=path)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1, linestyle="--")
    bars = np.maximum([share - low, high - share], 0.0)
    axes.errorbar(p, share, yerr=bars, marker="o", capsize=3, color="#1f5fa8")
    # Statements that are nearly sure crowd at the end: their numbers stand below, beside each other.
    crowd = np.flatnonzero(p > _CROWD)
    places = np.linspace(1.0 - 0.08 * (len(crowd) - 1), 1.0, len(crowd))
    for k, (x, y, n) in enumerate(zip(p, share, count, strict=True)):
        if k not in crowd:
            axes.annotate(f"{n:.0f}", (x, y), textcoords="offset points", xytext=(6, -12), fontsize=8, color="0.35")
            continue
        at = places[k - crowd[0]]
        axes.plot([x, at], [y, _BELOW + 0.04], color="0.8", linewidth=0.8, zorder=1)
        axes.annotate(f"{n:.0f}", (x, y), xytext=(at, _BELOW), ha="center", fontsize=8, color="0.35")
    axes.set(xlabel="stated probability", ylabel="share right", xlim=(0.15, 1.03), ylim=(0, 1.05))
    axes.grid(alpha=0.25)
    save_figure(figure, path, dpi=150)
