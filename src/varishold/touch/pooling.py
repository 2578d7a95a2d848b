"""One answer from several looks at the same contact: the frames of a press, or of a touch that still lasts."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TypeVar

import numpy as np

from varishold.touch.names import KINDS
from varishold.touch.recognizer import surface_from
from varishold.touch.surface import Surface

__all__ = ["EvidencePool"]

# A kind that one look rules out entirely can still come back.
_LEAST = 1e-12

S = TypeVar("S", bound=Surface)


class EvidencePool:
    """The evidence of several looks at one contact.

    The pool is the geometric mean of the looks' probabilities, each look weighed by its height above the noise: looks
    at one press share their systematic errors, so that more of them may not make a name surer than the best of them
    was.

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
        self._weight = 0.0
        #: How many looks there were.
        self.looks = 0

    def add(self, surface: Surface) -> None:
        """Take one more look into the pool."""
        contact = surface.contact
        weight = contact.peak - contact.floor
        self._logs += weight * np.log(np.maximum(surface.kind_probability, _LEAST))
        self._weight += weight
        self.looks += 1

    def answer(self, surface: S) -> S:
        """Return one look's surface with the names and probabilities of all; what else it knows it keeps."""
        if not self._weight > 0:
            return surface
        pooled = surface_from(surface.contact, surface.inputs, self._logs / self._weight, surface.parameters)
        return replace(surface, **{field.name: getattr(pooled, field.name) for field in fields(pooled)})
