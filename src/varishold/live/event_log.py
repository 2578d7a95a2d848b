"""What has happened, in words, as far as anybody may still ask for it."""

from __future__ import annotations

import time
from collections import deque
from threading import Lock
from typing import Any

from varishold.live.stream import Change
from varishold.live.watcher import Seen
from varishold.live.words import event_words, named_line, zeroing_words

__all__ = ["EventLog"]

_MOST = 200


class EventLog:
    """Things that happened, numbered from 0; any thread may add and ask.

    An entry has ``number``, ``kind``, ``time_s`` (the sensor's), ``host_time_s``, ``words``, and ``pad`` and ``track``
    where it is of one.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._entries: deque[dict[str, Any]] = deque(maxlen=_MOST)
        self._state = ""
        #: How many things have happened.
        self.count = 0

    def since(self, number: int) -> list[dict[str, Any]]:
        """Return what happened from a running number on, as far as it is remembered, oldest first."""
        with self._lock:
            return [entry for entry in self._entries if entry["number"] >= number]

    def add(self, kind: str, time_s: float, words: str, *, pad: str = "", track: int | None = None) -> None:
        """Add what happened."""
        with self._lock:
            entry = {"number": self.count, "kind": kind, "time_s": time_s, "host_time_s": time.time()}
            entry |= {"words": words, "pad": pad, "track": None if track is None else f"{pad}/{track}"}
            self._entries.append(entry)
            self.count += 1

    def add_seen(self, seen: Seen) -> None:
        """Add what happened in a reading."""
        for name, pad in seen.pads.items():
            for event in pad.events:
                self.add(event.kind, event.time_s, event_words(event), pad=name, track=event.track)
            for zeroing in pad.zeroings:
                kind = "zero" if zeroing.taken else "refused"
                self.add(kind, zeroing.time_s, zeroing_words(zeroing), pad=name)
        for named in seen.named:
            if named.over:
                self.add("named", named.end_s, named_line(named))

    def add_change(self, change: Change, time_s: float) -> None:
        """Add that the source was opened, lost or has ended; that it is still lost is no news."""
        if change.state != self._state:
            self._state = change.state
            self.add(change.state, time_s, f"source {change.state}")
