"""The bytes of the ROS 2 messages that are written, and of images of any kind that are read."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ImageLayout",
    "NumbersLayout",
    "image_head",
    "image_layout",
    "image_message",
    "image_pixels",
    "images",
    "numbers_head",
    "numbers_layout",
    "numbers_message",
    "string_message",
    "string_of",
]

# What stands before every message that is written: plain CDR, the lowest byte first. The second byte tells the order.
_LITTLE = b"\x00\x01\x00\x00"
_ORDERS: Mapping[bytes, Literal["<", ">"]] = {b"\x00\x00": ">", b"\x00\x01": "<"}
# An image's stamp, and where it ends.
_STAMP, _AFTER_STAMP = struct.Struct("<iI"), 12
_NS = 10**9
_ENCODING = re.compile(r"(8|16|32|64)([USF])C(\d{1,3})?")
_KINDS = {"U": "u", "S": "i", "F": "f"}
_NAMED = {"mono8": "8UC1", "mono16": "16UC1"}
# How each type is written that an encoding holds which viewers draw.
_DRAWN = {
    "u1": ("mono8", "<u1"),
    "u2": ("16UC1", "<u2"),
    **dict.fromkeys(("i1", "i2", "f2", "f4"), ("32FC1", "<f4")),
}
# The other types, and up to where each float holds every whole number.
_FLOATS = (("32FC1", "<f4", 2**24), ("64FC1", "<f8", 2**53))
# What the axes of signals are called.
_AXES = {1: ("signal",), 2: ("taxel", "axis"), 3: ("row", "column", "axis")}


def image_pixels(values: NDArray[Any]) -> tuple[str, bytes]:
    """Return the encoding in which an image holds a frame without loss, and the frame's bytes in it.

    Viewers draw mono8, 16UC1 and 32FC1, so that one of these is taken wherever it holds every value; otherwise 64FC1,
    or the numbers' own bytes as channels of 8 bits.
    """
    known = _DRAWN.get(values.dtype.str[1:])
    if known is not None:
        return known[0], values.astype(known[1], copy=False).tobytes()
    for encoding, dtype, most in _FLOATS:
        if _holds(dtype, most, values):
            return encoding, values.astype(dtype).tobytes()
    return f"8UC{values.dtype.itemsize}", values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


def _holds(dtype: str, most: int, values: NDArray[Any]) -> bool:
    if values.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return np.array_equal(values.astype(dtype), values, equal_nan=True)
    return -most <= int(values.min()) and int(values.max()) <= most


def image_head(rows: int, cols: int, encoding: str, frame: str) -> bytes:
    """Return what stands between an image's stamp and its pixels."""
    dtype, channels = _pixel(encoding, "<")
    step = cols * dtype.itemsize * channels
    head = _filled(_text(frame)) + struct.pack("<II", rows, cols)
    return _filled(head + _text(encoding) + b"\0") + struct.pack("<II", step, rows * step)


def _text(text: str) -> bytes:
    """A text with its length and its closing zero byte."""
    coded = text.encode("utf-8", "replace") + b"\0"
    return struct.pack("<I", len(coded)) + coded


def _filled(head: bytes) -> bytes:
    """Fill up to a multiple of four bytes."""
    return head + bytes(-len(head) % 4)


def image_message(stamp_ns: int, head: bytes, pixels: bytes) -> bytes:
    """Return an image; the stamp must be within `clock.STAMPS_NS`."""
    return _LITTLE + _STAMP.pack(*divmod(stamp_ns, _NS)) + head + pixels


@dataclass(frozen=True)
class ImageLayout:
    """Where the pixels of an image are in its message.

    Parameters
    ----------
    rows, cols, channels : int
    dtype : dtype
        Of a number, with its byte order.
    step : int
        Bytes from one row to the next.
    start, size : int
        Where the pixels begin, and the bytes of the whole message.
    head : bytes
        What stands between stamp and pixels.
    order : str
        Byte order of everything but the pixels.
    """

    rows: int
    cols: int
    channels: int
    dtype: np.dtype[Any]
    step: int
    start: int
    size: int
    head: bytes
    order: str

    def fits(self, message: bytes) -> bool:
        """Tell whether another message is laid out in the same way."""
        return len(message) == self.size and message.startswith(self.head, _AFTER_STAMP)


def image_layout(message: bytes) -> ImageLayout:
    """Return how an image's message is laid out.

    Raises
    ------
    ValueError
        If it is no such message, or its sizes contradict each other.
    """
    order = _order(message)
    try:
        frame_ends = _text_end(message, _AFTER_STAMP, order)
        rows, cols = struct.unpack_from(f"{order}II", message, at := frame_ends + -frame_ends % 4)
        ends = _text_end(message, at + 8, order)
        encoding = message[at + 12 : ends].rstrip(b"\0").decode("ascii", "replace")
        large_first = message[ends]
        step, n_bytes = struct.unpack_from(f"{order}II", message, at := ends + 1 + -(ends + 1) % 4)
    except (struct.error, IndexError):
        raise ValueError(f"its {len(message)} bytes end before its pixels begin") from None
    dtype, channels = _pixel(encoding, ">" if large_first else "<")
    start, width = at + 8, cols * dtype.itemsize * channels
    if not (
        rows
        and cols
        and step >= width
        and n_bytes == rows * step
        and len(message) - start in range(n_bytes, n_bytes + 4)
    ):
        raise ValueError(
            f"{rows} x {cols} pixels of {encoding} in rows of {step} bytes need {rows * max(step, width)} bytes, and "
            f"{n_bytes} are announced, {len(message) - start} there"
        )
    head = bytes(message[_AFTER_STAMP:start])
    return ImageLayout(rows, cols, channels, dtype, step, start, len(message), head, order)


