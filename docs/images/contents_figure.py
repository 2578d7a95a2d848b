"""A table of contents: what each form does to a skin, what the taxels say of it, and what is seen through it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.report.colours import shade
from varishold.report.figure_file import new_figure, save_figure
from varishold.skin import PressedSolid, Relief

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["ContentsEntry", "write_contents_figure"]

Floats = NDArray[np.float64]

_ROWS = ("pressure on the skin", "what the taxels say", "seen through the skin", "the object")
_COLUMNS = 7
# A light from the upper left, as in maps; relief is exaggerated to slopes of this size.
_LIGHT = np.array([-0.55, -0.6, 0.58])
_EXAGGERATED = 1.1


@dataclass(frozen=True)
class ContentsEntry:
    """One form of the table.

    Parameters
    ----------
    name : str
        Heading.
    press : PressedSolid
        The press.
    frame : ndarray of shape (rows, cols), float64
        What the taxels read.
    relief : Relief
        What is reconstructed from it.
    """

    name: str
    press: PressedSolid
    frame: Floats
    relief: Relief


def write_contents_figure(path: str | Path, entries: Sequence[ContentsEntry], *, note: str = "") -> None:
    """Draw the table: a column a form, in blocks of seven; rows from the skin's surface to the object.

    Parameters
    ----------
    path : str or Path
        The PNG to write.
    entries : sequence of ContentsEntry
        The forms.
    note : str
        A line under the table: which skin, which noise.
    """
    blocks = -(-len(entries) // _COLUMNS)
    rows = len(_ROWS)
    figure = new_figure(11.2, blocks * 6.65 + 0.3, beside=path)
    grids = figure.subfigures(blocks + 1, 1, squeeze=False, height_ratios=[6.65] * blocks + [0.3])[:, 0]
    for block, grid in enumerate(grids[:-1]):
        part = entries[block * _COLUMNS : (block + 1) * _COLUMNS]
        axes = grid.subplots(rows, _COLUMNS, squeeze=False)
        for panel in axes.ravel():
            panel.set_axis_off()
        for column, entry in enumerate(part):
            for row, values in enumerate(_panels(entry)):
                _show(axes[row, column], values)
            axes[0, column].set_title(entry.name, fontsize=9.5)
        for row, label in enumerate(_ROWS):
            panel = axes[row, 0]
            panel.text(-0.09, 0.5, label, transform=panel.transAxes, rotation=90, ha="center", va="center", fontsize=9)
    if note:
        grids[-1].text(0.99, 0.5, note, ha="right", va="center", fontsize=8.5, color="#555555")
    save_figure(figure, path, kind="png", dpi=100)


def _panels(entry: ContentsEntry) -> tuple[Floats, Floats, Floats, Floats]:
    press, relief = entry.press, entry.relief
    top = float(np.quantile(press.pressure[press.contact], 0.97))
    pressure = shade(np.clip(press.pressure / top, 0, 1) * 0.97 + 0.03)
    taxels = shade(np.clip(entry.frame / entry.frame.max(), 0, 1) * 0.97 + 0.03)
    # Where the true contact is, from the height at which it ends.
    seen = _shaded(relief.height, relief.core, relief.pitch_m, float(relief.height.max()))
    line = _true_line(entry)
    cells = (press.x_m[1] - press.x_m[0], press.y_m[1] - press.y_m[0])
    true_height = np.where(press.contact, np.maximum(press.displacement_m - press.gap_m - line, 0.0), 0.0)
    true = _shaded(true_height, press.contact, (cells[1], cells[0]), float(true_height.max()))
    return pressure / 255.0, taxels / 255.0, seen, true


def _true_line(entry: ContentsEntry) -> float:
    """Level of the contact line in the press, at the same share of the highest point as the relief found it."""
    relief, press = entry.relief, entry.press
    highest = float(relief.displacement.max())
    share = relief.line / highest if highest > 0 else 0.0
    return share * float(press.displacement_m.max())


def _shaded(height: Floats, mask: NDArray[np.bool_], pitch: tuple[float, float], top: float) -> Floats:
    """Shade a relief by a light from the upper left over the colour of its height; grey where there is none."""
    side = max(height.shape[0] * pitch[0], height.shape[1] * pitch[1])
    factor = _EXAGGERATED * 0.3 * side / max(top, 1e-30)
    slope_y, slope_x = np.gradient(height * factor, pitch[0], pitch[1])
    normal = np.stack([-slope_x, -slope_y, np.ones_like(height)])
    normal /= np.linalg.norm(normal, axis=0)
    light = np.tensordot(_LIGHT / np.linalg.norm(_LIGHT), normal, axes=1)
    colour = shade(0.25 + 0.7 * np.clip(height / max(top, 1e-30), 0, 1)) / 255.0
    lit = colour * (0.45 + 0.75 * np.clip(light, 0, 1))[..., None]
    ground = np.full((*height.shape, 3), 0.93) * (0.55 + 0.55 * np.clip(light, 0, 1))[..., None]
    return np.clip(np.where(mask[..., None], lit, ground), 0, 1)


def _show(axes: Axes, image: Floats) -> None:
    axes.imshow(image, interpolation="nearest")
