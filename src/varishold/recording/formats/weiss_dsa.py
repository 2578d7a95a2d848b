"""Weiss DSA fingertip arrays, as an NPZ of two-finger grasps.

``frames``, ``texel_mask``, ``time_ms`` and ``start``; where they are there, ``label`` and ``joint_angles_deg`` of each
grasp.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import FormatError, InputError
from varishold.files import archive_names, open_archive
from varishold.recording.formats.format import Format, Options, shape_error
from varishold.recording.pad import Pad
from varishold.recording.recording import Recording

__all__ = ["FORMAT"]

_KEYS = {"frames", "texel_mask", "time_ms", "start"}
_PITCH_M = 3.4e-3


def _recognizes(path: Path, head: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and set(archive_names(path)) >= _KEYS


def _read(path: Path, options: Options) -> Recording:
    with open_archive(path) as archive:
        frames, mask, time_ms = archive.array("frames"), archive.array("texel_mask"), archive.array("time_ms")
        start = archive.array("start")
        told: list[str] = [name for name in ("label", "joint_angles_deg") if name in archive.names]
        columns = {name: archive.array(name) for name in told}
    if frames.ndim != 4 or mask.shape != frames.shape[1:]:
        raise FormatError(
            f"{path}: frames must have shape (n, fingers, rows, cols) and texel_mask (fingers, rows, cols), "
            f"got {frames.shape} and {mask.shape}"
        )
    if error := shape_error(path, (frames.shape[2], frames.shape[3]), options):
        raise error
    if time_ms.dtype.kind not in "iuf":
        raise FormatError(f"{path}: time_ms must be numbers, got {time_ms.dtype}")
    press, press_columns = _grasps(path, start, columns, len(frames))
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
            press=press,
            press_columns=press_columns,
        )
    except InputError as error:
        raise FormatError(f"{path}: {error}") from error


def _grasps(
    path: Path, start: NDArray[Any], given: dict[str, NDArray[Any]], n_frames: int
) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
    """Return the grasp of each frame, and the object's name and the joint angles of each grasp."""
    if start.dtype.kind not in "iu" or start.ndim != 1 or (np.diff(start.astype(np.int64)) < 0).any():
        raise FormatError(f"{path}: start must be the first frame of each grasp, rising")
    press = np.searchsorted(start.astype(np.int64), np.arange(n_frames), side="right") - 1
    n_grasps = int(press[-1]) + 1 if n_frames else 0
    columns: dict[str, NDArray[Any]] = {}
    if "label" in given:
        columns = {"label": given["label"], "object": given["label"]}
    if "joint_angles_deg" in given:
        angles = given["joint_angles_deg"]
        if angles.ndim != 2 or angles.dtype.kind not in "iuf" or len(angles) < n_grasps:
            raise FormatError(
                f"{path}: joint_angles_deg must be numbers of shape ({n_grasps} grasps, n_joints), got "
                f"{angles.dtype} of shape {angles.shape}"
            )
        columns |= {f"angle_rad.joint_{k}": np.deg2rad(angles[:, k]) for k in range(angles.shape[1])}
    return press, columns


FORMAT = Format("Weiss DSA grasps (NPZ)", (), _recognizes, _read)
