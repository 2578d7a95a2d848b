"""How much a touch is expected to tell about the object's name."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require
from varishold.perceive.belief import Belief
from varishold.perceive.touch_model import squared_distances

__all__ = ["expected_information"]

Floats = NDArray[np.float64]

# Outcomes that are imagined a touch, and particles that are weighed for each.
_OUTCOMES, _PARTICLES = 48, 500


def expected_information(belief: Belief, touch: str) -> float:
    """Return how much a touch is expected to tell about the object's name.

    Outcomes are imagined by drawing particles from the belief: each says what the touch would feel like. The other
    particles are weighed by each outcome in turn; a particle never explains its own. That the touch fails is an outcome
    too.

    Parameters
    ----------
    belief : Belief
    touch : str
        A touch that the library knows.

    Returns
    -------
    float
        Nats: entropy of the name now less its expected entropy afterwards.

    Raises
    ------
    InputError
        If the library does not know such a touch.
    """
    library = belief.library
    known = ", ".join(library.touches)
    require(touch in library.touches, f"the library knows no touch {touch!r}; it knows {known}")
    model = library.touches[touch]
    n_objects = len(library.objects)
    fails = np.exp(model.log_success(library.owner, failed=True)) if model.failed.any() else np.zeros(len(library))
    by_name = np.bincount(library.owner, weights=belief.particles, minlength=n_objects)
    failed = np.bincount(library.owner, weights=belief.particles * fails, minlength=n_objects)
    # Particles in which the touch was made stand for all of their object's that it succeeds in.
    weight = np.where(model.made, belief.particles, 0.0)
    made = np.bincount(library.owner, weights=weight, minlength=n_objects)
    weight = weight * ((by_name - failed) / np.maximum(made, 1e-300))[library.owner]
    likely = np.argsort(-weight, kind="stable")[:_PARTICLES]
    likely = likely[weight[likely] > 0]
    if not likely.size:
        return 0.0
    share = weight[likely] / weight[likely].sum()
    # Evenly spaced over the cumulated weights, so that the same belief always imagines the same outcomes.
    picks = np.searchsorted(np.cumsum(share), (np.arange(_OUTCOMES) + 0.5) / _OUTCOMES)
    drawn, times = np.unique(picks, return_counts=True)
    white = model.white[likely]
    log_kernel = model.kernel(squared_distances(white[drawn], white), white.shape[1])
    log_kernel[np.arange(len(drawn)), drawn] = -np.inf
    owner = library.owner[likely]
    names = np.unique(owner)
    member = (owner[:, None] == names).astype(float)
    prior = share @ member
    # Where there is one particle alone, its name stays as likely as it was.
    after = np.tile(prior, (len(drawn), 1))
    for k, row in enumerate(log_kernel):
        top = row.max()
        if np.isfinite(top):
            rest = share.copy()
            rest[drawn[k]] = 0.0
            felt = (rest * np.exp(row - top)) @ member
            # What a drawn particle's own name loses with it is given back to that name.
            after[k] = felt * prior / np.maximum(rest @ member, 1e-300)
    after /= np.maximum(after.sum(axis=1, keepdims=True), 1e-300)
    p_failed = float(failed.sum())
    left = p_failed * float(_entropy(failed / max(failed.sum(), 1e-300)))
    left += (1 - p_failed) * float(times @ _entropy(after) / times.sum())
    # So few outcomes can make it look as if a touch took knowledge away.
    return max(0.0, float(_entropy(by_name)) - left)


def _entropy(p: NDArray[Any]) -> Floats:
    out: Floats = -(p * np.log(np.maximum(p, 1e-300))).sum(axis=-1)
    return out
