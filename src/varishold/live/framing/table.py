"""Entries of a framing file's tables: each of its kind, or one line that says what would be right."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from varishold.errors import FormatError
from varishold.live.framing.model import Pattern

__all__ = ["DTYPES", "Entries"]

#: Types of values, by their names in a framing file.
DTYPES = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")
_MOST = 1 << 20


class Entries:
    """One table of a framing file.

    Parameters
    ----------
    path : str
        The file, and where in it the table stands, as messages name it.
    table : mapping
    known : sequence of str
        What may stand in it.

    Raises
    ------
    FormatError
        If something else stands in it.
    """

    def __init__(self, path: str, table: Any, known: Sequence[str]) -> None:
        self.path = path
        if not isinstance(table, Mapping):
            raise FormatError(f"{path} must be a table of {', '.join(known)}, got {table!r}")
        if unknown := sorted(set(table) - set(known)):
            raise FormatError(f"{path}: unknown key {', '.join(unknown)}; known are {', '.join(known)}")
        self._table = table

    def __contains__(self, key: str) -> bool:
        return key in self._table

    def wrong(self, key: str, wanted: str) -> FormatError:
        """Return the error of an entry."""
        got = f"got {self._table[key]!r}" if key in self._table else "it is missing"
        return FormatError(f"{self.path}: {key} must be {wanted}, {got}")

    def raw(self, key: str) -> Any:
        """Return an entry as it stands; None where there is none."""
        return self._table.get(key)

    def text(self, key: str, default: str = "") -> str:
        value = self._table.get(key, default)
        if not isinstance(value, str):
            raise self.wrong(key, "a text")
        return value

    def choice(self, key: str, choices: Sequence[str], default: str | None = None) -> str:
        value = self._table.get(key, default)
        if not isinstance(value, str) or value not in choices:
            raise self.wrong(key, f"one of {', '.join(choices)}")
        return value

    def truth(self, key: str) -> bool:
        value = self._table.get(key, False)
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def whole(self, key: str, default: int | None = None, *, least: int = 0, most: int = _MOST) -> int:
        value = self._table.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise self.wrong(key, f"a whole number from {least} to {most}")
        return value

    def number(self, key: str, default: float, *, least: float, most: float) -> float:
        value = self._table.get(key, default)
        if not isinstance(value, int | float) or isinstance(value, bool) or not least <= value <= most:
            raise self.wrong(key, f"a number from {least:g} to {most:g}")
        return float(value)

    def names(self, key: str) -> tuple[str, ...]:
        value = self._table.get(key, [])
        if not isinstance(value, list) or not all(isinstance(name, str) and name.isprintable() for name in value):
            raise self.wrong(key, "a list of names")
        return tuple(value)

    def shape(self, key: str) -> tuple[int, int] | None:
        value = self._table.get(key)
        if value is None:
            return None
        sides = value if isinstance(value, list) else []
        if len(sides) != 2 or not all(type(side) is int and 1 <= side <= 4096 for side in sides):
            raise self.wrong(key, "[rows, columns], each from 1 to 4096")
        return sides[0], sides[1]

    def dtype(self, key: str, endian: str, default: str | None = None) -> np.dtype[Any]:
        name = self.choice(key, DTYPES, default)
        return np.dtype(name).newbyteorder("<" if endian == "little" else ">")

    def pattern(self, key: str) -> Pattern:
        """Return bytes such as ``"AA 55 ??"``; ``??`` is any byte."""
        value = self._table.get(key, "")
        joined = "".join(value.split()) if isinstance(value, str) else "x"
        if re.fullmatch(r"(?:[0-9A-Fa-f]{2}|\?\?){0,64}", joined) is None:
            raise self.wrong(key, 'bytes in hexadecimal, as in "AA 55", with ?? for any byte, at most 64')
        pairs = [joined[at : at + 2] for at in range(0, len(joined), 2)]
        return tuple(None if pair == "??" else int(pair, 16) for pair in pairs)

    def fixed(self, key: str) -> bytes:
        """Return bytes such as ``"AA 55"``, all of them fixed."""
        pattern = self.pattern(key)
        if None in pattern:
            raise self.wrong(key, 'bytes in hexadecimal, as in "AA 55", without ??')
        return bytes(byte for byte in pattern if byte is not None)
