"""Frames out of numbers that are sent as text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.live.framing.counting import Counting
from varishold.live.framing.model import Framing, PadValues
from varishold.live.framing.reading import Reading
from varishold.live.sample import PadLayout

__all__ = ["TextDecoder", "numbers_of"]

# Characters of a number and what stands between two, at most; and of a line whose numbers are not counted yet.
_WIDEST, _LONGEST = 32, 1 << 18
# Rows of a frame, at most, where they are not counted yet.
_MOST_ROWS = 1024
_SEPARATORS = bytes.maketrans(b",;\t", b"   ")

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
        self.damaged = 0
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
            reading = self._row(numbers) if self._by_rows else self._line(numbers)
            if reading is not None:
                found.append(reading)
        if len(self._rest) > longest:
            self._rest, self._too_long = b"", True
        return found

    def _line(self, numbers: list[float] | None) -> Reading | None:
        if numbers is not None and not numbers:
            return None
        skip = self._framing.skip
        if numbers is None or len(numbers) <= skip:
            self.damaged += 1
            return None
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
        if len(rows) > self._most_rows or len({len(row) for row in rows}) > 1 or len(rows[0]) <= skip:
            self.damaged += 1
            return None
        return self._frame(np.array([row[skip:] for row in rows]), rows[0])

    def _frame(self, values: Frame, columns: list[float]) -> Reading | None:
        pad = self._known(values)
        if pad is None:
            return None
        if values.size != pad.count or (self._by_rows and values.shape != pad.layout.shape):
            self.damaged += 1
            return None
        fitted = _fitted(values, pad.dtype)
        if fitted is None:
            self.damaged += 1
            return None
        return Reading(
            {pad.name: pad.shaped(fitted)}, self._time.of_column(columns), self._sequence.whole_of_column(columns)
        )

    def _known(self, values: Frame) -> PadValues | None:
        """Return the pad; None as long as two frames have not told its shape."""
        if not self._pad.is_known:
            if values.shape == self._seen:
                self._pad = replace(self._pad, layout=replace(self._pad.layout, shape=values.shape))
            self._seen = values.shape
        return self._pad if self._pad.is_known else None


def numbers_of(line: bytes) -> list[float] | None:
    """Return the numbers of a line, none of a blank one; None where something in it is no number."""
    if b"_" in line:
        return None
    try:
        return [float(word) for word in line.translate(_SEPARATORS).strip(b" \r[]{}").split()]
    except ValueError:
        return None


def _fitted(values: Frame, dtype: np.dtype[Any]) -> NDArray[Any] | None:
    """Return values in their type; None where they do not fit in."""
    if dtype.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(dtype)
    bounds = np.iinfo(dtype)
    if not np.all((values >= bounds.min) & (values <= bounds.max) & (values == np.floor(values))):
        return None
    return values.astype(dtype)
