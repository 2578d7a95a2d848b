"""Decoders: from the signs of many hyperplanes to a score a class, linear in the signs; one function each.

`DECODERS` is the registry; `choose_decoder` takes the one that answers best in a cross-validation on the
training grasps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from varishold.grasp.comparison import clearly_best, deal_folds
from varishold.grasp.estimator import few_of_each_class

__all__ = [
    "DECODERS",
    "DEFAULT_DECODER",
    "Weights",
    "choose_decoder",
    "least_squares",
    "nearest_code",
    "one_against_one",
]

#: Slopes (n_classes, n_hyperplanes) on signs -1 and 1, and offsets (n_classes,).
Weights = tuple[NDArray[np.float64], NDArray[np.float64]]
Decoder = Callable[[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64], int], Weights]

#: Taken unless another decoder is clearly better: ten grasps a class cannot tell apart what is nearly alike.
DEFAULT_DECODER = "least squares, ridge 0.1"
#: Patterns up to which every fold of five is tried; above, one fold of a quarter.
_FIVE_FOLDS = 600
#: Patterns that take part in choosing the decoder, and patterns times hyperplanes above which the one-against-one
#: machines are left out: they would take most of the time of a fit.
_CHOOSING, _MACHINES = 4000, 2_000_000
#: Classes above which they are left out too: there is one for every two classes.
_MACHINE_CLASSES = 50


def nearest_code(
    signs: NDArray[np.float64], labels: NDArray[np.int64], weights: NDArray[np.int64], n_classes: int
) -> Weights:
    """Hamming distance to each class's code: on each hyperplane the side on which most of its grasps lie."""
    slopes = np.zeros((n_classes, signs.shape[1]))
    for k in range(n_classes):
        own = labels == k
        if own.any():
            slopes[k] = np.sign((signs[own] * weights[own, None]).sum(axis=0))
    absent = np.bincount(labels, minlength=n_classes) == 0
    return slopes, np.where(absent, -2.0 * signs.shape[1], 0.0)


def least_squares(
    signs: NDArray[np.float64],
    labels: NDArray[np.int64],
    weights: NDArray[np.int64],
    n_classes: int,
    *,
    ridge: float,
) -> Weights:
    """Ridge regression of class membership on the signs, all classes weighing the same."""
    n, m = signs.shape
    counts = np.bincount(labels, weights=weights, minlength=n_classes)
    sample = weights / counts[labels]
    sample = sample * (n / sample.sum())
    targets = np.where(labels[:, None] == np.arange(n_classes), 1.0, -1.0)
    centre = sample @ signs / n
    level = sample @ targets / n
    root = np.sqrt(sample)[:, None]
    a, b = root * (signs - centre), root * (targets - level)
    penalty = ridge * m
    if n <= m:
        slopes = np.linalg.solve(a @ a.T + penalty * np.eye(n), b).T @ a
    else:
        slopes = np.linalg.solve(a.T @ a + penalty * np.eye(m), a.T @ b).T
    return slopes, level - slopes @ centre


def one_against_one(
    signs: NDArray[np.float64],
    labels: NDArray[np.int64],
    weights: NDArray[np.int64],
    n_classes: int,
    *,
    cost: float,
) -> Weights:
    """Support vector machines between every two classes; a class's score is the sum of its margins."""
    from sklearn.svm import SVC

    m = signs.shape[1]
    present = np.unique(labels)
    machine = SVC(kernel="linear", C=cost, class_weight="balanced", cache_size=400)
    with few_of_each_class():
        machine.fit(signs / np.sqrt(m), labels, sample_weight=weights)
    slopes, offsets = np.zeros((n_classes, m)), np.zeros(n_classes)
    absent = np.bincount(labels, minlength=n_classes) == 0
    if len(present) == 2:
        slopes[present[1]], offsets[present[1]] = machine.coef_[0] / np.sqrt(m), machine.intercept_[0]
    else:
        pairs = [(a, b) for k, a in enumerate(present) for b in present[k + 1 :]]
        for (a, b), coefficient, intercept in zip(pairs, machine.coef_, machine.intercept_, strict=True):
            slopes[a] += coefficient / np.sqrt(m)
            slopes[b] -= coefficient / np.sqrt(m)
            offsets[a] += intercept
            offsets[b] -= intercept
    reach = np.abs(slopes).sum(axis=1).max() + np.abs(offsets).max()
    return slopes, np.where(absent, -2.0 * reach, offsets)


DECODERS: Mapping[str, Decoder] = {
    "nearest code": nearest_code,
    "least squares, ridge 1": partial(least_squares, ridge=1.0),
    "least squares, ridge 0.1": partial(least_squares, ridge=0.1),
    "least squares, ridge 0.01": partial(least_squares, ridge=0.01),
    "one against one, cost 1": partial(one_against_one, cost=1.0),
    "one against one, cost 10": partial(one_against_one, cost=10.0),
}


def choose_decoder(
    signs: NDArray[np.float64],
    labels: NDArray[np.int64],
    weights: NDArray[np.int64],
    groups: NDArray[np.int64],
    n_classes: int,
    rng: np.random.Generator,
) -> str:
    """Return the name of the decoder that answers held-out patterns best, all classes weighing the same."""
    if len(labels) > _CHOOSING:
        some = rng.choice(len(labels), _CHOOSING, replace=False)
        signs, labels, weights, groups = signs[some], labels[some], weights[some], groups[some]
    folds = 5 if len(labels) <= _FIVE_FOLDS else 1
    fold_of = deal_folds(labels, groups, 5 if folds == 5 else 4, rng)
    counts = np.bincount(labels, minlength=n_classes)
    slow = signs.size > _MACHINES or n_classes > _MACHINE_CLASSES
    tried = [name for name in DECODERS if not (slow and name.startswith("one against one"))]
    held_out = np.zeros(len(labels), dtype=np.bool_)
    right = np.zeros((len(tried), len(labels)))
    for fold in range(folds):
        held = fold_of == fold
        if not held.any() or len(np.unique(labels[~held])) < 2:
            continue
        held_out |= held
        for k, name in enumerate(tried):
            slopes, offsets = DECODERS[name](signs[~held], labels[~held], weights[~held], n_classes)
            answers = (signs[held] @ slopes.T + offsets).argmax(axis=1)
            right[k, held] = (answers == labels[held]) / counts[labels[held]]
    return tried[clearly_best(right[:, held_out], tried.index(DEFAULT_DECODER))]
