"""What each known serial skin sends, written down apart from the framings: a frame's values to its bytes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

__all__ = ["SENDERS", "Sender", "frames_of", "weiss_crc"]

Frame = dict[str, np.ndarray]


class Sender(NamedTuple):
    """A skin: what it measures, and how it says so."""

    draw: Callable[[np.random.Generator], Frame]
    bytes_of: Callable[[Frame], bytes]


def weiss_crc(data: bytes) -> int:
    """Bit by bit, for the table that they have."""
    value = 0xFFFF
    for byte in data:
        part = ((value ^ byte) & 0xFF) << 8
        for _ in range(8):
            part = ((part << 1) ^ 0x1021 if part & 0x8000 else part << 1) & 0xFFFF
        value = (value >> 8) ^ part
    return value


def _drawn(shape: tuple[int, ...], dtype: Any, most: int, name: str = "pad") -> Callable[[np.random.Generator], Frame]:
    return lambda rng: {name: rng.integers(0, most, shape).astype(dtype)}


def _escaped(content: bytes) -> bytes:
    out = bytearray(b"\x5b")
    for byte in content:
        out += {0x5C: b"\x5c\x00", 0x5B: b"\x5c\x01", 0x5D: b"\x5c\x02"}.get(byte, bytes([byte]))
    return bytes(out + b"\x5d")


def _matsense_imu(rng: np.random.Generator) -> Frame:
    return {"pad": rng.integers(0, 256, (16, 16), np.uint8), "imu": rng.integers(-32768, 32768, 6).astype(np.int16)}


def _weiss(frame: Frame) -> bytes:
    payload = struct.pack("<HIB", 0, 123456, 0) + frame["pad"].astype("<u2").tobytes()
    packet = b"\xaa\xaa\xaa\x20" + struct.pack("<H", len(payload)) + payload
    return packet + struct.pack("<H", weiss_crc(packet))


def _glove(rng: np.random.Generator) -> Frame:
    side = "left" if rng.random() < 0.5 else "right"
    turn = rng.standard_normal(4).astype(np.float32)
    return {side: rng.integers(0, 256, (16, 16), np.uint8), f"{side}.orientation": turn}


def _glove_bytes(frame: Frame, extra: bytes = b"") -> bytes:
    side = next(iter(frame))
    which = b"\x01" if side == "left" else b"\x02"
    values = frame[side].tobytes()
    mark = b"\xaa\x55\x03\x99"
    first = mark + b"\x01" + which + values[:128]
    return first + mark + b"\x02" + which + values[128:] + frame[f"{side}.orientation"].astype("<f4").tobytes() + extra


def _rows(frame: Frame) -> bytes:
    return "".join(",".join(str(value) for value in row) + "\r\n" for row in frame["pad"].tolist()).encode() + b"\r\n"


def _line(frame: Frame) -> bytes:
    return "\t".join(repr(value) for value in frame["pad"].ravel().tolist()).encode() + b"\n"


_SIGNALS = Sender(
    lambda rng: {"pad": rng.normal(0, 300, 20).astype(np.float32)},
    lambda frame: frame["pad"].astype("<f4").tobytes() + b"\r\n",
)

#: By the name of the preset.
SENDERS: dict[str, Sender] = {
    "flexitac": Sender(_drawn((12, 32), np.uint8, 256), lambda frame: b"\xaa\x55" + frame["pad"].tobytes()),
    "anyskin": _SIGNALS,
    "anyskin-text": Sender(lambda rng: {"pad": rng.normal(0, 300, 20)}, _line),
    "matsense": Sender(_drawn((16, 16), np.uint8, 256), lambda frame: _escaped(frame["pad"].tobytes())),
    "matsense-imu": Sender(
        _matsense_imu, lambda frame: _escaped(frame["pad"].tobytes() + frame["imu"].astype("<i2").tobytes())
    ),
    "matsense-simple": Sender(_drawn((16, 16), np.uint8, 255), lambda frame: frame["pad"].tobytes() + b"\xff"),
    "weiss-wsg": Sender(_drawn((6, 4), np.uint16, 4096), _weiss),
    "jq-mat-32": Sender(_drawn((32, 32), np.uint8, 256), lambda frame: b"\xaa\x55\x03\x99" + frame["pad"].tobytes()),
    "jq-mat-64": Sender(_drawn((64, 64), np.uint8, 256), lambda frame: b"\xaa\x55\x03\x99" + frame["pad"].tobytes()),
    "jq-glove": Sender(_glove, _glove_bytes),
    "jq-glove-long": Sender(_glove, lambda frame: _glove_bytes(frame, bytes(range(24)))),
    "arduino-rows": Sender(_drawn((5, 7), np.float64, 1024), _rows),
    "arduino-line": Sender(_drawn((6, 6), np.float64, 1024), _line),
}


def frames_of(name: str, count: int, seed: int = 0) -> list[Frame]:
    """Draw some frames of a skin."""
    rng = np.random.default_rng(seed)
    return [SENDERS[name].draw(rng) for _ in range(count)]