def _order(message: bytes) -> Literal["<", ">"]:
    order = _ORDERS.get(bytes(message[:2]))
    if order is None:
        raise ValueError(f"begins with {bytes(message[:4]).hex(' ')}, which is no plain CDR")
    return order


def _text_end(message: bytes, at: int, order: str) -> int:
    """Where a text ends that begins with its length."""
    (length,) = struct.unpack_from(f"{order}I", message, at)
    if length > len(message) - at - 4:
        raise ValueError(f"a text of {length} bytes is announced, {len(message) - at - 4} are there")
    return at + 4 + int(length)


def _pixel(encoding: str, order: str) -> tuple[np.dtype[Any], int]:
    """Return the type of a pixel's numbers, and how many there are."""
    match = _ENCODING.fullmatch(_NAMED.get(encoding, encoding))
    bits, kind, channels = match.groups() if match else ("", "", "")
    if match is None or (kind == "F") > (bits in ("16", "32", "64")) or int(channels or 1) == 0:
        raise ValueError(f"its encoding {encoding[:32]!r} is none of numbers; known are mono8, mono16, 8UC1 to 64FC1")
    return np.dtype(f"{order}{_KINDS[kind]}{int(bits) // 8}"), int(channels or 1)


def images(messages: list[bytes], layout: ImageLayout) -> tuple[NDArray[np.int64], NDArray[Any]]:
    """Return the stamps and the pixels of images that a layout fits.

    Returns
    -------
    ndarray of shape (n,), int64
        Nanoseconds.
    ndarray of shape (n, rows, cols, channels)
        In the images' own type.
    """
    n, row = len(messages), layout.cols * layout.channels * layout.dtype.itemsize
    stamps = np.frombuffer(
        b"".join([m[4:12] for m in messages]), [("s", f"{layout.order}i4"), ("ns", f"{layout.order}u4")]
    )
    stop = layout.start + layout.rows * layout.step
    data = np.frombuffer(b"".join([m[layout.start : stop] for m in messages]), np.uint8)
    rows = data.reshape(n, layout.rows, layout.step)[:, :, :row]
    values = np.ascontiguousarray(rows).view(layout.dtype).reshape(n, layout.rows, layout.cols, layout.channels)
    return stamps["s"].astype(np.int64) * _NS + stamps["ns"], values


def numbers_head(shape: tuple[int, ...]) -> bytes:
    """Return what stands before the numbers of a multi-array, the mark of its coding included.

    Numbers of eight bytes begin at a multiple of eight after that mark.
    """
    head = struct.pack("<I", len(shape))
    for axis, (label, size) in enumerate(zip(_AXES[len(shape)], shape, strict=True)):
        head = _filled(head + _text(label)) + struct.pack("<II", size, math.prod(shape[axis:]))
    return _LITTLE + head + struct.pack("<II", 0, math.prod(shape))


def numbers_message(head: bytes, values: NDArray[Any]) -> bytes:
    """Return a multi-array of numbers in their own type, lowest byte first."""
    fill = bytes(-(len(head) - 4) % values.dtype.itemsize)
    return head + fill + values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


@dataclass(frozen=True)
class NumbersLayout:
    """Where the numbers of a multi-array are in its message.

    Parameters
    ----------
    shape : tuple of int
    dtype : dtype
        Of a number, with its byte order.
    head : bytes
        What stands before the numbers, which go on to the end.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    head: bytes

    def fits(self, message: bytes) -> bool:
        """Tell whether another message is laid out in the same way."""
        size = len(self.head) + math.prod(self.shape) * self.dtype.itemsize
        return len(message) == size and message.startswith(self.head)


def numbers_layout(message: bytes, dtype: np.dtype[Any]) -> NumbersLayout:
    """Return how a multi-array's message is laid out.

    Raises
    ------
    ValueError
        If it is no such message, or its sizes contradict each other.
    """
    order = _order(message)
    sizes = []
    try:
        (n_dims,) = struct.unpack_from(f"{order}I", message, at := 4)
        at += 4
        for _ in range(n_dims):
            at = _text_end(message, at, order)
            at += -at % 4 + 8
            sizes.append(struct.unpack_from(f"{order}I", message, at - 8)[0])
        offset, n = struct.unpack_from(f"{order}II", message, at)
    except struct.error:
        raise ValueError(f"its {len(message)} bytes end before its numbers begin") from None
    start = int(at) + 8
    start += -(start - 4) % dtype.itemsize if n else 0
    if offset or math.prod(sizes or [n]) != n or len(message) != start + n * dtype.itemsize:
        raise ValueError(
            f"its layout says {' x '.join(map(str, sizes)) or n} numbers from {offset} on, {n} are announced, "
            f"{len(message) - start} bytes are there"
        )
    return NumbersLayout(tuple(sizes) or (n,), dtype.newbyteorder(order), message[:start])


def string_message(text: str) -> bytes:
    """Return a message that is one text."""
    return _LITTLE + _text(text)


def string_of(message: bytes) -> str:
    """Return the text of a message that is one.

    Raises
    ------
    ValueError
        If it is no such message.
    """
    order = _order(message)
    try:
        ends = _text_end(message, 4, order)
    except struct.error:
        raise ValueError(f"its {len(message)} bytes hold no text") from None
    return message[8:ends].rstrip(b"\0").decode("utf-8", "replace")
