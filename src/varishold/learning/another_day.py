"""What is known of another day where one day was learned: forms.

Within a day a thing lies in the same place of a hand and is pressed as hard, and both help to name it. Tomorrow the
hand may sit elsewhere and press less: all things are strange then by where and how hard they are felt. So where no
sessions are known, whether a press is like anything known is judged by forms alone, on copies of held-out presses that
have drifted, lie elsewhere and are pressed less. And forms have a share of every answer: what lies where another thing
lay that day, and is pressed as hard, differs from it in nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from varishold.learning.sources import Learned
from varishold.trust import conformal_p_value, widened

__all__ = ["Judged", "judge"]

Floats = NDArray[np.float64]

# Of an answer forms have this share where all is felt as it was that day, and that one where it is not.
_FORMS_COUNT, _FORMS_COUNT_UNLIKE = 0.25, 0.5
# What is felt unlike the session is surely named only where more than this share of known presses have stranger forms.
_USUAL = 0.3
# Otherwise only where more than so many times the share of known presses that may be refused are stranger: of what is
# hardly less strange than what is refused, much is nothing known.
_RARE = 2.0


@dataclass(frozen=True, eq=False)
class Judged:
    """What was said of presses, and by what.

    Parameters
    ----------
    probabilities : ndarray of shape (n, n_classes), float64
        As if each were of one of the classes. None is above .9 where a press is hardly less strange than what is
        refused, or its form is asked and names another thing, or is felt as nothing was on the day that was learned
        and its form is none of the most usual ones either.
    p_values : ndarray of shape (n,), float64
        How rare it is that a press of something known is as strange.
    unlike : ndarray of shape (n,), bool
        Which are felt as nothing was in the one session that was learned, but for their form.
    scaled, forms : mapping of str to ndarray of shape (n, n_measures), float64
        Standardized measures of each source, and those of forms alone; empty where these are not asked.
    silent : ndarray of shape (n,), bool, optional
        Which bear next to nothing beside any that was learned, so that touch tells nothing of them.
    untimely : ndarray of shape (n,), bool, optional
        Which have times of another clock than those that were learned.
    """

    probabilities: Floats
    p_values: Floats
    unlike: NDArray[np.bool_]
    scaled: Mapping[str, Floats]
    forms: Mapping[str, Floats] = field(default_factory=dict)
    silent: NDArray[np.bool_] | None = None
    untimely: NDArray[np.bool_] | None = None


def judge(learned: Learned, measures: Mapping[str, Floats], forms: Mapping[str, Floats], error: float) -> Judged:
    """Judge presses.

    Parameters
    ----------
    learned : Learned
    measures, forms : mapping of str to ndarray of shape (n, n_measures), float64
        Of each source, and those of forms alone, where the model has learned these by themselves.
    error : float
        What has a p-value of at most this within the day that was learned is unlike it.
    """
    scaled = learned.scaled(measures)
    said, strangeness = learned.judge(scaled)
    p_values = conformal_p_value(strangeness, learned.known)
    if learned.forms is None:
        # What is refused promises less still, and by the caller.
        rare = (p_values > error) & (p_values <= _RARE * error)
        return Judged(_unsure(np.exp(said), rare, error), p_values, np.zeros(len(said), np.bool_), scaled)
    scaled_forms = learned.forms.scaled(forms)
    by_forms, strangeness = learned.forms.judge(scaled_forms)
    usual = conformal_p_value(strangeness, learned.forms.known)
    unlike = p_values <= error
    share = np.where(unlike, _FORMS_COUNT_UNLIKE, _FORMS_COUNT)
    named = _unsure(_pooled(np.exp(said), np.exp(by_forms), share), unlike & (usual <= _USUAL), error)
    return Judged(named, usual, unlike, scaled, scaled_forms)


def _unsure(named: Floats, which: NDArray[np.bool_], error: float) -> Floats:
    """Return answers of which some promise no more than what is just refused: none above .9."""
    bounded = widened(named, np.full(len(named), error), error)
    return np.where(which[:, None], bounded, named)


def _pooled(named: Floats, by_forms: Floats, share: Floats) -> Floats:
    """Return a mean of two answers, of which the second has a share, in the order of the first.

    One that names another thing counts as even.
    """
    agree = named.argmax(axis=1) == by_forms.argmax(axis=1)
    other = np.where(agree[:, None], by_forms, 1.0 / named.shape[1])
    return np.asarray(named + share[:, None] * (other - named))
