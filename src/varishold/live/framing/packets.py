"""Packets of fixed sizes out of a stream of bytes, whatever is lost from it or put into it."""

from __future__ import annotations

import re
from collections.abc import Iterator

from varishold.live.framing.model import Packet, Pattern

__all__ = ["PacketSplitter"]

# A byte that is missed where a packet should begin makes the place so much more doubtful, and a packet that is there
# so much less; beyond the limit another place is taken, if there is one that fits.
_FORGET, _DOUBTFUL = 0.97, 3.0


class PacketSplitter:
    """Finds packets by their fixed bytes.

    Once it knows where packets begin it takes one after the other, each as soon as its last byte is there. Where one
    does not begin as it should, either some bytes changed, and the next begins where it would have anyway; or some are
    lost or too many, and the nearest place is taken at which two packets follow each other. A head that stands among
    values by chance is hence left again when the values change, at the latest when it was missed more often than
    `_DOUBTFUL` allows. Every decision waits until the bytes that it needs are there, so that the same bytes give the
    same packets however they are chopped.

    Parameters
    ----------
    packets : tuple of Packet
        Told apart by their heads.
    confirm : bool
        Whether a packet is first believed when another follows it, or its checksum is right. Not where each is
        asked for.
    """

    def __init__(self, packets: tuple[Packet, ...], *, confirm: bool = True) -> None:
        self._packets = packets
        choices = b"|".join(b"(?P<p%d>%s)" % (number, _pattern(packet)) for number, packet in enumerate(packets))
        self._whole = re.compile(choices, re.DOTALL)
        self._ahead = re.compile(b"(?=%s)" % choices, re.DOTALL)
        self._largest = max(packet.size for packet in packets)
        # Whether one packet is enough to believe that it is one.
        self._certain = not confirm or all(packet.checksum is not None for packet in packets)
        self.damaged = 0
        self.restart()

    def restart(self) -> None:
        """Forget all bytes: what comes next is something new."""
        self._bytes = b""
        self._at = 0
        self._known = False
        self._doubt = 0.0

    def feed(self, data: bytes) -> list[tuple[int, bytes]]:
        """Return the packets that end in these bytes: the number of each one's kind, and its bytes."""
        self._bytes += data
        found: list[tuple[int, bytes]] = []
        while self._take(found) if self._known else self._search():
            pass
        # A packet that was lost may have begun before the place at which it was looked for.
        kept = max(0, self._at - self._largest)
        self._bytes, self._at = self._bytes[kept:], self._at - kept
        return found

    def _take(self, found: list[tuple[int, bytes]]) -> bool:
        """Take the packet that begins here; tell whether more can be done with the bytes that are there."""
        match = self._whole.match(self._bytes, self._at)
        if match is None:
            # Three packets from here on decide: this one, and two that follow each other.
            needed = self._largest * (1 if self._certain else 3)
            return len(self._bytes) - self._at >= needed and self._look_around()
        kind, packet = _kind(match), match.group()
        self._doubt *= _FORGET
        if self._packets[kind].is_sound(packet):
            self._at = match.end()
            found.append((kind, packet))
        else:
            self.damaged += 1
            self._at += 1
            self._known = False
        return True

    def _look_around(self) -> bool:
        """Go on where no packet begins that should."""
        self.damaged += 1
        if self._certain:
            self._known = False
            return True
        self._doubt += 1.0
        goes_on = [
            at for at in {self._at + packet.size for packet in self._packets} if self._whole.match(self._bytes, at)
        ]
        if goes_on and self._doubt < _DOUBTFUL:
            self._at = min(goes_on)
            return True
        reach = self._largest // 2
        others = [at for at in self._places(self._at - reach, self._at + reach) if at not in goes_on]
        self._doubt = 0.0
        if others:
            here = self._at
            self._at = min(others, key=lambda at: abs(at - here))
        elif goes_on:
            self._at = min(goes_on)
        else:
            self._at += reach + 1
            self._known = False
        return True

    def _places(self, first: int, last: int) -> Iterator[int]:
        """Yield the places in a range at which a packet is believed to begin; two packets behind it must be there."""
        at = max(first, 0)
        while (match := self._ahead.search(self._bytes, at)) is not None and match.start() <= last:
            at = match.start() + 1
            if self._is_believed(match):
                yield match.start()

    def _is_believed(self, match: re.Match[bytes]) -> bool:
        kind = _kind(match)
        if self._certain:
            return self._packets[kind].is_sound(match.group(kind + 1))
        return self._whole.match(self._bytes, match.end(kind + 1)) is not None

    def _search(self) -> bool:
        """Look for the first packet that is believed; tell whether there is one."""
        decided = len(self._bytes) - self._largest * (1 if self._certain else 2)
        place = next(self._places(self._at, decided), None)
        if place is None:
            self._at = max(self._at, decided + 1)
            return False
        self._at, self._known = place, True
        return True


def _kind(match: re.Match[bytes]) -> int:
    """Return the number of the group that matched, from 0."""
    return (match.lastindex or 1) - 1


def _pattern(packet: Packet) -> bytes:
    return _fixed(packet.head) + b".{%d}" % packet.body + _fixed(packet.tail)


def _fixed(pattern: Pattern) -> bytes:
    return b"".join(b"." if byte is None else re.escape(bytes([byte])) for byte in pattern)
