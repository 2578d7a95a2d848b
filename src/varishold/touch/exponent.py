"""The apex exponent k of A ~ (theta_1 - theta)^k."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind

__all__ = ["apex_exponent"]

_fit = bind("vh_apex_exponent", "ppiddd", "d")


def apex_exponent(
    threshold: NDArray[np.float64],
    area: NDArray[np.float64],
    *,
    peak: float,
    floor: float,
    taxel_area: float = 1.0,
) -> float | None:
    """Fit k of A = c (theta_1 - theta)^k to a profile, theta_1 free a little above the highest taxel.

    Parameters
    ----------
    threshold, area : ndarray of shape (n_levels,), float64
        A contact's profile.
    peak, floor : float
        Highest taxel and the standard plane, in the thresholds' unit.
    taxel_area : float
        Area of one taxel, in the areas' unit.

    Returns
    -------
    float or None
        None where fewer than four sections are usable. On a height map a pillar has 0, a lying cylinder
        1/2, a sphere or a ridge 1, a cone or a pyramid 2; on taxels over an elastic skin it tells little.

    Examples
    --------
    >>> theta = np.linspace(0.95, 0.05, 19)
    >>> round(apex_exponent(theta, 200 * (1 - theta) ** 2, peak=1.0, floor=0.0), 2)
    2.0
    """
    theta, areas = (np.array(a, dtype=np.float64) for a in (threshold, area))
    if not theta.size:
        return None
    k = float(_fit(address(theta), address(areas), theta.size, peak, floor, taxel_area))
    return None if math.isnan(k) else k
