"""Frames whose names an exported recognizer is compared with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.solids import draw_contact, ideal_frame
from varishold.touch.names import NAMES
from varishold.touch.recognizer import recognize
from varishold.touch.sensing import find_contacts
from varishold.touch.writers.pad import Export

__all__ = ["Vector", "check_vectors"]

_SOLIDS = (
    *("cylinder", "square-pillar", "rectangular-pillar", "cone-frustum", "pyramid-frustum", "sphere", "cone"),
    *("pyramid", "ridge", "hip", "lying-cylinder", "edge", "plane"),
)
_COUNT, _SEED = 65, 1971
# Breadth of a contact beside the pad's shorter side, and noise beside its peak.
_BREADTH, _NOISE = (0.45, 0.8), 0.005


@dataclass(frozen=True, eq=False)
class Vector:
    """One frame and what Python says of it.

    Parameters
    ----------
    readings : ndarray of shape (rows, cols), float32
        What the sensor reads.
    n_touches : int
        How many contacts there are, as far as they are told apart.
    name : int
        Index of the largest contact's name; -1 where there is none.
    probability : float
        Of this name.
    """

    readings: NDArray[np.float32]
    n_touches: int
    name: int
    probability: float


def check_vectors(wanted: Export, count: int = _COUNT, *, seed: int = _SEED) -> list[Vector]:
    """Return drawn contacts as the sensor reads them, a solid after the other, and an empty frame at the end.

    Parameters
    ----------
    wanted : Export
    count : int
        How many.
    seed : int
    """
    rng = np.random.default_rng(seed)
    rows, cols = wanted.rows_and_cols
    side = min(rows, cols)
    vectors = []
    for i in range(count):
        drawn = draw_contact(
            rng,
            _SOLIDS[i % len(_SOLIDS)],
            field_m=(float(rows), float(cols)),
            size_m=(_BREADTH[0] * side, _BREADTH[1] * side),
        )
        frame = ideal_frame(drawn.solid, (rows, cols), 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
        frame *= float(i + 1 < count) / max(frame.max(), 1e-12)
        frame += rng.normal(0.0, _NOISE, frame.shape) * float(i + 1 < count)
        sensor = wanted.sensor
        if sensor is not None:
            frame = sensor.forward(0.5 * sensor.full_scale * frame)
        vectors.append(_expected(wanted, frame.astype(np.float32)))
    return vectors


def _expected(wanted: Export, readings: NDArray[np.float32]) -> Vector:
    contacts = find_contacts(readings.astype(np.float64), wanted.levels, pitch=wanted.pitch, sensor=wanted.sensor)
    if not contacts:
        return Vector(readings, 0, -1, 0.0)
    surface = recognize(contacts[0])
    return Vector(readings, min(len(contacts), wanted.contacts), NAMES.index(surface.name), surface.probability)
