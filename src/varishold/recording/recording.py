"""Pads and recordings: a sensor's frames with masks, pitch, unit and time, checked once and for all."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold._remade import remade
from varishold.errors import InputError, require_a
from varishold.files import let_go
from varishold.frame.checks import as_given, as_mask, as_numbers, as_pitch, as_usable, as_valid
from varishold.frame.doubts import doubts_of
from varishold.frame.health import Extent, broken_taxels, extent_of, remarks_of
from varishold.frame.holes import hole_share
from varishold.frame.slow_drift import slow_drift
from varishold.frame.taxels_apart import spacing_of
from varishold.recording.press_table import Mark, PressTable, checked_marks, checked_press, press_remarks, press_table
from varishold.recording.pressure_unit import pascals_per_unit
from varishold.recording.time_unit import no_seconds

__all__ = ["UNNAMED_PAD", "Pad", "Recording", "Signals", "far_apart", "frame_of"]

#: The name of a pad that has none.
UNNAMED_PAD = "pad"

# Bytes of frames that are looked at together when a whole recording is gone through.
_BLOCK = 1 << 24
# No skin's taxels are farther apart.
_FARTHEST_M = 0.1


@dataclass(frozen=True, eq=False)
class Pad:
    """One pad's frames, where it has taxels, and which of them work.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols), integer or float
        Larger is more pressure, in the recording's unit. The type is kept, a memory map stays one, and the
        array that the pad shows is read-only. Negative values are noise; NaN may stand only where `field` or
        `valid` is False. Truth values become uint8.
    field : ndarray of shape (rows, cols), bool, optional
        False where there is no taxel: outside the region R, never filled. Default: taxels everywhere.
    valid : ndarray of shape (rows, cols), bool, optional
        False where a taxel is broken. Default: all work.
    pitch_m : (float, float), optional
        Row spacing and column spacing, metres; a single number stands for both. Default: unknown.
    positions_m : ndarray of shape (n_taxels, 2), float64, optional
        (x, y) of each taxel where they stand on no grid; the frames are then one row of taxels.
    polarity : {"up", "down"}
        "down" where smaller is more pressure; such frames are to be turned by a sensor file before anything else.
    notes : tuple of str
        What was done to the frames, in words.

    Raises
    ------
    InputError
        If shapes, types or values do not fit, or the frames go up and are mostly negative.

    Examples
    --------
    >>> import numpy as np
    >>> pad = Pad(np.zeros((3, 2, 4), np.uint16), pitch_m=(0.002, 0.001))
    >>> pad.n_frames, pad.shape
    (3, (2, 4))
    """

    frames: NDArray[Any]
    field: NDArray[np.bool_] | None = None
    valid: NDArray[np.bool_] | None = None
    pitch_m: tuple[float, float] | None = None
    positions_m: NDArray[np.float64] | None = None
    polarity: Literal["up", "down"] = "up"
    notes: tuple[str, ...] = ()
    #: What is odd about the values, in words: dead, stuck and saturated taxels, no change at all.
    remarks: tuple[str, ...] = dataclasses.field(default=(), init=False, repr=False)
    extent: Extent = dataclasses.field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.polarity, str) or self.polarity not in ("up", "down"):
            raise InputError(f"polarity must be up or down, got {self.polarity!r}", parameter="polarity")
        frames = _checked_frames(self.frames)
        shape = frames.shape[1:]
        field = _kept(as_mask(self.field, shape, "field"))
        valid = _kept(as_valid(self.frames, self.valid, shape))
        usable = as_usable(frames, shape, field, valid)
        if not usable.any():
            raise InputError(f"no taxel of {shape[0]} x {shape[1]} is both in field and valid")
        extent = extent_of(_blocks(frames), usable, signed=self.polarity == "down")
        object.__setattr__(self, "frames", frames)
        object.__setattr__(self, "field", field)
        object.__setattr__(self, "valid", valid)
        object.__setattr__(self, "pitch_m", None if self.pitch_m is None else as_pitch(self.pitch_m))
        object.__setattr__(self, "positions_m", _checked_positions(self.positions_m, shape))
        object.__setattr__(self, "notes", _checked_notes(self.notes))
        object.__setattr__(self, "extent", extent)
        object.__setattr__(self, "remarks", remarks_of(extent, usable, frames.dtype, frames.shape[0]))

    @property
    def n_frames(self) -> int:
        return int(self.frames.shape[0])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return int(self.frames.shape[1]), int(self.frames.shape[2])

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Where there is a taxel and it works: shape (rows, cols), bool."""
        return as_usable(self.frames, self.shape, self.field, self.valid)

    @property
    def broken(self) -> NDArray[np.bool_]:
        """Where a usable taxel shows by its values that it is dead or stuck: shape (rows, cols), bool."""
        return broken_taxels(self.extent, self.usable, self.frames.dtype, self.n_frames)

    def totals(self) -> NDArray[np.float64]:
        """Return each frame's sum over the usable taxels, shape (n_frames,), in the recording's unit."""
        usable = self.usable.ravel()
        totals = np.empty(self.n_frames)
        for start, block in _blocks(self.frames):
            flat = block.reshape(block.shape[0], -1)
            if not usable.all():
                flat = flat[:, usable]
            totals[start : start + block.shape[0]] = flat.sum(axis=1, dtype=np.float64)
        return totals


