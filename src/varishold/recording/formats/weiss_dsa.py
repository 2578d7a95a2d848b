"""Weiss DSA fingertip arrays, as an NPZ of two-finger grasps: frames, texel_mask, time_ms, start, peak."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from varishold.errors import FormatError, InputError
from varishold.files import archive_names, open_archive
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.recording import Pad, Recording

__all__ = ["FORMAT"]

_KEYS = {"frames", "texel_mask", "time_ms", "start"}
_PITCH_M = 3.4e-3


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and set(archive_names(path)) >= _KEYS


def _read(path: Path, options: Options) -> Recording:
    with open_archive(path) as archive:
        frames, mask, time_ms = archive.array("frames"), archive.array("texel_mask"), archive.array("time_ms")
    if frames.ndim != 4 or mask.shape != frames.shape[1:]:
        raise FormatError(
            f"{path}: frames must have shape (n, fingers, rows, cols) and texel_mask (fingers, rows, cols), "
            f"got {frames.shape} and {mask.shape}"
        )
    if error := shape_error(path, (frames.shape[2], frames.shape[3]), options):
        raise error
    if time_ms.dtype.kind not in "iuf":
        raise FormatError(f"{path}: time_ms must be numbers, got {time_ms.dtype}")
    pitch = options.pitch_m or (_PITCH_M, _PITCH_M)
    try:
        pads = {
            f"finger{k}": Pad(frames[:, k], field=mask[k] != 0, pitch_m=pitch, polarity=options.polarity)
            for k in range(frames.shape[1])
        }
        return Recording(
            pads,
            time_s=np.asarray(time_ms, dtype=np.float64) / 1000,
            sensor="Weiss DSA",
            source=str(path),
            notes=("grasps follow one another; time counts from the first frame of each",),
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


FORMAT = Format("Weiss DSA grasps (NPZ)", (), _recognizes, _read)
