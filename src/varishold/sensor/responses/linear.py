"""The linear response, y = x."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["Linear"]


@dataclass(frozen=True)
class Linear:
    """y = x."""

    kind: ClassVar[str] = "linear"

    def reading(self, stress: NDArray[np.float64]) -> NDArray[np.float64]:
        return stress

    def stress(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        return reading

    def entries(self) -> dict[str, Any]:
        return {}
