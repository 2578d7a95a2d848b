"""What is seen as lines of JSON: a line a reading, a line an event, a line a press that was named."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from varishold.live.stream import Change
from varishold.live.watcher import Seen

__all__ = ["change_line", "lines_of"]


def lines_of(seen: Seen) -> Iterator[dict[str, Any]]:
    """Yield the lines of a reading, as plain values that JSON can hold.

    First ``"line": "frame"`` with all contacts, then ``"event"`` for what happened, ``"zero"`` for a zero that was
    taken or refused, ``"remarks"`` where others are made of a pad than before, and ``"press"`` for each press that has
    ended and was named meanwhile.
    """
    if seen.sample is not None:
        yield {
            "line": "frame",
            "frame": seen.number,
            "time_s": seen.time_s,
            "device_time_s": seen.sample.device_time_s,
            "host_time_s": seen.sample.host_time_s,
            "sequence": seen.sample.sequence,
            "contacts": [track.to_dict() for pad in seen.pads.values() for track in pad.tracks],
        }
    for name, pad in seen.pads.items():
        for event in pad.events:
            yield {"line": "event", "frame": seen.number, **event.to_dict()}
        for zeroing in pad.zeroings:
            yield {"line": "zero", "frame": seen.number, "pad": name, **zeroing.to_dict()}
        if pad.is_news:
            yield {"line": "remarks", "frame": seen.number, "pad": name, "remarks": list(pad.remarks)}
    for named in seen.named:
        if named.over:
            yield {"line": "press", **named.to_dict()}


def change_line(change: Change) -> dict[str, Any]:
    """Return the line that tells of a source that was opened, lost or has ended."""
    return {"line": "source", "host_time_s": change.host_time_s, "state": change.state, "words": change.words}
