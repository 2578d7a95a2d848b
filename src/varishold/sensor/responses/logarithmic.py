"""The logarithmic response, y = log(1 + a x) / log(1 + a)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.sensor.responses.constants import positive

__all__ = ["Logarithmic"]


@dataclass(frozen=True)
class Logarithmic:
    """``y = sign(x) log(1 + a |x|) / log(1 + a)``.

    Parameters
    ----------
    a : float
        In [1e-6, 1e9]: the larger, the stronger is the first touch beside full load.

    Raises
    ------
    InputError
        If it is not in its range.
    """

    kind: ClassVar[str] = "logarithmic"
    a: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "a", positive("a", self.a, 1e-6, 1e9))

    def reading(self, stress: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.copysign(np.log1p(self.a * np.abs(stress)) / math.log1p(self.a), stress)

    def stress(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.copysign(np.expm1(np.abs(reading) * math.log1p(self.a)) / self.a, reading)

    def entries(self) -> dict[str, Any]:
        return {"a": self.a}
