"""What a calibration found, how sure it is, and what it could not know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.sensor import Sensor

__all__ = ["Calibration", "Curve", "Finding", "error_of_spread"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Finding:
    """One thing that was measured.

    Parameters
    ----------
    name : str
        What it is, in the words of the sensor file.
    value : float
        What it is.
    error : float
        Its standard error.
    says : str
        What it means, in a sentence.
    share : bool
        Whether it is a share, shown in per cent.
    """

    name: str
    value: float
    error: float
    says: str
    share: bool = False

    def __str__(self) -> str:
        if self.share:
            return f"{self.name} {100 * self.value:.2g} ± {100 * self.error:.1g} %: {self.says}"
        return f"{self.name} {self.value:.3g} ± {self.error:.1g}: {self.says}"


@dataclass(frozen=True, eq=False)
class Curve:
    """A response as it was measured.

    Parameters
    ----------
    stress, reading : ndarray of shape (n_points,), float64
        Measured points, shares of full scale.
    """

    stress: Floats
    reading: Floats


@dataclass(frozen=True, eq=False)
class Calibration:
    """A sensor as it was measured.

    Parameters
    ----------
    kind : str
        How: "even", "objects", "unlabelled" or "scale".
    sensor : Sensor
        What is now known of it, what was known before included.
    presses : int
        Presses that it rests on.
    findings : tuple of Finding
        What was measured.
    unknown : tuple of str
        What could not be known from these presses, and what would tell it.
    notes : tuple of str
        What else a person should know, such as what was found and not applied.
    before, after : ndarray of shape (rows, cols), float64
        Each taxel's reading beside what it should be, without and with what was found; 1 is right, NaN unknown.
    error : ndarray of shape (rows, cols), float64
        Standard error of each gain; NaN where none was measured.
    residual : ndarray of shape (rows, cols), float64
        Root mean square of what the presses leave unexplained at each taxel, as a share of their peak.
    curve : Curve or None
        The points of the response, where one was measured.
    """

    kind: str
    sensor: Sensor
    presses: int
    findings: tuple[Finding, ...]
    unknown: tuple[str, ...]
    notes: tuple[str, ...]
    before: Floats
    after: Floats
    error: Floats
    residual: Floats
    curve: Curve | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return what was found as plain values that JSON can hold."""
        return {
            "kind": self.kind,
            "presses": self.presses,
            "found": {each.name: {"value": each.value, "error": each.error} for each in self.findings},
            "unknown": list(self.unknown),
            "notes": list(self.notes),
            "gains_applied": self.sensor.gains is not None,
        }

    def record(self) -> dict[str, Any]:
        """Return the table ``[calibration]`` of a sensor file."""
        return {
            "kind": self.kind,
            "presses": self.presses,
            **{f"{each.name}_error": each.error for each in self.findings},
            "unknown": list(self.unknown),
        }

    def recorded(self, more: Mapping[str, Any] | None = None) -> Calibration:
        """Return it with a sensor whose file says how it was measured, and what more there is to say.

        :meta private:
        """
        return replace(self, sensor=replace(self.sensor, calibration={**self.record(), **(more or {})}))


def error_of_spread(spread: float, differ: float, off: Floats, error: Floats) -> float:
    """Return the standard error of the spread of gains that a prior draws towards 1.

    Parameters
    ----------
    spread : float
        As it is told.
    differ : float
        Standard error of a gain, as two halves of the presses differ.
    off, error : ndarray of shape (n,), float64
        How far each gain is off 1, and its standard error by the fit: what its errors add to the scatter of the true
        gains does not show in `spread`.
    """
    if not off.size:
        return 0.0
    unseen = float(np.sqrt(np.mean(off**2 + error**2))) - spread
    return float(np.hypot(differ / np.sqrt(off.size), unseen))
