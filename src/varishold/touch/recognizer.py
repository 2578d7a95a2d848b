"""From a contact to the surface that it is."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError
from varishold.frame.floor import FLOOR_OF_PEAK
from varishold.levelset.contact import Contact
from varishold.touch.decision import Parameters, kind_logits, load_parameters
from varishold.touch.names import KINDS, NAMES
from varishold.touch.scale import MOST_SIDE, as_learned
from varishold.touch.signature import SIGNATURE_NAMES, signature_into
from varishold.touch.state import STATE_NAMES, state_into
from varishold.touch.surface import Surface

if TYPE_CHECKING:
    from varishold.skin import Relief

__all__ = ["contact_signature", "recognize"]

# Pads with fewer rows or columns have a table of their own.
SMALL_PAD = 10

_NAME_INDEX = np.array([NAMES.index(kind.name) for kind in KINDS])
_IS_PLANE = np.array([kind.name == "plane" for kind in KINDS])
# A rest that was taken off and is so many times as high as what stands on it may be a plane that is pressed, with
# something left on it: these are its log-odds.
_HIGH_REST, _PLANE_ODDS = 2.5, math.log(0.45 / 0.55)
# Log-odds that outweigh whatever a table says.
_CERTAIN = 1e3


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
    frame, k, profile = contact.frame, contact.index, contact.profile
    form, state = out[: -len(STATE_NAMES)], out[-len(STATE_NAMES) :]
    signature_into(
        form,
        profile.measures,
        profile.counts,
        frame.padded,
        frame.label,
        k,
        frame.places[k],
        contact.spacing,
        contact.peak,
        contact.floor,
        contact.sigma,
    )
    state_into(state, frame.padded, frame.label, k, frame.places[k], contact.peak, contact.floor)
    return out


def recognize(
    contact: Contact, *, relief: Relief | None = None, among: Collection[str] | None = None, early: bool = False
) -> Surface:
    """Say what surface a contact is.

    Parameters
    ----------
    contact : Contact
        From `find_contacts`.
    relief : Relief, optional
        The skin's displacement under the contact, from `varishold.skin.reconstruct`.
    among : collection of str, optional
        The only names that can occur here (unknown need not be named); default: all.
    early : bool
        The contact's floor is only how far the threshold has fallen so far, not the standard plane.

    Returns
    -------
    Surface

    Raises
    ------
    InputError
        If `among` holds a name that is not one of `NAMES`.

    Examples
    --------
    >>> from varishold.solids import Cone, ideal_frame
    >>> from varishold.touch import find_contacts
    >>> frame = ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0)
    >>> recognize(find_contacts(frame)[0]).name
    'cone'
    """
    strange = contact.floor < FLOOR_OF_PEAK * contact.peak or max(s.stop - s.start for s in contact.window) > MOST_SIDE
    signature = contact_signature(as_learned(contact) if strange and not early else contact)
    parameters = load_parameters("early" if early else _table_for(contact))
    white = _whitened(signature, parameters)
    logits = kind_logits(white, parameters)
    if relief is not None:
        from varishold.touch.relief import relief_signature

        # Both tables weigh the taxels; the second one knows the surface too. Their evidence is pooled.
        parameters = load_parameters("reliefs")
        white = _whitened(np.concatenate([signature, relief_signature(relief)]), parameters)
        logits = kind_logits(white, parameters) + parameters.taxels_weight * logits
    if _stands_on_a_rest(contact):
        logits = np.where(_IS_PLANE, np.maximum(logits, _log_sum(logits[~_IS_PLANE]) + _PLANE_ODDS), logits)
    if fills_evenly(contact):
        # Every taxel at one value, as at full scale: nothing but a plane does that, and there is no outline to tell.
        logits = np.where(_IS_PLANE, logits + _CERTAIN, logits)
    if among is not None:
        logits = np.where(_allowed(among), logits, -np.inf)
    return surface_from(contact, white, logits, parameters)


def _stands_on_a_rest(contact: Contact) -> bool:
    """Tell whether the rest that was taken off is much higher than the contact that stands on it."""
    first, by_col, by_row = contact.frame.rest
    rows, cols = contact.shape
    return first + by_col * (cols - 1) / 2 + by_row * (rows - 1) / 2 > _HIGH_REST * contact.peak


def _log_sum(logits: NDArray[np.float64]) -> float:
    top = logits.max()
    return float(top + np.log(np.exp(logits - top).sum()))


def fills_evenly(contact: Contact) -> bool:
    """Tell whether every taxel of the field has the contact's peak value."""
    field = contact.field
    return (
        all(contact.borders)
        and contact.n_taxels == np.count_nonzero(field)
        and bool(np.all(contact.frame.padded[1:-1, 1:-1][field] == contact.peak))
    )


def _table_for(contact: Contact) -> str:
    return "small" if min(contact.shape) < SMALL_PAD else "surfaces"


def _whitened(signature: NDArray[np.float64], parameters: Parameters) -> NDArray[np.float64]:
    white = (signature - parameters.shift) * parameters.scale
    return np.clip(white, -parameters.clip, parameters.clip, out=white)


def surface_from(
    contact: Contact, white: NDArray[np.float64], logits: NDArray[np.float64], parameters: Parameters
) -> Surface:
    """Return the surface that log-odds of kinds make of a contact.

    Parameters
    ----------
    contact : Contact
    white : ndarray of shape (n_inputs,), float64
        The whitened inputs that gave the log-odds.
    logits : ndarray of shape (n_kinds,), float64
        Log-odds up to a constant.
    parameters : Parameters

    Returns
    -------
    Surface
    """
    p = np.exp(logits - logits.max())
    p /= p.sum()
    by_name = np.bincount(_NAME_INDEX, weights=p, minlength=len(NAMES))
    best = int(by_name.argmax())
    kind = KINDS[int(np.where(_NAME_INDEX == best, p, -1.0).argmax())]
    return Surface(
        contact=contact,
        name=NAMES[best],
        form=kind.form,
        section=kind.section,
        probability=float(by_name[best]),
        kind_probability=p,
        inputs=white,
        parameters=parameters,
    )


def _allowed(among: Collection[str]) -> NDArray[np.bool_]:
    strange = [name for name in among if name not in NAMES]
    if strange:
        raise InputError(f"among holds {strange[0]!r}, which is no name; names are {', '.join(NAMES)}")
    if not among:
        raise InputError("among is empty; give at least one name, or leave it out")
    return np.array([kind.name in among for kind in KINDS])
