"""Grey TIFF files of a stranger: pages of one number a pixel, in strips as they are or packed by deflate or LZW.

What a page says of its size, its numbers and its strips is checked before a number is read. Both byte orders, and
files beyond 4 GiB.
"""

from __future__ import annotations

import math
import os
import re
import struct
import zlib
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import damage_told
from varishold.recording.formats.tiff_lzw import unpacked

__all__ = ["MOST_TAXELS", "TiffPages"]

#: Taxels of a picture: more than any optical skin has.
MOST_TAXELS = 1 << 24
_MOST_PAGES, _MOST_ENTRIES, _MOST_STRIPS = 1 << 20, 4096, 1 << 16
# How whole numbers stand in entries, by their kind: bytes, 2, 4 and 8 of them.
_NUMBERS = {1: "B", 2: "B", 3: "H", 4: "I", 13: "I", 16: "Q", 18: "Q"}
# Entries by their numbers, and what each says where it is not there; of those without, there must be one.
_WIDTH, _LENGTH, _BITS, _PACKING, _PHOTOMETRIC, _FILL, _TOLD = 256, 257, 258, 259, 262, 266, 270
_OFFSETS, _TURN, _SAMPLES, _ROWS, _COUNTS, _PREDICTOR, _TILES, _KIND = 273, 274, 277, 278, 279, 317, 322, 339
_DEFAULTS = {_BITS: 1, _PACKING: 1, _FILL: 1, _TURN: 1, _SAMPLES: 1, _ROWS: 2**32 - 1, _PREDICTOR: 1, _KIND: 1}
_WANTED = (_WIDTH, _LENGTH, _PHOTOMETRIC, _TOLD, _OFFSETS, _COUNTS, _TILES, *_DEFAULTS)
_DTYPES = {1: "u", 2: "i", 3: "f"}
_PLAIN, _LZW, _DEFLATES = 1, 5, (8, 32946)
# What may have been done to numbers before: nothing, differences; bytes of floats apart.
_PREDICTORS, _PREDICTORS_OF_FLOATS, _FLOATS = (1, 2), (1, 2, 3), 3
_BLACK_IS_ZERO = 1
# What ImageJ says of a stack.
_STACK = re.compile(rb"^images=(\d{1,9})$", re.MULTILINE)
# A strip that is packed to more than it holds, and some bytes for its head, is damaged.
_WORSE, _HEAD = 2, 1024


@dataclass(frozen=True)
class _Page:
    """What a page says of itself."""

    shape: tuple[int, int]
    dtype: np.dtype[Any]
    packing: int
    predictor: int
    rows_per_strip: int
    offsets: tuple[int, ...]
    counts: tuple[int, ...]


