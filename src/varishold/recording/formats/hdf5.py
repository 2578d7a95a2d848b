"""HDF5: a group a pad, its frames in blocks, what is said of it as attributes; and other people's files.

``/NAME/pressure`` with the attributes ``pitch_m`` and ``polarity``, the masks ``field`` and ``valid`` and the places
``positions_m`` beside it; ``/time_s``, ``/press``, ``/presses/NAME``, ``/signals/NAME``, ``/marks/frame`` and
``/marks/label``; unit and sensor as attributes of the file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from varishold._lazy import missing_extra
from varishold.files import atomic_write
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.named_arrays import PRESS, SIGNALS, SINGLE, HeldArrays, arrays_of, stored_in
from varishold.recording.recording import UNNAMED_PAD, Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.formats.hdf5_file import Hdf5File

__all__ = ["FORMAT", "write"]

_MAGIC = b"\x89HDF\r\n\x1a\n"
# The superblock may stand behind something else's head.
_PLACES = (0, 512, 1024, 2048, 4096, 8192, 16384, 32768)
# The attribute by which files of this program are known, and of which kind they are.
_MARK, _KIND = "varishold", "recording"
_FRAMES = "pressure"
# What is said of a pad beside its frames.
_OF_PAD = ("field", "valid", "positions_m", "pitch_m", "polarity", "unit", "sensor")
# Groups that are no pads, and what the arrays in them are called before their own name.
_GROUPS = {"presses": PRESS, "signals": SIGNALS, "marks": "mark."}
# Bytes of a piece of frames.
_CHUNK = 1 << 18


def _recognizes(path: Path, head: bytes) -> bool:
    return any(head.startswith(_MAGIC, at) for at in _PLACES)


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.hdf5_file import Hdf5File

    file = Hdf5File(path)
    try:
        arrays, notes = _arrays(path, file, options)
        return stored_in(arrays, path, options, notes=notes, close=file.close)
    except BaseException:
        file.close()
        raise


def _arrays(path: Path, file: Hdf5File, options: Options) -> tuple[HeldArrays, tuple[str, ...]]:
    """Return what a file holds by the names of `named_arrays`, and what there is to say about it."""
    root = file.attributes()
    ours = _MARK in root
    datasets, notes = file.datasets, list[str]()
    pads = {where[:-1] for where in datasets if where[-1] == _FRAMES and where[0] not in _GROUPS}
    said = {name: value for name, value in root.items() if name in _OF_PAD}
    if not pads:
        keys, told = guessed(path, {"/".join(w): d for w, d in datasets.items() if d.is_numbers}, options)
        by_place = {"/".join(where): dataset for where, dataset in datasets.items()}
        held = {key: by_place[place] for key, place in keys.items()}
        notes += told
        for key, place in keys.items():
            said |= _said(file.attributes(*place.split("/")), key)
    else:
        held = {}
        for where, dataset in datasets.items():
            name = _name(where, pads, ours)
            held[name] = dataset
            if name.startswith(SIGNALS):
                said |= {f"{k}.{name}": v for k, v in file.attributes(*where).items() if k in ("unit", "names")}
        for pad in pads:
            key = _name((*pad, _FRAMES), pads, ours)
            said |= _said({**(file.attributes(*pad) if pad else {}), **file.attributes(*pad, _FRAMES)}, key)
    if file.passed:
        notes.append(f"passed over: {', '.join(file.passed[:8])}" + (", ..." if len(file.passed) > 8 else ""))
    return HeldArrays(held, said), tuple(notes)


def _said(attributes: Mapping[str, NDArray[Any]], key: str) -> dict[str, NDArray[Any]]:
    """Return what attributes say of a pad; the unit and the sensor are the recording's."""
    end = key.removeprefix(SINGLE)
    return {
        name if name in ("unit", "sensor") else f"{name}{end}": value
        for name, value in attributes.items()
        if name in _OF_PAD
    }


def _name(where: tuple[str, ...], pads: set[tuple[str, ...]], ours: bool) -> str:
    """Return what `named_arrays` calls the dataset at a place."""
    *groups, last = (unquote(part) for part in where) if ours else where
    if where[:-1] in pads and last in (_FRAMES, *_OF_PAD):
        called = "/".join(groups)
        return f"{last}.{called}" if called else last
    if len(where) == 2 and where[0] in _GROUPS:
        return f"{_GROUPS[where[0]]}{last}"
    return "/".join((*groups, last))


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as HDF5, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
    path : str or path-like
        The file; its name should end in ``.h5`` or ``.hdf5``.

    Raises
    ------
    InputError
        If it cannot be written there.
    MissingExtraError
        If h5py is not installed.
    """
    try:
        import h5py
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    from varishold.recording.formats.hdf5_file import WIDTH

    with atomic_write(path) as binary, h5py.File(binary, "w", track_order=True) as file:
        file.attrs[_MARK] = np.bytes_(_KIND)
        for name, array in arrays_of(recording).items():
            held = _put(file, name, array)
            if held is not None and array.dtype.kind == "U":
                held.attrs[WIDTH] = array.dtype.itemsize // 4


def _put(file: Any, name: str, array: NDArray[Any]) -> Any:
    """Write an array of `named_arrays` where it belongs; return the dataset where it became one that may hold text."""
    kind, _, rest = name.partition(".")
    plain = coded_text(array) if array.dtype.kind == "U" else array
    if name in ("unit", "sensor"):
        file.attrs[name] = plain
    elif kind in ("unit", "names"):
        file[f"signals/{_escaped(rest.removeprefix(SIGNALS))}"].attrs[kind] = plain
    elif kind in (_FRAMES, *_OF_PAD):
        group = _group(file, _escaped(rest or UNNAMED_PAD))
        if kind in ("pitch_m", "polarity"):
            group.attrs[kind] = plain
        else:
            _put_array(group, kind, plain)
    else:
        group = {prefix: group for group, prefix in _GROUPS.items()}.get(f"{kind}.") if rest else None
        return _put_array(_group(file, group) if group else file, _escaped(rest or kind), plain)
    return None


def _group(file: Any, name: str) -> Any:
    return file[name] if name in file else file.create_group(name, track_order=True)


def _put_array(group: Any, name: str, array: NDArray[Any]) -> Any:
    entry = max(1, array[:1].nbytes) if array.ndim else 1
    if array.nbytes < _CHUNK:
        return group.create_dataset(name, data=array)
    many = max(1, min(len(array), _CHUNK // entry))
    held = group.create_dataset(
        name,
        array.shape,
        array.dtype,
        chunks=(many, *array.shape[1:]),
        compression="gzip",
        compression_opts=1,
        shuffle=True,
    )
    for begun in range(0, len(array), 64 * many):
        held[begun : begun + 64 * many] = array[begun : begun + 64 * many]
    return held


def coded_text(text: NDArray[Any]) -> NDArray[Any]:
    """Return text as UTF-8 of one length, which the file knows for such; it holds no heap then."""
    import h5py

    coded = np.char.encode(text, "utf-8", "replace")
    return coded.astype(h5py.string_dtype("utf-8", max(1, coded.dtype.itemsize)))


def _escaped(name: str) -> str:
    """Return a name that can stand in a path, and no group's that is no pad."""
    made = name.replace("%", "%25").replace("/", "%2F")
    if made.strip(".") == "" or made in _GROUPS:
        made = f"%{ord(made[0]):02X}{made[1:]}"
    return made


FORMAT = Format("HDF5", (".h5", ".hdf5"), _recognizes, read_by(_open), write, _open)