@dataclass(frozen=True, eq=False)
class Signals:
    """Numbers beside the pads that are no pressure: shear, temperatures, magnetometers.

    Parameters
    ----------
    values : ndarray of shape (n_frames, n_signals), integer or float
        In their own type, NaN where one is not known.
    names : tuple of str
        What each is called; may be empty.
    unit : str

    Raises
    ------
    InputError
        If the values are no such numbers, or there are not as many names.
    """

    values: NDArray[Any]
    names: tuple[str, ...] = ()
    unit: str = "raw"

    def __post_init__(self) -> None:
        values = _frozen(as_numbers(self.values, 2, "signals", masked=True).view())
        names = tuple(str(name) for name in self.names)
        if names and len(names) != values.shape[1]:
            raise InputError(f"signals must have a name each, got {len(names)} names of {values.shape[1]}")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "unit", _checked_unit(self.unit))


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
        object.__setattr__(self, "unit", _checked_unit(self.unit))
        for what in ("sensor", "source"):
            said = getattr(self, what)
            if not isinstance(said, str | os.PathLike):
                raise InputError(f"{what} must be text, got {type(said).__name__}")
            object.__setattr__(self, what, str(said))
        object.__setattr__(self, "notes", _checked_notes(self.notes))
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
                more = f" and {back.size - 1} times more" if back.size > 1 else ""
                found.append(f"time goes back at frame {int(back[0]) + 1}{more}")
        found += press_remarks(self.press, self.press_columns)
        for name, pad in self.pads.items():
            which = "" if name == UNNAMED_PAD else f"pad {name}: "
            found += [f"{which}{remark}" for remark in _pad_remarks(pad)]
        return tuple(found)

    def totals(self) -> NDArray[np.float64]:
        """Return each frame's sum over the usable taxels of all pads, shape (n_frames,)."""
        # Of one pad it is not added up: there may be many frames.
        return reduce(np.add, (pad.totals() for pad in self.pads.values()))


def _pad_remarks(pad: Pad) -> Iterator[str]:
    """Yield what is odd about a pad: what its reader and its values say, then what all of its frames show."""
    yield from (*pad.notes, *pad.remarks)
    drift = slow_drift(pad.frames, pad.usable)
    if drift is not None:
        yield (
            f"the rest drifts by {drift[0]:.3g} in all, {drift[1]:.0%} of what is read: it is taken off "
            "where frames without a press show it; varishold live replay:FILE follows the rest of each taxel"
        )
    holes = hole_share(pad.frames, pad.usable) if pad.polarity == "down" else 0.0
    if holes:
        yield (
            f"{holes:.2g} of all readings are exactly 0, far below the others: where a camera sees "
            "nothing? fill them with what is near, or they are deep presses"
        )
    yield from far_apart(pad.pitch_m, pad.positions_m)
    yield from doubts_of(pad.frames, pad.usable)


def far_apart(pitch_m: tuple[float, float] | None, positions_m: NDArray[np.float64] | None = None) -> list[str]:
    """Say where taxels, on a grid or at positions, are farther apart than those of any skin."""
    told = []
    if pitch_m is not None and max(pitch_m) > _FARTHEST_M:
        told.append(f"taxels are {max(pitch_m):g} m apart: is the pitch in millimetres?")
    if positions_m is not None and len(positions_m) > 1:
        spacing = spacing_of(positions_m)
        if spacing > _FARTHEST_M:
            told.append(f"taxels are {spacing:.3g} m apart: are positions_m in millimetres?")
    return told


def frame_of(pad: Pad, index: int) -> NDArray[np.float64]:
    """Return one frame of a pad as a new array of shape (rows, cols), float64.

    Raises
    ------
    InputError
        If there is no such frame.
    """
    if not 0 <= index < pad.n_frames:
        raise InputError(f"there is no frame {index}: frames are numbered 0 to {pad.n_frames - 1}")
    return np.array(pad.frames[index], dtype=np.float64, order="C")


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
                f"signals must have a name of their own and a row a frame, got {len(beside.values)} rows of "
                f"{name!r} beside {n_frames} frames"
            )
    return n_frames


def _checked_positions(positions: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    if positions is None:
        return None
    must = f"positions_m must be finite (x, y) of each of {shape[1]} taxels in one row, shape ({shape[1]}, 2)"
    array = as_given(positions, must)
    if array.dtype.kind not in "iuf" or array.shape != (shape[1], 2) or shape[0] != 1 or not np.isfinite(array).all():
        raise InputError(f"{must}, got {array.dtype} of shape {array.shape} beside frames of {shape[0]} x {shape[1]}")
    return _frozen(array.astype(np.float64))


def _checked_frames(frames: ArrayLike) -> NDArray[Any]:
    array = as_numbers(frames, 3, "pressure", masked=True)
    if array.shape[0] == 0:
        raise InputError("a recording needs at least one frame, got none")
    return _frozen(array.view())


def _kept(mask: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    """Return a copy of a mask that nobody can write to; None for the mask of no taxels."""
    return _frozen(mask.copy()) if mask.size else None


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
    return _frozen(time)


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array of our own, which nobody can write to from now on."""
    array.flags.writeable = False
    return array


def _checked_notes(notes: object) -> tuple[str, ...]:
    if not isinstance(notes, tuple | list) or not all(isinstance(note, str) for note in notes):
        raise InputError(f"notes must be a tuple of texts, got {str(notes)[:60]!r}")
    return tuple(notes)


def _checked_unit(unit: object) -> str:
    return str(unit).strip() or "raw"


def _blocks(frames: NDArray[Any]) -> Iterator[tuple[int, NDArray[Any]]]:
    """Yield (number of the first frame, some frames), so that temporary arrays stay small."""
    many = max(1, _BLOCK // math.prod(frames.shape[1:]) // 8)
    for start in range(0, frames.shape[0], many):
        yield start, frames[start : start + many]
        let_go(frames)
