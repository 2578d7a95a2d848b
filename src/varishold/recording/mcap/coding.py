"""Readings of a pad as the messages that viewers and robots know."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from varishold.recording.mcap.clock import STAMPS_NS
from varishold.recording.mcap.image_message import image_head, image_message, image_pixels
from varishold.recording.mcap.numbers_message import numbers_head, numbers_message
from varishold.recording.mcap.topics import IMAGE, NUMBERS, PadFacts

__all__ = ["MessageCoder"]


class MessageCoder:
    """Makes messages of readings: images of pressure, arrays of signals. What stands before the numbers is kept."""

    def __init__(self) -> None:
        self._heads: dict[tuple[Any, ...], bytes] = {}

    def coded(self, facts: PadFacts, values: NDArray[Any], stamp_ns: int) -> tuple[str, bytes]:
        """Return the type of the message that holds some values, and its bytes.

        Parameters
        ----------
        facts : PadFacts
            Of the pad.
        values : ndarray
            (rows, cols), or (n,) of taxels on no grid; of signals one to three axes.
        stamp_ns : int
            Its time, nanoseconds.
        """
        if facts.kind == "signals":
            kind, dtype = NUMBERS[values.dtype.str[1:]]
            head = self._head(values.shape, lambda: numbers_head(values.shape))
            return kind, numbers_message(head, values.astype(dtype, copy=False))
        encoding, pixels = image_pixels(values)
        rows, cols = values.shape if values.ndim == 2 else (1, values.size)
        head = self._head((facts.name, rows, cols, encoding), lambda: image_head(rows, cols, encoding, facts.name))
        within = min(max(stamp_ns, STAMPS_NS.start), STAMPS_NS.stop - 1)
        return IMAGE, image_message(within, head, pixels)

    def _head(self, key: tuple[Any, ...], make: Callable[[], bytes]) -> bytes:
        head = self._heads.get(key)
        if head is None:
            head = self._heads[key] = make()
        return head
