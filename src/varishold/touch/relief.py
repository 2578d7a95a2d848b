"""The signature of a reconstructed surface: what a skin file adds to the taxels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact
from varishold.levelset.contacts import find_contacts
from varishold.skin import Relief, Skin, reconstruct
from varishold.touch.signature import SIGNATURE_NAMES, contact_signature

__all__ = ["RELIEF_NAMES", "relief_of", "relief_signature"]

#: Name of every number of a relief's signature: those of its height map, then those of its pressure.
RELIEF_NAMES: tuple[str, ...] = (
    *(f"height.{name}" for name in SIGNATURE_NAMES),
    *(f"pressure.{name}" for name in SIGNATURE_NAMES),
)

# Height is cut down to this share of its top: the contact line itself is unsteady.
_LINE_SHARE = 0.05


def relief_signature(relief: Relief) -> NDArray[np.float64]:
    """Return the signature of a relief: the numbers named in `RELIEF_NAMES`.

    Parameters
    ----------
    relief : Relief
        From `varishold.skin.reconstruct`.

    Returns
    -------
    ndarray of shape (2 * n_inputs,), float64
        Of its height above the contact line and of its pressure; zeros where there is nothing to cut.
    """
    parts = []
    for values, floor in ((relief.height, _LINE_SHARE * float(relief.height.max())), (relief.pressure, None)):
        contacts = find_contacts(values, floor=floor)
        # In cells, not metres: a signature has no unit, and cells are half a taxel for every pad alike.
        parts.append(contact_signature(contacts[0]) if contacts else np.zeros(len(SIGNATURE_NAMES)))
    return np.concatenate(parts)


def relief_of(contact: Contact, skin: Skin, *, among: list[Contact] | None = None) -> Relief:
    """Reconstruct the surface under one contact of a frame.

    Parameters
    ----------
    contact : Contact
        It must know its pitch.
    skin : Skin
        The skin over the taxels.
    among : list of Contact, optional
        All contacts of the frame; the others' taxels are taken as not touched.

    Returns
    -------
    Relief
    """
    frame = np.array(contact.frame.padded[1:-1, 1:-1])
    frame[~np.isfinite(frame)] = 0.0
    label = contact.frame.label[1:-1, 1:-1]
    for other in among or []:
        if other.index != contact.index:
            frame[label == other.index] = 0.0
    return reconstruct(frame, skin, pitch=contact.spacing, noise=contact.sigma)
