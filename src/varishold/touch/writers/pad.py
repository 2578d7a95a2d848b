"""What is exported: a pad, its sensor, its learned decision, and how finely it is kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.sensor import Sensor
from varishold.sensor.responses import Linear
from varishold.touch.contact_network import LEVELS, ContactNetwork, check_sides
from varishold.touch.decision import load_parameters
from varishold.touch.network import Decision
from varishold.touch.recognizer import table_for
from varishold.touch.scale import small_gaps
from varishold.touch.signature import SIGNATURE_NAMES

__all__ = ["Export", "Weights"]

Weights = Literal["int8", "float32"]

_MOST_CONTACTS = 64
_COARSEST = 127
# The most that rest, span and full scale may be: squares of stresses are numbers of single precision.
_MOST_STRESS = 1e17


@dataclass(frozen=True, eq=False)
class Export:
    """A recognizer to be written as source.

    Parameters
    ----------
    shape : (int, int), optional
        Rows and columns of the pad. Default: the sensor's, or 16 x 16.
    levels : int
        Thresholds a contact; a `ContactNetwork` was learned at 32.
    contacts : int
        The most contacts that are told apart, the largest first.
    sensor : Sensor, optional
        What makes the readings; default: readings are stresses.
    weights : {"int8", "float32"}
        How the network's weights are kept; int8 has a scale for each output.
    parameters : Decision, optional
        What was learned. Default: the shipped table for pads of this size. A `ContactNetwork` has the shape and the
        field of its pad; of the sensor only rest and polarity are then undone, as they were in learning.

    Raises
    ------
    InputError
        If a value is out of its range, or the sensor is not one that a controller can undo.
    """

    shape: tuple[int, int] | None = None
    levels: int = 32
    contacts: int = 2
    sensor: Sensor | None = None
    weights: Weights = "int8"
    parameters: Decision | None = None

    def __post_init__(self) -> None:
        sensor = self.sensor
        if sensor is not None and sensor.positions_m is not None:
            raise InputError("a sensor whose taxels stand on no grid cannot be exported; resample it on the controller")
        if isinstance(self.parameters, ContactNetwork):
            sensor = _plain_sensor(sensor, self.parameters)
            object.__setattr__(self, "sensor", sensor)
        own = self.parameters.shape if isinstance(self.parameters, ContactNetwork) else None
        known, whose = (own, "model") if own else (None if sensor is None else sensor.shape, "sensor")
        shape = self.shape or known or (16, 16)
        if known is not None and shape != known:
            raise InputError(
                f"shape must be the {whose}'s, {known[0]}x{known[1]}, got {shape[0]}x{shape[1]}", parameter="shape"
            )
        check_sides(shape)
        if not 4 <= self.levels <= 512:
            raise InputError(f"levels must be from 4 to 512, got {self.levels}", parameter="levels")
        if own and self.levels != LEVELS:
            raise InputError(
                f"what own presses taught was learned at {LEVELS} thresholds a contact, got levels {self.levels}; "
                "leave them as they are",
                parameter="levels",
            )
        if not 1 <= self.contacts <= _MOST_CONTACTS:
            raise InputError(f"contacts must be from 1 to {_MOST_CONTACTS}, got {self.contacts}", parameter="contacts")
        if sensor is not None:
            _check_single(sensor)
        spreads = sensor is not None and (sensor.crosstalk or sensor.blur_taxels)
        if sensor is not None and spreads and sensor.field is not None and not sensor.field.all():
            raise InputError("crosstalk and blur of a pad with gaps cannot be undone on a controller; leave them out")
        if sensor is not None and self.parameters is None:
            object.__setattr__(self, "sensor", _bridged(sensor))
        parameters = self.parameters or load_parameters(table_for(shape))
        if len(parameters.shift) != len(SIGNATURE_NAMES):
            raise InputError(
                f"a decision that is exported has the {len(SIGNATURE_NAMES)} inputs of the signature, got "
                f"{len(parameters.shift)}"
            )
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "parameters", parameters)

    @property
    def rows_and_cols(self) -> tuple[int, int]:
        """Rows and columns of the pad."""
        assert self.shape is not None
        return self.shape

    @property
    def decision(self) -> Decision:
        """The learned decision."""
        assert self.parameters is not None
        return self.parameters

    @property
    def pitch(self) -> tuple[float, float]:
        """Row and column spacing: metres, or taxels where it is unknown."""
        known = None if self.sensor is None else self.sensor.pitch_m
        return (1.0, 1.0) if known is None else known


def _check_single(sensor: Sensor) -> None:
    """Refuse readings and stresses that single precision has no room for."""
    for name in ("rest", "span", "full_scale"):
        most = float(np.abs(getattr(sensor, name)).max())
        if most > _MOST_STRESS:
            raise InputError(
                f"{name} of a sensor that is exported must be at most {_MOST_STRESS:g}, for numbers of single "
                f"precision, got {most:g}; take a larger unit"
            )


def _bridged(sensor: Sensor) -> Sensor:
    """Return a sensor with broken taxels in its small gaps: they are filled, as they are where names are given."""
    gaps = None if sensor.field is None else small_gaps(sensor.field)
    if sensor.field is None or gaps is None or not gaps.any():
        return sensor
    gains = np.ones(sensor.field.shape) if sensor.gains is None else sensor.gains
    return replace(sensor, field=sensor.field | gaps, gains=np.where(gaps, 0.0, gains))


def _plain_sensor(sensor: Sensor | None, network: ContactNetwork) -> Sensor | None:
    """Return what of a sensor is undone before presses are learned from; None where that is nothing."""
    if sensor is None and network.field.all():
        return None
    known = sensor or Sensor()
    if known.shape is not None and known.shape != network.shape:
        (rows, cols), (own_rows, own_cols) = known.shape, network.shape
        raise InputError(f"the sensor has {rows} x {cols} taxels, the model was learned on {own_rows} x {own_cols}")
    return replace(
        known,
        shape=network.shape,
        field=network.field,
        # Lengths were taxels in learning: what is longer than broad must be so here.
        pitch_m=known.pitch_m if known.pitch_m is not None and len(set(known.pitch_m)) == 1 else None,
        response=Linear(),
        gains=None if known.broken is None else np.where(known.broken, 0.0, 1.0),
        dead_band=0.0,
        saturation=None,
        crosstalk=0.0,
        blur_taxels=0.0,
    )


def coarse(weight: NDArray[np.float32]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return weights as whole numbers, and what one is worth in each column."""
    largest = np.abs(weight).max(axis=0, initial=0.0)
    scale = np.where(largest > 0, largest / _COARSEST, 1.0).astype(np.float32)
    return np.rint(weight / scale).astype(np.int8), scale
