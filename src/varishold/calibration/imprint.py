"""The stress that a known object leaves on a pad, from where and how deep it is pressed; and a first guess back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.covers import SPRINGS, Cover
from varishold.errors import InputError

__all__ = ["OBJECTS", "KnownObject", "Points", "Print", "known_object"]

Floats = NDArray[np.float64]
#: What a press leaves open of an object, and how far each number may well move.
Guess = tuple[list[float], list[float]]

#: Points along a taxel's side at which the stress is looked at. With half as many what an edge leaves on a taxel is so
#: coarse that a power of .6 is found as .616.
PER_TAXEL = 8
# A ball or roller is guessed to be pressed in by this part of its diameter at most.
_DEEPEST = 0.4


@dataclass(frozen=True)
class KnownObject:
    """An object of known size.

    Parameters
    ----------
    kind : str
        One of `OBJECTS`.
    size_m : float
        Diameter of a ball, roller or disc (a round plate), breadth of a square plate, metres.
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
        """Return the mean stress in each taxel, shape (rows, cols): on springs the depth of the face, metres."""
        return OBJECTS[self.kind].stress(self.size_m, at[: len(self.parameters)], pad)

    def guess(self, left: Print) -> Guess:
        """Return what a press may have been, by its parameters, and how far each may well move."""
        return OBJECTS[self.kind].guess(self.size_m, left)


