"""Samples written to a file as they come, so that all but the last moments are there whenever the writer dies."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.files import GrowingFile, growing_file
from varishold.live.odd_clock import OddClock
from varishold.live.sample import PadLayout, Sample
from varishold.recording.mcap import PadFacts, TopicWriter
from varishold.recording.mcap.clock import nanoseconds
from varishold.recording.mcap.topics import MARKS, ZEROS

__all__ = ["Limits", "SampleFile", "Tally", "sample_file"]

# What came is handed to the system so often, seconds.
_FLUSH_S = 0.4
# Where a recording is to end after some time and nothing comes then, it ends so much later. Seconds.
_LATE_S = 0.5
# A sensor whose numbers jump by more has been started anew.
_MOST_LOST = 10_000


@dataclass(frozen=True)
class Limits:
    """Where a recording ends by itself.

    Parameters
    ----------
    samples : int, optional
        After so many.
    seconds : float, optional
        Before the sample that comes so long after the first.
    """

    samples: int | None = None
    seconds: float | None = None


@dataclass
class Tally:
    """What was written so far.

    Parameters
    ----------
    samples : int
    lost : int
        Readings that the sensor's own numbers tell of, and that never came.
    refused : int
        Readings that were not written, because a pad came in another shape or was none.
    why : str
        What was wrong with the first of them.
    first_s, last_s : float
        When the first and the last came, seconds since 1970.
    odd_clock : str
        Why the sensor's own times cannot be seconds, in words; empty where they can.
    """

    samples: int = 0
    lost: int = 0
    refused: int = 0
    why: str = ""
    first_s: float = math.nan
    last_s: float = math.nan
    odd_clock: str = ""

    @property
    def seconds(self) -> float:
        """From the first reading to the last; 0 where there are not two."""
        return max(self.last_s - self.first_s, 0.0) if self.samples > 1 else 0.0

    @property
    def rate_hz(self) -> float | None:
        """Readings a second; None where they took no time."""
        return (self.samples - 1) / self.seconds if self.seconds > 0 else None


class SampleFile:
    """Takes samples, marks and zeros; as `sample_file` opens it. One thread's only.

    Attributes
    ----------
    tally : Tally
    """

    def __init__(
        self, file: GrowingFile, layouts: Callable[[], Mapping[str, PadLayout]], sensor: str, limits: Limits
    ) -> None:
        self.tally = Tally()
        #: Whether the limits are reached; what comes then is not written.
        self.full = limits.samples == 0
        self._limits = limits
        self._file = file
        self._writer = TopicWriter(file, "measurement")
        self._layouts, self._sensor = layouts, sensor
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._number: int | None = None
        self._clock = OddClock()
        self._flushed_s = time.monotonic()
        self._began_s = math.inf

    def attach(self, texts: Mapping[str, str]) -> None:
        """Put files into the file: the sensor's."""
        for name, text in texts.items():
            self._writer.attach(name, text.encode("utf-8", "replace"), "text/plain")

    def add(self, sample: Sample) -> None:
        """Write a sample, if there is room for it.

        Raises
        ------
        InputError
            If the disk has refused what came before.
        """
        self.full = self.full or self._over(sample.host_time_s)
        if self.full:
            return
        wrong = self._wrong(sample)
        if wrong:
            self.tally.refused += 1
            self.tally.why = self.tally.why or wrong
            return
        self._writer.reading(
            sample.pads,
            log_ns=_possible_ns(sample.host_time_s) or 0,
            device_ns=_possible_ns(sample.device_time_s),
            sequence=sample.sequence,
        )
        self._count(sample)
        self.full = self.tally.samples == self._limits.samples
        if not self._file.shown:
            # From its first reading on there is a file.
            self._writer.flush()
            self._file.show()
        self.look()

    def mark(self, told: Mapping[str, Any], host_time_s: float, *, zero: bool = False) -> None:
        """Write what a person marked, or a zero that was taken or refused."""
        self._writer.tell(ZEROS if zero else MARKS, told, log_ns=_possible_ns(host_time_s) or 0)

    def look(self) -> None:
        """Hand over what has waited for long; to be called now and then where no sample comes."""
        now_s = time.monotonic()
        # Where nothing comes any more, nothing can come too late.
        self.full = self.full or now_s - self._began_s > (self._limits.seconds or math.inf) + _LATE_S
        if now_s - self._flushed_s >= _FLUSH_S:
            self._flushed_s = now_s
            self._writer.flush()

    def finish(self) -> None:
        """Write the file's end."""
        self._writer.finish()

    def _wrong(self, sample: Sample) -> str:
        """Say what keeps a sample from being written, and take in the pads that are new."""
        for name, values in sample.pads.items():
            if values.dtype.kind not in "biuf" or not 1 <= values.ndim <= 3 or not values.size:
                return f"pad {name} was {values.dtype} of shape {values.shape}"
            known = self._shapes.get(name)
            if known is None:
                facts = _facts(name, values, self._layouts().get(name), self._sensor)
                if facts.kind == "pressure" and values.ndim > 2:
                    return f"pad {name} was of shape {values.shape}, which is no frame"
                self._writer.describe(facts)
                self._shapes[name] = values.shape
            elif known != values.shape:
                return f"pad {name} was of shape {values.shape} after {known}"
        return ""

    def _over(self, host_time_s: float) -> bool:
        return self._limits.seconds is not None and host_time_s - self.tally.first_s >= self._limits.seconds

    def _count(self, sample: Sample) -> None:
        tally = self.tally
        tally.samples += 1
        tally.last_s = sample.host_time_s
        if tally.samples == 1:
            self._began_s = time.monotonic()
            tally.first_s = sample.host_time_s
        if sample.sequence is not None and self._number is not None:
            skipped = sample.sequence - self._number - 1
            tally.lost += max(skipped, 0) if skipped <= _MOST_LOST else 0
        self._number = sample.sequence
        self._clock.look(sample)
        tally.odd_clock = self._clock.words


