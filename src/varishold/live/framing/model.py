"""A framing: what each byte of a serial skin's frames is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.live.framing.checksums import Checksum
from varishold.live.sample import UNNAMED_PAD, PadLayout

__all__ = ["Escape", "Framing", "Number", "Packet", "PadValues", "Pattern", "Whose"]

#: Bytes that stand fixed; None is a byte that may be anything.
Pattern = tuple[int | None, ...]

# The largest packet, bytes: a frame of 512 x 512 float32.
_LARGEST = 1 << 20


@dataclass(frozen=True)
class Packet:
    """The bytes of one packet, in their order: head, skip, values, extra, checksum, tail.

    Parameters
    ----------
    head, tail : tuple of (int or None)
        Fixed bytes; None is a byte that may be anything.
    skip, extra : int
        Bytes before and after the values that are none.
    values : int
        Bytes of values.
    checksum : Checksum, optional
    """

    values: int
    head: Pattern = ()
    tail: Pattern = ()
    skip: int = 0
    extra: int = 0
    checksum: Checksum | None = None

    @property
    def start(self) -> int:
        """Where the values start."""
        return len(self.head) + self.skip

    @property
    def body(self) -> int:
        """How many bytes stand between head and tail."""
        return self.skip + self.values + self.extra + (0 if self.checksum is None else self.checksum.size)

    @property
    def size(self) -> int:
        """How many bytes the packet has."""
        return len(self.head) + self.body + len(self.tail)

    def is_sound(self, packet: bytes) -> bool:
        """Tell whether a packet's checksum is right, or it has none."""
        if self.checksum is None:
            return True
        at = len(self.head) + self.body - self.checksum.size
        return packet[at : at + self.checksum.size] == self.checksum.of(packet[:at])


