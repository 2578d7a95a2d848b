"""A sensor in words: what it is called, and what of it is undone."""

from __future__ import annotations

import numpy as np

from varishold.sensor.model import Sensor

__all__ = ["sensor_name", "undone_words"]


def sensor_name(sensor: Sensor) -> str:
    """Return what to call a sensor in an answer: its file, and its name where it has one."""
    if not sensor.source:
        return sensor.name or "sensor"
    return f"{sensor.name} ({sensor.source})" if sensor.name else sensor.source


def undone_words(sensor: Sensor) -> tuple[str, ...]:
    """Return what of a sensor is undone, in words."""
    words = []
    if sensor.polarity == "down" or np.ndim(sensor.rest) or sensor.rest:
        words.append("readings counted from rest" + (", downward" if sensor.polarity == "down" else ""))
    if sensor.response.kind != "linear":
        words.append(f"a {sensor.response.kind} response undone")
    if sensor.gains is not None:
        words.append("unequal gains undone")
    if sensor.crosstalk or sensor.blur_taxels:
        words.append("crosstalk and blur undone")
    if sensor.dead_band:
        words.append(f"{100 * sensor.dead_band:.2g} % of full scale is not felt")
    if sensor.resampling is not None:
        words.append(str(sensor.resampling))
    return tuple(words)
