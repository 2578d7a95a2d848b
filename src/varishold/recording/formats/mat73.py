"""MATLAB 7.3: HDF5 with MATLAB's own notes in it, axes in MATLAB's order; read, and written for MATLAB to load."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError
from varishold.files import possible_text
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.matlab_arrays import Variable, place_of, stored_variables
from varishold.recording.formats.named_arrays import arrays_of
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.formats.hdf5_file import Dataset, Hdf5File
    from varishold.recording.formats.hdf5_writing import Pieces

__all__ = ["FORMAT", "write"]

_MAGIC, _BLOCK = b"MATLAB 7.3 MAT-file", 512
_CLASS, _EMPTY, _DECODE, _FIELDS = "MATLAB_class", "MATLAB_empty", "MATLAB_int_decode", "struct"
# What `named_arrays` calls a variable, how many axes it has there, and its type where MATLAB has no such.
_NAME, _AXES, _TYPE = "varishold_name", "varishold_axes", "varishold_type"
_CLASSES = {"f8": "double", "f4": "single", "b1": "logical"} | {
    f"{kind}{n}": f"{'u' * (kind == 'u')}int{8 * n}" for kind in "iu" for n in (1, 2, 4, 8)
}
_TYPES = re.compile(r"[<>|]([biuf][1248]|U\d{1,5})")
_NUMBERS, _TEXT, _CELL = (*_CLASSES.values(),), "char", "cell"
# Groups in which the library keeps what other variables refer to.
_HIDDEN = ("#refs#", "#subsystem#")
_MOST_CELLS = 1 << 16
# Bytes of a piece of frames.
_CHUNK = 1 << 18


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


class _Held:
    """A variable that stays in the file."""

    def __init__(self, file: Hdf5File, where: tuple[str, ...], dataset: Dataset) -> None:
        self._file, self._dataset = file, dataset
        told = {key: value for key, value in file.attributes(*where).items() if value.size == 1}
        self.kind = str(told[_CLASS].item()) if _CLASS in told else _CLASSES.get(dataset.dtype.str[1:], "")
        self.known_as = str(told[_NAME].item()) if _NAME in told else ""
        self.known_axes = min(max(int(told[_AXES].item()), 0), 3) if _AXES in told else None
        self._type = str(told[_TYPE].item()) if _TYPE in told else ""
        if self._type and not _TYPES.fullmatch(self._type):
            raise FormatError(f"{dataset.place}: {_TYPE} must be a type of numbers or text, got {self._type[:20]!r}")
        self._empty = _EMPTY in told and bool(told[_EMPTY].item())

    @property
    def shape(self) -> tuple[int, ...]:
        if self._empty:
            return tuple(int(side) for side in self._dataset.small().ravel()[:3])
        return self._dataset.shape[::-1]

    @property
    def dtype(self) -> np.dtype[Any]:
        if self.kind in (_TEXT, _CELL):
            return np.dtype(np.str_)
        if self._type:
            return np.dtype(self._type)
        return np.dtype(bool) if self.kind == "logical" else self._dataset.dtype

    def read(self, *wanted: slice) -> NDArray[Any]:
        if self._empty:
            return np.zeros(self.shape, self.dtype)[wanted]
        self._dataset.check()
        return self._dataset.read(*wanted[::-1]).T.astype(self.dtype, copy=False)

    def small(self) -> NDArray[Any]:
        if self.kind == _TEXT:
            return self._text()
        if self.kind == _CELL:
            return self._cell()
        if self._empty:
            return self.read(*[slice(None)] * len(self.shape))
        self._dataset.check()
        return self._dataset.small().T.astype(self.dtype, copy=False)

    def _text(self) -> NDArray[Any]:
        """Return the text of each row."""
        rows = 0 if self._empty else self.shape[0]
        if self._empty:
            texts = [""] * self.shape[0]
        else:
            units = self._dataset.small()
            if units.ndim != 2 or units.dtype.kind != "u":
                raise FormatError(f"{self._dataset.place}: must be characters, got {units.dtype} of {units.shape}")
            coded = np.ascontiguousarray(units.T.astype("<u2"))
            fill = "\0 " if rows > 1 and not self.known_as else "\0"
            texts = [row.tobytes().decode("utf-16-le", "replace").rstrip(fill) for row in coded]
        return possible_text(np.array(texts, self._type if self._type.startswith("<U") else np.str_))

    def _cell(self) -> NDArray[Any]:
        """Return the texts of a cell."""
        from varishold.recording.formats.hdf5_file import Dataset

        if math.prod(self.shape) > _MOST_CELLS:
            raise FormatError(f"{self._dataset.place}: has {math.prod(self.shape)} entries, {_MOST_CELLS} are the most")
        texts = []
        for held in self._dataset.references():
            text = Dataset(self._file, self._dataset.place.rpartition(": ")[2], held)
            units = text.small().ravel() if text.dtype.kind == "u" and held.attrs.get(_EMPTY, 0) == 0 else np.empty(0)
            texts.append(units.astype("<u2").tobytes().decode("utf-16-le", "replace"))
        return possible_text(np.array(texts, np.str_))


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.hdf5_file import Hdf5File

    file = Hdf5File(path)
    try:
        passed: list[str] = []
        variables = dict(_variables(file, passed))
        notes = (f"passed over: {', '.join(passed[:8])}",) if passed else ()
        return stored_variables(path, variables, options, notes=notes, close=file.close)
    except BaseException:
        file.close()
        raise


def _variables(file: Hdf5File, passed: list[str]) -> Iterator[tuple[tuple[str, ...], Variable]]:
    for where, dataset in file.datasets.items():
        if where[0] in _HIDDEN:
            continue
        held = _Held(file, where, dataset)
        if held.kind in (*_NUMBERS, _TEXT) or (held.kind == _CELL and dataset.holds_references):
            yield where, held
        else:
            passed.append(f"{'.'.join(where)} ({held.kind or 'of no known class'})")


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as MATLAB 7.3, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
    path : str or path-like
        The file; its name should end in ``.mat``.

    Raises
    ------
    InputError
        If it cannot be written there.
    MissingExtraError
        If h5py is not installed.
    """
    from varishold.recording.formats.hdf5_writing import write_hdf5

    def fill(file: Any, pieces: Pieces) -> None:
        taken: set[tuple[str, ...]] = set()
        for name, array in arrays_of(recording).items():
            _put(file, place_of(name, taken), name, array, pieces)

    said = _MAGIC + b", Platform: varishold recording, HDF5 schema 1.00 ."
    head = (said.ljust(116) + bytes(8) + b"\x00\x02IM").ljust(_BLOCK, b"\0")
    write_hdf5(path, fill, head=head, userblock_size=_BLOCK)


