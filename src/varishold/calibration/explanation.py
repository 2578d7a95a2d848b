"""Which response explains presses of known objects best, by presses that it was not fitted to."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.calibration.covers import SPRINGS, Cover
from varishold.calibration.gains_behind import gains_behind
from varishold.calibration.imprint import Points
from varishold.calibration.press_fit import ENOUGH, Fit, Observed, fit_presses
from varishold.sensor import Linear, Logarithmic, Power, Response, Sensor

__all__ = [
    "BLUR",
    "DEAD",
    "FAMILIES",
    "WELL",
    "Explanation",
    "Family",
    "Hypothesis",
    "Observations",
    "best_fit",
    "explain",
    "families_of",
    "fitted",
]

Floats = NDArray[np.float64]

# A response of one constant more must explain presses that it was not fitted to so much better.
_WORTH = 0.95
# What is smaller than so many standard errors is none.
_SURE = 2.0
#: A usual press is explained well where no more sigmas are left of it.
WELL = 1.5
# A dead band must explain presses by so much better than none, and well, where none does not (a press that is as much
# less deep looks the same): it may make up for an object of another form.
_DEAD_WORTH = 0.9
# The logarithm of a response's constant is off by so much where faces are looked at by points.
_BY_POINTS = 0.008
# Under a layer by so much more: what an edge leaves there is known to two hundredths.
_BY_TABLES = 0.15
# The first constant of a fit, before those of the response: logarithm of full scale beside depth.
_SCALE = 0
#: The second and the third: dead band, blur squared.
DEAD, BLUR = 1, 2
# Step of the derivative by gains.
_STEP = 1e-4
# How large a dead band may be, and what is none to a fit that wants room.
_MOST_DEAD, _NO_DEAD = 0.8, 1e-9


@dataclasses.dataclass(frozen=True)
class Family:
    """A response to be tried: how it is made of its constant, where the constant's logarithm begins and must stay."""

    name: str
    made: Callable[..., Response]
    start: tuple[float, ...] = ()
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    says: str = ""

    def response(self, constants: Floats) -> Response:
        return self.made(*np.exp(constants).tolist())


FAMILIES = (
    Family("linear", Linear),
    Family("power", Power, (0.0,), (np.log(0.2),), (np.log(5.0),), "of the power response y = x^exponent"),
    Family(
        "logarithmic",
        Logarithmic,
        (1.0,),
        (np.log(0.02),),
        (np.log(500.0),),
        "of the logarithmic response y = log(1 + a x) / log(1 + a)",
    ),
)


@dataclasses.dataclass(frozen=True, eq=False)
class Observations:
    """Presses to be explained, the pad that they were made on, and its sensor without what is to be found.

    `gain_spread` is how far its gains spread, where they were found from these presses.
    """

    base: Sensor
    observed: Sequence[Observed]
    points: Points
    usable: NDArray[np.bool_]
    gain_readings: Floats | None = None
    gain_spread: float | None = None

    def sensor(self, family: Family, constants: Floats) -> Sensor:
        """Return the sensor of these constants; gains that were found without a response are put behind it."""
        response, gains = family.response(constants[3:]), self.base.gains
        if gains is not None and self.gain_readings is not None:
            gains = gains_behind(response, self.base.span, gains, self.gain_readings)
        return dataclasses.replace(
            self.base,
            dead_band=float(np.clip(constants[DEAD], 0.0, 0.85)),
            blur_taxels=float(np.sqrt(np.clip(constants[BLUR], 0.0, 16.0))),
            response=response,
            gains=gains,
        )

    def with_gains(self, gains: Floats, spread: float) -> Observations:
        """The same presses of a sensor with gains that were found from them, and spread so far."""
        return dataclasses.replace(self, base=dataclasses.replace(self.base, gains=gains), gain_spread=spread)

    def under(self, cover: Cover) -> Observations:
        """The same presses, taken to be made through that cover."""
        return dataclasses.replace(self, points=dataclasses.replace(self.points, cover=cover))

    def half(self, k: int) -> Observations:
        """Every second press, from the first (0) or the second (1) on."""
        return dataclasses.replace(self, observed=self.observed[k::2])


class Hypothesis(NamedTuple):
    """What may explain presses: a response, and what covers the taxels."""

    family: Family
    cover: Cover = SPRINGS

    @property
    def bends(self) -> bool:
        """Whether the response is other than linear."""
        return self.family is not FAMILIES[0]

    @property
    def name(self) -> str:
        return self.family.name if self.cover == SPRINGS else f"{self.family.name} under a layer"

    @property
    def constants(self) -> int:
        """How many constants it has that the plainest one has not."""
        return self.bends + (self.cover != SPRINGS)


@dataclasses.dataclass(frozen=True, eq=False)
class Explanation:
    """What explains presses best: its fit, how sure its constants are, and whether there is a dead band."""

    hypothesis: Hypothesis
    fit: Fit
    error: Floats
    dead: bool

    @property
    def constants(self) -> Floats:
        """The fit's constants, 0 where they are none, or not to be believed."""
        constants = self.fit.constants.copy()
        for index, told in ((DEAD, self.dead), (BLUR, self.well)):
            if not told or constants[index] < _SURE * self.error[index]:
                constants[index] = 0.0
        return constants

    @property
    def family(self) -> Family:
        return self.hypothesis.family

    @property
    def well(self) -> bool:
        """Whether a usual press is explained well: otherwise a blur makes up for what is not, and undone does harm."""
        return self.typical <= WELL

    @property
    def typical(self) -> float:
        """What is left of a usual press, in its sigmas."""
        return _typical(self.fit)


