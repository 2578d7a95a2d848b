"""From one file format to another: without loss, or with what was lost told."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, reason_of
from varishold.files import atomic_write, folder_beside
from varishold.recording.formats import FORMATS, format_of, read
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording

__all__ = ["beyond_recording", "convert", "losses"]

# What is compared of two pads and two recordings, and how it is called.
_OF_PADS = MappingProxyType(
    {
        "pitch_m": "pitch",
        "field": "field mask",
        "valid": "mask of broken taxels",
        "positions_m": "positions of taxels",
        "polarity": "polarity",
    }
)
_OF_ALL = MappingProxyType(
    {"time_s": "time", "unit": "unit", "sensor": "sensor", "press": "press of each frame", "marks": "marks"}
)


def convert(
    recording: Recording, path: str | os.PathLike[str], *, beyond: tuple[str, ...] = (), lossy: bool = False
) -> tuple[str, ...]:
    """Write a recording in the format that a file's name tells, read it back, and say what was lost.

    Parameters
    ----------
    recording : Recording
    path : str or path-like
        Its ending says the format: those that `FORMATS` writes hold all, ``.npy`` and ``.csv`` the frames of one pad.
    beyond : tuple of str
        What is lost already, as of `beyond_recording`.
    lossy : bool
        Write it although something is lost.

    Returns
    -------
    tuple of str
        What was lost, in words; empty where reading it gives the same recording.

    Raises
    ------
    InputError
        If nothing is written in such a format, or something would be lost and `lossy` is not said.
    """
    target = Path(path)
    writer = _writer(target)
    # Beside the target, so that it is put in place whole, and only when it is known to be good.
    try:
        with folder_beside(target) as beside:
            made = beside / target.name
            _write(writer, recording, made, target)
            shape, unsaid = _shape_unsaid(recording, target)
            lost = (*unsaid, *losses(recording, _read_back(made, target, shape)), *beyond)
            if lost and not lossy:
                raise InputError(f"{target}: would lose {', '.join(lost)}; that must be asked for", parameter="lossy")
            os.replace(made, target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {reason_of(error)}") from error
    return lost


def _write(writer: Callable[[Recording, Path], object], recording: Recording, made: Path, target: Path) -> None:
    """Write beside the target; what fails is told of the target, which a person has named."""
    try:
        writer(recording, made)
    except InputError as error:
        told = str(error).replace(str(made), str(target))
        raise InputError(
            told if str(target) in told else told.replace(target.name, str(target), 1), parameter=error.parameter
        ) from error


def _shape_unsaid(recording: Recording, target: Path) -> tuple[tuple[int, int] | None, tuple[str, ...]]:
    """Return the shape that a file of frames alone must be read with, and in words what of it the file does not say."""
    shapes = {pad.shape for pad in recording.pads.values()}
    ending = target.suffix.lower()
    if ending not in _FRAMES or len(shapes) > 1:
        return None, ()
    rows, cols = shapes.pop()
    if ending == ".csv":
        # Lines of numbers are rows of one frame where a blank line parts them from another.
        one = f"the shape of its one frame (say {rows}x{cols} when it is read)"
        return ((rows, cols), (one,)) if recording.n_frames == 1 else (None, ())
    # Numbers alone do not say in which order their axes are.
    return (rows, cols), ()


def _read_back(made: Path, target: Path, shape: tuple[int, int] | None) -> Recording:
    """Read what was written beside the target; what fails is told of the target."""
    try:
        return read(made, shape=shape)
    except InputError as error:
        told = str(error).replace(str(made), str(target)).removeprefix(f"{target}: ")
        raise InputError(f"{target}: could not be read again: {told}") from error


def losses(recording: Recording, other: Recording) -> tuple[str, ...]:
    """Return what one recording holds and another does not, in words.

    Parameters
    ----------
    recording, other : Recording
    """
    return tuple(_losses(recording, other))


def beyond_recording(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return what a file holds that no recording does, in words: topics, marks, zeros, attachments of an MCAP file.

    Parameters
    ----------
    path : str or path-like
        A file that can be read.
    """
    if format_of(path) is not FORMATS["mcap"]:
        return ()
    from varishold.recording.mcap import gather
    from varishold.recording.mcap.topics import MARKS, ZEROS

    held = gather(path)
    found = [f"topic {topic}" for topic in held.passed]
    # A recording holds presses, and marks that are a label alone.
    more = (n for n in held.notes if n.topic == ZEROS or (n.topic == MARKS and not {*n.told} <= {"label", "frame"}))
    found += dict.fromkeys(f"topic {note.topic}" for note in more)
    found += [f"attachment {name}" for name in held.attachments if not name.startswith("time_s")]
    if any(series.sequence is not None for series in held.pads.values()):
        found.append("the sensor's numbers of readings")
    if any(series.stamp == "device" and (series.log_ns != series.stamp_ns).any() for series in held.pads.values()):
        found.append("the time of the machine that recorded")
    return tuple(found)


