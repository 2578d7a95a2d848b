"""What goes out to browsers: made once for all of them, and to each what it has not got yet."""

from __future__ import annotations

import json
import math
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

from varishold.live.picture import picture_of
from varishold.live.session import Session
from varishold.live.words import named_words, words_of

__all__ = ["Browser", "Offer"]

# Pictures, words and states of the source go out at most so often. Seconds.
_PICTURE_S, _WORDS_S, _STATUS_S = 0.02, 0.2, 0.5
# A browser that has not shown so many pictures yet gets no further one.
_MOST_UNSHOWN = 2
# A browser that comes is told so much of what happened before. What it asked is answered so many times at once.
_EVENTS_BEFORE, _MOST_ANSWERS = 60, 16


class Offer:
    """Messages that are the same for every browser.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._pictured: object = None
        self._picture = b""
        self._worded: object = None
        self._words, self._words_at = "", -math.inf
        self._status, self._status_at = "", -math.inf

    def picture(self) -> bytes:
        """Return the picture of the newest reading."""
        seen = self.session.newest
        if seen is not self._pictured and seen is not None:
            self._picture = picture_of(seen)
        self._pictured = seen
        return self._picture

    def words(self, now: float) -> str:
        """Return what is said of what touches; it changes no more often than a person reads."""
        seen = self.session.newest
        if seen is not self._worded and seen is not None and now - self._words_at >= _WORDS_S:
            self._worded, self._words_at = seen, now
            named = self.session.named
            told = {
                "tracks": words_of(seen, tuple(self.session.looked_at)),
                "named": None if named is None else named_words(named),
            }
            self._words = _message("words", told)
        return self._words

    def status(self, now: float, *, fresh: bool) -> str:
        """Return how the source is; `fresh` where something has just changed."""
        if now - self._status_at >= (_PICTURE_S if fresh else 0.5 * _STATUS_S):
            self._status, self._status_at = _message("status", self.session.status()), now
        return self._status


class Browser:
    """What one browser has got, and what is due to it.

    Parameters
    ----------
    offer : Offer

    Attributes
    ----------
    answers : deque of dict
        Answers to what it asked.
    """

    def __init__(self, offer: Offer) -> None:
        self.answers: deque[dict[str, Any]] = deque(maxlen=_MOST_ANSWERS)
        self._offer = offer
        self._seen: object = None
        self._sent = self._shown = 0
        self._events = max(offer.session.events.count - _EVENTS_BEFORE, 0)
        self._words = ""
        self._picture_at = self._status_at = -math.inf

    def has_shown(self, count: int) -> bool:
        """Take note that it has shown so many pictures since it came; tell whether it wants one again by that."""
        wanted, self._shown = self.wants_picture, min(max(self._shown, count), self._sent)
        return self.wants_picture and not wanted

    @property
    def wants_picture(self) -> bool:
        """Whether it has shown enough of what it got."""
        return self._sent - self._shown < _MOST_UNSHOWN

    @property
    def wants_news(self) -> bool:
        """Whether it could have the next picture at once: only then is it worth waking for each reading."""
        return self.wants_picture and time.monotonic() - self._picture_at >= _PICTURE_S

    def wait_s(self) -> float:
        """Return after how long something is due to it even if there is no news."""
        now = time.monotonic()
        due = self._status_at + _STATUS_S
        next_picture = self._picture_at + _PICTURE_S
        if self.wants_picture and (next_picture > now or self._offer.session.newest is not self._seen):
            due = min(due, next_picture)
        return max(due - now, 0.0)

    def due(self) -> Iterator[str | bytes]:
        """Yield what is due now: the picture first, for it is what ages."""
        now, offer, session = time.monotonic(), self._offer, self._offer.session
        newest = session.newest
        is_new = newest is not None and newest is not self._seen
        if is_new and self.wants_picture and now - self._picture_at >= _PICTURE_S:
            self._seen, self._picture_at = newest, now
            self._sent += 1
            yield offer.picture()
        while self.answers:
            yield _message("answer", self.answers.popleft())
        happened = session.events.count > self._events
        if happened:
            events = session.events.since(self._events)
            self._events = session.events.count
            yield _message("events", {"events": events})
        if self.wants_picture and (words := offer.words(now)) is not self._words:
            self._words = words
            yield words
        if happened or now - self._status_at >= _STATUS_S:
            self._status_at = now
            yield offer.status(now, fresh=happened)


def _message(kind: str, values: dict[str, Any]) -> str:
    return json.dumps({"kind": kind, **values}, allow_nan=False, separators=(",", ":"))
