"""A source that is watched for whoever looks: the newest reading, what happened, and what can be asked for."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError
from varishold.live.event_log import EventLog
from varishold.live.lull import Lull
from varishold.live.page_recorder import PageRecorder, free_path
from varishold.live.press_keeper import KeptPress
from varishold.live.press_namer import NamedPress
from varishold.live.sample import Sample
from varishold.live.since import since
from varishold.live.source import Source
from varishold.live.status import source_status
from varishold.live.stream import Change, Stream
from varishold.live.teaching import Teaching
from varishold.live.watcher import Seen, Watcher

if TYPE_CHECKING:
    from varishold.learning import PressClassifier
    from varishold.perceive import Perceiver
    from varishold.sensor import Sensor

__all__ = ["Session"]

# So often a silent source is looked at. Seconds.
_LOOK_S = 0.05
# Who is later than this goes on with the newest reading. Seconds.
_LATE_S = 0.2
# Readings that wait for a recording while this machine is busy with something else.
_KEPT = 4096
_MOST_LOOKED_AT = 8


class Session:
    """Watches a source in a thread of its own.

    Parameters
    ----------
    source : Source
        Not yet opened.
    sensor, model, levels
        As `Watcher` takes them.
    on_seen : callable, optional
        Called in the watching thread with each reading.
    folder : path-like, optional
        Where recordings and models are written. Default: nothing is.

    Attributes
    ----------
    events : EventLog
        What has happened.
    newest : Seen or None
        The newest reading, with the newest of every pad.
    looked_at : deque of str
        Keys of contacts that somebody looks at, as far as that is remembered.
    on_news : callable or None
        Called in the watching thread whenever there is something new; it must not take long.
    failure : Exception or None
        Why nothing is watched any more: the source can never be read, or `on_seen` failed.
    """

    def __init__(
        self,
        source: Source,
        *,
        sensor: Sensor | None = None,
        model: PressClassifier | Perceiver | None = None,
        levels: int = 32,
        on_seen: Callable[[Seen], object] | None = None,
        folder: str | Path | None = None,
    ) -> None:
        self.stream = Stream(source, keep=_KEPT)
        self.events = EventLog()
        self.newest: Seen | None = None
        self.on_news: Callable[[], object] | None = None
        self._watcher = Watcher(sensor=sensor, model=model, levels=levels)
        self._teaching = Teaching(self._learned)
        self._folder = None if folder is None else Path(folder)
        self._recorder = None if folder is None else self._page_recorder(folder, sensor)
        self._asked: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self.looked_at: deque[str] = deque(maxlen=_MOST_LOOKED_AT)
        self._left_out = self._missed = 0
        self._named: NamedPress | None = None
        self._last_change: Change | None = None
        self._lull = Lull(time.monotonic())
        self.failure: Exception | None = None
        self._on_seen = on_seen
        self._unwanted, self._over = Event(), Event()
        self._thread = Thread(target=self._run, name="varishold watches", daemon=True)

    def __enter__(self) -> Session:
        self.stream.start()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._unwanted.set()
        if self._recorder is not None:
            self._recorder.close()
        self.stream.close()
        self._thread.join()
        self._teaching.close()
        self._watcher.close()

    def wait_over(self, timeout_s: float) -> bool:
        """Wait until the source has ended, or nothing is watched any more; tell whether that is so."""
        return self._over.wait(timeout_s)

    @property
    def named(self) -> NamedPress | None:
        """What the model says of the press that lasts, or of the last one; or a perceiver of the object."""
        return self._named

    def status(self) -> dict[str, Any]:
        """Return how the source and everything around it are, as JSON holds it."""
        told = source_status(self.stream, dict(self._watcher.pads), self.newest)
        if self.failure is not None:
            told["words"] = str(self.failure)
        elif told["state"] == "open":
            clock = told["health"]["stream"]["odd_clock"]
            told["words"] = "; ".join(
                filter(None, [self._lull.damage, clock and f"{clock}; the time of arrival is taken"])
            )
        return {
            **told,
            "left_out": self._left_out + self._missed,
            "can_record": self._recorder is not None,
            "recording": None if self._recorder is None else self._recorder.to_dict(),
            "teaching": self._teaching.to_dict(),
            "model": self._known(),
            "objects": self._watcher.perceiver is not None,
        }

    def look_at(self, track: str) -> None:
        """Say more of a contact from now on, however light it is."""
        self.looked_at.append(track)

    def ask_zero(self) -> None:
        """Take the zero of every pad anew; whether it was taken or refused is told as an event."""

        def ask() -> None:
            for pad in self._watcher.pads.values():
                pad.ask_zero(self._watcher.now_s)

        self._asked.put(ask)

    def next_object(self) -> None:
        """Say that another object is pressed from now on.

        Raises
        ------
        InputError
            If no library was given to know objects from.
        """
        if self._watcher.perceiver is None:
            raise InputError("objects are told apart by a library; none was given")
        self._watcher.next_object()

    def set_label(self, label: str | None) -> None:
        """Keep the presses that come under this label; None for under none. InputError if it is none."""
        self._teaching.set_label(label)
        if self._recorder is not None:
            self._recorder.mark(label)

    def record(self, on: bool) -> str:
        """Begin or end to write what comes to a file; return what is done, in words.

        Raises
        ------
        InputError
            If it is being done already, or no folder was given.
        """
        if self._recorder is None:
            raise InputError("no folder was given to record to")
        if on:
            label = self._teaching.to_dict()["label"]
            return f"recording to {self._recorder.begin(label)}"
        self._recorder.end()
        return "the recording is ended"

    def save(self) -> str:
        """Write the model that names presses to a file; return where, in words.

        Raises
        ------
        InputError
            If there is none, no folder was given, or it cannot be written.
        """
        classifier = self._watcher.classifier
        if classifier is None:
            raise InputError("nothing was learned yet")
        if self._folder is None:
            raise InputError("no folder was given to write to")
        from varishold.learning import write_model

        path = free_path(self._folder, ".npz")
        write_model(classifier, path)
        return f"saved as {path}"

    def forget(self, label: str) -> None:
        """Forget the presses of a label."""
        self._teaching.forget(label)

    def learn(self) -> None:
        """Learn from the presses that were kept, and name presses by it; InputError if there are too few."""
        self._teaching.learn()

    def _known(self) -> list[str] | None:
        """Return the names that presses can get."""
        classifier, perceiver = self._watcher.classifier, self._watcher.perceiver
        if perceiver is not None:
            return list(perceiver.library.objects)
        return None if classifier is None else [str(label) for label in classifier.classes_]

    def _page_recorder(self, folder: str | Path, sensor: Sensor | None) -> PageRecorder:
        def tell(well: bool, words: str) -> None:
            self.events.add("recorded" if well else "refused", self._watcher.now_s, words)
            self._tell()

        if sensor is None:
            return PageRecorder(self.stream, folder, tell)
        from varishold.sensor import sensor_texts

        return PageRecorder(self.stream, folder, tell, sensor=sensor.name, files=sensor_texts(sensor))

    def _learned(self, model: PressClassifier) -> None:
        def take() -> None:
            self._watcher.learned(model)
            self._named = None

        self._asked.put(take)

    def _run(self) -> None:
        reader = self.stream.reader()
        try:
            while not self._unwanted.is_set():
                samples = reader.read(_LOOK_S)
                self._do_what_is_due()
                self._watcher.layouts = self.stream.pads
                ended = not samples and self.stream.state == "ended"
                self._see(samples, reader.number - len(samples))
                self._publish(self._watcher.meanwhile())
                self._missed = reader.missed
                self._tell_changes()
                self._tell_lull()
                if ended:
                    break
            self._publish(self._watcher.finish())
        except Exception as failure:
            # Whoever runs this is told, and the page.
            self.failure = failure
        self._over.set()
        while not self._unwanted.wait(_LOOK_S):
            self._do_what_is_due()

    def _see(self, samples: list[Sample], first: int) -> None:
        begun = time.monotonic()
        for k, sample in enumerate(samples):
            if time.monotonic() - begun > _LATE_S and k + 1 < len(samples):
                self._left_out += 1
                continue
            self._publish(self._watcher.see(sample, number=first + k))

    def _publish(self, seen: Seen | None) -> None:
        if seen is None:
            return
        if self._on_seen is not None:
            self._on_seen(seen)
        self.events.add_seen(seen)
        if self._recorder is not None:
            for name, pad in seen.pads.items():
                for zeroing in pad.zeroings:
                    self._recorder.zeroed({"pad": name, **zeroing.to_dict()})
        if seen.ended is not None:
            self._keep(seen.ended, seen.time_s)
        self._named = seen.named[-1] if seen.named else self._named
        newest = self._watcher.newest
        self.newest = seen if len(seen.pads) == len(newest) else replace(seen, pads=dict(newest))
        self._tell()

    def _keep(self, ended: KeptPress, time_s: float) -> None:
        """Keep a press that has ended under the label that is set; none of readings that go the wrong way."""
        if (why := self._watcher.wrong_way) is not None:
            if self._teaching.label is not None:
                self.events.add("refused", time_s, f"the press is not kept: {why}")
        elif (kept := self._teaching.take(ended)) is not None:
            self.events.add("kept", time_s, f"press {kept[1]} of {kept[0]} kept")

    def _tell_changes(self) -> None:
        for change in since(self.stream.changes, self._last_change):
            self._last_change = change
            self.events.add_change(change, self._watcher.now_s)
            self._tell()

    def _tell_lull(self) -> None:
        """Tell once that no readings come any more, much that is none, or more than can be read."""
        stream, now_s = self.stream, time.monotonic()
        if stream.state != "open":
            self._lull.restart(now_s)
        elif words := self._lull.look(stream.received, stream, now_s):
            self.events.add("silent", self._watcher.now_s, words)
            self._tell()

    def _tell(self) -> None:
        if (told := self.on_news) is not None:
            told()

    def _do_what_is_due(self) -> None:
        """Do what was asked for, and end a recording that has ended by itself."""
        if self._recorder is not None:
            self._recorder.look()
        while True:
            try:
                self._asked.get_nowait()()
            except Empty:
                return
