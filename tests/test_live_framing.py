"""Laws of framings: what was sent comes out, however it is chopped, and whatever is done to it on its way."""

from __future__ import annotations

import binascii
import functools
import operator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks._skin_senders import SENDERS, Frame, frames_of
from varishold.live import PadLayout
from varishold.live.framing import FRAMINGS, Decoder, Framing, checksums, decoder_of, framing_of
from varishold.live.framing.checksums import CHECKSUMS, Checksum
from varishold.live.framing.model import Packet, PadValues

HEADS = {"flexitac": b"\xaa\x55", "jq-mat-32": b"\xaa\x55\x03\x99", "anyskin": b"\r\n", "matsense-simple": b"\xff"}
BINARY = sorted(name for name in SENDERS if "arduino" not in name and "text" not in name)


def _framing(name: str) -> Framing:
    framing = framing_of(name)
    return framing.with_shape((6, 6)) if name == "arduino-line" else framing


def _sent(name: str, frames: list[Frame]) -> list[bytes]:
    return [SENDERS[name].bytes_of(frame) for frame in frames]


def _fed(decoder: Decoder, data: bytes, cuts: list[int]) -> list[Frame]:
    """Return what comes out of a stream that is cut at some places."""
    found = []
    places = sorted({0, len(data), *(cut % (len(data) + 1) for cut in cuts)})
    for first, last in pairwise(places):
        found += [dict(reading.pads) for reading in decoder.feed(data[first:last])]
    return found


def _key(frame: Frame) -> tuple[tuple[str, bytes], ...]:
    return tuple(sorted((name, values.tobytes()) for name, values in frame.items()))


def _keys(frames: list[Frame]) -> list[tuple[tuple[str, bytes], ...]]:
    return [_key(frame) for frame in frames]


def test_every_preset_has_a_sender() -> None:
    assert set(SENDERS) == set(FRAMINGS)


@pytest.mark.parametrize("name", sorted(SENDERS))
@given(seed=st.integers(0, 99), cuts=st.lists(st.integers(0, 1 << 16), max_size=12))
@settings(max_examples=15)
def test_what_was_sent_comes_out_however_it_is_chopped(name: str, seed: int, cuts: list[int]) -> None:
    frames = frames_of(name, 6, seed)
    found = _fed(decoder_of(_framing(name)), b"".join(_sent(name, frames)), cuts)
    # Rows and columns that nobody gave are seen from the first two frames.
    wanted = frames[1:] if name == "arduino-rows" else frames
    assert _keys(found) == _keys(wanted)
    for one, other in zip(found, wanted, strict=True):
        for pad, values in one.items():
            assert (values.shape, values.dtype) == (other[pad].shape, other[pad].dtype)
            assert values.dtype.isnative


@pytest.mark.parametrize("name", sorted(SENDERS))
@given(
    seed=st.integers(0, 99),
    garbage=st.lists(st.binary(max_size=700), min_size=3, max_size=3),
    cuts=st.lists(st.integers(0, 1 << 16), max_size=6),
)
@settings(max_examples=25)
def test_chopping_changes_nothing_with_garbage_either(
    name: str, seed: int, garbage: list[bytes], cuts: list[int]
) -> None:
    sent = _sent(name, frames_of(name, 6, seed))
    data = garbage[0] + b"".join(sent[:3]) + garbage[1] + b"".join(sent[3:5]) + garbage[2] + sent[5]
    once, often = decoder_of(_framing(name)), decoder_of(_framing(name))
    assert _keys(_fed(once, data, [])) == _keys(_fed(often, data, cuts))
    assert once.damaged == often.damaged


@pytest.mark.parametrize("name", sorted(set(SENDERS) - {"jq-mat-64"}))
def test_byte_by_byte_gives_the_same(name: str) -> None:
    sent = _sent(name, frames_of(name, 4))
    data = b"".join(sent[:2]) + b"\xaa\x55\r\n\n5" + b"".join(sent[2:])
    together = _fed(decoder_of(_framing(name)), data, [])
    assert _keys(_fed(decoder_of(_framing(name)), data, list(range(len(data))))) == _keys(together)


@pytest.mark.parametrize("name", sorted(SENDERS))
@given(seed=st.integers(0, 99), before=st.binary(max_size=900), between=st.binary(min_size=1, max_size=900))
@settings(max_examples=25)
def test_it_is_in_step_again_within_two_frames_after_garbage(
    name: str, seed: int, before: bytes, between: bytes
) -> None:
    frames = frames_of(name, 16, seed)
    sent = _sent(name, frames)
    data = before + b"".join(sent[:8]) + between + b"".join(sent[8:])
    found = set(_keys(_fed(decoder_of(_framing(name)), data, [])))
    keys = _keys(frames)
    lost = 3 if name == "arduino-rows" else 2
    # Those at the very end may still be waiting for more bytes.
    assert found.issuperset(keys[lost:7])
    assert found.issuperset(keys[10:13])


