"""Where a contact lies, which way it points and how wide it is, from all its sections together."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.levelset.contact import Contact
from varishold.levelset.second_moments import principal_angle, principal_moments

__all__ = ["ContactPose", "contact_pose"]


@dataclass(frozen=True, eq=False)
class ContactPose:
    """Position, orientation and extent of a contact; metres where its pitch is known, taxels otherwise.

    Parameters
    ----------
    position : (float, float)
        (x, y) from the pad's centre.
    covariance : ndarray of shape (2, 2), float64
        Weighted second central moments.
    mean_area : float
        Weighted mean area of the sections. It grows with the true area, but the sensor's blur and the form of
        the contact stand between them: calibrate it.
    """

    position: tuple[float, float]
    covariance: NDArray[np.float64]
    mean_area: float

    @property
    def orientation(self) -> float:
        """Direction of the longest extent from +x toward +y, in [-pi/2, pi/2); noise where aspect is near 1."""
        c = self.covariance
        return float(principal_angle(c[0, 0], c[0, 1], c[1, 1]))

    @property
    def aspect(self) -> float:
        """Length over breadth of the ellipse that has these moments, at least 1."""
        c = self.covariance
        long, short = principal_moments(c[0, 0], c[0, 1], c[1, 1])
        return math.sqrt(long / short) if short > 0 else math.inf


def contact_pose(contact: Contact) -> ContactPose:
    """Weigh every section of a contact by its height above the standard plane, and take them together.

    The centroid of all sections with equal weights is the centroid of V - delta; with weights theta_i - delta
    it is that of (V - delta)^2 / 2. That square is the weight that a matched filter gives: for a smooth spot
    in even noise no other places it more precisely, and the faint skirt that neighbouring taxels, cross-talk
    or a soft skin put around a contact hardly counts. Nothing is fitted.

    It places the heart of a contact. For a face that is pressed in askew that is not the middle of its
    outline: for that look at the centroid of a low section.

    Parameters
    ----------
    contact : Contact
        From `find_contacts`.

    Returns
    -------
    ContactPose

    Raises
    ------
    InputError
        If no section of the contact has an area.

    Examples
    --------
    >>> import numpy as np
    >>> from varishold.touch import find_contacts
    >>> y, x = np.mgrid[-8:9, -8:9]
    >>> ridge = np.maximum(6 - np.abs(x - 2) - 0.4 * np.abs(y), 0.0)
    >>> pose = contact_pose(find_contacts(ridge)[0])
    >>> [round(p, 3) + 0.0 for p in pose.position], round(abs(pose.orientation), 3)
    ([2.0, 0.0], 1.571)
    """
    profile = contact.profile
    used = profile.area > 0
    if not used.any():
        raise InputError(
            f"no section of the contact at taxel {contact.peak_taxel} has an area; use more levels or a lower floor"
        )
    threshold = profile.threshold[used]
    height = threshold - contact.floor
    if len(threshold) > 1:
        # Uneven thresholds: each stands for the step around it.
        height = height * -np.gradient(threshold)
    if not (height > 0).any():
        height = np.ones_like(height)
    area, centroid, covariance = profile.area[used], profile.centroid[used], profile.covariance[used]
    weight = height * area / (height @ area)
    position = weight @ centroid
    offset = centroid - position
    second = np.einsum("i,ijk->jk", weight, covariance) + np.einsum("i,ij,ik->jk", weight, offset, offset)
    return ContactPose((float(position[0]), float(position[1])), second, float(height @ area / height.sum()))
