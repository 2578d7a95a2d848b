"""Arrays from NPY and NPZ files of strangers: nothing is unpickled, and sizes are checked before memory is taken."""

from __future__ import annotations

import io
import math
import mmap
import os
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError, MissingExtraError
from varishold.files.opening import LARGEST_BYTES, open_file
from varishold.files.writing import atomic_write

__all__ = [
    "Archive",
    "archive_names",
    "damage_told",
    "let_go",
    "open_archive",
    "open_packed_archive",
    "possible_text",
    "read_npy",
    "write_archive",
]

_MOST_ARRAYS = 1000
# Bytes of the list of members at an archive's end, and of its last record, where that list is announced.
_MOST_LISTED, _END = 1 << 20, struct.Struct("<4s4H2LH")
# A larger array that was packed so tightly holds nothing; frames of a resting sensor reach a tenth of it.
_BOMB_BYTES, _BOMB_RATIO = 1 << 28, 200
# Below this many bytes an archive is compressed; above, writing would take longer than anybody waits.
_COMPRESSED_BYTES = 1 << 26
# A fixed date: the same recording gives the same bytes.
_DATE = (1980, 1, 1, 0, 0, 0)
# What numpy and zipfile raise on damaged files.
_DAMAGED = (
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
    zlib.error,
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
        self._members: dict[str, zipfile.ZipInfo] = {}
        self._unread = set[str]()
        for info in file.infolist():
            name = info.filename.removesuffix(".npy")
            if name in self._members:
                raise FormatError(f"{source}: holds {name!r} twice, and nobody can know which is meant")
            _check_member(f"{source}: array {name!r}", info)
            self._members[name] = info
            self._unread.add(name)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._members)

    @property
    def unread(self) -> tuple[str, ...]:
        """Names of the members that nobody has asked for."""
        return tuple(name for name in self._members if name in self._unread)

    def array(self, name: str) -> NDArray[Any]:
        """Read one array.

        Raises
        ------
        FormatError
            If it is damaged, larger than its file says, or holds pickled objects.
        """
        if name not in self._members:
            raise FormatError(f"{self._source}: holds no array {name!r}")
        self._unread.discard(name)
        info, place = self._members[name], f"{self._source}: array {name!r}"
        with damage_told(place), self._file.open(info) as member:
            array = _array(member, info.file_size, place)
        return possible_text(array) if array.dtype.kind == "U" else array

    def text(self, name: str) -> str:
        """Read one array that holds one text."""
        array = self.array(name)
        if array.size != 1 or array.dtype.kind not in "US":
            raise FormatError(f"{self._source}: {name} must be one text, got {array.dtype} of shape {array.shape}")
        return str(possible_text(array).item())

    def check_rest(self) -> None:
        """Read through what nobody has asked for: who answers from a damaged file may be wrong about the rest too.

        Raises
        ------
        FormatError
            If a member is damaged.
        """
        for name in self.unread:
            with damage_told(f"{self._source}: member {name!r}"), self._file.open(self._members[name]) as member:
                while member.read(1 << 22):
                    pass


def _check_member(place: str, info: zipfile.ZipInfo) -> None:
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise FormatError(f"{place}: is packed in a way that numpy never uses (method {info.compress_type})")
    if info.file_size > max(_BOMB_BYTES, _BOMB_RATIO * info.compress_size):
        raise FormatError(
            f"{place}: would unpack {info.compress_size} bytes to {info.file_size}; nothing measured is so empty"
        )


def possible_text(array: NDArray[Any]) -> NDArray[np.str_]:
    """Return an array of bytes or text as text in which every character can be written to a file.

    Code points that Unicode does not have, halves of surrogate pairs, and bytes that are not UTF-8 become U+FFFD.
    """
    if not array.size or not array.dtype.itemsize:
        return array.astype(np.str_)
    if array.dtype.kind == "S":
        return np.char.decode(array, "utf-8", "replace")
    points = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("=")).view(np.uint32)
    points[(points > 0x10FFFF) | ((points >= 0xD800) & (points <= 0xDFFF))] = 0xFFFD
    return points.view(f"U{array.dtype.itemsize // 4}").reshape(array.shape)


@contextmanager
def open_archive(path: str | os.PathLike[str]) -> Iterator[Archive]:
    """Open an NPZ file; what nobody has read of it when the block ends is still checked for damage.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is damaged, holds a name twice or would unpack to more than `LARGEST_BYTES`.
    """
    with _opened(path) as archive:
        yield archive
        archive.check_rest()


@contextmanager
def open_packed_archive(path: str | os.PathLike[str]) -> Iterator[Archive]:
    """Open an NPZ file of this package, which xz has packed as a whole."""
    try:
        import lzma
    except ImportError as error:
        # A Python built from source where the headers of liblzma were missing.
        raise MissingExtraError(
            f"{os.fspath(path)}: this Python was built without lzma, which unpacks it; use another, as your system's"
        ) from error

    with lzma.open(path) as packed, _archive_in(io.BytesIO(packed.read()), os.fspath(path)) as archive:
        yield archive


