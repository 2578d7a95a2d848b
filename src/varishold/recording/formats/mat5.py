"""MATLAB 5 to 7 (`save -v7`): numbers, text, structs and cells of text; objects and functions are never looked into."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import LARGEST_BYTES, damage_told, open_file, possible_text
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.matlab_arrays import stored_variables
from varishold.recording.stored import Stored

__all__ = ["FORMAT"]

_MAGIC, _HEAD = b"MATLAB 5.0", 128
_ORDERS = {b"IM": "<", b"MI": ">"}
# Kinds of elements that hold numbers, as numpy calls them; then those of text, of arrays and of what is packed.
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_TEXTS = {2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_MATRIX, _PACKED = 14, 15
# Classes of arrays: those of numbers by the type that they have in MATLAB.
_CELL, _STRUCT, _CHAR = 1, 2, 4
_CLASSES = {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
_OTHERS = {3: "an object", 5: "a sparse matrix", 16: "a function", 17: "an object"}
_COMPLEX, _LOGICAL = 0x0800, 0x0200
# Structs within structs, variables, entries of a cell, and to how much a file may unpack.
_DEEPEST, _MOST, _MOST_CELLS = 4, 4096, 1 << 20
_LARGE, _BOMB_RATIO = 1 << 28, 300


class _Element(NamedTuple):
    """An element of a file: its kind, its bytes, and where the next begins."""

    kind: int
    data: memoryview
    end: int


class _Array:
    """A variable in memory, in MATLAB's order of axes."""

    known_as: str = ""
    known_axes: int | None = None

    def __init__(self, values: NDArray[Any]) -> None:
        self._values = values
        self.shape, self.dtype = values.shape, values.dtype

    def read(self, *wanted: slice) -> NDArray[Any]:
        return self._values[wanted]

    def small(self) -> NDArray[Any]:
        return self._values


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


def _open(path: Path, options: Options) -> Stored:
    with open_file(path) as file, damage_told(str(path)):
        contents = _Contents(path, file)
        variables = {where: _Array(values) for where, values in contents.variables()}
    passed = (f"passed over: {', '.join(contents.passed[:8])}",) if contents.passed else ()
    return stored_variables(path, variables, options, notes=passed)


