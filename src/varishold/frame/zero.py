"""The zero that follows: what each taxel shows when nothing presses, kept right for hours and through presses."""

from __future__ import annotations

from collections import deque
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.frame.checks import as_floor, as_usable
from varishold.frame.following_baseline import FollowingBaseline
from varishold.frame.frame_clock import FrameClock
from varishold.frame.health import taxels_in_words
from varishold.frame.letting_go import LettingGo
from varishold.frame.lowest_levels import LowestLevels
from varishold.frame.quiet_window import QuietWindow, standing_patch
from varishold.frame.readings import Readings, as_shape

__all__ = ["FollowingZero", "Zeroing"]

# Frames that come sooner after one another are zeroed, not judged: the zero follows no faster than creep. Seconds.
_JUDGED_EVERY_S = 0.015
# How long the first zero and one on request take, and how often the first is tried while something moves.
_START_S, _ASKED_S, _START_TRIES = 1.0, 0.5, 5
# After a longer pause the zero begins anew. Seconds.
_LONG_PAUSE_S = 60.0
_KEPT_ZEROINGS = 1000

_Why = Literal["start", "pause", "asked"]


@dataclass(frozen=True)
class Zeroing:
    """One zero that was taken or refused.

    Parameters
    ----------
    time_s : float
        By the caller's clock, at its end.
    why : {"start", "pause", "asked"}
        At the start, after a long pause between frames, or on request.
    taken : bool
        False where it was refused.
    reason : str
        Why it was refused, or what is to be known of it; empty where there is nothing.
    n_frames : int
        Frames that it was taken from.
    n_taxels : int
        Taxels whose zero it set.
    largest_change : float
        How far it moved the zero of a taxel at most, in the unit of the frames.
    """

    time_s: float
    why: _Why
    taken: bool
    reason: str
    n_frames: int
    n_taxels: int
    largest_change: float

    def to_dict(self) -> dict[str, Any]:
        """Return the record as JSON has it."""
        return asdict(self)


