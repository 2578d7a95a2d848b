"""Where pressure is not form: the highest section of a flat punch, from the surface down into the skin."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold.report.colours import shade
from varishold.report.figure_file import new_figure, save_figure

__all__ = ["write_ring_figure"]

Floats = NDArray[np.float64]


def write_ring_figure(
    path: str | Path, maps: Sequence[tuple[str, Floats]], *, side_m: float, share: float = 0.8
) -> None:
    """Draw maps of stress with the section above a share of the peak, and a cut through the middle of each.

    Parameters
    ----------
    path : str or Path
        The PNG to write.
    maps : sequence of (str, ndarray of shape (rows, cols))
        Heading and stress of each map.
    side_m : float
        Breadth of the maps, metres.
    share : float
        Threshold of the outlined section, as a share of each map's peak.
    """
    figure = new_figure(2.05 * len(maps), 3.6, beside=path)
    axes = figure.subplots(2, len(maps), height_ratios=(2, 1), squeeze=False, sharey="row")
    half = 1e3 * side_m / 2
    for column, (heading, stress) in enumerate(maps):
        peak = float(stress.max())
        panel = axes[0, column]
        image = shade(0.03 + 0.97 * np.clip(stress / peak, 0, 1))
        panel.imshow(image, extent=(-half, half, half, -half), interpolation="nearest")
        section = (stress > share * peak).astype(np.float64)
        points = (np.arange(stress.shape[0]) + 0.5) / stress.shape[0] * 2 * half - half
        panel.contour(points, points, section, levels=[0.5], colors="#e4572e", linewidths=1.1)
        panel.set_title(heading, fontsize=9)
        panel.set_xticks([])
        panel.set_yticks([])
        cut = axes[1, column]
        cut.plot(points, stress[stress.shape[0] // 2] / peak, color="#1f4e79", linewidth=1.0)
        cut.axhline(share, color="#e4572e", linewidth=0.8, linestyle=":")
        cut.set_ylim(0, 1.05)
        cut.set_xlabel("x (mm)", fontsize=8)
        cut.tick_params(labelsize=7)
    axes[1, 0].set_ylabel("share of the peak", fontsize=8)
    save_figure(figure, path, kind="png")
