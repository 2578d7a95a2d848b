"""Presses with their labels and sessions, from recordings of one sensor."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold._name import plain_name
from varishold.errors import InputError
from varishold.recording import Recording
from varishold.recording.mended import without_faults
from varishold.touch.course.one_sensor import check_same_pads
from varishold.touch.course.presses import Press, cut_presses

__all__ = ["FOLDER", "LabelledPresses", "labelled_presses"]

#: The label, or group, that is the name of the folder in which a recording lies.
FOLDER = "folder"
# Each time that this stands behind it, it is the folder around.
_OUTER = "/.."


@dataclass(frozen=True, eq=False)
class LabelledPresses:
    """Presses to learn from, or to be tested on.

    Parameters
    ----------
    presses : list of Press
    labels : ndarray of shape (n,), str
    groups : ndarray of shape (n,), str, optional
        The session of each; None where none was asked for.
    """

    presses: list[Press]
    labels: NDArray[np.str_]
    groups: NDArray[np.str_] | None

    def __len__(self) -> int:
        return len(self.presses)


def labelled_presses(recordings: Sequence[Recording], *, label: str, group: str | None = None) -> LabelledPresses:
    """Return all presses of some recordings with their labels; readings that stand alone are replaced first.

    Parameters
    ----------
    recordings : sequence of Recording
        Of one sensor.
    label, group : str
        A column of the presses, or ``folder`` for the name of the folder in which a recording lies, ``folder/..`` for
        that of the folder around it.

    Raises
    ------
    InputError
        Naming the file that has no such column or one entry a frame in it, other pads than the first, or no press.
    """
    presses: list[Press] = []
    labels: list[str] = []
    groups: list[str] = []
    for recording in recordings:
        cut = cut_presses(without_faults(recording))
        presses += cut
        check_same_pads([presses[0], cut[0]], common=True)
        labels += _column(recording, label, len(cut), "label")
        if group is not None:
            groups += _column(recording, group, len(cut), "group")
    return LabelledPresses(presses, np.array(labels), None if group is None else np.array(groups))


def _check_a_press_each(recording: Recording, name: str, parameter: str) -> None:
    """Refuse a column that says something of each frame: its first entries are not those of the presses."""
    given, press = recording.press_columns.get(name), recording.press
    if given is None or press is None:
        return
    n_presses = int(press.max(initial=-1)) + 1
    if len(given) == recording.n_frames > n_presses:
        raise InputError(
            f"{recording.source}: press.{name} has an entry for each of {counted(len(given), 'frame')}; "
            f"give one for each of the {counted(n_presses, 'press')}",
            parameter=parameter,
        )


def _name(text: str) -> str | None:
    """Return a name with one sign a letter, as keyboards write it: some file systems part the mark from the letter."""
    return plain_name(unicodedata.normalize("NFC", text))


def _column(recording: Recording, name: str, n_presses: int, parameter: str) -> list[str]:
    outer = name.removeprefix(FOLDER)
    if name.startswith(FOLDER) and outer == _OUTER * (len(outer) // len(_OUTER)):
        folder = Path(os.path.abspath(f"{recording.source}/..{outer}")).name
        return [_name(folder) or folder] * n_presses
    columns = recording.presses.columns
    _check_a_press_each(recording, name, parameter)
    if name not in columns:
        known = (
            f"{', '.join(columns)}; name one of these, or 'folder'" if columns else "none; 'folder' names each file's"
        )
        raise InputError(
            f"{recording.source or 'the recording'}: presses have no column {name!r}, known are: {known}",
            parameter=parameter,
        )
    texts = list[str]()
    for k, value in enumerate(columns[name]):
        text = _name(str(value))
        if text is None and str(value).strip():
            raise InputError(
                f"{recording.source}: press {k}: {name} must be a line of printable text, got {str(value)[:60]!r}"
            )
        if text is None or text == "nan":
            raise InputError(f"{recording.source}: press {k} has no {name}; fill it in, or leave the press out")
        texts.append(text)
    return texts
