"""Where the pieces of a Zarr array are: each a key of the store, or several in a shard behind an index of places."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import damage_told
from varishold.recording.formats.zarr_codecs import Pipeline
from varishold.recording.formats.zarr_store import Store

__all__ = ["LoosePieces", "Pieces", "ShardedPieces"]

Place = tuple[int, ...]

# In an index: no piece stands there.
_NONE = 2**64 - 1


class Pieces(Protocol):
    """Packed bytes by the place of a piece in the grid of its array."""

    def size(self, place: Place) -> int | None:
        """Return how many bytes a piece is packed to; None where there is none."""
        ...

    def read(self, place: Place, most: int) -> bytes:
        """Return a piece's bytes; raises FormatError where they are more than `most`."""
        ...

    def name(self, place: Place) -> str:
        """Return what a message calls a piece."""
        ...


class LoosePieces:
    """Pieces that are keys of a store.

    Parameters
    ----------
    store : Store
    array : str
        Path of the array.
    keys : (str, str)
        What stands before the numbers of a piece, and between them.
    """

    def __init__(self, store: Store, array: str, keys: tuple[str, str]) -> None:
        self._store, self._array, self._keys = store, array, keys

    def size(self, place: Place) -> int | None:
        return self._store.size(self._key(place))

    def read(self, place: Place, most: int) -> bytes:
        return self._store.read(self._key(place), most)

    def part(self, place: Place, start: int, n_bytes: int) -> bytes:
        """Return so many bytes from `start` on, or as many as there are."""
        return self._store.part(self._key(place), start, n_bytes)

    def name(self, place: Place) -> str:
        return self._store.place(self._key(place))

    def _key(self, place: Place) -> str:
        before, mark = self._keys
        numbers = [before, *map(str, place)] if before else list(map(str, place)) or ["0"]
        return f"{self._array}/{mark.join(numbers)}" if self._array else mark.join(numbers)


class ShardedPieces:
    """Pieces of which several stand in one key, a shard; an index in it says where.

    Parameters
    ----------
    shards : LoosePieces
    counts : tuple of int
        Pieces of a shard along each axis.
    index : Pipeline
        The way from the index's bytes to a place and a size for each piece.
    is_last : bool
        Whether the index stands at the shard's end, not at its beginning.
    """

    def __init__(self, shards: LoosePieces, counts: Place, index: Pipeline, *, is_last: bool) -> None:
        self._shards, self._counts, self._pipeline, self._is_last = shards, counts, index, is_last
        self._found: dict[Place, NDArray[np.uint64] | None] = {}

    def size(self, place: Place) -> int | None:
        found = self._entry(place)
        return None if found is None else found[1]

    def read(self, place: Place, most: int) -> bytes:
        found = self._entry(place)
        start, n_bytes = (0, 0) if found is None else found
        if n_bytes > most:
            raise FormatError(f"{self.name(place)}: is larger than {most} bytes; such a piece never is")
        return self._shards.part(self._shard(place), start, n_bytes)

    def name(self, place: Place) -> str:
        return f"{self._shards.name(self._shard(place))}: piece {', '.join(map(str, place))}"

    def _shard(self, place: Place) -> Place:
        return tuple(at // count for at, count in zip(place, self._counts, strict=True))

    def _entry(self, place: Place) -> tuple[int, int] | None:
        """Return where in its shard a piece begins, and how many bytes it has."""
        shard = self._shard(place)
        if shard not in self._found:
            self._found[shard] = self._index(shard)
        index = self._found[shard]
        if index is None:
            return None
        start, n_bytes = index[tuple(at % count for at, count in zip(place, self._counts, strict=True))].tolist()
        return None if start == n_bytes == _NONE else (start, n_bytes)

    def _index(self, shard: Place) -> NDArray[Any] | None:
        size = self._shards.size(shard)
        if size is None:
            return None
        n_bytes = self._pipeline.n_bytes + self._pipeline.checksum
        with damage_told(self._shards.name(shard)):
            start = size - n_bytes if self._is_last else 0
            if start < 0:
                raise ValueError(f"a shard of {size} bytes has no room for its index of {n_bytes}")
            index = self._pipeline.numbers(self._shards.part(shard, start, n_bytes)).reshape(-1, 2).tolist()
            there = [entry for entry in index if entry != [_NONE, _NONE]]
            if any(sum(entry) > size for entry in there):
                raise ValueError(f"its index says places beyond its {size} bytes")
            if sum(many for _, many in there) > size:
                raise ValueError(f"its index says more than its {size} bytes, some of them twice")
            return np.array(index, np.uint64).reshape(*self._counts, 2)
