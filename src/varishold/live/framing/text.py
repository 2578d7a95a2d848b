"""Frames out of numbers that are sent as text."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.live.framing.counting import Counting
from varishold.live.framing.model import Framing, PadValues
from varishold.live.framing.reading import Reading
from varishold.live.sample import PadLayout

__all__ = ["TextDecoder", "numbers_of", "shown_line", "unlike_words"]

# Characters of a number and what stands between two, at most; and of a line whose numbers are not counted yet.
_WIDEST, _LONGEST = 32, 1 << 18
# Rows of a frame, at most, where they are not counted yet.
_MOST_ROWS = 1024
# So many numbers may stand before the values of a line, as a time and a frame's number do.
_MOST_BEFORE = 4
# So many characters of a line are shown where it is told what was wrong with it.
_SHOWN = 40
_SEPARATORS = bytes.maketrans(b",;\t", b"   ")
# Numbers with decimal commas, which semicolons or tabs separate.
_COMMA_NUMBER = rb" *[-+]?\d+(?:,\d+)? *"
_DECIMAL_COMMAS = re.compile(rb"%b(?:[;\t]%b)+[;\t]?\s*" % (_COMMA_NUMBER, _COMMA_NUMBER))

Frame = NDArray[np.float64]


class TextDecoder:
    """Turns lines of numbers into readings; lines of something else are passed over.

    Where rows and columns are not given, the first two frames that agree tell them.

    Parameters
    ----------
    framing : Framing
        With `text`.
    """

    def __init__(self, framing: Framing) -> None:
        self._framing = framing
        self._by_rows = framing.text == "rows"
        self._time, self._sequence = Counting(framing.time), Counting(framing.sequence)
        self.damaged, self.damage = 0, ""
        self._pad = framing.pads[0]
        self.restart()

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pad, once it is known."""
        return {self._pad.name: self._pad.layout} if self._pad.is_known else {}

    def restart(self) -> None:
        """Forget all bytes: what comes next is something new."""
        self._rest = b""
        self._too_long = False
        self._rows: list[list[float]] = []
        # Whether a blank line stood before the rows.
        self._whole = False
        self._seen: tuple[int, ...] | None = None

    def feed(self, data: bytes) -> list[Reading]:
        """Return the readings that end in these bytes."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        found: list[Reading] = []
        longest = _WIDEST * (self._pad.count + self._framing.skip + 2) if self._pad.is_known else _LONGEST
        for line in lines:
            numbers = None if self._too_long or len(line) > longest else numbers_of(line)
            self._too_long = False
            reading = self._row(numbers) if self._by_rows else self._line(numbers, line)
            if reading is not None:
                found.append(reading)
        if len(self._rest) > longest:
            self._rest, self._too_long = b"", True
        return found

    def _line(self, numbers: list[float] | None, line: bytes) -> Reading | None:
        if numbers is None:
            return self._spoilt(f"{shown_line(line)} is no line of numbers")
        if not numbers:
            return None
        skip = self._framing.skip
        if len(numbers) <= skip:
            return self._spoilt(f"a line holds {counted(len(numbers), 'number')}, and {skip} are to be passed over")
        return self._frame(np.array(numbers[skip:]), numbers)

    def _row(self, numbers: list[float] | None) -> Reading | None:
        if numbers is None:
            # A title, or a damaged row: the frame is then too short.
            return None
        if not numbers:
            reading = self._block() if self._rows else None
            self._whole = True
            return reading
        # One more than there may be tells that there are too many.
        if len(self._rows) <= self._most_rows:
            self._rows.append(numbers)
        # The blank line may come with the next frame only.
        is_last = self._whole and self._pad.is_known and len(self._rows) == self._most_rows
        return self._block() if is_last else None

    @property
    def _most_rows(self) -> int:
        return self._pad.layout.shape[0] if self._pad.is_known else _MOST_ROWS

    def _block(self) -> Reading | None:
        """Return the frame of the rows that came, and begin a new one."""
        rows, self._rows, self._whole = self._rows, [], False
        skip = self._framing.skip
        if len(rows) > self._most_rows:
            return self._spoilt(f"more than {counted(self._most_rows, 'row')} came without a blank line")
        if len(lengths := {len(row) for row in rows}) > 1 or len(rows[0]) <= skip:
            return self._spoilt(f"rows of {' and '.join(map(str, sorted(lengths)))} numbers came, which are no frame")
        return self._frame(np.array([row[skip:] for row in rows]), rows[0])

    def _frame(self, values: Frame, columns: list[float]) -> Reading | None:
        pad = self._known(values)
        if pad is None:
            return None
        if values.size != pad.count or (self._by_rows and values.shape != pad.layout.shape):
            return self._spoilt(unlike_words(values.shape, pad.layout.shape, self._framing.skip))
        fitted = _fitted(values, pad.dtype)
        if fitted is None:
            return self._spoilt(f"a number is none of type {pad.dtype.name}")
        return Reading(
            {pad.name: pad.shaped(fitted)}, self._time.of_column(columns), self._sequence.whole_of_column(columns)
        )

    def _spoilt(self, why: str) -> Reading | None:
        """Count what holds no frame; return none."""
        self.damaged += 1
        self.damage = why
        return None

    def _known(self, values: Frame) -> PadValues | None:
        """Return the pad; None as long as two frames have not told its shape."""
        if not self._pad.is_known:
            if values.shape == self._seen:
                self._pad = replace(self._pad, layout=replace(self._pad.layout, shape=values.shape))
            self._seen = values.shape
        return self._pad if self._pad.is_known else None


def numbers_of(line: bytes) -> list[float] | None:
    """Return the numbers of a line, none of a blank one; None where something in it is no number.

    Examples
    --------
    >>> numbers_of(b"1,5;2;-0,25"), numbers_of(b"1,2,3;4,5,6"), numbers_of(b"1,\\t2"), numbers_of(b"F: 1")
    ([1.5, 2.0, -0.25], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [1.0, 2.0], None)
    """
    if b"_" in line:
        return None
    if b"," in line and (b";" in line or b"\t" in line) and _DECIMAL_COMMAS.fullmatch(line):
        line = line.replace(b",", b".")
    try:
        return [float(word) for word in line.translate(_SEPARATORS).strip(b" \r[]{}").split()]
    except ValueError:
        return None


def shown_line(line: bytes) -> str:
    """Return the begin of a line, in quotes.

    Examples
    --------
    >>> shown_line(b"L:" + 50 * b"1,")
    "'L:1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1, ...'"
    """
    text = line.strip()[: 4 * _SHOWN + 4].decode("utf-8", "replace")
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]} ...")


def unlike_words(came: tuple[int, ...], shape: tuple[int, ...], skip: int = 0) -> str:
    """Say that the numbers of a line, or of some rows, are not those of a frame, and what may stand before them.

    Examples
    --------
    >>> unlike_words((65,), (8, 8))
    'a line holds 65 numbers, and a frame 8 x 8; a framing file with skip = 1 passes over the first'
    """
    said = " x ".join(map(str, shape))
    if len(came) > 1:
        return f"{' x '.join(map(str, came))} numbers came, and a frame has {said}"
    more = came[0] - math.prod(shape)
    first = "the first" if more == 1 else f"the first {more}"
    hint = f"; a framing file with skip = {skip + more} passes over {first}" if 0 < more <= _MOST_BEFORE else ""
    return f"a line holds {counted(came[0] + skip, 'number')}, and a frame {said}{hint}"


def _fitted(values: Frame, dtype: np.dtype[Any]) -> NDArray[Any] | None:
    """Return values in their type; None where they do not fit in."""
    if dtype.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(dtype)
    bounds = np.iinfo(dtype)
    if not np.all((values >= bounds.min) & (values <= bounds.max) & (values == np.floor(values))):
        return None
    return values.astype(dtype)
