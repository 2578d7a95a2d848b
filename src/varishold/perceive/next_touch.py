"""How much a touch is expected to tell about the object's name, and how soon it makes the name sure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from varishold.errors import require
from varishold.perceive.belief import Belief
from varishold.perceive.library import Library
from varishold.perceive.likelihood import mean_by_every_kind, squared_distances
from varishold.perceive.touch_model import TouchModel

__all__ = ["NextTouch", "expected_information", "time_until_sure"]

Floats = NDArray[np.float64]

# Outcomes that are imagined a touch, and particles that are weighed for each.
_OUTCOMES, _PARTICLES = 48, 500

# Particles where touches are looked at in pairs.
_PARTICLES_OF_PAIRS = 400

# Examples of a kind that say what it feels like on the whole.
_OF_A_KIND = 24

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
        Nats: entropy of the name now less its expected entropy afterwards; 0 of a touch that was felt whole where the
        object lies.

    Raises
    ------
    InputError
        If the library does not know such a touch.
    """
    library = belief.library
    known = ", ".join(library.touches)
    require(touch in library.touches, f"the library knows no touch {touch!r}; it knows {known}")
    made = belief.here.get(touch)
    # It errs again as it did; one that was felt in part may bring news, and is reckoned as a new one.
    if made is not None and made.whole:
        return 0.0
    model = library.touches[touch]
    n_objects = len(library.objects)
    fails = np.exp(model.log_success(library.kind, failed=True)) if model.failed.any() else np.zeros(len(library))
    by_name = np.bincount(library.owner, weights=belief.particles, minlength=n_objects)
    failed = np.bincount(library.owner, weights=belief.particles * fails, minlength=n_objects)
    # Examples that know the touch stand for all of their objects'.
    knowing = np.where(model.made, belief.particles, 0.0)
    of_knowing = np.bincount(library.owner, weights=knowing, minlength=n_objects)
    weight = knowing * ((by_name - failed) / np.maximum(of_knowing, 1e-300))[library.owner]
    imagined = _imagined(library, weight, _PARTICLES)
    if imagined is None:
        return 0.0
    after = imagined.names_after(imagined.explained(model))
    p_failed = float(failed.sum())
    left = p_failed * float(_entropy(failed / max(failed.sum(), 1e-300)))
    left += (1 - p_failed) * float(imagined.often @ _entropy(after))
    # So few outcomes can make it look as if a touch took knowledge away.
    return max(0.0, float(_entropy(by_name)) - left)


def time_until_sure(belief: Belief, takes: Mapping[str, float], error: float) -> dict[str, tuple[float, str | None]]:
    """Return how long it is expected to take from each touch on until the name is sure, with two touches looked ahead.

    Examples hold all touches of one thing together, so that an example that is drawn says what two touches of it would
    feel like, or that one of them fails. The second touch is made where the first leaves the name in doubt.

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
        is the only one. Empty where no example is believed.
    """
    library = belief.library
    imagined = _imagined(library, belief.particles, _PARTICLES_OF_PAIRS)
    if imagined is None:
        return {}
    usual = float(np.mean([*takes.values()]))
    if len(takes) == 1:
        return {touch: (taken, None) for touch, taken in takes.items()}
    # Of two touches it is the product.
    explains = {touch: imagined.weighed(library.touches[touch]) for touch in takes}
    in_doubt = {
        touch: imagined.often * (imagined.names_after(explained).max(axis=1) < 1 - error)
        for touch, explained in explains.items()
    }
    out: dict[str, tuple[float, str | None]] = {}
    for one, other in combinations(takes, 2):
        after = imagined.names_after(explains[one] * explains[other])
        rest = np.where(after.max(axis=1) < 1 - error, _MORE * usual * (1 + _entropy(after)), 0.0)
        for first, second in ((one, other), (other, one)):
            time = takes[first] + float(in_doubt[first] @ (takes[second] + rest))
            if first not in out or time < out[first][0]:
                out[first] = time, second
    return out


