"""The one mapping between a recording and arrays by their names; every container of arrays holds it in its own way."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import LARGEST_BYTES
from varishold.frame import as_pitch
from varishold.recording.formats.format import Options, shape_error
from varishold.recording.formats.time_axis import last_axis_words, time_axis_notes
from varishold.recording.pad import UNNAMED_PAD
from varishold.recording.press_table import Mark
from varishold.recording.recording import Recording
from varishold.recording.stored import Column, Stored, StoredPad, StoredSignals, Turned

__all__ = [
    "NAMED",
    "PRESS",
    "SIGNALS",
    "SINGLE",
    "TRUTH",
    "Dataset",
    "HeldArrays",
    "NamedArrays",
    "arrays_of",
    "stored_in",
]

#: What the arrays are called: the frames of the only pad, and what stands before the name of one of several, of a
#: column of presses, of signals.
SINGLE, NAMED, PRESS, SIGNALS = "pressure", "pressure.", "press.", "signals."
#: What stands before the name of what a simulation knows of a recording and no sensor measures: nobody reads it.
TRUTH = "truth."
_MARK_FRAME, _MARK_LABEL = "mark.frame", "mark.label"
# Names of arrays, or what stands before a pad's name, beside which frames are as they are written here.
_SAID_BESIDE = ("unit", "time_s", "press", "field", "valid", "positions_m")
# Members that a message names at most.
_TOLD = 12


class NamedArrays(Protocol):
    """An open container of arrays."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def unread(self) -> tuple[str, ...]:
        """Names that nobody has asked for."""
        ...

    def array(self, name: str) -> NDArray[Any]:
        """Read one array."""
        ...

    def column(self, name: str) -> Column:
        """Return an array with an entry a frame, which may stay where it is."""
        ...

    def text(self, name: str) -> str:
        """Read one array that holds one text."""
        array = self.array(name)
        if array.size != 1 or array.dtype.kind != "U":
            raise InputError(f"{name} must be one text, got {array.dtype} of shape {array.shape}")
        return str(array.ravel()[0])


class Dataset(Column, Protocol):
    """An array that stays in its file."""

    def check(self) -> None:
        """Raise FormatError where it cannot be read as a column."""
        ...

    def small(self) -> NDArray[Any]:
        """Read all of it; raises FormatError where it is too large for anything but a column."""
        ...


class HeldArrays(NamedArrays):
    """Arrays that stay in their file, and those that are in memory, by their names.

    Parameters
    ----------
    datasets : mapping of str to Dataset
    said : mapping of str to ndarray
    """

    def __init__(self, datasets: Mapping[str, Dataset], said: Mapping[str, NDArray[Any]]) -> None:
        self._datasets, self._said = datasets, said
        self._unread = dict.fromkeys(datasets)

    @property
    def names(self) -> tuple[str, ...]:
        return (*self._datasets, *(name for name in self._said if name not in self._datasets))

    @property
    def unread(self) -> tuple[str, ...]:
        return tuple(self._unread)

    def array(self, name: str) -> NDArray[Any]:
        self._unread.pop(name, None)
        if name in self._datasets:
            return self._datasets[name].small()
        return self._said[name]

    def column(self, name: str) -> Column:
        self._unread.pop(name, None)
        if name not in self._datasets:
            return self._said[name]
        self._datasets[name].check()
        return self._datasets[name]


