"""Presses that are unlike all that were learned, whatever their form: too light, on broken taxels, of another clock."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.touch.course.borne import filled_share, largest_load
from varishold.touch.course.measures import LOADS, MeasureSettings
from varishold.touch.course.presses import Press

__all__ = ["bear_nothing", "made_up", "of_another_clock"]

Floats = NDArray[np.float64]

# What bears less than this share of the least load that was learned bears next to nothing.
_NOTHING = 0.1
# Where by so much more of the load stands on broken taxels than was usual in learning, the form is made up in part.
_MADE_UP = 0.02
# What takes so many times as long as is usual, or so much less, and is so many standard deviations off, is of another
# clock, or no such press.
_OTHER_CLOCK, _OTHER_SIGMAS = 10.0, 4.0


def bear_nothing(presses: Sequence[Press], settings: MeasureSettings) -> NDArray[np.bool_]:
    """Tell which presses bear next to nothing beside any that was learned, shape (n_presses,).

    What little there is has some form, though it may be noise. A press without one of the pads is none of these: the
    others may bear little.
    """
    least = _NOTHING * settings.least_load
    whole = settings.shapes.keys()
    return np.array([press.pads.keys() >= whole and largest_load(press, settings.floor) < least for press in presses])


def made_up(presses: Sequence[Press], settings: MeasureSettings) -> NDArray[np.bool_]:
    """Tell of which presses more of the load stands on broken taxels than was usual in learning, shape (n_presses,).

    What these would read is drawn from the taxels around them: part of the form is not felt.
    """
    most = settings.filled + _MADE_UP
    return np.array([filled_share(press, settings.floor) > most for press in presses])


def of_another_clock(measures: Floats, shift: Floats, scale: Floats, drift: Floats | float = 0.0) -> NDArray[np.bool_]:
    """Tell which presses take ten times as long to their largest load as those learned usually did, or a tenth.

    Shape (n_presses,). None is where presses that were learned took such times too, and so scatter as far.

    Parameters
    ----------
    measures : ndarray of shape (n_presses, n_measures), float64
        As `measure_presses` gives them.
    shift, scale : ndarray of shape (n_measures,), float64
        The mean of what was learned, and one over its standard deviation; 0 where that is 0.
    drift : ndarray of shape (n_measures,), float64, optional
        By how many standard deviations measures are known to have shifted since.
    """
    whole = len(LOADS) - 2
    spread = 1.0 / scale[whole] if scale[whole] > 0 else 0.0
    by = measures[:, whole] - shift[whole] - spread * np.broadcast_to(drift, shift.shape)[whole]
    return np.asarray(np.abs(by) > max(math.log(_OTHER_CLOCK), _OTHER_SIGMAS * spread))
