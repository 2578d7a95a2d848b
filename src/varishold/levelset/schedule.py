"""Schedules: how the threshold falls from theta_1 at the top of a contact to delta on the standard plane.

A schedule is a function of (top, delta, n) to n falling thresholds; `SCHEDULES` is their registry. In discrete
time the threshold takes one of them at each sampling instant, and the sections arrive one by one
(`VaryingThreshold`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.frame.checks import as_floats, as_pitch
from varishold.levelset.columns import BOUNDS
from varishold.levelset.kernel import measure_whole
from varishold.levelset.profile import Profile

__all__ = ["SCHEDULES", "VaryingThreshold", "even", "geometric", "quadratic", "whole_section"]


def even(top: float, delta: float, n: int) -> NDArray[np.float64]:
    """Return n thresholds in equal steps, the first and the last half a step inside (the default).

    Examples
    --------
    >>> even(1.0, 0.2, 4).round(3).tolist()
    [0.9, 0.7, 0.5, 0.3]
    """
    _check(top, delta, n)
    return np.asarray(top - (np.arange(n) + 0.5) * ((top - delta) / n), dtype=np.float64)


def geometric(top: float, delta: float, n: int) -> NDArray[np.float64]:
    """Return n thresholds in equal ratios, at half steps: fine near delta, for faint skirts; delta > 0.

    Examples
    --------
    >>> geometric(16.0, 1.0, 2).tolist()
    [8.0, 2.0]
    """
    _check(top, delta, n)
    if delta <= 0:
        raise InputError(f"a geometric schedule needs delta > 0, got {delta}")
    return np.asarray(top * (delta / top) ** ((np.arange(n) + 0.5) / n), dtype=np.float64)


def quadratic(top: float, delta: float, n: int) -> NDArray[np.float64]:
    """Return n thresholds whose depths below the top grow as squares, at half steps: fine near an apex.

    Examples
    --------
    >>> quadratic(1.0, 0.0, 2).tolist()
    [0.9375, 0.4375]
    """
    _check(top, delta, n)
    return np.asarray(top - (top - delta) * ((np.arange(n) + 0.5) / n) ** 2, dtype=np.float64)


#: Every schedule by its name.
SCHEDULES: dict[str, Callable[[float, float, int], NDArray[np.float64]]] = {
    "even": even,
    "geometric": geometric,
    "quadratic": quadratic,
}


def _check(top: float, delta: float, n: int) -> None:
    if n < 1:
        raise InputError(f"a schedule needs at least one threshold, got {n}")
    if not (np.isfinite(top) and np.isfinite(delta) and top > delta):
        raise InputError(f"a schedule falls from its top to delta, got top = {top}, delta = {delta}")


@dataclass(slots=True)
class VaryingThreshold:
    """The threshold in discrete time: one sampling instant, one threshold, one section of a live array.

    Parameters
    ----------
    thresholds : ndarray of shape (n,), float64
        Falling, as a schedule returns them.
    pitch_m : float or (float, float), optional
        Taxel spacing, metres, one for both ways or (row spacing, column spacing); default: taxels.

    Examples
    --------
    >>> y, x = np.mgrid[-4:5, -4:5]
    >>> held = np.maximum(4.0 - np.hypot(x, y), 0.0)
    >>> falling = VaryingThreshold(even(4.0, 0.0, 4))
    >>> while not falling.ended:
    ...     section = falling.feed(held)
    >>> falling.profile.area.round(2).tolist()
    [0.5, 6.44, 19.03, 38.21]
    """

    thresholds: NDArray[np.float64]
    pitch_m: float | tuple[float, float] | None = None
    _seen: list[Profile] = field(default_factory=list)

    def __post_init__(self) -> None:
        values = np.asarray(self.thresholds, dtype=np.float64)
        if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all() or np.any(np.diff(values) > 0):
            raise InputError(f"thresholds must fall and be finite, got shape {values.shape}: {values}")
        self.thresholds = values

    @property
    def instant(self) -> int:
        """How many sections have arrived: i of X_i."""
        return len(self._seen)

    @property
    def ended(self) -> bool:
        """Whether the threshold has come down to delta."""
        return self.instant == self.thresholds.size

    def feed(self, frame: ArrayLike) -> Profile:
        """Cut the frame of this instant at this instant's threshold.

        Parameters
        ----------
        frame : array_like of shape (rows, cols), float or integer
            What the array says now; NaN is no taxel.

        Returns
        -------
        Profile
            The section X_i of the whole frame, a profile of one level.

        Raises
        ------
        InputError
            If the frame has not the shape (rows, cols) or the threshold has ended.
        """
        if self.ended:
            raise InputError(f"the threshold has ended after {self.thresholds.size} instants; start a new one")
        section = whole_section(frame, float(self.thresholds[self.instant]), self.pitch_m)
        self._seen.append(section)
        return section

    @property
    def profile(self) -> Profile:
        """The sections that have arrived so far."""
        if not self._seen:
            raise InputError("no section has arrived yet: feed a frame first")
        measures = np.stack([section.measures for section in self._seen])
        counts = np.concatenate([section.counts for section in self._seen], axis=1)
        return Profile(np.concatenate([measures[:, a:b].ravel() for a, b in pairwise(BOUNDS)]), counts)


def whole_section(frame: ArrayLike, level: float, pitch_m: float | tuple[float, float] | None = None) -> Profile:
    """Measure the section {V > level} of a whole frame, whatever its parts.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame; NaN is no taxel.
    level : float
        The threshold.
    pitch_m : float or (float, float), optional
        Taxel spacing; default: taxels.

    Returns
    -------
    Profile
        Of one level.
    """
    values = as_floats(frame, 2, "a frame")
    found, counts = measure_whole(values, level, None if pitch_m is None else as_pitch(pitch_m))
    return Profile(found, counts)
