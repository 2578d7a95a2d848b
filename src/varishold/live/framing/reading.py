"""What a decoder makes of a frame's bytes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from numpy.typing import NDArray

__all__ = ["Reading"]


class Reading(NamedTuple):
    """One frame.

    Parameters
    ----------
    pads : mapping of str to ndarray
        Values as they came, in this machine's byte order.
    device_time_s : float or None
    sequence : int or None
    """

    pads: Mapping[str, NDArray[Any]]
    device_time_s: float | None
    sequence: int | None
