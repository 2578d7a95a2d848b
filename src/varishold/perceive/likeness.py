"""How like a new thing is to what a library knows already."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from varishold.perceive.evidence import Evidence
from varishold.perceive.library import NONE_OF_THESE, Library
from varishold.perceive.perceiver import Perceiver

__all__ = ["taken_for"]

# A name that is given with so much is sure.
_SURE = 0.9


def taken_for(library: Library, examples: Sequence[Sequence[Evidence]]) -> dict[str, int]:
    """Count how often a library surely takes a thing that it does not know for one of its objects.

    Parameters
    ----------
    library : Library
        Without the thing.
    examples : sequence of sequence of Evidence
        As `Library.with_object` takes them; the touches of each are felt in turn until its name is sure.

    Returns
    -------
    dict of str to int
        Examples by the object that they are taken for, the most first; without those of which nothing is sure.
    """
    found: Counter[str] = Counter()
    for example in examples:
        perceiver = Perceiver(library)
        for evidence in example:
            if evidence.failed or perceiver.stopped or evidence.touch not in library.touches:
                continue
            perceiver.feel(evidence)
        if perceiver.stopped:
            answer = perceiver.answer()
            if answer.object != NONE_OF_THESE and max(answer.trace[-1].probability.values()) > _SURE:
                found[answer.object] += 1
    return dict(found.most_common())
