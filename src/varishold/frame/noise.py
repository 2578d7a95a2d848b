"""The noise of one frame, from the frame alone: what no smooth pressure makes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from varishold.files.compiling import njit
from varishold.frame.checks import as_numbers, as_usable

__all__ = ["MEDIAN_ABS_NORMAL", "ROUNDING", "frame_noise", "noise_sigma"]

# Median of |z| for a standard normal z.
MEDIAN_ABS_NORMAL = 0.6744897501960817
# Residuals beyond this many sigma belong to a contact's rim and are left out of the next round.
_CLIP = 3.0
_ROUNDS = 3
# Relative; far below the sampling error of any frame.
_PRECISION = 1e-3
# Of a larger frame only every so manyeth row is looked at: sigma is then known to 1 %.
_MOST_TAXELS = 16_384
# Fewer residuals than this say more about the contact's form than about the noise.
_FEWEST = 16
# Where a sensor shows zeros instead of noise, every residual comes from inside the contact.
_FEWEST_INSIDE = 64
# The lowest value in this share of the taxels: the sensor cuts off what lies below it.
_CUT_SHARE = 0.25
# Neighbours of a cut taxel: in clipped noise 2/3 stand above the cut, around a contact few.
_MIXED_SHARE = 0.4
# max(z, 0) has these fractions of sigma in the residuals' clipped medians (1e6 taxels, seed 0).
_CLIPPED_MIXED = 0.5691
_CLIPPED_LAPLACIAN = 0.5263
_CLIPPED_LINE = 0.5727
# Rounding to whole numbers alone leaves this much noise.
ROUNDING = 1 / math.sqrt(12)

_PLAIN, _THRESHOLDED, _CLIPPED = 0, 1, 2
# State of a taxel that may take part in no residual.
_NEVER = 100


@njit(cache=True)
def _at_most(a, n, bound):  # type: ignore[no-untyped-def]
    count = 0
    for i in range(n):
        count += a[i] <= bound
    return count


@njit(cache=True)
def _median(a, n, rank, n_low, bound, n_bound):  # type: ignore[no-untyped-def]
    """Return the value of that rank among a[:n] >= 0 to _PRECISION, and how many values are no greater.

    Counts: n_low <= rank at 0, n_bound > rank at `bound`. Interpolation by counting: a count runs over many
    values an instruction, a selection does not.
    """
    if n_low > rank:
        return 0.0, n_low
    low, high, n_high = 0.0, bound, n_bound
    above, turn = False, 0
    while high - low > _PRECISION * high:
        turn += 1
        if turn % 4 == 0:
            middle = 0.5 * (low + high)
        else:
            # A little beyond the guess, on the side that is not known closely yet.
            side = max(0.4 * _PRECISION * high, 0.03 * (high - low))
            side = -side if above else side
            middle = low + (high - low) * ((rank + 0.5 - n_low) / (n_high - n_low)) + side
            middle = min(max(middle, low + 0.02 * (high - low)), high - 0.02 * (high - low))
        if middle <= low or middle >= high:
            break
        count = _at_most(a, n, middle)
        above = count > rank
        if above:
            high, n_high = middle, count
        else:
            low, n_low = middle, count
    return high, n_high


@njit(cache=True)
def _robust_sigma(a, n):  # type: ignore[no-untyped-def]
    """Return sigma of n absolute residuals a[:n] by their median, clipped for outliers in rounds."""
    zeros = _at_most(a, n, 0.0)
    # The median of positive values is at most twice their mean.
    median, n_median = _median(a, n, n // 2, zeros, 2.000001 * _sum(a, n) / n, n)
    kept = n
    for _ in range(_ROUNDS):
        still = _at_most(a, n, _CLIP / MEDIAN_ABS_NORMAL * median)
        if still == kept:
            break
        kept = still
        median, n_median = _median(a, n, kept // 2, zeros, median, n_median)
    return median / MEDIAN_ABS_NORMAL


@njit(cache=True, fastmath={"reassoc"})
def _sum(a, n):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(n):
        total += a[i]
    return total


@njit(cache=True)
def _all(a):  # type: ignore[no-untyped-def]
    n = 0
    for i in range(a.size):
        n += a[i]
    return n == a.size


@njit(cache=True)
def _lowest(a):  # type: ignore[no-untyped-def]
    """Return the lowest of finite values, and how often it is there."""
    one = two = three = four = a[0]
    # Four at a time: a minimum waits for the one before.
    for i in range(a.size // 4):
        j = 4 * i
        one = a[j] if a[j] < one else one
        two = a[j + 1] if a[j + 1] < two else two
        three = a[j + 2] if a[j + 2] < three else three
        four = a[j + 3] if a[j + 3] < four else four
    for j in range(a.size - a.size % 4, a.size):
        one = a[j] if a[j] < one else one
    lowest = min(min(one, two), min(three, four))
    count = 0
    for i in range(a.size):
        count += a[i] == lowest
    return lowest, count


@njit(cache=True)
def _kind(frame, usable, whole):  # type: ignore[no-untyped-def]
    """Tell noise that is all there from noise that a sensor has cut off: (kind, value of the cut)."""
    rows, cols = frame.shape
    n = 0
    if whole:
        n = frame.size
        lowest, at_lowest = _lowest(frame.ravel())
    else:
        lowest, at_lowest = np.inf, 0
        for r in range(rows):
            for c in range(cols):
                if usable[r, c]:
                    n += 1
                    if frame[r, c] < lowest:
                        lowest = frame[r, c]
                        at_lowest = 1
                    elif frame[r, c] == lowest:
                        at_lowest += 1
    if at_lowest < _CUT_SHARE * n:
        return _PLAIN, lowest
    mixed, same = 0, 0
    for r in range(rows):
        for c in range(cols):
            if not usable[r, c]:
                continue
            here = frame[r, c] == lowest
            if r + 1 < rows and usable[r + 1, c]:
                below = frame[r + 1, c] == lowest
                mixed += here != below
                same += here and below
            if c + 1 < cols and usable[r, c + 1]:
                right = frame[r, c + 1] == lowest
                mixed += here != right
                same += here and right
    if mixed > _MIXED_SHARE * (mixed + same):
        return _CLIPPED, lowest
    return _THRESHOLDED, lowest


@njit(cache=True)
def _mixed_differences(frame, state, allowed, every, out):  # type: ignore[no-untyped-def]
    """Write the mixed differences that start in every so manyeth row; without a state all of them count."""
    rows, cols = frame.shape
    n = 0
    for r in range(0, rows - 1, every):
        f0, f1 = frame[r], frame[r + 1]
        if state.size == 0:
            line = out[n : n + cols - 1]
            for c in range(cols - 1):
                line[c] = abs(f0[c] - f0[c + 1] - f1[c] + f1[c + 1]) / 2.0
            n += cols - 1
            continue
        s0, s1 = state[r], state[r + 1]
        for c in range(cols - 1):
            # Written always and kept only if it counts: no branch for the processor to guess.
            out[n] = abs(f0[c] - f0[c + 1] - f1[c] + f1[c + 1]) / 2.0
            n += (s0[c] + s0[c + 1] + s1[c] + s1[c + 1] <= allowed) & (out[n] < np.inf)
    return n


@njit(cache=True)
def _laplacian_differences(frame, state, allowed, every, out):  # type: ignore[no-untyped-def]
    """Write the differences of Laplacians, as `_mixed_differences` does."""
    rows, cols = frame.shape
    n = 0
    for r in range(0, rows - 2, every):
        f0, f1, f2 = frame[r], frame[r + 1], frame[r + 2]
        if state.size == 0:
            line = out[n : n + cols - 2]
            for c in range(cols - 2):
                sides = (f0[c] - 2 * f1[c] + f2[c]) + (f0[c + 2] - 2 * f1[c + 2] + f2[c + 2])
                line[c] = abs(sides - 2 * (f0[c + 1] - 2 * f1[c + 1] + f2[c + 1])) / 6.0
            n += cols - 2
            continue
        s0, s1, s2 = state[r], state[r + 1], state[r + 2]
        left, middle = f0[0] - 2 * f1[0] + f2[0], f0[1] - 2 * f1[1] + f2[1]
        left_state, middle_state = s0[0] + s1[0] + s2[0], s0[1] + s1[1] + s2[1]
        for c in range(2, cols):
            right = f0[c] - 2 * f1[c] + f2[c]
            right_state = s0[c] + s1[c] + s2[c]
            out[n] = abs((left + right) - 2 * middle) / 6.0
            n += (left_state + middle_state + right_state <= allowed) & (out[n] < np.inf)
            left, middle = middle, right
            left_state, middle_state = middle_state, right_state
    return n


@njit(cache=True)
def _line_differences(line, state, allowed, out):  # type: ignore[no-untyped-def]
    n = 0
    for c in range(line.size - 2):
        out[n] = abs(line[c] - 2 * line[c + 1] + line[c + 2]) / math.sqrt(6.0)
        counts = state.size == 0 or state[c] + state[c + 1] + state[c + 2] <= allowed
        n += counts & (out[n] < np.inf)
    return n


@njit(cache=True)
def noise_sigma(frame, usable, scratch):  # type: ignore[no-untyped-def]
    """Return sigma of one frame's noise; the compiled core of `frame_noise`, for use in other kernels.

    Parameters
    ----------
    frame : ndarray of shape (rows, cols), float64
        The frame.
    usable : ndarray of shape (rows, cols), bool
        False where there is no taxel or a broken one; what is not finite leaves itself out.
    scratch : ndarray of shape (>= rows * cols,), float64
        Overwritten.
    """
    rows, cols = frame.shape
    whole = _all(usable.ravel()) and math.isfinite(_sum(frame.ravel(), frame.size))
    kind, cut = _kind(frame, usable, whole)
    every = 1 + (frame.size - 1) // _MOST_TAXELS
    # A residual counts where the states of its taxels sum to no more than is allowed.
    state = np.empty((0, 0), np.int64)
    if kind != _PLAIN or not whole:
        state = np.empty((rows, cols), np.int64)
        at_cut = 0 if kind == _PLAIN else 1
        for r in range(rows):
            for c in range(cols):
                state[r, c] = (at_cut if frame[r, c] == cut else 0) if usable[r, c] else _NEVER
    allowed_laplacian, allowed_mixed, allowed_line = 0, 0, 0
    fewest = _FEWEST
    scale_laplacian, scale_mixed, scale_line = 1.0, 1.0, 1.0
    if kind == _THRESHOLDED:
        fewest, every = _FEWEST_INSIDE, 1
    elif kind == _CLIPPED:
        allowed_laplacian, allowed_mixed, allowed_line = 8, 3, 2
        scale_laplacian, scale_mixed, scale_line = _CLIPPED_LAPLACIAN, _CLIPPED_MIXED, _CLIPPED_LINE

    if rows < 2 or cols < 2:
        n = _line_differences(frame.ravel(), state.ravel(), allowed_line, scratch)
        return _robust_sigma(scratch, n) / scale_line if n >= fewest else 0.0
    sigma = np.inf
    if rows > 2 and cols > 2:
        n = _laplacian_differences(frame, state, allowed_laplacian, every, scratch)
        if n < fewest:
            return 0.0
        sigma = _robust_sigma(scratch, n) / scale_laplacian
    n = _mixed_differences(frame, state, allowed_mixed, every, scratch)
    if n < fewest:
        return 0.0
    return min(sigma, _robust_sigma(scratch, n) / scale_mixed)


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
    values = np.ascontiguousarray(given, dtype=np.float64)
    usable = as_usable(frame, values.shape, field, valid) & np.isfinite(values)
    if not usable.any():
        return 0.0
    sigma = float(noise_sigma(values, usable, np.empty(values.size)))
    if given.dtype.kind in "iu" and sigma < ROUNDING and np.ptp(values[usable]) > 0:
        return ROUNDING
    return sigma
