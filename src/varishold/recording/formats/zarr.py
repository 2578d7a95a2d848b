"""Zarr, versions 2 and 3, as a folder or a ZIP archive of one: a group a pad, and other people's arrays."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from varishold.recording.formats.episodes import Episodes, in_episodes
from varishold.recording.formats.format import Format, Options, read_by
from varishold.recording.formats.grouped_arrays import arrays_in_groups
from varishold.recording.formats.named_arrays import stored_in
from varishold.recording.stored import Stored

if TYPE_CHECKING:
    from varishold.recording.formats.zarr_arrays import ZarrArray, ZarrGroups
    from varishold.recording.formats.zarr_store import Store

__all__ = ["FOLDER", "FORMAT"]

# What tells a group or an array, and an archive of them by its first members.
_MARKS = (".zgroup", ".zarray", "zarr.json")
_ZIP, _ENDING = b"PK\x03\x04", ".zarr.zip"


def _recognizes(path: Path, head: bytes) -> bool:
    named = path.name.lower().endswith(_ENDING)
    return head.startswith(_ZIP) and (named or any(mark.encode() in head for mark in _MARKS))


def _recognizes_folder(path: Path, head: bytes) -> bool:
    return any((path / mark).is_file() for mark in _MARKS)


def _open(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.zarr_store import ZipStore

    return _stored(path, options, ZipStore(path))


def _open_folder(path: Path, options: Options) -> Stored:
    from varishold.recording.formats.zarr_store import FolderStore

    return _stored(path, options, FolderStore(path))


def _stored(path: Path, options: Options, store: Store) -> Stored:
    from varishold.recording.formats.zarr_arrays import ZarrGroups

    try:
        groups = ZarrGroups(store)
        episodes = Episodes(groups)
        arrays, notes = arrays_in_groups(path, episodes, options)
        stored = stored_in(arrays, path, options, notes=notes, close=store.close)
        return in_episodes(_with_missing(stored, groups), episodes)
    except BaseException:
        store.close()
        raise


def _with_missing(stored: Stored, groups: ZarrGroups) -> Stored:
    """Say which frames nobody has written, which Zarr fills."""
    lacking = [f"{'/'.join(name)} ({each.missing})" for name, each in groups.datasets.items() if _lacks(each, stored)]
    if not lacking:
        return stored
    note = f"pieces are missing and read as what stands for nothing there: {', '.join(lacking[:8])}"
    return dataclasses.replace(stored, notes=(*stored.notes, note))


def _lacks(array: ZarrArray, stored: Stored) -> bool:
    return array.shape[:1] == (stored.n_frames,) and array.missing > 0


FORMAT = Format("Zarr (ZIP)", (), _recognizes, read_by(_open), open=_open)
FOLDER = Format("Zarr (folder)", (), _recognizes_folder, read_by(_open_folder), open=_open_folder, folder=True)
