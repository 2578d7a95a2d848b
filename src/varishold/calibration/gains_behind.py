"""Gains that were found before their response was known, as they are behind it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.frame.spread import spread_over
from varishold.sensor import Linear, Response, Sensor

__all__ = ["GAIN_READINGS", "gains_behind", "known_readings", "readings_of_gains"]

Floats = NDArray[np.float64]

#: What the table ``[calibration]`` calls the readings at which gains were found as if readings followed load in a line.
GAIN_READINGS = "gain_readings"

# So many readings at most are kept.
_MOST_KEPT = 16
# Gains that are looked at, and how many.
_LEAST, _MOST, _STEPS = 1e-3, 1e3, 600


def readings_of_gains(typical: Floats) -> list[float]:
    """Return what is to be kept of the usual taxel's reading in each press of an even pressure.

    Parameters
    ----------
    typical : ndarray of shape (n_presses,), float64
        Readings above rest.
    """
    ordered = np.sort(typical)
    return [float(f"{value:.6g}") for value in ordered[spread_over(ordered.size, _MOST_KEPT)]]


def known_readings(sensor: Sensor) -> Floats | None:
    """Return the readings at which a sensor's gains were found without its response; None where nothing tells them."""
    told = sensor.calibration.get(GAIN_READINGS)
    if sensor.gains is None or not isinstance(sensor.response, Linear) or not isinstance(told, Sequence):
        return None
    numbers = all(isinstance(each, int | float) and 0 < each < np.inf for each in told)
    return np.array(told, np.float64) if told and numbers else None


def gains_behind(response: Response, span: float, gains: Floats, readings: Floats) -> Floats:
    """Return the gains behind a response whose readings, each beside the usual taxel's, are `gains`.

    Parameters
    ----------
    response : Response
    span : float
        Reading at full scale.
    gains : ndarray
        Shares of the usual taxel's reading on the mean of the readings, weighed by their squares.
    readings : ndarray of shape (n_readings,), float64
        What the usual taxel read.
    """
    if isinstance(response, Linear):
        return gains
    tried = np.geomspace(_LEAST, _MOST, _STEPS)
    share = readings / span
    reads = response.reading(tried[:, None] * response.stress(share)) / share
    beside = np.average(reads, axis=1, weights=readings**2)
    found = np.exp(np.interp(gains, beside, np.log(tried)))
    made: Floats = np.where(gains > 0, found, gains)
    return made
