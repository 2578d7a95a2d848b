"""What each taxel shows at its lowest while a first zero is looked for, and whether anything presses meanwhile."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.frame.patches import in_patches

__all__ = ["LowestLevels"]

# Frames are averaged over so long: a slow rise stands out of the noise sooner. Seconds.
_AVERAGED_S = 0.025
# So many averages tell noise from what moves; no more are kept than that, or than hold so many readings: then each two
# become one.
_FEWEST, _MOST, _READINGS = 4, 80, 1 << 22
# From the mean of absolute differences of two to a standard deviation.
_SIGMA_OF_MEAN = math.sqrt(math.pi) / 2.0
# A taxel whose averages are farther apart than so many standard deviations has moved, one that is nearer to its lowest
# is at rest. No taxel counts as noisier than this many times the skin's median.
_MOVED_SIGMAS, _REST_SIGMAS, _NOISIEST = 8.0, 4.0, 3.0

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class LowestLevels:
    """Averages of a few frames each.

    Parameters
    ----------
    usable : ndarray of shape (rows, cols), bool

    Examples
    --------
    >>> import numpy as np
    >>> rng, levels = np.random.default_rng(0), LowestLevels(np.ones((6, 6), bool))
    >>> for k in range(60):
    ...     frame = 100 + rng.normal(0, 1, (6, 6))
    ...     frame[1:4, 1:4] += max(k - 40, 0)  # rises slowly
    ...     _ = levels.add(0.01, frame)
    >>> int(levels.moved(0.0).sum()), round(levels.lowest(0.0)[2, 2])
    (9, 100)
    """

    def __init__(self, usable: Mask) -> None:
        self._usable = usable
        self._most = max(2 * _FEWEST, min(_MOST, _READINGS // max(usable.size, 1)))
        self._average_s = _AVERAGED_S
        self._levels: list[Floats] = []
        # The same without what all taxels do together.
        self._alone: list[Floats] = []
        self._sum, self._n, self._passed_s = np.zeros(usable.shape), 0, 0.0

    def add(self, passed_s: float, values: Floats) -> bool:
        """Take a frame, and the seconds since the one before; tell whether an average is complete with it."""
        self._sum = self._sum + values
        self._n += 1
        self._passed_s += passed_s
        if self._passed_s < self._average_s:
            return False
        level = self._sum / self._n
        self._levels.append(level)
        self._alone.append(level - np.median(level[self._usable]) if self._usable.any() else level)
        self._sum, self._n, self._passed_s = np.zeros(level.shape), 0, 0.0
        if len(self._levels) >= self._most:
            self._levels, self._alone, self._average_s = (
                _halved(self._levels),
                _halved(self._alone),
                2 * self._average_s,
            )
        return True

    def moved(self, least_noise: float) -> Mask:
        """Return where a patch of three neighbours or more moved, (rows, cols)."""
        if len(self._alone) < _FEWEST or not self._usable.any():
            return np.zeros_like(self._usable)
        apart = np.ptp(np.array(self._alone), axis=0)
        return in_patches((apart > _MOVED_SIGMAS * self._noise(least_noise)) & self._usable)

    def lowest(self, least_noise: float) -> Floats | None:
        """Return the mean of each taxel's averages that are as low as its lowest two in a row; None of too few.

        An array of shape (rows, cols).
        """
        if len(self._alone) < _FEWEST:
            return None
        levels, alone = np.array(self._levels), np.array(self._alone)
        low = np.maximum(alone[1:], alone[:-1]).min(axis=0)
        at_rest = np.abs(alone - low) < _REST_SIGMAS * self._noise(least_noise)
        # What stands beside a rise, or came last, may have begun to rise.
        wide = np.pad(at_rest, ((1, 1), (0, 0), (0, 0)), constant_values=False)
        wide[0] = True
        inner = at_rest & wide[2:] & wide[:-2]
        chosen = np.where(inner.any(axis=0), inner, at_rest)
        return np.asarray((levels * chosen).sum(axis=0) / np.maximum(chosen.sum(axis=0), 1))

    def _noise(self, least_noise: float) -> Floats:
        """Return the standard deviation of each taxel's averages, from one to the next."""
        sigma = np.abs(np.diff(np.array(self._alone), axis=0)).mean(axis=0) * _SIGMA_OF_MEAN
        median = max(float(np.median(sigma[self._usable])), least_noise) if self._usable.any() else least_noise
        return np.asarray(np.clip(sigma, median, _NOISIEST * median))


def _halved(levels: list[Floats]) -> list[Floats]:
    """Return the mean of each two; the newest stays alone where they are odd."""
    pairs = [(one + other) / 2 for one, other in zip(levels[:-1:2], levels[1::2], strict=False)]
    return pairs + levels[len(levels) & ~1 :]
