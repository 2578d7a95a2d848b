"""What comes from a source: one reading of all its pads, and what a pad is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from numpy.typing import NDArray

from varishold.recording import UNNAMED_PAD

__all__ = ["UNNAMED_PAD", "PadLayout", "Sample"]


class Sample(NamedTuple):
    """One reading of all pads that came together.

    Parameters
    ----------
    device_time_s : float or None
        By the sensor's own clock, seconds from wherever that clock begins; None where it sends none.
    host_time_s : float
        When the reading's last byte had come, by this machine's clock, seconds since 1970.
    sequence : int or None
        The sensor's own number of the reading; None where it sends none.
    pads : mapping of str to ndarray
        Values as they came, in the sensor's own unit and type: (rows, cols) where taxels stand on a grid, (n_taxels,)
        where they stand on none, (n_signals,) of a pad of signals.
    """

    device_time_s: float | None
    host_time_s: float
    sequence: int | None
    pads: Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class PadLayout:
    """What a source says of a pad.

    Parameters
    ----------
    shape : tuple of int
        (rows, cols), or (n,) where there is no grid.
    kind : {"pressure", "signals"}
        Signals, as a magnetometer skin's, are recorded, watched and learned from, and have no contacts.
    pitch_m : (float, float), optional
        Row and column spacing, metres. Default: unknown.
    unit : str
    polarity : {"up", "down"}
        Whether larger or smaller readings mean more pressure.
    names : tuple of str
        What each signal is called; empty for pressure.
    gaps, broken : tuple of int
        Places, row by row from 0, where there is no taxel, and where it does not work.
    """

    shape: tuple[int, ...]
    kind: Literal["pressure", "signals"] = "pressure"
    pitch_m: tuple[float, float] | None = None
    unit: str = "raw"
    polarity: Literal["up", "down"] = "up"
    names: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()
    broken: tuple[int, ...] = ()
