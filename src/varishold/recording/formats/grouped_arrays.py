"""Arrays in groups, a group a pad, with attributes on both: HDF5 and Zarr; our own files and other people's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import unquote

from numpy.typing import NDArray

from varishold.recording.formats.format import Options
from varishold.recording.formats.guessing import guessed
from varishold.recording.formats.named_arrays import PRESS, SIGNALS, SINGLE, Dataset, HeldArrays

__all__ = ["FRAMES", "GROUPS", "MARK", "OF_PAD", "GroupedArrays", "Numbers", "arrays_in_groups"]

#: The attribute by which files of this program are known.
MARK = "varishold"
#: What frames are called, and what is said of a pad beside them.
FRAMES = "pressure"
OF_PAD = ("field", "valid", "positions_m", "pitch_m", "polarity", "unit", "sensor")
#: Groups that are no pads, and what the arrays in them are called before their own name.
GROUPS = {"presses": PRESS, "signals": SIGNALS, "marks": "mark."}
# What was passed over that a message names at most.
_TOLD = 8


class Numbers(Dataset, Protocol):
    """An array of a group, which may be no numbers but text."""

    @property
    def is_numbers(self) -> bool: ...


class GroupedArrays(Protocol):
    """An open file of groups."""

    @property
    def passed(self) -> list[str]:
        """What was not looked into."""
        ...

    @property
    def datasets(self) -> Mapping[tuple[str, ...], Numbers]:
        """Every array of numbers or text by its path, groups first."""
        ...

    def attributes(self, *path: str) -> dict[str, NDArray[Any]]:
        """Return the attributes of the file, of a group or of an array."""
        ...


def arrays_in_groups(path: Path, file: GroupedArrays, options: Options) -> tuple[HeldArrays, tuple[str, ...]]:
    """Return what a file holds by the names of `named_arrays`, and what there is to say about it.

    Raises
    ------
    FormatError
        If it holds nothing that can be frames, or is damaged.
    """
    root = file.attributes()
    ours = MARK in root
    datasets, notes = file.datasets, list[str]()
    pads = {where[:-1] for where in datasets if where[-1] == FRAMES and where[0] not in GROUPS}
    said = {name: value for name, value in root.items() if name in OF_PAD}
    if not pads:
        keys, told = guessed(path, {"/".join(w): d for w, d in datasets.items() if d.is_numbers}, options)
        by_place = {"/".join(where): dataset for where, dataset in datasets.items()}
        held: dict[str, Dataset] = {key: by_place[place] for key, place in keys.items()}
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
            key = _name((*pad, FRAMES), pads, ours)
            said |= _said({**(file.attributes(*pad) if pad else {}), **file.attributes(*pad, FRAMES)}, key)
    if file.passed:
        notes.append(f"passed over: {', '.join(file.passed[:_TOLD])}" + (", ..." if len(file.passed) > _TOLD else ""))
    return HeldArrays(held, said), tuple(notes)


def _said(attributes: Mapping[str, NDArray[Any]], key: str) -> dict[str, NDArray[Any]]:
    """Return what attributes say of a pad; the unit and the sensor are the recording's."""
    end = key.removeprefix(SINGLE)
    return {
        name if name in ("unit", "sensor") else f"{name}{end}": value
        for name, value in attributes.items()
        if name in OF_PAD
    }


def _name(where: tuple[str, ...], pads: set[tuple[str, ...]], ours: bool) -> str:
    """Return what `named_arrays` calls the dataset at a place."""
    *groups, last = (unquote(part) for part in where) if ours else where
    if where[:-1] in pads and last in (FRAMES, *OF_PAD):
        called = "/".join(groups)
        return f"{last}.{called}" if called else last
    if len(where) == 2 and where[0] in GROUPS:
        return f"{GROUPS[where[0]]}{last}"
    return "/".join((*groups, last))