@dataclass(frozen=True, eq=False)
class _Imagined:
    """Particles that a touch may find, and the outcomes that are imagined of it: each is what one of them feels like.

    Parameters
    ----------
    kind : ndarray of shape (n_examples,), int
        The kind of each of the library's examples.
    rows : ndarray of shape (n,), int
        The particles, as `_thinned` leaves them.
    share : ndarray of shape (n,)
        Their probabilities, which sum to one.
    member : ndarray of shape (n, n_names)
        1 where a particle is of a name, else 0.
    drawn : ndarray of shape (n_outcomes,), int
        Which of them outcomes are imagined from.
    often : ndarray of shape (n_outcomes,)
        How often each comes, a share.
    """

    kind: NDArray[np.int64]
    rows: NDArray[np.intp]
    share: Floats
    member: Floats
    drawn: NDArray[np.intp]
    often: Floats

    def explained(self, model: TouchModel) -> Floats:
        """Return how well every particle explains each outcome, shape (n_outcomes, n); none explains its own."""
        return self._others(self._log_kernel(model, self.rows))

    def weighed(self, model: TouchModel) -> Floats:
        """As `explained`, as a belief will weigh them: no example counts for more than it may by itself.

        A particle that does not know the touch explains it as its kind does on the whole, and says that it fails.
        """
        drawn, kind = self.rows[self.drawn], self.kind[self.rows]
        some = _some_of_each_kind(model.made, self.kind)
        members = (self.kind[some] == np.arange(self.kind.max() + 1)[:, None]).astype(float)
        of_kinds = self._log_kernel(model, some)
        of_kinds[some == drawn[:, None]] = -np.inf
        means = mean_by_every_kind(of_kinds, members)
        log_kernel = np.where(model.made[self.rows], self._log_kernel(model, self.rows), means[:, kind])
        if model.own < 1:
            log_kernel = model.own * log_kernel + (means - mean_by_every_kind(model.own * of_kinds, members))[:, kind]
        log_kernel += model.log_success(self.kind, failed=False)[self.rows]
        log_kernel[~model.made[drawn]] = model.log_success(self.kind, failed=True)[self.rows]
        return self._others(log_kernel)

    def _log_kernel(self, model: TouchModel, rows: NDArray[np.intp]) -> Floats:
        white = model.white
        return model.kernel(squared_distances(white[self.rows[self.drawn]], white[rows]), white.shape[1])

    def _others(self, log_kernel: Floats) -> Floats:
        """Return likelihoods up to a factor for each outcome, without a particle's own."""
        log_kernel[np.arange(len(self.drawn)), self.drawn] = -np.inf
        top = log_kernel.max(axis=1, keepdims=True)
        return np.asarray(np.exp(log_kernel - np.where(np.isfinite(top), top, 0.0)))

    def names_after(self, explained: Floats) -> Floats:
        """Return the probability of each name after each outcome; as before it where no other particle explains it."""
        felt = (explained @ self._told) * self._given_back
        total = felt.sum(axis=1, keepdims=True)
        return np.where(total > 0, felt / np.maximum(total, 1e-300), self._prior)

    @cached_property
    def _told(self) -> Floats:
        return self.share[:, None] * self.member

    @cached_property
    def _prior(self) -> Floats:
        return np.asarray(self.share @ self.member)

    @cached_property
    def _given_back(self) -> Floats:
        """What a drawn particle's own name loses with it is given back to that name; shape (n_outcomes, n_names)."""
        others = np.ones((len(self.drawn), len(self.rows)))
        others[np.arange(len(self.drawn)), self.drawn] = 0.0
        # Not as what there is less its own: of what is nearly all nothing would be left but rounding.
        return np.asarray(self._prior / np.maximum(others @ self._told, 1e-300))


def _imagined(library: Library, weight: Floats, most: int) -> _Imagined | None:
    """Imagine outcomes among so many of the library's examples at most, by their weights; None where none has any.

    Outcomes are evenly spaced over the cumulated weights, so that the same belief always imagines the same ones.
    """
    rows, share = _thinned(weight, most)
    if not rows.size:
        return None
    picks = np.searchsorted(np.cumsum(share), (np.arange(_OUTCOMES) + 0.5) / _OUTCOMES)
    drawn, times = np.unique(picks, return_counts=True)
    owner = library.owner[rows]
    member = (owner[:, None] == np.unique(owner)).astype(float)
    return _Imagined(library.kind, rows, share, member, drawn, times / times.sum())


def _some_of_each_kind(known: NDArray[np.bool_], kind: NDArray[np.int64]) -> NDArray[np.intp]:
    """Return examples that are known, evenly spaced among those of each kind."""
    rows = np.flatnonzero(known)
    rows = rows[np.argsort(kind[rows], kind="stable")]
    counts = np.bincount(kind[rows])
    place = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    of = np.repeat(counts, counts)
    most = np.minimum(of, _OF_A_KIND)
    return np.asarray(rows[(place * most) // of != ((place - 1) * most) // of])


def _thinned(weight: Floats, most: int) -> tuple[NDArray[np.intp], Floats]:
    """Return at most so many particles by number, and their shares: heavy ones as they are, and some of the light ones.

    Each of the light ones stays with a chance in proportion to its weight, evenly spaced over their cumulated weights,
    and then stands for those around it; the sums over objects stay right where the heaviest alone would be of a few.

    References
    ----------
    P. Fearnhead and P. Clifford, "On-line inference for hidden Markov models via particle filters", Journal of the
    Royal Statistical Society B 65 (2003) 887-899.
    """
    rows = np.argsort(-weight, kind="stable")[: int(np.count_nonzero(weight))]
    share = weight[rows] / weight[rows].sum()
    if len(rows) <= most:
        return rows, share
    # What the others' places, one fewer with each heavy one, have each of the rest: none of the heavy ones is lighter.
    rest = 1 - np.concatenate([[0.0], np.cumsum(share[: most - 1])])
    each = rest / (most - np.arange(most))
    heavy = int(np.argmax(share[:most] <= each))
    light = heavy + np.argsort(rows[heavy:])
    at = np.searchsorted(np.cumsum(share[light]), each[heavy] * (np.arange(most - heavy) + 0.5))
    kept = light[np.unique(at[at < len(light)])]
    share = np.concatenate([share[:heavy], np.full(len(kept), each[heavy])])
    return rows[np.concatenate([np.arange(heavy), kept])], share / share.sum()


def _entropy(p: NDArray[Any]) -> Floats:
    out: Floats = -(p * np.log(np.maximum(p, 1e-300))).sum(axis=-1)
    return out
