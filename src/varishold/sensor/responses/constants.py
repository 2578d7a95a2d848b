"""The one check of a response's constant."""

from __future__ import annotations

from typing import Any

from varishold.errors import InputError

__all__ = ["positive"]


def positive(name: str, value: Any, least: float, most: float) -> float:
    """Return a response's constant as a float.

    Raises
    ------
    InputError
        If it is no number from `least` to `most`.
    """
    number = not isinstance(value, bool) and isinstance(value, int | float)
    if not number or not least <= value <= most:
        raise InputError(f"{name} of a response must be a number from {least:g} to {most:g}, got {value!r}")
    return float(value)