@pytest.mark.parametrize("name", BINARY)
@given(seed=st.integers(0, 99), at=st.integers(0, 1 << 16), lost=st.integers(1, 40))
@settings(max_examples=25)
def test_lost_bytes_cost_two_frames_at_most(name: str, seed: int, at: int, lost: int) -> None:
    frames = frames_of(name, 14, seed)
    sent = _sent(name, frames)
    at %= len(sent[4])
    sent[4] = sent[4][:at] + sent[4][at + lost :]
    found = set(_keys(_fed(decoder_of(_framing(name)), b"".join(sent), [])))
    keys = _keys(frames)
    assert found.issuperset(keys[:4])
    assert found.issuperset(keys[7:11])


@pytest.mark.parametrize("name", sorted(SENDERS))
def test_a_thousandth_of_the_bytes_damaged(name: str) -> None:
    frames = frames_of(name, 400, seed=7)
    rng = np.random.default_rng(3)
    keys, wanted, untouched, data = _keys(frames), set(), 0, b""
    for key, part in zip(keys, _sent(name, frames), strict=True):
        raw = np.frombuffer(part, np.uint8).copy()
        hit = rng.random(raw.size) < 1e-3
        raw[hit] ^= rng.integers(1, 256, int(hit.sum()), np.uint8)
        data += raw.tobytes()
        if not hit.any():
            wanted.add(key)
            untouched += 1
    found = _keys(_fed(decoder_of(_framing(name)), data, list(range(0, len(data), 777))))
    assert len(wanted.intersection(found)) >= 0.98 * untouched - 4
    assert len(found) <= len(frames)


