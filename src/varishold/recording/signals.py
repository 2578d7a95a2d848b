"""Signals: numbers beside the pads that are no pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.frame.checks import as_numbers
from varishold.recording.kept import checked_unit, frozen

__all__ = ["Signals"]


@dataclass(frozen=True, eq=False)
class Signals:
    """Numbers beside the pads that are no pressure: shear, temperatures, magnetometers.

    Parameters
    ----------
    values : ndarray of shape (n_frames, n_signals), integer or float
        In their own type, NaN where one is not known.
    names : tuple of str
        What each is called; may be empty.
    unit : str

    Raises
    ------
    InputError
        If the values are no such numbers, or there are not as many names.
    """

    values: NDArray[Any]
    names: tuple[str, ...] = ()
    unit: str = "raw"

    def __post_init__(self) -> None:
        values = frozen(as_numbers(self.values, 2, "signals", masked=True).view())
        names = tuple(str(name) for name in self.names)
        if names and len(names) != values.shape[1]:
            raise InputError(f"signals must have a name each, got {counted(len(names), 'name')} of {values.shape[1]}")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "unit", checked_unit(self.unit))
