"""Samples out of a pipe: lines of JSON, or bare numbers one frame after the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from varishold.errors import InputError
from varishold.files.opening import PlainText
from varishold.live.address import Address
from varishold.live.framed import FRAMING_OPTIONS, FramedBytes, framing_at
from varishold.live.framing.text import numbers_of, shown_line, unlike_words
from varishold.live.interpreter import OPTIONS, Interpreter
from varishold.live.sample import PadLayout, Sample

__all__ = ["PIPE_OPTIONS", "Unpacking", "unpacking_at"]

#: Options of an address that say what comes through a pipe.
PIPE_OPTIONS = tuple(dict.fromkeys((*FRAMING_OPTIONS, *OPTIONS)))

# The longest line of JSON, bytes: a frame of 512 x 512 numbers.
_LONGEST = 1 << 23


class Unpacking(Protocol):
    """Turns what comes through a pipe into samples."""

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        ...

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        ...

    @property
    def damage(self) -> str:
        """What was wrong with the newest of it; empty where that is not known."""
        ...

    def samples(self, data: bytes) -> list[Sample]:
        """Return the samples that end in these bytes."""
        ...

    def finish(self) -> list[Sample]:
        """Return the samples that end with the pipe."""
        ...


class JsonLines:
    """One reading a line.

    Parameters
    ----------
    address : Address
    """

    def __init__(self, address: Address) -> None:
        self._interpreter = Interpreter(address)
        self._rest, self._too_long = b"", False

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._interpreter.pads

    @property
    def damaged(self) -> int:
        return self._interpreter.damaged

    @property
    def damage(self) -> str:
        return self._interpreter.damage

    def samples(self, data: bytes) -> list[Sample]:
        *lines, self._rest = (self._rest + data).split(b"\n")
        found: list[Sample] = []
        for line in lines:
            if not self._too_long and line.strip():
                try:
                    found += self._interpreter.payload(line)
                except InputError as error:
                    raise InputError(f"{error}; each line is to be one reading", parameter=error.parameter) from error
            self._too_long = False
        if len(self._rest) > _LONGEST:
            self._rest, self._too_long = b"", True
            self._interpreter.tell(f"a line is longer than {_LONGEST} bytes")
        return found

    def finish(self) -> list[Sample]:
        return self.samples(b"\n")


class BareNumbers:
    """Frames of one size without anything between them, which a pipe can carry because it loses nothing.

    Parameters
    ----------
    address : Address
        With the options `dtype` and `shape`.
    """

    def __init__(self, address: Address) -> None:
        self._interpreter = Interpreter(address)
        shape = address.shape()
        if shape is None:
            raise InputError(f"{address.text}: bare numbers need their shape, as in shape=16x16", parameter="shape")
        values = shape[0] * shape[1] * np.dtype(address.options["dtype"]).itemsize
        self._size = self._interpreter.skip + values
        self._rest = b""

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self._interpreter.pads

    @property
    def damaged(self) -> int:
        return self._interpreter.damaged

    @property
    def damage(self) -> str:
        return self._interpreter.damage

    def samples(self, data: bytes) -> list[Sample]:
        data, found = self._rest + data, []
        whole = len(data) - len(data) % self._size
        for at in range(0, whole, self._size):
            found += self._interpreter.payload(data[at : at + self._size])
        self._rest = data[whole:]
        return found

    def finish(self) -> list[Sample]:
        return []


class Guessed:
    """Lines of JSON or text, as the first line that is one tells; text with a whole frame in it is a line a frame.

    What stands before, as a controller says where it starts, is passed over and counted.

    Parameters
    ----------
    address : Address
        Its `shape`, where it is given, tells rows of text from whole frames.
    """

    def __init__(self, address: Address) -> None:
        # What cannot be is refused before anything comes.
        self._shape = address.shape()
        self._address = address
        self._by: Unpacking | None = None
        self._plain = PlainText()
        self._first = b""
        self._passed, self._why = 0, ""

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return {} if self._by is None else self._by.pads

    @property
    def damaged(self) -> int:
        return self._passed + (0 if self._by is None else self._by.damaged)

    @property
    def damage(self) -> str:
        return self._why if self._by is None else self._by.damage or self._why

    def samples(self, data: bytes) -> list[Sample]:
        return self._samples(self._plain.feed(data))

    def _samples(self, data: bytes) -> list[Sample]:
        if self._by is None:
            self._first += data
            self._by = self._told()
            if self._by is None:
                return []
            data, self._first = self._first, b""
        return self._by.samples(data)

    def finish(self) -> list[Sample]:
        # A line of text that nothing ended is whole now.
        found = self._samples(b"\n") if self._first else []
        return found if self._by is None else [*found, *self._by.finish()]

    def _told(self) -> Unpacking | None:
        """Return what reads the first line that holds something, with which what is left begins; None before it."""
        lines = self._first.split(b"\n")
        for behind, line in enumerate(lines, 1):
            line = line.lstrip()
            by = self._read_by(line, ended=behind < len(lines)) if line else None
            if by is not None:
                self._first = b"\n".join([line, *lines[behind:]])
                return by
        self._first = lines[-1].lstrip()
        return None

    def _read_by(self, line: bytes, *, ended: bool) -> Unpacking | None:
        """Return what reads a line and those behind it; None where it holds nothing, or is not told before its end."""
        if line[:1] in (b"{", b"["):
            return JsonLines(self._address)
        if not ended:
            return _framed(self._address, "arduino-rows") if len(line) > _LONGEST else None
        numbers, shape = numbers_of(line), self._shape
        if numbers and shape is not None and len(numbers) >= shape[0] * shape[1]:
            return _framed(self._address, "arduino-line")
        if numbers and (shape is None or len(numbers) == shape[1]):
            return _framed(self._address, "arduino-rows")
        self._passed += 1
        if numbers and shape is not None:
            self._why = unlike_words((len(numbers),), shape)
        else:
            self._why = f"{shown_line(line)} is neither JSON nor a line of numbers"
        return None


def unpacking_at(address: Address) -> Unpacking:
    """Return what unpacks a pipe, as the address says.

    Raises
    ------
    InputError
        If it says what cannot be.
    """
    if "preset" in address.options or "framing" in address.options:
        return _framed(address, "arduino-rows")
    if "dtype" in address.options:
        return BareNumbers(address)
    return Guessed(address)


def _framed(address: Address, default: str) -> FramedBytes:
    return FramedBytes(address.text, framing_at(address, default))
