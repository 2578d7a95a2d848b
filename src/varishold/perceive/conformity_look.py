"""Whether touches conform so badly together as those of an object seldom do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from varishold.perceive.conformity import Calibration
from varishold.perceive.library import REFUSED_AT
from varishold.perceive.seen import Look
from varishold.trust import conformal_p_value, least_error

__all__ = ["conformity_look"]

Floats = NDArray[np.float64]

# So many examples can refuse one known thing in as many as is usual; of fewer the strangest refuse more.
_ENOUGH = round(1 / REFUSED_AT[1]) - 1


def conformity_look(
    touches: Sequence[tuple[Calibration, float]], log_size: float | None, error: float, examples: int
) -> Look:
    """Ask by all touches together whether they are of an object.

    For each touch: the share of the object's own examples with a conformity no higher, for things of its size. Fisher's
    product of the shares is ranked among the same products of those examples, so that it may be that touches of one
    object conform badly together.

    Parameters
    ----------
    touches : sequence of (Calibration, float)
        For each touch, the conformity of the object's own examples, and that of what was felt.
    log_size : float or None
        Logarithm of the thing's size, where it is known.
    error : float
        The share of things of the object that may be called strange, where there are enough examples for it.
    examples : int
        How many the object has.
    """
    usual = np.array([own.of_examples(sized=log_size is not None) for own, _ in touches])
    surprisal = np.array([float(own.surprisal(score, log_size)) for own, score in touches])
    whole = _together(usual, surprisal, error, examples)
    if len(touches) < 2 or examples >= _ENOUGH:
        return whole
    # So few examples refuse one known thing in as many: what is strange must be so without its strangest touch.
    others = np.arange(len(touches)) != surprisal.argmax()
    return max(whole, _together(usual[others], surprisal[others], error, examples), key=lambda look: look.inside)


def _together(usual: Floats, surprisal: Floats, error: float, examples: int) -> Look:
    """Ask how rare it is that an example conforms as badly in some touches.

    `usual` is that of the examples, shape (n_touches, n), NaN where one was not made; `surprisal` that of the thing.
    """
    known = _of_all_touches(usual)
    if not known.size:
        return Look(1.0, least_error(error, examples))
    return Look(conformal_p_value([sum(surprisal.tolist()) - 1e-9], known).item(), least_error(error, known.size))


def _of_all_touches(surprisal: Floats) -> Floats:
    """Return the surprisal of all touches together, of examples that made them.

    Where they are too few, what made some of the touches counts too, as if the others had felt as usual as those.
    """
    if not len(surprisal):
        return np.array([])
    made = np.isfinite(surprisal)
    if made.all(axis=0).sum() >= _ENOUGH:
        return np.asarray(surprisal[:, made.all(axis=0)].sum(axis=0))
    return np.asarray(np.nanmean(surprisal[:, made.any(axis=0)], axis=0) * len(surprisal))
