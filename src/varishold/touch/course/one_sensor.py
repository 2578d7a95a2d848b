"""Presses of one sensor: the same pads, taxels as far apart, readings in one unit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from varishold._counted import counted
from varishold.errors import InputError
from varishold.recording import pascals_per_unit
from varishold.touch.course.presses import Press

__all__ = ["UNKNOWN_UNIT", "SensorScale", "check_same_pads", "of_one_sensor", "pads_in_words", "pitch_in_words"]

#: The unit of readings that have none.
UNKNOWN_UNIT = "raw"
# Taxels are as far apart where what was written down differs by no more than this share.
_AS_FAR = 0.05
# So many files are named.
_MOST_NAMED = 3


@dataclass(frozen=True)
class SensorScale:
    """What a sensor's readings and distances are told in, as far as it is known.

    Parameters
    ----------
    unit : str
        Of the readings; "raw" where it is not known.
    pitch_m : mapping of str to (float, float)
        How far the taxels' rows and columns are apart, of the pads of which it is known; metres.
    """

    unit: str = UNKNOWN_UNIT
    pitch_m: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(cls, presses: Iterable[Press]) -> SensorScale:
        """Return what the first presses say that say anything."""
        unit, pitch_m = UNKNOWN_UNIT, dict[str, tuple[float, float]]()
        for press in presses:
            unit = press.unit if unit == UNKNOWN_UNIT else unit
            pitch_m = {**press.pitch_m, **pitch_m}
        return cls(unit, pitch_m)

    def factor(self, press: Press) -> float | None:
        """Return what readings of a press are multiplied by to be in this unit; None where that is not known."""
        if UNKNOWN_UNIT in (self.unit, press.unit) or press.unit == self.unit:
            return 1.0
        mine, other = pascals_per_unit(self.unit), pascals_per_unit(press.unit)
        return None if mine is None or other is None else other / mine

    def other_pitch(self, press: Press) -> str | None:
        """Return the pad whose taxels are not as far apart in a press, where there is one."""
        for name, pitch in press.pitch_m.items():
            mine = self.pitch_m.get(name, pitch)
            if any(abs(a - b) > _AS_FAR * max(a, b) for a, b in zip(mine, pitch, strict=True)):
                return name
        return None

    def taken(self, presses: Sequence[Press], said_by: str, *, levels_count: bool = True) -> list[Press]:
        """Return presses with their readings in this unit.

        Parameters
        ----------
        presses : sequence of Press
        said_by : str
            Whose scale this is, for messages.
        levels_count : bool
            Whether how high readings are says anything; otherwise those in a unit that has nothing to do with this one
            are left as they are.

        Raises
        ------
        InputError
            Naming the files whose taxels are not as far apart, or whose unit cannot be converted.
        """
        for press in presses:
            name = self.other_pitch(press)
            if name is not None:
                others = places_of(presses, lambda one: self.other_pitch(one) is not None)
                raise InputError(
                    f"{others}: taxels of {name!r} are {pitch_in_words(press.pitch_m[name])} apart, those of {said_by} "
                    f"{pitch_in_words(self.pitch_m[name])}; forms are measured in taxels: keep to recordings of one "
                    "pitch, or correct pitch_m where it is wrong"
                )
        factors = [self.factor(press) for press in presses]
        if levels_count and None in factors:
            press = presses[factors.index(None)]
            others = places_of(presses, lambda one: self.factor(one) is None)
            raise InputError(
                f"{others}: readings are in {press.unit}, those of {said_by} in {self.unit}, which are not converted; "
                "keep to recordings of one unit, or correct unit where it is wrong"
            )
        return [_times(press, factor, self.unit) for press, factor in zip(presses, factors, strict=True)]

    def remarks_on(self, presses: Sequence[Press], said_by: str) -> tuple[str, ...]:
        """Return what is to be said of presses that are taken in this scale, as `taken` takes them."""
        found = []
        if self.unit != UNKNOWN_UNIT:
            unknown = sum(press.unit == UNKNOWN_UNIT for press in presses)
            if unknown:
                found.append(f"{_so_many(unknown)} no unit: taken in {self.unit}, that of {said_by}")
            for unit in dict.fromkeys(press.unit for press in presses if self.factor(press) not in (1.0, None)):
                found.append(f"readings in {unit} are taken in {self.unit}, that of {said_by}")
            for unit in dict.fromkeys(press.unit for press in presses if self.factor(press) is None):
                found.append(f"readings are in {unit}, those of {said_by} in {self.unit}: forms alone are compared")
        else:
            for unit in dict.fromkeys(press.unit for press in presses if press.unit != UNKNOWN_UNIT):
                found.append(f"readings in {unit} are taken as they are: no unit is known of {said_by}")
        silent = sum(not press.pitch_m.keys() >= self.pitch_m.keys() & press.pads.keys() for press in presses)
        if silent:
            found.append(f"{_so_many(silent)} no pitch: taxels are taken to be as far apart as those of {said_by}")
        return tuple(found)


def of_one_sensor(presses: Sequence[Press], *, levels_count: bool = True) -> list[Press]:
    """Return presses in the unit of the first that has one.

    Raises
    ------
    InputError
        If they are of different pads, differ in how far taxels are apart, or in units that cannot be converted.
    """
    check_same_pads(presses)
    scale = SensorScale.of(presses)
    first = places_of(presses, lambda one: bool(one.pitch_m) or one.unit != UNKNOWN_UNIT, most=1)
    return scale.taken(presses, first, levels_count=levels_count)


def check_same_pads(presses: Sequence[Press], *, common: bool = False) -> None:
    """Check that presses are of one sensor: no pad has two sizes.

    Parameters
    ----------
    presses : sequence of Press
    common : bool
        Whether each has a pad in common with the first; otherwise each may be without any.

    Raises
    ------
    InputError
        Naming the first that is of another sensor.
    """
    known: dict[str, tuple[int, int]] = {}
    for press in presses:
        strange = common and known and not press.shapes.keys() & presses[0].shapes.keys()
        if strange or any(known.get(name, shape) != shape for name, shape in press.shapes.items()):
            raise InputError(
                f"{press.place}: has the pads {pads_in_words(press.shapes)}, those before it {pads_in_words(known)}; "
                "give presses of one sensor"
            )
        known |= press.shapes


def pads_in_words(shapes: Mapping[str, tuple[int, int]]) -> str:
    """Return pads by name and size, for messages."""
    return ", ".join(f"{name} {rows} x {cols}" for name, (rows, cols) in shapes.items())


def pitch_in_words(pitch_m: tuple[float, float]) -> str:
    """Return how far rows and columns are apart, in millimetres."""
    rows, cols = (f"{1e3 * side:.4g}" for side in pitch_m)
    return f"{rows} mm" if rows == cols else f"{rows} x {cols} mm"


def places_of(presses: Iterable[Press], wanted: Callable[[Press], bool], *, most: int = _MOST_NAMED) -> str:
    """Return where some presses stand: their files, the first few by name."""
    files = list(
        dict.fromkeys(press.place.rpartition(", press ")[0] or press.place for press in presses if wanted(press))
    )
    more = f" and {len(files) - most} more" if len(files) > most > 1 else ""
    return ", ".join(files[:most]) + more


def _so_many(presses: int) -> str:
    return counted(presses, "press says", "presses say")


def _times(press: Press, factor: float | None, unit: str) -> Press:
    if factor is None or factor == 1.0:
        return press
    return replace(press, pads={name: factor * frames for name, frames in press.pads.items()}, unit=unit)
