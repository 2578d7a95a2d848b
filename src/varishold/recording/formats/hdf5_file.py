"""An HDF5 file of a stranger: what may be read of it, each dataset checked before the library is let at its bytes.

The library is C. What it does with a damaged file was tried by `hostile.fuzz`: it refuses, with one exception, a heap
of texts whose entries have no length, through which it goes forever; heaps are therefore walked first. It unpacks
without bounds, opens files that the file names, and loads filters that it names; none of that is let happen.
"""

from __future__ import annotations

import math
import os
import struct
import zlib
from collections.abc import Iterator
from functools import cached_property
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.errors import FormatError
from varishold.files import damage_told, open_file, possible_text

try:
    import h5py
except ModuleNotFoundError as _missing:
    raise missing_extra(_missing) from None

__all__ = ["WIDTH", "Dataset", "Hdf5File", "plain_text"]

#: The attribute of a text that says how many characters its longest may have.
WIDTH = "characters"

# Groups within groups, and objects, that are looked at.
_DEEPEST, _MOST_OBJECTS = 8, 1 << 14
# Bytes of an array that is no column, and of a chunk that is packed.
_SMALL, _LARGEST_CHUNK = 1 << 26, 1 << 26
# A dataset of so many times the bytes of its file holds nothing measured, if it is larger than this.
_LARGE, _BOMB_RATIO = 1 << 28, 300
# Filters that the library brings itself and that keep within bounds.
_DEFLATE, _FLETCHER = 1, 3
_FILTERS = (_DEFLATE, 2, _FLETCHER, 5, 6, 32000)
# A smaller chunk cannot unpack to anything that matters.
_HARMLESS_CHUNK = 1 << 20
# A heap of texts: its mark and version, and what stands before each of its entries.
_HEAP, _HEAP_HEAD, _ENTRY, _BLOCK = b"GCOL\x01", struct.Struct("<4sB3xQ"), struct.Struct("<HHIQ"), 1 << 22


