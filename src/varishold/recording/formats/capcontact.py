"""CapContact: mutual-capacitance frames of fingers on a touch screen, as an NPZ with the key capacitance."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from varishold.errors import FormatError, InputError
from varishold.files import archive_names, open_archive
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.pad import UNNAMED_PAD, Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT"]

_KEY = "capacitance"
_PITCH_M = 4.79e-3


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and _KEY in archive_names(path)


def _read(path: Path, options: Options) -> Recording:
    with open_archive(path) as archive:
        frames = archive.array(_KEY)
        pitch_mm = archive.array("pitch_mm") if "pitch_mm" in archive.names else None
    if frames.ndim == 3 and (error := shape_error(path, (frames.shape[1], frames.shape[2]), options)):
        raise error
    try:
        pitch = options.pitch_m or (_PITCH_M if pitch_mm is None else np.asarray(pitch_mm, dtype=np.float64) / 1000)
        return Recording(
            {UNNAMED_PAD: Pad(frames, pitch_m=pitch, polarity=options.polarity)},  # type: ignore[arg-type]
            sensor="mutual-capacitance touch screen",
            source=str(path),
        )
    except (InputError, ValueError, TypeError) as error:
        raise FormatError(f"{path}: {error}") from error


FORMAT = Format("CapContact capacitance (NPZ)", (), _recognizes, _read)
