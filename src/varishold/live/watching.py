"""Watching a source from its first reading to its last."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from varishold.live.lull import Lull, unused_words
from varishold.live.sample import Sample
from varishold.live.since import since
from varishold.live.source import Source, damage_of, damaged_of
from varishold.live.sources import source_at
from varishold.live.stream import Change, State, Stream, batches_of
from varishold.live.taken import as_source
from varishold.live.watcher import Seen, Watcher
from varishold.touch.tracking.event import Event

if TYPE_CHECKING:
    from varishold.learning import PressClassifier
    from varishold.perceive import Perceiver
    from varishold.sensor import Sensor

__all__ = ["watch"]

# So often a silent source is looked at. Seconds.
_LOOK_S = 0.05


def watch(
    source: Source | str,
    *,
    sensor: Sensor | None = None,
    model: PressClassifier | Perceiver | None = None,
    levels: int = 32,
    every: bool = False,
    on_event: Callable[[str, Event], object] | None = None,
    on_change: Callable[[Change], object] | None = None,
) -> Iterator[Seen]:
    """Yield what is seen in each reading of a source, until it ends; a source that was lost is waited for.

    Parameters
    ----------
    source : Source or str
        Not yet opened; or its address.
    sensor : Sensor, optional
        What makes the readings.
    model : PressClassifier or Perceiver, optional
        Names each press, or the object by all presses of it, as in `Watcher`.
    levels : int
        Thresholds a contact.
    every : bool
        Let the source wait, so that no reading is missed: for recordings and simulations. Otherwise a thread reads it,
        and readings are left out where this one falls far behind.
    on_event : callable, optional
        Called with the pad's name and each event.
    on_change : callable, optional
        Called when the source is opened, lost or has ended; once, with words, where it is open and brings no readings,
        much that is none, or more than can be read.

    Yields
    ------
    Seen
        Names of presses may come between readings: then there is no sample. The last one has none either: it tells what
        ends with the source.

    Raises
    ------
    InputError
        If the source can never be read as it was asked for, or the sensor is another's.
    LostSourceError
        With `every`, if the source is not there, or no more.

    Examples
    --------
    >>> from varishold.live import watch
    >>> kinds = []
    >>> seen = watch("sim:sphere?speed=0&duration_s=4&rest_s=2", every=True, on_event=lambda _, e: kinds.append(e.kind))
    >>> *_, last = seen
    >>> last.number, kinds[0], kinds[-1]
    (400, 'touched', 'released')
    """
    source = source_at(source) if isinstance(source, str) else as_source(source)

    def told(seen: Seen) -> Seen:
        if on_event is not None:
            for name, pad in seen.pads.items():
                for event in pad.events:
                    on_event(name, event)
        return seen

    with Watcher(sensor=sensor, model=model, levels=levels) as watcher:
        for number, sample in _all_of(source, on_change) if every else _newest_of(source, on_change):
            watcher.layouts = source.pads
            seen = watcher.meanwhile() if sample is None else watcher.see(sample, number=number)
            if seen is not None:
                yield told(seen)
        if (last := watcher.finish()) is not None:
            yield told(last)


def _all_of(source: Source, on_change: Callable[[Change], object] | None) -> Iterator[tuple[int, Sample | None]]:
    """Yield each sample with its number; tell that the source is opened and has ended, and what of it was of no use."""
    tell: Callable[[Change], object] = on_change or (lambda _: None)
    tell(Change(time.time(), "opening", ""))
    lull, number = Lull(time.monotonic()), 0
    state: State = "opening"
    for samples in batches_of(source):
        if samples and state == "opening":
            state = "open"
            tell(Change(time.time(), "open", ""))
        if words := lull.look(number + len(samples), source, time.monotonic()):
            tell(Change(time.time(), state, words))
        yield from enumerate(samples, number)
        number += len(samples)
    tell(Change(time.time(), "ended", unused_words(damaged_of(source), damage=damage_of(source))))


def _newest_of(source: Source, on_change: Callable[[Change], object] | None) -> Iterator[tuple[int, Sample | None]]:
    """Yield each sample with its running number, None while none comes; tell each change of the source's state."""
    told: Change | None = None
    lull = Lull(time.monotonic())
    with Stream(source) as stream:
        reader = stream.reader()
        while True:
            samples = reader.read(_LOOK_S)
            # What is said last is said of what was read first.
            ended = not samples and stream.state == "ended"
            for change in since(stream.changes, told):
                told = change
                if on_change is not None:
                    on_change(change)
            if stream.state != "open":
                lull.restart(time.monotonic())
            else:
                words = lull.look(stream.received, stream, time.monotonic())
                if words and on_change is not None:
                    on_change(Change(time.time(), "open", words))
            yield from enumerate(samples, reader.number - len(samples))
            if not samples:
                yield reader.number, None
            if ended:
                return