def stored_in(
    arrays: NamedArrays,
    path: Path,
    options: Options,
    *,
    notes: tuple[str, ...] = (),
    close: Callable[[], object] = lambda: None,
    ordered: bool = False,
) -> Stored:
    """Return the recording that named arrays hold; `ordered`: frames are known to come first, as the format says.

    Raises
    ------
    FormatError
        If they hold none, or two things that contradict each other.
    """
    keys = {name.removeprefix(NAMED): name for name in arrays.names if name.startswith(NAMED)}
    if SINGLE in arrays.names:
        if keys:
            raise FormatError(f"{path}: holds both 'pressure' and {keys.popitem()[1]!r}; name every pad")
        keys = {UNNAMED_PAD: SINGLE}
    if not keys:
        held = ", ".join(arrays.names[:_TOLD]) or "nothing"
        raise FormatError(f"{path}: must hold an array 'pressure' or 'pressure.NAME', holds {held}")
    try:
        columns = {name: _frames(arrays, path, name, key, options, ordered=ordered) for name, key in keys.items()}
        pads = {name: _pad(arrays, path, name, key, columns[name][0], options) for name, key in keys.items()}
        held_by_name: dict[str, Any] = {
            "time_s": arrays.column("time_s") if "time_s" in arrays.names else None,
            "press": arrays.column("press") if "press" in arrays.names else None,
            "unit": arrays.text("unit") if "unit" in arrays.names else "raw",
            "sensor": arrays.text("sensor") if "sensor" in arrays.names else "",
            "press_columns": {
                name.removeprefix(PRESS): arrays.array(name) for name in arrays.names if name.startswith(PRESS)
            },
            "signals": {
                name.removeprefix(SIGNALS): _signals(arrays, name) for name in arrays.names if name.startswith(SIGNALS)
            },
            "marks": _marks(arrays),
        }
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error
    notes = (*notes, *(note for _, said in columns.values() for note in said))
    # The pitch is not asked for where a person has said it.
    passed = [name for name in arrays.unread if name != "pitch_m" and not name.startswith(("pitch_m.", TRUTH))]
    if passed:
        told = ", ".join(passed[:_TOLD]) + (", ..." if len(passed) > _TOLD else "")
        notes = (*notes, f"passed over, for it is no part of a recording: {told}")
    return Stored(pads, **held_by_name, source=str(path), notes=notes, close=close)


def _frames(
    arrays: NamedArrays, path: Path, name: str, key: str, options: Options, *, ordered: bool
) -> tuple[Column, tuple[str, ...]]:
    """Return a pad's frames as (n, rows, cols), and what was assumed about them."""
    frames, positions = arrays.column(key), _of_pad(arrays, "positions_m", name)
    shape, which = frames.shape, "" if key == SINGLE else f"{key}: "
    if len(shape) == 2 and positions is not None:
        # Taxels that stand on no grid are one row.
        return _shaped(frames, (1, shape[1])), ()
    if len(shape) == 2 and options.shape is not None and shape[1] == options.shape[0] * options.shape[1]:
        return _shaped(frames, options.shape), ()
    if len(shape) == 2:
        raise FormatError(
            f"{path}: {key} must have shape (n, rows, cols), got {shape}; "
            "say the shape of a frame if each row is one, or store one frame as (1, rows, cols)",
            parameter="shape",
        )
    if len(shape) != 3:
        raise FormatError(f"{path}: {key}: must be numbers of shape (n_frames, rows, cols), got shape {shape}")
    if shape[:2] == options.shape != shape[1:]:
        if math.prod(shape) * frames.dtype.itemsize > LARGEST_BYTES:
            raise FormatError(f"{path}: {key} is too large to be turned: store it as (n, rows, cols)")
        held = frames if isinstance(frames, np.ndarray) else frames[:]
        return np.ascontiguousarray(np.moveaxis(held, -1, 0)), (last_axis_words(shape, which),)
    if error := shape_error(path, (shape[1], shape[2]), options):
        raise error
    # Who says one of these means frames as they are written here.
    told = options.shape is not None or any(each.partition(".")[0] in _SAID_BESIDE for each in arrays.names)
    return frames, () if told else time_axis_notes(path, (shape[0], shape[1], shape[2]), which, ordered=ordered)


def _pad(arrays: NamedArrays, path: Path, name: str, key: str, frames: Column, options: Options) -> StoredPad:
    positions = _of_pad(arrays, "positions_m", name)
    pitch = _of_pad(arrays, "pitch_m", name) if options.pitch_m is None else options.pitch_m
    try:
        return StoredPad(
            frames,
            key,
            field=_mask(arrays, "field", name, positions),
            valid=_mask(arrays, "valid", name, positions),
            pitch_m=None if pitch is None else as_pitch(pitch),
            positions_m=positions,
            polarity=_polarity(arrays, name) if options.polarity == "up" else options.polarity,
        )
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: {key}: {error}") from error


