"""HDF5: a group a pad, its frames in blocks, what is said of it as attributes; and other people's files.

``/NAME/pressure`` with the attributes ``pitch_m`` and ``polarity``, the masks ``field`` and ``valid`` and the places
``positions_m`` beside it; ``/time_s``, ``/press``, ``/presses/NAME``, ``/signals/NAME``, ``/marks/frame`` and
``/marks/label``; unit and sensor as attributes of the file.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from varishold.recording.formats.episodes import Episodes, in_episodes
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.grouped_arrays import FRAMES, GROUPS, MARK, OF_PAD, arrays_in_groups
from varishold.recording.formats.named_arrays import SIGNALS, arrays_of, stored_in
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.recording import Recording
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.formats.hdf5_writing import Pieces

__all__ = ["FORMAT", "write"]

_MAGIC = b"\x89HDF\r\n\x1a\n"
# The superblock may stand behind something else's head.
_PLACES = (0, 512, 1024, 2048, 4096, 8192, 16384, 32768)
# Which kind of file of this program it is.
_KIND = "recording"
# Bytes of a piece of frames.
_CHUNK = 1 << 18


def _recognizes(path: Path, head: bytes) -> bool:
    return any(head.startswith(_MAGIC, at) for at in _PLACES)


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.hdf5_file import Hdf5File

    file = Hdf5File(path)
    try:
        episodes = Episodes(file)
        arrays, notes = arrays_in_groups(path, episodes, options)
        return in_episodes(stored_in(arrays, path, options, notes=notes, close=file.close), episodes)
    except BaseException:
        file.close()
        raise


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
    from varishold.recording.formats.hdf5_file import WIDTH
    from varishold.recording.formats.hdf5_writing import write_hdf5

    def fill(file: Any, pieces: Pieces) -> None:
        file.attrs[MARK] = np.bytes_(_KIND)
        for name, array in arrays_of(recording).items():
            held = _put(file, name, array, pieces)
            if held is not None and array.dtype.kind == "U":
                held.attrs[WIDTH] = array.dtype.itemsize // 4

    write_hdf5(path, fill)


def _put(file: Any, name: str, array: NDArray[Any], pieces: Pieces) -> Any:
    """Write an array of `named_arrays` where it belongs; return the dataset where it became one that may hold text."""
    kind, _, rest = name.partition(".")
    plain = coded_text(array) if array.dtype.kind == "U" else array
    if name in ("unit", "sensor"):
        file.attrs[name] = plain
    elif kind in ("unit", "names"):
        file[f"signals/{_escaped(rest.removeprefix(SIGNALS))}"].attrs[kind] = plain
    elif kind in (FRAMES, *OF_PAD):
        group = _group(file, _escaped(rest or UNNAMED_PAD))
        if kind in ("pitch_m", "polarity"):
            group.attrs[kind] = plain
        else:
            _put_array(group, kind, plain, pieces)
    else:
        group = {prefix: group for group, prefix in GROUPS.items()}.get(f"{kind}.") if rest else None
        return _put_array(_group(file, group) if group else file, _escaped(rest or kind), plain, pieces)
    return None


def _group(file: Any, name: str) -> Any:
    return file[name] if name in file else file.create_group(name, track_order=True)


def _put_array(group: Any, name: str, array: NDArray[Any], pieces: Pieces) -> Any:
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
    for piece in pieces(len(array), 64 * many):
        held[piece] = array[piece]
    return held


def coded_text(text: NDArray[Any]) -> NDArray[Any]:
    """Return text as UTF-8 of one length, which the file knows for such; it holds no heap then."""
    import h5py

    coded = np.char.encode(text, "utf-8", "replace")
    return coded.astype(h5py.string_dtype("utf-8", max(1, coded.size and coded.dtype.itemsize)))


def _escaped(name: str) -> str:
    """Return a name that can stand in a path, and no group's that is no pad."""
    made = name.replace("%", "%25").replace("/", "%2F")
    if made.strip(".") == "" or made in GROUPS:
        made = f"%{ord(made[0]):02X}{made[1:]}"
    return made


FORMAT = Format("HDF5", (".h5", ".hdf5"), _recognizes, read_by(_open), write, _open)
