"""How far an answer may be believed where the taxels themselves cannot show more."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from varishold.levelset.contact import Contact
from varishold.touch.decision import NAME_OF
from varishold.touch.names import KINDS, NAMES, OUTLINE_OF

if TYPE_CHECKING:
    from varishold.touch.surface import Surface

__all__ = ["FEWEST_LINES", "cautious", "no_surer", "shows_an_outline"]

#: Of a pad with fewer rows or columns nobody knows what is beyond: no form is sure.
FEWEST_LINES = 4
# Where several forms look the same, the likeliest is likelier than all others together, and not surely.
_ONE_OF_SEVERAL = 0.55
# What nothing spoke for is as likely as this, beside the others.
_SPREAD = 1e-6


def cautious(surface: Surface) -> Surface:
    """Return a surface, no surer than the pad's taxels can be: those of a narrow pad, and on-off taxels."""
    if min(surface.contact.shape) < FEWEST_LINES:
        return no_surer(surface, _ONE_OF_SEVERAL)
    if surface.form == "pillar" and surface.name != "unknown" and shows_an_outline(surface.contact):
        alike = np.array([OUTLINE_OF[kind.name] == OUTLINE_OF[surface.name] for kind in KINDS])
        return no_surer(surface, _ONE_OF_SEVERAL, among=alike)
    return surface


def shows_an_outline(contact: Contact) -> bool:
    """Tell whether all taxels of a contact read exactly the same, as on-off taxels do: an outline without a form."""
    # Where there is noise readings are not all the same.
    if contact.frame.sigma > 0.0:
        return False
    inside = contact.frame.padded[1:-1, 1:-1][contact.window]
    return bool((inside[contact.mask] == contact.peak).all())


def no_surer(surface: Surface, most: float, among: NDArray[np.bool_] | None = None) -> Surface:
    """Return a surface whose name is at most so probable; the name stays.

    Parameters
    ----------
    surface : Surface
    most : float
        Of 1, or of what the kinds of `among` have together.
    among : ndarray of shape (n_kinds,), bool, optional
        Which kinds share what the name loses. Default: all others.
    """
    mine = NAME_OF == NAMES.index(surface.name)
    kinds = surface.kind_probability
    shared = np.ones(len(kinds), np.bool_) if among is None else among | mine
    limit = most * float(kinds[shared].sum())
    if surface.probability <= limit:
        return surface
    # Where nothing else was thought of, everything else is as likely.
    others = np.where(shared & ~mine, kinds + _SPREAD, 0.0)
    rest = float(kinds[shared].sum()) - limit
    shares = np.where(shared, others * (rest / others.sum()), kinds)
    shares[mine] = kinds[mine] * (limit / surface.probability)
    return replace(surface, probability=limit, kind_probability=shares)
