"""Presses named by a model that was learned, in a thread of its own: no reading waits for it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from threading import Condition, Thread
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError
from varishold.live.press_keeper import KeptPress

if TYPE_CHECKING:
    from varishold.learning import Recognition, TactileClassifier

__all__ = ["NamedPress", "PressNamer"]

# Presses that wait for their name; of more the oldest go without one.
_MOST_WAITING = 64


@dataclass(frozen=True, eq=False)
class NamedPress:
    """What a model says of a press.

    Parameters
    ----------
    number : int
        Of the press, counted from 0.
    start_s, end_s : float
        When it first and last touched.
    over : bool
        Whether the press has ended; otherwise it is what there was of it so far.
    recognition : Recognition or None
        None where the model cannot say anything of it.
    words : str
        Why it cannot; empty where it can.
    """

    number: int
    start_s: float
    end_s: float
    over: bool
    recognition: Recognition | None
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
    model : TactileClassifier
        It has learned.
    """

    def __init__(self, model: TactileClassifier) -> None:
        self.model = model
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
            return NamedPress(*about, self.model.explain([kept.press])[0])
        except InputError as error:
            return NamedPress(*about, None, str(error))
