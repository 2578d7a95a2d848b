"""Packets between bytes that stand nowhere else, because they are escaped."""

from __future__ import annotations

import re

from varishold.live.framing.model import Escape, Packet

__all__ = ["EscapedSplitter"]


class EscapedSplitter:
    """Finds packets between a head and a tail, and takes the escapes off.

    Parameters
    ----------
    packet : Packet
        What stands between head and tail, escapes taken off.
    escape : Escape
    """

    def __init__(self, packet: Packet, escape: Escape) -> None:
        self._packet = packet
        self._escape = escape
        ends = bytes(byte for byte in (escape.head, escape.tail) if byte is not None)
        self._end = re.compile(b"[%s]" % re.escape(ends))
        self._pair = re.compile(b"%s(.?)" % re.escape(bytes([escape.mark])), re.DOTALL)
        self._meant = {bytes([second]): bytes([meant]) for second, meant in escape.meant.items()}
        # Whether the byte that ends a packet may be the one that begins the next.
        self._goes_on = escape.head is None or escape.tail is None or escape.head == escape.tail
        self.damaged = 0
        self.restart()

    def restart(self) -> None:
        """Forget all bytes: what comes next is something new."""
        self._rest = b""
        # Whether a packet has begun; without a head it begins where the last one ended.
        self._begun = self._escape.head is None

    def feed(self, data: bytes) -> list[tuple[int, bytes]]:
        """Return the packets that end in these bytes: the number of each one's kind, which is 0, and its bytes."""
        found: list[tuple[int, bytes]] = []
        at = 0
        for match in self._end.finditer(data):
            content = self._rest + data[at : match.start()]
            self._rest, at = b"", match.end()
            is_tail = self._escape.tail is None or match.group()[0] == self._escape.tail
            if self._begun and is_tail and content:
                self._finish(content, found)
            elif self._begun and content:
                self.damaged += 1
            self._begun = not is_tail or self._goes_on
        # Of what is too long to be a packet nothing is needed but that it is too long.
        self._rest = (self._rest + data[at:])[: 2 * self._packet.size + 2]
        return found

    def _finish(self, content: bytes, found: list[tuple[int, bytes]]) -> None:
        try:
            packet = self._pair.sub(lambda pair: self._meant[pair[1]], content)
        except KeyError:
            packet = b""
        if len(packet) == self._packet.size and self._packet.is_sound(packet):
            found.append((0, packet))
        else:
            self.damaged += 1
