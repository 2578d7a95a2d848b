"""The power law, y = x^exponent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from varishold.sensor.responses.constants import positive

__all__ = ["Power"]


@dataclass(frozen=True)
class Power:
    """``y = sign(x) |x|^exponent``.

    Parameters
    ----------
    exponent : float
        In [.05, 20]: below 1 the sensor is most sensitive to light touch, above 1 to heavy load.

    Raises
    ------
    InputError
        If it is not in its range.
    """

    kind: ClassVar[str] = "power"
    exponent: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "exponent", positive("exponent", self.exponent, 0.05, 20.0))

    def reading(self, stress: NDArray[np.float64]) -> NDArray[np.float64]:
        return _raised(stress, self.exponent)

    def stress(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        return _raised(reading, 1.0 / self.exponent)

    def entries(self) -> dict[str, Any]:
        return {"exponent": self.exponent}


def _raised(values: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
    return np.copysign(np.abs(values) ** exponent, values)
