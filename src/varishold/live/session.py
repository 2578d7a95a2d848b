"""A source that is watched for whoever looks: the newest reading, what happened, and what can be asked for."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any

from varishold.errors import InputError
from varishold.live.page_recorder import PageRecorder
from varishold.live.press_namer import NamedPress
from varishold.live.sample import Sample
from varishold.live.since import since
from varishold.live.source import Source
from varishold.live.stream import Change, Stream
from varishold.live.teaching import Teaching
from varishold.live.watcher import Seen, Watcher
from varishold.live.words import event_words, named_line
from varishold.report.quantities import length, reading

if TYPE_CHECKING:
    from varishold.frame import HealthReport
    from varishold.learning import TactileClassifier
    from varishold.sensor import Sensor

__all__ = ["Session"]

# So often a silent source is looked at. Seconds.
_LOOK_S = 0.05
# Who is later than this goes on with the newest reading. Seconds.
_LATE_S = 0.2
_MOST_EVENTS = 200
# Readings that wait for a recording while this machine is busy with something else.
_KEPT = 4096
# Pads whose size is told.
_MOST_PADS = 6
# Remarks on taxels.
_MOST_REMARKS = 8
# The rate is that of so long. Seconds.
_RATE_S = 2.0


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
        Where recordings are written. Default: nothing is recorded.

    Attributes
    ----------
    newest : Seen or None
        The newest reading, with the newest of every pad.
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
        model: TactileClassifier | None = None,
        levels: int = 32,
        on_seen: Callable[[Seen], object] | None = None,
        folder: str | Path | None = None,
    ) -> None:
        self.stream = Stream(source, keep=_KEPT)
        self.newest: Seen | None = None
        self.on_news: Callable[[], object] | None = None
        self._watcher = Watcher(sensor=sensor, model=model, levels=levels)
        self._model = model
        self._teaching = Teaching(self._learned)
        self._recorder = None if folder is None else self._page_recorder(folder, sensor)
        self._asked: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._lock = Lock()
        self._events: deque[dict[str, Any]] = deque(maxlen=_MOST_EVENTS)
        self._n_events = self._left_out = 0
        self._named: NamedPress | None = None
        self._came: deque[tuple[float, int]] = deque([(time.monotonic(), 0)])
        self._last_change: Change | None = None
        self._seen_at = time.monotonic()
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
    def n_events(self) -> int:
        """How many things have happened."""
        return self._n_events

    def events_since(self, number: int) -> list[dict[str, Any]]:
        """Return what happened from a running number on, as far as it is remembered, oldest first."""
        with self._lock:
            return [event for event in self._events if event["number"] >= number]

    @property
    def named(self) -> NamedPress | None:
        """What the model says of the press that lasts, or of the last one."""
        return self._named

    def status(self) -> dict[str, Any]:
        """Return how the source and everything around it are, as JSON holds it."""
        stream, watcher = self.stream, self._watcher
        sent = stream.health.report(time.time())
        taxels = {name: pad.how_it_is() for name, pad in list(watcher.pads.items())}
        now, received = time.monotonic(), stream.received
        self._came.append((now, received))
        while len(self._came) > 2 and now - self._came[1][0] > _RATE_S:
            self._came.popleft()
        since, before = self._came[0]
        rate_hz = (received - before) / (now - since) if now > since else 0.0
        return {
            "address": stream.address,
            "state": stream.state,
            "words": stream.words if self.failure is None else str(self.failure),
            "rate_hz": round(rate_hz, 1),
            "received": received,
            "left_out": self._left_out,
            "silent_s": round(now - self._seen_at, 2),
            "facts": self._facts(),
            "remarks": [*sent.remarks, *_remarks(taxels)],
            "broken": {name: _broken(report) for name, report in taxels.items()},
            "health": {"stream": sent.to_dict(), "pads": {name: report.to_dict() for name, report in taxels.items()}},
            "can_record": self._recorder is not None,
            "recording": None if self._recorder is None else self._recorder.to_dict(),
            "zero": {name: pad.zero.state for name, pad in list(watcher.pads.items())},
            "teaching": self._teaching.to_dict(),
            "model": None if self._model is None else [str(label) for label in self._model.classes_],
        }

    def _facts(self) -> list[list[str]]:
        """Return what is known of the pads, as pairs of a name and a text."""
        facts = []
        pads = list(self._watcher.pads.items())
        for name, pad in pads[:_MOST_PADS]:
            rows, cols = pad.shape
            pitch = "" if pad.pitch_m is None else f" at {length(pad.pitch_m[0], metres=True)}"
            facts.append(["taxels" if len(pads) == 1 else name, f"{rows} × {cols}{pitch}"])
        newest = self.newest
        if newest is not None:
            noise = [pad.sigma for pad in newest.pads.values() if pad.sigma]
            units = {pad.unit for pad in newest.pads.values()}
            if noise and len(units) == 1:
                facts.append(["noise σ", reading(max(noise), units.pop())])
        return facts

    def ask_zero(self) -> None:
        """Take the zero of every pad anew; whether it was taken or refused is told as an event."""

        def ask() -> None:
            for pad in self._watcher.pads.values():
                pad.ask_zero(self._watcher.now_s)

        self._asked.put(ask)

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

    def forget(self, label: str) -> None:
        """Forget the presses of a label."""
        self._teaching.forget(label)

    def learn(self) -> None:
        """Learn from the presses that were kept, and name presses by it; InputError if there are too few."""
        self._teaching.learn()

    def _page_recorder(self, folder: str | Path, sensor: Sensor | None) -> PageRecorder:
        def tell(well: bool, words: str) -> None:
            self._happened("recorded" if well else "refused", self._watcher.now_s, words)
            self._tell()

        if sensor is None:
            return PageRecorder(self.stream, folder, tell)
        from varishold.sensor import sensor_texts

        return PageRecorder(self.stream, folder, tell, sensor=sensor.name, files=sensor_texts(sensor))

    def _learned(self, model: TactileClassifier) -> None:
        def take() -> None:
            self._watcher.learned(model)
            self._model, self._named = model, None

        self._asked.put(take)

    def _run(self) -> None:
        reader = self.stream.reader()
        try:
            while not self._unwanted.is_set():
                samples = reader.read(_LOOK_S)
                self._do_what_was_asked()
                self._watcher.layouts = self.stream.pads
                ended = not samples and self.stream.state == "ended"
                self._see(samples, reader.number - len(samples))
                self._publish(self._watcher.meanwhile())
                self._tell_changes()
                if self._recorder is not None:
                    self._recorder.look()
                if ended:
                    break
            self._publish(self._watcher.finish())
        except Exception as failure:
            # Whoever runs this is told, and the page.
            self.failure = failure
        self._over.set()
        while not self._unwanted.wait(_LOOK_S):
            self._do_what_was_asked()

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
        for name, pad in seen.pads.items():
            for event in pad.events:
                self._happened(event.kind, event.time_s, event_words(event), name, track=event.track)
            for zeroing in pad.zeroings:
                what = "zero taken" if zeroing.taken else "zero refused"
                words = f"{what}: {zeroing.reason}" if zeroing.reason else what
                self._happened("zero" if zeroing.taken else "refused", zeroing.time_s, words, name)
                if self._recorder is not None:
                    self._recorder.zeroed({"pad": name, **zeroing.to_dict()})
        if seen.ended is not None and (kept := self._teaching.take(seen.ended)) is not None:
            self._happened("kept", seen.time_s, f"press {kept[1]} of {kept[0]} kept")
        for named in seen.named:
            self._named = named
            if named.over:
                self._happened("named", named.end_s, named_line(named))
        self._seen_at = time.monotonic()
        self.newest = replace(seen, sample=seen.sample, pads=dict(self._watcher.newest))
        self._tell()

    def _tell_changes(self) -> None:
        for change in since(self.stream.changes, self._last_change):
            self._last_change = change
            self._happened(change.state, self._watcher.now_s, f"source {change.state}")
            self._tell()

    def _happened(self, kind: str, time_s: float, words: str, pad: str = "", track: int | None = None) -> None:
        with self._lock:
            event = {"number": self._n_events, "kind": kind, "time_s": time_s, "host_time_s": time.time()}
            event |= {"words": words, "pad": pad}
            self._events.append({**event, "track": None if track is None else f"{pad}/{track}"})
            self._n_events += 1

    def _tell(self) -> None:
        if (told := self.on_news) is not None:
            told()

    def _do_what_was_asked(self) -> None:
        while True:
            try:
                self._asked.get_nowait()()
            except Empty:
                return


def _remarks(reports: Mapping[str, HealthReport]) -> list[str]:
    """Say what is wrong with taxels, of which pad where there are several."""
    told = [(name, remark) for name, report in reports.items() for remark in report.remarks]
    return [remark if len(reports) == 1 else f"{name}: {remark}" for name, remark in told[:_MOST_REMARKS]]


def _broken(report: HealthReport) -> list[list[int]]:
    """Return the places of the taxels that tell nothing."""
    return [[bad.row, bad.col] for bad in report.bad if bad.word in ("dead", "stuck", "open line", "no number")]