def families_of(given: Observations) -> tuple[Family, ...]:
    """Return the responses that these presses can tell from each other: a flat face presses everywhere alike."""
    return FAMILIES if any(one.object.curved for one in given.observed) else FAMILIES[:1]


def explain(of: Mapping[Hypothesis, Observations], tick: Callable[..., object]) -> tuple[Explanation, dict[str, float]]:
    """Return what explains presses best, and how badly each hypothesis explains those that it was not fitted to.

    Parameters
    ----------
    of : mapping of Hypothesis to Observations
        The presses under each cover to be tried, with the gains that they make behind each response.
    tick : callable
        Called with ``advance=1`` after each, and after the best is fitted.
    """
    tried = {}
    for each, given in of.items():
        tried[each] = _held_out(each.family, given)
        tick(advance=1)
    numbers = sorted({each.constants for each in of})
    chosen, *larger = (min((each for each in of if each.constants == n), key=tried.__getitem__) for n in numbers)
    for each in larger:
        if tried[each] < _WORTH * tried[chosen]:
            chosen = each
    fit, dead = best_fit(chosen.family, of[chosen])
    error = _errors_of(chosen.family, of[chosen], fit, dead=dead)
    tick(advance=1)
    return Explanation(chosen, fit, error, dead), {each.name: cost for each, cost in tried.items()}


def fitted(
    family: Family,
    given: Observations,
    *,
    places: Sequence[Floats] | None = None,
    free: bool = True,
    constants: Floats | None = None,
    dead: bool = True,
    enough: float = ENOUGH,
) -> Fit:
    """Return the fit of a response to presses, with or without a dead band."""
    base, observed, points = given.base, given.observed, given.points

    def forward(faces: Floats, at: Floats) -> Floats:
        return given.sensor(family, at).forward(faces * (np.exp(at[_SCALE]) * base.full_scale))

    def by_gain(faces: Floats, at: Floats) -> Floats:
        stress, sensor = faces * (np.exp(at[_SCALE]) * base.full_scale), given.sensor(family, at)
        gains = np.ones(given.usable.shape) if sensor.gains is None else sensor.gains
        larger = dataclasses.replace(sensor, gains=(1.0 + _STEP) * gains)
        grown: Floats = (larger.forward(stress) - sensor.forward(stress)) / _STEP
        return grown

    if constants is None:
        telling = [one for one in observed if one.object.curved] or observed
        deepest = max(float(one.object.stress(one.start, points).max()) for one in telling)
        constants = np.array([-np.log(deepest), 0.02, 0.1, *family.start])
    high = np.array([30.0, _MOST_DEAD if dead else _NO_DEAD, 9.0, *family.high])
    return fit_presses(
        forward,
        np.minimum(constants, high),
        observed,
        points,
        given.usable,
        low=np.array([-30.0, 0.0, 0.0, *family.low]),
        high=high,
        places=places,
        free=free,
        by_gain=None if given.gain_spread is None else by_gain,
        gain_spread=given.gain_spread or 0.0,
        enough=enough,
    )


def _held_out(family: Family, given: Observations) -> float:
    """Return how badly a family explains presses that it was not fitted to, in their sigmas."""
    cost = []
    for k in (0, 1):
        fit = fitted(family, given.half(k))
        other = fitted(family, given.half(1 - k), constants=fit.constants, free=False)
        cost.append(np.median(other.cost))
    return float(np.sqrt(np.mean(cost)))


def best_fit(family: Family, given: Observations) -> tuple[Fit, bool]:
    """Return the fit with a dead band where that explains presses better, else without; and which one it is."""
    fit, plain = fitted(family, given), fitted(family, given, dead=False)
    dead = _typical(fit) < min(_DEAD_WORTH * _typical(plain), WELL) and _typical(plain) > WELL
    return (fit, True) if dead else (plain, False)


def _errors_of(family: Family, given: Observations, fit: Fit, *, dead: bool) -> Floats:
    """Return the standard errors of the constants: as halves of the presses repeat them, at least as the fit says.

    Two halves may agree by chance; how far each press pulls the constants does not.

    Where presses are not explained, what all have alike is no noise that becomes less with their number.
    """
    first, second = (
        fitted(family, given.half(k), places=fit.places[k::2], constants=fit.constants, dead=dead) for k in (0, 1)
    )
    alike = np.sqrt(len(fit.places)) if _typical(fit) > WELL else 1.0
    repeated = np.maximum(np.abs(first.constants - second.constants) / 2, fit.error)
    errors: Floats = np.maximum(alike * repeated, fit.press_error)
    errors[3:] = np.hypot(errors[3:], _BY_POINTS if given.points.cover == SPRINGS else _BY_TABLES)
    return errors


def _typical(fit: Fit) -> float:
    """Return what a fit leaves of a usual press, in its sigmas."""
    return float(np.sqrt(np.median(fit.cost)))
