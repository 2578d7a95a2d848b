"""One answer from several looks at the same contact: the frames of a press, or of a touch that still lasts."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import TypeVar

import numpy as np

from varishold.levelset.contact import Contact
from varishold.touch.decision import NAME_OF
from varishold.touch.names import KINDS, NAMES
from varishold.touch.recognizer import surface_from
from varishold.touch.surface import Surface

__all__ = ["EvidencePool"]

# A kind that one look rules out entirely can still come back.
_LEAST = 1e-12
# Log-odds of an answer that is as sure as it says scatter over presses by twice their mean.
_SCATTER_OF_SURE = 2.0
# No more than this is made of what many looks agree in.
_MOST = 1.3

# A look of which every taxel is saturated still counts so far.
_LEAST_SHOWN = 0.1

S = TypeVar("S", bound=Surface)


class EvidencePool:
    """The evidence of several looks at one contact.

    The pool is the geometric mean of the looks' probabilities, each look weighed by the square of its height above the
    noise, as what it tells of a form grows (a light look at a frustum sees its top alone), and by how little of it is
    saturated. Looks at one press share their systematic errors: however many there are, their mean is no surer than one
    of them. What noise does to them they do not share, and it shows as their scatter. The mean of log-odds that scatter
    by s^2 over the looks of one press, and by v over presses, is worth v / (v - s^2) times as much as one look's; by so
    much, bounded, the pool is sharpened.

    Examples
    --------
    >>> from varishold.solids import Cone, ideal_frame
    >>> from varishold.touch import find_contacts, recognize
    >>> cone = recognize(find_contacts(ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0))[0])
    >>> pool = EvidencePool()
    >>> pool.add(cone)
    >>> pool.add(cone)
    >>> pool.answer(cone).name, pool.looks
    ('cone', 2)
    """

    def __init__(self) -> None:
        self._logs = np.zeros(len(KINDS))
        self._names = np.zeros(len(NAMES))
        self._products = np.zeros((len(NAMES), len(NAMES)))
        self._weight = 0.0
        #: How many looks there were.
        self.looks = 0

    def add(self, surface: Surface, *, frames: int = 1) -> None:
        """Take one more look into the pool; it may be one at the mean of several frames."""
        contact = surface.contact
        weight = (contact.peak - contact.floor) ** 2 * math.sqrt(frames) * _shown(contact)
        p = surface.kind_probability
        names = np.log(np.maximum(np.bincount(NAME_OF, weights=p, minlength=len(NAMES)), _LEAST))
        self._logs += weight * np.log(np.maximum(p, _LEAST))
        self._names += weight * names
        self._products += weight * np.outer(names, names)
        self._weight += weight
        self.looks += 1

    def answer(self, surface: S) -> S:
        """Return one look's surface with the names and probabilities of all; what else it knows it keeps."""
        if not self._weight > 0:
            return surface
        logs = self._sharpness() * self._logs / self._weight
        pooled = surface_from(surface.contact, surface.inputs, logs, surface.parameters)
        return replace(surface, **{field.name: getattr(pooled, field.name) for field in fields(pooled)})

    def _sharpness(self) -> float:
        """Return how much more the mean of the looks is worth than one of them."""
        mean = self._names / self._weight
        second, first = np.argsort(mean)[-2:].tolist()
        margin = float(mean[first] - mean[second])
        products = self._products / self._weight
        square = float(products[first, first] + products[second, second] - 2 * products[first, second])
        scatter = max(square - margin**2, 0.0)
        expected = max(_SCATTER_OF_SURE * margin, 1e-9)
        return expected / max(expected - scatter, expected / _MOST)


def _shown(contact: Contact) -> float:
    """Return how far a look shows a form rather than the sensor's end: by the share of its taxels that are at it."""
    share = contact.state.saturated / max(contact.n_taxels, 1)
    return max(1.0 - share, _LEAST_SHOWN) ** 2
