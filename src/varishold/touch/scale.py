"""A contact as those were from which names were learned: on their scale, above their floor, without small gaps."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from varishold.frame.floor import FLOOR_OF_PEAK
from varishold.levelset.contact import Contact
from varishold.levelset.contact_state import Losses
from varishold.levelset.contacts import find_contacts
from varishold.touch.caution import FEWEST_LINES

__all__ = ["LEVELS", "MOST_SIDE", "as_learned", "averaging", "bridged", "on_scale", "small_gaps", "spanned", "squared"]

#: Names were learned from contacts of up to so many taxels along their longer side.
MOST_SIDE = 48
# Larger ones are averaged down to at most so many.
_WORKING_SIDE = 32
#: Names were learned at so many levels; fewer tell less of a form.
LEVELS = 32
# Of taxels that are so many times as long as broad several are one.
_OBLONG = 1.75
# A gap is small of one taxel, or of so many of the pad's; all together are at most such a share of them.
_SMALL, _SMALL_SHARE = 1 / 4, 0.3


def averaging(contact: Contact) -> int:
    """Return how many neighbours along a side are averaged so that a contact is as large as those learned from."""
    side = max(along.stop - along.start for along in contact.window)
    return 1 if side <= MOST_SIDE else -(-side // _WORKING_SIDE)


def bridged(contact: Contact) -> Contact:
    """Return a contact as if there were taxels in the small gaps within the pad, filled from their neighbours.

    Names were learned from pads without gaps: there a hole is a form. A contact on a pad without any, or beside them,
    is returned as it is.
    """
    frame = contact.frame
    gaps = _gaps_of(frame.field.tobytes(), frame.shape)
    if not gaps[contact.window].any():
        return contact
    values = np.where(gaps, 0.0, frame.padded[1:-1, 1:-1])
    found = find_contacts(
        values,
        len(contact.profile),
        pitch=contact.pitch,
        valid=~gaps,
        field=frame.field | gaps,
        floor=contact.floor,
    )
    repaired = gaps if frame.losses.repaired is None else gaps | frame.losses.repaired
    return _known_as(contact, _over(found, *contact.peak_taxel), replace(frame.losses, repaired=repaired))


def spanned(contact: Contact) -> Contact:
    """Return a contact at levels that span it, as many as those have from which names were learned."""
    frame = contact.frame
    values = frame.padded[1:-1, 1:-1]
    field = frame.field if frame.has_gaps else None
    found = find_contacts(values, LEVELS, pitch=contact.pitch, field=field, floor=contact.floor)
    return _known_as(contact, _over(found, *contact.peak_taxel), frame.losses)


def squared(contact: Contact) -> Contact:
    """Return a contact as if several oblong taxels beside each other were one that is nearly square.

    Names were learned from square taxels. A contact on such ones, or on a pad that would have too few lines, is
    returned as it is.
    """
    rows, cols = _beside(contact.pitch)
    if rows == cols or contact.shape[0] < FEWEST_LINES * rows or contact.shape[1] < FEWEST_LINES * cols:
        return contact
    of = contact.frame
    coarse = _averaged(of.padded[1:-1, 1:-1], rows, cols)
    row_pitch, col_pitch = contact.spacing
    found = find_contacts(coarse, LEVELS, pitch=(rows * row_pitch, cols * col_pitch), floor=contact.floor)
    row, col = contact.peak_taxel
    again = _over(found, row // rows, col // cols)
    if again is None:
        return contact
    broken = of.losses.repaired
    losses = Losses() if broken is None else Losses(repaired=_averaged(broken.astype(np.float64), rows, cols) > 0.0)
    rest = (of.rest[0], cols * of.rest[1], rows * of.rest[2])
    return Contact(replace(again.frame, sigma=of.sigma / math.sqrt(rows * cols), rest=rest, losses=losses), again.index)


def _beside(pitch: tuple[float, float] | None) -> tuple[int, int]:
    """Return how many taxels along the columns, and along the rows, are one so that it is nearly square."""
    if pitch is None:
        return 1, 1
    longer = max(pitch) / min(pitch)
    many = round(longer) if longer >= _OBLONG else 1
    return (1, many) if pitch[0] > pitch[1] else (many, 1)


def small_gaps(field: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the small gaps of a field that taxels surround, shape (rows, cols)."""
    from scipy import ndimage

    parts, n = ndimage.label(~field)
    sizes = np.bincount(parts.ravel(), minlength=n + 1)
    small = sizes <= max(1.0, _SMALL * field.size)
    small[0] = False
    for border in (parts[0], parts[-1], parts[:, 0], parts[:, -1]):
        small[border] = False
    gaps: NDArray[np.bool_] = small[parts]
    return gaps if np.count_nonzero(gaps) <= _SMALL_SHARE * field.size else np.zeros_like(gaps)


@lru_cache(maxsize=16)
def _gaps_of(field: bytes, shape: tuple[int, int]) -> NDArray[np.bool_]:
    return small_gaps(np.frombuffer(field, np.bool_).reshape(shape))


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
    coarse = _averaged(contact.frame.padded[1:-1, 1:-1], factor, factor)
    pitch = None if contact.pitch is None else (factor * contact.pitch[0], factor * contact.pitch[1])
    found = find_contacts(coarse, levels, pitch=pitch, floor=floor)
    row, col = contact.peak_taxel
    return _over(found, row // factor, col // factor) or (found or [contact])[0]


def _known_as(contact: Contact, again: Contact | None, losses: Losses) -> Contact:
    """Return a contact as it was found again, knowing what its frame knew; the contact itself where it was not."""
    if again is None:
        return contact
    of = contact.frame
    return Contact(replace(again.frame, sigma=of.sigma, rest=of.rest, losses=losses), again.index)


def _over(found: list[Contact], row: int, col: int) -> Contact | None:
    """Return the one of a frame's contacts that covers a taxel; None where none does."""
    return next((contact for contact in found if contact.frame.label[1 + row, 1 + col] == contact.index), None)


def _averaged(values: NDArray[np.float64], high: int, broad: int) -> NDArray[np.float64]:
    """Return means over so many rows and columns; NaN where fewer than half of the taxels are there (-inf is none)."""
    rows, cols = -(-values.shape[0] // high), -(-values.shape[1] // broad)
    whole = np.full((rows * high, cols * broad), -np.inf)
    whole[: values.shape[0], : values.shape[1]] = values
    several = whole.reshape(rows, high, cols, broad)
    there = several > -np.inf
    count = there.sum(axis=(1, 3))
    total = np.where(there, several, 0.0).sum(axis=(1, 3))
    return np.where(2 * count >= high * broad, total / np.maximum(count, 1), np.nan)
