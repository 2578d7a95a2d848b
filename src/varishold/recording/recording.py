"""Recordings: the pads of a sensor over some time, with what is known beside them, checked once and for all."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._counted import counted
from varishold._remade import remade
from varishold.errors import InputError, require_a
from varishold.frame.checks import as_given
from varishold.recording.kept import checked_notes, checked_unit, frozen
from varishold.recording.pad import Pad, of_pad, pad_remarks
from varishold.recording.press_table import Mark, PressTable, checked_marks, checked_press, press_remarks, press_table
from varishold.recording.pressure_unit import pascals_per_unit
from varishold.recording.signals import Signals
from varishold.recording.time_unit import no_seconds

__all__ = ["Recording"]


@dataclass(frozen=True, eq=False)
class Recording:
    """What one sensor said over some time, on one pad or several.

    Parameters
    ----------
    pads : mapping of str to Pad
        The pads by name, all with the same number of frames; a pad without a name is called "pad".
    time_s : ndarray of shape (n_frames,), float64, optional
        Device time of each frame, seconds. Default: unknown.
    unit : str
        Unit of the values; "raw" where the sensor has none.
    sensor : str
        What the sensor calls itself; may be empty.
    source : str
        The file that it was read from; may be empty.
    notes : tuple of str
        What the reader of that file had to say about it.
    press : ndarray of shape (n_frames,), int64, optional
        The number of the press that each frame belongs to, -1 for none. Default: unknown.
    press_columns : mapping of str to ndarray of shape (n_presses,)
        What is known of each press by its number, text or numbers; `presses` gives both as a table.
    signals : mapping of str to Signals
        What was measured beside the pads, by name.
    marks : tuple of Mark
        What somebody said was felt from a frame on, rising; the labels of presses that have no numbers.

    Raises
    ------
    InputError
        If there is no pad, or pads and times do not fit together.

    Examples
    --------
    >>> import numpy as np
    >>> recording = Recording({"pad": Pad(np.ones((3, 2, 4)))}, unit="kPa")
    >>> recording.n_frames, recording.pascals_per_unit
    (3, 1000.0)
    >>> recording.remarks
    ('nothing changes: every value of every frame is 1',)
    """

    pads: Mapping[str, Pad]
    time_s: NDArray[np.float64] | None = None
    unit: str = "raw"
    sensor: str = ""
    source: str = ""
    notes: tuple[str, ...] = ()
    press: NDArray[np.int64] | None = None
    press_columns: Mapping[str, NDArray[Any]] = dataclasses.field(default_factory=dict)
    signals: Mapping[str, Signals] = dataclasses.field(default_factory=dict)
    marks: tuple[Mark, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.pads, Mapping):
            raise InputError(f'pads must be by name, as {{"pad": Pad(values)}}, got {type(self.pads).__name__}')
        for what in ("press_columns", "signals"):
            if not isinstance(getattr(self, what), Mapping):
                raise InputError(f"{what} must be by name, got {type(getattr(self, what)).__name__}")
        pads, signals = dict(self.pads), dict(self.signals)
        n_frames = _checked_length(pads, signals)
        object.__setattr__(self, "pads", MappingProxyType(pads))
        object.__setattr__(self, "signals", MappingProxyType(signals))
        object.__setattr__(self, "time_s", _checked_time(self.time_s, n_frames))
        object.__setattr__(self, "unit", checked_unit(self.unit))
        for what in ("sensor", "source"):
            said = getattr(self, what)
            if not isinstance(said, str | os.PathLike):
                raise InputError(f"{what} must be text, got {type(said).__name__}")
            object.__setattr__(self, what, str(said))
        object.__setattr__(self, "notes", checked_notes(self.notes))
        press, columns = checked_press(self.press, self.press_columns, n_frames)
        object.__setattr__(self, "press", press)
        object.__setattr__(self, "press_columns", columns)
        object.__setattr__(self, "marks", checked_marks(self.marks, n_frames))

    __reduce__ = remade

    @property
    def n_frames(self) -> int:
        return next(iter(self.pads.values())).n_frames

    @property
    def presses(self) -> PressTable:
        """Where each press is, and what is known of it; where the recording names none, its runs of loaded frames."""
        return press_table(self)

    @property
    def pascals_per_unit(self) -> float | None:
        """What one unit is in pascal; None where the unit is no known unit of pressure."""
        return pascals_per_unit(self.unit)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is odd about this recording, in words: the reader's notes, its times and presses, then each pad's."""
        found = [*self.notes]
        if self.time_s is not None:
            found += no_seconds(self.time_s)
            back = np.flatnonzero(self.time_s[1:] < self.time_s[:-1])
            if back.size:
                more = f" and {counted(back.size - 1, 'time')} more" if back.size > 1 else ""
                found.append(f"time goes back at frame {int(back[0]) + 1}{more}")
        found += press_remarks(self.press, self.press_columns)
        for name, pad in self.pads.items():
            which = of_pad(name)
            found += [f"{which}{remark}" for remark in pad_remarks(pad)]
        return tuple(found)

    def totals(self) -> NDArray[np.float64]:
        """Return each frame's sum over the usable taxels of all pads, shape (n_frames,)."""
        # Of one pad it is not added up: there may be many frames.
        return reduce(np.add, (pad.totals() for pad in self.pads.values()))


def _checked_length(pads: dict[str, Pad], signals: dict[str, Signals]) -> int:
    """Return the number of frames, which all pads and signals must have."""
    if not pads:
        raise InputError("a recording needs at least one pad, got none")
    for name in (*pads, *signals):
        if not isinstance(name, str) or not name.strip() or not name.isprintable():
            raise InputError(f"a pad's name must be printable text, got {name!r}")
    for name, pad in pads.items():
        require_a(Pad, pad, f"pad {name!r}", "as Pad(values) makes it")
    first, n_frames = next((name, pad.n_frames) for name, pad in pads.items())
    for name, pad in pads.items():
        if pad.n_frames != n_frames:
            raise InputError(
                f"pads must have equally many frames, got {n_frames} of {first!r} and {pad.n_frames} of {name!r}"
            )
    for name, beside in signals.items():
        require_a(Signals, beside, f"signals {name!r}", "as Signals(values) makes them")
        if len(beside.values) != n_frames or name in pads:
            raise InputError(
                f"signals must have a name of their own and a row a frame, got {counted(len(beside.values), 'row')} of "
                f"{name!r} beside {counted(n_frames, 'frame')}"
            )
    return n_frames


def _checked_time(time_s: ArrayLike | None, n_frames: int) -> NDArray[np.float64] | None:
    if time_s is None:
        return None
    must = f"time_s must be one number a frame, shape ({n_frames},)"
    given = as_given(time_s, must)
    if given.dtype.kind not in "iuf" or given.shape != (n_frames,):
        raise InputError(f"{must}, got {given.dtype} of shape {given.shape}")
    time = given.astype(np.float64)
    wrong = np.flatnonzero(~np.isfinite(time))
    if wrong.size:
        raise InputError(f"time_s must be finite, got {time[wrong[0]]} at frame {int(wrong[0])}")
    return frozen(time)
