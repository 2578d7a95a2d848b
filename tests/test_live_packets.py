"""Packets out of bytes, decision by decision: which place is believed, when one is left, what is counted as damage."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from varishold.live.framing.checksums import Checksum
from varishold.live.framing.model import Packet
from varishold.live.framing.packets import PacketSplitter

HEAD = (0xAA, 0x55)


def _sent(count: int, *, false_head: bool = False, tail: bytes = b"") -> list[bytes]:
    """Return packets of eight values; a head may stand among those of all but the first six."""
    inside = [bytes([3 + k % 2, 9] if k < 6 or not false_head else HEAD) for k in range(count)]
    return [bytes(HEAD) + bytes([k % 160, 1, 2]) + inside[k] + bytes([3, 4, 5]) + tail for k in range(count)]


def _found(splitter: PacketSplitter, data: bytes) -> list[bytes]:
    return [packet for _, packet in splitter.feed(data)]


@pytest.mark.parametrize(("good", "leaves"), [(13, True), (14, False), (40, False), (5, True)])
def test_a_place_that_is_missed_too_often_is_left(good: int, leaves: bool) -> None:
    """A miss is forgotten by three hundredths a packet; three at once are too many where another place fits."""
    sent = _sent(90 * (good + 1), false_head=True)
    damaged = range(10, len(sent) - 4, good + 1)
    for at in damaged:
        sent[at] = b"\0\0" + sent[at][2:]
    splitter = PacketSplitter((Packet(8, HEAD),))
    found = _found(splitter, b"".join(sent))
    whole = [packet for packet in sent if packet[:2] == bytes(HEAD)]
    assert (found != whole) == leaves
    if not leaves:
        assert splitter.damaged == len(damaged)


@pytest.mark.parametrize(("in_a_row", "leaves"), [(1, False), (2, True)])
def test_a_place_is_left_at_once_where_the_next_packet_does_not_begin_either(in_a_row: int, leaves: bool) -> None:
    sent = _sent(40, false_head=True)
    for at in range(20, 20 + in_a_row):
        sent[at] = b"\0\0" + sent[at][2:]
    splitter = PacketSplitter((Packet(8, HEAD),))
    found = _found(splitter, b"".join(sent))
    assert found[:20] == sent[:20]
    assert (found[20:22] != sent[21:23]) == leaves
    assert splitter.damaged == 1


@pytest.mark.parametrize("lost", range(1, 10))
@pytest.mark.parametrize("more", [False, True])
def test_where_bytes_are_lost_or_too_many_the_nearest_place_goes_on(lost: int, more: bool) -> None:
    sent = _sent(30)
    broken = sent[10] + b"\x07" * lost if more else sent[10][:-lost]
    splitter = PacketSplitter((Packet(8, HEAD),))
    found = _found(splitter, b"".join([*sent[:10], broken, *sent[11:]]))
    # Bytes behind a whole packet cost none; where some are lost, the next head is taken for values.
    expected = sent if more else [*sent[:10], *sent[11:]]
    missing = [k for k, packet in enumerate(expected) if packet not in found]
    assert len(missing) <= (1 if more else 2)
    assert found[-18:] == sent[-18:]
    assert splitter.damaged <= 2


def test_a_packet_is_given_with_its_last_byte() -> None:
    sent = _sent(8)
    splitter, given_with = PacketSplitter((Packet(8, HEAD),)), []
    for at, byte in enumerate(b"".join(sent)):
        given_with += [(at, packet) for packet in _found(splitter, bytes([byte]))]
    # The first is believed when the second is there.
    assert given_with == [(19, sent[0]), *((10 * k + 9, sent[k]) for k in range(1, 8))]
    asked = PacketSplitter((Packet(8, HEAD),), confirm=False)
    assert _found(asked, b"\x01\x02" + sent[0][:-1]) == []
    assert _found(asked, sent[0][-1:]) == [sent[0]]
    # What comes after a new beginning has nothing to do with what came.
    splitter.feed(sent[0][:5])
    splitter.restart()
    assert _found(splitter, sent[0][5:] + sent[1] + sent[2]) == sent[1:3]
    assert splitter.damaged == 0


# With a checksum.


def _summed(values: bytes) -> bytes:
    return b"\xaa" + values + bytes([sum(b"\xaa" + values) & 255])


PACKET = Packet(4, (0xAA,), checksum=Checksum("sum8"))


@pytest.mark.parametrize(
    "before", [b"\xaa", b"\xaa\xaa", b"\xaa\x01\xaa", b"\x01\x02\x03", b"\xaa\x01\x02\x03\x04\x05"]
)
def test_one_sound_packet_is_enough_wherever_it_begins(before: bytes) -> None:
    sound = _summed(b"\x01\xaa\x02\x03")
    splitter = PacketSplitter((PACKET,))
    assert _found(splitter, before + sound) == [sound]
    # It is in step now: the next comes with its last byte, and damage in it is counted.
    assert _found(splitter, sound) == [sound]
    damaged = splitter.damaged
    assert _found(splitter, sound[:-1] + bytes([sound[-1] ^ 1])) == []
    assert _found(splitter, sound * 2) == [sound] * 2
    assert splitter.damaged == damaged + 1


@given(
    st.lists(st.one_of(st.binary(min_size=4, max_size=4).map(_summed), st.binary(max_size=7)), max_size=12),
    st.lists(st.integers(0, 90), max_size=5),
)
@settings(max_examples=200)
def test_every_sound_packet_between_packets_that_are_none_is_found(parts: list[bytes], cuts: list[int]) -> None:
    """As a slow look at every place finds them, one after the other; what may still become one is waited for."""
    data = b"".join(parts) + bytes(12)
    slow, at = [], 0
    while at + PACKET.size <= len(data):
        here = data[at : at + PACKET.size]
        if here[0] == 0xAA and sum(here[:-1]) & 255 == here[-1]:
            slow.append(here)
            at += PACKET.size
        else:
            at += 1
    splitter = PacketSplitter((PACKET,))
    places = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    assert [packet for a, b in pairwise(places) for packet in _found(splitter, data[a:b])] == slow
    assert len(splitter._bytes) <= 3 * PACKET.size


def test_packets_of_several_kinds_are_told_by_their_heads() -> None:
    first, second = Packet(2, (0xAA, 1), tail=(0x0D,)), Packet(3, (0xAA, 2), skip=1)
    one, two = b"\xaa\x01\x07\x08\x0d", b"\xaa\x02\x00\x01\x02\x03"
    splitter = PacketSplitter((first, second))
    assert splitter.feed((one + two) * 3) == [(0, one), (1, two)] * 3
    # One whose tail is not there is none.
    assert splitter.feed(one[:-1] + b"\0" + two + one + two + one)[-3:] == [(0, one), (1, two), (0, one)]
    assert splitter.damaged == 1


def test_what_a_packet_is_made_of_stands_in_its_order() -> None:
    packet = Packet(4, (1, None), (9,), skip=2, extra=3, checksum=Checksum("sum16"))
    assert (packet.start, packet.body, packet.size) == (4, 11, 14)
    content = bytes([1, 7, *range(10, 19)])
    whole = content + sum(content).to_bytes(2, "little") + b"\x09"
    assert len(whole) == packet.size
    assert packet.is_sound(whole)
    assert not packet.is_sound(whole[:11] + b"\0" + whole[12:])
    assert not packet.is_sound(b"\x02" + whole[1:])
    bare = Packet(4, (1, None), (9,), skip=2, extra=3)
    assert (bare.body, bare.size, bare.is_sound(b"")) == (9, 12, True)
