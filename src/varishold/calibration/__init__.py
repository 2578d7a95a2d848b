"""Calibration: a sensor file from recordings, and how sure it is.

`calibrate_even` finds gains, and with known pressures the response, from an even pressure; `calibrate_objects`
response, dead band, blur and gains from objects of known form and size; `calibrate_unlabelled` gains, as far as they
can be known, from presses of anything; `calibrate_scale` gains from small tips on a scale. Each returns a
`Calibration`: what was found with its standard error, what could not be known, and the sensor to be written with
`varishold.sensor.write_sensor`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "Calibration",
    "Curve",
    "Finding",
    "KnownObject",
    "calibrate_even",
    "calibrate_objects",
    "calibrate_scale",
    "calibrate_unlabelled",
    "known_object",
]

if TYPE_CHECKING:
    from varishold.calibration.even import calibrate_even
    from varishold.calibration.imprint import KnownObject, known_object
    from varishold.calibration.objects import calibrate_objects
    from varishold.calibration.result import Calibration, Curve, Finding
    from varishold.calibration.scale import calibrate_scale
    from varishold.calibration.unlabelled import calibrate_unlabelled
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
