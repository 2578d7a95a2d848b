"""Where readings end although the sensor could show more: an amplifier, or a taxel's material, gives no more."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.files import let_go
from varishold.frame.spread import spread_over

__all__ = [
    "FEWEST_TAXELS",
    "EndOfPress",
    "EndsOfPresses",
    "PressFrame",
    "ReadingEnd",
    "clearer_end",
    "reach_of",
    "reading_end",
    "uneven",
]

#: Taxels without which nothing is told.
FEWEST_TAXELS = 16
# Presses that are looked at, frames of each, and presses that must agree.
_MOST_PRESSES, _MOST_FRAMES, _FEWEST_PRESSES = 32, 64, 2
# The top of a press: this highest taxel, so that one alone makes none.
_TOP = 3
# It stays where it is to within so many sigma, or this share of it.
_STAYS_SIGMAS, _STAYS = 3.0, 0.01
# Meanwhile the load grows by this share, and by more than that power of what the top may have grown by unseen, and by
# so many taxels at the top.
_GROWS, _TIP, _MORE_TAXELS, _FEWEST_AT_TOP = 0.1, 1.2, 3, 6
# A press whose top lies so many times as far beyond the end as the top of one wavers shows that there is none; so do
# most presses that go nearly so far, as counts of which a top stays at the last but one.
BEYOND, _NEARLY = 4.0, 0.9


@dataclass(frozen=True)
class ReadingEnd:
    """Where readings end.

    Parameters
    ----------
    height : float
        Beyond this no taxel reads; what noise leaves below the end lies above it.
    of_readings : bool
        Whether it is one reading for all taxels, wherever each of them rests, as an amplifier has it: `height` is then
        above the rest of the usual taxel. Otherwise it is above each taxel's own.
    """

    height: float
    of_readings: bool

    def above(self, rest: NDArray[np.float64] | None, usable: NDArray[np.bool_]) -> NDArray[np.float64] | float:
        """Return how high above its rest each taxel reads at most: one height, or an array of shape (rows, cols)."""
        return self.height - uneven(rest, usable) if self.of_readings and rest is not None else self.height

    def __str__(self) -> str:
        return f"readings end at about {self.height:.3g} above the rest, while presses grow on: saturated there"


def uneven(rest: NDArray[np.float64], usable: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return how far each taxel rests above the usual one, shape (rows, cols)."""
    return rest - float(np.median(rest[usable]))


def reading_end(
    frames: NDArray[Any],
    usable: NDArray[np.bool_],
    rest: NDArray[np.float64] | None,
    presses: Sequence[range],
    sigma: float,
) -> ReadingEnd | None:
    """Return beyond what no taxel reads, found by how presses grow; None where no end is seen.

    While a press grows, its top grows. Where the top stays and the rest of the press goes on growing, and more taxels
    reach that same top, readings end there. Two presses at least must agree on it.

    Parameters
    ----------
    frames : ndarray of shape (n_frames, rows, cols)
        May be mapped; some are read.
    usable : ndarray of shape (rows, cols), bool
    rest : ndarray of shape (rows, cols), float64, or None
    presses : sequence of range
        Frames of each press.
    sigma : float
        Standard deviation of the noise.
    """
    if np.count_nonzero(usable) < FEWEST_TAXELS or len(presses) < _FEWEST_PRESSES:
        return None
    below = np.zeros(np.count_nonzero(usable)) if rest is None else rest[usable]
    apart = None if rest is None else uneven(rest, usable)[usable]
    own, common = EndsOfPresses(), EndsOfPresses()
    for k in spread_over(len(presses), _MOST_PRESSES):
        run = presses[int(k)]
        some = np.unique(np.linspace(run.start, run.stop - 1, _MOST_FRAMES).astype(np.intp))
        press = np.array([frames[i][usable] - below for i in some.tolist()], dtype=np.float64)
        own.add(*_end_of([PressFrame.of(values) for values in press], sigma))
        if apart is not None:
            common.add(*_end_of([PressFrame.of(values, values + apart) for values in press], sigma))
        let_go(frames)
    return clearer_end(own, common, sigma)


