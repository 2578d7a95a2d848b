"""The mean of the frames in which a contact lies still: what is seen of it with less noise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact, with_losses
from varishold.levelset.contacts import find_contacts
from varishold.touch.tracking.felt import Felt

__all__ = ["SteadyMean"]

# A contact lies still within so many taxels and such a share of its load.
_STILL, _STEADY = 0.35, 0.08
# No more frames count, later ones instead of earlier ones: noise four times less is as little as was learned.
_MOST = 16


class SteadyMean:
    """The mean of a contact's frames since it lies still under a steady load.

    Attributes
    ----------
    frames : int
        How many there are; one that came with a motion or another load is the first again.
    """

    def __init__(self) -> None:
        self.frames = 0
        self._mean = np.empty((0, 0))
        self._position, self._load = np.zeros(2), 0.0

    def add(self, felt: Felt) -> None:
        """Take the next frame in which the contact is a contact of its own."""
        values = _inside(felt.contact)
        goes_on = (
            values.shape == self._mean.shape
            and math.dist(felt.position, self._position) < _STILL
            and abs(felt.load - self._load) < _STEADY * self._load
        )
        self.frames = min(self.frames + 1, _MOST) if goes_on else 1
        share = 1 / self.frames
        if goes_on:
            self._mean += share * (values - self._mean)
        else:
            self._mean = values.copy()
        self._position += share * (np.array(felt.position) - self._position)
        self._load += share * (felt.load - self._load)

    def contact(self, felt: Felt) -> Contact:
        """Return the newest contact as the mean shows it, or as it is where there is no other frame."""
        own = felt.contact
        if self.frames < 2:
            return own
        of = own.frame
        field = of.field
        found = find_contacts(
            self._mean,
            of.n_levels,
            pitch=of.pitch,
            field=None if field.all() else field,
            sigma=felt.sigma / math.sqrt(self.frames),
        )
        if not found:
            return own
        found = with_losses(found, **vars(of.losses))
        label = found[0].frame.label[1:-1, 1:-1].ravel()[felt.taxels]
        # The same place may hold parts of several.
        by_index = np.bincount(label[label >= 0], minlength=1)
        index = int(by_index.argmax())
        return next((one for one in found if one.index == index and by_index[index] > 0), own)


def _inside(contact: Contact) -> NDArray[np.float64]:
    values = contact.frame.padded[1:-1, 1:-1]
    field = contact.frame.field
    return values if field.all() else np.where(field, values, 0.0)
