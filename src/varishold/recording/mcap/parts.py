"""What messages say of pads, whoever takes them apart."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.recording.mcap.topics import PadFacts

__all__ = ["Decoder", "MessageError", "Part", "joined"]


class Part(NamedTuple):
    """What some messages say of a pad.

    Parameters
    ----------
    pad : str
        Its name within the message; empty where the message is one pad.
    at : ndarray of shape (n,), int64
        Which of the messages tell of it.
    stamps_ns : ndarray of shape (n,), int64, or None
        Their own times, nanoseconds; None where not all have one.
    sequence : ndarray of shape (n,), int64, or None
        Their own numbers; None where not all have one.
    values : ndarray of shape (n, ...)
    facts : PadFacts or None
        What the messages say of the pad; None where that stands elsewhere.
    """

    pad: str
    at: NDArray[np.int64]
    stamps_ns: NDArray[np.int64] | None
    sequence: NDArray[np.int64] | None
    values: NDArray[Any]
    facts: PadFacts | None


class MessageError(ValueError):
    """A message that is not what its type says, or not as those before it.

    Parameters
    ----------
    at : int
        Which of the messages.
    reason : str
    """

    def __init__(self, at: int, reason: str) -> None:
        super().__init__(reason)
        self.at = at


class Decoder(Protocol):
    """Takes values out of the messages of a channel."""

    def read(self, messages: list[bytes]) -> list[Part]:
        """Return what messages say of each pad; raises MessageError."""
        ...


def joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Return arrays as one; what is of one type stays so, the order of its bytes included."""
    types = {part.dtype for part in parts}
    return parts[0] if len(parts) == 1 else np.concatenate(parts, dtype=types.pop() if len(types) == 1 else None)
