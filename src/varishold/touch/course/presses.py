"""Presses as they are learned from: frames that are zero at rest, whatever they came as."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold._counted import counted
from varishold.errors import InputError
from varishold.frame import fill_invalid
from varishold.frame.checks import MOST_READ, squarest_grid
from varishold.frame.level import level
from varishold.recording import Pad, Recording
from varishold.recording.mended import without_faults
from varishold.recording.press_table import COLUMN_HEADS
from varishold.touch.course.loading import as_grasp

__all__ = [
    "FoundPresses",
    "Press",
    "as_presses",
    "cut_presses",
    "drifted",
    "find_presses",
    "first_of_same",
    "flat_presses",
    "is_flat",
    "values_of",
    "without_copies",
]

Floats = NDArray[np.float64]

# Frames at the start of a press that may show its rest.
_REST_FRAMES = 8
# Of what changes up to the strongest frame at most so much, squared, goes down, or it is noise.
_FALLEN_SHARE = 0.2
# The first frame is loaded where it holds so much of that change ...
_REST_SHARE = 0.05
# ... and more than unevenness gives by chance, ...
_CHANCE_SIGMAS = 3.0
# ... and in any case where it holds so much.
_LOADED_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Press:
    """One press, or one grasp.

    Parameters
    ----------
    pads : mapping of str to ndarray of shape (n_frames, rows, cols), float64
        Zero at rest, broken taxels filled, 0 where there is no taxel.
    fields : mapping of str to ndarray of shape (rows, cols), bool
        Where each pad has taxels.
    time_s : ndarray of shape (n_frames,), float64, optional
    columns : mapping of str to float
        Angles, switches and forces by their names; NaN where unknown.
    place : str
        Where it stands, for messages: the file and the number of the press.
    unit : str
        Of the frames; "raw" where it is not known.
    pitch_m : mapping of str to (float, float)
        How far rows and columns of taxels are apart, of the pads of which it is known; metres.
    filled : mapping of str to ndarray of shape (rows, cols), bool
        Of pads with broken taxels which these are.
    """

    pads: Mapping[str, Floats]
    fields: Mapping[str, NDArray[np.bool_]]
    time_s: Floats | None = None
    columns: Mapping[str, float] = field(default_factory=dict)
    place: str = ""
    unit: str = "raw"
    pitch_m: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    filled: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    @property
    def shapes(self) -> dict[str, tuple[int, int]]:
        """Rows and columns of each pad."""
        return {name: (frames.shape[1], frames.shape[2]) for name, frames in self.pads.items()}


def as_presses(X: Any) -> list[Press]:
    """Return presses from recordings or arrays.

    Parameters
    ----------
    X : sequence of Recording, of frames or of (frames, time_s); or array_like
        Each recording is one press. Frames of one press have shape (n_frames, rows, cols), (n_frames, pads, rows, cols)
        or, where a press is one frame, (rows, cols). An array has shape (n, rows, cols), (n, n_frames, rows, cols) or
        (n, n_frames, pads, rows, cols).

    Raises
    ------
    InputError
        Naming the press that cannot be used.
    """
    if isinstance(X, (Recording, str)) or not isinstance(X, (Sequence, np.ndarray)):
        raise InputError(f"presses must be a sequence of recordings or frames, got {type(X).__name__}")
    presses = []
    for k, given in enumerate(X):
        if isinstance(given, Press):
            presses.append(given)
            continue
        try:
            presses.append(_press(given, f"press {k}"))
        except InputError as error:
            raise InputError(f"press {k}: {error}") from error
    return presses


def first_of_same(presses: Sequence[Press]) -> NDArray[np.intp]:
    """Return for each press the first one with the same frames and numbers beside them: itself, or what it copies.

    One in which nothing is felt copies none: that is the same whenever it happens. Shape (n_presses,).
    """
    first: dict[tuple[object, ...], int] = {}
    found = []
    for k, press in enumerate(presses):
        felt = any(frames.any() for frames in press.pads.values())
        frames = tuple((name, of.shape, of.tobytes()) for name, of in sorted(press.pads.items()))
        beside = tuple((name, np.float64(value).tobytes()) for name, value in sorted(press.columns.items()))
        found.append(first.setdefault((frames, beside), k) if felt else k)
    return np.array(found, dtype=np.intp)


def without_copies(presses: Sequence[Press]) -> list[Press]:
    """Return the presses but for those that copy an earlier one."""
    return [presses[k] for k in np.unique(first_of_same(presses))]


@dataclass(frozen=True, eq=False)
class FoundPresses:
    """What a whole recording tells of its presses, from which each can be cut out of its own frames.

    Parameters
    ----------
    spans : sequence of (int, int)
        First frame of each and the one behind its last.
    columns : mapping of str to ndarray of shape (n_presses,), float64
        What stands beside them, by name.
    works : mapping of str to ndarray of shape (rows, cols), bool
        Which taxels of each pad work.
    """

    spans: Sequence[tuple[int, int]]
    columns: Mapping[str, Floats]
    works: Mapping[str, NDArray[np.bool_]]

    def cut(self, number: int, frames: Recording, first: int = 0) -> Press:
        """Return a press out of frames that hold it, of which the first is number `first` of the whole.

        Raises
        ------
        InputError
            If time runs backward in it.
        """
        begin, stop = self.spans[number]
        beside = {name: float(values[number]) for name, values in self.columns.items()}
        source = frames.source or "the recording"
        try:
            return _cut(frames, begin - first, stop - first, beside, f"{source}, press {number}", self.works)
        except InputError as error:
            raise InputError(f"{source}: press {number}: {error}") from error


def find_presses(recording: Recording) -> FoundPresses:
    """Look for the presses of a recording.

    Raises
    ------
    InputError
        If nothing was pressed, or smaller readings mean more pressure.
    """
    table = recording.presses
    source = recording.source or "the recording"
    if not len(table):
        named = recording.press is not None
        why = "press names none, it is -1 in every frame" if named else "the total never rises above its noise"
        raise InputError(f"{source}: no press found: {why}")
    try:
        works = _works(recording)
    except InputError as error:
        raise InputError(f"{source}: press 0: {error}") from error
    spans = [(span.start, span.stop) for span in table.spans]
    return FoundPresses(spans, _numbers_beside(table.columns, recording.source), works)


def cut_presses(recording: Recording) -> list[Press]:
    """Return the presses of a recording, with their columns; errors as `find_presses`."""
    found = find_presses(recording)
    return [found.cut(number, recording) for number in range(len(found.spans))]


def is_flat(X: Any) -> bool:
    """Tell whether X is a table of flat frames, a row each, or no presses at all."""
    if isinstance(X, Recording):
        return False
    if isinstance(X, (list, tuple)):
        first: Any = X[0] if X else None
        return bool(X) and not isinstance(first, (Recording, Press, tuple)) and np.ndim(first) < 2
    return not isinstance(X, np.ndarray) or X.ndim < 3


def flat_presses(X: Floats, shape: tuple[int, ...] | None = None) -> list[Press]:
    """Return presses of one frame from flat ones.

    Parameters
    ----------
    X : ndarray of shape (n, n_values), float64
    shape : (rows, cols) or (pads, rows, cols), optional
        What a flat frame holds. Default: the squarest grid without a rest.

    Raises
    ------
    InputError
        If the shape holds another number of values.
    """
    frames = X.reshape(len(X), 1, *_pads_shape(shape, X.shape[1]))
    field = np.ones(frames.shape[-2:], np.bool_)
    names = [f"pad_{p}" for p in range(frames.shape[2])]
    fields = dict.fromkeys(names, field)
    return [
        Press(_at_rest_zero({name: press[:, p] for p, name in enumerate(names)}, fields), fields, place=f"press {k}")
        for k, press in enumerate(frames)
    ]


def drifted(
    press: Press, drift: float, seed: tuple[int, ...], *, elsewhere: int = 0, lighter: float = 0.0, pace: float = 1.0
) -> Press:
    """Return a press as it might be on another day.

    Parameters
    ----------
    press : Press
    drift : float
        By about what share the gain of every taxel has drifted.
    seed : tuple of int
    elsewhere : int
        By up to so many taxels everything may lie elsewhere, where a pad has no gaps: by less than half its side.
    lighter : float
        By up to so much less, or half as much more, it may be pressed.
    pace : float
        Up to so many times as fast, or as slowly, it may be pressed.
    """
    rng = np.random.default_rng(seed)
    away = rng.integers(-elsewhere, elsewhere + 1, 2)
    load = rng.uniform(1.0 - lighter, 1.0 + 0.5 * lighter)
    pads = {}
    for name, frames in press.pads.items():
        changed = frames * (load * np.exp(rng.normal(0.0, drift, frames.shape[1:])))
        most = (np.array(changed.shape[1:]) - 1) // 2
        rows, cols = np.clip(away, -most, most)
        pads[name] = _shifted(changed, int(rows), int(cols)) if press.fields[name].all() else changed
    slower = pace ** rng.uniform(-1.0, 1.0)
    time_s = press.time_s if press.time_s is None or pace == 1.0 else press.time_s * slower
    return replace(press, pads=pads, time_s=time_s)


def _shifted(frames: Floats, rows: int, cols: int) -> Floats:
    """Return frames that lie so many rows further down and columns further right; what leaves the pad is lost."""
    moved = np.zeros_like(frames)
    n_rows, n_cols = frames.shape[1:]
    down, right = (slice(max(rows, 0), n_rows + min(rows, 0)), slice(max(cols, 0), n_cols + min(cols, 0)))
    up, left = (slice(max(-rows, 0), n_rows + min(-rows, 0)), slice(max(-cols, 0), n_cols + min(-cols, 0)))
    moved[:, down, right] = frames[:, up, left]
    return moved


def _press(given: Any, place: str) -> Press:
    paired = isinstance(given, tuple) and len(given) == 2
    frames, time_s = given if paired else (given, None)
    if isinstance(frames, Recording):
        recording = without_faults(frames)
        numbers = {}
        if recording.press is not None and len(recording.presses) == 1:
            beside = _numbers_beside(recording.presses.columns, recording.source or place)
            numbers = {name: float(of[0]) for name, of in beside.items()}
        return _cut(recording, 0, recording.n_frames, numbers, recording.source or place, _works(recording))
    array = np.asarray(frames)
    if array.dtype.kind not in "biuf":
        raise InputError(f"frames must be numbers in one array, got {array.dtype} of shape {array.shape}")
    if array.ndim == 2:
        array = array[None]
    valid = np.isfinite(array)
    if np.isinf(array).any():
        raise InputError("pressure must be finite or, where a taxel is dead, NaN; got inf")
    array = array[:, None] if array.ndim == 3 else array
    valid = valid.reshape(array.shape).all(axis=0) if array.ndim == 4 else valid
    recording = as_grasp(np.where(np.isnan(array), 0, array) if array.dtype.kind == "f" else array, time_s)
    if not valid.any():
        raise InputError("every taxel is NaN in some frame, so none is left; mark only dead taxels with NaN")
    if not valid.all():
        pads = {
            name: Pad(pad.frames, valid=valid[k])
            for k, (name, pad) in enumerate(recording.pads.items())
            if valid[k].any()
        }
        recording = Recording(pads, recording.time_s)
    recording = without_faults(recording)
    return _cut(recording, 0, recording.n_frames, {}, place, _works(recording))


def _numbers_beside(columns: Mapping[str, NDArray[Any]], source: str) -> dict[str, Floats]:
    """Return the columns of presses that are numbers to learn from."""
    found = {
        name: np.asarray(values, dtype=np.float64)
        for name, values in columns.items()
        if name.startswith(COLUMN_HEADS) and values.dtype.kind in "biuf"
    }
    for name, values in found.items():
        wild = np.flatnonzero(np.abs(values) > MOST_READ)
        if wild.size:
            where, got = f"{source}: " if source else "", values[wild[0]]
            raise InputError(f"{where}press {wild[0]}: {name} must lie within {MOST_READ:g} of zero, got {got:g}")
    return found


def _pads_shape(shape: tuple[int, ...] | None, n_values: int) -> tuple[int, ...]:
    if shape is None:
        return 1, *squarest_grid(n_values)
    if len(shape) not in (2, 3) or math.prod(shape) != n_values:
        raise InputError(f"shape {tuple(shape)} needs {counted(math.prod(shape), 'value')} a press, got {n_values}")
    return (1, *shape)[-3:]


def _works(recording: Recording) -> dict[str, NDArray[np.bool_]]:
    """Return which taxels of each pad work."""
    if any(pad.polarity == "down" for pad in recording.pads.values()):
        raise InputError("smaller readings mean more pressure here; give a sensor file, which turns them")
    return {name: pad.usable & ~pad.broken for name, pad in recording.pads.items()}


def _cut(
    recording: Recording,
    first: int,
    stop: int,
    numbers: Mapping[str, float],
    place: str,
    works: Mapping[str, NDArray[np.bool_]],
) -> Press:
    pads, fields, filled = {}, {}, {}
    for name, pad in recording.pads.items():
        fields[name] = np.ones(pad.shape, np.bool_) if pad.field is None else pad.field
        pads[name] = _filled(pad, first, stop, works[name], fields[name])
        if (broken := fields[name] & ~works[name]).any():
            filled[name] = broken
    time_s = None if recording.time_s is None else recording.time_s[first:stop]
    if time_s is not None and (np.diff(time_s) < 0).any():
        raise InputError("time_s must not run backward within a press")
    pitch_m = {name: pad.pitch_m for name, pad in recording.pads.items() if pad.pitch_m is not None}
    return Press(_at_rest_zero(pads, fields), fields, time_s, numbers, place, recording.unit, pitch_m, filled)


def _filled(pad: Pad, first: int, stop: int, works: NDArray[np.bool_], field: NDArray[np.bool_]) -> Floats:
    """Return frames in which broken taxels are filled, 0 where there is no taxel."""
    frames = np.asarray(pad.frames[first:stop], dtype=np.float64)
    if not works[field].all() and works.any():
        frames = np.stack([fill_invalid(frame, works, field) for frame in frames])
    return np.where(field, frames, 0.0)


def _at_rest_zero(pads: dict[str, Floats], fields: Mapping[str, NDArray[np.bool_]]) -> dict[str, Floats]:
    """Return frames less their rest: the first ones where a press starts unloaded, else a plane that shows itself."""
    n_rest = _resting(np.concatenate([frames[:, fields[name]] for name, frames in pads.items()], axis=1))
    if n_rest:
        return {name: frames - frames[:n_rest].mean(axis=0) for name, frames in pads.items()}
    return {name: _levelled(frames, fields[name]) for name, frames in pads.items()}


def _resting(readings: Floats) -> int:
    """Return how many frames at the start show the rest; 0 where a press starts loaded.

    Taxels rest unevenly: what counts is not how uneven the first frame is, but how much it holds already of the change
    up to the strongest one.
    """
    first = readings[0]
    change = readings[int(np.argmax(readings.sum(axis=1)))] - first
    whole = float(change @ change)
    fallen = np.minimum(change, 0.0)
    if not whole or fallen @ fallen > _FALLEN_SHARE * whole:
        return 0
    uneven = first - np.median(first)
    by_chance = _CHANCE_SIGMAS * math.sqrt(float(np.mean(uneven * uneven)) / whole)
    if uneven @ change > min(max(_REST_SHARE, by_chance), _LOADED_SHARE) * whole:
        return 0
    resting = (readings[:_REST_FRAMES] - first) @ change <= _REST_SHARE * whole
    return int(np.argmin(resting)) if not resting.all() else len(resting)


def _levelled(frames: Floats, field: NDArray[np.bool_]) -> Floats:
    strongest = int(np.argmax(frames[:, field].sum(axis=1)))
    rest, by_column, by_row = level(frames[strongest], field).rest
    if rest == by_column == by_row == 0:
        return frames
    row, col = np.indices(field.shape)
    return np.where(field, frames - (rest + by_column * col + by_row * row), 0.0)


def values_of(presses: Iterable[Press], names: Sequence[str]) -> Floats:
    """Return what the columns say of each press, NaN where nothing, shape (n, n_names)."""
    said = [[press.columns.get(name, math.nan) for name in names] for press in presses]
    return np.array(said, dtype=np.float64).reshape(len(said), len(names))
