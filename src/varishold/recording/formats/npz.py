"""NPZ: the package's own format, which loses nothing."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import Archive, open_archive, write_archive
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.press_table import Mark
from varishold.recording.recording import UNNAMED_PAD, Pad, Recording, Signals

__all__ = ["FORMAT", "write"]

_SINGLE = "pressure"
_NAMED = "pressure."
_PRESS = "press."
_SIGNALS = "signals."
_MARK_FRAME, _MARK_LABEL = "mark.frame", "mark.label"
# Members that a message names at most.
_TOLD = 12


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith((b"PK\x03\x04", b"PK\x05\x06"))


def _read(path: Path, options: Options) -> Recording:
    with open_archive(path) as archive:
        keys = {name.removeprefix(_NAMED): name for name in archive.names if name.startswith(_NAMED)}
        if _SINGLE in archive.names:
            if keys:
                raise FormatError(f"{path}: holds both 'pressure' and {keys.popitem()[1]!r}; name every pad")
            keys = {UNNAMED_PAD: _SINGLE}
        if not keys:
            held = ", ".join(archive.names[:_TOLD]) or "nothing"
            raise FormatError(f"{path}: must hold an array 'pressure' or 'pressure.NAME', holds {held}")
        try:
            recording = Recording(
                pads={name: _pad(archive, path, name, key, options) for name, key in keys.items()},
                time_s=archive.array("time_s") if "time_s" in archive.names else None,
                unit=archive.text("unit") if "unit" in archive.names else "raw",
                sensor=archive.text("sensor") if "sensor" in archive.names else "",
                source=str(path),
                press=archive.array("press") if "press" in archive.names else None,
                press_columns={
                    name.removeprefix(_PRESS): archive.array(name) for name in archive.names if name.startswith(_PRESS)
                },
                signals={
                    name.removeprefix(_SIGNALS): _signals(archive, name)
                    for name in archive.names
                    if name.startswith(_SIGNALS)
                },
                marks=_marks(archive),
            )
        except FormatError:
            raise
        except InputError as error:
            raise FormatError(f"{path}: {error}") from error
        # The pitch is not asked for where a person has said it.
        passed = [name for name in archive.unread if not name.startswith("pitch_m")]
        if not passed:
            return recording
        told = ", ".join(passed[:_TOLD]) + (", ..." if len(passed) > _TOLD else "")
        return replace(recording, notes=(f"passed over, for it is no part of a recording: {told}",))


def _pad(archive: Archive, path: Path, name: str, key: str, options: Options) -> Pad:
    frames, positions = archive.array(key), _of_pad(archive, "positions_m", name)
    if frames.ndim == 2 and positions is not None:
        # Taxels that stand on no grid are one row.
        frames = frames[:, None, :]
    elif frames.ndim == 2 and options.shape is not None and frames.shape[1] == options.shape[0] * options.shape[1]:
        frames = frames.reshape(-1, *options.shape)
    elif frames.ndim == 3 and (error := shape_error(path, frames.shape[1:], options)):
        raise error
    elif frames.ndim == 2:
        raise FormatError(
            f"{path}: {key} must have shape (n, rows, cols), got {frames.shape}; "
            "say the shape of a frame if each row is one, or store one frame as (1, rows, cols)",
            parameter="shape",
        )
    try:
        return Pad(
            frames,
            field=_mask(archive, "field", name, positions),
            valid=_mask(archive, "valid", name, positions),
            pitch_m=options.pitch_m or _of_pad(archive, "pitch_m", name),  # type: ignore[arg-type]
            positions_m=positions,
            polarity=options.polarity,
        )
    except FormatError:
        raise
    except InputError as error:
        raise FormatError(f"{path}: {key}: {error}") from error


def _marks(archive: Archive) -> tuple[Mark, ...]:
    if _MARK_FRAME not in archive.names:
        return ()
    frames, labels = archive.array(_MARK_FRAME), archive.array(_MARK_LABEL)
    if frames.shape != labels.shape or frames.ndim != 1:
        raise InputError(
            f"{_MARK_FRAME} and {_MARK_LABEL} must be a frame and a label each, got {frames.shape} and {labels.shape}"
        )
    return tuple(Mark(*mark) for mark in zip(frames.tolist(), labels.tolist(), strict=True))


def _signals(archive: Archive, key: str) -> Signals:
    told = {part: f"{part}.{key}" for part in ("names", "unit")}
    names = archive.array(told["names"]) if told["names"] in archive.names else np.empty(0)
    unit = archive.text(told["unit"]) if told["unit"] in archive.names else "raw"
    return Signals(archive.array(key), tuple(map(str, names.ravel())), unit)


def _of_pad(archive: Archive, key: str, name: str) -> NDArray[Any] | None:
    """Return ``key.NAME`` where there is one, else what ``key`` says of all pads."""
    for wanted in (f"{key}.{name}", key):
        if wanted in archive.names:
            return archive.array(wanted)
    return None


def _mask(archive: Archive, key: str, name: str, positions: NDArray[Any] | None) -> NDArray[Any] | None:
    """Return a mask; of taxels on no grid it may be one row or none at all."""
    mask = _of_pad(archive, key, name)
    return mask[None] if mask is not None and positions is not None and mask.ndim == 1 else mask


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
    arrays: dict[str, NDArray[Any]] = {}
    single = tuple(recording.pads) == (UNNAMED_PAD,)
    for name, pad in recording.pads.items():
        end = "" if single else f".{name}"
        arrays[f"pressure{end}"] = pad.frames if pad.positions_m is None else pad.frames[:, 0]
        for key in ("field", "valid", "pitch_m", "positions_m"):
            value = getattr(pad, key)
            if value is not None:
                arrays[f"{key}{end}"] = np.asarray(value)
    if recording.time_s is not None:
        arrays["time_s"] = recording.time_s
    if recording.press is not None:
        arrays["press"] = recording.press
        arrays |= {f"{_PRESS}{name}": column for name, column in recording.press_columns.items()}
    for name, signals in recording.signals.items():
        arrays[f"{_SIGNALS}{name}"] = signals.values
        arrays[f"unit.{_SIGNALS}{name}"] = np.array(signals.unit)
        if signals.names:
            arrays[f"names.{_SIGNALS}{name}"] = np.array(signals.names)
    if recording.marks:
        arrays[_MARK_FRAME] = np.array([mark.frame for mark in recording.marks])
        arrays[_MARK_LABEL] = np.array([mark.label for mark in recording.marks])
    arrays["unit"] = np.array(recording.unit)
    if recording.sensor:
        arrays["sensor"] = np.array(recording.sensor)
    write_archive(arrays, path)


FORMAT = Format("NumPy archive (NPZ)", (".npz",), _recognizes, _read, write)
