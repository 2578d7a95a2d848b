"""Where to cut next: the threshold whose section decides most between the names still in question."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.touch.bands import BANDS
from varishold.touch.names import KINDS
from varishold.touch.signature import SIGNATURE_NAMES
from varishold.touch.surface import Surface

__all__ = ["next_threshold"]

# Kinds less probable than this are out of the question.
_LEAST = 0.01
_BAND_OF = np.array(
    [int(name.rsplit("_", 1)[1]) if name.rsplit("_", 1)[-1].isdigit() else -1 for name in SIGNATURE_NAMES]
)


def next_threshold(surface: Surface, cut: ArrayLike) -> float:
    """Return the threshold to cut at next, toward the sections that still decide between forms.

    The sections of a band of heights decide between two kinds as far as the kinds' usual measures there lie
    apart (in units of their spread), and as far as both are still probable. What a cut in the middle of a gap
    between two cuts adds goes with the square of the gap, as the error of a sum of sections does.

    Parameters
    ----------
    surface : Surface
        The answer so far.
    cut : array_like of shape (n,)
        Thresholds cut so far, in the frame's unit.

    Returns
    -------
    float
        The middle of a gap between thresholds cut so far, or the contact's top or floor.

    Examples
    --------
    >>> from varishold.solids import Cone, ideal_frame
    >>> from varishold.touch import find_contacts, recognize
    >>> surface = recognize(find_contacts(ideal_frame(Cone(18.0, 6.0), (32, 32), 1.0))[0])
    >>> bool(surface.contact.floor < next_threshold(surface, [3.0]) < surface.contact.peak)
    True
    """
    contact = surface.contact
    span = contact.peak - contact.floor
    depth = (contact.peak - np.asarray(cut, dtype=np.float64).ravel()) / span
    edges = np.concatenate([[0.0], np.sort(depth[(depth > 0) & (depth < 1)]), [1.0]])
    middle = 0.5 * (edges[1:] + edges[:-1])
    band = (middle * BANDS).astype(int)
    worth = np.diff(edges) ** 2 * np.sqrt(_decisiveness(surface)[band])
    return float(contact.peak - span * middle[int(np.argmax(worth))])


def _decisiveness(surface: Surface) -> NDArray[np.float64]:
    """Return how far each band's sections tell the kinds in question apart; shape (BANDS,)."""
    p = surface.kind_probability
    usual = surface.parameters.kind_means[:, : len(SIGNATURE_NAMES)]
    asked = [kind for kind in range(len(KINDS)) if p[kind] >= _LEAST]
    score = np.full(BANDS, 1e-9)
    for i, one in enumerate(asked):
        for other in asked[i + 1 :]:
            if KINDS[one].name == KINDS[other].name:
                continue
            apart = (usual[one] - usual[other]) ** 2
            for band in range(BANDS):
                score[band] += p[one] * p[other] * float(apart[_BAND_OF == band].sum())
    return score
