"""Frames whose names an exported recognizer is compared with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.solids import draw_contact, ideal_frame
from varishold.touch.contact_network import ContactNetwork
from varishold.touch.recognizer import decided
from varishold.touch.sensing import find_contacts
from varishold.touch.writers.pad import Export

__all__ = ["SOLIDS", "Vector", "check_vectors"]

#: The solids that are drawn.
SOLIDS = (
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
    """Return frames as the sensor reads them, and an empty one at the end.

    Of a decision that own presses taught first what it learned from, then a few drawn solids, which are mostly
    strangers; otherwise drawn solids, one after the other.

    Parameters
    ----------
    wanted : Export
    count : int
        How many drawn ones, the empty one among them; beside own presses one of each solid.
    seed : int
    """
    rng = np.random.default_rng(seed)
    own = wanted.decision.examples if isinstance(wanted.decision, ContactNetwork) else ()
    count = len(SOLIDS) + 1 if len(own) else count
    drawn = [_drawn(wanted, rng, SOLIDS[i % len(SOLIDS)], float(i + 1 < count)) for i in range(count)]
    sensor = wanted.sensor
    if sensor is None:
        return [_expected(wanted, frame.astype(np.float32)) for frame in (*own, *drawn)]
    # What was learned from are readings above rest.
    stresses = (
        *(own_frame * sensor.full_scale / sensor.span for own_frame in own),
        *(0.5 * sensor.full_scale * frame for frame in drawn),
    )
    return [_expected(wanted, sensor.forward(stress).astype(np.float32)) for stress in stresses]


def _drawn(wanted: Export, rng: np.random.Generator, solid: str, height: float) -> NDArray[np.float64]:
    """Return a drawn solid pressed so high into the pad."""
    rows, cols = wanted.rows_and_cols
    side = min(rows, cols)
    drawn = draw_contact(
        rng, solid, field_m=(float(rows), float(cols)), size_m=(_BREADTH[0] * side, _BREADTH[1] * side)
    )
    frame = ideal_frame(drawn.solid, (rows, cols), 1.0, depth_m=drawn.depth_m, pose=drawn.pose)
    frame *= height / max(frame.max(), 1e-12)
    return np.asarray(frame + rng.normal(0.0, _NOISE, frame.shape) * height)


def _expected(wanted: Export, readings: NDArray[np.float32]) -> Vector:
    contacts = find_contacts(readings.astype(np.float64), wanted.levels, pitch=wanted.pitch, sensor=wanted.sensor)
    if not contacts:
        return Vector(readings, 0, -1, 0.0)
    n_touches, said = min(len(contacts), wanted.contacts), decided(contacts[0], wanted.decision.kernel)
    return Vector(readings, n_touches, *((-1, 0.0) if said is None else (said[0].name, said[0].probability)))
