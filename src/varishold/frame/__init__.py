"""What is true of one frame of numbers, or of a short run of frames.

What a frame must be (`checks`), how much of it is noise (`frame_noise`, `recording_noise`, `timed_noise`), what stood
where taxels are broken (`fill_invalid`), whether its taxels live (`health`). While frames come: what they
show when nothing presses (`FollowingZero`), and how its taxels are (`TaxelHealth`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "BadTaxel",
    "FollowingZero",
    "HealthReport",
    "TaxelHealth",
    "Zeroing",
    "as_pitch",
    "fill_invalid",
    "frame_noise",
    "recording_noise",
    "timed_noise",
]

if TYPE_CHECKING:
    from varishold.frame.checks import as_pitch
    from varishold.frame.fill import fill_invalid
    from varishold.frame.health_report import BadTaxel, HealthReport
    from varishold.frame.noise import frame_noise
    from varishold.frame.quiet import recording_noise, timed_noise
    from varishold.frame.running_health import TaxelHealth
    from varishold.frame.zero import FollowingZero, Zeroing
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
