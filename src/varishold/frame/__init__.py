"""What is true of one frame of numbers, or of a short run of frames.

What a frame must be (`checks`), how much of it is noise (`frame_noise`, `recording_noise`, `timed_noise`), what stood
where taxels are broken (`fill_invalid`), and whether its taxels live (`health`).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from varishold.frame.checks import as_pitch

if TYPE_CHECKING:
    from varishold.frame.fill import fill_invalid
    from varishold.frame.noise import frame_noise
    from varishold.frame.quiet import recording_noise, timed_noise

# Compiled code: whoever only reads or writes a file need not wait for it.
_COMPILED = {"fill_invalid": "fill", "frame_noise": "noise", "recording_noise": "quiet", "timed_noise": "quiet"}

__all__ = ["as_pitch", "fill_invalid", "frame_noise", "recording_noise", "timed_noise"]


def __getattr__(name: str) -> Any:
    if name in _COMPILED:
        return getattr(importlib.import_module(f"varishold.frame.{_COMPILED[name]}"), name)
    raise AttributeError(f"module 'varishold.frame' has no attribute {name!r}")
