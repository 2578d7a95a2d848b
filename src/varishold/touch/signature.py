"""A contact's signature: scale-free numbers that say how its sections nest and grow, and how its taxels lie.

The kernel measures them (`native/signature.c`, `bands.c`, `taxel_moments.c`, `state.c`); here are their names.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from varishold.kernel import address, bind
from varishold.levelset.contact import Contact
from varishold.touch.bands import BANDS, PER_BAND
from varishold.touch.state import STATE_GROUPS, STATE_NAMES

__all__ = ["PER_WEIGHT", "SIGNATURE_GROUPS", "SIGNATURE_NAMES", "WEIGHTS", "contact_signature"]

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

_signature = bind("vh_signature", "pp")


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
    _signature(contact.packed, address(out))
    return out
