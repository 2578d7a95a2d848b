"""A small PNG of colour indices, as a data URI: a frame of 32 x 32 taxels takes about a kilobyte."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray

from varishold.files.png import png_bytes
from varishold.report.colours import palette

__all__ = ["data_uri", "png_data_uri"]


def data_uri(png: bytes) -> str:
    """Return a PNG as an address that holds it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def png_data_uri(places: NDArray[np.float64], colours: int) -> str:
    """Encode a map in the colours of the scale.

    Parameters
    ----------
    places : ndarray of shape (rows, cols), float64
        Place of each pixel on the scale, 0 to 1 and clipped to it; NaN is not drawn.
    colours : int
        Into how many colours the scale is cut, at most 255.

    Returns
    -------
    str
        ``data:image/png;base64,...``
    """
    known = np.isfinite(places)
    steps = np.round(np.clip(places, 0.0, 1.0) * (colours - 1))
    index = np.where(known, steps, colours).astype(np.uint8)
    return data_uri(png_bytes(index, palette=palette(colours) + b"\0\0\0", transparency=b"\xff" * colours + b"\0"))
