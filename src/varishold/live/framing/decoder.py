"""Bytes in, readings out: no port, no clock, no thread."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.live.framing.counting import Counting
from varishold.live.framing.escaped import EscapedSplitter
from varishold.live.framing.model import Framing, PadValues
from varishold.live.framing.packets import PacketSplitter
from varishold.live.framing.reading import Reading
from varishold.live.framing.text import TextDecoder
from varishold.live.sample import UNNAMED_PAD, PadLayout

__all__ = ["Decoder", "Reading", "decoder_of"]


class Decoder(Protocol):
    """Turns a stream of bytes into readings; the same bytes give the same readings, however they are chopped."""

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        ...

    @property
    def damage(self) -> str:
        """What was wrong with the newest of it; empty where that is not known."""
        ...

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        ...

    def feed(self, data: bytes) -> list[Reading]:
        """Return the readings that end in these bytes, in their order."""
        ...

    def restart(self) -> None:
        """Forget all bytes: what comes next is something new."""
        ...


def decoder_of(framing: Framing, *, confirm: bool = True) -> Decoder:
    """Return what turns a skin's bytes into readings.

    Parameters
    ----------
    framing : Framing
    confirm : bool
        Whether a packet is first believed when another follows it, if it has no checksum and is not asked for.

    Examples
    --------
    >>> from varishold.live.framing import framing_of
    >>> decoder = decoder_of(framing_of("flexitac").with_shape((2, 2)))
    >>> [reading.pads["pad"].tolist() for reading in decoder.feed(bytes.fromhex("AA55 01020304 AA55 05060708"))]
    [[[1, 2], [3, 4]], [[5, 6], [7, 8]]]
    """
    return PacketDecoder(framing, confirm=confirm) if framing.text is None else TextDecoder(framing)


class PacketDecoder:
    """Puts packets together to frames.

    Parameters
    ----------
    framing : Framing
        Without `text`.
    confirm : bool
        As in `decoder_of`.
    """

    def __init__(self, framing: Framing, *, confirm: bool = True) -> None:
        self._framing = framing
        self._splitter: EscapedSplitter | PacketSplitter
        if framing.escape is not None:
            self._splitter = EscapedSplitter(framing.packets[0], framing.escape)
        else:
            self._splitter = PacketSplitter(framing.packets, confirm=confirm and not framing.request)
        whose = [""] if framing.whose is None else list(framing.whose.names.values())
        self._clocks = {name: (Counting(framing.time), Counting(framing.sequence)) for name in whose}
        self._apart = 0
        self._known: dict[str, PadLayout] = {}
        if framing.whose is None:
            self._known = {pad.name: pad.layout for pad in framing.pads}
        self.restart()

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far: those of several sensors when each has sent."""
        return dict(self._known)

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        return self._splitter.damaged + self._apart

    @property
    def damage(self) -> str:
        """Empty: of packets it is not known."""
        return ""

    def restart(self) -> None:
        """Forget all bytes: what comes next is something new."""
        self._splitter.restart()
        self._begun: dict[str, list[bytes]] = {}

    def feed(self, data: bytes) -> list[Reading]:
        """Return the readings that end in these bytes, in their order."""
        found: list[Reading] = []
        for kind, packet in self._splitter.feed(data):
            reading = self._join(kind, packet)
            if reading is not None:
                found.append(reading)
        return found

    def _join(self, kind: int, packet: bytes) -> Reading | None:
        """Return the frame that a packet completes; None where it completes none."""
        whose = self._framing.whose
        name = "" if whose is None else whose.names.get(packet[whose.at])
        if name is None:
            self._apart += 1
            return None
        begun = self._begun.setdefault(name, [])
        if kind != len(begun):
            self._apart += 1
            begun.clear()
            if kind != 0:
                return None
        begun.append(packet)
        if len(begun) < len(self._framing.packets):
            return None
        self._begun[name] = []
        values = b"".join(
            part[shape.start : shape.start + shape.values]
            for part, shape in zip(begun, self._framing.packets, strict=True)
        )
        time, sequence = self._clocks[name]
        return Reading(self._pads(name, values), time.of_bytes(begun[0]), sequence.whole_of_bytes(begun[0]))

    def _pads(self, whose: str, values: bytes) -> dict[str, NDArray[Any]]:
        found, at = {}, 0
        for pad in self._framing.pads:
            name = _name(whose, pad)
            flat = np.frombuffer(values, pad.dtype, pad.count, at).astype(pad.dtype.newbyteorder("="))
            at += pad.count * pad.dtype.itemsize
            found[name] = pad.shaped(flat)
            self._known.setdefault(name, pad.layout)
        return found


def _name(whose: str, pad: PadValues) -> str:
    if not whose:
        return pad.name
    return whose if pad.name == UNNAMED_PAD else f"{whose}.{pad.name}"
