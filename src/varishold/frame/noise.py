"""The noise of one frame, from the frame alone: what no smooth pressure makes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.frame.checks import as_floats, as_numbers, as_usable
from varishold.kernel import address, bind, work_space

__all__ = ["MEDIAN_ABS_NORMAL", "OF_MEDIAN", "ROUNDING", "frame_noise", "noise_sigma", "sigma_of_half"]

# Median of |z| for a standard normal z.
MEDIAN_ABS_NORMAL = 0.6744897501960817
# The standard error of a median in those of a mean.
OF_MEDIAN = 1.2533
# Rounding to whole numbers alone leaves this much noise.
ROUNDING = 1 / math.sqrt(12)

_sigma = bind("vh_noise_sigma", "ppiip", "d")
_sigma_work = bind("vh_noise_sigma_work", "ii", "z")


def noise_sigma(frame: NDArray[np.float64], usable: NDArray[np.bool_]) -> float:
    """Return sigma of one frame's noise: `frame_noise` of arrays as the kernel takes them, unchecked.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        In one piece.
    usable : ndarray of shape (rows, cols), bool
        False where there is no taxel or a broken one; what is not finite leaves itself out.
    """
    rows, cols = frame.shape
    sigma: float = _sigma(address(frame), address(usable), rows, cols, work_space(_sigma_work(rows, cols)))
    return sigma


def frame_noise(frame: ArrayLike, field: ArrayLike | None = None, valid: ArrayLike | None = None) -> float:
    """Estimate the standard deviation of one frame's noise, from the frame alone.

    Two residuals that vanish on smooth pressure are formed everywhere: the mixed difference of 2 x 2 taxels
    and the 3 x 3 difference of Laplacians [1]_. Each one's sigma is its median absolute value, with
    residuals beyond three sigma (a contact's rim) left out in rounds; the smaller of the two is taken.
    Pads of one row or column use second differences.

    A sensor that shows zeros instead of small values hides its noise; then only residuals from inside the
    contact count, and 0 is returned where they are too few to tell noise from form. Noise that is merely
    clipped at zero is recognized by how zeros and small values mix, and its sigma is restored.

    Of frames of more than 16,384 taxels, residuals are formed in every second, third ... row only, so that
    about so many are looked at.

    Parameters
    ----------
    frame : array_like of shape (rows, cols), float or integer
        The frame. An integer frame that is not constant has at least its rounding error, 1 / sqrt(12).
    field, valid : array_like of shape (rows, cols), bool, optional
        False where there is no taxel, and where a taxel is broken.

    Returns
    -------
    float
        In the unit of the frame; 0 for a constant frame and for one too small to tell (fewer than 16
        residuals).

    Raises
    ------
    InputError
        If the frame is not a (rows, cols) array of numbers or a mask has another shape.

    References
    ----------
    .. [1] J. Immerkaer, "Fast noise variance estimation", Computer Vision and Image Understanding 64 (1996),
       p. 300-302.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> contact = np.zeros((16, 16))
    >>> contact[4:9, 5:11] = 1.0
    >>> bool(abs(frame_noise(contact + rng.normal(0, 0.02, (16, 16))) / 0.02 - 1) < 0.2)
    True
    >>> frame_noise(np.ones((16, 16)))
    0.0
    """
    given = as_numbers(frame, 2, "a frame", masked=True)
    values = as_floats(given, 2, "a frame", masked=True)
    usable = as_usable(frame, values.shape, field, valid) & np.isfinite(values)
    if not usable.any():
        return 0.0
    sigma = noise_sigma(values, usable)
    if given.dtype.kind in "iu" and sigma < ROUNDING and np.ptp(values[usable]) > 0:
        return ROUNDING
    return sigma


def sigma_of_half(values: NDArray[np.float64]) -> float:
    """Return the standard deviation about zero that half of some values tell, as if they were normal."""
    return float(np.median(np.abs(values))) / MEDIAN_ABS_NORMAL
