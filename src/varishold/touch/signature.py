"""A contact's signature: scale-free numbers that say how its sections nest and grow, and how its taxels lie.

The kernel measures them (`native/signature.c`, `bands.c`, `taxel_moments.c`, `state.c`); here are their names.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind
from varishold.levelset.contact import Contact
from varishold.touch.bands import BANDS, PER_BAND
from varishold.touch.state import STATE_GROUPS, STATE_NAMES

__all__ = ["PER_WEIGHT", "SIGNATURE_GROUPS", "SIGNATURE_NAMES", "WEIGHTS", "contact_signature", "kernel_contact"]

#: How taxels are weighed: by their height, by its square, or nearly all alike.
WEIGHTS = ("height", "height_squared", "base")
#: Group and name of every number of a weight, in the order in which the kernel writes them.
PER_WEIGHT = (
    ("volume", "spread"),
    ("volume", "peakedness"),
    ("elongation", "moment_2"),
    ("outline", "moment_3"),
    ("outline", "moment_4"),
    ("outline", "moment_6"),
)
_SINGLE = (
    ("volume", "fill"),
    ("volume", "top_at_centre"),
    ("volume", "peak_offset"),
    ("resolution", "log_size"),
    ("resolution", "log_minor"),
    ("resolution", "noise"),
    ("border", "field_share"),
    ("border", "side_1"),
    ("border", "side_2"),
    ("border", "side_3"),
    ("border", "side_4"),
    ("border", "opposite"),
)

#: Name of every number of a signature, in order.
SIGNATURE_NAMES: tuple[str, ...] = (
    *(f"{name}_{band}" for _, name in PER_BAND for band in range(BANDS)),
    *(f"{weight}_{name}" for weight in WEIGHTS for _, name in PER_WEIGHT),
    *(name for _, name in _SINGLE),
    *STATE_NAMES,
)
#: What each number of a signature tells of, in the same order.
SIGNATURE_GROUPS: tuple[str, ...] = (
    *(group for group, _ in PER_BAND for _ in range(BANDS)),
    *(group for _ in WEIGHTS for group, _ in PER_WEIGHT),
    *(group for group, _ in _SINGLE),
    *STATE_GROUPS,
)

# struct vh_contact of varishold.h.
_CONTACT = struct.Struct("@5P4i5d")
_signature = bind("vh_signature", "pp")


def kernel_contact(contact: Contact) -> bytes:
    """Return a contact as the kernel takes it; good as long as the contact is kept.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    bytes
        A `struct vh_contact`.
    """
    frame, k = contact.frame, contact.index
    height, width = frame.label.shape
    places, measures, counts = frame.places, frame.measures, frame.counts
    row_pitch, col_pitch = contact.spacing
    peak, floor = frame.values[k].tolist()
    return _CONTACT.pack(
        address(frame.padded),
        address(frame.label),
        address(places) + k * places.strides[0],
        address(measures) + k * measures.strides[0],
        address(counts) + k * counts.strides[0],
        height,
        width,
        k,
        counts.shape[2],
        row_pitch,
        col_pitch,
        peak,
        floor,
        contact.sigma,
    )


def contact_signature(contact: Contact) -> NDArray[np.float64]:
    """Return the signature of a contact: the numbers named in `SIGNATURE_NAMES`.

    Parameters
    ----------
    contact : Contact

    Returns
    -------
    ndarray of shape (n_inputs,), float64
        Dimensionless.
    """
    out = np.empty(len(SIGNATURE_NAMES))
    _signature(kernel_contact(contact), address(out))
    return out
