"""A contact on the scale, and above the floor, from which names were learned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.frame.floor import FLOOR_OF_PEAK
from varishold.levelset.contact import Contact
from varishold.levelset.contacts import find_contacts

__all__ = ["MOST_SIDE", "as_learned", "averaging", "on_scale"]

#: Names were learned from contacts of up to so many taxels along their longer side.
MOST_SIDE = 48
# Larger ones are averaged down to at most so many.
_WORKING_SIDE = 32


def averaging(contact: Contact) -> int:
    """Return how many neighbours along a side are averaged so that a contact is as large as those learned from."""
    side = max(along.stop - along.start for along in contact.window)
    return 1 if side <= MOST_SIDE else -(-side // _WORKING_SIDE)


def as_learned(contact: Contact) -> Contact:
    """Return a contact as those were from which names were learned.

    Of a contact that covers very many taxels neighbours are averaged, as many along the rows as along the columns:
    the form stays, the noise shrinks. Below 5 % of its peak nothing is looked at. A contact of up to 48 taxels along
    its longer side that ends no lower is returned as it is.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    Contact
        Of a frame of its own.
    """
    return _seen_again(contact, max(contact.floor, FLOOR_OF_PEAK * contact.peak), len(contact.profile))


def on_scale(contact: Contact) -> Contact:
    """Return a contact on the scale on which sizes were learned: averaged as by `as_learned`, at its own thresholds."""
    return _seen_again(contact, contact.floor, contact.profile.threshold)


def _seen_again(contact: Contact, floor: float, levels: int | NDArray[np.float64]) -> Contact:
    factor = averaging(contact)
    if factor == 1 and floor == contact.floor:
        return contact
    coarse = _averaged(contact.frame.padded[1:-1, 1:-1], factor)
    pitch = None if contact.pitch is None else (factor * contact.pitch[0], factor * contact.pitch[1])
    found = find_contacts(coarse, levels, pitch=pitch, floor=floor)
    row, col = contact.peak_taxel
    there = [c for c in found if c.frame.label[1 + row // factor, 1 + col // factor] == c.index]
    return (there or found or [contact])[0]


def _averaged(values: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """Return means over squares of taxels; NaN where fewer than half of a square's taxels are there (-inf is none)."""
    rows, cols = (-(-n // factor) for n in values.shape)
    whole = np.full((rows * factor, cols * factor), -np.inf)
    whole[: values.shape[0], : values.shape[1]] = values
    squares = whole.reshape(rows, factor, cols, factor)
    there = squares > -np.inf
    count = there.sum(axis=(1, 3))
    total = np.where(there, squares, 0.0).sum(axis=(1, 3))
    return np.where(2 * count >= factor * factor, total / np.maximum(count, 1), np.nan)
