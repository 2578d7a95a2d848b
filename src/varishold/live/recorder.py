"""A recorder: a thread that writes every sample of a source to a file."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Mapping
from threading import Event, Thread
from types import TracebackType
from typing import Any, Protocol, Self

from varishold.errors import EndOfSourceError
from varishold.live.sample import PadLayout, Sample
from varishold.live.sample_file import Limits, SampleFile, Tally, sample_file
from varishold.live.source import Source, damage_of, damaged_of, overrun_of
from varishold.live.stream import Stream
from varishold.live.taken import taken

__all__ = ["Recorder"]

# So often the thread takes what has come, and looks whether it is still wanted. Seconds.
_LOOK_S = 0.05


class Recorder:
    """Writes samples to a file in a thread of its own, until there are no more or it is closed.

    What was written is readable at any moment but for the last half second, however the process ends.

    Parameters
    ----------
    source : Stream or Source
        A stream's samples are written from the oldest on that its ring keeps; the ring must hold what comes while this
        machine is busy. A source that is not yet opened is read by this thread alone, and waits for it: for recordings
        and simulations that go as fast as they can.
    path : str or path-like
        The MCAP file; what is there is replaced when the first sample has come.
    sensor : str
        What the sensor is called.
    files : mapping of str to str, optional
        The texts of the sensor file and its maps, by name.
    limits : Limits, optional
        Where it ends by itself.
    from_now : bool
        Leave out what a stream's ring holds already.

    Attributes
    ----------
    tally : Tally
        What was written so far.

    Examples
    --------
    >>> import tempfile
    >>> from varishold import read
    >>> from varishold.live import Recorder, source_at
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = f"{folder}/sphere.mcap"
    ...     with Recorder(source_at("sim:sphere?speed=0&duration_s=2"), file) as recorder:
    ...         recorder.mark("sphere")
    ...         ended = recorder.wait(60)
    ...     recorder.tally.samples, read(file).n_frames
    (200, 200)
    """

    def __init__(
        self,
        source: Stream | Source,
        path: str | os.PathLike[str],
        *,
        sensor: str = "",
        files: Mapping[str, str] | None = None,
        limits: Limits | None = None,
        from_now: bool = False,
    ) -> None:
        self.tally = Tally()
        self._feed: _Feed = _Streamed(source, from_now) if isinstance(source, Stream) else _Read(source)
        self._path, self._sensor, self._files, self._limits = path, sensor, files, limits
        self._marks: deque[tuple[Mapping[str, Any], float, bool]] = deque()
        self._unwanted, self._ended = Event(), Event()
        self._failure: Exception | None = None
        self._thread = Thread(target=self._run, name=f"varishold records {path}", daemon=True)

    @property
    def missed(self) -> int:
        """How many samples had left the stream's ring before they were written."""
        return self._feed.missed

    @property
    def address(self) -> str:
        """Where the source is."""
        return self._feed.source.address

    @property
    def damaged(self) -> int:
        """How often something came that could not be used, as far as the source counts that."""
        return damaged_of(self._feed.source)

    @property
    def damage(self) -> str:
        """What was wrong with the newest of that, as far as the source says so."""
        return damage_of(self._feed.source)

    @property
    def overrun(self) -> int:
        """How many messages came faster than they were read and are lost, as far as the source knows."""
        return overrun_of(self._feed.source)

    def start(self) -> Self:
        """Begin; may be called once."""
        self._thread.start()
        return self

    def mark(self, label: str, **more: Any) -> None:
        """Say what is felt from now on, to be found beside the samples."""
        self._marks.append(({"label": label, **more}, time.time(), False))

    def zeroed(self, entry: Mapping[str, Any]) -> None:
        """Say that a zero was taken or refused."""
        self._marks.append((entry, time.time(), True))

    def wait(self, timeout_s: float) -> bool:
        """Wait until it has ended by itself; tell whether it has."""
        return self._ended.wait(timeout_s)

    def close(self) -> None:
        """Write what has come so far, and end. May be called again.

        Raises
        ------
        InputError
            If the file could not be written, or the source can never be read.
        LostSourceError
            If it read the source itself, and that is not there, or no more.
        """
        self._unwanted.set()
        if self._thread.ident is not None:
            self._thread.join()
        if self._failure is not None:
            raise self._failure

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run(self) -> None:
        try:
            with sample_file(
                self._path, lambda: self._feed.pads, sensor=self._sensor, files=self._files, limits=self._limits
            ) as file:
                self.tally = file.tally
                self._write(file)
        except Exception as failure:
            # Whoever closes it is told.
            self._failure = failure
        finally:
            self._feed.close()
            self._ended.set()

    def _write(self, file: SampleFile) -> None:
        over = False
        while not (over or file.full):
            # What came before it was unwanted is still written.
            unwanted = self._unwanted.is_set()
            samples, over = self._feed.take()
            while self._marks:
                told, host_time_s, zero = self._marks.popleft()
                file.mark(told, host_time_s, zero=zero)
            for sample in samples:
                file.add(sample)
            file.look()
            over = over or unwanted
            if not (over or samples):
                self._unwanted.wait(self._feed.pause_s)


class _Feed(Protocol):
    """Where samples are taken from."""

    @property
    def source(self) -> Stream | Source: ...

    @property
    def pads(self) -> Mapping[str, PadLayout]: ...

    @property
    def missed(self) -> int: ...

    @property
    def pause_s(self) -> float:
        """How long to wait where nothing has come."""
        ...

    def take(self) -> tuple[list[Sample], bool]:
        """Return what has come, and whether that was all."""
        ...

    def close(self) -> None: ...


class _Streamed:
    """The samples of a stream, which waits for nobody."""

    pause_s = _LOOK_S

    def __init__(self, stream: Stream, from_now: bool) -> None:
        self.source, self._reader = stream, stream.reader()
        if from_now:
            self._reader.skip_all()

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self.source.pads

    @property
    def missed(self) -> int:
        return self._reader.missed

    def take(self) -> tuple[list[Sample], bool]:
        # Asked for before what came is taken, so that nothing comes after.
        ended = self.source.state == "ended"
        return self._reader.read(), ended

    def close(self) -> None:
        """The stream is somebody else's."""


class _Read:
    """The samples of a source, which waits until they are taken."""

    # A read waits itself, or gives part of a reading.
    missed, pause_s = 0, 0.0

    def __init__(self, source: Source) -> None:
        self.source, self._opened = source, False

    @property
    def pads(self) -> Mapping[str, PadLayout]:
        return self.source.pads

    def take(self) -> tuple[list[Sample], bool]:
        if not self._opened:
            self.source.open()
            self._opened = True
        try:
            return taken(self.source, _LOOK_S), False
        except EndOfSourceError:
            return [], True

    def close(self) -> None:
        self.source.close()
