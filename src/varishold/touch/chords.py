"""The paper's inequality [18] in the readings that are true: sections against their chord.

For a convex V the section at a threshold between two others holds the mixture of those two sections, so a
measure J that grows with the section and is superadditive of degree 1 lies on or above the chord between its
values there. The area itself is of degree 2 and may lie below (it does for cones, pyramids, frustums and
hips); its square root (Brunn-Minkowski) and the perimeter may not. A defect therefore means that V is not
convex; it is a diagnostic, never an error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.levelset import Profile

__all__ = ["USABLE_TAXELS", "Inequality", "inequality"]

# A section of fewer taxels says more about interpolation than about the surface.
USABLE_TAXELS = 4.0
# A flat top's taxels lie within so many sigma of each other: the outlines cut there are the noise's.
_ROUGH_SIGMAS = 6.0


@dataclass(frozen=True, slots=True, eq=False)
class Inequality:
    """Two measures of a contact's usable sections against their chords.

    Parameters
    ----------
    threshold : ndarray of shape (n_usable,), float64
        The usable thresholds, falling.
    sqrt_area, perimeter : ndarray of shape (n_usable,), float64
        J at these thresholds, metres or taxels; the perimeter without the noise's raggedness.
    sqrt_area_chord, perimeter_chord : ndarray of shape (n_usable,), float64
        The straight line in theta between J at the highest and at the lowest of them.
    defect_sqrt_area, defect_perimeter : float
        The largest max(0, chord - J), as a share of the lowest section's J; NaN with fewer than three usable
        sections.
    bulge_sqrt_area, bulge_perimeter : float
        The largest max(0, J - chord), likewise.
    """

    threshold: NDArray[np.float64]
    sqrt_area: NDArray[np.float64]
    sqrt_area_chord: NDArray[np.float64]
    perimeter: NDArray[np.float64]
    perimeter_chord: NDArray[np.float64]
    defect_sqrt_area: float
    defect_perimeter: float
    bulge_sqrt_area: float
    bulge_perimeter: float


def inequality(profile: Profile, *, taxel_area: float = 1.0, sigma: float = 0.0) -> Inequality:
    """Compare sqrt(area) and perimeter of a contact's sections with their chords (eq. [18], corrected).

    Pillars, cones, pyramids and frustums bulge in neither; ridges and hips in sqrt(area) alone; domed
    surfaces in both.

    Parameters
    ----------
    profile : Profile
        Of a contact.
    taxel_area : float
        Area of a taxel in the unit of the profile's areas; sections of at least four taxels are usable.
    sigma : float
        Standard deviation of the frame's noise, in the thresholds' unit. An outline is taken to be no longer than
        one that noise alone sets apart from it, lower down: raggedness within the noise is no concavity.

    Returns
    -------
    Inequality

    References
    ----------
    G. Kinoshita, S. Aida and M. Mori, "Pattern recognition by an artificial tactile sense", 1971, eq. [18].

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.touch import find_contacts
    >>> y, x = np.mgrid[-24:25, -24:25]
    >>> (dome,) = find_contacts(np.maximum(1 - (x**2 + y**2) / 400, 0), 64, floor=0.02)
    >>> result = inequality(dome.profile)
    >>> result.defect_sqrt_area < 1e-3 < result.bulge_sqrt_area
    True
    """
    with np.errstate(invalid="ignore"):
        usable = np.flatnonzero(profile.area >= USABLE_TAXELS * taxel_area)
    threshold = profile.threshold[usable]
    sqrt_area = np.sqrt(profile.area[usable])
    perimeter = _without_raggedness(threshold, profile.perimeter[usable], _ROUGH_SIGMAS * sigma)
    sqrt_area_chord = _chord(threshold, sqrt_area)
    perimeter_chord = _chord(threshold, perimeter)
    return Inequality(
        threshold,
        sqrt_area,
        sqrt_area_chord,
        perimeter,
        perimeter_chord,
        _share(sqrt_area_chord - sqrt_area, sqrt_area),
        _share(perimeter_chord - perimeter, perimeter),
        _share(sqrt_area - sqrt_area_chord, sqrt_area),
        _share(perimeter - perimeter_chord, perimeter),
    )


def _without_raggedness(
    threshold: NDArray[np.float64], perimeter: NDArray[np.float64], reach: float
) -> NDArray[np.float64]:
    """Return each outline's length, or that of a shorter one down to the first that is cut `reach` lower."""
    beyond = np.searchsorted(-threshold, reach - threshold, side="left")
    lengths = perimeter.tolist()
    return np.array([min(lengths[i : max(i, stop) + 1]) for i, stop in enumerate(beyond.tolist())])


def _chord(threshold: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.float64]:
    if threshold.size < 2 or threshold[0] == threshold[-1]:
        return j.copy()
    share = (threshold[0] - threshold) / (threshold[0] - threshold[-1])
    return np.asarray(j[0] + share * (j[-1] - j[0]), dtype=np.float64)


def _share(excess: NDArray[np.float64], j: NDArray[np.float64]) -> float:
    if j.size < 3:
        return math.nan
    # A section that the border closes all around has no outline at all.
    return max(0.0, float(excess.max()) / float(j[-1])) if j[-1] > 0 else 0.0