class _Contents:
    """What a file holds, element by element, within bounds."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self._path, self._file = path, file
        head = file.read(_HEAD)
        order = _ORDERS.get(head[126:128])
        if order is None:
            raise FormatError(f"{path}: is damaged or cut off: its head does not say the order of its bytes")
        self._order = order
        self._size = file.seek(0, 2)
        self._unpacked = 0
        self.passed: list[str] = []

    def variables(self) -> Iterator[tuple[tuple[str, ...], NDArray[Any]]]:
        """Yield every array of numbers or text by its place: the variable, and the field of a struct."""
        self._file.seek(_HEAD)
        for _ in range(_MOST):
            tag = self._file.read(8)
            if not tag:
                return
            kind, length = struct.unpack(f"{self._order}II", tag)
            left = self._size - self._file.tell()
            if kind not in (_MATRIX, _PACKED) or length > min(left, LARGEST_BYTES):
                raise ValueError(f"an element of kind {kind} and {length} bytes begins where {left} are left")
            body = self._file.read(length)
            if kind == _PACKED:
                inner = self._element(memoryview(self._inflated(body)), 0)
                if inner.kind != _MATRIX:
                    raise ValueError(f"an element of kind {inner.kind} is packed where a variable should be")
                yield from self._matrix(inner.data, (), 0)
            else:
                yield from self._matrix(memoryview(body), (), 0)
                self._file.seek(-length % 8, 1)
        raise FormatError(f"{self._path}: holds more than {_MOST} variables")

    def _inflated(self, body: bytes) -> bytes:
        most = min(LARGEST_BYTES, max(_LARGE, _BOMB_RATIO * self._size)) - self._unpacked
        unpacker = zlib.decompressobj()
        content = unpacker.decompress(body, max(1, most))
        self._unpacked += len(content)
        if unpacker.unconsumed_tail:
            raise FormatError(
                f"{self._path}: would unpack {self._size} bytes to more than {self._unpacked}; nothing measured is so "
                "empty, or it is too large (save it with -v7.3)"
            )
        if not unpacker.eof:
            raise EOFError("a packed variable ends early")
        return content

    def _element(self, data: memoryview, at: int) -> _Element:
        (kind,) = struct.unpack_from(f"{self._order}I", data, at)
        if kind >> 16:
            # Up to four bytes stand within the tag.
            length, kind, begin, end = kind >> 16, kind & 0xFFFF, at + 4, at + 8
        else:
            (length,) = struct.unpack_from(f"{self._order}I", data, at + 4)
            begin, end = at + 8, at + 8 + length + -length % 8
        if begin + length > len(data) or (begin == at + 4 and length > 4):
            raise ValueError(f"{length} bytes are announced where {len(data) - begin} are left")
        return _Element(kind, data[begin : begin + length], end)

    def _numbers(self, element: _Element) -> NDArray[Any]:
        kind = _NUMBERS.get(element.kind)
        if kind is None:
            raise ValueError(f"an element of kind {element.kind} stands where numbers should be")
        return np.frombuffer(element.data, f"{self._order}{kind}")

    def _matrix(
        self, data: memoryview, above: tuple[str, ...], depth: int
    ) -> Iterator[tuple[tuple[str, ...], NDArray[Any]]]:
        flags = self._element(data, 0)
        dims = self._element(data, flags.end)
        called = self._element(data, dims.end)
        told = int(self._numbers(flags)[0])
        shape = tuple(self._numbers(dims).tolist())
        if len(shape) < 2 or min(shape) < 0 or math.prod(shape) > LARGEST_BYTES:
            raise ValueError(f"an array of shape {shape} is announced")
        name = bytes(called.data).decode("ascii", "replace")
        where = (*above, name) if name else above
        kind, place = told & 0xFF, ".".join(where)
        if kind in _CLASSES and not told & _COMPLEX:
            values = self._numbers(self._element(data, called.end)).reshape(shape, order="F")
            made = values.astype(_CLASSES[kind], copy=False)
            yield where, made.astype(bool) if told & _LOGICAL else made
        elif kind == _CHAR:
            yield where, self._text(self._element(data, called.end), shape)
        elif kind == _CELL:
            texts = self._cell(data, called.end, math.prod(shape))
            if texts is None:
                self.passed.append(f"{place} (a cell)")
            else:
                yield where, texts
        elif kind == _STRUCT and math.prod(shape) == 1 and depth < _DEEPEST:
            yield from self._struct(data, called.end, where, depth)
        else:
            self.passed.append(
                f"{place} ({_OTHERS.get(kind, 'complex' if kind in _CLASSES else 'an array of structs')})"
            )

    def _struct(
        self, data: memoryview, at: int, where: tuple[str, ...], depth: int
    ) -> Iterator[tuple[tuple[str, ...], NDArray[Any]]]:
        longest = self._element(data, at)
        names = self._element(data, longest.end)
        width = int(self._numbers(longest)[0])
        if not 0 < width <= 256 or len(names.data) % width or len(names.data) > _MOST * width:
            raise ValueError(f"a struct has {len(names.data)} letters of names, {width} each")
        at = names.end
        for begin in range(0, len(names.data), width):
            name = bytes(names.data[begin : begin + width]).split(b"\0")[0].decode("ascii", "replace")
            field = self._element(data, at)
            if len(field.data):
                yield from self._matrix(field.data, (*where, name), depth + 1)
            at = field.end

    def _cell(self, data: memoryview, at: int, n: int) -> NDArray[Any] | None:
        """Return the texts of a cell; None where it holds anything else."""
        texts = []
        if n > min(_MOST_CELLS, len(data)):
            raise ValueError(f"a cell of {n} entries is announced")
        for _ in range(n):
            entry = self._element(data, at)
            at = entry.end
            if not len(entry.data):
                texts.append("")
                continue
            flags = self._element(entry.data, 0)
            if int(self._numbers(flags)[0]) & 0xFF != _CHAR:
                return None
            ((_, text),) = self._matrix(entry.data, (), 0)
            if text.size > 1:
                return None
            texts.append(str(text.ravel()[0]) if text.size else "")
        return np.array(texts, np.str_)

    def _text(self, element: _Element, shape: tuple[int, ...]) -> NDArray[Any]:
        """Return the text of each row of an array of characters."""
        if element.kind not in _TEXTS and element.kind != 1:
            raise ValueError(f"an element of kind {element.kind} stands where text should be")
        if math.prod(shape) > len(element.data):
            raise ValueError(f"{shape} characters are announced, {len(element.data)} bytes are there")
        coding = _TEXTS.get(element.kind, "latin-1")
        if coding in ("utf-16", "utf-32"):
            coding += "-le" if self._order == "<" else "-be"
        letters = bytes(element.data).decode(coding, "replace")
        rows = shape[0] if math.prod(shape) else 0
        # Columns come first, and shorter rows are filled.
        fill = "\0 " if rows > 1 else "\0"
        return possible_text(np.array([letters[row::rows].rstrip(fill) for row in range(rows)], np.str_))


FORMAT = Format("MATLAB 5 to 7", (), _recognizes, read_by(_open), open=_open)
