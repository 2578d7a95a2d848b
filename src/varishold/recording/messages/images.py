"""Images of one channel: `sensor_msgs/Image`, and what is shaped like it."""

from __future__ import annotations

import base64
import binascii
import re

import numpy as np

from varishold.errors import InputError
from varishold.recording.messages.fields import Fields, number_at, numbers_in
from varishold.recording.messages.grids import MOST_VALUES, grid_pads
from varishold.recording.messages.reading import Asked, MessagePad

__all__ = ["image_pads"]

_NAMED = {"mono8": "u1", "mono16": "u2", "8uc1": "u1"}
_TYPES = {"u": "u", "s": "i", "f": "f"}
_ENCODING = re.compile(r"(8|16|32|64)([usf])c?1?", re.IGNORECASE)


def image_pads(fields: Fields, asked: Asked) -> dict[str, MessagePad] | None:
    """Return the pad that an image is: rows may be longer than they need be, in either order of bytes."""
    content = _content(fields.get("data"))
    if content is None or not isinstance(fields.get("encoding"), str):
        return None
    dtype = _dtype(fields["encoding"]).newbyteorder(">" if fields.get("is_bigendian") else "<")
    rows, cols = (int(number_at(fields, name) or 0) for name in ("height", "width"))
    if not (0 <= rows and 0 <= cols and rows * cols <= MOST_VALUES):
        raise InputError(f"an image of {rows} x {cols} came")
    if rows * cols == 0:
        return {}
    tight = cols * dtype.itemsize
    step = int(number_at(fields, "step") or 0) or tight
    if step < tight or content.size < step * (rows - 1) + tight:
        raise InputError(
            f"an image of {rows} x {cols} {fields['encoding']} with {step} bytes a row came with {content.size} bytes"
        )
    whole = np.lib.stride_tricks.as_strided(content, (rows, tight), (step, 1), writeable=False)
    return grid_pads(np.ascontiguousarray(whole).view(dtype), asked)


def _dtype(encoding: str) -> np.dtype:
    named = _NAMED.get(encoding.lower())
    match = _ENCODING.fullmatch(encoding)
    if named is None and match is None:
        raise InputError(
            f"an image in {encoding[:40]!r} came, which is no map of pressure; 32FC1, 64FC1, 16UC1, 16SC1, 32SC1, "
            "8UC1, mono8 and mono16 are",
            parameter="field",
        )
    try:
        return np.dtype(named or f"{_TYPES[match[2].lower()]}{int(match[1]) // 8}")  # type: ignore[index]
    except TypeError:
        raise InputError(f"an image in {encoding!r} came: there are no such numbers", parameter="field") from None


def _content(data: object) -> np.ndarray | None:
    """Return an image's bytes, which JSON holds in base64 or as numbers."""
    if isinstance(data, str):
        try:
            return np.frombuffer(base64.b64decode(data, validate=True), np.uint8)
        except (binascii.Error, ValueError):
            raise InputError(f"an image's data came as text that is no base64: {data[:40]!r}") from None
    numbers = numbers_in(data)
    if numbers is None or numbers.ndim != 1:
        return None
    if numbers.dtype == np.uint8:
        return numbers
    if numbers.size and not (numbers.dtype.kind in "iu" and 0 <= numbers.min() and numbers.max() < 256):
        raise InputError("an image's data must be bytes, from 0 to 255 each")
    return numbers.astype(np.uint8)
