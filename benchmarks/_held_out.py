"""What a source says about grasps that it has not seen, so that its weight beside others can be chosen."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from varishold.errors import InputError
from varishold.trust.fusion import checked_truth

__all__ = ["held_out_log_probabilities", "training_folds"]

Floats = NDArray[np.float64]


def training_folds(truth: ArrayLike, folds: int = 5) -> NDArray[np.intp]:
    """Deal the grasps of each object into folds of neighbours in time.

    Grasps that follow each other are alike; where neighbours stand on both sides, a source looks better than it is.

    Parameters
    ----------
    truth : array_like of shape (n,)
        The object of each grasp, in the order of recording.
    folds : int, default 5
        Number of folds, at least 2.

    Returns
    -------
    ndarray of shape (n,), int
        The fold of each grasp.

    Examples
    --------
    >>> training_folds(["a", "a", "b", "a", "b", "a"], 2).tolist()
    [0, 0, 0, 1, 1, 1]
    """
    if isinstance(folds, bool) or not isinstance(folds, (int, np.integer)) or folds < 2:
        raise InputError(f"folds must be a whole number, at least 2, got {folds!r}")
    names = np.asarray(truth)
    if names.ndim != 1:
        raise InputError(f"truth must be one object a grasp, got shape {names.shape}")
    fold = np.zeros(len(names), dtype=np.intp)
    for name in np.unique(names):
        of = np.flatnonzero(names == name)
        fold[of] = np.arange(len(of)) * folds // len(of)
    return fold


def held_out_log_probabilities(
    classifier: Any, X: ArrayLike, truth: ArrayLike, *, n_objects: int | None = None, fold: ArrayLike | None = None
) -> Floats:
    """Return what a source says about each training grasp when it has not seen it.

    Parameters
    ----------
    classifier : object with fit(X, y), predict_proba(X) and classes_
        Not fitted here: each fold fits a copy.
    X : array_like of shape (n, n_features)
        The source's features of the training grasps. A row of NaN is a grasp without this source.
    truth : array_like of shape (n,), integer
        Number of the object of each grasp.
    n_objects : int, optional
        Number of columns. Default: the largest number in `truth` and one.
    fold : array_like of shape (n,), optional
        The fold of each grasp. Default: `training_folds`, five.

    Returns
    -------
    ndarray of shape (n, n_objects), float64
        -inf where a fold's training has no grasp of an object, NaN in the rows without this source.

    Raises
    ------
    InputError
        If the arrays do not fit together or there is only one fold.
    """
    features = np.asarray(X, dtype=np.float64)
    if features.ndim != 2:
        raise InputError(f"X must have shape (n, n_features), got {features.shape}")
    n = len(features)
    most = np.asarray(truth)
    k = n_objects if n_objects is not None else int(most.max()) + 1 if most.size and most.dtype.kind in "iu" else 0
    numbers = checked_truth(truth, n, k)
    folds = training_folds(numbers) if fold is None else np.asarray(fold)
    if folds.shape != (n,):
        raise InputError(f"fold must be one number a grasp, shape ({n},), got {folds.shape}")
    if len(np.unique(folds)) < 2:
        raise InputError("held-out log-probabilities need at least two folds, got one")
    present = ~np.isnan(features).all(axis=1)
    said = np.full((n, k), np.nan)
    for f in np.unique(folds):
        train, test = present & (folds != f), present & (folds == f)
        if not test.any() or not train.any():
            continue
        fitted = copy.deepcopy(classifier).fit(features[train], numbers[train])
        probability = np.zeros((int(test.sum()), k))
        probability[:, fitted.classes_] = fitted.predict_proba(features[test])
        with np.errstate(divide="ignore"):
            said[test] = np.log(probability)
    return said
