"""The least step between the readings of a frame."""

from __future__ import annotations

import math

from varishold.files.compiling import njit

__all__ = ["count_of"]

# A sensor of three counts and fewer shows no noise.
_COARSEST = 0.3


@njit(nogil=True)
def count_of(frame, usable):  # type: ignore[no-untyped-def]
    """Return the least difference between neighbours that is not zero: a sensor's count, where it has one.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        Finite where usable.
    usable : ndarray of shape (rows, cols), bool

    Returns
    -------
    float
        In the unit of the frame; 0 where all neighbours are equal, or where so few counts reach the peak that they are
        the steps of the form. Of readings that are not rounded it is as good as 0.
    """
    rows, cols = frame.shape
    least, peak = math.inf, 0.0
    for r in range(rows):
        for c in range(cols):
            if not usable[r, c]:
                continue
            peak = max(peak, frame[r, c])
            for k in range(2):
                y, x = r + k, c + 1 - k
                if y < rows and x < cols and usable[y, x]:
                    step = abs(frame[r, c] - frame[y, x])
                    # What rounding of numbers leaves is no step.
                    if 1e-9 * abs(frame[r, c]) < step < least:
                        least = step
    return least if least < _COARSEST * peak else 0.0
