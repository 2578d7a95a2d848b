"""A map of one number a taxel, without a contact."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from varishold.report.picture import png_data_uri
from varishold.report.screen import fit, screen

__all__ = ["taxel_map"]

_COLOURS = 96


def taxel_map(values: NDArray[np.float64], low: float, high: float, *, label: str) -> Markup:
    """Draw a map, dark where it is low; a taxel that is not known stays empty.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        NaN where nothing is known.
    low, high : float
        Ends of the colour scale.
    label : str
        Description for those who cannot see it.
    """
    rows, cols = values.shape
    place = fit((0.0, 0.0, float(cols), float(rows)))
    uri = png_data_uri((values - low) / max(high - low, 1e-300), _COLOURS)
    body = (
        f'<g transform="{place.transform()}"><image x="0" y="0" width="{cols}" height="{rows}" '
        f'preserveAspectRatio="none" style="image-rendering: pixelated" href="{uri}"/></g>'
    )
    return screen(body, label=label, kind="taxels")
