"""The recording: what a sensor said, before anybody has asked what it means.

Every file goes through here: `atomic_write` is the one way in which the package writes.
"""

from __future__ import annotations

from varishold.recording.atomic import atomic_write

__all__ = ["atomic_write"]
