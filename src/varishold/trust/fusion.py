"""Late fusion: one belief from several sources, each of which names the object by itself.

A source is a classifier of its own features: the tactile one, that of the joint angles, that of the switches. Each
gives its log-probabilities. They are calibrated and then multiplied: a source's probabilities are raised to its weight
(above 1 it knows more than it claims, below 1 it claims too much or repeats what another said) and mixed with a share
of the prior, its mixing weight, which bounds how strongly it can ever contradict the others. Features are never joined,
so a source may be missing, grasp by grasp, and nothing is trained again.

References
----------
Genest and Zidek, Combining probability distributions, Statistical Science 1 (1986) 114-135: the logarithmic pool.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError, require
from varishold.frame.checks import as_array, as_given, is_number

__all__ = ["MIXING", "SourceWeights", "checked_truth", "choose_weights", "fuse", "log_loss"]

Floats = NDArray[np.float64]

#: The mixing weight of a source of which nothing else is known.
MIXING = 0.01
_LARGEST_WEIGHT = 5.0
_LEAST_MIXING, _LARGEST_MIXING = 0.001, 0.9
# The loss has more than one hollow: modest and bold sources, each with small and with large mixing weights.
_STARTS = ((1.0, 0.01), (2.0, 0.3))
# A probability that a source gives as 0 stands for this many nats below its largest, so that a weight can act on it.
_LEAST_LOG = -30.0


@dataclass(frozen=True)
class SourceWeights:
    """How far each source is to be trusted.

    Parameters
    ----------
    weights : mapping of str to float
        The power of each source's probabilities, at least 0.
    mixing : mapping of str to float
        The share of each source's answers that are about nothing, from 0 to below 1.

    Raises
    ------
    InputError
        If a weight or a mixing weight is out of range, or they are not of the same sources.
    """

    weights: Mapping[str, float]
    mixing: Mapping[str, float]

    def __post_init__(self) -> None:
        for kind in ("weights", "mixing"):
            got = type(getattr(self, kind)).__name__
            require(isinstance(getattr(self, kind), Mapping), f"{kind} must be given by the sources' names, got {got}")
        same = set(self.weights) == set(self.mixing)
        require(same, f"weights are of the sources {sorted(self.weights)}, mixing of {sorted(self.mixing)}")
        for name in self.weights:
            _checked("weight", name, self.weights[name])
            _checked("mixing weight", name, self.mixing[name], below=1.0)
        for kind in ("weights", "mixing"):
            object.__setattr__(self, kind, MappingProxyType({k: float(v) for k, v in getattr(self, kind).items()}))

    def __reduce__(self) -> tuple[Any, ...]:
        return SourceWeights, (dict(self.weights), dict(self.mixing))


def fuse(
    log_probabilities: Mapping[str, ArrayLike | None],
    weights: SourceWeights | Mapping[str, float] | None = None,
    *,
    mixing: float = MIXING,
    log_prior: ArrayLike | None = None,
) -> Floats:
    """Combine what several sources say about the same objects.

    Parameters
    ----------
    log_probabilities : mapping of str to array_like of shape (n, k) or None
        Of each source, the log-probability of each of k objects for n grasps; -inf is allowed, and each row may lack
        a constant. A row of NaN: this source has nothing to say about this grasp. None: about none.
    weights : SourceWeights or mapping of str to float, optional
        How much each source counts, at least 0. Default: 1 each. Sources that are not there may have weights too.
    mixing : float, default 0.01
        Share of each source's answers that are about nothing, from 0 to below 1; not used where `weights` holds each
        source's own. With 0 one source can rule an object out; where they rule out all, the answer is the prior.
    log_prior : array_like of shape (k,), optional
        Log-probability of each object before any source spoke, as in what every source was trained on. Default: even.

    Returns
    -------
    ndarray of shape (n, k), float64
        Log-probabilities; each row's probabilities sum to 1. A grasp of which no source says anything has the prior.

    Raises
    ------
    InputError
        If there is no source, shapes differ, a value is no log-probability, or a weight is missing or negative.

    Examples
    --------
    >>> import numpy as np
    >>> tactile = np.log([[0.6, 0.4], [0.5, 0.5]])
    >>> angles = [[np.nan, np.nan], np.log([0.2, 0.8])]
    >>> np.exp(fuse({"tactile": tactile, "angles": angles}, mixing=0)).round(3).tolist()
    [[0.6, 0.4], [0.2, 0.8]]
    """
    sources = _checked_sources(log_probabilities)
    _checked("mixing weight", "", mixing, below=1.0)
    n, k = next(iter(sources.values())).shape
    prior = _checked_prior(log_prior, k)
    total = np.tile(prior, (n, 1))
    for name, source in sources.items():
        weight, share = _trust(name, weights, mixing)
        spoken = _spoken(source)
        if weight > 0 and spoken.any():
            # A source that is mixed with the prior may rule nothing out; an unmixed one may.
            log = _floored(source[spoken]) if share > 0 else source[spoken]
            said = _tempered(log, weight, prior)
            if share > 0:
                said = np.logaddexp(np.log1p(-share) + said, np.log(share) + prior)
            total[spoken] += said - _finite(prior)
    total[np.isneginf(total).all(axis=1)] = prior
    return total - _log_sum(total)


def choose_weights(
    log_probabilities: Mapping[str, ArrayLike | None],
    truth: ArrayLike,
    *,
    log_prior: ArrayLike | None = None,
    counts: ArrayLike | None = None,
) -> SourceWeights:
    """Choose how far each source is to be trusted: the weights and mixing weights of least log loss when all are fused.

    The log-probabilities must be of grasps that the sources were not trained on, as `held_out_log_probabilities`
    gives them inside the training grasps: a source that has seen the answer would get all the weight.

    Parameters
    ----------
    log_probabilities : mapping of str to array_like of shape (n, k) or None
        As in `fuse`. A source that says nothing about any grasp gets weight 1: nothing is known about it.
    truth : array_like of shape (n,), integer
        Number of the object (column) that each grasp is of.
    log_prior : array_like of shape (k,), optional
        As in `fuse`.
    counts : array_like of shape (n,), optional
        How much each grasp counts, above 0. Default: all alike.

    Returns
    -------
    SourceWeights
        Weights from 0 to 5, mixing weights from .001 to .9.

    Raises
    ------
    InputError
        As `fuse`, and if `truth` or `counts` does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> truth = np.arange(100) % 2
    >>> modest = np.log(np.where(np.arange(2) == truth[:, None], 0.7, 0.3))
    >>> guess = np.log(np.where(np.arange(2) == (np.arange(100) // 2 % 2)[:, None], 0.7, 0.3))
    >>> chosen = choose_weights({"modest": modest, "guess": guess}, truth)
    >>> chosen.weights["modest"] > 1 > chosen.weights["guess"]
    True
    """
    from scipy.optimize import minimize

    sources = _checked_sources(log_probabilities)
    n, k = next(iter(sources.values())).shape
    numbers, prior = checked_truth(truth, n, k), _checked_prior(log_prior, k)
    names = [name for name, source in sources.items() if _spoken(source).any()]
    weights, mixing = dict.fromkeys(log_probabilities, 1.0), dict.fromkeys(log_probabilities, MIXING)
    if names:
        loss = _Loss([sources[name] for name in names], numbers, prior, counts)
        bounds = [(0.0, _LARGEST_WEIGHT)] * len(names) + [(_LEAST_MIXING, _LARGEST_MIXING)] * len(names)
        found = [
            minimize(loss, np.repeat(start, len(names)), jac=True, method="L-BFGS-B", bounds=bounds)
            for start in _STARTS
        ]
        best = min(found, key=lambda one: float(one.fun)).x
        weights |= {name: float(value) for name, value in zip(names, best[: len(names)], strict=True)}
        mixing |= {name: float(value) for name, value in zip(names, best[len(names) :], strict=True)}
    return SourceWeights(weights, mixing)


class _Loss:
    """Log loss of the fused sources and its gradient, as a function of their weights and then their mixing weights."""

    def __init__(
        self, sources: list[Floats], truth: NDArray[np.intp], prior: Floats, counts: ArrayLike | None = None
    ) -> None:
        self._sources = [(_floored(source[_spoken(source)]), _spoken(source)) for source in sources]
        self._truth, self._prior, self._shares = truth, prior, _checked_counts(counts, len(truth))

    def __call__(self, trust: Floats) -> tuple[float, Floats]:
        n, prior = len(self._truth), self._prior
        total = np.tile(prior, (n, 1))
        slopes = []
        for (source, spoken), weight, mixing in zip(self._sources, *np.split(trust, 2), strict=True):
            log = source - _finite(prior)
            p = np.exp(_tempered(source, weight, prior))
            mixed = np.maximum((1 - mixing) * p + mixing * np.exp(prior), 1e-300)
            total[spoken] += np.where(np.isneginf(prior), 0.0, np.log(mixed) - _finite(prior))
            by_weight = (1 - mixing) * p * (log - (p * log).sum(axis=1, keepdims=True)) / mixed
            slopes.append((spoken, by_weight, (np.exp(prior) - p) / mixed))
        total -= _log_sum(total)
        rows = np.arange(n)
        pull = np.exp(total)
        pull[rows, self._truth] -= 1
        pull *= self._shares[:, None]
        gradient = [float((pull[spoken] * slope).sum()) for spoken, slope, _ in slopes]
        gradient += [float((pull[spoken] * slope).sum()) for spoken, _, slope in slopes]
        return -float(self._shares @ np.maximum(total[rows, self._truth], -1e3)), np.array(gradient)


def log_loss(log_probabilities: ArrayLike, truth: ArrayLike) -> float:
    """Return the mean of -log P(true object), in nats.

    Examples
    --------
    >>> import numpy as np
    >>> round(log_loss(np.log([[0.5, 0.5], [0.1, 0.9]]), [0, 1]), 4)
    0.3993
    """
    source = _checked_sources({"log_probabilities": log_probabilities})["log_probabilities"]
    if not len(source):
        raise InputError("log loss of no grasp is not defined")
    return -float(source[np.arange(len(source)), checked_truth(truth, *source.shape)].mean())


def _spoken(source: Floats) -> NDArray[np.bool_]:
    """Return the rows in which a source says something: one that gives every object no chance says nothing."""
    return np.asarray(source.max(axis=1, initial=-np.inf) > -np.inf)


def _floored(source: Floats) -> Floats:
    return np.asarray(np.maximum(source - source.max(axis=1, keepdims=True), _LEAST_LOG))


def _tempered(source: Floats, weight: float, prior: Floats) -> Floats:
    """Return log P of each object by this source alone, what it adds to the prior raised to its weight."""
    said = prior + weight * (source - source.max(axis=1, keepdims=True) - _finite(prior))
    top = said.max(axis=1, keepdims=True)
    # Where all that the prior allows is ruled out, nothing remains to share.
    return np.asarray(said - np.where(np.isneginf(top), 0.0, _log_sum(np.where(np.isneginf(top), 0.0, said))))


def _finite(prior: Floats) -> Floats:
    return np.where(np.isneginf(prior), 0.0, prior)


def _log_sum(rows: Floats) -> Floats:
    top = rows.max(axis=1, keepdims=True)
    return np.asarray(top + np.log(np.exp(rows - top).sum(axis=1, keepdims=True)))


def _checked_sources(given: Mapping[str, ArrayLike | None]) -> dict[str, Floats]:
    sources: dict[str, Floats] = {}
    got = type(given).__name__
    require(isinstance(given, Mapping), f"sources must be log-probabilities by name, got {got}")
    for name, values in given.items():
        if values is None:
            continue
        try:
            array = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"log-probabilities of {name!r} must be one array of numbers") from error
        table = array.ndim == 2 and array.shape[1] > 0
        require(table, f"log-probabilities of {name!r} must have shape (n, k), got {array.shape}")
        if np.isposinf(array).any():
            raise InputError(
                f"log-probabilities of {name!r} must be below infinity, got inf in row {_row(np.isposinf(array))}"
            )
        some = np.asarray(np.isnan(array).any(axis=1) & ~np.isnan(array).all(axis=1))
        if some.any():
            raise InputError(
                f"log-probabilities of {name!r}: row {int(np.argmax(some))} is NaN in part; all of it or none"
            )
        sources[name] = array
    require(sources, "fusion needs at least one source, got none")
    shapes = {name: array.shape for name, array in sources.items()}
    if len(set(shapes.values())) > 1:
        said = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(f"sources must have the same grasps and objects, got {said}")
    return sources


def _row(wrong: NDArray[np.bool_]) -> int:
    return int(np.argmax(wrong.any(axis=1)))


def _trust(name: str, given: SourceWeights | Mapping[str, float] | None, mixing: float) -> tuple[float, float]:
    if given is None:
        return 1.0, mixing
    weights = given.weights if isinstance(given, SourceWeights) else given
    got = type(weights).__name__
    require(isinstance(weights, Mapping), f"weights must be SourceWeights or given by the sources' names, got {got}")
    if name not in weights:
        there = ", ".join(map(repr, weights)) or "none"
        raise InputError(f"no weight for source {name!r}; there are weights for {there}")
    _checked("weight", name, weights[name])
    return float(weights[name]), given.mixing[name] if isinstance(given, SourceWeights) else mixing


def _checked(what: str, name: str, value: object, *, below: float = np.inf) -> None:
    if not is_number(value) or not 0 <= value < below:  # type: ignore[operator]
        of = f" of source {name!r}" if name else ""
        raise InputError(f"{what}{of} must be a number from 0 to below {below:g}, got {value!r}")


def _checked_prior(log_prior: ArrayLike | None, k: int) -> Floats:
    if log_prior is None:
        return np.full(k, -np.log(k))
    prior = as_array(log_prior)
    require(prior.shape == (k,), f"log_prior must have shape ({k},), got {prior.shape}")
    allowed = (prior < np.inf).all() and not np.isneginf(prior).all()
    require(allowed, "log_prior must be log-probabilities, some of them above -inf")
    return np.asarray(prior - _log_sum(prior[None])[0])


def _checked_counts(counts: ArrayLike | None, n: int) -> Floats:
    """Return the share of the whole that each grasp counts for."""
    if counts is None:
        return np.full(n, 1.0 / n)
    given = as_array(counts)
    fit = given.shape == (n,) and bool(np.isfinite(given).all() and (given > 0).all())
    require(fit, f"counts must be one number above 0 a grasp, shape ({n},), got shape {given.shape}")
    return np.asarray(given / given.sum())


def checked_truth(truth: ArrayLike, n: int, k: int) -> NDArray[np.intp]:
    """Return the number of the object of each of n grasps, from 0 to below k.

    Raises
    ------
    InputError
        If it is anything else.
    """
    numbers = as_given(truth, f"truth must be one whole number a grasp, shape ({n},)")
    require(
        numbers.shape == (n,) and numbers.dtype.kind in "iu",
        f"truth must be one whole number a grasp, shape ({n},), got {numbers.dtype} of {numbers.shape}",
    )
    wrong = np.asarray((numbers < 0) | (numbers >= k))
    if wrong.any():
        raise InputError(
            f"truth must be from 0 to {k - 1}, got {int(numbers[np.argmax(wrong)])} for grasp {int(np.argmax(wrong))}"
        )
    return numbers.astype(np.intp)
