"""Dead taxels and dead lines of one frame: found where the evidence is strong, and filled.

A dead taxel reads the rest while everything around it is pressed; a dead line does so along a whole row or column.
Nothing else is touched: a frame in which nothing is found stays as it is, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.files.compiling import njit
from varishold.frame.counts import count_of
from varishold.frame.fill import fill_taxels
from varishold.frame.noise import noise_sigma

__all__ = ["Repaired", "find_dead", "repair", "repair_into"]

# A dead taxel reads the rest, and noise: at most this share of the range above the lowest reading, or this many sigma
# (the lowest of many readings lies some three sigma below the rest).
_REST_SHARE, _REST_SIGMAS = 0.04, 7.5
# What surrounds it stands this much higher.
_STEP_SHARE, _STEP_SIGMAS = 0.10, 6.0
# And by so many counts of the sensor: rounded noise is one count up or down, and no spread tells of it.
_STEP_COUNTS = 2.5
# Neighbours that a dead taxel needs: all five at a border of the pad, none of which may be at rest.
_FEWEST_AROUND = 5
# The lowest of them stands at least this share as high as the highest; on a pad of a few taxels, where noise can be
# told from form by nothing else, this share.
_LEAST_EVEN, _LEAST_EVEN_SMALL = 0.15, 0.35
# Pads with fewer rows or columns are of a few taxels.
_SMALL = 10
# Taxels of a line that must be pressed on both sides of it.
_FEWEST_ALONG = 2
# More taxels than this share of the field are no faults but a form.
_MOST_DEAD = 0.12


@dataclass(frozen=True)
class Repaired:
    """A frame whose dead taxels are filled.

    Parameters
    ----------
    values : ndarray of shape (rows, cols), float64
        The frame; the same numbers where nothing was found.
    dead : ndarray of shape (rows, cols), bool
        The taxels that were filled.
    """

    values: NDArray[np.float64]
    dead: NDArray[np.bool_]


@njit(nogil=True)
def _dead_line(line, before, after, usable, rest, step):  # type: ignore[no-untyped-def]
    """Tell whether a line is at rest throughout while the lines beside it are pressed together."""
    pressed, read = 0, 0
    for i in range(line.size):
        if not usable[i]:
            continue
        read += 1
        if line[i] > rest:
            return False
        pressed += min(before[i], after[i]) > line[i] + step
    return 2 * read > line.size and pressed >= _FEWEST_ALONG


@njit(nogil=True)
def find_dead(frame, usable, sigma, dead):  # type: ignore[no-untyped-def]
    """Mark the dead taxels of a frame; the compiled core of `repair`.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Finite where usable.
    usable : ndarray of shape (rows, cols), bool
        False where there is no taxel, or one that is known to be broken.
    sigma : float
        Standard deviation of the frame's noise.
    dead : ndarray of shape (rows, cols), bool
        Overwritten.

    Returns
    -------
    int
        Number of dead taxels.
    """
    rows, cols = frame.shape
    dead[:] = False
    low, peak, n_usable = np.inf, -np.inf, 0
    for r in range(rows):
        for c in range(cols):
            if usable[r, c]:
                low, peak = min(low, frame[r, c]), max(peak, frame[r, c])
                n_usable += 1
    span = peak - low
    if n_usable < 9 or not span > 0.0:
        return 0
    rest = low + max(_REST_SHARE * span, _REST_SIGMAS * sigma)
    step = max(_STEP_SHARE * span, _STEP_SIGMAS * sigma, _STEP_COUNTS * count_of(frame, usable))
    if rest + step >= peak:
        return 0
    n = 0
    most = int(_MOST_DEAD * n_usable)
    lines = 0
    for r in range(1, rows - 1):
        if _dead_line(frame[r], frame[r - 1], frame[r + 1], usable[r], rest, step):
            dead[r, :] = usable[r]
            lines += 1
    for c in range(1, cols - 1):
        if _dead_line(frame[:, c], frame[:, c - 1], frame[:, c + 1], usable[:, c], rest, step):
            dead[:, c] = usable[:, c]
            lines += 1
    if lines * 8 > rows + cols:
        # So many are a grating, not faults.
        dead[:] = False
    else:
        for r in range(rows):
            for c in range(cols):
                n += dead[r, c]
    least_even = _LEAST_EVEN_SMALL if min(rows, cols) < _SMALL else _LEAST_EVEN
    widest = 1 if min(rows, cols) < _SMALL else (2 if min(rows, cols) < 24 else 3)
    found = n
    member = np.empty((widest, 2), np.int64)
    for r in range(rows):
        for c in range(cols):
            if dead[r, c] or not usable[r, c] or frame[r, c] > rest:
                continue
            # The island of resting taxels that this one belongs to; all its shore must be pressed.
            member[0, 0], member[0, 1] = r, c
            size, k, enclosed, around = 1, 0, True, 0
            lowest, highest = np.inf, -np.inf
            while k < size and enclosed:
                for y in range(max(member[k, 0] - 1, 0), min(member[k, 0] + 2, rows)):
                    for x in range(max(member[k, 1] - 1, 0), min(member[k, 1] + 2, cols)):
                        known = False
                        for j in range(size):
                            known |= member[j, 0] == y and member[j, 1] == x
                        if known or dead[y, x] or not usable[y, x]:
                            continue
                        if frame[y, x] <= rest:
                            if size == widest:
                                enclosed = False
                            else:
                                member[size, 0], member[size, 1] = y, x
                                size += 1
                        elif frame[y, x] > frame[r, c] + step:
                            around += 1
                            lowest, highest = min(lowest, frame[y, x]), max(highest, frame[y, x])
                        else:
                            enclosed = False
                k += 1
            even = lowest - frame[r, c] >= least_even * (highest - frame[r, c])
            if enclosed and around >= _FEWEST_AROUND and even:
                for j in range(size):
                    dead[member[j, 0], member[j, 1]] = True
                found += size
    if found - n > most:
        dead[:] = False
        return 0
    return found


@njit(nogil=True)
def repair_into(frame, usable, field, sigma, dead):  # type: ignore[no-untyped-def]
    """Fill the dead taxels of a frame in place and return how many there were; `dead` is overwritten."""
    n = find_dead(frame, usable, sigma, dead)
    if n > 0:
        works = usable & ~dead
        fill_taxels(frame, works, field)
    return n


def repair(frame: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> Repaired:
    """Fill the taxels that read the rest while everything around them is pressed.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        Finite inside the field.
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is known to be broken (it is filled too).

    Returns
    -------
    Repaired

    Examples
    --------
    >>> import numpy as np
    >>> frame = np.zeros((12, 12))
    >>> frame[3:9, 3:9] = 1.0
    >>> frame[5, 6] = 0.0
    >>> mended = repair(frame)
    >>> round(float(mended.values[5, 6]), 6), int(mended.dead.sum())
    (1.0, 1)
    """
    values = np.array(frame, dtype=np.float64, order="C")
    inside = np.ones(values.shape, np.bool_) if field is None else np.array(field, dtype=np.bool_)
    usable = inside.copy() if valid is None else inside & np.asarray(valid, dtype=np.bool_)
    dead = np.zeros(values.shape, np.bool_)
    sigma = float(noise_sigma(values, usable, np.empty(values.size)))
    repair_into(values, usable, inside, sigma, dead)
    return Repaired(values, dead)
