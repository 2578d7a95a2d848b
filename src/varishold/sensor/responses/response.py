"""What every response is: a rising curve from (0, 0) to (1, 1), and back."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Response"]

Floats = NDArray[np.float64]


class Response(Protocol):
    """How a taxel's reading y follows the stress x on it, both as shares of full scale.

    Every response is odd, y(-x) = -y(x), so that noise about zero stays noise about zero; it goes on
    beyond full scale.
    """

    @property
    def kind(self) -> str:
        """Its name in a sensor file."""

    def reading(self, stress: Floats) -> Floats:
        """Return y of x."""

    def stress(self, reading: Floats) -> Floats:
        """Return x of y: the inverse of `reading`."""

    def entries(self) -> dict[str, Any]:
        """Return its constants as a sensor file holds them, without `kind`."""