@dataclass(frozen=True, eq=False)
class Points:
    """Points all over a pad, several in each taxel, and what covers them.

    Parameters
    ----------
    shape : (int, int)
    pitch_m : (float, float)
    cover : Cover
    per_taxel : int
        Points along a taxel's side.
    """

    shape: tuple[int, int]
    pitch_m: tuple[float, float]
    cover: Cover = SPRINGS
    per_taxel: int = PER_TAXEL

    @cached_property
    def axes(self) -> tuple[Floats, Floats]:
        """x as a row and y as a column, metres from the pad's centre."""
        y, x = (
            ((np.arange(n * self.per_taxel) + 0.5) / self.per_taxel - n / 2) * p
            for n, p in zip(self.shape, self.pitch_m, strict=True)
        )
        return x[None, :], y[:, None]

    @property
    def diagonal_m(self) -> float:
        (rows, cols), (dy, dx) = self.shape, self.pitch_m
        return float(np.hypot(rows * dy, cols * dx))

    @property
    def spacing_m(self) -> float:
        return min(self.pitch_m) / self.per_taxel

    def stress(self, made: Callable[[Floats, Floats], Floats], around: tuple[float, float, float] | None) -> Floats:
        """Return the mean stress of each taxel, shape (rows, cols).

        Parameters
        ----------
        made : callable
            Stress at points of x (1, n) and y (m, 1), metres; shape (m, n).
        around : (float, float, float) or None
            x and y of a place, and how far from it along both there is no stress any more; None: anywhere.
        """
        (rows, cols), n, (x, y) = self.shape, self.per_taxel, self.axes
        means = np.zeros(self.shape)
        down, across = slice(0, rows), slice(0, cols)
        if around is not None:
            (dy, dx), (at_x, at_y, reach) = self.pitch_m, around
            down, across = _within(at_y, reach, rows, dy), _within(at_x, reach, cols, dx)
        x, y = x[:, across.start * n : across.stop * n], y[down.start * n : down.stop * n]
        if x.size and y.size:
            means[down, across] = self.taxel_means(made(x, y))
        return means

    def taxel_means(self, values: Floats) -> Floats:
        """Return the mean of each taxel's points, from values at the points of some rows and columns of taxels."""
        n = self.per_taxel
        rows, cols = values.shape
        mean: Floats = values.reshape(rows // n, n, cols // n, n).mean(axis=(1, 3))
        return mean


def _within(at_m: float, reach_m: float, count: int, pitch_m: float) -> slice:
    """Return which of so many taxels along a side lie within a reach of a place, in parts."""
    low, high = ((at_m + way * reach_m) / pitch_m + count / 2 for way in (-1, 1))
    start = int(np.clip(np.floor(low), 0, count))
    return slice(start, max(start, int(np.clip(np.ceil(high), 0, count))))


@dataclass(frozen=True, eq=False)
class Print:
    """What a press left on a pad.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Readings above rest.
    pressed : ndarray of shape (rows, cols), bool
        Taxels that are taken for pressed.
    pitch_m : (float, float)
    highest : float
        The highest reading of all presses.
    """

    frame: Floats
    pressed: NDArray[np.bool_]
    pitch_m: tuple[float, float]
    highest: float

    @property
    def side_m(self) -> tuple[float, float]:
        """Height and breadth of the pad, metres."""
        (rows, cols), (dy, dx) = self.frame.shape, self.pitch_m
        return rows * dy, cols * dx

    @property
    def area_m2(self) -> float:
        return float(self.pressed.sum()) * self.pitch_m[1] * self.pitch_m[0]

    @cached_property
    def middle_m(self) -> tuple[float, float]:
        """(x, y) of the middle of what is pressed, by weight, from the pad's centre."""
        x, y = self._places
        return float((self._weight * x).sum()), float((self._weight * y).sum())

    @cached_property
    def around_m(self) -> tuple[Floats, Floats]:
        """x and y of each taxel from that middle, each of shape (rows, cols)."""
        (x, y), (cx, cy) = self._places, self.middle_m
        return x - cx, y - cy

    @cached_property
    def yaw_rad(self) -> float:
        """Direction in which what is pressed is longest."""
        x, y = self.around_m
        xx, yy = float((self._weight * x**2).sum()), float((self._weight * y**2).sum())
        xy = float((self._weight * x * y).sum())
        return 0.5 * float(np.arctan2(2 * xy, xx - yy))

    @cached_property
    def _places(self) -> tuple[Floats, Floats]:
        (rows, cols), (dy, dx) = self.frame.shape, self.pitch_m
        y, x = np.indices(self.frame.shape)
        return (x - (cols - 1) / 2) * dx, (y - (rows - 1) / 2) * dy

    @cached_property
    def _weight(self) -> Floats:
        weight: Floats = np.where(self.pressed, self.frame, 0.0)
        weight /= weight.sum()
        return weight


def _ball(size_m: float, at: Floats, pad: Points) -> Floats:
    face, (cx, cy, depth) = pad.cover.round("ball", size_m), at.tolist()
    reach = float(face.reach_m(depth))
    return pad.stress(lambda x, y: face.pressure(np.sqrt((x - cx) ** 2 + (y - cy) ** 2), depth), (cx, cy, reach))


def _roller(size_m: float, at: Floats, pad: Points) -> Floats:
    face, (off, yaw, depth, slope) = pad.cover.round("roller", size_m), at.tolist()

    def made(x: Floats, y: Floats) -> Floats:
        across = -np.sin(yaw) * x + np.cos(yaw) * y - off
        deep = depth + slope * (np.cos(yaw) * x + np.sin(yaw) * y)
        near = np.abs(across) < float(face.reach_m(deep.max()))
        stress = np.zeros(across.shape)
        stress[near] = face.pressure(across[near], deep[near])
        return stress

    return pad.stress(made, None)


def _plate(size_m: float, at: Floats, pad: Points) -> Floats:
    face, (cx, cy, yaw, depth, along_u, along_v) = pad.cover.flat("square", size_m), at.tolist()

    def made(x: Floats, y: Floats) -> Floats:
        u = np.cos(yaw) * (x - cx) + np.sin(yaw) * (y - cy)
        v = np.cos(yaw) * (y - cy) - np.sin(yaw) * (x - cx)
        return face.pressure(u, v, depth, along_u, along_v, pad.spacing_m)

    return pad.stress(made, (cx, cy, size_m * np.sqrt(0.5) + 2 * pad.spacing_m))


def _disc(size_m: float, at: Floats, pad: Points) -> Floats:
    face, (cx, cy, depth, along_u, along_v) = pad.cover.flat("disc", size_m), at.tolist()

    def made(x: Floats, y: Floats) -> Floats:
        u, v = np.broadcast_arrays(x - cx, y - cy)
        return face.pressure(u, v, depth, along_u, along_v, pad.spacing_m)

    return pad.stress(made, (cx, cy, size_m / 2 + 2 * pad.spacing_m))


def _guess_ball(size_m: float, left: Print) -> Guess:
    pitch = min(left.pitch_m)
    depth = min(left.area_m2 / np.pi / size_m, _DEEPEST * size_m)
    return [*left.middle_m, depth], [pitch, pitch, 0.5 * depth]


def _guess_roller(size_m: float, left: Print) -> Guess:
    (height, breadth), (cx, cy), yaw = left.side_m, left.middle_m, left.yaw_rad
    long = np.hypot(height * np.sin(yaw), breadth * np.cos(yaw))
    depth = min((left.area_m2 / long / 2) ** 2 / size_m, _DEEPEST * size_m)
    across = -np.sin(yaw) * cx + np.cos(yaw) * cy
    return [across, yaw, depth, 0.0], [min(left.pitch_m), 0.1, 0.5 * depth, 0.5 * depth / long]


def _guess_plate(size_m: float, left: Print) -> Guess:
    pitch = min(left.pitch_m)
    depth = 0.5 * pitch * float(left.frame.max()) / left.highest
    start = [*left.middle_m, _plate_turn(left.pressed, *left.around_m, size_m), depth, 0.0, 0.0]
    return start, [pitch, pitch, 0.1, 0.3 * depth, depth / size_m, depth / size_m]


def _guess_disc(size_m: float, left: Print) -> Guess:
    (x, y, _, *rest), (of_x, of_y, _, *scales) = _guess_plate(size_m, left)
    return [x, y, *rest], [of_x, of_y, *scales]


def _plate_turn(pressed: NDArray[np.bool_], x: Floats, y: Floats, size_m: float) -> float:
    """Return the turn at which a square of this breadth covers what is pressed best."""
    turns = np.linspace(0, np.pi / 2, 19)[:-1]
    agree = []
    for turn in turns:
        u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
        agree.append(np.count_nonzero((np.maximum(np.abs(u), np.abs(v)) < size_m / 2) == pressed))
    return float(turns[int(np.argmax(agree))])


@dataclass(frozen=True)
class _Imprint:
    """How one kind of object presses: what is open of a press, what stress it makes, and a guess from what is left."""

    parameters: tuple[str, ...]
    curved: bool
    stress: Callable[[float, Floats, Points], Floats]
    guess: Callable[[float, Print], Guess]


#: Known objects by their word; a size follows it after a colon.
OBJECTS: Mapping[str, _Imprint] = MappingProxyType(
    {
        "ball": _Imprint(("x_m", "y_m", "depth_m"), True, _ball, _guess_ball),
        "roller": _Imprint(("across_m", "yaw_rad", "depth_m", "slope"), True, _roller, _guess_roller),
        "plate": _Imprint(("x_m", "y_m", "yaw_rad", "depth_m", "slope_u", "slope_v"), False, _plate, _guess_plate),
        "disc": _Imprint(("x_m", "y_m", "depth_m", "slope_x", "slope_y"), False, _disc, _guess_disc),
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
            f"a known object is {', '.join(f'{each}:SIZE' for each in OBJECTS)}, SIZE in metres: the diameter of a "
            f"ball, roller or disc (a round plate), the breadth of a plate (a square), as in ball:0.02, got {text!r}"
        )
    return KnownObject(kind, size_m)
