"""NPZ: the package's own format, which loses nothing."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from varishold.files import Archive, open_archive, write_archive
from varishold.recording.formats.format import Format, Options
from varishold.recording.formats.named_arrays import arrays_of, stored_in
from varishold.recording.recording import Recording

__all__ = ["FORMAT", "write"]


class _Archived:
    """The arrays of an archive, each of which is read whole."""

    def __init__(self, archive: Archive) -> None:
        self._archive = archive
        self.names, self.array, self.text = archive.names, archive.array, archive.text

    @property
    def unread(self) -> tuple[str, ...]:
        return self._archive.unread

    def column(self, name: str) -> NDArray[Any]:
        return self.array(name)


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith((b"PK\x03\x04", b"PK\x05\x06"))


def _read(path: Path, options: Options) -> Recording:
    with open_archive(path) as archive:
        return stored_in(_Archived(archive), path, options, ordered=True).whole()


def write(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Write a recording as NPZ, whole or not at all; reading it gives the same recording.

    Parameters
    ----------
    recording : Recording
        Values and their types, masks, pitch, time, unit, sensor and presses are kept; `source` and `notes` are not.
    path : str or path-like
        The file; its name should end in ``.npz``.

    Raises
    ------
    InputError
        If it cannot be written there.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> from varishold.recording import Pad, Recording, read, write
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(Recording({"pad": Pad(np.eye(3)[None])}), Path(folder, "one.npz"))
    ...     read(Path(folder, "one.npz")).pads["pad"].shape
    (3, 3)
    """
    # An archive says nothing of polarity: a sensor file does.
    write_archive({n: a for n, a in arrays_of(recording).items() if n.partition(".")[0] != "polarity"}, path)


FORMAT = Format("NumPy archive (NPZ)", (".npz",), _recognizes, _read, write)
