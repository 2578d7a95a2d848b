"""The one colour scale of every drawing: even steps of lightness, from night blue to pale yellow.

It is a line through the Oklab space in which lightness grows in equal steps, so that equal differences of
pressure look equal, also to colour-blind eyes and in grey print.

References
----------
B. Ottosson, "A perceptual color space for image processing", 2020.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["BELOW", "INSIDE", "css", "darker", "palette", "shade"]

#: Place on the scale of a taxel at the floor (delta) of a contact; below it everything is darker, so that
#: the contact's border shows.
INSIDE = 0.27
#: Place of the scale's darkest colour in use: a taxel at zero.
BELOW = 0.03

_LMS_FROM_LAB = np.array(
    [[1.0, 0.3963377774, 0.2158037573], [1.0, -0.1055613458, -0.0638541728], [1.0, -0.0894841775, -1.2914855480]]
)
_RGB_FROM_LMS = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def shade(place: ArrayLike) -> NDArray[np.uint8]:
    """Return the colours at places on the scale.

    Parameters
    ----------
    place : array_like of shape (...)
        0 (darkest) to 1 (lightest); clipped to it.

    Returns
    -------
    ndarray of shape (..., 3), uint8
        Red, green, blue.
    """
    t = np.clip(np.asarray(place, dtype=np.float64), 0.0, 1.0)
    lightness = 0.185 + 0.765 * t
    hue = np.radians(281.0 - 178.0 * t**1.15)
    chroma = 0.035 + 0.08 * np.sin(np.pi * np.minimum(t, 0.62) ** 0.8) * (1 - 0.15 * t)
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=-1)
    linear = np.clip(((lab @ _LMS_FROM_LAB.T) ** 3) @ _RGB_FROM_LMS.T, 0.0, 1.0)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    colours: NDArray[np.uint8] = np.round(255 * srgb).astype(np.uint8)
    return colours


@cache
def palette(n: int) -> bytes:
    """Return n evenly spaced colours of the scale as 3 n bytes."""
    return shade(np.linspace(0.0, 1.0, n)).tobytes()


def css(place: float) -> str:
    """Return the colour at a place on the scale as CSS.

    Examples
    --------
    >>> css(0.0), css(1.0)
    ('#101122', '#f9f2a9')
    """
    return "#" + shade(place).tobytes().hex()


def darker(colour: str, by: float) -> str:
    """Return a CSS colour with its light taken `by` times.

    Examples
    --------
    >>> darker("#8040ff", 0.5)
    '#402080'
    """
    return "#" + bytes(round(by * channel) for channel in bytes.fromhex(colour[1:])).hex()
