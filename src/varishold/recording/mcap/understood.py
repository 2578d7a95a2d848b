"""Messages of other programs, understood by their shape."""

from __future__ import annotations

import math

import numpy as np

from varishold.errors import InputError
from varishold.recording.mcap.clock import nanoseconds
from varishold.recording.mcap.container import Channel
from varishold.recording.mcap.parts import MessageError, Part
from varishold.recording.mcap.topics import PadFacts
from varishold.recording.messages import MessagePad, message_decoder, read_message
from varishold.recording.pad import UNNAMED_PAD

__all__ = ["Understood"]


class Understood:
    """Takes messages apart by the text of their type, one by one, and their pads by their shape.

    Parameters
    ----------
    channel : Channel

    Raises
    ------
    InputError
        If messages of its type or in its coding cannot be taken apart.
    """

    def __init__(self, channel: Channel) -> None:
        self._decode = message_decoder(channel.encoding, channel.type, channel.schema, channel.schema_encoding)
        self._shapes: dict[str, tuple[int, ...]] = {}

    def read(self, messages: list[bytes]) -> list[Part]:
        """Return what messages say of each pad.

        Raises
        ------
        MessageError
            If one cannot be taken apart, is not understood, or has a pad of another shape than before.
        """
        found: dict[str, list[tuple[int, MessagePad]]] = {}
        times: list[float | None] = []
        numbers: list[int | None] = []
        for k, message in enumerate(messages):
            try:
                said = read_message(self._decode(message))
            except InputError as error:
                raise MessageError(k, str(error)) from None
            times.append(said.time_s if said.time_s is not None and math.isfinite(said.time_s) else None)
            numbers.append(said.sequence)
            for name, pad in said.pads.items():
                known = self._shapes.setdefault(name, pad.values.shape)
                if known != pad.values.shape:
                    raise MessageError(k, f"pad {name} has shape {pad.values.shape}, before it had {known}")
                found.setdefault(name, []).append((k, pad))
        return [_part(name, pads, times, numbers) for name, pads in found.items()]


def _part(name: str, pads: list[tuple[int, MessagePad]], times: list[float | None], numbers: list[int | None]) -> Part:
    at = [k for k, _ in pads]
    stamps = [time_s for k in at if (time_s := times[k]) is not None]
    sequence = [number for k in at if (number := numbers[k]) is not None and -(2**63) <= number < 2**63]
    pad = pads[0][1]
    return Part(
        "" if name == UNNAMED_PAD else name,
        np.array(at),
        np.array([nanoseconds(time_s) for time_s in stamps]) if len(stamps) == len(at) else None,
        np.array(sequence) if len(sequence) == len(at) else None,
        np.stack([each.values for _, each in pads]),
        PadFacts(
            name,
            kind=pad.kind,
            unit=pad.unit,
            sensor=pad.sensor,
            polarity=pad.polarity,
            positions_m=pad.positions_m,
            names=pad.names,
        ),
    )
