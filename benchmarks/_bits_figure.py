"""What a recognition costs in bits, by sections and by reading every taxel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from varishold.report.figure_file import new_figure, save_figure

__all__ = ["BitsCurve", "write_bits_figure"]


@dataclass(frozen=True)
class BitsCurve:
    """How many are recognized by how many bits.

    Parameters
    ----------
    label : str
        What is sent.
    bits : sequence of float
        Bits a recognition, rising.
    right : sequence of float
        Share of presses that were given the right name.
    """

    label: str
    bits: Sequence[float]
    right: Sequence[float]


def write_bits_figure(path: str | Path, curves: Sequence[BitsCurve], *, title: str = "") -> None:
    """Draw the share of right names over the bits that they cost; a curve of one point is drawn as a mark.

    Parameters
    ----------
    path : str or Path
        The PNG to write.
    curves : sequence of BitsCurve
        What to draw.
    title : str
        Headline.
    """
    figure = new_figure(6.4, 3.8, beside=path)
    axes = figure.subplots()
    for curve, colour in zip(curves, ("#1f4e79", "#2a9d8f", "#e4572e", "#6d597a", "#888888"), strict=False):
        style = "o-" if len(curve.bits) > 1 else "s"
        axes.plot(curve.bits, curve.right, style, color=colour, markersize=4, linewidth=1.2, label=curve.label)
    axes.set_xscale("log")
    axes.set_xlabel("bits a recognition")
    axes.set_ylabel("share of right names")
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8, frameon=False)
    if title:
        axes.set_title(title, fontsize=10)
    save_figure(figure, path, kind="png")
