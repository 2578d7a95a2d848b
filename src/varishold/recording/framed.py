"""What frames and presses are looked for in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Framed"]


class Framed(Protocol):
    """What frames are chosen from, and presses looked for in: a `Recording`."""

    @property
    def pads(self) -> Mapping[str, Any]: ...
    @property
    def n_frames(self) -> int: ...
    @property
    def presses(self) -> Any: ...
    @property
    def source(self) -> str: ...
    def totals(self) -> NDArray[np.float64]: ...
