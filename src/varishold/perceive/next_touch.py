"""How much a touch is expected to tell about the object's name, and how soon it makes the name sure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require
from varishold.perceive.belief import Belief
from varishold.perceive.touch_model import squared_distances

__all__ = ["NextTouch", "expected_information", "time_until_sure"]

Floats = NDArray[np.float64]

# Outcomes that are imagined a touch, and particles that are weighed for each.
_OUTCOMES, _PARTICLES = 48, 500

# Particles where touches are looked at in pairs.
_PARTICLES_OF_PAIRS = 400

# What is in doubt after two touches takes so many usual touches more, and as many for each nat.
_MORE = 2.0


@dataclass(frozen=True)
class NextTouch:
    """The touch that is wanted next.

    Parameters
    ----------
    touch : str
    nats : float
        What it is expected to tell about the name.
    seconds : float or None
        What it takes a hand on the mean; None where nobody measured it.
    along_with : str or None
        The touch that is looked at together with it, where no touch alone tells enough; None elsewhere.
    """

    touch: str
    nats: float
    seconds: float | None = None
    along_with: str | None = None


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
    fails = np.exp(model.log_success(library.kind, failed=True)) if model.failed.any() else np.zeros(len(library))
    by_name = np.bincount(library.owner, weights=belief.particles, minlength=n_objects)
    failed = np.bincount(library.owner, weights=belief.particles * fails, minlength=n_objects)
    # Particles in which the touch was made stand for all of their object's that it succeeds in.
    weight = np.where(model.made, belief.particles, 0.0)
    made = np.bincount(library.owner, weights=weight, minlength=n_objects)
    weight = weight * ((by_name - failed) / np.maximum(made, 1e-300))[library.owner]
    likely, share, drawn, times = _imagined(weight, _PARTICLES)
    if not likely.size:
        return 0.0
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


def time_until_sure(belief: Belief, takes: Mapping[str, float], error: float) -> dict[str, tuple[float, str | None]]:
    """Return how long it is expected to take from each touch on until the name is sure, with two touches looked ahead.

    Examples hold all touches of one thing together, so that an example that is drawn says what two touches of it would
    feel like. The second touch is made where the first leaves the name in doubt.

    Parameters
    ----------
    belief : Belief
    takes : mapping of str to float
        What each touch takes: those that can be made next, all known to the library.
    error : float
        The name is sure from a probability of one less this.

    Returns
    -------
    dict of str to (float, str or None)
        For each touch: the time, in the unit of `takes`, and the touch after it for which it is least; None where it
        is the only one. Empty where no example that is believed knows all touches.
    """
    library, n_objects = belief.library, len(belief.library.objects)
    whole = np.logical_and.reduce([library.touches[touch].made for touch in takes])
    by_name = np.bincount(library.owner, weights=belief.particles, minlength=n_objects)
    weight = np.where(whole, belief.particles, 0.0)
    made = np.bincount(library.owner, weights=weight, minlength=n_objects)
    weight = weight * (by_name / np.maximum(made, 1e-300))[library.owner]
    likely, share, drawn, times = _imagined(weight, _PARTICLES_OF_PAIRS)
    if not likely.size:
        return {}
    often = times / times.sum()
    owner = library.owner[likely]
    member = (owner[:, None] == np.unique(owner)).astype(float)
    usual = float(np.mean([*takes.values()]))
    if len(takes) == 1:
        return {touch: (taken, None) for touch, taken in takes.items()}
    # How well every other example explains each imagined outcome of a touch; of two touches it is the product.
    explains = {}
    for touch in takes:
        model = library.touches[touch]
        white = model.white[likely]
        log_kernel = model.kernel(squared_distances(white[drawn], white), white.shape[1])
        log_kernel[np.arange(len(drawn)), drawn] = -np.inf
        top = log_kernel.max(axis=1, keepdims=True)
        explains[touch] = np.exp(log_kernel - np.where(np.isfinite(top), top, 0.0))
    # What a drawn particle's own name loses with it is given back to that name.
    prior = share @ member
    given_back = prior / np.maximum(prior - share[drawn][:, None] * member[drawn], 1e-300)
    told = share[:, None] * member

    def names_after(explained: Floats) -> Floats:
        """Probability of each name after each imagined outcome; as before it where no other example explains it."""
        felt = (explained @ told) * given_back
        total = felt.sum(axis=1, keepdims=True)
        out: Floats = np.where(total > 0, felt / np.maximum(total, 1e-300), prior)
        return out

    in_doubt = {
        touch: often * (names_after(explained).max(axis=1) < 1 - error) for touch, explained in explains.items()
    }
    out: dict[str, tuple[float, str | None]] = {}
    for one, other in combinations(takes, 2):
        after = names_after(explains[one] * explains[other])
        rest = np.where(after.max(axis=1) < 1 - error, _MORE * usual * (1 + _entropy(after)), 0.0)
        for first, second in ((one, other), (other, one)):
            time = takes[first] + float(in_doubt[first] @ (takes[second] + rest))
            if first not in out or time < out[first][0]:
                out[first] = time, second
    return out


def _imagined(weight: Floats, most: int) -> tuple[NDArray[np.intp], Floats, NDArray[np.intp], NDArray[np.intp]]:
    """Return the likeliest particles by number and their shares, which of them outcomes are imagined from, how often.

    Evenly spaced over the cumulated weights, so that the same belief always imagines the same outcomes.
    """
    likely = np.argsort(-weight, kind="stable")[:most]
    likely = likely[weight[likely] > 0]
    share = weight[likely] / weight[likely].sum() if likely.size else weight[likely]
    picks = np.searchsorted(np.cumsum(share), (np.arange(_OUTCOMES) + 0.5) / _OUTCOMES)
    drawn, times = np.unique(picks, return_counts=True)
    return likely, share, drawn, times


def _entropy(p: NDArray[Any]) -> Floats:
    out: Floats = -(p * np.log(np.maximum(p, 1e-300))).sum(axis=-1)
    return out
