"""The recording: what a sensor said, before anybody has asked what it means.

A `GraspTable` holds the rows of grasps: switches, angles and forces by name. `frame_noise` and
`recording_noise` are the package's one noise estimate, `fill_invalid` fills broken taxels, and `atomic_write`
is the one way in which the package writes a file.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.recording.atomic import atomic_write
from varishold.recording.grasp_table import (
    GraspTable,
    iter_grasp_table,
    read_grasp_table,
    write_grasp_table,
)

if TYPE_CHECKING:
    from varishold.recording.fill import fill_invalid, fill_taxels
    from varishold.recording.noise import frame_noise, noise_sigma, recording_noise

# Compiled code: whoever only reads or writes a file need not wait for numba.
_COMPILED = {
    "fill_invalid": "fill",
    "fill_taxels": "fill",
    "frame_noise": "noise",
    "noise_sigma": "noise",
    "recording_noise": "noise",
}

__all__ = [
    "GraspTable",
    "atomic_write",
    "fill_invalid",
    "fill_taxels",
    "frame_noise",
    "iter_grasp_table",
    "noise_sigma",
    "read_grasp_table",
    "recording_noise",
    "write_grasp_table",
]


def __getattr__(name: str) -> Any:
    if name in _COMPILED:
        return getattr(importlib.import_module(f"varishold.recording.{_COMPILED[name]}"), name)
    raise AttributeError(f"module 'varishold.recording' has no attribute {name!r}")
