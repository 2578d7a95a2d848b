"""Live: any sensor on the wire, watched while it is touched, and recorded as it came."""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "PadLayout",
    "Reader",
    "Recorder",
    "Sample",
    "Seen",
    "Source",
    "Stream",
    "StreamHealth",
    "StreamReport",
    "Watcher",
    "samples_of",
    "source_at",
    "watch",
]

if TYPE_CHECKING:
    from varishold.live.health import StreamHealth, StreamReport
    from varishold.live.recorder import Recorder
    from varishold.live.sample import PadLayout, Sample
    from varishold.live.source import Source
    from varishold.live.sources import source_at
    from varishold.live.stream import Reader, Stream, samples_of
    from varishold.live.watcher import Seen, Watcher
    from varishold.live.watching import watch
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
