"""Are the taxels of a stream fit for use: told while frames come in, from the last minute of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.frame.checks import as_usable
from varishold.frame.frame_clock import FrameClock
from varishold.frame.health import ALIVE_SHARE, FULL_SCALES
from varishold.frame.health_report import BadTaxel, HealthReport, Word
from varishold.frame.noise import MEDIAN_ABS_NORMAL
from varishold.frame.press_return import PressReturn
from varishold.frame.readings import Readings, as_shape
from varishold.frame.running_noise import RunningNoise

__all__ = ["TaxelHealth"]

# All but impulses is looked at so often. Seconds.
_LOOK_S = 0.1
# Counts are those of about so long. Seconds.
_MEMORY_S = 60.0
# Nothing is said of a taxel before so long and so many looks. Seconds.
_KNOWN_S, _KNOWN_LOOKS = 10.0, 30
# A taxel is silent that has not changed for so long, and in as many looks as anything is known after, or has less than
# this share of the typical noise. Seconds.
_SILENT_S, _SILENT_NOISE = 10.0, 0.05
# A line is open where this share of all taxels is not silent.
_HALF = 0.5
_NOISY = 4.0
# An impulse goes up and down, or down and up, by so many standard deviations from frame to frame.
_IMPULSE_SIGMAS = 8.0
# So many times as far as any neighbour, or it is a tap.
_ALONE_TIMES = 4.0
# What is told: impulses a minute, and shares of the frames.
_IMPULSES_PER_MIN, _SATURATED_SHARE, _NOT_FINITE_SHARE = 2.0, 0.01, 0.001
# Of a press, what stays half a second after it: twice as much as creep usually is.
_SLOW_SHARE = 0.25
# The drift is that of a minute; a taxel drifts apart so many times as far off as the others scatter, and by so many
# standard deviations of its noise.
_DRIFT_OVER_S, _APART, _APART_SIGMAS = 60.0, 6.0, 3.0


@dataclass(frozen=True, eq=False)
class _Silent:
    """What says nothing: open lines, their taxels, dead and stuck ones; the others, and by what it is told."""

    rows: tuple[int, ...]
    cols: tuple[int, ...]
    open: NDArray[np.bool_]
    dead: NDArray[np.bool_]
    stuck: NDArray[np.bool_]
    heard: NDArray[np.bool_]
    silent_s: NDArray[np.float64]
    for_median: NDArray[np.float64]


class TaxelHealth:
    """Watches the taxels of a pad; what it keeps does not grow.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the pad.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is known to be broken: nothing is said of them.
    full_scale : float, optional
        The reading at which a taxel is saturated. Default: what the usual converters have, where whole numbers reach it
        and none goes beyond.

    Raises
    ------
    InputError
        If the shape is none, or a mask has another.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> health = TaxelHealth((6, 6))
    >>> for k in range(600):
    ...     frame = 300 + rng.normal(0, 2.0, (6, 6))
    ...     frame[1, 2], frame[:, 4] = 17.0, 0.0
    ...     health.update(k / 30, frame)
    >>> health.report().remarks
    ('column 4 is silent: an open line', 'taxel (1, 2) never changes its value: stuck')
    """

    def __init__(
        self,
        shape: tuple[int, int],
        *,
        field: ArrayLike | None = None,
        valid: ArrayLike | None = None,
        full_scale: float | None = None,
    ) -> None:
        shape = as_shape(shape)
        self._usable = as_usable(None, shape, field, valid)
        self._clock = FrameClock()
        self._readings = Readings(self._usable)
        self._noise = RunningNoise(self._usable)
        self._return = PressReturn(shape)
        self._full_scale = full_scale
        self._highest, self._whole = -np.inf, False
        self._before: NDArray[np.float64] | None = None
        self._change = np.zeros(shape)
        self._seen = np.zeros(shape)
        self._looked_s, self._n_looks = 0.0, 0
        self._changed_at_s, self._changed_at_look = np.zeros(shape), np.zeros(shape, np.int64)
        self._impulses, self._saturated, self._not_finite = np.zeros((3, *shape))
        self._frames_lately = self._looks_lately = 0.0
        self._slow: NDArray[np.float64] | None = None
        self._drift_from: tuple[float, NDArray[np.float64]] | None = None
        self._drift_per_s: NDArray[np.float64] | None = None

    def update(self, time_s: float, frame: ArrayLike, *, touched: bool = False) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
            When it was taken, seconds, by any clock.
        frame : array_like of shape (rows, cols), float or integer
            As the sensor sends it, not zeroed.
        touched : bool
            Whether anything presses, as far as is known: it tells how taxels come back.

        Raises
        ------
        InputError
            If the frame has another shape or is none, or the time is not finite.
        """
        values = self._readings.take(frame)
        passed_s = self._clock.add(time_s)
        self._frames_lately += 1.0
        if self._readings.wrong is not None:
            self._not_finite += self._readings.wrong
        if self._before is None or self._clock.paused_s is not None:
            self._noise.forget_frame()
            self._change = np.zeros_like(values)
        else:
            self._find_impulses(values - self._before)
        self._before = values
        self._looked_s += passed_s
        if self._looked_s >= _LOOK_S or self._n_looks == 0:
            self._look(values, self._looked_s, whole=np.asarray(frame).dtype.kind in "iu", touched=touched)
            self._looked_s = 0.0

    def _find_impulses(self, change: NDArray[np.float64]) -> None:
        """Count what goes up in one frame and down in the next, or down and up, while its neighbours do not."""
        back = -np.minimum(change * self._change, 0.0)
        reach = _IMPULSE_SIGMAS * self._noise.floored
        struck = back > reach * reach
        last, self._change = self._change, change
        if self._noise.known and struck.any():
            # Both ways about as far, or it is no impulse but a press that begins in one.
            struck &= np.abs(change + last) < 0.5 * np.abs(last)
            struck &= np.abs(last) > _ALONE_TIMES * _of_neighbours(np.abs(last))
            self._impulses += struck

    def _look(self, values: NDArray[np.float64], passed_s: float, *, whole: bool, touched: bool) -> None:
        """Take note of everything that does not need each frame."""
        now_s = self._clock.now_s
        self._noise.least = self._readings.least_noise
        if self._n_looks == 0:
            self._seen = values
        if touched:
            self._noise.forget_frame()
        else:
            self._noise.add(passed_s, values)
        changed = values != self._seen
        self._changed_at_s[changed], self._changed_at_look[changed] = now_s, self._n_looks
        self._seen = values
        faded = math.exp(-passed_s / _MEMORY_S)
        for counts in (self._impulses, self._saturated, self._not_finite):
            counts *= faded
        self._frames_lately *= faded
        self._looks_lately = self._looks_lately * faded + 1.0
        self._look_at_top(values, whole=whole)
        # Beside a noise that nobody knows no press is loud.
        noise = self._noise.floored if self._noise.known else np.full_like(values, np.inf)
        self._return.add(now_s, passed_s, values, noise, touched=touched)
        self._look_at_drift(now_s, passed_s, values)
        self._n_looks += 1

    def _look_at_top(self, values: NDArray[np.float64], *, whole: bool) -> None:
        full = self._full_scale
        if full is None:
            highest = float(values.max(where=self._usable, initial=-np.inf))
            if highest > self._highest:
                self._highest = highest
                self._saturated[:] = 0.0
            self._whole = whole
            if not whole or self._highest not in FULL_SCALES:
                return
            full = self._highest
        self._saturated += values >= full

    def _look_at_drift(self, now_s: float, passed_s: float, values: NDArray[np.float64]) -> None:
        """Measure over a minute how far each taxel's rest has gone, where nothing pressed in between."""
        if not self._return.resting:
            self._slow = self._drift_from = None
            return
        self._slow = values if self._slow is None else self._slow + min(passed_s / 3.0, 1.0) * (values - self._slow)
        if self._drift_from is None:
            # The mean needs some seconds to become one.
            self._drift_from = now_s + _KNOWN_S, self._slow
        elif now_s <= self._drift_from[0]:
            self._drift_from = self._drift_from[0], self._slow
        elif now_s - self._drift_from[0] >= _DRIFT_OVER_S:
            self._drift_per_s = (self._slow - self._drift_from[1]) / (now_s - self._drift_from[0])
            self._drift_from = now_s, self._slow

    @property
    def full_scale(self) -> float | None:
        """The reading at which taxels are saturated, where readings have reached it; None where none is known."""
        if self._full_scale is not None:
            return self._full_scale
        return self._highest if self._whole and self._highest in FULL_SCALES else None

    def report(self) -> HealthReport:
        """Return how the taxels are by now."""
        minutes = max(min(self._clock.now_s, _MEMORY_S), 1.0) / 60.0
        usable, n = self._usable, max(int(np.count_nonzero(self._usable)), 1)
        impulses = self._impulses / minutes
        saturated = self._saturated_share
        not_finite = self._not_finite / max(self._frames_lately, 1.0)
        drift = self._drift_per_s
        rows, cols, bad = self._bad(impulses, saturated, not_finite) if self._known else ((), (), ())
        return HealthReport(
            n_frames=self._readings.n_frames,
            watched_s=self._clock.now_s,
            noise=self._noise.median,
            drift_per_min=None if drift is None or not usable.any() else 60.0 * float(np.median(drift[usable])),
            impulses_per_min=float(impulses[usable].sum()),
            saturated_share=float(saturated[usable].sum()) / n,
            not_finite_share=float(not_finite[usable].sum()) / n,
            open_rows=rows,
            open_cols=cols,
            bad=bad,
        )

    @property
    def _known(self) -> bool:
        return self._clock.now_s >= _KNOWN_S and self._n_looks >= _KNOWN_LOOKS and bool(self._usable.any())

    @property
    def _saturated_share(self) -> NDArray[np.float64]:
        """In which share of the looks of late each taxel was at full scale."""
        share: NDArray[np.float64] = self._saturated / max(self._looks_lately, 1.0)
        return share

    @property
    def broken(self) -> NDArray[np.bool_]:
        """Which taxels say nothing of what presses: dead and stuck ones, and open lines; shape (rows, cols).

        None where the usual taxel shows no noise either: those that nothing has pressed would look the same.
        """
        if not self._known or not self._noise.median > 0.0:
            return np.zeros(self._usable.shape, np.bool_)
        quiet = self._silent()
        return (quiet.dead | quiet.stuck | quiet.open) & (quiet.for_median < _SILENT_NOISE)

    def _silent(self) -> _Silent:
        """Return which taxels and lines say nothing."""
        saturated, usable, median = self._saturated_share, self._usable, self._noise.median
        for_median = self._noise.sigma / median if median > 0.0 else np.zeros(usable.shape)
        silent_s = self._clock.now_s - self._changed_at_s
        long = (silent_s > _SILENT_S) & (self._n_looks - self._changed_at_look >= _KNOWN_LOOKS)
        still = long & (saturated < _HALF) & usable
        silent = still | ((for_median < _SILENT_NOISE) & usable & (median > 0.0) & (saturated < _HALF))
        rows, cols = _open_lines(silent, usable)
        line = np.zeros(usable.shape, np.bool_)
        line[list(rows), :] = True
        line[:, list(cols)] = True
        others = usable & ~line
        few = np.count_nonzero(silent & others) <= (1.0 - ALIVE_SHARE) * np.count_nonzero(others)
        alone = silent & others & few
        stuck = alone & still & (self._seen != 0.0)
        return _Silent(rows, cols, line & silent, alone & ~stuck, stuck, usable & ~silent, silent_s, for_median)

    def _bad(
        self, impulses: NDArray[np.float64], saturated: NDArray[np.float64], not_finite: NDArray[np.float64]
    ) -> tuple[tuple[int, ...], tuple[int, ...], tuple[BadTaxel, ...]]:
        """Return the lines that are open, and the taxels that are bad."""
        quiet = self._silent()
        usable, heard, silent_s, for_median = self._usable, quiet.heard, quiet.silent_s, quiet.for_median
        stays, back_s = self._return.stays_share, self._return.return_s
        found: list[BadTaxel] = []

        def tell(word: Word, where: NDArray[np.bool_], **figures: NDArray[np.float64]) -> None:
            for row, col in np.argwhere(where).tolist():
                numbers = {name: float(values[row, col]) for name, values in figures.items()}
                found.append(BadTaxel(row, col, word, {k: v for k, v in numbers.items() if math.isfinite(v)}))

        tell("dead", quiet.dead, noise_times_median=for_median)
        tell("stuck", quiet.stuck, value=self._seen, silent_s=silent_s)
        tell("open line", quiet.open, silent_s=silent_s)
        tell("noisy", heard & (for_median > _NOISY), noise_times_median=for_median)
        tell("impulses", usable & (impulses > _IMPULSES_PER_MIN), impulses_per_min=impulses)
        tell("saturated", usable & (saturated > _SATURATED_SHARE), saturated_share=saturated)
        tell("no number", usable & (not_finite > _NOT_FINITE_SHARE), not_finite_share=not_finite)
        tell("slow to return", heard & (stays > _SLOW_SHARE), stays_share=stays, return_s=back_s)
        if self._drift_per_s is not None:
            drift = 60.0 * self._drift_per_s
            tell("drifts alone", heard & _apart(drift, heard, self._noise.floored), drift_per_min=drift)
        return quiet.rows, quiet.cols, tuple(found)


