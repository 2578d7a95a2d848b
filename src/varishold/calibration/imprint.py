"""The stress that a known object leaves on a pad, from where and how deep it is pressed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["OBJECTS", "KnownObject", "known_object"]

Floats = NDArray[np.float64]

# Points along a taxel's side at which the stress is looked at.
_PER_TAXEL = 4
# A plate's edge rises over this share of a point's spacing, so that it moves smoothly.
_EDGE = 1.0


@dataclass(frozen=True)
class KnownObject:
    """An object of known size.

    Parameters
    ----------
    kind : str
        One of `OBJECTS`.
    size_m : float
        Diameter of a ball or roller, breadth of a square plate, metres.
    """

    kind: str
    size_m: float

    @property
    def parameters(self) -> tuple[str, ...]:
        """What a press of it leaves open: its place, turn, depth and slopes."""
        return OBJECTS[self.kind].parameters

    @property
    def curved(self) -> bool:
        """Whether it presses with all stresses up to its highest, so that a response shows."""
        return OBJECTS[self.kind].curved

    def stress(self, at: Floats, pad: Points) -> Floats:
        """Return the mean depth of the object's face in each taxel, metres, shape (rows, cols)."""
        return pad.taxel_means(OBJECTS[self.kind].depth(self.size_m, at, pad))


@dataclass(frozen=True, eq=False)
class Points:
    """Points all over a pad, several in each taxel.

    Parameters
    ----------
    shape : (int, int)
    pitch_m : (float, float)
    """

    shape: tuple[int, int]
    pitch_m: tuple[float, float]

    @property
    def axes(self) -> tuple[Floats, Floats]:
        """x as a row and y as a column, metres from the pad's centre."""
        y, x = (
            ((np.arange(n * _PER_TAXEL) + 0.5) / _PER_TAXEL - n / 2) * p
            for n, p in zip(self.shape, self.pitch_m, strict=True)
        )
        return x[None, :], y[:, None]

    @property
    def spacing_m(self) -> float:
        return min(self.pitch_m) / _PER_TAXEL

    def taxel_means(self, values: Floats) -> Floats:
        rows, cols = self.shape
        mean: Floats = values.reshape(rows, _PER_TAXEL, cols, _PER_TAXEL).mean(axis=(1, 3))
        return mean


def _ball(size_m: float, at: Floats, pad: Points) -> Floats:
    x, y = pad.axes
    return _below(size_m / 2, (x - at[0]) ** 2 + (y - at[1]) ** 2, at[2])


def _roller(size_m: float, at: Floats, pad: Points) -> Floats:
    x, y = pad.axes
    across = -np.sin(at[1]) * x + np.cos(at[1]) * y - at[0]
    along = np.cos(at[1]) * x + np.sin(at[1]) * y
    return _below(size_m / 2, across**2, at[2] + at[3] * along)


def _plate(size_m: float, at: Floats, pad: Points) -> Floats:
    x, y = pad.axes
    u = np.cos(at[2]) * (x - at[0]) + np.sin(at[2]) * (y - at[1])
    v = np.cos(at[2]) * (y - at[1]) - np.sin(at[2]) * (x - at[0])
    inside = np.clip((size_m / 2 - np.maximum(np.abs(u), np.abs(v))) / (_EDGE * pad.spacing_m) + 0.5, 0.0, 1.0)
    depth: Floats = inside * np.maximum(at[3] + at[4] * u + at[5] * v, 0.0)
    return depth


def _below(radius_m: float, distance_2: Floats, depth_m: Floats | float) -> Floats:
    gap = radius_m - np.sqrt(np.maximum(radius_m**2 - distance_2, 0.0))
    return np.maximum(depth_m - gap, 0.0)


@dataclass(frozen=True)
class _Imprint:
    """How one kind of object presses: what is open of a press, and the depth of its face at points of the pad."""

    parameters: tuple[str, ...]
    curved: bool
    depth: Callable[[float, Floats, Points], Floats]


#: Known objects by their word; a size follows it after a colon.
OBJECTS: Mapping[str, _Imprint] = MappingProxyType(
    {
        "ball": _Imprint(("x_m", "y_m", "depth_m"), True, _ball),
        "roller": _Imprint(("across_m", "yaw_rad", "depth_m", "slope"), True, _roller),
        "plate": _Imprint(("x_m", "y_m", "yaw_rad", "depth_m", "slope_u", "slope_v"), False, _plate),
    }
)


def known_object(text: str) -> KnownObject:
    """Return the object of a text like ``ball:0.02``.

    Raises
    ------
    InputError
        If it is none of `OBJECTS` with a size in metres after a colon.

    Examples
    --------
    >>> known_object("ball:0.02")
    KnownObject(kind='ball', size_m=0.02)
    """
    kind, _, size = text.partition(":")
    try:
        size_m = float(size)
    except ValueError:
        size_m = np.nan
    if kind not in OBJECTS or not 1e-6 < size_m < 1e3:
        raise InputError(
            f"a known object is {', '.join(f'{each}:SIZE' for each in OBJECTS)} with its diameter or breadth in "
            f"metres, as in ball:0.02, got {text!r}"
        )
    return KnownObject(kind, size_m)
