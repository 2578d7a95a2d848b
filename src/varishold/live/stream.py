"""A stream: one thread reads a source, and anybody may look at what came, at his own pace."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Mapping
from threading import Condition, Event, Thread
from types import TracebackType
from typing import Literal, NamedTuple, Self

from varishold.errors import EndOfSourceError, InputError, LostSourceError
from varishold.live.health import StreamHealth
from varishold.live.retry_wait import RetryWait
from varishold.live.sample import PadLayout, Sample
from varishold.live.source import Source, damage_of, damaged_of, overrun_of
from varishold.live.taken import as_source, taken

__all__ = ["Change", "Reader", "State", "Stream", "batches_of", "samples_of"]

State = Literal["opening", "open", "lost", "ended"]

# So long a source may be silent before the thread looks whether it is still wanted. Seconds.
_LOOK_S = 0.1
# So many changes of state are remembered.
_MOST_CHANGES = 256
# So long closing waits for a source that does not keep to its timeout. Seconds.
_LEAVE_S = 10.0


class Change(NamedTuple):
    """When a stream's state changed, and why.

    Parameters
    ----------
    host_time_s : float
        Seconds since 1970.
    state : {"opening", "open", "lost", "ended"}
    words : str
        The error's message; empty where there was none.
    """

    host_time_s: float
    state: State
    words: str


class Stream:
    """A source that is read by a thread of its own, and comes back by itself when it was lost.

    The newest samples are kept in a ring. Whoever reads has a `Reader` of his own, which counts what it was too slow
    for; the thread waits for nobody. Arrays are shared by all readers, hence read-only.

    Parameters
    ----------
    source : Source
        Not yet opened; nobody else may use it.
    keep : int
        How many samples the ring keeps.

    Attributes
    ----------
    health : StreamHealth
        Rate, jitter, what was lost on the way here.

    Raises
    ------
    InputError
        If `keep` is less than 1.

    Examples
    --------
    >>> from varishold.live import source_at
    >>> with Stream(source_at("sim:sphere?seed=1&speed=0&duration_s=1"), keep=1000) as stream:
    ...     reader = stream.reader()
    ...     total = sum(1 for sample in reader)
    >>> total, reader.missed, stream.state
    (100, 0, 'ended')
    """

    def __init__(self, source: Source, *, keep: int = 1024) -> None:
        if keep < 1:
            raise InputError(f"keep must be 1 sample or more, got {keep}")
        self._source = source
        self._keep = keep
        self.health = StreamHealth()
        self._ring: list[Sample] = []
        self._total = 0
        self._news = Condition()
        self._unwanted = Event()
        self._failure: Exception | None = None
        self._changes = deque([Change(time.time(), "opening", "")], _MOST_CHANGES)
        self._thread = Thread(target=self._run, name=f"varishold {source.address}", daemon=True)

    @property
    def address(self) -> str:
        """Where the source is."""
        return self._source.address

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        """The pads that are known so far."""
        return self._source.pads

    @property
    def state(self) -> State:
        """ "opening", "open", "lost" (it is tried again and again) or "ended"."""
        return self._changes[-1].state

    @property
    def words(self) -> str:
        """Why it is lost or has ended, in one line; empty while it is open."""
        return self._changes[-1].words

    @property
    def changes(self) -> tuple[Change, ...]:
        """The newest changes of state, in their order."""
        with self._news:
            return tuple(self._changes)

    @property
    def received(self) -> int:
        """How many samples came so far."""
        return self._total

    @property
    def damaged(self) -> int:
        """How often something came that could not be used, as far as the source counts that."""
        return damaged_of(self._source)

    @property
    def damage(self) -> str:
        """What was wrong with the newest of that, as far as the source says so."""
        return damage_of(self._source)

    @property
    def overrun(self) -> int:
        """How many messages came faster than they were read and are lost, as far as the source knows."""
        return overrun_of(self._source)

    def start(self) -> Self:
        """Let the thread open the source and read it; may be called once."""
        self._thread.start()
        return self

    def close(self) -> None:
        """Stop reading and let the source go; what the ring keeps stays readable. May be called again."""
        self._unwanted.set()
        if self._thread.is_alive():
            self._thread.join(_LEAVE_S)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def newest(self) -> Sample | None:
        """Return the sample that came last; None before the first."""
        with self._news:
            return self._ring[(self._total - 1) % self._keep] if self._total else None

    def reader(self) -> Reader:
        """Return a reader that begins with the oldest sample that is kept."""
        return Reader(self)

    def wait_open(self, timeout_s: float) -> bool:
        """Wait until the source is open; tell whether it is, or was open already and has ended.

        Raises
        ------
        InputError
            If it can never be read as it was asked for.
        """
        with self._news:
            self._news.wait_for(lambda: self.state in ("open", "ended"), timeout_s)
        if self._failure is not None:
            raise self._failure
        return self.state in ("open", "ended")

    def _take(self, number: int, timeout_s: float | None) -> tuple[int, list[Sample]]:
        """Return the number of the first sample from `number` on that is kept, and all from there."""
        with self._news:
            self._news.wait_for(lambda: self._total > number or self.state == "ended", timeout_s)
            first = max(number, self._total - len(self._ring))
            return first, [self._ring[at % self._keep] for at in range(first, self._total)]

    def _put(self, samples: list[Sample]) -> None:
        for sample in samples:
            self.health.add(sample)
        with self._news:
            for sample in samples:
                if len(self._ring) < self._keep:
                    self._ring.append(sample)
                else:
                    self._ring[self._total % self._keep] = sample
                self._total += 1
            self._news.notify_all()

    def _become(self, state: State, words: str = "") -> None:
        with self._news:
            if (self.state, self.words) != (state, words):
                self._changes.append(Change(time.time(), state, words))
            self._news.notify_all()

    def _run(self) -> None:
        wait = RetryWait()
        try:
            while not self._unwanted.is_set():
                opened_s: float | None = None
                try:
                    self._source.open()
                    opened_s = time.monotonic()
                    self._read_on()
                except LostSourceError as lost:
                    self._become("lost", str(lost))
                    there_s = None if opened_s is None else time.monotonic() - opened_s
                    self._unwanted.wait(wait.after_loss(there_s))
                finally:
                    self._source.close()
            self._become("ended", "")
        except EndOfSourceError as end:
            self._become("ended", str(end))
        except Exception as failure:
            # Whoever reads is told: InputError of what can never be read, or a fault of the source's own.
            self._failure = failure
            self._become("ended", str(failure))

    def _read_on(self) -> None:
        self._become("open")
        while not self._unwanted.is_set():
            if came := taken(self._source, _LOOK_S):
                self._put(came)


class Reader:
    """Somebody who reads a stream at his own pace; one thread's only.

    Parameters
    ----------
    stream : Stream

    Attributes
    ----------
    number : int
        The running number, from 0, of the sample that comes next.
    missed : int
        How many samples had left the ring before they were read.
    """

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self.number = 0
        self.missed = 0

    def read(self, timeout_s: float | None = 0.0) -> list[Sample]:
        """Return all samples since the last call, in their order; wait for one so long, None for ever.

        An empty list means that none came within the timeout, or that the stream has ended.

        Raises
        ------
        InputError
            If the source can never be read as it was asked for.
        """
        first, samples = self._stream._take(self.number, timeout_s)
        self.missed += first - self.number
        self.number = first + len(samples)
        if not samples and self._stream._failure is not None:
            raise self._stream._failure
        return samples

    def skip(self) -> None:
        """Go to the newest sample; what is passed over is not missed."""
        self.number = max(self.number, self._stream.received - 1)

    def skip_all(self) -> None:
        """Go to the sample that comes next; what is passed over is not missed."""
        self.number = max(self.number, self._stream.received)

    def __iter__(self) -> Iterator[Sample]:
        """Yield samples until the stream ends; errors as in `read`."""
        while samples := self.read(None):
            yield from samples


def samples_of(source: Source) -> Iterator[Sample]:
    """Yield every sample of a source, read in this thread: none is missed, and the source waits.

    For recordings and simulations that go as fast as they can. It closes the source at its end.

    Raises
    ------
    LostSourceError
        If it is not there, or no more.
    InputError
        If it can never be read as it was asked for.

    Examples
    --------
    >>> from varishold.live import source_at
    >>> sum(1 for _ in samples_of(source_at("sim:cone?speed=0&duration_s=0.5")))
    50
    """
    for samples in batches_of(source):
        yield from samples


def batches_of(source: Source) -> Iterator[list[Sample]]:
    """Yield what every reading of a source brings, which may be nothing; otherwise as `samples_of`."""
    source = as_source(source)
    try:
        source.open()
        while True:
            yield taken(source, _LOOK_S)
    except EndOfSourceError:
        return
    finally:
        source.close()
