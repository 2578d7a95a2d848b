"""How what a recording and its pads are made of is kept."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from varishold.errors import InputError

__all__ = ["checked_notes", "checked_unit", "frozen"]


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array of our own, which nobody can write to from now on."""
    array.flags.writeable = False
    return array


def checked_notes(notes: object) -> tuple[str, ...]:
    """Return notes, refusing what are no texts."""
    if not isinstance(notes, tuple | list) or not all(isinstance(note, str) for note in notes):
        raise InputError(f"notes must be a tuple of texts, got {str(notes)[:60]!r}")
    return tuple(notes)


def checked_unit(unit: object) -> str:
    """Return the name of a unit; "raw" where there is none."""
    return str(unit).strip() or "raw"
