"""A Zarr data set of a stranger, version 2 or 3: its groups and arrays, and parts of an array that are asked for."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import damage_told, parse_json, possible_text
from varishold.recording.formats.zarr_codecs import Pipeline, pipeline_2, pipeline_3
from varishold.recording.formats.zarr_pieces import LoosePieces, Pieces, ShardedPieces
from varishold.recording.formats.zarr_store import Store

__all__ = ["ZarrArray", "ZarrGroups"]

# Bytes of what an array says of itself; groups within groups; what is looked at.
_MOST_SAID, _DEEPEST, _MOST_OBJECTS = 1 << 24, 8, 1 << 14
# Bytes of an array that is no column, and of a piece; pieces of an array; bytes that are kept of the pieces read last.
_SMALL, _LARGEST_PIECE, _MOST_PIECES, _KEPT = 1 << 26, 1 << 26, 1 << 22, 1 << 26
# An array of so many times the bytes of its pieces holds nothing measured, if it is larger than this.
_LARGE, _BOMB_RATIO = 1 << 28, 300
# A piece that is packed to more than it holds, and some bytes for its head, is damaged.
_WORSE, _HEAD = 2, 4096
_DTYPE_2 = re.compile(r"[<>|]([biufUS])(\d{1,5})")
_DTYPES_3 = {
    "bool": "?",
    **{f"{kind}{bits}": f"{kind[0]}{bits // 8}" for kind in ("int", "uint", "float") for bits in (8, 16, 32, 64)},
}
# What an array is called that stands in no group.
_ALONE = "array"
_NUMBERS = {"NaN": np.nan, "Infinity": np.inf, "-Infinity": -np.inf}


class ZarrGroups:
    """The groups and arrays of a data set.

    Parameters
    ----------
    store : Store
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        #: What was not looked into: arrays of objects, times, structs.
        self.passed: list[str] = []

    @cached_property
    def datasets(self) -> dict[tuple[str, ...], ZarrArray]:
        """Every array of numbers or text by its path, groups first.

        Raises
        ------
        FormatError
            If what one says of itself is damaged, or they are nested too deeply.
        """
        return dict(self._arrays((), itertools.count()))

    def _arrays(self, path: tuple[str, ...], seen: Iterator[int]) -> Iterator[tuple[tuple[str, ...], ZarrArray]]:
        if len(path) > _DEEPEST or next(seen) > _MOST_OBJECTS:
            raise FormatError(f"{self._store.source}: holds groups within more than {_DEEPEST} others, or too many")
        said = self._said(path)
        if said is None:
            return
        if "shape" in said:
            array = self._array(path, said)
            if array is None:
                self.passed.append("/".join(path) or _ALONE)
            else:
                yield path or (_ALONE,), array
            return
        for name in self._store.groups("/".join(path)):
            if not name.startswith("."):
                yield from self._arrays((*path, name), seen)

    def _said(self, path: tuple[str, ...]) -> dict[str, Any] | None:
        """Return what a group or an array says of itself; None where nothing is."""
        for name in ("zarr.json", ".zarray", ".zgroup"):
            key = "/".join((*path, name))
            if self._store.size(key) is None:
                continue
            said = self._json(key)
            if name == "zarr.json" and said.get("node_type") == "group":
                said.pop("shape", None)
            return said
        return None

    def _json(self, key: str) -> dict[str, Any]:
        text = self._store.read(key, _MOST_SAID).decode("utf-8", "replace")
        # Zarr 2 writes what JSON has not, where nothing stands.
        text = re.sub(r'("fill_value"\s*:\s*)(NaN|-?Infinity)', r'\1"\2"', text)
        said = parse_json(text, where=self._store.place(key))
        if not isinstance(said, dict):
            raise FormatError(f"{self._store.place(key)}: must be an object, got {type(said).__name__}")
        return said

    def _array(self, path: tuple[str, ...], said: dict[str, Any]) -> ZarrArray | None:
        name = "/".join(path)
        place = f"{self._store.source}: {name or _ALONE}"
        with damage_told(place):
            version = said["zarr_format"]
            if version not in (2, 3):
                raise FormatError(f"{place}: is of version {str(version)[:20]}; 2 and 3 are read")
            dtype = _dtype_2(said["dtype"]) if version == 2 else _dtype_3(said["data_type"])
            if dtype is None:
                return None
            shape = _sides(said["shape"], 0)
            if version == 2:
                pieces, mark, before = _sides(said["chunks"], 1), said.get("dimension_separator") or ".", ""
            else:
                grid, keys = said["chunk_grid"], said["chunk_key_encoding"]
                if grid["name"] != "regular" or keys["name"] not in ("default", "v2"):
                    raise FormatError(f"{place}: has pieces on a grid that is not regular, or names that are not known")
                pieces = _sides(grid["configuration"]["chunk_shape"], 1)
                usual, before = ("/", "c") if keys["name"] == "default" else (".", "")
                mark = (keys.get("configuration") or {}).get("separator", usual)
            if len(pieces) != len(shape) or mark not in ("/", "."):
                raise FormatError(f"{place}: has pieces of {len(pieces)} sides in an array of {len(shape)}")
            if said.get("storage_transformers"):
                raise FormatError(f"{place}: is stored by transformers, which are not read")
            loose = LoosePieces(self._store, name, (before, mark))
            stored: Pieces = loose
            if version == 2:
                pipeline = pipeline_2(place, said, pieces, dtype)
            elif said["codecs"] and said["codecs"][0]["name"] == "sharding_indexed":
                stored, pipeline = _sharded(place, said["codecs"], pieces, dtype, loose)
            else:
                pipeline = pipeline_3(place, said["codecs"], pieces, dtype)
            if pipeline.n_bytes > _LARGEST_PIECE:
                raise FormatError(
                    f"{place}: stands in pieces of {pipeline.n_bytes} bytes; {_LARGEST_PIECE} are the most"
                )
            return ZarrArray(place, shape, pipeline, stored, _fill(said.get("fill_value"), dtype), is_alone=not name)

    def attributes(self, *path: str) -> dict[str, NDArray[Any]]:
        """Return the attributes of the data set, of a group or of an array: those of numbers or text."""
        path = () if path == (_ALONE,) and (_ALONE,) in self.datasets and self.datasets[_ALONE,].is_alone else path
        here = "/".join((*path, "zarr.json"))
        if self._store.size(here) is not None:
            told = self._json(here).get("attributes")
        else:
            old = "/".join((*path, ".zattrs"))
            told = self._json(old) if self._store.size(old) is not None else {}
        found = {}
        for name, value in (told if isinstance(told, dict) else {}).items():
            try:
                array = np.array(value) if isinstance(value, str | int | float | list) else np.empty(0, object)
            except ValueError:
                # Lists of several lengths, or nested too deeply: no part of a recording.
                continue
            if array.dtype.kind in "biufU" and array.nbytes <= _SMALL:
                found[name] = possible_text(array) if array.dtype.kind == "U" else array
        return found