class TiffPages:
    """The pages of an open TIFF file: a column of frames.

    Parameters
    ----------
    place : str
        What it is called, for messages.
    file : binary file
        Is closed with it, and where it cannot be read.

    Raises
    ------
    FormatError
        If it is damaged, or its first page is not grey.
    """

    def __init__(self, place: str, file: BinaryIO) -> None:
        self.place, self._file = place, file
        #: What there is to say about a file that was cut off.
        self.notes: tuple[str, ...] = ()
        try:
            self._size = self._file.seek(0, os.SEEK_END)
            with damage_told(self.place):
                self._order, self._wide, at = self._head()
                self._places = self._walk(at)
                first = self._page(0)
                promised = _STACK.search(bytes(self._said(self._places[0]).get(_TOLD, ())))
                if promised and int(promised[1]) > len(self._places) and not self.notes:
                    raise FormatError(
                        f"{self.place}: says that it holds {int(promised[1])} images and has {len(self._places)} pages "
                        "of them; save it with a page an image"
                    )
                while len(self._places) > 1 and not self._is_there(len(self._places) - 1):
                    self._places.pop()
                    self.notes = (f"is cut off after page {len(self._places) - 1}",)
        except BaseException:
            self._file.close()
            raise
        self.dtype = first.dtype.newbyteorder("=")
        self.shape: tuple[int, ...] = (len(self._places), *first.shape)

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._file.close()

    def _at(self, place: int, form: str) -> tuple[int, ...]:
        kind = struct.Struct(f"{self._order}{form}")
        return kind.unpack(self._bytes(place, kind.size))

    def _bytes(self, place: int, n_bytes: int) -> bytes:
        if place + n_bytes > self._size:
            raise EOFError(f"bytes {place} to {place + n_bytes} are wanted of {self._size}")
        self._file.seek(place)
        return self._file.read(n_bytes)

    def _head(self) -> tuple[str, bool, int]:
        """Return the byte order, whether places have 64 bits, and where the first page is."""
        self._order = {b"II": "<", b"MM": ">"}[self._bytes(0, 2)]
        (version,) = self._at(2, "H")
        if version not in (42, 43):
            raise ValueError(f"its version is {version}")
        return self._order, version == 43, self._at(8, "Q")[0] if version == 43 else self._at(4, "I")[0]

    def _walk(self, at: int) -> list[int]:
        """Return where each page is, as far as the file goes."""
        places = dict[int, None]()
        while at:
            if at in places or len(places) >= _MOST_PAGES:
                raise ValueError(f"its pages lead in a circle, or are more than {_MOST_PAGES}")
            try:
                n_entries, first, size = self._entries(at)
                (after,) = self._at(first + n_entries * size, "Q" if self._wide else "I")
            except EOFError:
                if not places:
                    raise
                self.notes = (f"is cut off after page {len(places) - 1}",)
                break
            places[at] = None
            at = after
        if not places:
            raise ValueError("it has no page")
        return list(places)

    def _entries(self, at: int) -> tuple[int, int, int]:
        """Return how many entries a page has, where they begin and how long each is."""
        (number,) = self._at(at, "Q" if self._wide else "H")
        if not 0 < number <= _MOST_ENTRIES:
            raise ValueError(f"a page has {number} entries")
        return (number, at + 8, 20) if self._wide else (number, at + 2, 12)

    def _page(self, number: int) -> _Page:
        """Read and check what a page says of itself."""
        which = f"{self.place}: page {number}"
        said = self._said(self._places[number])
        cols, rows = self._one(said, _WIDTH), self._one(said, _LENGTH)
        if not 0 < rows * cols <= MOST_TAXELS:
            raise FormatError(f"{which}: is {rows} x {cols}; it may have 1 to {MOST_TAXELS} taxels")
        if self._one(said, _SAMPLES) != 1 or self._one(said, _PHOTOMETRIC) != _BLACK_IS_ZERO:
            raise FormatError(f"{which}: has colours, or black for the largest number; depth pictures are grey")
        if _TILES in said or self._one(said, _FILL) != 1 or self._one(said, _TURN) != 1:
            raise FormatError(f"{which}: stands in tiles, turned or with bits reversed, which is not read; save strips")
        bits, kind = self._one(said, _BITS), self._one(said, _KIND)
        packing, predictor = self._one(said, _PACKING), self._one(said, _PREDICTOR)
        predictors = _PREDICTORS_OF_FLOATS if kind == _FLOATS else _PREDICTORS
        if packing not in (_PLAIN, _LZW, *_DEFLATES) or (packing != _PLAIN and predictor not in predictors):
            raise FormatError(
                f"{which}: is packed in way {packing} with predictor {predictor}, which is not read; save it unpacked, "
                "or by LZW or deflate"
            )
        if bits not in (8, 16, 32, 64) or kind not in _DTYPES or (kind, bits) == (3, 8):
            raise FormatError(f"{which}: has {bits} bits of kind {kind} a pixel; 8 to 64 whole bits are read")
        per_strip = min(rows, max(1, self._one(said, _ROWS)))
        offsets, counts = said.get(_OFFSETS, ()), said.get(_COUNTS, ())
        if len(offsets) != math.ceil(rows / per_strip) or len(counts) != len(offsets):
            raise ValueError(f"page {number} has {len(offsets)} strips of {per_strip} rows for {rows} rows")
        dtype = np.dtype(f"{self._order}{_DTYPES[kind]}{bits // 8}")
        return _Page((rows, cols), dtype, packing, predictor if packing != _PLAIN else 1, per_strip, offsets, counts)

    def _said(self, at: int) -> dict[int, tuple[int, ...]]:
        """Return the numbers of a page's entries; of words their letters."""
        number, first, size = self._entries(at)
        data = self._bytes(first, number * size)
        form = struct.Struct(f"{self._order}HH{'QQ' if self._wide else 'II'}")
        found: dict[int, tuple[int, ...]] = {}
        room = 8 if self._wide else 4
        for start in range(0, len(data), size):
            tag, kind, many, place = form.unpack_from(data, start)
            if kind not in _NUMBERS or many > _MOST_STRIPS or tag not in _WANTED:
                continue
            letters = f"{self._order}{many}{_NUMBERS[kind]}"
            if struct.calcsize(letters) <= room:
                found[tag] = struct.unpack_from(letters, data, start + size - room)
            else:
                found[tag] = struct.unpack(letters, self._bytes(place, struct.calcsize(letters)))
        return found

    def _one(self, said: dict[int, tuple[int, ...]], tag: int) -> int:
        values = said.get(tag, (_DEFAULTS[tag],) if tag in _DEFAULTS else ())
        if len(values) != 1:
            raise ValueError(f"a page says {len(values)} numbers as entry {tag}, where one is wanted")
        return values[0]

    def _is_there(self, number: int) -> bool:
        """Tell whether all of a page is in the file."""
        try:
            page = self._page(number)
        except EOFError:
            return False
        return all(at + n <= self._size for at, n in zip(page.offsets, page.counts, strict=True))

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some pages.

        Raises
        ------
        FormatError
            If one is damaged, or of another size or type than the first.
        """
        numbers = range(*wanted.indices(self.shape[0]))
        read = np.empty((len(numbers), *self.shape[1:]), self.dtype)
        for frame, number in zip(read, numbers, strict=True):
            with damage_told(f"{self.place}: page {number}"):
                page = self._page(number)
                if page.shape != self.shape[1:] or page.dtype.newbyteorder("=") != self.dtype:
                    raise FormatError(
                        f"{self.place}: page {number} is {page.shape[0]} x {page.shape[1]} {page.dtype.name}, page 0 "
                        f"{self.shape[1]} x {self.shape[2]} {self.dtype.name}; all must be alike"
                    )
                for strip, (at, n_bytes) in enumerate(zip(page.offsets, page.counts, strict=True)):
                    rows = frame[strip * page.rows_per_strip : (strip + 1) * page.rows_per_strip]
                    rows[:] = self._strip(page, at, n_bytes, rows.shape)
        return read

    def _strip(self, page: _Page, at: int, n_bytes: int, shape: tuple[int, ...]) -> NDArray[Any]:
        needed = math.prod(shape) * page.dtype.itemsize
        if n_bytes > _WORSE * needed + _HEAD:
            raise ValueError(f"a strip of {needed} bytes is packed into {n_bytes}")
        data = self._bytes(at, n_bytes)
        if page.packing == _LZW:
            data = unpacked(data, needed)
        elif page.packing != _PLAIN:
            data = zlib.decompressobj().decompress(data, needed)
        if len(data) < needed:
            raise EOFError(f"a strip has {len(data)} bytes of {needed}")
        values = np.frombuffer(data, page.dtype, math.prod(shape)).reshape(shape)
        if page.predictor == 1:
            return values
        if page.predictor == 2:
            # Differences wrap round, whatever the numbers mean.
            whole = values.view(page.dtype.str.replace("f", "u").replace("i", "u")).astype(f"u{page.dtype.itemsize}")
            summed = np.cumsum(whole, axis=1, dtype=whole.dtype)
            return summed.view(page.dtype.newbyteorder("="))
        planes = np.cumsum(np.frombuffer(data, np.uint8, needed).reshape(shape[0], -1), axis=1, dtype=np.uint8)
        # The first bytes of all numbers of a row, then the second, the largest first.
        parts = planes.reshape(shape[0], page.dtype.itemsize, shape[1]).transpose(0, 2, 1)
        return np.ascontiguousarray(parts).view(f">f{page.dtype.itemsize}")[:, :, 0]