def _put(file: Any, where: tuple[str, ...], name: str, array: NDArray[Any], pieces: Pieces) -> None:
    *groups, last = where
    group = file
    for each in groups:
        group = group[each] if each in group else group.create_group(each, track_order=True)
        group.attrs[_CLASS] = np.bytes_(_FIELDS)
    plain, kind = _plain(array)
    wide = plain.reshape(*plain.shape, *[1] * (2 - plain.ndim)) if plain.ndim < 2 else plain
    turned = wide.T
    if not wide.size:
        held = group.create_dataset(last, data=np.array(wide.shape, np.uint64))
        held.attrs[_EMPTY] = np.uint8(1)
    elif turned.nbytes < _CHUNK:
        held = group.create_dataset(last, data=turned)
    else:
        many = max(1, min(len(wide), _CHUNK // wide[:1].nbytes))
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        held = group.create_dataset(last, turned.shape, turned.dtype, chunks=(*turned.shape[:-1], many), **packed)
        for piece in pieces(len(wide), 64 * many):
            held[..., piece] = wide[piece].T
    held.attrs[_CLASS] = np.bytes_(kind)
    if kind in ("logical", _TEXT):
        held.attrs[_DECODE] = np.int32(1 if kind == "logical" else 2)
    held.attrs[_NAME], held.attrs[_AXES] = np.bytes_(name.encode()), array.ndim
    if array.dtype.kind == "U" or array.dtype.itemsize != plain.dtype.itemsize or not array.size:
        held.attrs[_TYPE] = np.bytes_(array.dtype.str)


def _plain(array: NDArray[Any]) -> tuple[NDArray[Any], str]:
    """Return an array as MATLAB has it, and what it is called there."""
    if array.dtype.kind == "U":
        rows = [np.frombuffer(each.encode("utf-16-le", "replace"), "<u2") for each in array.ravel().tolist()]
        units = np.zeros((len(rows), max((len(row) for row in rows), default=0)), np.uint16)
        for unit, row in zip(units, rows, strict=True):
            unit[: len(row)] = row
        return units, _TEXT
    if array.dtype.kind == "b":
        return array.astype(np.uint8), "logical"
    if array.dtype.str[1:] not in _CLASSES:
        array = array.astype(np.float32)
    return array, _CLASSES[array.dtype.str[1:]]


FORMAT = Format("MATLAB 7.3", (".mat",), _recognizes, read_by(_open), write, _open)
