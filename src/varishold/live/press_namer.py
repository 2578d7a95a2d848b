"""Presses named by a model that was learned, or by a perceiver, in a thread of their own: no reading waits for it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from threading import Condition, Thread
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError
from varishold.live.press_keeper import KeptPress

if TYPE_CHECKING:
    from varishold.learning import Recognition
    from varishold.live.press_believer import BelievedObject

__all__ = ["NamedPress", "PressNamer"]

# Presses that wait for their name; of more the oldest go without one.
_MOST_WAITING = 64


@dataclass(frozen=True, eq=False)
class NamedPress:
    """What is said of a press.

    Parameters
    ----------
    number : int
        Of the press, counted from 0.
    start_s, end_s : float
        When it first and last touched.
    over : bool
        Whether the press has ended; otherwise it is what there was of it so far.
    recognition : Recognition or BelievedObject or None
        What a model says of this press, or a perceiver of the object by all presses of it; None where nothing can be
        said of it.
    words : str
        Why it cannot; empty where it can.
    """

    number: int
    start_s: float
    end_s: float
    over: bool
    recognition: Recognition | BelievedObject | None
    words: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        told = {} if self.recognition is None else self.recognition.to_dict()
        return {
            **told,
            "press": self.number,
            "start_s": self.start_s,
            "end_s": self.end_s,
            **({"refusal": self.words} if self.words else {}),
        }


class PressNamer:
    """Names one press after the other.

    Parameters
    ----------
    name : callable
        Says of a press what it is; InputError where it cannot.
    """

    def __init__(self, name: Callable[[KeptPress], Recognition | BelievedObject]) -> None:
        self._name = name
        self._news = Condition()
        self._waiting: deque[tuple[KeptPress, bool]] = deque(maxlen=_MOST_WAITING)
        self._done: deque[NamedPress] = deque(maxlen=_MOST_WAITING)
        self._busy = self._unwanted = False
        self._thread = Thread(target=self._run, name="varishold names presses", daemon=True)
        self._thread.start()

    @property
    def idle(self) -> bool:
        """Whether nothing waits for its name."""
        with self._news:
            return not self._waiting and not self._busy

    def ask(self, kept: KeptPress, *, over: bool) -> None:
        """Let a press be named; `done` gives its name later."""
        with self._news:
            self._waiting.append((kept, over))
            self._news.notify_all()

    def done(self) -> list[NamedPress]:
        """Return the presses that have been named since the last call."""
        with self._news:
            named = list(self._done)
            self._done.clear()
            return named

    def finish(self, timeout_s: float) -> list[NamedPress]:
        """Wait until nothing waits for its name, and return as `done`."""
        with self._news:
            self._news.wait_for(lambda: not self._waiting and not self._busy, timeout_s)
        return self.done()

    def close(self) -> None:
        """Name nothing more. May be called again."""
        with self._news:
            self._unwanted = True
            self._news.notify_all()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._news:
                self._busy = False
                self._news.notify_all()
                self._news.wait_for(lambda: self._waiting or self._unwanted)
                if self._unwanted:
                    return
                kept, over = self._waiting.popleft()
                self._busy = True
            named = self._named(kept, over)
            with self._news:
                self._done.append(named)

    def _named(self, kept: KeptPress, over: bool) -> NamedPress:
        about = kept.number, kept.start_s, kept.end_s, over
        try:
            return NamedPress(*about, self._name(kept))
        except InputError as error:
            return NamedPress(*about, None, str(error))
