"""What a message says of a touch: values by pad, when, and as which of its kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["Asked", "MessagePad", "MessageReading"]


@dataclass(frozen=True)
class Asked:
    """What a person said of messages that do not say it themselves.

    Parameters
    ----------
    shape : (int, int), optional
        Rows and columns of a pad whose values come in one row.
    field : str, optional
        The field that holds the values, with dots between fields in fields.
    """

    shape: tuple[int, int] | None = None
    field: str | None = None


@dataclass(frozen=True, eq=False)
class MessagePad:
    """One pad's values, and what the message says of them.

    Parameters
    ----------
    values : ndarray
        (rows, cols) where taxels stand on a grid, (n,) where they stand on none, and of signals.
    kind : {"pressure", "signals"}
        Shear, temperatures and magnetometers are signals; shear is x and y of each taxel in turn.
    unit : str
    polarity : {"up", "down"}
        Whether larger or smaller values mean more pressure.
    names : tuple of str
        What each signal is called.
    sensor : str
        The sensor file that is known by this name describes it; empty where none does.
    positions_m : ndarray of shape (n, 2), float64, optional
        (x, y) of each taxel where they stand on no grid and the message says where. Metres.
    """

    values: NDArray[Any]
    kind: Literal["pressure", "signals"] = "pressure"
    unit: str = "raw"
    polarity: Literal["up", "down"] = "up"
    names: tuple[str, ...] = ()
    sensor: str = ""
    positions_m: NDArray[np.float64] | None = None


@dataclass(frozen=True, eq=False)
class MessageReading:
    """What one message says.

    Parameters
    ----------
    pads : mapping of str to MessagePad
        By name; ``shear.NAME`` and ``temperature.NAME`` stand beside the pad called NAME. None where the message
        lists no taxel this time.
    time_s : float or None
        By the sensor's own clock where it is sent, otherwise the header's stamp. Seconds.
    sequence : int or None
        The sensor's own number of the reading, otherwise the header's.
    """

    pads: Mapping[str, MessagePad]
    time_s: float | None = None
    sequence: int | None = None