class FollowingZero:
    """A baseline that follows free taxels at once, and pressed ones by what the free ones do.

    Each taxel's share of the common drift is learned while it is free. A press begins at three neighbours above eight
    standard deviations of their noise, or at one taxel four times as high, and ends below four; it, two taxels around
    it, and what it leaves for a second, follow the common drift alone. What stays below 15 % of a press's peak is
    creep, and is followed. Where nobody is free the zero is held.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the pad.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is broken; such taxels show 0.
    least_noise : float, optional
        No taxel's noise is taken to be less, in the unit of the frames. Default: rounding's where frames are whole
        numbers, otherwise a millionth of the first reading.
    follows : bool
        False for signals that are no pressure, where a sign and a neighbour mean nothing: their zero is taken at the
        start and on request, and held.

    Attributes
    ----------
    shape : (int, int)

    Raises
    ------
    InputError
        If the shape is none, or a mask has another.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> zero = FollowingZero((8, 8))
    >>> for k in range(300):
    ...     warm = 100 + 0.02 * k + rng.normal(0, 1, (8, 8))
    ...     warm[2:5, 2:5] += 50 * (k >= 200)
    ...     zeroed = zero.update(k / 100, warm)
    >>> round(zeroed[2:5, 2:5].mean()), int(zero.pressed.sum()), zero.log[0].taken
    (50, 9, True)
    """

    def __init__(
        self,
        shape: tuple[int, int],
        *,
        field: ArrayLike | None = None,
        valid: ArrayLike | None = None,
        least_noise: float | None = None,
        follows: bool = True,
    ) -> None:
        self.shape = as_shape(shape)
        self._usable = as_usable(None, self.shape, field, valid)
        self._all_usable = bool(self._usable.all())
        self._least_noise = as_floor(least_noise, "least_noise")
        self._baseline = FollowingBaseline(self._usable)
        self._clock = FrameClock()
        self._log: deque[Zeroing] = deque(maxlen=_KEPT_ZEROINGS)
        self._judged_s = 0.0
        self._readings = Readings(self._usable)
        self._anyway = False
        self._follows = follows
        self._letting_go: LettingGo | None = None
        self._begin("start")

    @property
    def n_not_finite(self) -> int:
        """Readings that were no finite numbers."""
        return self._readings.n_not_finite

    @property
    def reading(self) -> NDArray[np.float64]:
        """The newest frame, shape (rows, cols): what is no finite number as the taxel's last reading."""
        return self._readings.newest

    @property
    def baseline(self) -> NDArray[np.float64]:
        """What is taken off a frame now, of shape (rows, cols): the raw frame is the zeroed one plus this."""
        return self._baseline.values.copy()

    @property
    def log(self) -> tuple[Zeroing, ...]:
        """The zeros that were taken and refused, oldest first: the last thousand."""
        return tuple(self._log)

    @property
    def pressed(self) -> NDArray[np.bool_]:
        """Where something presses, a mask of shape (rows, cols)."""
        return self._baseline.presses.mask

    @property
    def is_pressed(self) -> bool:
        """Whether anything presses."""
        return self._baseline.presses.bits != 0

    @property
    def wrong(self) -> NDArray[np.bool_] | None:
        """Where the last frame held no finite numbers, of shape (rows, cols); None where all were."""
        return self._readings.wrong

    @property
    def free(self) -> NDArray[np.bool_]:
        """The taxels that the zero follows each by itself, a mask of shape (rows, cols)."""
        return self._baseline.presses.free.copy()

    @property
    def share(self) -> NDArray[np.float64]:
        """How far each taxel drifts where the mean taxel drifts by 1, of shape (rows, cols)."""
        return self._baseline.drift.share.copy()

    @property
    def drift(self) -> float:
        """How far the mean taxel has drifted since the start, in the unit of the frames."""
        return self._baseline.drift.level

    @property
    def noise(self) -> NDArray[np.float64]:
        """Standard deviation that each taxel is judged by, of shape (rows, cols), in the unit of the frames."""
        return self._baseline.noise.floored.copy()

    @property
    def state(self) -> Literal["starting", "zeroing", "following", "holding"]:
        """Whether the zero is taken for the first time or on request, follows, or is held as nobody is free."""
        if self._window is not None:
            return "zeroing" if self._why == "asked" else "starting"
        return "following" if self._follows and self._baseline.presses.free.any() else "holding"

    def restart(self) -> None:
        """Begin anew, as with the first frame: what was read so far meant something else."""
        self._baseline, self._letting_go, self._judged_s = FollowingBaseline(self._usable), None, 0.0
        self._begin("start")

    def ask(self, time_s: float, *, anyway: bool = False) -> Zeroing | None:
        """Take the zero anew from the next half second of frames; what comes of it stands in `log` then.

        Parameters
        ----------
        time_s : float
            By the clock of the frames.
        anyway : bool
            Whether to take it although something presses.

        Returns
        -------
        Zeroing or None
            The refusal where something presses now, None where the zero is being taken.
        """
        if self.state == "starting":
            return None
        pressed = self.pressed
        if pressed.any() and not anyway:
            return self._note(time_s, "asked", 0, refused=f"something presses {_on(pressed)}")
        self._anyway = anyway
        self._begin("asked")
        return None

    def update(self, time_s: float, frame: ArrayLike) -> NDArray[np.float64]:
        """Take a frame and return it zeroed.

        Parameters
        ----------
        time_s : float
            When it was taken, seconds, by any clock; pauses and jumps are survived.
        frame : array_like of shape (rows, cols), float or integer
            Larger means more pressure. What is no finite number counts as the taxel's last reading.

        Returns
        -------
        ndarray of shape (rows, cols), float64
            A new array; 0 where there is no usable taxel.

        Raises
        ------
        InputError
            If the frame has another shape or is none, or the time is not finite.
        """
        values = self._readings.take(frame)
        if self._readings.n_frames == 1:
            known = self._least_noise if self._least_noise >= 0.0 else self._readings.least_noise
            self._baseline.noise.least = known or self._readings.least_noise
        passed_s = self._clock.add(time_s)
        if self._clock.paused_s is not None:
            self._resume(time_s, self._clock.paused_s, values)
        elif self._window is not None:
            self._fill(self._window, time_s, passed_s, values)
        zeroed: NDArray[np.float64] = values - self._baseline.values
        if not self._all_usable:
            zeroed[~self._usable] = 0.0
        self._judged_s = 0.0 if self.state == "starting" else self._judged_s + passed_s
        if self._follows and self._judged_s >= _JUDGED_EVERY_S:
            self._baseline.follow(self._clock.now_s, self._judged_s, values, zeroed)
            self._judged_s = 0.0
        if self._letting_go is not None:
            self._let_go(self._letting_go, passed_s, values)
        return zeroed

    def _begin(self, why: _Why) -> None:
        self._why: _Why = why
        self._window: QuietWindow | None = QuietWindow(self._usable, _ASKED_S if why == "asked" else _START_S)
        self._levels, self._tries = LowestLevels(self._usable), 1

    def _fill(self, window: QuietWindow, time_s: float, passed_s: float, values: NDArray[np.float64]) -> None:
        """Take a frame for a zero that is being taken."""
        least = self._baseline.noise.least
        if self._why != "asked" and (rising := window.rises(values, least)).any():
            # What rises is a press, and what came before it is the rest.
            self._take_first(window, time_s, rising)
            return
        full = window.add(passed_s, values)
        if self._why == "asked":
            pressed = self._baseline.presses.mask
            if pressed.any() and not self._anyway:
                self._window = None
                self._note(time_s, "asked", window.n_frames, refused=f"something presses {_on(pressed)}")
            elif full:
                self._take_asked(window, time_s)
        elif full or (self._follows and self._levels.add(passed_s, values) and self._levels.moved(least).any()):
            self._take_first(window, time_s)
        elif self._why == "start":
            self._baseline.values = window.mean

    def _take_asked(self, window: QuietWindow, time_s: float) -> None:
        self._window = None
        moved = window.moved(self._baseline.noise.least)
        if moved.any() and not self._anyway:
            self._note(time_s, "asked", window.n_frames, refused=f"something moves {_on(moved)}")
            return
        self._baseline.presses.clear()
        self._set(window, window.mean, time_s, "something pressed" if self._anyway and moved.any() else "")

    def _take_first(self, window: QuietWindow, time_s: float, rising: NDArray[np.bool_] | None = None) -> None:
        """Take the zero at the start or after a long pause: where something moves, from when it was lowest."""
        baseline = self._baseline
        moved = window.moved(baseline.noise.least)
        were = self._levels.moved(baseline.noise.least) if self._follows else np.zeros_like(self._usable)
        pressed = were | rising if rising is not None and self._follows else were
        if moved.any() and not pressed.any() and self._tries < _START_TRIES:
            self._window, self._tries = QuietWindow(self._usable, _START_S), self._tries + 1
            return
        self._window = None
        is_known = pressed.any() or not moved.any()
        rest = window.mean
        if pressed.any() and (lowest := self._levels.lowest(baseline.noise.least)) is not None:
            rest = lowest
        baseline.set_noise(_but(window.sigma, self._usable, pressed | moved))
        stands = standing_patch(rest, self._usable, baseline.noise.median)
        reason = ""
        if not is_known:
            reason = f"something moves {_on(moved)}: the zero is not to be trusted there"
        elif were.any():
            reason = f"something presses {_on(were)}: the zero there is the lowest that was seen"
        elif stands.any() and self._why == "start":
            reason = f"something may press {_on(stands)}: what stands there counts as nothing"
        self._set(window, rest, time_s, reason)
        if self._follows:
            self._letting_go = LettingGo(self._usable, pressed | moved | stands)

    def _let_go(self, letting_go: LettingGo, passed_s: float, values: NDArray[np.float64]) -> None:
        """Correct the zero where what pressed while it was taken lets go."""
        sunk = letting_go.add(passed_s, values, self._baseline.values, self._baseline.noise.floored)
        if sunk is not None:
            where, level = sunk
            self._baseline.set(level, where)
        elif letting_go.is_over:
            self._letting_go = None

    def _set(self, window: QuietWindow, rest: NDArray[np.float64], time_s: float, reason: str) -> None:
        held = self._baseline.presses.mask
        change = np.abs(rest - self._baseline.values)[self._usable & ~held]
        largest = float(change.max()) if change.size and self._why != "start" else 0.0
        self._baseline.set(rest, ~held)
        self._log.append(Zeroing(time_s, self._why, True, reason, window.n_frames, change.size, largest))

    def _resume(self, time_s: float, paused_s: float, values: NDArray[np.float64]) -> None:
        """Go on after a pause or a jump of the clock."""
        if self.state == "starting":
            self._begin(self._why)
            return
        if self.state == "zeroing":
            self._note(time_s, "asked", 0, refused="frames did not come while it was taken")
            self._window = None
        if not self._follows:
            return
        self._baseline.resume(values)
        if paused_s > _LONG_PAUSE_S:
            self._begin("pause")

    def _note(self, time_s: float, why: _Why, n_frames: int, *, refused: str) -> Zeroing:
        note = Zeroing(float(time_s), why, False, refused, n_frames, 0, 0.0)
        self._log.append(note)
        return note


def _on(mask: NDArray[np.bool_]) -> str:
    """Say where a mask's taxels are."""
    return f"on {taxels_in_words(mask)}"


def _but(sigma: NDArray[np.float64], usable: NDArray[np.bool_], moved: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the noise of each taxel, the usual one where something moved."""
    still = usable & ~moved
    return np.where(moved, np.median(sigma[still]), sigma) if moved.any() and still.any() else sigma
