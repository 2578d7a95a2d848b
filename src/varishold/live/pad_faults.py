"""What of a watched pad's readings is not to be believed, or is at least what it shows, or is smoothed."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from varishold.frame.health import taxels_in_words
from varishold.frame.quiet import SMOOTHED
from varishold.frame.running_end import RunningEnd
from varishold.frame.running_fall import RunningFall
from varishold.frame.running_health import TaxelHealth
from varishold.frame.running_quiet import RunningQuiet
from varishold.frame.running_sticking import RunningSticking
from varishold.frame.zero import FollowingZero

__all__ = ["PadFaults"]

# Broken taxels are looked for so often, while nothing presses. Seconds.
_LOOK_S = 1.0
# Noise of a noisy taxel below this share of the largest reading is borne.
_NOISE_OF_LARGEST = 0.03
# Fewer taxels do not show which way readings go.
_FEWEST = 9

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class PadFaults:
    """Watches a pad for broken taxels, taxels that stick, and saturated ones.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool
    zero : FollowingZero
    health : TaxelHealth
        Of the same readings; whoever watches them keeps both up to date.
    rises, way_is_told : bool
        Whether larger readings mean more pressure, and whether that is said of them.

    Attributes
    ----------
    broken : ndarray of shape (rows, cols), bool, or None
        The taxels that say nothing, of which there are few; None where all do.
    """

    def __init__(
        self, usable: Mask, zero: FollowingZero, health: TaxelHealth, *, rises: bool, way_is_told: bool
    ) -> None:
        self._usable, self._zero, self._health = usable, zero, health
        self._rises, self._way_is_told = rises, way_is_told
        self._sticking = RunningSticking(usable)
        self._end = RunningEnd(usable)
        self._quiet = RunningQuiet(usable)
        self._fall = RunningFall(usable)
        self._looked_s = -np.inf
        self._largest = 0.0
        self.broken: Mask | None = None
        self._broken_words: list[str] = []
        self._ends_at: Floats | float | None = None

    def update(self, time_s: float, zeroed: Floats, sigma: float) -> None:
        """Take a frame.

        Parameters
        ----------
        time_s : float
        zeroed : ndarray of shape (rows, cols), float64
            Upright, as far as is known, and zero at rest; what was no number has become one.
        sigma : float
            Standard deviation of the noise of the usual taxel.
        """
        self._sticking.update(time_s, zeroed, sigma)
        rest = self._zero.baseline
        self._end.update(zeroed, rest, sigma, is_pressed=self._zero.is_pressed)
        self._ends_at = None if self._end.end is None else self._end.end.above(rest, self._usable)
        self._quiet.update(time_s, zeroed, is_pressed=self._zero.is_pressed)
        if self._zero.is_pressed:
            self._largest = max(self._largest, float(zeroed.max()))
        elif not 0.0 <= time_s - self._looked_s < _LOOK_S:
            self._looked_s = time_s
            self._look()

    def look_which_way(self, time_s: float, sigma: float) -> None:
        """Look at the zero's newest frame, of the first ones too, before there is a zero: whether readings fall.

        `sigma` is 0 where there is no zero yet.
        """
        reading = self._zero.reading
        if reading.size >= _FEWEST:
            self._fall.update(time_s, reading, sigma)

    @property
    def which_way(self) -> Literal["rise", "may fall", "fall"]:
        """Whether readings fall where something presses, or go another way than is said, as far as is seen."""
        return "fall" if self._fall.found is not None else "may fall" if self._fall.suspected else "rise"

    def way_words(self) -> str | None:
        """Return that readings fall where something presses, and what to do; None where they do not."""
        fall = self._fall.found
        if fall is None:
            return None
        if self._way_is_told:
            return "readings go the other way where something presses than is said: is the polarity right?"
        return (
            f"readings fall where something presses, from about {fall.rest:.4g} to {fall.pressed:.4g}: give a "
            f"sensor file that says polarity = 'down' and rest = {fall.rest:.4g}"
        )

    def _look(self) -> None:
        """Look for broken taxels."""
        broken = self._health.broken
        if self._quiet.noisy is not None:
            broken |= self._quiet.noisy & (self._zero.noise > _NOISE_OF_LARGEST * self._largest)
        self.broken, self._broken_words = None, []
        if broken.any():
            self.broken = broken
            which = taxels_in_words(broken)
            self._broken_words.append(f"{which} is dead, stuck or far too noisy: filled from its neighbours")

    @property
    def stuck(self) -> Mask | None:
        """The taxels that stick now, shape (rows, cols); None where none does."""
        return self._sticking.stuck

    @property
    def smoothed(self) -> bool:
        """Whether taxels share their noise, as where readings are smoothed or interpolated."""
        return self._quiet.shares

    def up_to_end(self, zeroed: Floats) -> Floats:
        """Return a frame up to where readings end: what stands above that is noise on it."""
        return zeroed if self._ends_at is None else np.minimum(zeroed, self._ends_at)

    def saturated(self, values: NDArray[Any], zeroed: Floats) -> Mask | None:
        """Return where taxels felt at least what they show; None for nowhere.

        Parameters
        ----------
        values, zeroed : ndarray of shape (rows, cols)
            A frame as it came, and zeroed.
        """
        full, ends_at = self._health.full_scale if self._rises else None, self._ends_at
        found = None if full is None else values >= full
        if ends_at is not None:
            found = zeroed >= ends_at if found is None else found | (zeroed >= ends_at)
        return found if found is not None and found.any() else None

    def words(self) -> tuple[str, ...]:
        """Return what is not believed, and where readings end."""
        way = self.way_words()
        words = [] if way is None else [way]
        words += self._broken_words
        if self.stuck is not None:
            words.append(f"{taxels_in_words(self.stuck)} sticks: filled from those beside")
        if self._end.agreed is not None:
            words.append(str(self._end.agreed))
        if self.smoothed:
            words.append(SMOOTHED)
        return tuple(words)
