"""Images as messages: `sensor_msgs/msg/Image`, written without loss, and read many at a time."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.mcap.cdr import LITTLE, cdr_order, cdr_text, filled, text_end

__all__ = ["ImageLayout", "image_head", "image_layout", "image_message", "image_pixels", "images"]

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
    head = filled(cdr_text(frame)) + struct.pack("<II", rows, cols)
    return filled(head + cdr_text(encoding) + b"\0") + struct.pack("<II", step, rows * step)


def image_message(stamp_ns: int, head: bytes, pixels: bytes) -> bytes:
    """Return an image; the stamp must be within `clock.STAMPS_NS`."""
    return LITTLE + _STAMP.pack(*divmod(stamp_ns, _NS)) + head + pixels


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


def image_layout(message: bytes, *, ros1: bool = False) -> ImageLayout:
    """Return how an image's message is laid out.

    Parameters
    ----------
    message : bytes
    ros1 : bool
        Whether it is of ROS 1, which fills nothing; its stamp stands in the same place, behind a number.

    Raises
    ------
    ValueError
        If it is no such message, or its sizes contradict each other.
    """
    order: str = "<" if ros1 else cdr_order(message)
    unit = 1 if ros1 else 4
    try:
        frame_ends = text_end(message, _AFTER_STAMP, order)
        rows, cols = struct.unpack_from(f"{order}II", message, at := frame_ends + -frame_ends % unit)
        ends = text_end(message, at + 8, order)
        encoding = message[at + 12 : ends].rstrip(b"\0").decode("ascii", "replace")
        large_first = message[ends]
        step, n_bytes = struct.unpack_from(f"{order}II", message, at := ends + 1 + -(ends + 1) % unit)
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
