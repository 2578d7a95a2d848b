"""Samples out of messages: what a source of messages makes of each, and what it tells of those that are none."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from varishold._counted import counted
from varishold.errors import InputError
from varishold.files.documents import parse_json
from varishold.live.address import Address
from varishold.live.sample import UNNAMED_PAD, PadLayout, Sample
from varishold.live.steady_shapes import SteadyShapes
from varishold.recording.messages import MessagePad, MessageReading, read_message, readable_name

__all__ = ["OPTIONS", "Interpreter"]

#: Options of an address that say what messages do not.
OPTIONS = ("shape", "field", "dtype", "skip")

# So many messages may be none before the source is given up as one that nobody understands.
_PATIENCE = 5
_MOST_PADS = 1024
# Nor does a message hold more readings, or more bytes of text: a frame of 512 x 512 numbers, twice.
_MOST_TEXTS, _LONGEST_TEXT = 4096, 1 << 24
_TYPES = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")


class Interpreter:
    """Makes samples of a source's messages; one thread's only.

    A message that cannot be used is counted and passed over, unless none has been understood at all.

    Parameters
    ----------
    address : Address
        Its options `shape` and `field` go to `varishold.recording.messages.read_message`; `dtype` is the type of
        numbers that come as bare bytes, little-endian, behind `skip` others.

    Attributes
    ----------
    skip : int
        Bytes that stand before bare numbers.
    pads : mapping of str to PadLayout
        Known so far; a new mapping at each change.
    damaged : int
        How many messages could not be used.
    damage : str
        What was wrong with the newest of them.

    Raises
    ------
    InputError
        If an option cannot be.
    """

    def __init__(self, address: Address) -> None:
        self._where, self._said = address.text, frozenset(address.options)
        self._shape, self._field = address.shape(), address.options.get("field")
        self._type = address.options.get("dtype")
        if self._type is not None and self._type not in _TYPES:
            raise InputError(f"{address.text}: dtype must be one of {', '.join(_TYPES)}, got {self._type!r}")
        if "skip" in address.options and self._type is None:
            raise InputError(f"{address.text}: skip is of bare numbers: say their dtype")
        self.skip = address.whole("skip", 0, least=0, most=1 << 16)
        self.pads: Mapping[str, PadLayout] = {}
        self.damaged, self.damage = 0, ""
        self._understood = False
        self._shapes = SteadyShapes()

    def message(self, content: bytes, decode: Callable[[bytes], Any], **known: Any) -> list[Sample]:
        """Return the sample of a message that `decode` takes apart; an empty list where it cannot be used.

        `known` goes to `sample`.

        Raises
        ------
        InputError
            If nobody understands what comes.
        """
        try:
            said = read_message(decode(content), shape=self._shape, field=self._field)
        except InputError as error:
            self.tell(error)
            return []
        return self.sample(said, **known)

    def payload(self, content: bytes, **known: Any) -> list[Sample]:
        """Return the samples of JSON, or of bare numbers where their type was named; errors as in `message`.

        Several JSON texts in one message, a line each or one right after the other, are several readings.
        """
        if self._type is None and len(content) > _LONGEST_TEXT:
            self.tell(f"{len(content)} bytes of JSON are more than {_LONGEST_TEXT}")
            return []
        if self._type is None and len(texts := _texts_in(content)) > 1:
            return [sample for text in texts for sample in self.message(text, self._plain, **known)]
        return self.message(content, self._plain, **known)

    def sample(
        self,
        said: MessageReading,
        *,
        name: str | None = None,
        host_time_s: float | None = None,
        device_time_s: float | None = None,
        sequence: int | None = None,
    ) -> list[Sample]:
        """Return the sample of what was read of a message; an empty list where it lists no taxel this time.

        A pad that comes in another shape for once is damaged and left out.

        Parameters
        ----------
        said : MessageReading
        name : str, optional
            What a pad without a name is called.
        host_time_s : float, optional
            When it came. Default: now.
        device_time_s, sequence : float, int, optional
            Its time and number where the message itself has none.
        """
        self._understood = True
        if not said.pads:
            return []
        name = readable_name(name) if name else None
        pads = {
            (key.replace(UNNAMED_PAD, name) if name and _unnamed(key) else key): pad for key, pad in said.pads.items()
        }
        if len(self.pads.keys() | pads.keys()) > _MOST_PADS:
            self.tell(f"a message names pads that no other did, and more than {_MOST_PADS} are known")
            return []
        pads = {key: pad for key, pad in pads.items() if self._fits(key, pad.values.shape)}
        if not pads:
            return []
        layouts = {key: _layout_of(pad) for key, pad in pads.items()}
        if any(self.pads.get(key) != layout for key, layout in layouts.items()):
            self.pads = {**self.pads, **layouts}
        return [
            Sample(
                said.time_s if said.time_s is not None else device_time_s,
                time.time() if host_time_s is None else host_time_s,
                said.sequence if said.sequence is not None else sequence,
                {key: pad.values for key, pad in pads.items()},
            )
        ]

    def _fits(self, pad: str, shape: tuple[int, ...]) -> bool:
        """Tell whether a frame is of its pad's shape; one that is not is damage."""
        fits = self._shapes.takes(pad, shape)
        if not fits:
            self.tell(f"pad {pad} came with {_sized(shape)} values among frames of {_sized(self._shapes.of(pad))}")
        return fits

    def tell(self, error: InputError | str) -> None:
        """Count a message that cannot be used.

        Raises
        ------
        InputError
            If several came, and none that could.
        """
        self.damaged += 1
        self.damage = str(error)
        if not self._understood and self.damaged >= _PATIENCE:
            parameter = getattr(error, "parameter", None)
            remedy = ""
            if parameter in _REMEDIES:
                remedy = f"; {_SAID_ALREADY if parameter in self._said else _REMEDIES[parameter]}"
            raise InputError(f"{self._where}: {self.damage}{remedy}", parameter=parameter)

    def _plain(self, content: bytes) -> Any:
        if self._type is not None:
            dtype, content = np.dtype(self._type).newbyteorder("<"), content[self.skip :]
            if not content or len(content) % dtype.itemsize:
                raise InputError(
                    f"{counted(len(content), 'byte is', 'bytes are')} no row of {self._type}", parameter="dtype"
                )
            return {"data": np.frombuffer(content, dtype)}
        try:
            text = content.decode()
        except UnicodeDecodeError:
            raise InputError(
                f"{counted(len(content), 'byte came that is', 'bytes came that are')} no JSON", parameter="dtype"
            ) from None
        document = parse_json(text, where="a message", finite=False)
        return {"data": document} if isinstance(document, list) else document


