"""The recording: what a sensor said, before anybody has asked what it means.

`read` makes a `Recording` of named `Pad` s from a file of any known format (`FORMATS`; one file each in
``formats/``), and `write` loses nothing of it. `select_frames` chooses frames: the strongest, every one, or those
of each press. A `GraspTable` holds the rows of grasps: switches, angles and forces by name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "FORMATS",
    "UNNAMED_PAD",
    "Blocks",
    "Format",
    "GraspTable",
    "Mark",
    "Options",
    "Pad",
    "PressTable",
    "Recording",
    "Signals",
    "Summary",
    "faults_of",
    "frame_of",
    "iter_grasp_table",
    "open",
    "pascals_per_unit",
    "peak_frame",
    "presses",
    "read",
    "read_grasp_table",
    "read_height_map",
    "select_frames",
    "summarize",
    "write",
    "write_grasp_table",
]

if TYPE_CHECKING:
    from varishold.recording.blocks import Blocks, open
    from varishold.recording.formats import FORMATS, Format, Options, read, write
    from varishold.recording.grasp_csv import iter_grasp_table, read_grasp_table, write_grasp_table
    from varishold.recording.grasp_table import GraspTable
    from varishold.recording.height_map import read_height_map
    from varishold.recording.inspection import Summary, faults_of, summarize
    from varishold.recording.pad import UNNAMED_PAD, Pad, frame_of
    from varishold.recording.press_table import Mark, PressTable
    from varishold.recording.pressure_unit import pascals_per_unit
    from varishold.recording.recording import Recording
    from varishold.recording.selection import peak_frame, presses, select_frames
    from varishold.recording.signals import Signals
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