@dataclass(frozen=True)
class EndOfPress:
    """The top at which a press stayed while it grew, and how many taxels were there in the end."""

    top: float
    taxels: int


class EndsOfPresses:
    """Where the presses of a recording or of a stream seem to end: the newest of them."""

    def __init__(self) -> None:
        self._ends: deque[EndOfPress] = deque(maxlen=_MOST_PRESSES)
        self._highest: deque[float] = deque(maxlen=_MOST_PRESSES)

    def add(self, end: EndOfPress | None, highest: float) -> None:
        """Take what a press shows: an end, if it shows one, and its highest top."""
        self._ends += [] if end is None else [end]
        self._highest.append(highest)

    def clear(self) -> None:
        """Forget all presses."""
        self._ends.clear()
        self._highest.clear()

    @property
    def taxels(self) -> int:
        """How many taxels were at an end, in all presses together."""
        return sum(end.taxels for end in self._ends)

    def agreed(self, sigma: float) -> float | None:
        """Return where presses agree that readings end, less what noise may leave below; None where they do not."""
        tops = [end.top for end in self._ends]
        if len(tops) < _FEWEST_PRESSES:
            return None
        end = float(np.median(tops))
        reach = reach_of(end, sigma)
        beyond = np.subtract(self._highest, end) / reach
        if beyond.max() > BEYOND or np.count_nonzero(beyond > _NEARLY) > len(beyond) / 2:
            return None
        agree = np.count_nonzero(np.abs(np.subtract(tops, end)) <= reach)
        return end - reach if agree >= max(_FEWEST_PRESSES, len(tops) / 2) else None


def clearer_end(own: EndsOfPresses, common: EndsOfPresses, sigma: float) -> ReadingEnd | None:
    """Return the end above each taxel's own rest, or the one reading of all: that at which more taxels were."""
    of_readings = common.taxels > own.taxels
    for which in (of_readings, not of_readings):
        end = (common if which else own).agreed(sigma)
        if end is not None:
            return ReadingEnd(end, which)
    return None


def reach_of(top: float, sigma: float) -> float:
    """Return within how much the top of a press stays where it is."""
    return max(_STAYS_SIGMAS * sigma, _STAYS * top)


@dataclass(frozen=True, eq=False)
class PressFrame:
    """A frame of a press: how high its top is, how much all taxels together show, and how high each stands.

    Parameters
    ----------
    top, load : float
    values : ndarray of shape (n_taxels,), float64
    """

    top: float
    load: float
    values: NDArray[np.float64]

    @classmethod
    def of(cls, values: NDArray[np.float64], shown: NDArray[np.float64] | None = None) -> PressFrame:
        """Take a frame's usable taxels, zero at rest; and what of them is looked at, where it is something else."""
        shown = values if shown is None else shown
        return cls(float(np.partition(shown, -_TOP)[-_TOP]), float(np.maximum(values, 0.0).sum()), shown)

    def end_since(self, earlier: PressFrame, top: float, highest: float, reach: float) -> EndOfPress | None:
        """Return the end that a press shows at `top` if it has grown since an earlier frame whose top was as high."""
        high = highest - 2 * reach
        before, now = (int(np.count_nonzero(one.values >= high)) for one in (earlier, self))
        grown = ((highest + reach) / (highest - reach)) ** _TIP
        heavier = self.load >= max(1 + _GROWS, grown) * earlier.load
        return EndOfPress(top, now) if heavier and now >= max(before + _MORE_TAXELS, _FEWEST_AT_TOP) else None


def _end_of(press: Sequence[PressFrame], sigma: float) -> tuple[EndOfPress | None, float]:
    """Return the top of a press that stays while the press grows, None of others; and the highest top."""
    highest = max(frame.top for frame in press)
    reach = reach_of(highest, sigma)
    at_top = [frame for frame in press if frame.top >= highest - reach]
    if highest <= 2 * reach:
        return None, highest
    heaviest = max(at_top, key=lambda frame: frame.load)
    top = float(np.median([frame.top for frame in at_top]))
    return heaviest.end_since(at_top[0], top, highest, reach), highest
