"""Samples out of a stream of bytes: what a source that is a cable or a pipe makes of what comes."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace

from varishold._counted import counted
from varishold.errors import InputError, LostSourceError
from varishold.live.address import Address
from varishold.live.framing import Framing, decoder_of, framing_of
from varishold.live.sample import PadLayout, Sample

__all__ = ["FRAMING_OPTIONS", "FramedBytes", "framing_at"]

#: Options of an address that say how its bytes are frames.
FRAMING_OPTIONS = ("preset", "framing", "shape", "pitch_m")

# Bytes may come for so long without a frame in them, and so many, before that is told. Seconds, bytes.
_PATIENCE_S, _PATIENCE = 4.0, 256


class FramedBytes:
    """Turns bytes into samples by a framing, and tells when that is plainly the wrong one.

    Parameters
    ----------
    address : str
        Of the source, for messages.
    framing : Framing
    confirm : bool
        Whether a frame is first believed when another follows it, where nothing else proves it.
    """

    def __init__(self, address: str, framing: Framing, *, confirm: bool = True) -> None:
        self._address = address
        self._decoder = decoder_of(framing, confirm=confirm)
        checked = any(packet.checksum is not None for packet in framing.packets)
        self._remedy = f"is it another preset, shape{', checksum' * checked} or baud?"
        self._patience = max(_PATIENCE, 3 * sum(packet.size for packet in framing.packets))
        self._any = False
        self.restart()

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        return self._decoder.pads

    @property
    def damaged(self) -> int:
        """How often something was not as it should be."""
        return self._decoder.damaged

    @property
    def damage(self) -> str:
        """What was wrong with the newest of it; empty where that is not known."""
        return self._decoder.damage

    @property
    def unframed(self) -> str:
        """That bytes came and never a whole frame, in words; empty where one did, or nothing."""
        return "" if self._any or not self._bytes else f"{counted(self._bytes, 'byte')} came and no whole frame in them"

    def restart(self) -> None:
        """Begin anew: what comes next has nothing to do with what came."""
        self._decoder.restart()
        # How many bytes have come without a frame, and since when.
        self._bytes = 0
        self._since_s: float

    def expect(self) -> None:
        """Forget a frame that has begun: what comes next is the answer to a request."""
        self._decoder.restart()

    def samples(self, data: bytes) -> list[Sample]:
        """Return the samples that end in these bytes.

        Raises
        ------
        LostSourceError
            If bytes come and come, and no frame is in them.
        """
        host_time_s = time.time()
        readings = self._decoder.feed(data)
        if readings:
            self._bytes, self._any = 0, True
        elif data:
            if self._bytes == 0:
                self._since_s = time.monotonic()
            self._bytes += len(data)
            waited_s = time.monotonic() - self._since_s
            if self._bytes > self._patience and waited_s > _PATIENCE_S:
                why = f": {self.damage}" if self.damage else ""
                raise LostSourceError(
                    f"{self._address}: {counted(self._bytes, 'byte')} came in {waited_s:.0f} s, and no frame in them"
                    f"{why}; {self._remedy}"
                )
        return [Sample(reading.device_time_s, host_time_s, reading.sequence, reading.pads) for reading in readings]

    def finish(self) -> list[Sample]:
        """Return the samples that end with the stream: a text's last frame, without a blank line behind it."""
        return self.samples(b"\n\n")


def framing_at(address: Address, default: str | None = None) -> Framing:
    """Return the framing that an address names, with its other options.

    Parameters
    ----------
    address : Address
    default : str, optional
        The preset where it names none.

    Raises
    ------
    InputError
        If it names none or two, or one that cannot be.
    """
    preset, file = address.options.get("preset"), address.options.get("framing")
    if preset is not None and file is not None:
        raise InputError(f"{address.text}: give preset or framing, not both")
    named = preset or file or default
    if named is None:
        from varishold.live.framing import FRAMINGS

        raise InputError(
            f"{address.text}: say what it sends: ?preset= with one of {', '.join(FRAMINGS)}, or ?framing=FILE.toml"
        )
    framing = framing_of(named)
    shape = address.shape()
    try:
        framing = framing if shape is None else framing.with_shape(shape)
    except InputError as error:
        raise InputError(f"{address.text}: {error}") from None
    if "pitch_m" in address.options:
        pitch_m = address.number("pitch_m", 0.0, least=1e-9, most=1e3)
        framing = replace(
            framing,
            pads=tuple(
                replace(pad, layout=replace(pad.layout, pitch_m=(pitch_m, pitch_m)))
                if pad.layout.kind == "pressure"
                else pad
                for pad in framing.pads
            ),
        )
    return framing
