"""One press as a picture: the object, the pressure, what the taxels say, and what is seen through the skin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.report.figure_file import new_figure, save_figure
from varishold.skin import PressedSolid, Relief

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["show_map", "write_press_figure"]


def show_map(
    axes: Axes,
    values: NDArray[np.float64],
    extent_m: tuple[float, float],
    *,
    colours: str = "magma",
    top: float | None = None,
    outline: NDArray[np.bool_] | None = None,
) -> Any:
    """Show a map over a pad of (height, width) metres, y downward like the rows; return the image."""
    height, width = (1e3 * side for side in extent_m)
    extent = (-width / 2, width / 2, height / 2, -height / 2)
    image = axes.imshow(values, extent=extent, cmap=colours, vmin=0.0, vmax=top, interpolation="nearest")
    if outline is not None and outline.any() and not outline.all():
        y = (np.arange(outline.shape[0]) + 0.5) / outline.shape[0] * height - height / 2
        x = (np.arange(outline.shape[1]) + 0.5) / outline.shape[1] * width - width / 2
        axes.contour(x, y, outline.astype(float), levels=[0.5], colors="#3fd0c9", linewidths=0.9)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color("#999999")
        spine.set_linewidth(0.6)
    return image


def write_press_figure(
    path: str | Path,
    press: PressedSolid,
    frame: NDArray[np.float64],
    *,
    relief: Relief | None = None,
    title: str = "",
) -> None:
    """Draw a press: surface pressure, taxels, displacement, a cut through the middle of the load.

    Parameters
    ----------
    path : str or Path
        The PNG to write.
    press : PressedSolid
        The press.
    frame : ndarray of shape `press.shape`, float64
        What the taxels read of it.
    relief : Relief, optional
        What is reconstructed from the frame.
    title : str
        Headline.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    unit = "Pa" if press.skin.youngs_modulus_pa is not None else "contact modulus"
    extent = (press.shape[0] * press.pitch_m[0], press.shape[1] * press.pitch_m[1])
    figure = new_figure(11.5, 3.6, beside=path)
    if title:
        figure.suptitle(title, fontsize=11)
    panels: list[Axes] = list(figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.25)))
    maps = (
        ("surface pressure", press.pressure, unit, "magma"),
        ("taxels", np.maximum(frame, 0.0), unit, "magma"),
        ("surface pressed down", 1e3 * press.displacement_m, "mm", "viridis"),
    )
    for axes, (label, values, of, colours) in zip(panels, maps, strict=False):
        # A punch's rim is singular: the scale leaves out the highest cells.
        top = float(np.quantile(values[values > 0], 0.995)) if (values > 0).any() else 1.0
        outline = press.contact if label == "surface pressed down" else None
        image = show_map(axes, values, extent, colours=colours, top=top, outline=outline)
        axes.set_title(label, fontsize=9)
        bar = figure.colorbar(image, ax=axes, shrink=0.75)
        bar.set_label(of, fontsize=8)
        bar.ax.tick_params(labelsize=7)
    _cut(panels[3], press, relief)
    save_figure(figure, path, kind="png")


def _cut(axes: Axes, press: PressedSolid, relief: Relief | None) -> None:
    load = press.pressure.sum(axis=1)
    row = int(np.argmax(np.cumsum(load) >= load.sum() / 2))
    x = 1e3 * press.x_m
    gap = press.gap_m[row]
    body = np.where(np.isfinite(gap), press.displacement_m[row] - gap, np.nan)
    body[body < -press.depth_m] = np.nan
    axes.plot(x, -1e3 * body, color="#888888", linewidth=2.5, label="object")
    axes.plot(x, -1e3 * press.displacement_m[row], color="#1f4e79", linewidth=1.2, label="skin")
    if relief is not None:
        rows = relief.displacement.shape[0]
        seen = relief.displacement[min(row * rows // press.pressure.shape[0], rows - 1)]
        at = (np.arange(seen.size) + 0.5 - seen.size / 2) * relief.pitch_m[1] * 1e3
        axes.plot(at, -1e3 * seen, color="#d1495b", linewidth=1.0, linestyle="--", label="seen through the skin")
    axes.set_title("cut through the middle of the load", fontsize=9)
    axes.set_xlabel("x (mm)", fontsize=8)
    axes.set_ylabel("height (mm)", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7, frameon=False)
