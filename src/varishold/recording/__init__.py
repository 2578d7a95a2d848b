"""The recording: what a sensor said, before anybody has asked what it means.

`read` makes a `Recording` of named `Pad` s from a file of any known format (`FORMATS`; one file each in
``formats/``), and `write` loses nothing of it. `select_frames` chooses frames: the strongest, every one, or those
of each press. A `GraspTable` holds the rows of grasps: switches, angles and forces by name.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.recording.blocks import Blocks, open
from varishold.recording.formats import FORMATS, Format, Options, read, write
from varishold.recording.grasp_csv import iter_grasp_table, read_grasp_table, write_grasp_table
from varishold.recording.grasp_table import GraspTable
from varishold.recording.height_map import read_height_map
from varishold.recording.recording import UNNAMED_PAD, Pad, Recording, frame_of

if TYPE_CHECKING:
    from varishold.recording.selection import peak_frame, presses, select_frames

# Compiled code: whoever only reads or writes a file need not wait for numba.
_COMPILED = {
    "peak_frame": "selection",
    "presses": "selection",
    "select_frames": "selection",
}

__all__ = [
    "FORMATS",
    "UNNAMED_PAD",
    "Blocks",
    "Format",
    "GraspTable",
    "Options",
    "Pad",
    "Recording",
    "frame_of",
    "iter_grasp_table",
    "open",
    "peak_frame",
    "presses",
    "read",
    "read_grasp_table",
    "read_height_map",
    "select_frames",
    "write",
    "write_grasp_table",
]


def __getattr__(name: str) -> Any:
    if name in _COMPILED:
        return getattr(importlib.import_module(f"varishold.recording.{_COMPILED[name]}"), name)
    raise AttributeError(f"module 'varishold.recording' has no attribute {name!r}")
