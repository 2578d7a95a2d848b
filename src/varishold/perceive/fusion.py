"""Late fusion: one belief from several sources, each of which names the object by itself.

A source is a classifier of its own features: the tactile one, that of the joint angles, that of the switches. Each
gives its log-probabilities, and the logarithmic opinion pool adds them, every source with a weight. A weight above 1
says that a source knows more than it claims, below 1 that it claims too much or repeats what another said.
Features are never joined, so a source may be missing, grasp by grasp, and nothing is trained again.

References
----------
Genest and Zidek, Combining probability distributions, Statistical Science 1 (1986) 114-135: the logarithmic pool.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError

__all__ = ["LAPSE", "checked_truth", "choose_weights", "fuse", "log_loss"]

Floats = NDArray[np.float64]

#: Share of the answers of a source that are taken to be about nothing: its probabilities are mixed with so much of
#: an even spread, so that no source alone can rule out an object.
LAPSE = 0.01
# No source counts more than this many times.
_LARGEST_WEIGHT = 5.0


def fuse(
    log_probabilities: Mapping[str, ArrayLike | None],
    weights: Mapping[str, float] | None = None,
    *,
    lapse: float = LAPSE,
    log_prior: ArrayLike | None = None,
) -> Floats:
    """Combine what several sources say about the same objects.

    Parameters
    ----------
    log_probabilities : mapping of str to array_like of shape (n, k) or None
        Of each source, the log-probability of each of k objects for n grasps; -inf is allowed, and each row may lack
        a constant. A row of NaN: this source has nothing to say about this grasp. None: about none.
    weights : mapping of str to float, optional
        How much each source counts, at least 0. Default: 1 each. Sources that are not there may have weights too.
    lapse : float, default 0.01
        Share of each source's answers that are about nothing, from 0 to below 1. With 0 one source can rule an
        object out; where sources rule out every object together, the answer is the prior.
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
    >>> np.exp(fuse({"tactile": tactile, "angles": angles}, lapse=0)).round(3).tolist()
    [[0.6, 0.4], [0.2, 0.8]]
    """
    sources = _checked_sources(log_probabilities)
    if not 0 <= lapse < 1:
        raise InputError(f"lapse must be a share from 0 to below 1, got {lapse!r}")
    n, k = next(iter(sources.values())).shape
    prior = _checked_prior(log_prior, k)
    total = np.tile(prior, (n, 1))
    for name, source in sources.items():
        weight = _weight_of(name, weights)
        # A source that does not count cannot rule out anything either, and 0 times infinity is no number.
        if weight > 0:
            total += weight * _evidence(source, prior, lapse)
    ruled_out = np.isneginf(total).all(axis=1)
    total[ruled_out] = prior
    return total - _log_sum(total)


def choose_weights(
    log_probabilities: Mapping[str, ArrayLike | None],
    truth: ArrayLike,
    *,
    lapse: float = LAPSE,
    log_prior: ArrayLike | None = None,
) -> dict[str, float]:
    """Choose how much each source counts: the weights of least log loss.

    The log-probabilities must be of grasps that the sources were not trained on, as `held_out_log_probabilities`
    gives them inside the training grasps: a source that has seen the answer would get all the weight. The loss is
    convex in the weights, so there is one answer.

    Parameters
    ----------
    log_probabilities : mapping of str to array_like of shape (n, k) or None
        As in `fuse`. A source that is None for all grasps gets weight 1: nothing is known about it.
    truth : array_like of shape (n,), integer
        Number of the object (column) that each grasp is of.
    lapse, log_prior
        As in `fuse`; lapse must be above 0.

    Returns
    -------
    dict of str to float
        From 0 to 5.

    Raises
    ------
    InputError
        As `fuse`, and if `truth` does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> truth = np.arange(100) % 2
    >>> sure = np.log(np.where(np.arange(2) == truth[:, None], 0.9, 0.1))
    >>> guess = np.log(np.where(np.arange(2) == truth[::-1, None] * (truth[:, None] > 2), 0.7, 0.3))
    >>> weights = choose_weights({"sure": sure, "guess": guess}, truth)
    >>> weights["sure"] > 1 > weights["guess"]
    True
    """
    from scipy.optimize import minimize

    sources = _checked_sources(log_probabilities)
    if not 0 < lapse < 1:
        raise InputError(f"lapse must be above 0 and below 1 to choose weights, got {lapse!r}")
    n, k = next(iter(sources.values())).shape
    numbers = checked_truth(truth, n, k)
    prior = _checked_prior(log_prior, k)
    names = [name for name, source in sources.items() if not np.isnan(source).all()]
    evidence = np.stack([_evidence(sources[name], prior, lapse) for name in names]) if names else np.empty((0, n, k))
    rows = np.arange(n)
    of_truth = evidence[:, rows, numbers]

    def loss(weight: Floats) -> tuple[float, Floats]:
        total = prior + np.tensordot(weight, evidence, axes=1)
        total -= _log_sum(total)
        expected = np.einsum("nk,snk->sn", np.exp(total), evidence)
        return -float(total[rows, numbers].mean()), (expected - of_truth).mean(axis=1)

    chosen = dict.fromkeys(log_probabilities, 1.0)
    if names and n:
        found = minimize(
            loss, np.ones(len(names)), jac=True, method="L-BFGS-B", bounds=[(0, _LARGEST_WEIGHT)] * len(names)
        )
        chosen |= {name: float(weight) for name, weight in zip(names, found.x, strict=True)}
    return chosen


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


def _evidence(source: Floats, prior: Floats, lapse: float) -> Floats:
    """Return log P / prior of each object, 0 in the rows without this source."""
    missing: NDArray[np.bool_] = np.isnan(source).any(axis=1)
    # A source that gives every object no chance says as little as one that is silent.
    silent = np.asarray(missing | np.isneginf(source).all(axis=1))
    kept = np.where(silent[:, None], 0.0, source)
    kept = kept - _log_sum(kept)
    if lapse > 0:
        kept = np.logaddexp(np.log1p(-lapse) + kept, np.log(lapse) - np.log(source.shape[1]))
    # An object without prior stays so whatever is said.
    return np.where(silent[:, None], 0.0, kept - np.where(np.isneginf(prior), 0.0, prior))


def _log_sum(rows: Floats) -> Floats:
    top = rows.max(axis=1, keepdims=True)
    return np.asarray(top + np.log(np.exp(rows - top).sum(axis=1, keepdims=True)))


def _checked_sources(given: Mapping[str, ArrayLike | None]) -> dict[str, Floats]:
    sources: dict[str, Floats] = {}
    for name, values in given.items():
        if values is None:
            continue
        try:
            array = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"log-probabilities of {name!r} must be one array of numbers") from error
        if array.ndim != 2 or array.shape[1] == 0:
            raise InputError(f"log-probabilities of {name!r} must have shape (n, k), got {array.shape}")
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
    if not sources:
        raise InputError("fusion needs at least one source, got none")
    shapes = {name: array.shape for name, array in sources.items()}
    if len(set(shapes.values())) > 1:
        said = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(f"sources must have the same grasps and objects, got {said}")
    return sources


def _row(wrong: NDArray[np.bool_]) -> int:
    return int(np.argmax(wrong.any(axis=1)))


def _weight_of(name: str, weights: Mapping[str, float] | None) -> float:
    if weights is None:
        return 1.0
    if name not in weights:
        raise InputError(
            f"no weight for source {name!r}; weights are there for {', '.join(map(repr, weights)) or 'none'}"
        )
    weight = float(weights[name])
    if not 0 <= weight < np.inf:
        raise InputError(f"weight of source {name!r} must be finite and not negative, got {weights[name]!r}")
    return weight


def _checked_prior(log_prior: ArrayLike | None, k: int) -> Floats:
    if log_prior is None:
        return np.full(k, -np.log(k))
    prior = np.asarray(log_prior, dtype=np.float64)
    if prior.shape != (k,):
        raise InputError(f"log_prior must have shape ({k},), got {prior.shape}")
    if np.isnan(prior).any() or np.isposinf(prior).any() or np.isneginf(prior).all():
        raise InputError("log_prior must be log-probabilities, some of them above -inf")
    return np.asarray(prior - _log_sum(prior[None])[0])


def checked_truth(truth: ArrayLike, n: int, k: int) -> NDArray[np.intp]:
    """Return the number of the object of each of n grasps, from 0 to below k.

    Raises
    ------
    InputError
        If it is anything else.
    """
    numbers = np.asarray(truth)
    if numbers.shape != (n,) or numbers.dtype.kind not in "iu":
        raise InputError(
            f"truth must be one whole number a grasp, shape ({n},), got {numbers.dtype} of {numbers.shape}"
        )
    wrong = np.asarray((numbers < 0) | (numbers >= k))
    if wrong.any():
        raise InputError(
            f"truth must be from 0 to {k - 1}, got {int(numbers[np.argmax(wrong)])} for grasp {int(np.argmax(wrong))}"
        )
    return numbers.astype(np.intp)
