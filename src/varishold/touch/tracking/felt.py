"""What the tracker takes of one contact of one frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact

__all__ = ["Felt", "feel", "gap", "joined"]

# What stands so many sigma high counts for where the load is.
_CLEAR = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Felt:
    """One contact of one frame.

    Parameters
    ----------
    contact : Contact
    taxels : ndarray of shape (n_taxels,), intp
        Its taxels, as indices into the flattened frame.
    position : (float, float)
        Centre of load (x, y), in taxels from the pad's centre.
    load : float
        Sum over its taxels, in the unit of the frame.
    peak : float
    sigma : float
        The noise.
    """

    contact: Contact
    taxels: NDArray[np.intp]
    position: tuple[float, float]
    load: float
    peak: float
    sigma: float


def feel(contacts: Sequence[Contact], sigma: float) -> list[Felt]:
    """Return what the tracker takes of a frame's contacts, the heaviest first, whatever their order.

    Parameters
    ----------
    contacts : sequence of Contact
    sigma : float
        The noise, as far as earlier frames have told it.
    """
    if not contacts:
        return []
    frame = contacts[0].frame
    rows, cols = frame.shape
    label = frame.label[1:-1, 1:-1].ravel()
    values = frame.padded[1:-1, 1:-1].ravel()
    sigma = max(sigma, contacts[0].sigma)
    felt = []
    for contact in contacts:
        taxels = np.flatnonzero(label == contact.index)
        of_taxels = values[taxels]
        height = np.maximum(of_taxels - max(contact.floor, _CLEAR * sigma), 0.0)
        total = float(height.sum())
        if not total > 0:
            height, total = np.ones(len(taxels)), float(len(taxels))
        x = float(height @ (taxels % cols)) / total - (cols - 1) / 2
        y = float(height @ (taxels // cols)) / total - (rows - 1) / 2
        felt.append(Felt(contact, taxels, (x, y), float(of_taxels.sum()), contact.peak, sigma))
    return sorted(felt, key=lambda one: (-one.load, one.position))


def joined(main: Felt, parts: Sequence[Felt]) -> Felt:
    """Return a contact and what has fallen off from it as one; the contact stays the main one's."""
    if not parts:
        return main
    every = (main, *parts)
    load = sum(one.load for one in every)
    x, y = (sum(one.load * one.position[axis] for one in every) / load for axis in (0, 1))
    taxels = np.concatenate([one.taxels for one in every])
    return Felt(main.contact, taxels, (x, y), load, max(one.peak for one in every), main.sigma)


def gap(one: Felt, other: Felt) -> int:
    """Return how many rows or columns lie between the nearest taxels of two contacts."""
    cols = one.contact.shape[1]
    between = [
        np.abs(np.subtract.outer(part(one.taxels, cols), part(other.taxels, cols)))
        for part in (np.floor_divide, np.mod)
    ]
    return int(np.maximum(*between).min()) - 1