def _facts(name: str, values: NDArray[Any], layout: PadLayout | None, sensor: str) -> PadFacts:
    if layout is None:
        return PadFacts(name, kind="signals" if values.ndim == 3 else "pressure", sensor=sensor)
    return PadFacts(
        name,
        field=_mask(layout.gaps, values.shape),
        valid=_mask(layout.broken, values.shape),
        kind=layout.kind,
        unit=layout.unit,
        sensor=sensor,
        polarity=layout.polarity,
        pitch_m=layout.pitch_m,
        names=layout.names,
    )


def _mask(places: tuple[int, ...], shape: tuple[int, ...]) -> NDArray[np.bool_] | None:
    """Return a mask that is False at some places, taxels on no grid as one row; None where there are none."""
    if not places:
        return None
    mask = np.ones(math.prod(shape), np.bool_)
    mask[[place for place in places if place < mask.size]] = False
    return mask.reshape(shape if len(shape) == 2 else (1, -1))


def _possible_ns(time_s: float | None) -> int | None:
    """Return a time in nanoseconds; None of what is none."""
    return None if time_s is None or not math.isfinite(time_s) else nanoseconds(time_s)


@contextmanager
def sample_file(
    path: str | os.PathLike[str],
    layouts: Callable[[], Mapping[str, PadLayout]],
    *,
    sensor: str = "",
    files: Mapping[str, str] | None = None,
    limits: Limits | None = None,
) -> Iterator[SampleFile]:
    """Open a file that samples are written to; there is none before the first.

    However the block ends, what was written is given its end.

    Parameters
    ----------
    path : str or path-like
        An MCAP file.
    layouts : callable
        Returns what the source says of its pads, by name.
    sensor : str
        What the sensor is called.
    files : mapping of str to str, optional
        The texts of the sensor file and its maps by their names, which are put into the file.
    limits : Limits, optional
        Where it ends by itself.

    Raises
    ------
    InputError
        If it cannot be written there, or another process writes it.
    """
    with growing_file(path) as file:
        written = SampleFile(file, layouts, sensor, limits or Limits())
        written.attach(files or {})
        try:
            yield written
        finally:
            written.finish()