class ZarrArray:
    """An array: a column, of which slices are read.

    Parameters
    ----------
    place : str
        What it is called, for messages.
    shape : tuple of int
    pipeline : Pipeline
        The way from a piece's bytes to its numbers.
    pieces : Pieces
        Those bytes.
    fill : scalar
        What stands where there is no piece.
    is_alone : bool
        Whether it is all of the data set, and no array in a group.
    """

    def __init__(
        self, place: str, shape: tuple[int, ...], pipeline: Pipeline, pieces: Pieces, fill: Any, *, is_alone: bool
    ) -> None:
        self.place, self.shape, self.is_alone = place, shape, is_alone
        self._pipeline, self._pieces, self._fill = pipeline, pieces, fill
        self.dtype: np.dtype[Any] = pipeline.dtype.newbyteorder("=")
        self._last: dict[tuple[int, ...], NDArray[Any]] = {}

    @property
    def is_numbers(self) -> bool:
        return self.dtype.kind in "biuf" and len(self.shape) > 0

    @property
    def missing(self) -> int:
        """How many of its pieces are not there."""
        return self._there[1]

    def check(self) -> None:
        """Check how it is stored.

        Raises
        ------
        FormatError
            If it holds nothing that was measured, or too many pieces.
        """
        n_bytes = math.prod(self.shape) * self.dtype.itemsize
        if n_bytes > max(_LARGE, _BOMB_RATIO * self._there[0]):
            raise FormatError(f"{self.place}: holds {n_bytes} bytes in {self._there[0]}; nothing is so empty")

    @cached_property
    def _there(self) -> tuple[int, int]:
        """Return the bytes of all pieces, and how many are missing."""
        counts = [-(-side // piece) for side, piece in zip(self.shape, self._pipeline.shape, strict=True)]
        # A side without pieces hides how many the others would have.
        most = math.prod(max(1, count) for count in counts)
        if most > _MOST_PIECES:
            raise FormatError(f"{self.place}: stands in {most} pieces; at most {_MOST_PIECES} are read")
        sizes = [self._pieces.size(place) for place in itertools.product(*map(range, counts))]
        found = [size for size in sizes if size is not None]
        return sum(found), len(sizes) - len(found)

    def small(self) -> NDArray[Any]:
        """Read all of an array that is no column: numbers, or text.

        Raises
        ------
        FormatError
            If it is too large for that.
        """
        if math.prod(self.shape) * self.dtype.itemsize > _SMALL:
            raise FormatError(f"{self.place}: has {math.prod(self.shape)} entries; so many are frames only")
        self.check()
        array = self[:] if self.shape else self._piece(()).reshape(())
        return possible_text(array) if array.dtype.kind in "SU" else array

    def __getitem__(self, wanted: slice, /) -> NDArray[Any]:
        """Read some entries along the first axis.

        Raises
        ------
        FormatError
            If a piece is damaged, or unpacks to another size.
        """
        first, last, _ = wanted.indices(self.shape[0])
        last = max(first, last)
        read = np.empty((last - first, *self.shape[1:]), self.dtype)
        if not read.size:
            return read
        sides = self._pipeline.shape
        along = [range(first // sides[0], -(-last // sides[0]))]
        along += [range(-(-side // piece)) for side, piece in zip(self.shape[1:], sides[1:], strict=True)]
        begun = (first, *[0] * (len(sides) - 1))
        for place in itertools.product(*along):
            piece = self._piece(place)
            starts = [number * side for number, side in zip(place, sides, strict=True)]
            # Of the piece, and of what is read: what both have.
            from_, to = [], []
            for at, side, low, many in zip(starts, sides, begun, read.shape, strict=True):
                a, b = max(at, low), min(at + side, low + many)
                from_.append(slice(a - at, b - at))
                to.append(slice(a - low, b - low))
            read[tuple(to)] = piece[tuple(from_)]
        return read

    def _piece(self, place: tuple[int, ...]) -> NDArray[Any]:
        if place in self._last:
            return self._last[place]
        if self._pieces.size(place) is None:
            return np.full(self._pipeline.shape, self._fill, self.dtype)
        with damage_told(self._pieces.name(place)):
            piece = self._pipeline.numbers(self._pieces.read(place, _WORSE * self._pipeline.n_bytes + _HEAD))
        # Who reads onward needs again what he had in part.
        self._last = {k: each for k, each in self._last.items() if k[:1] == place[:1]}
        if (len(self._last) + 1) * self._pipeline.n_bytes <= _KEPT:
            self._last[place] = piece
        return piece


def _sharded(
    place: str, codecs: list[Any], shard: tuple[int, ...], dtype: np.dtype[Any], shards: LoosePieces
) -> tuple[ShardedPieces, Pipeline]:
    """Return the pieces of shards, and the way from their bytes to numbers."""
    how = codecs[0]["configuration"]
    sides = _sides(how["chunk_shape"], 1)
    if len(sides) != len(shard) or any(whole % side for whole, side in zip(shard, sides, strict=True)):
        raise FormatError(f"{place}: has shards of {list(shard)} that {list(sides)} do not fill")
    if len(codecs) > 1 or any(each["name"] == "sharding_indexed" for each in how["codecs"]):
        raise FormatError(f"{place}: packs its shards again, or has shards within shards, which is not read")
    counts = tuple(whole // side for whole, side in zip(shard, sides, strict=True))
    if math.prod(counts) > _MOST_PIECES:
        raise FormatError(f"{place}: has shards of {math.prod(counts)} pieces; at most {_MOST_PIECES} are read")
    index = pipeline_3(place, how["index_codecs"], (*counts, 2), np.dtype("u8"))
    where = how.get("index_location", "end")
    if index.unpack is not None or where not in ("start", "end"):
        raise FormatError(f"{place}: has shards whose index is packed, or stands at {str(where)[:20]!r}")
    return ShardedPieces(shards, counts, index, is_last=where == "end"), pipeline_3(place, how["codecs"], sides, dtype)


def _sides(said: Any, least: int) -> tuple[int, ...]:
    if not isinstance(said, list) or not all(type(side) is int and least <= side < 1 << 48 for side in said):
        raise ValueError(f"sides must be whole numbers from {least} on, got {str(said)[:60]}")
    if len(said) > _DEEPEST:
        raise ValueError(f"it has {len(said)} axes")
    return tuple(said)


def _dtype_2(said: Any) -> np.dtype[Any] | None:
    """Return a type of numbers or text; None of anything else."""
    match = _DTYPE_2.fullmatch(said) if isinstance(said, str) else None
    return np.dtype(said) if match and int(match[2]) else None


def _dtype_3(said: Any) -> np.dtype[Any] | None:
    if isinstance(said, dict) and said.get("name") == "fixed_length_utf32":
        length = said["configuration"]["length_bytes"]
        return np.dtype(f"U{length // 4}") if type(length) is int and 4 <= length < 1 << 16 else None
    kind = _DTYPES_3.get(said) if isinstance(said, str) else None
    return None if kind in (None, "f1") else np.dtype(kind)


def _fill(said: Any, dtype: np.dtype[Any]) -> Any:
    """Return what stands where there is no piece."""
    if dtype.kind in "US" or said is None:
        return np.zeros((), dtype)[()]
    if isinstance(said, str) and said.startswith("0x"):
        return np.array(int(said, 16), f"u{dtype.itemsize}").view(dtype)[()]
    made = np.array(_NUMBERS.get(said, said) if isinstance(said, str) else said)
    if made.shape or made.dtype.kind not in "biuf":
        raise ValueError(f"what stands for nothing there must be a number, got {str(said)[:40]!r}")
    with np.errstate(all="ignore"):
        fill = made.astype(dtype)[()]
    if dtype.kind != "f" and fill != made:
        raise ValueError(f"what stands for nothing there is {str(said)[:40]}, which is no {dtype}")
    return fill