def _shaped(column: Column, shape: tuple[int, int]) -> Column:
    """Return a column whose entries have rows and columns."""
    if isinstance(column, np.ndarray):
        return column.reshape(-1, *shape)
    return Turned(column, shape, lambda block: block.reshape(-1, *shape))


def _polarity(arrays: NamedArrays, name: str) -> Literal["up", "down"]:
    for wanted in (f"polarity.{name}", "polarity"):
        if wanted in arrays.names:
            told = arrays.text(wanted)
            if told not in ("up", "down"):
                raise InputError(f"polarity must be up or down, got {told!r}")
            return "down" if told == "down" else "up"
    return "up"


def _marks(arrays: NamedArrays) -> tuple[Mark, ...]:
    if _MARK_FRAME not in arrays.names:
        return ()
    frames, labels = arrays.array(_MARK_FRAME), arrays.array(_MARK_LABEL)
    if frames.shape != labels.shape or frames.ndim != 1:
        raise InputError(
            f"{_MARK_FRAME} and {_MARK_LABEL} must be a frame and a label each, got {frames.shape} and {labels.shape}"
        )
    return tuple(Mark(*mark) for mark in zip(frames.tolist(), labels.tolist(), strict=True))


def _signals(arrays: NamedArrays, key: str) -> StoredSignals:
    told = {part: f"{part}.{key}" for part in ("names", "unit")}
    names = arrays.array(told["names"]) if told["names"] in arrays.names else np.empty(0)
    unit = arrays.text(told["unit"]) if told["unit"] in arrays.names else "raw"
    return StoredSignals(arrays.column(key), tuple(map(str, names.ravel())), unit)


def _of_pad(arrays: NamedArrays, key: str, name: str) -> Any:
    """Return ``key.NAME`` where there is one, else what ``key`` says of all pads."""
    for wanted in (f"{key}.{name}", key):
        if wanted in arrays.names:
            return arrays.array(wanted)
    return None


def _mask(arrays: NamedArrays, key: str, name: str, positions: NDArray[Any] | None) -> NDArray[Any] | None:
    """Return a mask; of taxels on no grid it may be one row or none at all."""
    mask: NDArray[Any] | None = _of_pad(arrays, key, name)
    return mask[None] if mask is not None and positions is not None and mask.ndim == 1 else mask


def arrays_of(recording: Recording) -> dict[str, NDArray[Any]]:
    """Return the arrays that hold a recording, by their names; a pad's polarity only where it is down."""
    arrays: dict[str, NDArray[Any]] = {}
    single = tuple(recording.pads) == (UNNAMED_PAD,)
    for name, pad in recording.pads.items():
        end = "" if single else f".{name}"
        arrays[f"{SINGLE}{end}"] = pad.frames if pad.positions_m is None else pad.frames[:, 0]
        for key in ("field", "valid", "pitch_m", "positions_m"):
            value = getattr(pad, key)
            if value is not None:
                arrays[f"{key}{end}"] = np.asarray(value)
        if pad.polarity == "down":
            arrays[f"polarity{end}"] = np.array(pad.polarity)
    if recording.time_s is not None:
        arrays["time_s"] = recording.time_s
    if recording.press is not None:
        arrays["press"] = recording.press
        arrays |= {f"{PRESS}{name}": column for name, column in recording.press_columns.items()}
    for name, signals in recording.signals.items():
        arrays[f"{SIGNALS}{name}"] = signals.values
        arrays[f"unit.{SIGNALS}{name}"] = np.array(signals.unit)
        if signals.names:
            arrays[f"names.{SIGNALS}{name}"] = np.array(signals.names)
    if recording.marks:
        arrays[_MARK_FRAME] = np.array([mark.frame for mark in recording.marks])
        arrays[_MARK_LABEL] = np.array([mark.label for mark in recording.marks])
    arrays["unit"] = np.array(recording.unit)
    if recording.sensor:
        arrays["sensor"] = np.array(recording.sensor)
    return arrays
