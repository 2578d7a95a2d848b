"""Addresses of sources, as in ``serial:/dev/ttyACM0?preset=flexitac``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qsl

from varishold.errors import InputError

__all__ = ["Address", "parse_address", "replayed_file"]


@dataclass(frozen=True)
class Address:
    """Where a source is.

    Parameters
    ----------
    text : str
        As a person wrote it.
    kind : str
        What stands before the first colon: how it is reached.
    place : str
        What stands between that and the question mark; ``//`` before it is taken off.
    options : mapping of str to str
        What follows the question mark, as ``name=value`` with ``&`` between.
    """

    text: str
    kind: str
    place: str
    options: Mapping[str, str]

    @property
    def can_wait(self) -> bool:
        """Whether its readings come only when they are asked for, as fast as they are."""
        return self.kind == "stdin" or self.options.get("speed") == "0"

    def only(self, *known: str) -> None:
        """Raise InputError where an option is not one of these."""
        for name in self.options:
            if name not in known:
                allowed = f"known are {', '.join(known)}" if known else "it has none"
                raise InputError(f"{self.text}: {self.kind} has no option {name!r}; {allowed}")

    def number(self, name: str, default: float, *, least: float, most: float) -> float:
        """Return an option that is a number.

        Raises
        ------
        InputError
            If it is none, or out of bounds.
        """
        text = self.options.get(name)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise InputError(f"{self.text}: {name} must be a number from {least:g} to {most:g}, got {text!r}")
        return value

    def whole(self, name: str, default: int, *, least: int, most: int) -> int:
        """Return an option that is a whole number; errors as in `number`."""
        value = self.number(name, default, least=least, most=most)
        if value != int(value):
            raise InputError(f"{self.text}: {name} must be a whole number, got {self.options[name]!r}")
        return int(value)

    def shape(self, name: str = "shape") -> tuple[int, int] | None:
        """Return an option that is rows x columns; None where it is not given.

        Raises
        ------
        InputError
            If it is not two whole numbers from 1 to 4096.
        """
        text = self.options.get(name)
        if text is None:
            return None
        parts = text.lower().split("x")
        if len(parts) == 2 and all(part.isascii() and part.isdigit() and len(part) < 5 for part in parts):
            rows, cols = int(parts[0]), int(parts[1])
            if 1 <= rows <= 4096 and 1 <= cols <= 4096:
                return rows, cols
        raise InputError(f"{self.text}: {name} must be rows x columns, as in 16x16, got {text!r}")


def replayed_file(text: str) -> list[str]:
    """Return the file that an address replays; none where it replays none."""
    try:
        address = parse_address(text)
    except InputError:
        return []
    return [address.place] if address.kind == "replay" else []


def parse_address(text: str) -> Address:
    """Return the parts of an address.

    Raises
    ------
    InputError
        If there is no kind before a colon, or an option is given twice or without a value.

    Examples
    --------
    >>> parse_address("serial:/dev/ttyACM0?preset=flexitac").options
    {'preset': 'flexitac'}
    """
    kind, colon, rest = text.partition(":")
    if not colon or not kind:
        meant = f"replay:{text}" if Path(text).is_file() else f"serial:{text or 'PORT'}"
        raise InputError(f"{text!r} is no address of a source; write what it is first, as in {meant}")
    place, _, query = rest.partition("?")
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=True) if query else []
    except ValueError:
        raise InputError(f"{text}: what follows ? must be name=value, with & between; got {query!r}") from None
    options = dict(pairs)
    if len(options) < len(pairs):
        raise InputError(f"{text}: an option is given twice")
    return Address(text, kind.lower(), place.removeprefix("//"), options)
