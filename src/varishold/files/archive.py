"""Arrays from NPY and NPZ files of strangers: nothing is unpickled, and sizes are checked before memory is taken."""

from __future__ import annotations

import lzma
import math
import os
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files.opening import open_file
from varishold.files.writing import atomic_write

__all__ = ["LARGEST_BYTES", "Archive", "archive_names", "open_archive", "read_npy", "write_archive"]

#: Most bytes that the arrays of one archive may take when unpacked. A million frames of 16 x 16 float64 are
#: half of it; whoever has more stores NPY, which is mapped and not loaded.
LARGEST_BYTES = 1 << 32
_MOST_ARRAYS = 1000
# Below this many bytes an archive is compressed; above, writing would take longer than anybody waits.
_COMPRESSED_BYTES = 1 << 26
# A fixed date: the same recording gives the same bytes.
_DATE = (1980, 1, 1, 0, 0, 0)
# What numpy and zipfile raise on damaged files.
_DAMAGED = (
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    tokenize.TokenError,
    EOFError,
    OSError,
    ValueError,
    KeyError,
    IndexError,
    TypeError,
    AttributeError,
    SyntaxError,
    OverflowError,
    RuntimeError,
    NotImplementedError,
    MemoryError,
)


class Archive:
    """The arrays of an open NPZ file, read one at a time."""

    def __init__(self, source: str, file: zipfile.ZipFile) -> None:
        self._source = source
        self._file = file
        self._members = {info.filename.removesuffix(".npy"): info for info in file.infolist()}

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._members)

    def array(self, name: str) -> NDArray[Any]:
        """Read one array.

        Raises
        ------
        FormatError
            If it is damaged, larger than its file says, or holds pickled objects.
        """
        info = self._members[name]
        with _damage_told(f"{self._source}: array {name!r}"), self._file.open(info) as member:
            return _array(member, info.file_size, f"{self._source}: array {name!r}")

    def text(self, name: str) -> str:
        """Read one array that holds one text."""
        array = self.array(name)
        if array.size != 1 or array.dtype.kind not in "US":
            raise FormatError(f"{self._source}: {name} must be one text, got {array.dtype} of shape {array.shape}")
        value = array.reshape(-1)[0]
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


@contextmanager
def open_archive(path: str | os.PathLike[str]) -> Iterator[Archive]:
    """Open an NPZ file.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is damaged or would unpack to more than `LARGEST_BYTES`.
    """
    source = os.fspath(path)
    with open_file(path) as file:
        with _damage_told(source):
            archive = zipfile.ZipFile(file)
        with archive:
            members = archive.infolist()
            total = sum(info.file_size for info in members)
            if len(members) > _MOST_ARRAYS:
                raise FormatError(f"{source}: holds {len(members)} arrays; at most {_MOST_ARRAYS} are read")
            if total > LARGEST_BYTES:
                raise FormatError(
                    f"{source}: would unpack to {total} bytes; at most {LARGEST_BYTES} are read "
                    "(one NPY file may be larger)"
                )
            yield Archive(source, archive)


def archive_names(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return the names of the arrays in an NPZ file; none if it cannot be opened as one."""
    try:
        with open_archive(path) as archive:
            return archive.names
    except InputError:
        return ()


def read_npy(path: str | os.PathLike[str]) -> NDArray[Any]:
    """Map the array of an NPY file into memory, read-only.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is damaged or holds pickled objects.
    """
    source = os.fspath(path)
    with open_file(path) as file, _damage_told(source):
        shape, fortran, dtype = _header(file, source)
        offset, size = file.tell(), os.fstat(file.fileno()).st_size
        needed = math.prod(shape) * dtype.itemsize
        if size - offset < needed:
            raise FormatError(
                f"{source}: is cut off: {needed} bytes of {shape} {dtype} announced, {size - offset} there"
            )
        if needed == 0:
            return np.empty(shape, dtype)
        return np.memmap(file, dtype, "r", offset, shape, "F" if fortran else "C")


def write_archive(arrays: Mapping[str, NDArray[Any]], path: str | os.PathLike[str]) -> None:
    """Write arrays as NPZ, whole or not at all, the same bytes for the same arrays.

    Up to 64 MiB are compressed.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    total = sum(array.nbytes for array in arrays.values())
    compression = zipfile.ZIP_DEFLATED if total <= _COMPRESSED_BYTES else zipfile.ZIP_STORED
    with atomic_write(path) as file, zipfile.ZipFile(file, "w", compression) as archive:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy", _DATE)
            info.compress_type = compression
            with archive.open(info, "w", force_zip64=True) as member:
                npy.write_array(member, np.asanyarray(array), allow_pickle=False)


@contextmanager
def _damage_told(place: str) -> Iterator[None]:
    try:
        yield
    except InputError:
        raise
    except _DAMAGED as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FormatError(f"{place}: is damaged or cut off: {reason[:200]}") from error


def _header(file: IO[bytes], place: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = npy.read_magic(file)
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(version)
    if read is None:
        raise FormatError(f"{place}: has NPY version {version}; known are 1.0 and 2.0")
    with warnings.catch_warnings():
        # numpy warns of headers that old versions wrote, and reads them.
        warnings.simplefilter("ignore")
        shape, fortran, dtype = read(file)
    if dtype.hasobject:
        raise FormatError(f"{place}: holds pickled objects, which are never loaded; store plain numbers")
    if any(side < 0 for side in shape):
        raise FormatError(f"{place}: has a negative length in its shape {shape}")
    return shape, fortran, dtype


def _array(member: IO[bytes], size: int, place: str) -> NDArray[Any]:
    shape, fortran, dtype = _header(member, place)
    needed = math.prod(shape) * dtype.itemsize
    if needed > size:
        raise FormatError(f"{place}: is cut off: {needed} bytes of {shape} {dtype} announced, {size} there")
    data = bytearray(needed)
    got = 0
    with memoryview(data) as view:
        while got < needed:
            n = member.readinto(view[got : got + (1 << 22)])  # type: ignore[attr-defined]
            if not n:
                raise FormatError(f"{place}: is cut off: {needed} bytes announced, {got} there")
            got += n
    array = np.frombuffer(data, dtype) if needed else np.empty(math.prod(shape), dtype)
    return array.reshape(shape, order="F" if fortran else "C")