_REMEDIES = {
    "field": "add ?field=NAME to the address",
    "shape": "add ?shape=ROWSxCOLS to the address",
    "dtype": "add ?dtype=TYPE to the address where numbers come as bare bytes",
}
_NO_SPACE = re.compile(r"\S")
# One text ends and the next begins: neither follows the other within one.
_BETWEEN = re.compile(rb"(?<=[}\]])\s*(?=[{\[])")
_SAID_ALREADY = "does the address say another than is sent, or is there more than the values?"


def _texts_in(content: bytes) -> list[bytes]:
    """Return the JSON texts of a message, which most often is one; what is left where one is broken stands last."""
    if _BETWEEN.search(content) is None:
        return [content]
    texts: list[bytes] = []
    decoder, begin = json.JSONDecoder(), 0
    try:
        whole = content.decode().strip()
        while begin < len(whole):
            if len(texts) == _MOST_TEXTS:
                return [content]
            _, end = decoder.raw_decode(whole, begin)
            texts.append(whole[begin:end].encode())
            begin = found.start() if (found := _NO_SPACE.search(whole, end)) else len(whole)
    except (ValueError, RecursionError):
        return [*texts, whole[begin:].encode()] if texts else [content]
    return texts


def _sized(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))


def _unnamed(key: str) -> bool:
    return key == UNNAMED_PAD or key.endswith(f".{UNNAMED_PAD}")


def _layout_of(pad: MessagePad) -> PadLayout:
    return PadLayout(pad.values.shape, pad.kind, unit=pad.unit, polarity=pad.polarity, names=pad.names)
