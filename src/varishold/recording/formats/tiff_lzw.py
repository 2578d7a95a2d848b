"""LZW as TIFF has it: codes of nine to twelve bits, each of which stands for a stretch of what came before.

The code 258 + k is what code k of the same run gave, and one byte more: so a stretch is copied from where it was given
first, and no table of stretches is kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["unpacked"]

_CLEAR, _END, _FIRST = 256, 257, 258
# How many codes of a run have 9, 10, 11 and 12 bits: a code too early, as the first program to write it had it.
_WIDTHS = ((9, 254), (10, 512), (11, 1024), (12, 2048))


def unpacked(data: bytes, n_bytes: int) -> bytes:
    """Return the first `n_bytes` bytes that are packed in `data`; fewer where there are fewer.

    Raises
    ------
    ValueError
        If a code stands for nothing that came before.
    """
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    out = bytearray()
    at = 0
    while len(out) < n_bytes:
        codes, at, ended = _run(bits, at)
        _expand(codes, out, n_bytes)
        if ended:
            break
    return bytes(out[:n_bytes])


def _run(bits: NDArray[np.uint8], at: int) -> tuple[list[int], int, bool]:
    """Return the codes up to the next that clears, where the next run begins, and whether it was the last."""
    codes: list[int] = []
    for width, most in _WIDTHS:
        many = min(most, (len(bits) - at) // width)
        block = bits[at : at + many * width].reshape(many, width) @ (1 << np.arange(width)[::-1])
        stops = np.flatnonzero((block == _CLEAR) | (block == _END))
        if stops.size:
            stop = int(stops[0])
            return codes + block[:stop].tolist(), at + (stop + 1) * width, bool(block[stop] == _END)
        codes += block.tolist()
        at += many * width
        if many < most:
            return codes, at, True
    raise ValueError("its codes grow beyond twelve bits")


def _expand(codes: list[int], out: bytearray, n_bytes: int) -> None:
    """Append what codes stand for, until there are enough bytes."""
    starts: list[int] = []
    at = len(out)
    for k, code in enumerate(codes):
        starts.append(at)
        if code < _CLEAR:
            out.append(code)
            at += 1
        else:
            before = code - _FIRST
            if before >= k:
                raise ValueError(f"code {code} stands for nothing yet")
            first = starts[before]
            stretch = out[first : starts[before + 1] + 1]
            # Of the one just before, the byte after it is its own first.
            if before == k - 1:
                stretch.append(out[first])
            out += stretch
            at += len(stretch)
        if at >= n_bytes:
            return