def _open_lines(silent: NDArray[np.bool_], usable: NDArray[np.bool_]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the rows and columns of two taxels or more that are silent as a whole, while half the pad is not."""
    if np.count_nonzero(usable & ~silent) < _HALF * np.count_nonzero(usable):
        return (), ()
    lines = []
    for axis in (1, 0):
        counts = usable.sum(axis=axis)
        lines.append(tuple(np.flatnonzero((counts >= 2) & ((usable & ~silent).sum(axis=axis) == 0)).tolist()))
    return lines[0], lines[1]


def _apart(drift: NDArray[np.float64], heard: NDArray[np.bool_], noise: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the taxels that drift otherwise than the others."""
    if not heard.any():
        return heard
    off = np.abs(drift - np.median(drift[heard]))
    spread = float(np.median(off[heard])) / MEDIAN_ABS_NORMAL
    apart: NDArray[np.bool_] = (off > _APART * spread) & (off > _APART_SIGMAS * noise)
    return apart


def _of_neighbours(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest of the eight values around each taxel, 0 where there are none."""
    rows, cols = values.shape
    room = np.zeros((rows + 2, cols + 2))
    room[1:-1, 1:-1] = values
    around = [room[i : i + rows, j : j + cols] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    largest: NDArray[np.float64] = np.max(around, axis=0)
    return largest
