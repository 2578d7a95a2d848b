"""The height of a form's top on a height map: taxels average it away where it is pointed, and noise lifts the highest.

A flat top is the mean of what lies within the reach of noise below the highest taxel. Where sections shrink to a point
or a line, the law by which their areas grow is followed up to an area of zero. Where the rest is uneven nobody knows
where the height of zero lies.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.frame.noise import MEDIAN_ABS_NORMAL

if TYPE_CHECKING:
    from varishold.levelset.contact import Contact
    from varishold.touch.surface import Surface

__all__ = ["rest_reach", "top_height"]

# Shares of the way down from the highest taxel between which areas are followed, least area (taxels), fewest sections.
_FROM, _TO, _LEAST_TAXELS, _FEWEST = 0.12, 0.9, 3.0, 5
# Noise reaches so many sigma to both sides of a flat top.
_REACH = 6.0
# Half of what holds 90 % of true heights: in sigma, and in the height that a taxel's breadth takes. From drawn faces.
_HALF: dict[str, tuple[float, float]] = {
    "cylinder": (0.35, 0.03),
    "square pillar": (0.25, 0.03),
    "rectangular pillar": (0.6, 0.05),
    "frustum of a cone": (1.4, 0.15),
    "frustum of a pyramid": (1.4, 0.15),
    "sphere": (3.0, 0.25),
    "cone": (3.4, 0.25),
    "pyramid": (4.0, 0.3),
    "lying cylinder": (5.0, 0.5),
    "ridge": (12.0, 1.0),
    "hip": (20.0, 1.3),
}
_OTHER = (3.0, 0.3)
# A taxel is a mean over its square, and straight lines between taxels flatten what bends: together they blur a surface
# with this variance, in taxels squared, each way.
_BLUR = 1 / 12 + 5 / 24
# The exponent of the area that goes evenly with height, the degree of the polynomial in it that is followed, and what
# a blur takes of the area, in variances: of a tip half of what its outline grows with each taxel outwards.
_LAW: dict[str, tuple[float, int, float]] = {
    "cone": (0.5, 1, math.pi),
    "pyramid": (0.5, 1, 4.0),
    "sphere": (1.0, 2, 0.0),
    "ridge": (1.0, 2, 0.0),
    "hip": (1.0, 2, 0.0),
    "lying cylinder": (2.0, 2, 0.0),
}
# A ball's area, and the square of that of a lying cylinder, are of second degree in the height, however deep it goes.
# On fewer taxels across, their blur bends that, and lower down a gel's skirt does.
_ROUND, _ROUND_ACROSS, _ROUND_TO = {"sphere": 1, "lying cylinder": 2}, 8.0, 0.7
# A top is no farther above or below the highest taxel than this share of the height.
_FARTHEST = 0.3
# The rest is uneven where it is off zero by so many times what noise tells; half of what holds 90 % of that, in its
# standard deviation, and so many taxels tell it.
_UNEVEN, _HOLDS, _ENOUGH = 1.25, 1.64, 1 << 13


def top_height(surface: Surface) -> tuple[float, float]:
    """Return how high a form's top lies, and half of the interval that holds it in 90 %.

    Parameters
    ----------
    surface : Surface
        Of a height map.

    Returns
    -------
    (float, float)
        In the unit of the frame.
    """
    contact = surface.contact
    in_sigma, in_taxels = _HALF.get(surface.name, _OTHER)
    steep = (contact.peak - contact.floor) / math.sqrt(max(surface.area / contact.taxel_area, 1.0))
    uneven = rest_reach(contact)
    half = math.hypot(max(in_sigma * contact.sigma, in_taxels * steep), uneven)
    if surface.name not in _LAW:
        values, reach = contact.values[contact.mask], _REACH * math.hypot(contact.sigma, uneven / _HOLDS)
        return float(values[values >= contact.peak - reach].mean()), half
    profile = contact.profile
    down = (contact.peak - profile.threshold) / (contact.peak - contact.floor)
    area = profile.area / contact.taxel_area
    seen = (down > _FROM) & (down < _TO) & (area >= _LEAST_TAXELS)
    if np.count_nonzero(seen) < _FEWEST or any(contact.borders) or not contact.field[contact.window].all():
        # Where a part is hidden, areas do not follow the law.
        return contact.peak, half
    across = surface.breadths(surface.lowest)[1] / math.sqrt(contact.taxel_area)
    upper = seen & (down < _ROUND_TO)
    if surface.name in _ROUND and across >= _ROUND_ACROSS and np.count_nonzero(upper) >= _FEWEST:
        above = _zero_near_top(down[upper], area[upper] ** _ROUND[surface.name])
        return contact.peak - above * (contact.peak - contact.floor), half
    exponent, degree, taken = _LAW[surface.name]
    grows = (area[seen] + taken * _BLUR) ** exponent
    return float(np.polynomial.polynomial.polyfit(grows, profile.threshold[seen], degree)[0]), half


def _zero_near_top(down: NDArray[np.float64], grows: NDArray[np.float64]) -> float:
    """Return where a parabola through what grows with the way down from the highest taxel is zero; 0 where nowhere."""
    zeros = np.polynomial.Polynomial.fit(down, grows, 2).roots()
    real = zeros[np.isreal(zeros)].real
    near = real[np.abs(real) < _FARTHEST]
    return float(near[np.abs(near).argmin()]) if near.size else 0.0


def rest_reach(contact: Contact) -> float:
    """Return half of what holds 90 % of how far the rest beside all contacts is off zero, beyond what noise tells."""
    frame, inner = contact.frame, slice(1, -1, max(math.isqrt(math.prod(contact.shape) // _ENOUGH), 1))
    values = frame.padded[inner, inner]
    rest = values[(frame.label[inner, inner] < 0) & (values > -np.inf)]
    off = float(np.median(np.abs(rest))) / MEDIAN_ABS_NORMAL if rest.size else 0.0
    return _HOLDS * math.sqrt(off**2 - contact.sigma**2) if off > _UNEVEN * contact.sigma else 0.0