@dataclass(frozen=True)
class PadValues:
    """The values of one pad, in the order in which they come.

    Parameters
    ----------
    dtype : numpy.dtype
        With its byte order.
    layout : PadLayout
        Its shape is () where a text's first frames tell it.
    name : str
    columns_first : bool
        Whether a column's values follow each other, not a row's.
    column_names : tuple of str
        Of signals, what those of each row are called.
    """

    dtype: np.dtype[Any]
    layout: PadLayout
    name: str = UNNAMED_PAD
    columns_first: bool = False
    column_names: tuple[str, ...] = ()

    @property
    def is_known(self) -> bool:
        """Whether its shape is known."""
        return self.layout.shape != ()

    @property
    def count(self) -> int:
        """How many values a frame has."""
        return math.prod(self.layout.shape) if self.is_known else 0

    def with_shape(self, shape: tuple[int, int]) -> PadValues:
        """Return this pad with other rows and columns; signals stand in one row, each column's name with its row's."""
        if self.layout.kind == "pressure":
            return replace(self, layout=replace(self.layout, shape=shape))
        rows, cols = shape
        names = self.column_names
        if len(names) == cols and rows > 1:
            names = tuple(f"{name}{row}" for row in range(rows) for name in names)
        names = names if len(names) == rows * cols else ()
        return replace(self, layout=replace(self.layout, shape=(rows * cols,), names=names))

    def shaped(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return a frame's values in the shape of the pad."""
        return np.ascontiguousarray(values.reshape(self.layout.shape, order="F" if self.columns_first else "C"))


@dataclass(frozen=True)
class Number:
    """A number that comes with a frame: the device's time, or the frame's own number.

    Parameters
    ----------
    at : int
        Its first byte in the frame's first packet; in text, its column.
    dtype : numpy.dtype
    unit_s : float
        What 1 means, seconds.
    """

    at: int
    dtype: np.dtype[Any]
    unit_s: float = 1.0


@dataclass(frozen=True)
class Escape:
    """Bytes that are sent as two, so that head and tail stand nowhere else.

    Parameters
    ----------
    mark : int
        The first of the two.
    meant : mapping of int to int
        What each second one means.
    head, tail : int or None
        The byte that begins a frame, and the one that ends it.
    """

    mark: int
    meant: Mapping[int, int]
    head: int | None
    tail: int | None


@dataclass(frozen=True)
class Whose:
    """A byte that tells which of several sensors on one cable a packet is from.

    Parameters
    ----------
    at : int
        Where it stands in each packet.
    names : mapping of int to str
        What each sensor is called.
    """

    at: int
    names: Mapping[int, str]


@dataclass(frozen=True)
class Framing:
    """How a serial skin's bytes are frames.

    Parameters
    ----------
    pads : tuple of PadValues
        In the order in which their values come.
    packets : tuple of Packet
        Those that make up one frame, in their order; one where `escape` is given, none where `text` is.
    escape : Escape, optional
    text : {"rows", "line"}, optional
        A frame is rows of numbers and a blank line, or one line.
    skip : int
        Of a text, the columns that stand before the values.
    time, sequence : Number, optional
    whose : Whose, optional
    baud : int
        Bits per second.
    start : bytes
        What is sent once the port is open.
    request : bytes
        What is sent for every frame; empty where the skin sends by itself.
    name, notes : str
    third_party : bool
        Whether it was read from somebody else's driver, not from the vendor's own words.

    Raises
    ------
    InputError
        If it cannot be told where a frame begins, or the packets do not hold the pads' values.
    """

    pads: tuple[PadValues, ...]
    packets: tuple[Packet, ...] = ()
    escape: Escape | None = None
    text: Literal["rows", "line"] | None = None
    skip: int = 0
    time: Number | None = None
    sequence: Number | None = None
    whose: Whose | None = None
    baud: int = 115200
    start: bytes = b""
    request: bytes = b""
    name: str = ""
    notes: str = ""
    third_party: bool = False
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if len({pad.name for pad in self.pads}) < len(self.pads):
            raise InputError("two pads have the same name")
        if self.text is None:
            self._check_packets()
            self._check_places()

    def _check_packets(self) -> None:
        held = sum(packet.values for packet in self.packets)
        wanted = sum(pad.count * pad.dtype.itemsize for pad in self.pads)
        if held != wanted:
            raise InputError(f"the pads have {wanted} bytes of values, the packets hold {held}")
        for packet in self.packets:
            if self.escape is None and not any(byte is not None for byte in packet.head + packet.tail):
                raise InputError("a packet needs a head or a tail: nothing else tells where it begins")
            if packet.size > _LARGEST:
                raise InputError(f"a packet has {packet.size} bytes, more than {_LARGEST}")
        for number, one in enumerate(self.packets):
            for other in self.packets[:number]:
                if not any(None not in pair and pair[0] != pair[1] for pair in zip(one.head, other.head, strict=False)):
                    raise InputError("the heads of two packets do not tell them apart")

    def _check_places(self) -> None:
        for what, number in (("time", self.time), ("sequence", self.sequence)):
            if number is not None and number.at + number.dtype.itemsize > self.packets[0].size:
                raise InputError(
                    f"{what} stands beyond the first packet, which has {counted(self.packets[0].size, 'byte')}"
                )
        if self.whose is not None and self.whose.at >= min(packet.size for packet in self.packets):
            raise InputError(f"whose stands at byte {self.whose.at}, beyond a packet's end")

    def with_shape(self, shape: tuple[int, int]) -> Framing:
        """Return this framing for a skin of other rows and columns.

        Raises
        ------
        InputError
            If it has several pads, or several packets that hold another number of values.
        """
        if len(self.pads) != 1:
            raise InputError(f"shape cannot be given: this framing has the pads {', '.join(p.name for p in self.pads)}")
        pad = self.pads[0]
        changed = pad.with_shape(shape)
        packets = self.packets
        if len(packets) == 1:
            packets = (replace(packets[0], values=changed.count * changed.dtype.itemsize),)
        return replace(self, pads=(changed,), packets=packets)