def _losses(recording: Recording, other: Recording) -> Iterator[str]:
    for name, pad in recording.pads.items():
        which = "" if len(recording.pads) == 1 else f" of pad {name}"
        there = other.pads.get(name)
        if there is None:
            yield f"the pad's name {name}" if len(recording.pads) == len(other.pads) == 1 else f"pad {name}"
            there = next(iter(other.pads.values()))
        if len(recording.pads) == len(other.pads):
            yield from (f"{lost}{which}" for lost in _pad_losses(pad, there))
    for key, words in _OF_ALL.items():
        if not _same(getattr(recording, key), getattr(other, key)):
            yield words
    for name, column in recording.press_columns.items():
        if not _same(column, other.press_columns.get(name)):
            yield f"press.{name}"
    for name, signals in recording.signals.items():
        there_too = other.signals.get(name)
        if there_too is None or not all(
            _same(getattr(signals, key), getattr(there_too, key)) for key in ("values", "names", "unit")
        ):
            yield f"signals {name}"


def _pad_losses(pad: Pad, other: Pad) -> Iterator[str]:
    if not _same(pad.frames, other.frames):
        same = pad.frames.shape == other.frames.shape and np.array_equal(pad.frames, other.frames, equal_nan=True)
        yield f"type {pad.frames.dtype} of the values" if same else "values"
    for key, words in _OF_PADS.items():
        if not _same(getattr(pad, key), getattr(other, key)):
            yield words


def _same(one: Any, other: Any) -> bool:
    if not isinstance(one, np.ndarray) or not isinstance(other, np.ndarray):
        return bool(one is other or (one is not None and other is not None and one == other))
    if one.dtype.kind == "U":
        return one.shape == other.shape and bool((one == other).all())
    return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _writer(target: Path) -> Callable[[Recording, Path], None]:
    ending = target.suffix.lower()
    for known in FORMATS.values():
        if known.write is not None and ending in known.suffixes:
            return known.write
    if ending in _FRAMES:
        return _FRAMES[ending]
    endings = [each for known in FORMATS.values() if known.write is not None for each in known.suffixes]
    known_endings = ", ".join([*endings, *_FRAMES][:-1])
    raise InputError(f"{target}: its name must end in {known_endings} or .csv, to say what is to be written")


def _one_pad(recording: Recording, path: Path) -> NDArray[Any]:
    if len(recording.pads) > 1:
        raise InputError(
            f"{path.name}: holds one pad, the recording has {len(recording.pads)} ({', '.join(recording.pads)}); "
            "name an .npz or .mcap"
        )
    return next(iter(recording.pads.values())).frames


def _write_npy(recording: Recording, path: Path) -> None:
    frames = np.ascontiguousarray(_one_pad(recording, path))
    with atomic_write(path) as file:
        np.lib.format.write_array(file, frames, allow_pickle=False)


def _write_csv(recording: Recording, path: Path) -> None:
    """Write rows of taxels as lines, and a blank line after each frame."""
    frames = _one_pad(recording, path)
    with atomic_write(path, "w") as file:
        _write_lines(frames, file)


def _write_lines(frames: NDArray[Any], file: IO[str]) -> None:
    for frame in frames:
        for row in frame.tolist():
            file.write(",".join(map(repr, row)) + "\n")
        file.write("\n")


_FRAMES: Mapping[str, Callable[[Recording, Path], None]] = MappingProxyType({".npy": _write_npy, ".csv": _write_csv})
