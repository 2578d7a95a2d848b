"""How a stream is: its rate, its jitter, what was lost, and its clock."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from varishold._counted import counted
from varishold.live.clock_slope import ClockSlope
from varishold.live.odd_clock import OddClock
from varishold.live.sample import Sample
from varishold.live.sequence import SequenceCounter

__all__ = ["StreamHealth", "StreamReport"]

# Rate, jitter and the longest gap are those of about so long. Seconds.
_MEMORY_S = 10.0
# What is worth a remark: readings lost of all, jitter by the usual distance, a clock that is off, in millionths.
_LOST_SHARE, _JITTER, _PPM = 0.001, 1.0, 2000.0
_FEWEST = 20


@dataclass(frozen=True)
class StreamReport:
    """How a stream is.

    Parameters
    ----------
    received : int
    rate_hz : float
        Readings a second lately; falls while none come.
    jitter_s : float
        Standard deviation of the time between readings as they come here, lately.
    longest_gap_s : float
        The longest time between two of them lately.
    silent_s : float
        Since the last one.
    lost, twice, late, restarts : int or None
        By the sensor's own numbers: readings that never came, came again, came after a later one, and how often it
        began to count anew; None where it sends none.
    clock_ppm : float or None
        By how many millionths the sensor's clock is fast; None where it sends no time, and before it is known.
    clock_set : int or None
        How often it was set or began anew; None where it sends no time.
    odd_clock : str
        Why its times cannot be seconds, in words; empty where they can.
    """

    received: int
    rate_hz: float
    jitter_s: float
    longest_gap_s: float
    silent_s: float
    lost: int | None
    twice: int | None
    late: int | None
    restarts: int | None
    clock_ppm: float | None
    clock_set: int | None
    odd_clock: str = ""

    @property
    def lost_share(self) -> float | None:
        """Of the readings that were sent, those that never came; None where that is not known."""
        return None if self.lost is None else self.lost / max(self.lost + self.received, 1)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is wrong, in words."""
        lines = []
        if self.lost is not None and self.lost_share is not None and self.lost_share > _LOST_SHARE:
            lines.append(
                f"{counted(self.lost, 'reading was', 'readings were')} lost on the way, "
                f"{100 * self.lost_share:.1f} % of all"
            )
        if self.restarts:
            lines.append(f"the sensor began to count anew {counted(self.restarts, 'time')}")
        if self.received >= _FEWEST and self.rate_hz > 0.0 and self.jitter_s * self.rate_hz > _JITTER:
            lines.append(f"readings come in bursts: {1e3 * self.jitter_s:.0f} ms of jitter at {self.rate_hz:.0f} /s")
        if self.odd_clock:
            lines.append(self.odd_clock)
        elif self.clock_ppm is not None and abs(self.clock_ppm) > _PPM:
            how = "fast" if self.clock_ppm > 0 else "slow"
            lines.append(f"the sensor's clock is {abs(self.clock_ppm) / 1e4:.1f} % {how}")
        return tuple(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it, with its remarks."""
        return {**asdict(self), "lost_share": self.lost_share, "remarks": list(self.remarks)}


class StreamHealth:
    """Watches when samples come; what it keeps does not grow.

    Examples
    --------
    >>> health = StreamHealth()
    >>> for k in range(500):
    ...     health.add(Sample(None, 1e9 + 0.01 * k, None if k == 0 else (k + (k > 250)) % 256, {}))
    >>> report = health.report()
    >>> round(report.rate_hz), report.lost
    (100, 1)
    """

    def __init__(self) -> None:
        self.received = 0
        self._numbers: SequenceCounter | None = None
        self._clock: ClockSlope | None = None
        self._odd = OddClock()
        self._last_s: float
        self._count = self._sum_s = self._squares = 0.0
        # Of the last ten seconds that are over, and of those since.
        self._longest_s, self._longest_since_s, self._since_s = 0.0, 0.0, 0.0

    def add(self, sample: Sample) -> None:
        """Take a sample."""
        host_s = sample.host_time_s
        if not math.isfinite(host_s):
            return
        # This machine's clock may be set back, too: then no time has passed.
        passed_s = max(host_s - self._last_s, 0.0) if self.received else 0.0
        if self.received and host_s >= self._last_s:
            self._take_gap(passed_s)
        self._last_s = host_s
        self.received += 1
        if sample.sequence is not None:
            self._numbers = self._numbers or SequenceCounter()
            self._numbers.add(sample.sequence, passed_s)
        if sample.device_time_s is not None:
            self._clock = self._clock or ClockSlope()
            self._clock.add(sample.device_time_s, host_s)
            self._odd.look(sample)

    def _take_gap(self, passed_s: float) -> None:
        faded = math.exp(-passed_s / _MEMORY_S)
        self._count = self._count * faded + 1.0
        self._sum_s = self._sum_s * faded + passed_s
        self._squares = self._squares * faded + passed_s * passed_s
        self._since_s += passed_s
        if self._since_s > _MEMORY_S:
            self._longest_s, self._longest_since_s, self._since_s = self._longest_since_s, 0.0, 0.0
        self._longest_since_s = max(self._longest_since_s, passed_s)

    def report(self, now_s: float | None = None) -> StreamReport:
        """Return how the stream is.

        Parameters
        ----------
        now_s : float, optional
            This machine's time, seconds since 1970, by which it may have fallen silent. Default: that of the last
            sample.
        """
        silent_s = max(now_s - self._last_s, 0.0) if now_s is not None and self.received else 0.0
        mean_s = self._sum_s / self._count if self._count else 0.0
        variance = max(self._squares / self._count - mean_s * mean_s, 0.0) if self._count else 0.0
        # A stream that is late by more than usual is slower than it was.
        late_s = max(silent_s - 2.0 * mean_s, 0.0)
        lately_s = self._sum_s + late_s
        return StreamReport(
            received=self.received,
            rate_hz=self._count / lately_s if lately_s > 0.0 else 0.0,
            jitter_s=math.sqrt(variance),
            longest_gap_s=max(self._longest_s, self._longest_since_s, silent_s),
            silent_s=silent_s,
            lost=None if self._numbers is None else self._numbers.lost,
            twice=None if self._numbers is None else self._numbers.twice,
            late=None if self._numbers is None else self._numbers.late,
            restarts=None if self._numbers is None else self._numbers.restarts,
            clock_ppm=None if self._clock is None else self._clock.ppm,
            clock_set=None if self._clock is None else self._clock.n_set,
            odd_clock=self._odd.words,
        )
