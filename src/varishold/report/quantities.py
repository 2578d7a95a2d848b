"""Numbers as a person reads them: three digits, an SI prefix where there is a unit, a true minus sign."""

from __future__ import annotations

import math

__all__ = ["angle", "area", "length", "number", "percent", "prefixed", "reading"]

_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PASCAL = ("pa", "pascal", "pascals")
_NARROW_SPACE = "\u202f"


def number(value: float, digits: int = 3) -> str:
    """Format a number with so many significant digits and no exponent where it can be avoided.

    Examples
    --------
    >>> number(1234.6), number(0.012345), number(-3.0)
    ('1235', '0.0123', '−3')
    """
    if not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if -4 <= size < 6:
        places = max(digits - 1 - math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}")))), 0)
        text = f"{value:.{places}f}"
        if "." in text:
            text = text.rstrip("0").rstrip(".")
    else:
        text = f"{value:.{digits - 1}e}"
    return text.replace("-", "−")


def prefixed(value: float, unit: str, power: int = 1) -> str:
    """Format a quantity with the prefix that suits it; `power` is that of the prefix (2 for squares).

    Examples
    --------
    >>> prefixed(0.0123, "N")
    '12.3\u202fmN'
    """
    if value == 0 or not math.isfinite(value):
        return f"{number(value)}{_NARROW_SPACE}{unit}"
    for factor, prefix in _PREFIXES:
        if abs(value) >= 0.9995 * factor**power:
            return f"{number(value / factor**power)}{_NARROW_SPACE}{prefix}{unit}"
    factor, prefix = _PREFIXES[-1]
    return f"{number(value / factor**power)}{_NARROW_SPACE}{prefix}{unit}"


def length(value: float, *, metres: bool) -> str:
    """Format a length in metres, or in taxels.

    Examples
    --------
    >>> length(0.0123, metres=True), length(12.3, metres=False)
    ('12.3\u202fmm', '12.3\u202ftaxels')
    """
    if metres:
        # Lengths on a pad are told in millimetres down to a tenth: nobody reads 300 µm between 1.2 mm and 4 mm.
        if 1e-4 <= abs(value) < 1:
            return f"{number(1e3 * value)}{_NARROW_SPACE}mm"
        return prefixed(value, "m")
    return f"{number(value)}{_NARROW_SPACE}{'taxel' if abs(value) == 1 else 'taxels'}"


def area(value: float, *, metres: bool) -> str:
    """Format an area in square metres, or in taxels.

    Examples
    --------
    >>> area(1.23e-4, metres=True), area(80.4, metres=False)
    ('123\u202fmm²', '80.4\u202ftaxels')
    """
    if metres:
        if 1e-8 <= abs(value) < 1e-2:
            return f"{number(1e6 * value)}{_NARROW_SPACE}mm²"
        return prefixed(value, "m²", power=2)
    return f"{number(value)}{_NARROW_SPACE}taxels"


def angle(radians: float) -> str:
    """Format an angle in degrees.

    Examples
    --------
    >>> angle(-0.5)
    '−28.6°'
    """
    return f"{number(round(math.degrees(radians), 1), 4)}°"


def percent(share: float) -> str:
    """Format a probability; what is not certain is never shown as 0 % or 100 %.

    Examples
    --------
    >>> percent(0.987), percent(0.9999), percent(0.0001)
    ('98.7\u202f%', '>\u202f99.9\u202f%', '<\u202f0.1\u202f%')
    """
    if 0.999 < share < 1:
        return f">{_NARROW_SPACE}99.9{_NARROW_SPACE}%"
    if 0 < share < 0.001:
        return f"<{_NARROW_SPACE}0.1{_NARROW_SPACE}%"
    return f"{round(100 * share, 1):g}{_NARROW_SPACE}%"


def reading(value: float, unit: str) -> str:
    """Format what a taxel reads, in the recording's unit.

    Examples
    --------
    >>> reading(12345.0, "Pa"), reading(812.0, "raw")
    ('12.3\u202fkPa', '812')
    """
    if unit.lower() in _PASCAL:
        return prefixed(value, "Pa")
    if unit.lower() in ("m", "metre", "metres"):
        return length(value, metres=True)
    if unit in ("raw", ""):
        return number(value)
    return f"{number(value)}{_NARROW_SPACE}{unit}"
