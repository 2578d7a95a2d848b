"""From a contact to the surface that it is."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Collection
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.errors import InputError, require_a
from varishold.kernel import address, bind, work_space
from varishold.levelset.contact import Contact
from varishold.touch.caution import FEWEST_LINES, cautious
from varishold.touch.decision import NAME_OF, Parameters, kind_logits, load_parameters
from varishold.touch.names import KINDS, NAMES
from varishold.touch.network import KernelNetwork
from varishold.touch.scale import LEVELS, as_learned, bridged, spanned, squared
from varishold.touch.signature import SIGNATURE_NAMES, contact_signature
from varishold.touch.surface import Surface

if TYPE_CHECKING:
    from varishold.skin import Relief

__all__ = ["contact_signature", "decided", "recognize"]

# Pads with fewer rows or columns than this have a table of their own.
_TABLES_BELOW = ((10, "small"), (22, "middle"))

# struct vh_hints of varishold.h.
_HINTS = struct.Struct("@3dPi")
_recognize = bind("vh_recognize", "ppppppp", "i")
_decide = bind("vh_decide", "ppppp")
_has_hollow = bind("vh_has_hollow", "p", "i")
_has_hill = bind("vh_has_hill", "p", "i")


class _Answer(ctypes.Structure):
    _fields_ = [("name", ctypes.c_int), ("kind", ctypes.c_int), ("probability", ctypes.c_double)]

    @property
    def at(self) -> int:
        return ctypes.addressof(self)


def recognize(
    contact: Contact, *, relief: Relief | None = None, among: Collection[str] | None = None, early: bool = False
) -> Surface:
    """Say what surface a contact is.

    Names are given at 32 levels that span a contact, whatever thresholds it was measured at. They are not sure where
    its top, or much of it, lies in a hole of broken taxels or in a gap of the pad.

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
        If `contact` or `relief` is something else, or `among` holds a name that is not one of `NAMES`.

    Examples
    --------
    >>> from varishold.solids import Cone, ideal_frame
    >>> from varishold.touch import find_contacts
    >>> frame = ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0)
    >>> recognize(find_contacts(frame)[0]).name
    'cone'
    """
    if not isinstance(contact, Contact):
        raise InputError(f"recognize takes a contact, one of find_contacts(frame), got {type(contact).__name__}")
    allowed, early = None if among is None else _allowed(among), bool(early)
    as_usual = early or (contact.frame.even and contact.frame.n_levels >= LEVELS)
    seen = contact if as_usual else spanned(contact)
    seen = bridged(seen) if seen.frame.has_gaps else seen
    pitch = contact.pitch
    seen = seen if early or pitch is None or pitch[0] == pitch[1] else squared(seen)
    parameters = load_parameters("early" if early else table_for(seen.shape))
    if relief is None:
        said = decided(seen, parameters.kernel, allowed, early)
        if said is not None:
            return _surface(contact, seen, *said, parameters)
    numbers = contact_signature(seen if early else as_learned(seen))
    white = _whitened(numbers, parameters)
    logits = kind_logits(white, parameters)
    if relief is not None:
        from varishold.skin import Relief
        from varishold.touch.relief import relief_signature

        require_a(Relief, relief, "relief", "as reconstruct gives it")
        # Both tables weigh the taxels; the second one knows the surface too. Their evidence is pooled.
        parameters = load_parameters("reliefs")
        white = _whitened(np.concatenate([numbers, relief_signature(relief)]), parameters)
        logits = kind_logits(white, parameters) + parameters.taxels_weight * logits
    answer = _Answer()
    _decide(seen.packed, parameters.kernel.at, _hints(seen, allowed, early), address(logits), answer.at)
    return _surface(contact, seen, answer, white, logits, parameters)


def decided(
    contact: Contact, network: KernelNetwork, allowed: NDArray[np.bool_] | None = None, early: bool = False
) -> tuple[_Answer, NDArray[np.float64], NDArray[np.float64]] | None:
    """Return what a network says of a contact, its whitened inputs and the probability of every kind.

    None where the contact is not like those that names are learned from: larger, or lower.
    """
    inputs, p, answer = np.empty(len(SIGNATURE_NAMES)), np.empty(network.n_outputs), _Answer()
    done = _recognize(
        *(contact.packed, network.at, _hints(contact, allowed, early), address(inputs), address(p)),
        *(answer.at, work_space(network.work)),
    )
    return (answer, inputs, p) if done else None


def _hints(contact: Contact, allowed: NDArray[np.bool_] | None, early: bool) -> bytes:
    """Return a `struct vh_hints`."""
    return _HINTS.pack(*contact.frame.rest, 0 if allowed is None else address(allowed), early)


def _surface(
    contact: Contact,
    seen: Contact,
    answer: _Answer,
    inputs: NDArray[np.float64],
    p: NDArray[np.float64],
    parameters: Parameters,
) -> Surface:
    kind = KINDS[answer.kind]
    surface = Surface(contact, kind.name, kind.form, kind.section, answer.probability, p, inputs, parameters)
    # Within wide pads with noise and a whole grid, as most are, a contact needs no caution.
    frame = seen.frame
    whole = frame.losses.repaired is None and frame.losses.stands is None and not frame.has_gaps
    plain = whole and min(frame.shape) >= FEWEST_LINES and frame.sigma > 0.0 and not seen.at_border
    return surface if plain else cautious(surface, seen)


def has_hollow(contact: Contact) -> bool:
    """Tell whether a contact that fills the field is a plane with a hollow within: a bump where readings fall."""
    return bool(_has_hollow(contact.packed))


def has_hill(contact: Contact) -> bool:
    """Tell whether a contact that fills the field is a plane with a hill on it: a bump on a rest not taken off."""
    return bool(_has_hill(contact.packed))


def fills_evenly(contact: Contact) -> bool:
    """Tell whether every taxel of the field has the contact's peak value."""
    field = contact.field
    return (
        all(contact.borders)
        and contact.n_taxels == np.count_nonzero(field)
        and bool(np.all(contact.frame.padded[1:-1, 1:-1][field] == contact.peak))
    )


@lru_cache(maxsize=64)
def table_for(shape: tuple[int, int]) -> str:
    """Return the name of the table of parameters for pads of so many rows and columns."""
    return next((name for below, name in _TABLES_BELOW if min(shape) < below), "surfaces")


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
    by_name = np.bincount(NAME_OF, weights=p, minlength=len(NAMES))
    best = int(by_name.argmax())
    kind = KINDS[int(np.where(NAME_OF == best, p, -1.0).argmax())]
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
    if isinstance(among, str) or not isinstance(among, Collection) or not all(isinstance(name, str) for name in among):
        raise InputError(f"among must be several names of {', '.join(NAMES)}, got {str(among)[:60]!r}")
    strange = [name for name in among if name not in NAMES]
    if strange:
        raise InputError(f"among holds {strange[0]!r}, which is no name; names are {', '.join(NAMES)}")
    if not among:
        raise InputError("among is empty; give at least one name, or leave it out")
    return np.array([kind.name in among for kind in KINDS])