@pytest.mark.parametrize("name", sorted(HEADS))
@given(seed=st.integers(0, 999), start=st.integers(0, 1 << 12), heads=st.integers(1, 6))
@settings(max_examples=25)
def test_heads_among_values_do_not_hold_it(name: str, seed: int, start: int, heads: int) -> None:
    rng = np.random.default_rng(seed)
    frames = frames_of(name, 20, seed)
    head = HEADS[name]
    for frame in frames:
        flat = frame["pad"].view(np.uint8).ravel()
        for at in rng.integers(0, flat.size - len(head), heads):
            flat[at : at + len(head)] = np.frombuffer(head, np.uint8)
    data = b"".join(_sent(name, frames))
    found = _keys(_fed(decoder_of(_framing(name)), data[start % len(data) // 2 :], []))
    assert set(found).issuperset(_keys(frames)[14:17])


@pytest.mark.parametrize("name", sorted(HEADS))
@pytest.mark.parametrize("at", [1, 17, 60])
def test_a_head_that_stays_among_the_values_is_not_taken_for_one(name: str, at: int) -> None:
    """Known where frames begin, changed, lost and added bytes do not make it step to what looks the same."""
    frames = frames_of(name, 60, seed=at)
    for frame in frames:
        frame["pad"].view(np.uint8).ravel()[at : at + len(HEADS[name])] = np.frombuffer(HEADS[name], np.uint8)
    sent = _sent(name, frames)
    sent[10] = b"\x00" + sent[10][1:-1] + b"\x00"
    sent[20] = sent[20][:30] + sent[20][31:]
    sent[30] = sent[30][:30] + b"\x00" + sent[30][30:]
    found = _keys(_fed(decoder_of(_framing(name)), b"".join(sent), []))
    keys = _keys(frames)
    lost = [number for number, key in enumerate(keys[:57]) if key not in found]
    assert set(lost) <= {10, 11, 20, 21, 30, 31}


@pytest.mark.parametrize("name", sorted(HEADS))
def test_it_leaves_a_false_place_once_that_fails_now_and_then(name: str) -> None:
    """Opened in the middle of a frame whose values look like a head, four frames of five."""
    frames = frames_of(name, 100, seed=5)
    for number, frame in enumerate(frames):
        if number % 5:
            frame["pad"].view(np.uint8).ravel()[40 : 40 + len(HEADS[name])] = np.frombuffer(HEADS[name], np.uint8)
    data = b"".join(_sent(name, frames))[len(_sent(name, frames)[0]) + 20 :]
    found = _keys(_fed(decoder_of(_framing(name)), data, []))
    assert set(found).issuperset(_keys(frames)[40:96])


@given(
    at=st.integers(0, 200),
    lost=st.integers(1, 30),
    kind=st.sampled_from(sorted(kind for kind in CHECKSUMS if kind.startswith("crc") and kind != "crc8")),
)
def test_a_checksum_tells_where_heads_do_not(at: int, lost: int, kind: str) -> None:
    """Frames of nothing but heads: bytes are lost, and the next frame is right."""
    packet = Packet(values=64, head=(0xAA, 0x55), checksum=Checksum(kind, start=2))
    framing = Framing((PadValues(np.dtype("<u2"), PadLayout((4, 8))),), (packet,))
    sent = []
    for number in range(8):
        content = b"\xaa\x55" + np.array([number, *[0x55AA] * 31], "<u2").tobytes()
        sent.append(content + Checksum(kind, start=2).of(content))
    at %= len(sent[3])
    sent[3] = sent[3][:at] + sent[3][at + lost :]
    found = [frame["pad"][0, 0] for frame in _fed(decoder_of(framing), b"".join(sent), [])]
    assert set(found) >= {0, 1, 2, 4, 5, 6, 7}
    assert found == sorted(found)


@pytest.mark.parametrize("name", sorted(SENDERS))
@pytest.mark.parametrize("what", ["noise", "heads", "nothing", "digits"])
def test_whatever_comes_is_survived_in_little_memory(name: str, what: str) -> None:
    rng = np.random.default_rng(0)
    sent = _sent(name, frames_of(name, 4))
    flood = {
        "noise": rng.integers(0, 256, 300_000, np.uint8).tobytes(),
        "heads": sent[0][:2] * 150_000,
        "nothing": bytes(300_000),
        "digits": b"7" * 300_000,
    }[what]
    decoder = decoder_of(_framing(name))
    for at in range(0, len(flood), 10_000):
        decoder.feed(flood[at : at + 10_000])
        held = getattr(decoder, "_splitter", decoder)
        kept = len(getattr(held, "_bytes", b"")) + len(getattr(held, "_rest", b""))
        assert kept <= 6 * max(len(part) for part in sent) + 10_000 + (1 << 18)
    decoder.restart()
    found = [dict(reading.pads) for reading in decoder.feed(b"".join(sent))]
    assert _keys(found)[-2:] == _keys(frames_of(name, 4))[-2:]


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("sum8", 0xDD),
        ("lrc8", 0x23),
        ("xor8", 0x31),
        ("crc8", 0xF4),
        ("sum16", 0x01DD),
        ("crc16-ccitt", 0x29B1),
        ("crc16-xmodem", 0x31C3),
        ("crc16-modbus", 0x4B37),
        ("crc32", 0xCBF43926),
    ],
)
def test_checksums_are_those_that_go_by_their_names(kind: str, value: int) -> None:
    size = CHECKSUMS[kind][0]
    assert Checksum(kind).of(b"123456789") == value.to_bytes(size, "little")
    assert Checksum(kind, start=1, endian="big").of(b"x123456789") == value.to_bytes(size, "big")


@given(st.binary(max_size=40), st.integers(0, 45), st.sampled_from(["little", "big"]))
@settings(max_examples=60)
def test_checksums_are_sums_of_polynomials(data: bytes, start: int, endian: Any) -> None:
    """Bit by bit: CRC-8 with x^8 + x^2 + x + 1, and MODBUS with its polynomial read backward."""
    crc8 = 0
    modbus = 0xFFFF
    for byte in data[start:]:
        crc8, modbus = crc8 ^ byte, modbus ^ byte
        for _ in range(8):
            crc8 = (crc8 << 1 ^ (0x07 if crc8 & 0x80 else 0)) & 0xFF
            modbus = modbus >> 1 ^ (0xA001 if modbus & 1 else 0)
    assert Checksum("crc8", start).of(data) == bytes([crc8])
    assert Checksum("crc16-modbus", start, endian).of(data) == modbus.to_bytes(2, endian)
    tables = checksums._table8(0x07), checksums._reflected(0xA001)
    assert (checksums._CRC8, checksums._MODBUS) == tables
    assert tables[0][1:9] == (0x07, 0x0E, 0x09, 0x1C, 0x1B, 0x12, 0x15, 0x38)
    assert tables[1][1:4] == (0xC0C1, 0xC181, 0x0140)
    value = 0xFFFF
    for byte in data[start:]:
        value = value >> 8 ^ binascii.crc_hqx(bytes([(value ^ byte) & 0xFF]), 0)
    assert Checksum("crc16-weiss", start, endian).of(data) == value.to_bytes(2, endian)
    xored = functools.reduce(operator.xor, data[start:], 0)
    sums = {"sum8": sum(data[start:]) & 255, "lrc8": -sum(data[start:]) & 255, "xor8": xored}
    assert {kind: Checksum(kind, start).of(data)[0] for kind in sums} == sums


def test_the_request_of_a_weiss_finger_carries_its_checksum() -> None:
    request = framing_of("weiss-wsg").request
    assert request[-2:] == Checksum("crc16-weiss").of(request[:-2])


@pytest.mark.parametrize("name", sorted(HEADS))
def test_a_head_that_is_damaged_at_times_does_not_make_it_leave(name: str) -> None:
    """Though another place looks right all the time."""
    frames = frames_of(name, 400, seed=9)
    for frame in frames:
        frame["pad"].view(np.uint8).ravel()[30 : 30 + len(HEADS[name])] = np.frombuffer(HEADS[name], np.uint8)
    sent = _sent(name, frames)
    for number in range(40, 400, 50):
        # In every one of these framings a frame's first or last byte is fixed.
        sent[number] = bytes([sent[number][0] ^ 1]) + sent[number][1:-1] + bytes([sent[number][-1] ^ 1])
    found = set(_keys(_fed(decoder_of(_framing(name)), b"".join(sent), [])))
    assert [number for number, key in enumerate(_keys(frames)[:396]) if key not in found] == list(range(40, 396, 50))
