"""What units of pressure are in pascal."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["pascals_per_unit"]

_PASCALS: Mapping[str, float] = MappingProxyType(
    {
        "pa": 1.0,
        "pascal": 1.0,
        "pascals": 1.0,
        "hpa": 1e2,
        "kpa": 1e3,
        "mpa": 1e6,
        "bar": 1e5,
        "mbar": 1e2,
        "n/m2": 1.0,
        "n/cm2": 1e4,
        "n/mm2": 1e6,
        "g/cm2": 98.0665,
        "kg/cm2": 98066.5,
        "psi": 6894.757293168361,
        "mmhg": 133.322387415,
        "inhg": 3386.389,
        "torr": 133.32236842105263,
        "atm": 101325.0,
    }
)


def pascals_per_unit(unit: str) -> float | None:
    """Return what one of a unit is in pascal; None where it is no known unit of pressure.

    Examples
    --------
    >>> pascals_per_unit("N/cm²"), pascals_per_unit("MPa"), pascals_per_unit("mPa"), pascals_per_unit("raw")
    (10000.0, 1000000.0, 0.001, None)
    """
    # Of all units here only this one is another in small letters.
    if unit.strip() == "mPa":
        return 1e-3
    return _PASCALS.get(unit.lower().replace("²", "2").replace("^", "").replace(" ", ""))