@contextmanager
def _opened(path: str | os.PathLike[str]) -> Iterator[Archive]:
    with open_file(path) as file, _archive_in(file, os.fspath(path)) as archive:
        yield archive


@contextmanager
def _archive_in(file: BinaryIO, source: str) -> Iterator[Archive]:
    with damage_told(source):
        _check_list(source, file)
        archive = zipfile.ZipFile(file)
    with archive:
        total = sum(info.file_size for info in archive.infolist())
        if total > LARGEST_BYTES:
            raise FormatError(
                f"{source}: would unpack to {total} bytes; at most {LARGEST_BYTES} are read "
                "(one NPY file may be larger)"
            )
        yield Archive(source, archive)


def _check_list(source: str, file: BinaryIO) -> None:
    """Refuse a list of members that would take long to read."""
    if file.read(2) != b"PK":
        raise FormatError(f"{source}: is no NPZ file: it does not start like an archive")
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - _END.size - 0xFFFF))
    tail = file.read()
    at = tail.rfind(b"PK\x05\x06")
    if at < 0:
        raise FormatError(f"{source}: is damaged or cut off: the list of its members, at its end, is missing")
    _, _, _, _, members, listed, _, comment = _END.unpack_from(tail, at)
    if at + _END.size + comment != len(tail):
        raise FormatError(f"{source}: is damaged or cut off: its end is not where its last record says")
    if members > _MOST_ARRAYS or listed > _MOST_LISTED:
        raise FormatError(f"{source}: holds {members} arrays; at most {_MOST_ARRAYS} are read")


def archive_names(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return the names of the arrays in an NPZ file; none if it cannot be opened as one."""
    try:
        with _opened(path) as archive:
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
    with open_file(path) as file, damage_told(source):
        shape, fortran, dtype = _header(file, source)
        offset = file.tell()
        size = file.seek(0, os.SEEK_END)
        needed = math.prod(shape) * dtype.itemsize
        _check_size(source, size - offset, shape, dtype)
        if needed == 0:
            return np.empty(shape, dtype)
        if isinstance(file, io.BytesIO):
            return np.frombuffer(file.getvalue(), dtype, offset=offset).reshape(shape, order="F" if fortran else "C")
        return np.memmap(file, dtype, "r", offset, shape, "F" if fortran else "C")


def let_go(array: object) -> None:
    """Give back the memory that a mapped file has taken by being read; what is looked at again is read again.

    Parameters
    ----------
    array : ndarray
        Of `read_npy`, or a view of it; of anything else nothing is given back.
    """
    source: Any = array
    while isinstance(source, np.ndarray):
        # Only of a map that nobody can have written to.
        if isinstance(source, np.memmap) and source.mode == "r" and hasattr(mmap, "MADV_DONTNEED"):
            source._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]
            return
        source = source.base


def write_archive(arrays: Mapping[str, NDArray[Any]], path: str | os.PathLike[str], *, kind: str = "recording") -> None:
    """Write arrays as NPZ, whole or not at all, the same bytes for the same arrays.

    Up to 64 MiB are compressed. The archive's comment says what it is, so that its writer knows it again.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    total = sum(array.nbytes for array in arrays.values())
    compression = zipfile.ZIP_DEFLATED if total <= _COMPRESSED_BYTES else zipfile.ZIP_STORED
    with atomic_write(path) as file, zipfile.ZipFile(file, "w", compression) as archive:
        archive.comment = f"varishold {kind}".encode()
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy", _DATE)
            info.compress_type = compression
            with archive.open(info, "w", force_zip64=True) as member:
                npy.write_array(member, np.asanyarray(array), allow_pickle=False)


@contextmanager
def damage_told(place: str) -> Iterator[None]:
    """Tell what a library raises on damaged files as a FormatError, opened by `place`."""
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
        raise FormatError(
            f"{place}: holds pickled objects, which are never loaded; store plain numbers, or text as str"
        )
    if any(side < 0 for side in shape):
        raise FormatError(f"{place}: has a negative length in its shape {shape}")
    return shape, fortran, dtype


def _array(member: IO[bytes], size: int, place: str) -> NDArray[Any]:
    shape, fortran, dtype = _header(member, place)
    needed = math.prod(shape) * dtype.itemsize
    _check_size(place, size - member.tell(), shape, dtype)
    data = bytearray(needed)
    got = 0
    with memoryview(data) as view:
        while got < needed:
            n = member.readinto(view[got : got + (1 << 22)])  # type: ignore[attr-defined]
            if not n:
                raise FormatError(f"{place}: is cut off: {needed} bytes announced, {got} there")
            got += n
    if member.read(1):  # what is read to its end has its checksum compared
        raise FormatError(f"{place}: holds more bytes than the archive says")
    array = np.frombuffer(data, dtype) if needed else np.empty(math.prod(shape), dtype)
    return array.reshape(shape, order="F" if fortran else "C")


def _check_size(place: str, there: int, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
    needed = math.prod(shape) * dtype.itemsize
    if there != needed:
        what = "is cut off" if there < needed else "holds more than it says"
        raise FormatError(f"{place}: {what}: {needed} bytes of {shape} {dtype} announced, {there} there")
