"""What a piece of a Zarr array went through before it was written, and the way back, of versions 2 and 3.

Only a short list of packers is undone; a piece never unpacks to more than the array's own words say.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.recording.formats.blosc import from_blosc, unshuffled
from varishold.recording.formats.packings import from_gzip, from_sized_lz4, from_zlib, from_zstd

__all__ = ["Pipeline", "pipeline_2", "pipeline_3"]

Unpack = Callable[[bytes, int], bytes]

# What is undone, by the names that both versions have for it; a piece that is packed twice is refused.
_PACKERS: Mapping[str, Unpack] = {"gzip": from_gzip, "zstd": from_zstd, "blosc": from_blosc}
_PACKERS_2: Mapping[str, Unpack] = {**_PACKERS, "zlib": from_zlib, "lz4": from_sized_lz4}
_CHECKSUM = 4
_ORDERS: Mapping[str, Literal["<", ">"]] = {"little": "<", "big": ">"}


@dataclass(frozen=True)
class Pipeline:
    """The way from a piece's bytes to its numbers.

    Parameters
    ----------
    shape : tuple of int
        Of a piece.
    dtype : dtype
        With its byte order.
    axes : tuple of int
        Which axis of the piece each axis of what is stored is.
    unpack : callable, optional
        Undoes the packer.
    checksum : int
        Bytes at the end that are no numbers, within the packed bytes or behind them.
    packed_checksum : int
    shuffled : int
        Bytes of a number whose bytes stand apart; 0 where they do not.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    axes: tuple[int, ...]
    unpack: Unpack | None = None
    checksum: int = 0
    packed_checksum: int = 0
    shuffled: int = 0

    @property
    def n_bytes(self) -> int:
        """Bytes of a piece that is not packed."""
        return int(np.prod(self.shape, dtype=object)) * self.dtype.itemsize

    def numbers(self, data: bytes) -> NDArray[Any]:
        """Return the numbers of a piece.

        Raises
        ------
        ValueError
            If it is damaged, or holds another number of them.
        """
        wanted = self.n_bytes + self.checksum
        data = data[: len(data) - self.packed_checksum] if self.packed_checksum else data
        if self.unpack is not None:
            data = self.unpack(data, wanted)
        if len(data) != wanted:
            raise ValueError(f"it unpacks to {len(data)} bytes, {wanted} are announced")
        data = data[: self.n_bytes]
        if self.shuffled:
            data = unshuffled(data, self.shuffled)
        stored = np.frombuffer(data, self.dtype).reshape([self.shape[axis] for axis in self.axes])
        return stored.transpose(np.argsort(self.axes))


def pipeline_2(place: str, said: Mapping[str, Any], shape: tuple[int, ...], dtype: np.dtype[Any]) -> Pipeline:
    """Return the pipeline that ``.zarray`` says.

    Raises
    ------
    FormatError
        If it names a packer that is not undone.
    """
    packer, filters = said.get("compressor"), said.get("filters") or []
    shuffled = 0
    for each in filters:
        if each["id"] != "shuffle" or len(filters) > 1:
            raise _unknown(place, each["id"])
        shuffled = int(each.get("elementsize", 4))
        if not 1 <= shuffled <= 16:
            raise FormatError(f"{place}: shuffles numbers of {shuffled} bytes")
    if packer is not None and packer["id"] not in _PACKERS_2:
        raise _unknown(place, packer["id"])
    if said["order"] not in ("C", "F"):
        raise FormatError(f"{place}: order must be C or F, got {str(said['order'])[:20]!r}")
    axes = tuple(range(len(shape)))
    return Pipeline(
        shape,
        dtype,
        axes if said["order"] == "C" else axes[::-1],
        None if packer is None else _PACKERS_2[packer["id"]],
        shuffled=shuffled,
    )


def pipeline_3(place: str, codecs: Sequence[Any], shape: tuple[int, ...], dtype: np.dtype[Any]) -> Pipeline:
    """Return the pipeline that the codecs of ``zarr.json`` say.

    Raises
    ------
    FormatError
        If one is not undone, or they stand in an order that makes no sense.
    """
    axes = tuple(range(len(shape)))
    unpack: Unpack | None = None
    checksums = [0, 0]
    order: Literal["<", ">"] | None = None
    for each in codecs:
        name, how = each["name"], each.get("configuration") or {}
        if name == "transpose" and not order:
            turned = how["order"]
            turned = {"C": list(range(len(shape))), "F": list(range(len(shape)))[::-1]}.get(str(turned), turned)
            if sorted(turned) != list(range(len(shape))):
                raise FormatError(f"{place}: turns axes by {str(turned)[:60]}, which is no order of {len(shape)}")
            axes = tuple(axes[k] for k in turned)
        elif name == "bytes" and not order:
            order = _ORDERS[how.get("endian", "little")]
        elif name == "crc32c" and order:
            checksums[unpack is not None] += _CHECKSUM
        elif name in _PACKERS and order and unpack is None:
            unpack = _PACKERS[name]
        else:
            raise _unknown(place, name)
    if order is None:
        raise _unknown(place, "nothing that makes bytes of numbers")
    if unpack is None:
        checksums = [sum(checksums), 0]
    return Pipeline(shape, dtype.newbyteorder(order), axes, unpack, *checksums)


def _unknown(place: str, name: Any) -> FormatError:
    return FormatError(
        f"{place}: is packed by {str(name)[:40]}, which is not read here; copy it with zstd, gzip or blosc"
    )