class Hdf5File:
    """An open HDF5 file.

    Parameters
    ----------
    path : str or path-like

    Raises
    ------
    InputError
        If it cannot be opened.
    FormatError
        If it is damaged.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.source = os.fspath(path)
        self._binary = open_file(path)
        self.n_bytes = self._binary.seek(0, os.SEEK_END)
        try:
            with damage_told(self.source):
                self._file = h5py.File(self._binary, "r")
        except BaseException:
            self._binary.close()
            raise
        #: What was not looked into: links to elsewhere, and what nobody can have measured.
        self.passed: list[str] = []

    def close(self) -> None:
        """Let the file go. May be called again."""
        self._file.close()
        self._binary.close()

    @cached_property
    def datasets(self) -> dict[tuple[str, ...], Dataset]:
        """Every dataset of numbers or text by its path, groups first.

        Raises
        ------
        FormatError
            If the file is damaged, or nested too deeply.
        """
        with damage_told(self.source):
            return dict(self._datasets(self._file, (), set()))

    def _datasets(self, group: Any, path: tuple[str, ...], seen: set[int]) -> Iterator[tuple[tuple[str, ...], Dataset]]:
        for name in group:
            here = (*path, name)
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                self.passed.append(f"the link {'/'.join(here)}")
                continue
            held = group[name]
            # The same group may stand under two names, and within itself.
            address = int(h5py.h5o.get_info(held.id).addr)
            if isinstance(held, h5py.Group) and address in seen:
                continue
            seen.add(address)
            if len(here) > _DEEPEST or len(seen) > _MOST_OBJECTS:
                raise FormatError(f"{self.source}: holds groups within more than {_DEEPEST} others, or too many")
            if isinstance(held, h5py.Group):
                yield from self._datasets(held, here, seen)
            elif isinstance(held, h5py.Dataset):
                yield here, Dataset(self, "/".join(here), held)

    def attributes(self, *path: str) -> dict[str, NDArray[Any]]:
        """Return the attributes of the file, of a group or of a dataset: those of numbers or text."""
        with damage_told(f"{self.source}: {'/'.join(path) or 'attributes'}"):
            held = self._file["/".join(path)] if path else self._file
            found = {}
            for name in held.attrs:
                identity = held.attrs.get_id(name)
                if math.prod(identity.shape) * identity.dtype.itemsize > _SMALL:
                    continue
                if self.is_plain(identity.dtype, identity.get_type()):
                    found[name] = plain_text(np.asarray(held.attrs[name]))
            return found

    def is_plain(self, dtype: np.dtype[Any], kind: Any) -> bool:
        """Tell whether something is numbers or text; of text of any length the heap is looked at first."""
        if dtype.kind in "biufS":
            return True
        told = h5py.check_string_dtype(dtype)
        if told is None or not kind.is_variable_str():
            return False
        self._check_heaps()
        return True

    @cached_property
    def _heaps_checked(self) -> bool:
        # The library goes to its place before each read.
        for at in _marks(self._binary, self.n_bytes):
            self._binary.seek(at)
            _, _, size = _HEAP_HEAD.unpack(self._binary.read(_HEAP_HEAD.size))
            content = self._binary.read(min(max(0, size - _HEAP_HEAD.size), _SMALL))
            place = 0
            while place + _ENTRY.size <= len(content):
                number, _, _, length = _ENTRY.unpack_from(content, place)
                if number == 0 and length == 0:
                    raise FormatError(f"{self.source}: is damaged: the heap of texts at byte {at} never ends")
                place += length if number == 0 else _ENTRY.size + length + -length % 8
        return True

    def _check_heaps(self) -> None:
        assert self._heaps_checked


def _marks(file: BinaryIO, n_bytes: int) -> Iterator[int]:
    """Yield where heaps begin."""
    for begun in range(0, n_bytes, _BLOCK):
        file.seek(begun)
        block = file.read(_BLOCK + _HEAP_HEAD.size)
        at = block.find(_HEAP)
        while 0 <= at < _BLOCK and at + _HEAP_HEAD.size <= len(block):
            yield begun + at
            at = block.find(_HEAP, at + 1)


class Dataset:
    """A dataset of an open file: a column, of which slices are read.

    Parameters
    ----------
    file : Hdf5File
    name : str
        Its path, for messages.
    held : h5py.Dataset
    """

    def __init__(self, file: Hdf5File, name: str, held: Any) -> None:
        self._file, self._held = file, held
        self.place = f"{file.source}: {name}"
        with damage_told(self.place):
            self.shape: tuple[int, ...] = tuple(held.shape or ())
            self.dtype: np.dtype[Any] = held.dtype

    @property
    def holds_references(self) -> bool:
        """Whether its entries name other datasets of the file."""
        return h5py.check_ref_dtype(self.dtype) is h5py.Reference

    def references(self) -> Iterator[Any]:
        """Yield the datasets that its entries name, of a small one."""
        with damage_told(self.place):
            for reference in self._held[()].ravel(order="C"):
                found = self._held.file[reference]
                if not isinstance(found, h5py.Dataset):
                    raise FormatError(f"{self.place}: an entry leads to no array")
                yield found

    @property
    def is_numbers(self) -> bool:
        return self.dtype.kind in "biuf" and len(self.shape) > 0

    def check(self) -> None:
        """Check how it is stored.

        Raises
        ------
        FormatError
            If it stands elsewhere, is packed in a way that is not read, or holds nothing that was measured.
        """
        with damage_told(self.place):
            assert self._deflated_chunk >= 0

    @cached_property
    def _deflated_chunk(self) -> int:
        """Check how the dataset is stored, and return the bytes of a chunk of which each must be tried first, or 0."""
        identity, n_bytes = self._held.id, math.prod(self.shape) * self.dtype.itemsize
        plan = identity.get_create_plist()
        if plan.get_layout() == h5py.h5d.VIRTUAL or plan.get_external_count():
            raise FormatError(f"{self.place}: its values stand in another file, which is not opened; copy them into it")
        if n_bytes > max(_LARGE, _BOMB_RATIO * self._file.n_bytes):
            raise FormatError(
                f"{self.place}: holds {n_bytes} bytes in a file of {self._file.n_bytes}; nothing is so empty"
            )
        filters = [plan.get_filter(k)[0] for k in range(plan.get_nfilters())]
        unknown = [
            plan.get_filter(k)[3].decode("utf-8", "replace") or f"filter {f}"
            for k, f in enumerate(filters)
            if f not in _FILTERS
        ]
        if unknown or filters.count(_DEFLATE) > 1:
            raise FormatError(
                f"{self.place}: is packed with {unknown[0] if unknown else 'deflate twice'}, which is not read; "
                "repack it (h5repack -f GZIP=1)"
            )
        if not filters:
            return 0
        chunk = math.prod(plan.get_chunk()) * self.dtype.itemsize
        if chunk > _LARGEST_CHUNK:
            raise FormatError(
                f"{self.place}: is packed in pieces of {chunk} bytes; {_LARGEST_CHUNK} are the most "
                "(h5repack -l CHUNK=)"
            )
        sizes: list[int] = []
        identity.chunk_iter(lambda info: sizes.append(info.size))
        if max(sizes, default=0) > chunk + chunk // 50 + 1024:
            raise FormatError(f"{self.place}: is damaged: a piece of {chunk} bytes is packed into {max(sizes)}")
        return chunk if _DEFLATE in filters and chunk > _HARMLESS_CHUNK else 0

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some entries along the first axis."""
        return self.read(wanted)

    def read(self, *wanted: slice) -> NDArray[Any]:
        """Read a part, by a slice an axis.

        Raises
        ------
        FormatError
            If the dataset is damaged, stands elsewhere, or would unpack to more than it says.
        """
        with damage_told(self.place):
            if self._deflated_chunk:
                self._try_chunks(wanted)
            return np.asarray(self._held[wanted if self.shape else ()])

    def _try_chunks(self, wanted: tuple[slice, ...]) -> None:
        chunks, size = self._held.chunks, self._deflated_chunk
        spans = [s.indices(n)[:2] for s, n in zip(wanted, self.shape, strict=False)]
        spans += [(0, n) for n in self.shape[len(spans) :]]
        steps = [range(a // c * c, b, c) for (a, b), c in zip(spans, chunks, strict=True)]
        for place in np.ndindex(*map(len, steps)):
            at = tuple(step[k] for step, k in zip(steps, place, strict=True))
            info = self._held.id.get_chunk_info_by_coord(at)
            if info.byte_offset is None or info.filter_mask:
                continue
            _, packed = self._held.id.read_direct_chunk(at)
            if len(zlib.decompressobj().decompress(packed, size + 1)) > size:
                raise FormatError(f"{self.place}: a piece of {size} bytes would unpack to more")

    def small(self) -> NDArray[Any]:
        """Read all of a dataset that is no column: numbers, or text.

        Raises
        ------
        FormatError
            If it is too large for that, or is neither.
        """
        with damage_told(self.place):
            if math.prod(self.shape) * self.dtype.itemsize > _SMALL:
                raise FormatError(f"{self.place}: has {math.prod(self.shape)} entries; so many are frames only")
            if not self._file.is_plain(self.dtype, self._held.id.get_type()):
                raise FormatError(f"{self.place}: holds neither numbers nor text")
            array = plain_text(self.read(*[slice(None)] * len(self.shape)))
            width = self._held.attrs.get(WIDTH) if array.dtype.kind == "U" and WIDTH in self._held.attrs else None
            return array.astype(f"U{int(width)}") if width is not None and 0 < width <= 1 << 16 else array


def plain_text(array: NDArray[Any]) -> NDArray[Any]:
    """Return text as text, whichever way it was stored; numbers as they are."""
    if array.dtype.kind == "O":
        array = np.array(
            [each if isinstance(each, bytes) else str(each).encode() for each in array.ravel()], "S"
        ).reshape(array.shape)
    return possible_text(array) if array.dtype.kind in "SU" else array
