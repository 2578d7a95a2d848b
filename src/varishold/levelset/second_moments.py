"""Second moments of a section: its principal axes and the way they point."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["principal_angle", "principal_moments"]


def principal_moments(xx: Any, xy: Any, yy: Any) -> tuple[Any, Any]:
    """Return the larger and the smaller second moment about the principal axes, never negative.

    The axes of the ellipse that has these moments are four times their square roots long. Numbers or arrays; it
    may be compiled.

    Parameters
    ----------
    xx, xy, yy : float or ndarray
        Second central moments over the area.

    Examples
    --------
    >>> [float(m) for m in principal_moments(2.0, 0.0, 5.0)]
    [5.0, 2.0]
    """
    half, difference = 0.5 * (xx + yy), 0.5 * (xx - yy)
    root = np.sqrt(difference * difference + xy * xy)
    return np.maximum(half + root, 0.0), np.maximum(half - root, 0.0)


def principal_angle(xx: Any, xy: Any, yy: Any) -> Any:
    """Return the angle of the longer principal axis from +x toward +y, in [-pi/2, pi/2).

    Parameters
    ----------
    xx, xy, yy : float or ndarray
        As in `principal_moments`.

    Examples
    --------
    >>> float(principal_angle(2.0, 0.0, 5.0))
    -1.5707963267948966
    """
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return (angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi
