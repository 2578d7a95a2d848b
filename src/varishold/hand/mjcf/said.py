"""A hand's file as it is written: its tables, checked one by one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from varishold._counted import counted
from varishold.errors import InputError

__all__ = ["Table", "tables"]


@dataclass(frozen=True)
class Table:
    """One table of a TOML file.

    Parameters
    ----------
    where : str
        Opens every message: the file and the table.
    content : mapping
    """

    where: str
    content: Mapping[str, Any]

    def only(self, *names: str) -> None:
        """Refuse keys that nobody reads."""
        for key in self.content:
            if key not in names:
                raise InputError(f"{self.where}: unknown key {key!r}; known are {', '.join(names)}")

    def wrong(self, key: str, what: str) -> InputError:
        """Return the error that a key's value deserves."""
        return InputError(f"{self.where}: {key} {what}")

    def text(self, key: str, usual: str | None = None) -> str:
        """Return a text of something."""
        value = self.content.get(key, usual)
        if value is None:
            raise InputError(f"{self.where}: {key} is missing")
        if not isinstance(value, str) or not value.strip() or not value.isprintable() or len(value) > 200:
            raise self.wrong(key, f"must be a text of 1 to 200 printable characters, got {repr(value)[:60]}")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of texts, none twice; empty where it is not said."""
        value = self.content.get(key, [])
        good = isinstance(value, list) and all(isinstance(each, str) and each for each in value)
        if not good or len(set(value)) != len(value):
            raise self.wrong(key, f"must be a list of names, each once, got {repr(value)[:60]}")
        return tuple(value)

    def flag(self, key: str, usual: bool = False) -> bool:
        """Return true or false."""
        value = self.content.get(key, usual)
        if not isinstance(value, bool):
            raise self.wrong(key, f"must be true or false, got {repr(value)[:60]}")
        return value

    def number(self, key: str, usual: float | None, low: float, high: float) -> float:
        """Return a number of a range; what is usual where none is said must lie there, too."""
        if key not in self.content and usual is not None and not low <= usual <= high:
            by = f"would be {usual:.3g} by the torques and sizes that are said"
            raise self.wrong(key, f"{by}, and must lie in [{low:g}, {high:g}]; change these, or say it")
        value = self.content.get(key, usual)
        if value is None:
            raise InputError(f"{self.where}: {key} is missing")
        return self._number(key, value, low, high)

    def numbers(self, key: str, n: int, low: float, high: float) -> tuple[float, ...] | None:
        """Return so many numbers of a range; None where they are not said."""
        value = self.content.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != n:
            raise self.wrong(key, f"must be a list of {counted(n, 'number')}, got {repr(value)[:60]}")
        return tuple(self._number(key, each, low, high) for each in value)

    def _number(self, key: str, value: object, low: float, high: float) -> float:
        number = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
        if not (math.isfinite(number) and low <= number <= high):
            unit = "; metres" if key.endswith("_m") and abs(number) > high else ""
            raise self.wrong(key, f"must be a number in [{low:g}, {high:g}]{unit}, got {repr(value)[:60]}")
        return number


def tables(path: str, content: Mapping[str, Any], key: str) -> Sequence[Table]:
    """Return the tables of an array of tables."""
    value = content.get(key, [])
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        raise InputError(f"{path}: {key} must be tables, each begun by [[{key}]]")
    return [Table(f"{path}: [[{key}]] {k}", each) for k, each in enumerate(value, start=1)]
