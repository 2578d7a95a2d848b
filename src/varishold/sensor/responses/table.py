"""A response that was measured: straight lines between points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_array

__all__ = ["Table"]


@dataclass(frozen=True)
class Table:
    """Straight lines between measured points, the last of them going on.

    Parameters
    ----------
    stresses, readings : sequence of float
        Shares of full scale, each rising from 0 to 1.

    Raises
    ------
    InputError
        If they are not equally many numbers, at least two, that rise from 0 to 1.

    Examples
    --------
    >>> import numpy as np
    >>> Table([0, 0.25, 1], [0, 0.5, 1]).stress(np.array([0.25, 0.75, -0.5])).tolist()
    [0.125, 0.625, -0.25]
    """

    kind: ClassVar[str] = "table"
    stresses: Sequence[float]
    readings: Sequence[float]
    _x: NDArray[np.float64] = field(init=False, repr=False, compare=False)
    _y: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, hidden in (("stresses", "_x"), ("readings", "_y")):
            points = _rising(name, getattr(self, name))
            object.__setattr__(self, name, tuple(points.tolist()))
            object.__setattr__(self, hidden, points)
        if len(self.stresses) != len(self.readings):
            raise InputError(
                f"a response's table must have as many readings as stresses, got {len(self.readings)} and "
                f"{len(self.stresses)}"
            )

    def reading(self, stress: NDArray[np.float64]) -> NDArray[np.float64]:
        return _interpolated(stress, self._x, self._y)

    def stress(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        return _interpolated(reading, self._y, self._x)

    def entries(self) -> dict[str, Any]:
        return {"stresses": list(self.stresses), "readings": list(self.readings)}


def _rising(name: str, values: Any) -> NDArray[np.float64]:
    points = as_array(values)
    if points.ndim != 1 or points.size < 2 or not np.isfinite(points).all():
        raise InputError(f"{name} of a response's table must be two finite numbers or more, got {values!r}")
    fall = np.flatnonzero(np.diff(points) <= 0)
    if fall.size:
        i = int(fall[0])
        raise InputError(
            f"a response must rise: {name} of its table go from {points[i]:g} to {points[i + 1]:g} at entry {i + 1}; "
            "leave out what lies beyond saturation"
        )
    if points[0] != 0 or points[-1] != 1:
        raise InputError(
            f"{name} of a response's table must go from 0 to 1 (shares of full scale), got {points[0]:g} to "
            f"{points[-1]:g}"
        )
    return points


def _interpolated(at: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    size = np.abs(at)
    slope = (y[-1] - y[-2]) / (x[-1] - x[-2])
    between: NDArray[np.float64] = np.interp(size, x, y) + slope * np.maximum(size - 1.0, 0.0)
    return np.copysign(between, at)
