"""What MATLAB calls things and how it lays them out; both of its file formats hold a recording so.

``pressure`` is a variable, or a field of a struct that is called as its pad; what is said of a pad stands beside it.
``time_s``, ``press``, ``presses.LABEL``, ``signals.NAME``, ``signal_names.NAME``, ``signal_units.NAME``,
``marks.frame`` and ``marks.label``, ``unit`` and ``sensor`` are as in `named_arrays`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.files import damage_told
from varishold.recording.formats.format import Options
from varishold.recording.formats.guessing import TIMES, guessed
from varishold.recording.formats.named_arrays import PRESS, SIGNALS, SINGLE, NamedArrays, stored_in
from varishold.recording.stored import Column, Stored

__all__ = ["Variable", "place_of", "stored_variables"]

# Structs that are no pads, and what their fields are called in `named_arrays`.
_STRUCTS = {
    "presses": PRESS,
    "signals": SIGNALS,
    "signal_names": f"names.{SIGNALS}",
    "signal_units": f"unit.{SIGNALS}",
    "marks": "mark.",
}
_OF_PAD = (SINGLE, "field", "valid", "positions_m", "pitch_m", "polarity")
_VECTORS = ("time_s", "press", "pitch_m", "mark.frame", "mark.label")
_IDENTIFIER = re.compile(r"[A-Za-z]\w*", re.ASCII)
# Longest name that MATLAB keeps.
_LONGEST = 63


class Variable(Protocol):
    """A variable, or a field of a struct, in MATLAB's own order of axes; it has at least two."""

    #: What `named_arrays` calls it, and how many axes it has there, where this program wrote it.
    known_as: str
    known_axes: int | None

    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    def read(self, *wanted: slice) -> NDArray[Any]:
        """Read a part, by a slice an axis."""
        ...

    def small(self) -> NDArray[Any]:
        """Read all of it: numbers, or text of one entry a row."""
        ...


def place_of(name: str, taken: set[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the variable, or struct and field, that holds an array of `named_arrays`; none is given twice.

    Examples
    --------
    >>> taken = set()
    >>> place_of("pressure.left 1", taken), place_of("press.label", taken), place_of("time_s", taken)
    (('left_1', 'pressure'), ('presses', 'label'), ('time_s',))
    """
    kind, _, rest = name.partition(".")
    struct = next((s for s, prefix in _STRUCTS.items() if name.startswith(prefix)), "")
    if struct:
        parts = [struct, name.removeprefix(_STRUCTS[struct])]
    else:
        parts = [rest, kind] if rest else [kind]
    made = [_identifier(part) for part in parts]
    at = 0 if len(made) == 2 and not struct else len(made) - 1
    plain, number = made[at], 1
    while tuple(made) in taken or (not struct and made[0] in _STRUCTS):
        number += 1
        made[at] = f"{plain[: _LONGEST - 5]}_{number}"
    taken.add(tuple(made))
    return tuple(made)


def _identifier(name: str) -> str:
    made = re.sub(r"\W", "_", name, flags=re.ASCII)[: _LONGEST - 2]
    return made if _IDENTIFIER.fullmatch(made) else f"x{made}"


def stored_variables(
    path: Path,
    variables: Mapping[tuple[str, ...], Variable],
    options: Options,
    *,
    notes: tuple[str, ...] = (),
    close: Callable[[], object] = lambda: None,
) -> Stored:
    """Return the recording that variables hold.

    Raises
    ------
    FormatError
        If they hold none.
    """
    with damage_told(str(path)):
        pads = {where[:-1] for where in variables if where[-1] == SINGLE and len(where) <= 2}
        named = {_name(where, variable, pads): variable for where, variable in variables.items()}
        times = _times_of(named)
        if not any(name.partition(".")[0] == SINGLE for name in named):
            numbers = {name: _Turned(v, times, options) for name, v in named.items() if v.dtype.kind in "biuf"}
            keys, told = guessed(path, numbers, options)
            named, notes = {key: named[name] for key, name in keys.items()}, (*notes, *told)
        arrays = _Arrays(named, times, options)
        return stored_in(arrays, path, options, notes=notes, close=close)


def _times_of(named: Mapping[str, Variable]) -> int | None:
    """Return how many times there are, by the likeliest vector that is called so."""
    vectors = {
        name.rpartition("/")[2].lower(): max(variable.shape)
        for name, variable in named.items()
        if variable.dtype.kind in "biuf"
        and len(variable.shape) == 2
        and 1 in variable.shape
        and max(variable.shape) > 1
    }
    said = named.get("time_s")
    return max(said.shape) if said is not None else next((vectors[each] for each in TIMES if each in vectors), None)


def _name(where: tuple[str, ...], variable: Variable, pads: set[tuple[str, ...]]) -> str:
    if variable.known_as:
        return variable.known_as
    if len(where) == 2 and where[0] in _STRUCTS:
        return f"{_STRUCTS[where[0]]}{where[1]}"
    if len(where) == 2 and where[:1] in pads and where[1] in _OF_PAD:
        return f"{where[1]}.{where[0]}"
    return "/".join(where)


class _Turned:
    """A variable as a column: its first axis, or where that cannot be meant its last, counts the frames."""

    def __init__(self, variable: Variable, times: int | None, options: Options) -> None:
        self._variable = variable
        shape = variable.shape
        self._last = False
        if variable.known_axes is not None:
            # A vector is a column, and one number a matrix.
            self.shape: tuple[int, ...] = shape[: variable.known_axes]
        elif len(shape) == 2 and 1 in shape:
            self._last = shape[0] == 1
            self.shape = (max(shape),)
        else:
            if len(shape) == 3 and times is not None:
                self._last = times == shape[2] != shape[0]
            elif len(shape) == 3 and options.shape is not None:
                self._last = shape[:2] == options.shape != shape[1:]
            self.shape = (shape[-1], *shape[:-1]) if self._last else shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return self._variable.dtype

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        whole = [slice(None)] * (len(self._variable.shape) - 1)
        read = self._variable.read(*whole, wanted) if self._last else self._variable.read(wanted, *whole)
        if len(self.shape) == 1:
            return read.ravel()
        return np.ascontiguousarray(np.moveaxis(read, -1, 0)) if self._last else read.reshape(-1, *self.shape[1:])


class _Arrays(NamedArrays):
    """Variables by the names of `named_arrays`."""

    def __init__(self, named: Mapping[str, Variable], times: int | None, options: Options) -> None:
        self._named, self._times, self._options = named, times, options
        self._unread = dict.fromkeys(named)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._named)

    @property
    def unread(self) -> tuple[str, ...]:
        return tuple(self._unread)

    def array(self, name: str) -> NDArray[Any]:
        self._unread.pop(name, None)
        variable = self._named[name]
        array = variable.small()
        if variable.known_axes is not None:
            return array.reshape(array.shape[: variable.known_axes])
        vector = name.partition(".")[0] in _VECTORS or name in _VECTORS or name.startswith((PRESS, "names."))
        if array.dtype.kind == "U" or vector:
            return array.ravel() if array.size > 1 or name.startswith(PRESS) else array.reshape(())
        if name.partition(".")[0] in ("field", "valid") and array.dtype == np.uint8 and array.max(initial=0) <= 1:
            return array.astype(bool)
        return array

    def column(self, name: str) -> Column:
        self._unread.pop(name, None)
        return _Turned(self._named[name], self._times, self._options)
